"""Operator: what touches on the way from frame to frame, and crosses in a frame."""

import bpy

from .connection import connect
from .detect import OnObjects
from .modes import out_of_edit_mode
from .preferences import preferences
from .reports import Failed, conclude, errors_reported
from .search import Search

_TICK = 0.001  # seconds


class DetectContactsInRange(OnObjects, bpy.types.Operator):
    """Mark where the selected objects touch or cross in the frame range, also between two frames. Esc ends the search early"""

    bl_idname = "collided.detect_range"
    bl_label = "Detect Over Frame Range"

    def execute(self, context):
        """All at once, as scripts call it."""
        try:
            with out_of_edit_mode(context):
                self._begin(context)
                while self._step(context):
                    pass
                self._end(context)
        except Failed:
            return {"CANCELLED"}
        return {"FINISHED"}

    def invoke(self, context, _event):
        """A frame at a time, while the window lives."""
        if context.window is None:
            return self.execute(context)
        if context.mode.startswith("EDIT"):
            bpy.ops.object.mode_set(mode="OBJECT")
        try:
            self._begin(context)
        except Failed:
            return {"CANCELLED"}
        self._timer = context.window_manager.event_timer_add(_TICK, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        is_cancelled = event.type == "ESC"
        if event.type != "TIMER" and not is_cancelled:
            return {"RUNNING_MODAL"}
        try:
            if not is_cancelled and self._step(context):
                return {"RUNNING_MODAL"}
            self._end(context, is_cancelled)
        except Failed:
            return {"CANCELLED"}
        return {"FINISHED"}

    def cancel(self, context):
        """Blender itself ends it, as when a file is opened."""
        self._close(context)

    def _begin(self, context):
        scene = context.scene
        first, last = ((scene.frame_preview_start, scene.frame_preview_end) if scene.use_preview_range else
                       (scene.frame_start, scene.frame_end))
        self._frames = range(first, last + 1, scene.frame_step)
        self._before, self._timer, self._done = (scene.frame_current, scene.frame_subframe), None, 0
        with errors_reported(self):
            self._search = Search(context, connect(preferences(context)))
        self._steps = self._search.over(self._frames)
        context.window_manager.progress_begin(0, len(self._frames))

    def _step(self, context):
        """Goes on for a moment. Returns whether there is more to do; raises Failed."""
        try:
            with errors_reported(self):
                done = next(self._steps, None)
        except BaseException:
            self._close(context)
            raise
        if done is None:
            return False
        self._done = done
        context.window_manager.progress_update(self._done)
        if context.workspace is not None:
            context.workspace.status_text_set(f"Detecting contacts: {self._done} of {len(self._frames)} frames   Esc: Stop")
        return True

    def _end(self, context, is_cancelled=False):
        self._close(context)
        with errors_reported(self):
            conclude(self, self._search, True, f"stopped after {self._done} of {len(self._frames)} frames" if is_cancelled else "")

    def _close(self, context):
        self._search.close()
        context.window_manager.progress_end()
        if self._timer is not None:
            context.window_manager.event_timer_remove(self._timer)
        if context.workspace is not None:
            context.workspace.status_text_set(None)
        frame, subframe = self._before
        context.scene.frame_set(frame, subframe=subframe)
