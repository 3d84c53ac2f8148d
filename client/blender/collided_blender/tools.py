"""Operators on marks."""

import bpy
import numpy as np

from .marks import clear
from .marks.touched import touched_faces
from .modes import out_of_edit_mode


class SelectTouchedFaces(bpy.types.Operator):
    """Select the touched faces of the selected objects, in edit mode"""

    bl_idname = "collided.select_faces"
    bl_label = "Select Touched Faces"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return any(thing.type == "MESH" for thing in context.selected_objects)

    def execute(self, context):
        if context.mode.startswith("EDIT"):
            bpy.ops.object.mode_set(mode="OBJECT")
        things = [thing for thing in context.selected_objects if thing.type == "MESH" and not thing.data.library]
        touched = [thing for thing in things if touched_faces(thing.data).any()]
        if not touched:
            self.report({"WARNING"}, "No face of the selected objects is marked")
            return {"CANCELLED"}
        for mesh in {thing.data for thing in things}:
            _select(mesh, touched_faces(mesh))
        context.view_layer.objects.active = touched[0]
        context.tool_settings.mesh_select_mode = (False, False, True)
        bpy.ops.object.mode_set(mode="EDIT")
        return {"FINISHED"}


class ClearContacts(bpy.types.Operator):
    """Remove all marks of contacts from the scene"""

    bl_idname = "collided.clear"
    bl_label = "Clear"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        with out_of_edit_mode(context):
            clear(context.scene)
        context.scene.collided.summary = ""
        return {"FINISHED"}


def _select(mesh, faces):
    """Exactly these faces, with their edges and vertices."""
    counts, loops = np.empty(len(mesh.polygons), np.int32), np.empty((2, len(mesh.loops)), np.int32)
    mesh.polygons.foreach_get("loop_total", counts)
    for row, name in zip(loops, ("vertex_index", "edge_index")):
        mesh.loops.foreach_get(name, row)
    mesh.polygons.foreach_set("select", faces)
    is_selected = np.repeat(faces, counts)
    for row, elements in zip(loops, (mesh.vertices, mesh.edges)):
        values = np.zeros(len(elements), bool)
        values[row[is_selected]] = True
        elements.foreach_set("select", values)
