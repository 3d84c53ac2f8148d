"""collidectl stream over mesh files of one's own.

Usage: frames_test.py COLLIDECTL DAEMON"""

import json
import os
import re

import support
from support import FRAME0, FRAME1, ONE_CPU


class Frames(support.CollidectlTest):
    def setUp(self):
        super().setUp()
        fall = [FRAME0, FRAME1, FRAME1]
        self.files = [self.put(f"frame{number}.obj", text) for number, text in zip((1, 2, 10), fall)]

    def test_frames_are_played_in_natural_order_a_line_each(self):
        lines = self.ok("stream", *reversed(self.files), *ONE_CPU).splitlines()
        for number, (line, file) in enumerate(zip(lines, self.files), 1):
            self.assertRegex(line, rf"^frame {number} of 3, {re.escape(file)}: \d+ contacts \(\d+ vt, \d+ ee, 0 tt\), "
                                   r"earliest \S+, \S+ ms$")
        self.assertRegex(lines[1], r": [1-9]\d* contacts \(1 vt")
        self.assertTrue(lines[3].startswith("name"), lines[3])

    def test_a_stream_finds_what_detect_finds(self):
        step = json.loads(self.ok("detect", *self.files[:2], *ONE_CPU, "--json"))
        played = json.loads(self.ok("stream", *self.files, *ONE_CPU, "--json"))
        frames = played["per_frame"]
        self.assertEqual([(frame["frame"], frame["file"]) for frame in frames], list(enumerate(self.files, 1)))
        self.assertEqual([frame["contact_count"] for frame in frames], [0, step["contact_count"], frames[2]["contact_count"]])
        self.assertEqual(frames[1]["earliest_toi"], step["earliest_toi"])
        self.assertEqual(list(frames[1]["counts"]), list(step["counts"]))
        self.assertEqual(sum(frame["contact_count"] for frame in frames), played["contact_count"])

    def test_positions_are_not_rounded(self):
        formats = ["scene", "position_format"]
        third = self.put("frame3.obj", FRAME1.replace("1 1 -1", "1 1 -1.1"))
        for more, expected in (([], "f32"), ([third], "f64"), ([third, "--position-format", "q16"], "q16")):
            played = json.loads(self.ok("stream", *self.files, *more, *ONE_CPU, "--json"))
            self.assertEqual(played[formats[0]][formats[1]], expected)
        played = json.loads(self.ok("stream", "--scene", "funnel", "--scale", "0.2", "--frames", "1", *ONE_CPU, "--json"))
        self.assertEqual(played["scene"]["position_format"], "f32")
        self.assertNotIn("per_frame", played)

    def test_a_frame_without_counted_contacts_has_none(self):
        out = self.ok("stream", *self.files, *ONE_CPU, "--report", "any")
        self.assertRegex(out.splitlines()[0], ": no contact, ")
        self.assertRegex(out.splitlines()[1], ": a contact, ")

    def test_a_frame_that_does_not_fit_is_named_before_the_work(self):
        nothing = {"COLLIDED_DAEMON": "/nonexistent"}
        more = self.put("frame3.obj", FRAME1 + "v 9 9 9\n")
        self.refused(1, f"the frames differ: {self.files[0]} has 6 vertices, {more} has 7", "stream", *self.files, more,
                     **nothing)
        turned = self.put("frame4.obj", FRAME1.replace("f 1 2 3", "f 1 3 2"))
        self.refused(1, f"triangle 0 has other vertices in {turned} than in {self.files[0]}", "stream", *self.files, turned,
                     **nothing)
        self.refused(1, "none.obj: does not exist", "stream", *self.files, os.path.join(self.folder.name, "none.obj"),
                     **nothing)
        self.refused(1, "neither .obj nor .ply", "stream", self.put("frame5.txt", ""), **nothing)

    def test_files_or_a_scene(self):
        self.refused(2, "stream needs one of FRAME... and --scene", "stream", *ONE_CPU)
        self.refused(2, "stream needs one of FRAME... and --scene", "stream", *self.files, "--scene", "funnel")
        for option in ("--frames", "--t0", "--dt", "--scale"):
            self.refused(2, f"{option} requires --scene", "stream", *self.files, option, "1")


if __name__ == "__main__":
    support.main()
