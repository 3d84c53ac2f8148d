"""Edit mode keeps an object's mesh to itself: it is left while that is read and marked, and entered again."""

import contextlib

import bpy


@contextlib.contextmanager
def out_of_edit_mode(context):
    is_editing = context.mode.startswith("EDIT")
    if is_editing:
        bpy.ops.object.mode_set(mode="OBJECT")
    try:
        yield
    finally:
        if is_editing:
            bpy.ops.object.mode_set(mode="EDIT")
