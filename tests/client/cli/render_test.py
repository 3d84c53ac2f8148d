"""collidectl render: what a picture shows, and where.

Usage: render_test.py COLLIDECTL DAEMON"""

import json
import os
import signal
import subprocess
import time

import numpy as np
from PIL import Image

import support
from support import COLLIDECTL, DAEMON, FRAME0, FRAME1, ONE_CPU

# Which of a pixel's channels stand out in the marks.
VERMILION, BLUE, PURPLE = (2, 0, -2), (-2, 0, 2), (1, -3, 1)
PAPER = (247, 247, 250)
FROM_ABOVE = ["--azimuth", "0", "--elevation", "90"]
SMALL = ["--width", "320", "--height", "240"]
EDGES = "v 0 0 {z}\nv 4 0 {z}\nv 1 -1 0\nv 1 3 0\nl 1 2\nl 3 4\n"


def pixels_of(file):
    with Image.open(file) as picture:
        return np.array(picture)


def marked(picture, channels):
    """Rows and columns of the pixels of a mark's colour."""
    strength = picture.astype(int) @ np.array(channels)
    return np.argwhere(strength > 180)


def shown(picture):
    """Rows and columns of all pixels that are not paper."""
    return np.argwhere(np.abs(picture.astype(int) - PAPER).max(axis=2) > 8)


class Render(support.CollidectlTest):
    def drawn(self, *words, size=SMALL):
        out = os.path.join(self.folder.name, "picture.png")
        report = json.loads(self.ok("render", *words, *size, *ONE_CPU, "--out", out, "--json", DISPLAY=""))
        self.assertEqual([frame["out"] for frame in report["per_frame"]], [out])
        return pixels_of(out), report["per_frame"][0]

    def test_a_ball_marks_where_a_vertex_meets_a_triangle(self):
        picture, frame = self.drawn("--frames", self.frame0, self.frame1, *FROM_ABOVE)
        self.assertEqual(picture.shape, (240, 320, 3))
        self.assertEqual(frame["counts"]["contacts_vertex_triangle"], 1)
        ball = marked(picture, VERMILION)
        self.assertGreater(len(ball), 50)
        self.assertEqual(len(marked(picture, BLUE)), 0)
        self.assertEqual(len(marked(picture, PURPLE)), 0)
        # From above, the triangle from (0, 0) to (4, 4) fills the picture, and the contact is at (1, 1), in its plane.
        pixels = shown(picture)
        (top, left), (bottom, right) = pixels.min(axis=0), pixels.max(axis=0)
        row, column = (ball.min(axis=0) + ball.max(axis=0)) / 2
        self.assertAlmostEqual(column, left + (right - left) / 4, delta=2)
        self.assertAlmostEqual(row, bottom - (bottom - top) / 4, delta=2)

    def test_a_cross_marks_where_edges_meet(self):
        frames = [self.put(f"edges{z}.obj", EDGES.format(z=z)) for z in (1, -1)]
        picture, frame = self.drawn("--frames", *frames, *FROM_ABOVE)
        self.assertEqual(frame["counts"]["contacts_edge_edge"], 1)
        cross = marked(picture, BLUE)
        self.assertGreater(len(cross), 50)
        self.assertEqual(len(marked(picture, VERMILION)), 0)
        # Its arms go along the edges: what they cover of their box is far less than a ball would.
        (top, left), (bottom, right) = cross.min(axis=0), cross.max(axis=0)
        self.assertLess(len(cross), 0.7 * (bottom - top + 1) * (right - left + 1))

    def test_lines_mark_where_triangles_cross(self):
        picture, frame = self.drawn("--frames", self.frame0, self.frame1, "--crossings")
        self.assertEqual(frame["crossing_count"], 2)
        self.assertGreater(len(marked(picture, PURPLE)), 20)
        alone = [self.drawn(*words, self.frame0)[1] for words in ([], ["--frames"])]
        self.assertEqual(*({key: frame[key] for key in ("frame", "out", "counts")} for frame in alone))
        picture, frame = self.drawn(self.frame0, "--mode", "dcd", "--crossings")
        self.assertEqual((frame["crossing_count"], len(marked(picture, PURPLE))), (0, 0))
        for kind, count in ("tt", 1), ("et", 2):
            picture, frame = self.drawn(self.frame1, "--mode", "dcd", "--kinds", kind, "--accuracy", "exact")
            self.assertEqual(frame["contact_count"], count)
            self.assertGreater(len(marked(picture, PURPLE)), 20)

    def test_contours_of_neighbours_begin_at_their_corner(self):
        folded = self.put("folded.obj", "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 2 1 -1\nv 2 1.5 2\nf 1 2 3\nf 1 4 5\n")
        picture, frame = self.drawn(folded, "--crossings", "--kinds", "vt,ee", *FROM_ABOVE)
        self.assertEqual((frame["crossing_count"], frame["contact_count"]), (1, 0))
        line = marked(picture, PURPLE)
        # From above, the triangle from (0, 0) to (4, 4) fills the picture; the line goes from (0, 0) to (2, 7/6).
        (top, left), (bottom, right) = shown(picture).min(axis=0), shown(picture).max(axis=0)
        unit = (right - left) / 4
        self.assertAlmostEqual(line[:, 1].max() - line[:, 1].min(), 2 * unit, delta=8)
        self.assertAlmostEqual(line[:, 0].max() - line[:, 0].min(), 7 / 6 * unit, delta=8)
        self.assertAlmostEqual(line[:, 1].min(), left, delta=5)
        self.assertAlmostEqual(line[:, 0].max(), bottom, delta=5)

    def test_crossings_are_those_at_the_time_that_is_drawn(self):
        counts = [self.drawn("--frames", self.frame0, self.frame1, "--crossings", "--time", time)[1]["crossing_count"]
                  for time in ("0", "0.25", "0.75")]
        self.assertEqual(counts, [0, 0, 2])

    def test_marks_behind_a_surface_shine_through_it(self):
        roof = "v -1 -1 5\nv 9 -1 5\nv -1 9 5\nf 7 8 9\n"
        frames = [self.put(name, text + roof) for name, text in (("a.obj", FRAME0), ("b.obj", FRAME1))]
        picture = self.drawn("--frames", *frames, *FROM_ABOVE)[0]
        self.assertEqual(len(marked(picture, VERMILION)), 0)
        redness = picture.astype(int) @ np.array(VERMILION)
        roof = np.median(redness[tuple(shown(picture).T)])
        self.assertGreater((redness > roof + 30).sum(), 50)

    def test_the_same_input_gives_the_same_bytes_wherever_the_scene_is(self):
        first, again = (self.drawn("--frames", self.frame0, self.frame1)[0] for _ in range(2))
        np.testing.assert_array_equal(first, again)
        moved = []
        for name, text in (("a.ply", FRAME0), ("b.ply", FRAME1)):
            rows = [[float(x) for x in line.split()[1:]] for line in text.splitlines() if line.startswith("v")]
            vertices = "".join(f"{x + 2**30} {y - 2**30} {z + 2**30}\n" for x, y, z in rows)
            moved.append(self.put(name, "ply\nformat ascii 1.0\nelement vertex 6\nproperty double x\nproperty double y\n"
                                  "property double z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n"
                                  f"{vertices}3 0 1 2\n3 3 4 5\n"))
        far, _ = self.drawn("--frames", *moved)
        self.assertLess(np.abs(first.astype(int) - far).mean(), 0.5)

    def test_zooming_shows_the_surroundings_of_the_contacts(self):
        zoomed, _ = self.drawn("--frames", self.frame0, self.frame1, "--zoom-contacts", *FROM_ABOVE)
        corners = zoomed[[0, 0, -1, -1], [0, -1, 0, -1]].astype(int)
        self.assertGreater(np.abs(corners - PAPER).max(axis=1).min(), 20, "the triangle is seen even in the corners")
        self.assertGreater(len(marked(zoomed, VERMILION)), 50)
        apart, frame = self.drawn("--frames", self.frame0, self.frame0, "--zoom-contacts")
        self.assertEqual(frame["contact_count"], 0)
        np.testing.assert_array_equal(apart, self.drawn("--frames", self.frame0, self.frame0)[0])

    def test_a_sequence_has_a_picture_for_each_step(self):
        third = self.put("c.obj", FRAME0)
        pattern = os.path.join(self.folder.name, "{frame}.png")
        words = ["render", "--frames", third, self.frame1, self.frame0, *SMALL, *ONE_CPU]
        lines = self.ok(*words, "--out", pattern).splitlines()
        self.assertEqual([line.partition(": ")[0] for line in lines], [pattern.format(frame=n) for n in ("0001", "0002")])
        self.assertRegex(lines[0], r": [1-9]\d* contacts \(1 vt")
        self.assertEqual([pixels_of(pattern.format(frame=n)).shape for n in ("0001", "0002")], [(240, 320, 3)] * 2)
        self.refused(2, "2 pictures need {frame} in the name", *words, "--out", "x.png")
        scene = ["render", "--scene", "one_cell", "--mode", "dcd", *SMALL, *ONE_CPU, "--json"]
        self.assertEqual(len(json.loads(self.ok(*scene, "--frames", "3", "--out", pattern))["per_frame"]), 3)
        self.assertEqual(len(json.loads(self.ok(*scene, "--out", pattern))["per_frame"]), 1)

    def test_several_meshes_are_drawn_as_they_stand(self):
        corner = self.put("corner.obj", "v 0.5 0.5 -1\nv 1 0.5 1\nv 0.5 1 1\nf 1 2 3\n")  # goes through the triangle
        floor = self.put("floor.obj", "v 0 0 0\nv 4 0 0\nv 0 4 0\nf 1 2 3\n")
        picture, frame = self.drawn(floor, corner)
        self.assertEqual(frame["crossing_count"], 2)
        self.assertGreater(len(marked(picture, PURPLE)), 0)

    def test_an_interrupt_tells_the_pictures_so_far(self):
        pattern = os.path.join(self.folder.name, "{frame}.png")
        words = ["render", "--scene", "one_cell", "--mode", "dcd", "--frames", "100000", "--dt", "0", *SMALL, *ONE_CPU]
        env = {**os.environ, "COLLIDED_DAEMON": DAEMON}
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
        with subprocess.Popen([COLLIDECTL, *words, "--out", pattern, "--json"], env=env, **pipes) as process:
            while process.poll() is None and not os.path.exists(pattern.format(frame="0003")):
                time.sleep(0.01)
            process.send_signal(signal.SIGINT)
            printed, errors = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 128 + signal.SIGINT, errors)
        self.assertGreaterEqual(len(json.loads(printed)["per_frame"]), 2)

    def test_standard_output_takes_a_picture(self):
        words = [COLLIDECTL, "render", "--frames", self.frame0, self.frame1, *SMALL, *ONE_CPU, "--out", "-"]
        done = subprocess.run(words, capture_output=True, env={**os.environ, "COLLIDED_DAEMON": DAEMON}, timeout=240)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue(done.stdout.startswith(b"\x89PNG"))
        self.assertTrue(done.stdout.endswith(b"IEND\xaeB`\x82"))
        self.assertRegex(done.stderr.decode(), "^1 contacts")

    def test_what_cannot_be_drawn_is_refused(self):
        frames = [self.frame0, self.frame1]
        self.refused(2, "one of MESH..., --frames and --scene", "render")
        self.refused(2, "one of MESH..., --frames and --scene", "render", *frames, "--scene", "funnel")
        self.refused(2, "--frames with --scene needs one number from 1 to 1000000", "render", "--frames", *frames, "--scene", "funnel")
        self.refused(2, "--accuracy candidates has none", "render", "--frames", *frames, "--accuracy", "candidates")
        self.refused(2, "--report any tells only", "render", "--frames", *frames, "--report", "any")
        self.refused(2, "--time needs --mode ccd", "render", self.frame0, "--mode", "dcd", "--time", "0.5")
        for option, value in (("--width", "0"), ("--height", "100000"), ("--azimuth", "nan"), ("--elevation", "91"),
                              ("--time", "-1"), ("--up", "x")):
            self.refused(2, option, "render", "--frames", *frames, option, value)
        huge = [self.put(name, text.replace("v 4 0 0", "v 1e300 0 0")) for name, text in (("0.obj", FRAME0), ("1.obj", FRAME1))]
        for more in ([], ["--zoom-contacts"]):
            self.refused(1, "too large for a picture", "render", "--frames", *huge, *SMALL, *ONE_CPU, *more, "--out", "x.png")
        self.refused(2, "--json and --out -", "render", "--frames", *frames, "--json", "--out", "-")
        self.refused(1, "Is a directory", "render", "--frames", *frames, "--out", self.folder.name, COLLIDED_DAEMON="/nonexistent")
        self.refused(1, "/dev/full: cannot be written: No space", "render", "--frames", *frames, *SMALL, *ONE_CPU, "--out", "/dev/full")


if __name__ == "__main__":
    support.main()
