"""The add-on in a window: the panel is drawn, the search of a frame range can be watched, ends, is stopped by Esc and
undone.

Goes on from step to step by a timer, between which Blender handles events.
"""

import faulthandler
import os
import pathlib
import sys
import traceback

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import bpy  # noqa: E402
import support  # noqa: E402
from range_cases import drop  # noqa: E402

FRAMES = 400
drawn = []


def show_panel():
    """In the tab that is open in a new window; notes each time that it is drawn."""
    from collided_blender.panel import ContactsPanel as panel

    draw = panel.draw

    def noted(self, context):
        draw(self, context)
        drawn.append(context.scene.collided.summary)

    bpy.utils.unregister_class(panel)
    panel.bl_category = "Item"
    panel.draw = noted
    bpy.utils.register_class(panel)
    view().spaces.active.show_region_ui = True


def view():
    return next(area for area in bpy.context.window_manager.windows[0].screen.areas if area.type == "VIEW_3D")


def start(operator):
    """As its button does."""
    window, area = bpy.context.window_manager.windows[0], view()
    region = next(region for region in area.regions if region.type == "WINDOW")
    with bpy.context.temp_override(window=window, area=area, region=region):
        return operator("INVOKE_DEFAULT")


def expect(condition, what):
    if not condition:
        raise AssertionError(what)


def steps():
    """Yields where Blender has to handle events; True to be asked again until something has happened."""
    bpy.ops.wm.read_homefile(use_empty=True)
    yield
    support.preferences().server = support.SERVER
    scene = bpy.context.scene
    support.select(drop("tip", [3, -3]), support.square())
    scene.frame_end = FRAMES
    show_panel()
    while not drawn:
        yield
    expect(start(bpy.ops.collided.detect_range) == {"RUNNING_MODAL"}, "the search does not run beside the window")
    while scene.frame_current < 5:
        yield
    bpy.context.window_manager.windows[0].event_simulate(type="ESC", value="PRESS", x=300, y=300)
    while not scene.collided.summary:
        yield
    expect(f" of {FRAMES} frames" in scene.collided.summary and "stopped after" in scene.collided.summary, scene.collided.summary)
    expect([marker.frame for marker in scene.timeline_markers] == [2], "what was found until then is not marked")
    expect(scene.frame_current == 1, "the frame is another one than before")
    scene.frame_end = 4
    start(bpy.ops.collided.detect_range)
    while "stopped" in scene.collided.summary:
        yield
    expect(scene.collided.summary.endswith("in 1 of 4 frames, first in 2"), scene.collided.summary)
    while drawn[-1] != scene.collided.summary:
        yield
    start(bpy.ops.ed.undo)
    yield
    expect("stopped after" in bpy.context.scene.collided.summary, "undo does not bring the earlier marks back")
    bpy.context.scene.frame_set(2)
    expect(support.drawn("collided contacts") > 0, "marks that undo has brought back show nothing")
    start(bpy.ops.ed.undo)
    yield
    expect("collided contacts" not in bpy.data.objects, "undo leaves marks")


def go_on(walk):
    try:
        next(walk)
        return 0.01
    except StopIteration:
        print("window: OK", flush=True)
        os._exit(0)
    except BaseException:
        traceback.print_exc()
        sys.stderr.flush()
        os._exit(1)


faulthandler.dump_traceback_later(150, exit=True)
support.install()
walk = steps()
bpy.app.timers.register(lambda: go_on(walk), first_interval=0.1, persistent=True)
