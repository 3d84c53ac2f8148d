"""collidectl stream over mesh files of one's own.

Usage: frames_test.py COLLIDECTL DAEMON"""

import json
import os
import re
import xml.etree.ElementTree

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
        step = json.loads(self.ok("detect", "--frames", *self.files[:2], *ONE_CPU, "--json"))
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
        self.refused(1, "the extension must be .obj, .ply", "stream", self.put("frame5.txt", ""), **nothing)

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def test_contacts_of_all_frames_are_in_one_file(self):
        out = self.path("contacts.csv")
        played = json.loads(self.ok("stream", *self.files, *ONE_CPU, "--out", out, "--json"))
        self.assertEqual(played["out"], out)
        rows = self.rows(out)
        counts = [frame["contact_count"] for frame in played["per_frame"]]
        self.assertEqual([sum(row["frame"] == str(id) for row in rows) for id in (1, 2, 3)], counts)
        step = self.path("step.csv")
        self.ok("detect", "--frames", *self.files[:2], *ONE_CPU, "--out", step)
        second = [{name: cell for name, cell in row.items() if name != "frame"} for row in rows if row["frame"] == "2"]
        self.assertEqual(second, self.rows(step))
        text = self.ok("stream", *self.files, *ONE_CPU, "--out", "-")
        with open(out, encoding="ascii") as file:
            self.assertEqual(text, file.read())

    def test_contacts_of_each_frame_are_in_a_file(self):
        names = {form: self.path("c_{frame}." + form) for form in ("csv", "vtp", "ply")}
        words = ["--out", names["csv"], "--vtp", names["vtp"], "--ply", names["ply"]]
        played = json.loads(self.ok("stream", *self.files, *ONE_CPU, *words, "--json"))
        for id, frame in enumerate(played["per_frame"], 1):
            count = frame["contact_count"]
            self.assertEqual(len(self.rows(names["csv"].format(frame=f"{id:04}"))), count)
            piece = xml.etree.ElementTree.parse(names["vtp"].format(frame=f"{id:04}")).find("PolyData/Piece")
            self.assertEqual(piece.get("NumberOfPoints"), str(count))
            with open(names["ply"].format(frame=f"{id:04}"), encoding="ascii") as file:
                self.assertIn(f"element vertex {count}\n", file.read())
        points = [self.path(f"step.{form}") for form in ("vtp", "ply")]
        self.ok("detect", "--frames", *self.files[:2], *ONE_CPU, "--vtp", points[0], "--ply", points[1])
        for file, of_stream in zip(points, (names["vtp"], names["ply"])):
            with open(file, encoding="ascii") as step, open(of_stream.format(frame="0002"), encoding="ascii") as frame:
                self.assertEqual(step.read(), frame.read())
        series = xml.etree.ElementTree.parse(self.path("c.pvd")).getroot().findall("Collection/DataSet")
        self.assertEqual([(one.get("timestep"), one.get("file")) for one in series],
                         [(str(id), f"c_{id:04}.vtp") for id in (1, 2, 3)])

    def test_contacts_of_many_frames_in_flight_are_those_of_their_frames(self):
        words = ["--scene", "reef_knot", "--scale", "0.2", "--t0", "0.5", "--frames", "20", "--thickness", "0.05", *ONE_CPU]
        out, same = self.path("all.csv"), self.path("{frame}.csv")
        self.ok("stream", *words, "--out", out)
        self.ok("stream", *words, "--mode", "dcd", "--out", same)
        for row in self.rows(out)[::50]:
            gap = sum((float(row["point_a_" + axis]) - float(row["point_b_" + axis]))**2 for axis in "xyz")**0.5
            self.assertAlmostEqual(gap, float(row["distance"]), delta=1e-4)
        self.assertEqual(len([name for name in os.listdir(self.folder.name) if name[:4].isdigit()]), 20)

    def test_contact_files_that_do_not_fit(self):
        nothing = {"COLLIDED_DAEMON": "/nonexistent"}
        for form in ("vtp", "ply"):
            self.refused(2, f"needs {{frame}} in its name, such as contacts_{{frame}}.{form}", "stream", *self.files,
                         f"--{form}", f"c.{form}", **nothing)
            self.refused(2, "not of its folder", "stream", *self.files, f"--{form}", f"{{frame}}/{{frame}}.{form}", **nothing)
            self.refused(2, "needs contact points", "stream", *self.files, "--mode", "dcd", "--kinds", "tt", f"--{form}",
                         f"{{frame}}.{form}", **nothing)
        self.refused(2, "--json and --out -", "stream", *self.files, "--json", "--out", "-")
        self.refused(2, "not --advance", "stream", *self.files, "--advance", "--out", "c.csv")
        self.refused(1, "Is a directory", "stream", *self.files, "--out", self.folder.name, **nothing)
        self.refused(1, "No such file", "stream", *self.files, "--vtp", "/nonexistent/{frame}.vtp", **nothing)

    def test_files_of_a_frame_are_no_others(self):
        nothing = {"COLLIDED_DAEMON": "/nonexistent"}
        ply, link = ["--ply", self.path("k_{frame}.ply")], self.path("link")
        os.symlink(self.folder.name, link)
        for name in (self.path("k_0001.ply"), link + "/k_0012.ply", self.path("k_{frame}.ply")):
            self.refused(2, "--record and --ply are two files; both are", "stream", *self.files, "--record", name, *ply, **nothing)
        self.refused(2, "--ply and the series of --vtp are two files", "stream", *self.files, "--ply", self.path("c{frame}.pvd"),
                     "--vtp", self.path("c0001{frame}.vtp"), **nothing)
        self.ok("stream", *self.files, *ONE_CPU, "--record", self.path("k_001.ply"), *ply)

    def test_checking_an_output_leaves_links_as_they_are(self):
        link, target = self.path("link.csv"), self.path("target.csv")
        os.symlink("target.csv", link)
        words = ["stream", *self.files, "--out", link]
        self.refused(1, "COLLIDED_DAEMON", *words, COLLIDED_DAEMON="/nonexistent")
        self.assertTrue(os.path.islink(link))
        self.assertFalse(os.path.exists(target))
        self.ok(*words, *ONE_CPU)
        self.assertTrue(os.path.islink(link) and os.path.getsize(target))

    def test_a_frame_tells_candidates_of_each_kind(self):
        words = ["stream", *self.files, "--accuracy", "candidates", "--kinds", "vt,ee,tt", *ONE_CPU]
        self.assertRegex(self.ok(*words).splitlines()[1], r": 4 candidates \(1 vt, 2 ee, 1 tt\), \S+ ms$")
        self.assertNotIn("earliest_toi", json.loads(self.ok(*words, "--json"))["per_frame"][1])

    def test_a_frame_without_motion_has_no_time_of_impact(self):
        words = ["stream", *self.files, "--mode", "dcd", "--thickness", "2", *ONE_CPU]
        self.assertRegex(self.ok(*words).splitlines()[1], r": [1-9]\d* contacts \(\d+ vt, \d+ ee, 0 tt\), \S+ ms$")
        for more in ([], ["--report", "any"]):
            frame = json.loads(self.ok(*words, *more, "--json"))["per_frame"][1]
            self.assertIs(frame["any_contact"], True)
            self.assertNotIn("earliest_toi", frame)

    def test_files_or_a_scene(self):
        self.refused(2, "stream needs one of FRAME... and --scene", "stream", *ONE_CPU)
        self.refused(2, "stream needs one of FRAME... and --scene", "stream", *self.files, "--scene", "funnel")
        for option in ("--frames", "--t0", "--dt", "--scale"):
            self.refused(2, f"{option} requires --scene", "stream", *self.files, option, "1")


if __name__ == "__main__":
    support.main()
