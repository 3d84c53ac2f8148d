#!/usr/bin/env python3
"""Advances per mesh and per vertex as the package has them: options, answers, and where a session knows its scene to be.

The daemon's answers are made here; tests/client/hostile sends some of them.

usage: advance_test.py DAEMON COLLIDECTL REPOSITORY
"""

import struct
import unittest

from support import FLOOR, ONE, TIP, main, np

import collided
from collided.contacts.answer import Answer
from collided.contacts.checks import check_done
from collided.frames.advance import read_advance
from collided.frames.options import frame_head
from collided.frames.track import Track
from collided.layout import Layout
from collided.options import SceneOptions
from collided.v1 import frame_pb2

PER_MESH, PER_VERTEX = frame_pb2.ADVANCE_MODE_PER_MESH, frame_pb2.ADVANCE_MODE_PER_VERTEX
PUSH = np.array([[0.3, -0.7, 1e-3], [1 / 3, 0.1, -2], [5, 1e-7, 0.9]])
PUSHED = np.eye(3, 4) + np.hstack([np.zeros((3, 3)), [[0.1], [-0.7], [1 / 3]]])


def ways(ids, fractions):
    return frame_pb2.ShortenedWays(ids=struct.pack(f"<{len(ids)}I", *ids), fractions=struct.pack(f"<{len(fractions)}d", *fractions))


def layout():
    """Vertices 0 to 2 are static, 3 to 5 deformable, 6 to 8 rigid, 9 to 11 deformable."""
    return Layout.of({"floor": collided.Mesh(FLOOR, ONE, motion="static"), "tip": (TIP, ONE),
                      "ball": collided.Mesh(TIP + np.float32([9, 0, 0]), ONE, motion="rigid"),
                      "cloth": (TIP - np.float32([9, 0, 0]), ONE)})


def along(x, p, fraction, dtype="<f4"):
    """The formula of client/STEPPING.md, a coordinate at a time."""
    def one(a, b):
        a, b = float(a), float(b)
        return np.dtype(dtype).type(b if fraction == 1 else a + fraction * (b - a) if fraction else a)
    return np.array([one(*pair) for pair in zip(np.ravel(x), np.ravel(p))], dtype)


class Options(unittest.TestCase):
    def test_every_way_to_say_it(self):
        for value, expected in ((None, (False, 0)), (False, (False, 0)), (True, (True, 0)), (np.True_, (True, 0)),
                                ("all_or_one", (True, 1)), ("per_mesh", (True, 2)), ("per-vertex", (True, 3)), ("PER_VERTEX", (True, 3))):
            head = frame_head({"advance": value})
            self.assertEqual((head.advance, head.advance_mode), expected, value)

    def test_what_it_cannot_be_is_refused_by_name(self):
        for bad in ("", "unspecified", "per_edge", 2, 0.5, PER_VERTEX, ["per_mesh"]):
            with self.assertRaises(collided.InvalidArgument) as caught:
                frame_head({"advance": bad})
            self.assertEqual((caught.exception.message, caught.exception.field),
                             (f"advance is {bad!r}; it must be True, False or one of all_or_one, per_mesh, per_vertex", "advance"))


class Answers(unittest.TestCase):
    def read(self, word, *messages, last=None):
        done = frame_pb2.FrameDone(advanced=0.25, way=0.75, **({} if last is None else {"shortened": last}))
        check_done(done)
        return read_advance(frame_head({"advance": word}), done, messages, layout())

    def test_messages_are_joined(self):
        for messages, last in (((), ways([3, 4, 9], [0.5, 0, 0.25])), ((ways([3], [0.5]), ways([4], [0])), ways([9], [0.25])),
                               ((ways([3, 4], [0.5, 0]), ways([9], [0.25])), None)):
            shortened = self.read("per_vertex", *messages, last=last).shortened
            self.assertEqual((shortened.ids.dtype, shortened.fractions.dtype), ("<u4", "<f8"))
            self.assertEqual((shortened.ids.tolist(), shortened.fractions.tolist()), ([3, 4, 9], [0.5, 0, 0.25]))
            self.assertEqual(shortened.of(4, 6).tolist(), [0, 1, 1, 1, 1, 0.25])

    def test_how_far_meshes_went(self):
        def contacts(advance):
            done = frame_pb2.FrameDone(advanced=0.25, way=0.75)
            return collided.Contacts.of_parts(Answer(1, 1, done, layout(), None, True, advance=advance), [])

        def fractions(*arguments, **options):
            return [contacts(self.read(*arguments, **options)).fractions(i).tolist() for i in range(4)]

        self.assertEqual(fractions("per_vertex", last=ways([3, 4, 6, 7, 8], [0.5, 0, 0.25, 0.25, 0.25])),
                         [[1, 1, 1], [0.5, 0, 1], [0.25] * 3, [1, 1, 1]])
        self.assertEqual(fractions("per_vertex", last=ways([7, 11], [0.25, 0.75])),  # rounding may leave vertices where they were
                         [[1, 1, 1], [1, 1, 1], [0.25] * 3, [1, 1, 0.75]])
        self.assertEqual(fractions("per_mesh", last=ways([1, 2], [0.5, 0.25])), [[1] * 3, [0.5] * 3, [0.25] * 3, [1] * 3])
        self.assertEqual(fractions(True), [[0.25] * 3] * 4)
        one = contacts(self.read("per_mesh", last=ways([1], [0.25])))
        self.assertEqual((one.advanced, one.way), (0.25, 0.75))
        self.assertEqual((one.shortened.ids.tolist(), one.vt.shortened.fractions.tolist()), ([1], [0.25]))
        self.assertEqual(contacts(None).shortened.ids.size, 0)
        with self.assertRaisesRegex(collided.FailedPrecondition, "sent without advance"):
            contacts(None).fractions("tip")

    def test_answers_that_cannot_be_are_refused(self):
        nan = float("nan")
        for messages, word, why in (
                ([ways([12], [0.5])], "per_vertex", "names 12; the frame has 12 vertices"),
                ([ways([4], [0.5])], "per_mesh", "names 4; the frame has 4 meshes"),
                ([ways([3], [0.5])], True, "names 3; the frame has 0"), ([ways([0], [0.5])], False, "names 0; the frame has 0"),
                ([ways([4, 3], [0, 0])], "per_vertex", "has 3 after 4"),
                ([ways([3], [0]), ways([3], [0])], "per_vertex", "has 3 after 3"),
                ([ways([3], [1.0])], "per_vertex", "not in"), ([ways([3], [-0.1])], "per_vertex", "not in"),
                ([ways([3], [nan])], "per_vertex", "not in"),
                ([ways([3], [])], "per_vertex", "4 bytes of ids and 0 of fractions"),
                ([ways([], [0])], "per_vertex", "0 bytes of ids and 8"),
                ([frame_pb2.ShortenedWays(ids=b"123", fractions=bytes(6))], "per_vertex", "3 bytes of ids and 6")):
            with self.subTest(why), self.assertRaisesRegex(collided.DataLoss, why):
                self.read(word, *messages[:-1], last=messages[-1])
        for bad in (-0.1, 1.5, nan):
            with self.assertRaisesRegex(collided.DataLoss, "done.way is .*0, 1"):
                check_done(frame_pb2.FrameDone(way=bad))


class Followed(unittest.TestCase):
    """Where a session knows its scene to be."""

    def track(self, **options):
        track = Track(layout(), SceneOptions(**options))
        self.step(track, {i: mesh.vertices for i, mesh in track.layout.present()}, True)
        return track

    def step(self, track, positions, is_first=False, shortened=(), **options):
        request = track.request(track.layout, is_first, positions, None, options)
        done = frame_pb2.FrameDone(advanced=0.25, shortened=ways(*shortened) if shortened else None)
        track.apply(request, read_advance(request.head, done, (), track.layout_of(request)), 1)

    def expect(self, track, where):
        """where: how far each vertex of each mesh went."""
        targets = {"floor": FLOOR, "tip": TIP + PUSH, "ball": TIP + [9, 0, 0], "cloth": TIP - [9, 0, 0] + PUSH}
        for (i, mesh), fractions in zip(track.layout.present(), where):
            has = track.state[i].real(track.form)
            if mesh.is_rigid:
                moved = PUSHED.copy()
                moved[:, 3] = along(np.zeros(3), PUSHED[:, 3], fractions[0], "<f8")
                np.testing.assert_array_equal(track.state[i].pose, moved)
                continue
            targets_there = np.asarray(targets[mesh.name], has.dtype)
            expected = [along(x, p, a, has.dtype) for x, p, a in zip(mesh.vertices, targets_there, fractions)]
            np.testing.assert_array_equal(has, expected, f"{mesh.name}, {fractions}")

    def test_it_is_where_each_vertex_or_mesh_went(self):
        target = {"tip": TIP + PUSH, "cloth": TIP - [9, 0, 0] + PUSH, "ball": collided.Rigid(PUSHED)}
        still = [1, 1, 1]
        for word, shortened, where in (
                ("per_vertex", ([3, 5, 6, 7, 8, 9, 10], [1 / 3, 0, 0.7, 0.7, 0.7, 127 / 128, 1e-300]),
                 (still, [1 / 3, 1, 0], [0.7] * 3, [127 / 128, 1e-300, 1])),
                ("per_vertex", ([3, 4, 5], [0, 0, 0]), (still, [0] * 3, still, still)),
                ("per_vertex", ([7], [0.4]), (still, still, [0.4] * 3, still)),
                ("per_vertex", None, (still,) * 4),
                ("per_mesh", ([1, 2], [1 / 3, 0.9]), (still, [1 / 3] * 3, [0.9] * 3, still)),
                ("per_mesh", ([2, 3], [0, 0]), (still, still, [0] * 3, [0] * 3)),
                ("all_or_one", None, (still, [0.25] * 3, [0.25] * 3, [0.25] * 3))):
            for form in ("f32", "f64"):
                with self.subTest(word=word, shortened=shortened, form=form):
                    track = self.track(position_format=form)
                    self.step(track, target, shortened=shortened, advance=word)
                    self.expect(track, where)

    def test_a_new_scene_is_put_there(self):
        track = self.track()
        p = (TIP + PUSH).astype("<f4")
        self.step(track, {"tip": p, "ball": collided.Rigid(PUSHED)}, shortened=([4, 6, 7, 8], [0.5] + [0.25] * 3), advance="per_vertex")
        *_, replay = track.replaying()
        tip, ball = sorted(replay.updates, key=lambda update: update.mesh)
        np.testing.assert_array_equal(tip.positions, track.state[1].positions)
        np.testing.assert_array_equal(tip.positions[1], along(TIP[1], p[1], 0.5))
        np.testing.assert_array_equal(ball.pose[:, 3], along(np.zeros(3), PUSHED[:, 3], 0.25, "<f8"))
        self.assertFalse(replay.head.advance)

    def test_the_next_frame_may_begin_on_the_way_that_was_gone(self):
        track = self.track()
        p = (TIP + PUSH).astype("<f4")
        self.step(track, {"tip": p}, shortened=([3, 4], [0.5, 0]), advance="per_vertex")
        gone = track.state[1].positions
        self.step(track, {}, from_last_fraction=0.375)
        np.testing.assert_array_equal(track.way.start[1].positions, [along(x, g, 0.375) for x, g in zip(TIP, gone)])

    def test_positions_of_q16_stay_on_its_steps_where_they_did_not_go_part_of_the_way(self):
        box = collided.Box((-20, -20, -20), (20, 20, 20))
        for shortened, dtype in ((([1], [0]), "<u2"), (None, "<u2"), (([1], [0.5]), "<f4")):
            track = self.track(position_format="q16", quantization_box=box)
            before, target = track.state[1].positions, TIP + np.float32([0, 0, 1])
            self.step(track, {"tip": target}, shortened=shortened, advance="per_mesh")
            self.assertEqual(track.state[1].positions.dtype, np.dtype(dtype))
            if shortened and dtype == "<u2":
                np.testing.assert_array_equal(track.state[1].positions, before)


if __name__ == "__main__":
    main()
