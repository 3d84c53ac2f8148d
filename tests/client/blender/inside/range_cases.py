"""From frame to frame: what meets between frames, changes its faces, comes and goes; and a search that ends early."""

import bpy
import numpy as np
from support import SERVER, Case, cube, drawn, lines, mesh, package, select, square, touched_vertices, values

RANGE = bpy.ops.collided.detect_range


def drop(name, heights, first=1):
    """A tip whose corner is at these heights, from frame to frame."""
    thing = mesh(name, [(0.3, 0.2, 0), (0.4, 0.2, 0.3), (0.3, 0.4, 0.3)], (), [(0, 1, 2)])
    for frame, height in enumerate(heights, first):
        thing.location.z = height
        thing.keyframe_insert("location", frame=frame)
    for curve in thing.animation_data.action.fcurves:
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
    return thing


class Range(Case):
    def markers(self):
        return {marker.frame: marker.name for marker in self.scene.timeline_markers}

    def test_what_passes_between_two_frames_is_found(self):
        tip, floor = drop("tip", [3, 2, 1, -1, -2]), square()
        select(tip, floor)
        self.scene.frame_end = 5
        self.scene.frame_set(2, subframe=0.5)
        RANGE()
        first = lines("collided contacts")
        self.assertEqual(self.markers().keys(), {4})
        self.assertEqual(set(values("collided contacts", "frame").reshape(-1)), {4})
        corner = np.argmin(values("collided contacts", "toi")[:, 0])
        np.testing.assert_allclose(first[corner], [(0.3, 0.2, 0)] * 2, atol=1e-6)
        self.assertAlmostEqual(values("collided contacts", "toi")[corner, 0], 0.5, places=5)
        self.assertEqual(self.settings.summary, f"{len(first)} contacts\nin 1 of 5 frames, first in 4")
        self.assertEqual((self.scene.frame_current, self.scene.frame_subframe), (2, 0.5))
        self.assertEqual(touched_vertices(tip), [0, 1, 2])
        self.assertEqual(drawn("collided contacts"), 0)
        self.scene.frame_set(4)
        self.assertGreater(drawn("collided contacts"), 0)

    def test_a_search_that_is_stopped_before_its_first_frame_marks_nothing(self):
        from collided_blender import connection, marks, preferences, search

        select(square())
        with search.Search(bpy.context, connection.connect(preferences.preferences(bpy.context))) as stopped:
            self.assertEqual(marks.mark(stopped, True), [])
        self.assertNotIn("collided contacts", bpy.data.objects)

    def test_crossings_of_each_frame(self):
        select(drop("tip", [3, -0.1, -0.1, 3]), square())
        self.scene.frame_end = 4
        for level in ("FAST", "EXACT"):
            self.settings.accuracy = level
            RANGE()
            self.assertEqual(set(values("collided crossings", "frame").reshape(-1)), {2, 3})
            self.assertEqual(self.markers().keys(), {2, 3, 4})
            self.assertNotIn("contact", self.markers()[3])

    def test_the_preview_range_and_its_step(self):
        select(drop("tip", [3, -3, 3, -3, 3, -3, 3]), square())
        self.scene.use_preview_range = True
        self.scene.frame_preview_start, self.scene.frame_preview_end, self.scene.frame_step = 3, 7, 2
        RANGE()
        self.assertEqual(self.settings.summary, "No contacts")
        self.scene.frame_step = 1
        RANGE()
        self.assertEqual(self.markers().keys(), {4, 5, 6, 7})

    def test_faces_that_change(self):
        """An array grows by one copy in frame 3, into the way of the tip, which falls onto it until frame 4."""
        tip, pile = drop("tip", [7, 6, 5, 2]), cube("pile", scale=(0.5, 0.5, 0.5))
        array = pile.modifiers.new("array", "ARRAY")
        array.relative_offset_displace = 0, 0, 3
        for frame, count in ((1, 1), (2, 1), (3, 2)):
            array.count = count
            array.keyframe_insert("count", frame=frame)
        select(tip, pile)
        self.scene.frame_end = 4
        RANGE()
        self.assertEqual(self.markers().keys(), {4})
        corner = np.argmin(values("collided contacts", "toi")[:, 0])
        np.testing.assert_allclose(lines("collided contacts")[corner], [(0.3, 0.2, 3.5)] * 2, atol=1e-5)
        self.assertAlmostEqual(values("collided contacts", "toi")[corner, 0], 0.5, places=5)
        self.assertEqual(touched_vertices(pile), [])

    def test_objects_that_come_and_go(self):
        tip, floor = drop("tip", [3, -3, 3, -3, 3, -3]), square()
        build = floor.modifiers.new("build", "BUILD")
        build.frame_start, build.frame_duration = 4, 1
        select(tip, floor)
        self.scene.frame_end = 6
        RANGE()
        self.assertEqual(self.markers().keys(), {6})

    def test_a_search_that_ends_early_leaves_nothing_on_the_daemon(self):
        from collided_blender.search import Search

        with package().Client(SERVER) as client:
            before = len(client.scenes())
            select(drop("tip", [3, 2]), square())
            with Search(bpy.context, package().Client(SERVER)) as search:
                steps = search.over(range(1, 100))
                while next(steps) == 0:
                    pass
                self.assertEqual(len(client.scenes()), before + 2)
            self.assertEqual(len(client.scenes()), before)
