"""Operator: what touches and crosses at the current frame."""

import bpy

from .connection import connect
from .modes import out_of_edit_mode
from .preferences import preferences
from .reports import Failed, conclude, errors_reported
from .search import Search, objects_to_test


class OnObjects:
    """What operators that need selected objects have in common."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        if objects_to_test(context):
            return True
        cls.poll_message_set("Select one or more meshes, curves or texts")
        return False


class DetectContacts(OnObjects, bpy.types.Operator):
    """Mark where the selected objects touch or cross at the current frame, each other and themselves"""

    bl_idname = "collided.detect"
    bl_label = "Detect Contacts"

    def execute(self, context):
        try:
            with out_of_edit_mode(context), errors_reported(self):
                with Search(context, connect(preferences(context))) as search:
                    search.in_frame()
                    conclude(self, search, by_frame=False)
        except Failed:
            return {"CANCELLED"}
        return {"FINISHED"}
