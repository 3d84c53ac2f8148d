#!/usr/bin/env python3
"""The formulas by which a client has the daemon's bits, against those of the C++ client.

usage: positions_test.py DAEMON COLLIDECTL REPOSITORY POSITIONS_BITS
"""

import subprocess
import sys
import unittest

from support import main, np, turned

import collided
from collided.positions import FORMATS, format_named, format_row
from collided.v1 import scene_pb2

PROGRAM = sys.argv[4]
DTYPES = {"f32": "<f4", "f64": "<f8"}


def in_cpp(words, *arrays, dtype="<f8"):
    given = b"".join(np.ascontiguousarray(array, "<f8").tobytes() for array in arrays)
    done = subprocess.run([PROGRAM, *words], input=given, capture_output=True, check=True)
    return np.frombuffer(done.stdout, dtype).reshape(-1, 3)


def random_positions(dtype, count=2000):
    """Of all sizes."""
    random = np.random.default_rng(7)
    return (random.standard_normal((count, 3)) * 10.0 ** random.integers(-6, 7, (count, 3))).astype(dtype)


class Formats(unittest.TestCase):
    def test_each_of_the_protocol_has_a_row(self):
        values = {name.removeprefix("POSITION_FORMAT_").lower(): number
                  for name, number in scene_pb2.PositionFormat.items() if number}
        self.assertEqual(list(FORMATS), list(values))
        box = collided.Box((0, 0, 0), (1, 1, 1))
        for name, row in FORMATS.items():
            self.assertIs(format_row(values[name]), row)
            self.assertEqual(format_named(name, box if row.has_box else None).number, values[name])
            with self.assertRaisesRegex(collided.InvalidArgument, "'q16' and a box go together"):
                format_named(name, None if row.has_box else box)


class SameBits(unittest.TestCase):
    def test_the_way_of_an_advance(self):
        for name, dtype in DTYPES.items():
            x, p = random_positions(dtype), random_positions(dtype)[::-1]
            for fraction in (0.0, 1.0, 0.5, 1 / 3, 0.9999999999, 1e-300, 127 / 128):
                ours = collided.move_along(x, p, fraction)
                self.assertEqual(ours.dtype, np.dtype(dtype))
                expected = in_cpp([name, "along", repr(fraction)], x, p)
                np.testing.assert_array_equal(ours.astype("<f8"), expected, f"{name}, {fraction}")

    def test_the_ways_of_an_advance_per_vertex(self):
        fractions = (0.0, 1.0, 0.5, 1 / 3, 0.9999999999, 1e-300, 127 / 128)
        for name, dtype in DTYPES.items():
            x, p = random_positions(dtype), random_positions(dtype)[::-1]
            each = np.random.default_rng(11).integers(0, len(fractions), len(x))
            ours = collided.move_along(x, p, np.array(fractions)[each])
            self.assertEqual(ours.dtype, np.dtype(dtype))
            for i, fraction in enumerate(fractions):
                expected = in_cpp([name, "along", repr(fraction)], x, p)
                np.testing.assert_array_equal(ours.astype("<f8")[each == i], expected[each == i], f"{name}, {fraction}")

    def test_a_rigid_meshs_pose(self):
        angle = 0.7
        turn = [[np.cos(angle), -np.sin(angle), 0, 1e-3], [np.sin(angle), np.cos(angle), 0, -7], [0, 0, 1, 1e5]]
        for name, dtype in DTYPES.items():
            x = random_positions(dtype)
            np.testing.assert_array_equal(collided.move_rigidly(x, turn).astype("<f8"),
                                          in_cpp([name, "rigid"], turn, x))

    def test_the_pose_of_an_advance(self):
        random = np.random.default_rng(5)
        for angle in (0, 1e-12, 1e-4, 0.3, 0.9, 2, 3):
            start, by = (turned(random.standard_normal(3), each, random.standard_normal(3) * 10.0 ** random.integers(-6, 7, 3))
                         for each in (random.uniform(-3, 3), angle))
            target = np.hstack([by[:, :3] @ start[:, :3], by[:, 3:]])
            for fraction in (0.0, 1.0, 0.5, 1 / 3, 0.9999999999, 1e-300, 127 / 128):
                ours = collided.pose_along(start, np.vstack([target, [0, 0, 0, 1]]), fraction)
                self.assertEqual((ours.shape, ours.dtype, ours.flags.c_contiguous), ((3, 4), np.dtype("<f8"), True))
                expected = in_cpp(["f64", "pose", repr(fraction)], start, target)
                self.assertEqual(ours.tobytes(), expected.tobytes(), f"{angle}, {fraction}")

    def test_the_pose_of_a_mesh_that_does_not_turn_is_that_of_its_translation(self):
        random = np.random.default_rng(17)
        rotation = turned((3, -1, 2), 0.7)[:, :3]
        start, target = (np.hstack([rotation, random.standard_normal((3, 1))]) for _ in range(2))
        for fraction in (0.0, 1.0, 0.5, 1 / 3, 127 / 128):
            pose = collided.pose_along(start, target, fraction)
            np.testing.assert_array_equal(pose[:, :3], rotation)
            np.testing.assert_array_equal(pose[:, 3], collided.move_along(start[:, 3], target[:, 3], fraction))

    def test_encoded_positions(self):
        random = np.random.default_rng(3)
        lower, upper = (-3.0, 1.0, 2.5), (5.0, 1.0, 2.75)
        box = collided.Box(lower, upper)
        inside = random.uniform(lower, upper, (5000, 3))
        # The ends, and where a coordinate is as near to one step as to the next.
        between = np.add(lower, (np.arange(64)[:, None] * 1000 + 0.5) * box.step)
        positions = np.concatenate([inside, np.minimum(between, upper), [lower, upper]])
        ours = collided.pack_quantized(positions, box)
        np.testing.assert_array_equal(ours, in_cpp(["f64", "q16"], lower, upper, positions, dtype="<u2"))
        np.testing.assert_allclose(collided.unpack_quantized(ours, box), positions, atol=float(box.step.max()))

    def test_what_cannot_be_encoded_is_refused_by_name(self):
        box = collided.Box((0, 0, 0), (1, 1, 1))
        for bad in (1.5, -0.25, np.nan, np.inf):
            with self.assertRaisesRegex(collided.InvalidArgument, rf"positions\[1\].y is .*{bad}.*outside the box, .*0.0.* to .*1.0"):
                collided.pack_quantized([[0, 0, 0], [0, bad, 0]], box)
        for lower, upper in (((0, 0), (1, 1)), ((0, 0, 2), (1, 1, 1)), ((0, 0, 0), (1, np.inf, 1))):
            with self.assertRaises(collided.InvalidArgument):
                collided.Box(lower, upper)

    def test_fractions_and_shapes_that_cannot_be_are_refused(self):
        x = np.zeros((2, 3))
        for bad in (-0.1, 1.5, np.nan):
            with self.assertRaisesRegex(ValueError, "fraction is"):
                collided.move_along(x, x, bad)
        for bad in (-0.1, 1.5, np.nan):
            with self.assertRaisesRegex(ValueError, r"fraction\[1\] is .*; it must be from 0 to 1"):
                collided.move_along(x, x, [0.5, bad])
        for bad in ([0.5], [0.5] * 3, [[0.5, 0.5]], [[0.5], [0.5]]):
            with self.assertRaisesRegex(ValueError, r"fraction has shape .*; it must be one number, or \(2,\)"):
                collided.move_along(x, x, bad)
        with self.assertRaisesRegex(ValueError, "target has shape"):
            collided.move_along(x, x[:1], 0.5)
        with self.assertRaisesRegex(ValueError, r"transform has shape \(2, 2\)"):
            collided.move_rigidly(x, np.eye(2))

    def test_poses_that_have_no_way_between_them_are_refused(self):
        here, half = np.eye(3, 4), np.diag([-1.0, -1, 1, 1])
        for bad in (-0.1, 1.5, np.nan):
            with self.assertRaisesRegex(collided.InvalidArgument, "fraction is .*; it must be from 0 to 1"):
                collided.pose_along(here, here, bad)
        for bad in ([0.5], [0.5, 0.5], [[0.5]]):
            with self.assertRaisesRegex(collided.InvalidArgument, r"fraction has shape .*; it must be one number$"):
                collided.pose_along(here, here, bad)
        for name, poses in (("start", (np.eye(2), here)), ("target", (here, np.eye(2)))):
            with self.assertRaisesRegex(collided.InvalidArgument, rf"{name} has shape \(2, 2\)"):
                collided.pose_along(*poses, 0.5)
        for bad in (half, np.where(here == 1, np.nan, 0), np.where(here == 1, np.inf, 0)):
            with self.assertRaisesRegex(collided.InvalidArgument, "half a turn from that of start") as caught:
                collided.pose_along(here, bad, 0.5)
            self.assertEqual(caught.exception.field, "target")
        np.testing.assert_array_equal(collided.pose_along(here, half, 1), half[:3])
        np.testing.assert_array_equal(collided.pose_along(half, here, 0), half[:3])


if __name__ == "__main__":
    main()
