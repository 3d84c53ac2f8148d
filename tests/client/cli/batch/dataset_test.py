"""collidectl batch: which pairs a data set has, and the results of those that are whole and those that are not.

Usage: dataset_test.py COLLIDECTL DAEMON"""

import json
import os
import shutil
import unittest

import batch_support
from batch_support import BROKEN, FRAME0, LEVEL, ONE_CPU, ctl, support

REAL = os.path.join(os.path.dirname(__file__), "../../../../../shared/data/ccd-frames")


class Datasets(batch_support.BatchTest):
    def listed(self, dataset, *words):
        done = ctl("batch", dataset, "--list", *words)
        self.assertEqual(done.returncode, 0, done.stderr)
        header, *pairs = done.stdout.splitlines()
        self.assertIn(header, ("frame0", "frame0,frame1"))
        return [pair.replace(str(dataset) + "/", "") for pair in pairs], done.stderr

    def test_sequences_in_folders_are_paired_by_their_numbers(self):
        self.frames("cloth/frames", (9, 10, 11))
        self.frames("ball/frames", (7, 8), "balls16_{}.obj")
        self.frames("coarse", (0, 10, 20), "{}.obj")
        pairs, notes = self.listed(self.data)
        self.assertEqual(pairs, ["ball/frames/balls16_7.obj,ball/frames/balls16_8.obj", "cloth/frames/f9.obj,cloth/frames/f10.obj",
                                 "cloth/frames/f10.obj,cloth/frames/f11.obj", "coarse/0.obj,coarse/10.obj",
                                 "coarse/10.obj,coarse/20.obj"])
        self.assertEqual(notes, "")

    def test_there_is_no_pair_across_a_gap(self):
        self.frames("", (92, 93, 120, 121))
        shutil.copy(os.path.join(self.data, "f92.obj"), os.path.join(self.data, "rest.obj"))
        self.put("data/._f94.obj", "not a mesh")
        pairs, notes = self.listed(self.data)
        self.assertEqual(pairs, ["f92.obj,f93.obj", "f120.obj,f121.obj"])
        self.assertIn("no pair of f93.obj and f120.obj", notes)
        self.assertIn("no pair of rest.obj: its name has no number", notes)

    def test_a_glob_and_a_list_are_data_sets_too(self):
        self.frames("a/frames", (1, 2))
        self.frames("b/frames", (1, 2, 3))
        pairs, _ = self.listed(os.path.join(self.data, "*", "frames"))
        self.assertEqual([pair.replace(self.data + "/", "") for pair in pairs],
                         ["a/frames/f1.obj,a/frames/f2.obj", "b/frames/f1.obj,b/frames/f2.obj", "b/frames/f2.obj,b/frames/f3.obj"])
        self.assertEqual(len(self.listed(os.path.join(self.data, "b/frames/f[12].obj"))[0]), 1)
        made = self.put("list.csv", '# of my own\r\nframe0,frame1\r\n"data/a/frames/f1.obj",data/b/frames/f2.obj\r\n\r\n')
        self.assertEqual([pair.replace(self.folder.name + "/", "") for pair in self.listed(made)[0]],
                         ["data/a/frames/f1.obj,data/b/frames/f2.obj"])

    def test_a_printed_list_is_a_data_set(self):
        self.frames("a, b", (1, 2, 3))
        printed = ctl("batch", "data", "--list", cwd=self.folder.name).stdout
        self.assertEqual(printed.splitlines()[1], '"data/a, b/f1.obj","data/a, b/f2.obj"')
        self.batch(*ONE_CPU, dataset=self.put("pairs.csv", printed))
        self.assertEqual([(row["frame1"], row["status"]) for row in self.table()],
                         [("data/a, b/f2.obj", "done"), ("data/a, b/f3.obj", "done")])

    def test_single_frames(self):
        self.frames("", (1, 2, 3))
        self.assertEqual(self.listed(self.data, "--mode", "dcd")[0], ["f1.obj", "f2.obj", "f3.obj"])
        self.batch("--mode", "dcd", *ONE_CPU)
        self.assertEqual([(row["frame1"], row["earliest_toi"]) for row in self.table()], [("", "")] * 3)

    @unittest.skipUnless(os.path.isdir(REAL), "the data set is not here")
    def test_the_layout_of_a_public_data_set(self):
        self.assertEqual(self.listed(REAL)[0], ["cloth-ball/frames/cloth_ball92.ply,cloth-ball/frames/cloth_ball93.ply",
                                                "cloth-funnel/frames/227.ply,cloth-funnel/frames/228.ply"])

    def test_a_printed_list_keeps_names_that_look_like_comments(self):
        self.put("#1.obj", FRAME0)
        self.put("#2.obj", FRAME0)
        printed = ctl("batch", "#?.obj", "--list", cwd=self.folder.name).stdout
        self.assertEqual(printed.splitlines()[1], '"#1.obj","#2.obj"')
        self.assertEqual(ctl("batch", self.put("pairs.csv", printed), "--list").stdout.count("\n"), 2)

    def test_what_cannot_be_looked_at_is_named(self):
        self.frames("below", (1, 2))
        os.symlink("loop.obj", os.path.join(self.data, "below", "loop.obj"))
        self.refused(1, "below/loop.obj: cannot be read: Too many levels of symbolic links", "batch", self.data, "--list")

    def test_hostile_data_sets(self):
        def refused(part, dataset, *words):
            self.refused(1, part, "batch", dataset, "--list", *words)

        refused("does not exist", "/nonexistent")
        refused("has no mesh files", self.data)
        refused("has no mesh files", "/nonexistent/*.ply")
        refused("is one mesh file", self.frame0)
        self.put("data/a.obj", FRAME0)
        refused("has no pairs of frames", self.data)
        self.put("data/f1.obj", FRAME0)
        self.put("data/f01.obj", FRAME0)
        refused("has the same number as", self.data)
        for text, part in (("a.obj\n", "list:1: has 1 names"), ("a,b,c\n", "list:1: has 3 names"), ("\n\na,\n", "list:3: has an empty name"),
                           ('"a,b\n', "list:1: quotes that do not end"), ('"a"b,c\n', "list:1: text after quotes"),
                           ("a,b\x07\n", "list:1: has a control character"), ("a,b\nc,d\na,b\n", "list:3: is line 1 again"),
                           ("", "has no pairs"), ("# nothing\n", "has no pairs"), ("a" * 100000, "list:1: has 1 names")):
            refused(part, self.put("list", text))
        refused("has 2 names; a step of this --mode has 1", self.put("list", "a,b\n"), "--mode", "dcd")

    def test_hostile_shards(self):
        for shard in ("3", "/", "1/", "/2", "a/2", "1/b", "-1/2", "+1/2", " 1/2", "1/2/3", "1.0/2", "0x1/2"):
            self.refused(2, "is not I/N, two whole numbers", "batch", self.data, "--out", self.out, f"--shard={shard}")
        for shard in ("0/4", "5/4", "99999999999999999999/4"):
            self.refused(2, "shards count from 1, here 1/4 to 4/4; add 1", "batch", self.data, "--out", self.out, "--shard", shard)
        for shard in ("1/0", "0/0", "1/100001", "1/99999999999999999999"):
            self.refused(2, "there are 1 to 100000 shards", "batch", self.data, "--out", self.out, "--shard", shard)
        self.assertFalse(os.path.exists(self.out))

    def test_options_that_do_not_fit(self):
        self.frames("", (1, 2))
        self.refused(2, "one of --out FOLDER and --list", "batch", self.data)
        self.refused(2, "one of --out FOLDER and --list", "batch", self.data, "--out", self.out, "--list")
        self.refused(2, "standard output (-) is none", "batch", self.data, "--out", "-")
        self.refused(1, "is no folder that can be written to", "batch", self.data, "--out", self.frame0)


class Pairs(batch_support.BatchTest):
    def test_a_broken_pair_is_told_and_stops_no_other(self):
        done = self.batch("--json", *ONE_CPU, dataset=self.broken(), code=3)
        self.assertIn("4 pairs have failed", done.stderr)
        self.assertEqual(json.loads(done.stdout)["failed_pairs"], 4)
        rows = self.table(code=3)
        self.assertEqual([row["status"] for row in rows], ["done", *["failed"] * 4, "done"])
        for row, (name, why) in zip(rows[1:], BROKEN.items()):
            self.assertIn(why, row["error"])
            self.assertIn(name + ".obj", row["error"])
        alone = json.loads(self.ok("detect", "--frames", *(os.path.join(self.data, name) for name in ("a0.obj", "a1.obj")), *LEVEL, *ONE_CPU,
                                   "--json"))
        self.assertEqual((int(rows[0]["contacts"]), float(rows[0]["earliest_toi"])), (alone["contact_count"], alone["earliest_toi"]))
        self.assertEqual((rows[0]["vertices"], rows[0]["triangles"], rows[0]["any_contact"], rows[0]["error"]), ("6", "2", "yes", ""))

    def test_what_failed_is_tried_again_if_asked(self):
        pairs = self.broken()
        self.batch(*ONE_CPU, dataset=pairs, code=3)
        self.put("data/missing.obj", FRAME0)
        before = self.file(1, 1).read_bytes()
        self.batch(dataset=pairs, code=3, COLLIDED_DAEMON="/nonexistent")  # nothing to do: it starts none
        self.assertEqual(self.file(1, 1).read_bytes(), before)
        self.batch("--retry-failed", *ONE_CPU, dataset=pairs, code=3)
        rows = self.table(code=3)
        self.assertEqual([row["status"] for row in rows], ["done", "done", *["failed"] * 3, "done"])
        self.assertEqual([row["pair"] for row in rows], [str(pair) for pair in range(1, 7)])

    def test_contacts_are_those_of_detect(self):
        self.frames("", (1, 2, 3))
        contacts, alone = (os.path.join(self.folder.name, name) for name in ("contacts.csv", "alone.csv"))
        self.batch("--contacts", *ONE_CPU)
        self.merged("--contacts", contacts)
        self.ok("detect", "--frames", *(os.path.join(self.data, name) for name in ("f2.obj", "f3.obj")), *LEVEL, *ONE_CPU, "--out", alone)
        second = [{name: cell for name, cell in row.items() if name != "pair"} for row in self.rows(contacts) if row["pair"] == "2"]
        self.assertGreater(len(second), 0)
        self.assertEqual(second, self.rows(alone))

    def test_what_is_not_counted_is_empty(self):
        self.frames("", (1, 2))
        self.batch("--report", "any", *ONE_CPU)
        self.assertEqual([(row["contacts"], row["earliest_toi"], row["any_contact"]) for row in self.table()], [("", "", "yes")])

    def test_candidates_are_counted_by_kind(self):
        self.frames("", (1, 2))
        self.batch("--accuracy", "candidates", "--kinds", "vt,ee,tt", *ONE_CPU)
        names = ("contacts", "vertex_triangle", "edge_edge", "triangle_triangle", "edge_triangle", "any_contact", "earliest_toi")
        (row,) = self.table()
        counts = [int(row[name]) for name in names[:5]]
        self.assertEqual(counts[0], sum(counts[1:]))
        self.assertEqual([bool(count) for count in counts], [True, True, True, True, False], row)
        self.assertEqual([row[name] for name in names[5:]], ["no", ""])

    def test_a_daemon_that_cannot_be_reached_is_no_pairs_fault(self):
        self.frames("", (1, 2, 3))
        self.batch("--server", "unix:/nonexistent/socket", code=1)
        with self.daemon() as server:
            self.batch("--server", server)
        self.assertEqual([row["status"] for row in self.table()], ["done"] * 2)


if __name__ == "__main__":
    support.main()
