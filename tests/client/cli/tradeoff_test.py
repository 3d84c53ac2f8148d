"""collidectl tradeoff: what it measures, judges and writes.

Usage: tradeoff_test.py COLLIDECTL DAEMON"""

import json
import os

import support
from support import ONE_CPU, FRAME0, FRAME1


class Tradeoff(support.CollidectlTest):
    def test_tradeoff_measures_judges_and_writes(self):
        out = os.path.join(self.folder.name, "tradeoff")
        small = ["--scene", "flamenco", "--scale", "0.2", "--t0", "0.5", "--repeats", "2", "--deltas", "1e-3,0"]
        labels = ["--date", "2026-11-21", "--commit", "abc1234"]
        summary = json.loads(self.ok("tradeoff", *small, *labels, *ONE_CPU, "--out", out, "--json"))
        self.check_tradeoff_files(out)
        with open(os.path.join(out, "tradeoff.json"), encoding="ascii") as file:
            result = json.load(file)
        self.assertEqual((result["name"], result["date"], result["commit"]), ("flamenco", "2026-11-21", "abc1234"))
        self.assertEqual((result["backend"], result["repeats"]), ("cpu", 2))
        self.assertEqual([truth["source"] for truth in result["truths"]], ["exact", "exact"])
        runs = result["runs"]
        self.assertEqual(len(runs), 2 * (1 + 3 * 2))
        for run in runs:
            contacts = run["contacts"]
            self.assertEqual(run["delta"] is None, run["level"] == "fast")
            self.assertGreater(contacts["sum"]["right"], 0)
            self.assertEqual(contacts["sum"]["reported"], contacts["sum"]["right"] + contacts["sum"]["false"])
            self.assertLessEqual(0, run["median_ms"]["narrow"])
            self.assertLess(run["median_ms"]["narrow"], run["median_ms"]["stages"])
            if run["level"] != "fast":
                self.assertEqual((contacts["sum"]["missed"], contacts["sum"]["late"]), (0, 0), run)
            if run["level"] == "exact":
                self.assertEqual(contacts["sum"]["false"], 0, run)
        self.assertEqual(len(summary["results"][0]["runs"]), len(runs))

    def test_encoded_positions_are_judged_by_those_that_were_meant(self):
        out = os.path.join(self.folder.name, "tradeoff")
        small = ["--scene", "flamenco", "--scale", "0.2", "--t0", "0.5", "--repeats", "1", "--formats", "f32,q16"]
        self.ok("tradeoff", *small, *ONE_CPU, "--out", out, "--json")
        with open(os.path.join(out, "tradeoff.json"), encoding="ascii") as file:
            result = json.load(file)
        runs = {(run["position_format"], run["level"]): run for run in result["runs"]}
        self.assertEqual([level for form, level in runs if form == "q16"], ["fast", "guarded", "certified"])
        plain, encoded = runs["f32", "certified"], runs["q16", "certified"]
        self.assertEqual(2 * encoded["bytes_in"], plain["bytes_in"])
        for level in ("guarded", "certified"):
            contacts = runs["q16", level]["contacts"]["sum"]
            self.assertEqual((contacts["missed"], contacts["late"]), (0, 0), contacts)
        self.assertGreater(encoded["contacts"]["sum"]["false"], plain["contacts"]["sum"]["false"])
        with open(os.path.join(out, "tradeoff.md"), encoding="utf-8") as file:
            self.assertIn("q16: the level `EXACT` on the positions before they were encoded", file.read())

    def check_tradeoff_files(self, folder):
        self.assertEqual(sorted(os.listdir(folder)), ["tradeoff.json", "tradeoff.md"])
        with open(os.path.join(folder, "tradeoff.md"), encoding="utf-8") as file:
            rows = [line.split(" | ")[:3] for line in file if line.startswith("| f")]
        for positions in ("| f32", "| f64"):
            self.assertEqual(rows.count([positions, "fast", "-"]), 2)  # answers and cost
            self.assertEqual(rows.count([positions, "certified", "1e-3"]), 2)
            self.assertEqual(rows.count([positions, "exact", "auto"]), 2)

    def put_truth(self, vf):
        self.put("vf.csv", "vertex,triangle,collides,toi\n" + vf)
        self.put("ee.csv", "a0,a1,b0,b1,collides,toi\n")
        return ["--truth", self.folder.name]

    def test_tradeoff_judges_by_a_given_truth(self):
        options = [*ONE_CPU, "--out", self.folder.name, "--json", "--repeats", "1", "--levels", "fast,certified"]
        words = ["tradeoff", *options, self.frame0, self.frame1]
        right = json.loads(self.ok(*words, *self.put_truth("3,0,1,0.5\n")))["results"][0]["runs"]
        self.assertEqual([run["missed"] for run in right], [0] * 4)
        wrong = json.loads(self.ok(*words, *self.put_truth("3,0,1,0.4876\n4,0,1,0.5\n3,1,0,\n")))
        runs = wrong["results"][0]["runs"]
        self.assertEqual([(run["missed"], run["late"]) for run in runs], [(1, 1)] * 4)
        with open(os.path.join(self.folder.name, "tradeoff.json"), encoding="ascii") as file:
            truths = json.load(file)["truths"]
        self.assertEqual([truth["source"] for truth in truths], [self.folder.name] * 2)
        # Positions that are not floats: the truth holds for the doubles only.
        double = self.put("double.obj", FRAME1.replace("v 1 1 -1", "v 1 1 -1.1"))
        self.ok("tradeoff", self.frame0, double, *options, *self.put_truth("3,0,1,0.5\n"))
        with open(os.path.join(self.folder.name, "tradeoff.json"), encoding="ascii") as file:
            truths = json.load(file)["truths"]
        self.assertEqual([truth["source"] for truth in truths], ["exact", self.folder.name])

    def test_tradeoff_refuses_bad_usage(self):
        out = ["--out", self.folder.name]
        frames = [self.frame0, self.frame1]
        self.refused(2, "--levels", "tradeoff", *frames, *out, "--levels", "fast,perfect")
        self.refused(2, "--formats", "tradeoff", *frames, *out, "--formats", "f16")
        for delta in ("-1", "nan", "inf", "soon", "0,-1"):
            self.refused(2, "--deltas", "tradeoff", *frames, *out, f"--deltas={delta}")
        self.refused(2, "--thickness", "tradeoff", *frames, *out, "--thickness=-1")
        self.refused(2, "--formats q16 needs --levels fast, guarded or certified", "tradeoff", *frames, *out, "--levels", "exact",
                     "--formats", "f32,q16")
        self.refused(2, "--repeats", "tradeoff", *frames, *out, "--repeats", "0")
        self.refused(2, "--out", "tradeoff", *frames)
        self.refused(2, "one of FRAME0 FRAME1 and --scene", "tradeoff", *out)
        self.refused(2, "one of FRAME0 FRAME1", "tradeoff", *frames, *out, "--scene", "funnel")
        self.refused(2, "needs two frames", "tradeoff", self.frame0, *out)
        self.refused(2, "--scene", "tradeoff", *frames, *out, "--t0", "0.5")
        self.refused(2, "--truth", "tradeoff", "--scene", "funnel", *out, "--truth", "x")
        self.refused(2, "--truth", "tradeoff", *frames, *out, "--truth", "x", "--thickness", "1")

    def test_tradeoff_names_what_cannot_be_read_or_written(self):
        out = ["--out", os.path.join(self.folder.name, "tradeoff")]
        frames = [self.frame0, self.frame1]
        for folder in (os.path.join(self.frame0, "below"), "/proc/nothing"):
            self.refused(1, folder, "tradeoff", *frames, "--out", folder)
        self.refused(1, "vf.csv: cannot be read", "tradeoff", *frames, *out, "--truth", self.folder.name)
        self.put_truth("3,0,maybe,0.5\n")
        self.refused(1, "vf.csv:2: collides is 'maybe'", "tradeoff", *frames, *out, "--truth", self.folder.name)
        other = self.put("other.obj", FRAME0 + "v 9 9 9\n")
        self.refused(1, "a.obj has 6 vertices, ", "tradeoff", self.frame0, other, *out)
        turned = self.put("turned.obj", FRAME0.replace("f 1 2 3", "f 1 3 2"))
        self.refused(1, "triangle 0 has other vertices", "tradeoff", self.frame0, turned, *out)
        os.makedirs(os.path.join(out[1], "tradeoff.md"))
        self.refused(1, "tradeoff.md: cannot be written: Is a directory", "tradeoff", *frames, *out, COLLIDED_DAEMON="/nonexistent")

    def test_a_result_that_cannot_be_written_is_told(self):
        out = os.path.join(self.folder.name, "tradeoff")
        os.mkdir(out)
        os.symlink("/dev/full", os.path.join(out, "tradeoff.json"))
        words = ["tradeoff", self.frame0, self.frame1, "--levels", "fast", "--formats", "f32", "--repeats", "1", *ONE_CPU]
        done = support.ctl(*words, "--out", out, "--json")
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("tradeoff.json: cannot be written: No space left", done.stderr)
        self.assertEqual(len(json.loads(done.stdout)["results"][0]["runs"]), 1)


if __name__ == "__main__":
    support.main()
