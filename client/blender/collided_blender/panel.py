"""The panel in the sidebar of the 3D view."""

import bpy

from . import detect, detect_range, tools
from .preferences import preferences


class ContactsPanel(bpy.types.Panel):
    bl_idname = "VIEW3D_PT_collided"
    bl_label = "Contacts"
    bl_category = "Contacts"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"

    def draw(self, context):
        settings = context.scene.collided
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        column = layout.column()
        column.prop(preferences(context), "server")
        column.prop(settings, "accuracy")
        column.prop(settings, "distance")
        column.prop(settings, "self_contacts")
        rings = column.column()
        rings.active = settings.self_contacts and settings.distance > 0
        rings.prop(settings, "skip_rings")
        column = layout.column(align=True)
        column.operator(detect.DetectContacts.bl_idname, icon="PIVOT_BOUNDBOX")
        column.operator(detect_range.DetectContactsInRange.bl_idname, icon="PREVIEW_RANGE")
        column = layout.column(align=True)
        column.operator(tools.SelectTouchedFaces.bl_idname, icon="RESTRICT_SELECT_OFF")
        column.operator(tools.ClearContacts.bl_idname, icon="X")
        column = layout.column(align=True)
        for line in settings.summary.splitlines():
            column.label(text=line)
