"""Blender add-on that marks contacts and crossings of the selected objects, found by the daemon `collided`."""

bl_info = {
    "name": "collided: contacts of meshes",
    "description": "Marks where the selected objects touch or cross, in a frame or between frames",
    "author": "collided",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "3D View > Sidebar > Contacts",
    "category": "Mesh",
}

import bpy  # noqa: E402

from . import connection, detect, detect_range, panel, preferences, settings, tools  # noqa: E402

_CLASSES = (preferences.Preferences, settings.Settings, detect.DetectContacts, detect_range.DetectContactsInRange,
            tools.SelectTouchedFaces, tools.ClearContacts, panel.ContactsPanel)


def register():
    if bpy.app.version >= (4, 0, 0):  # node groups have other sockets there
        raise RuntimeError(f"the add-on collided is for Blender 3.4 to 3.6; this is {bpy.app.version_string}")
    for kind in _CLASSES:
        bpy.utils.register_class(kind)
    bpy.types.Scene.collided = bpy.props.PointerProperty(type=settings.Settings)


def unregister():
    connection.stop_daemons()
    del bpy.types.Scene.collided
    for kind in reversed(_CLASSES):
        bpy.utils.unregister_class(kind)
