"""collidectl against the real daemon: what it prints, writes and refuses. Usage: collidectl_test.py COLLIDECTL DAEMON"""

import contextlib
import csv
import glob
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
import unittest
import xml.etree.ElementTree

COLLIDECTL, DAEMON = sys.argv[1:3]
ONE_CPU = ["--backend", "cpu", "--threads", "1"]

# A triangle and a vertex of another triangle that passes straight through its inside at t = 0.5.
FRAME0 = "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 1 1 1\nv 1.5 1 3\nv 1 1.5 3\nf 1 2 3\nf 4 5 6\n"
FRAME1 = "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 1 1 -1\nv 1.5 1 1\nv 1 1.5 1\nf 1 2 3\nf 4 5 6\n"


def ctl(*words, **environment):
    env = {**os.environ, "COLLIDED_DAEMON": DAEMON, **environment}
    return subprocess.run([COLLIDECTL, *words], capture_output=True, text=True, env=env, timeout=240)


class Collidectl(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.frame0 = self.put("a.obj", FRAME0)
        self.frame1 = self.put("b.obj", FRAME1)

    def put(self, name, text):
        path = os.path.join(self.folder.name, name)
        with open(path, "w", encoding="ascii") as file:
            file.write(text)
        return path

    def ok(self, *words, **environment):
        done = ctl(*words, **environment)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def refused(self, exit_code, part, *words, **environment):
        done = ctl(*words, **environment)
        self.assertEqual(done.returncode, exit_code, done.stdout + done.stderr)
        self.assertIn(part, done.stderr)
        self.assertTrue(done.stderr.startswith("collidectl: "), done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)

    def rows(self, name):
        with open(name, encoding="ascii", newline="") as file:
            return list(csv.DictReader(file))

    def test_ccd_finds_the_known_contact(self):
        out = os.path.join(self.folder.name, "c.csv")
        summary = json.loads(self.ok("detect", self.frame0, self.frame1, *ONE_CPU, "--out", out, "--json"))
        rows = self.rows(out)
        self.assertEqual(summary["contacts"], len(rows))
        self.assertEqual(summary["scene"]["triangles"], 2)
        self.assertEqual(summary["scene"]["backend"], "cpu")
        self.assertEqual(summary["scene"]["position_format"], "f32")
        vt = [row for row in rows if row["kind"] == "vt"]
        self.assertEqual([(row["element_a"], row["element_b"]) for row in vt], [("3", "0")])
        self.assertEqual([vt[0][v] for v in ("v0", "v1", "v2", "v3")], ["3", "0", "1", "2"])
        self.assertAlmostEqual(float(vt[0]["toi"]), 0.5, places=3)
        self.assertEqual(summary["earliest_toi"], float(vt[0]["toi"]))
        self.assertLessEqual(summary["earliest_toi"], 0.5)
        self.assertIs(summary["any_contact"], True)
        self.assertEqual(summary["warnings"], [])
        self.assertEqual([summary["scene"][name] for name in ("accuracy", "report", "kinds", "delta")],
                         ["certified", "all", ["vt", "ee"], 0])

    def test_every_level_finds_the_known_contact(self):
        for level in ("fast", "guarded", "certified", "exact"):
            out = os.path.join(self.folder.name, level)
            words = ["--accuracy", level, "--delta", "1e-5", "--out", out, "--json"]
            summary = json.loads(self.ok("detect", self.frame0, self.frame1, *ONE_CPU, *words))
            self.assertEqual((summary["scene"]["accuracy"], summary["scene"]["delta"]), (level, 1e-5))
            vt = [row for row in self.rows(out) if row["kind"] == "vt"]
            self.assertEqual([(row["element_a"], row["element_b"]) for row in vt], [("3", "0")])
            self.assertTrue(set(vt[0]["flags"].split("|")) <= {"", "certified", "near", "capped", "initial"})
        self.assertEqual(vt[0]["flags"], "certified")

    def test_reports(self):
        frames = [self.frame0, self.frame1]
        out = os.path.join(self.folder.name, "c.csv")
        earliest = json.loads(self.ok("detect", *frames, *ONE_CPU, "--report", "earliest", "--out", out, "--json"))
        self.assertEqual((earliest["scene"]["report"], earliest["contacts"], len(self.rows(out))), ("earliest", 1, 1))
        hit = json.loads(self.ok("detect", *frames, *ONE_CPU, "--report", "any", "--out", out, "--json"))
        self.assertEqual((hit["any_contact"], hit["contacts"], self.rows(out)), (True, 0, []))
        miss = json.loads(self.ok("detect", self.frame0, self.frame0, *ONE_CPU, "--report", "any", "--json"))
        self.assertIs(miss["any_contact"], False)

    def test_triangles_that_cross(self):
        out = os.path.join(self.folder.name, "c.csv")
        words = ["--mode", "dcd", "--kinds", "tt", "--out", out, "--json"]
        summary = json.loads(self.ok("detect", self.frame1, *ONE_CPU, *words))
        self.assertEqual(summary["scene"]["kinds"], ["tt"])
        self.assertEqual(summary["counts"]["contacts_triangle_triangle"], 1)
        row = self.rows(out)[0]
        self.assertEqual([row[name] for name in ("kind", "element_a", "element_b", "v0", "toi")],
                         ["tt", "0", "1", "", ""])

    def test_candidates_leave_uncomputed_fields_empty(self):
        out = os.path.join(self.folder.name, "c.csv")
        self.ok("detect", self.frame0, self.frame1, *ONE_CPU, "--accuracy", "candidates", "--out", out)
        rows = self.rows(out)
        self.assertEqual([row["kind"] for row in rows], sorted((row["kind"] for row in rows), reverse=True))
        self.assertTrue(all(row["toi"] == row["distance"] == "" for row in rows))

    def test_dcd_and_double_positions(self):
        near = self.put("near.obj", FRAME0.replace("v 1 1 1\n", "v 1 1 0.1\n"))
        summary = json.loads(self.ok("detect", near, "--mode", "dcd", "--thickness", "0.2", *ONE_CPU, "--json"))
        self.assertGreaterEqual(summary["contacts"], 1)
        self.assertEqual(summary["scene"]["position_format"], "f64")

    def test_export_detect_and_stream_agree_on_the_scene(self):
        out = os.path.join(self.folder.name, "frames")
        small = ["--scene", "funnel", "--scale", "0.2", "--frames", "2"]
        for ending in ("ply", "obj"):
            self.ok("export", *small, "--t0", "0.9", "--out", out, "--format", ending)
        frames = [os.path.join(out, f"funnel_000{i}.ply") for i in (0, 1)]
        one = json.loads(self.ok("detect", *frames, *ONE_CPU, "--json"))
        two = json.loads(self.ok("detect", *(f.replace(".ply", ".obj") for f in frames), *ONE_CPU, "--json"))
        self.assertEqual(one["counts"], two["counts"])
        played = json.loads(self.ok("stream", *small, *ONE_CPU, "--json"))
        self.assertEqual(played["scene"]["triangles"], one["scene"]["triangles"])
        self.assertEqual(played["frames"], 2)
        self.assertIn("total", played["median_stage_ms"])
        self.assertEqual(played["any_contact"], played["contacts"]["all"] > 0)
        self.assertEqual(played["warnings"], [])

    @contextlib.contextmanager
    def daemon(self, *options):
        """Address of a running daemon."""
        socket, ready = (os.path.join(self.folder.name, name) for name in ("s", "ready"))
        words = [DAEMON, "--address", "unix:" + socket, "--backend", "cpu", "--threads", "1", "--ready-file", ready]
        with subprocess.Popen([*words, "--log-level", "off", *options]) as daemon:
            try:
                while daemon.poll() is None and not (os.path.exists(ready) and os.path.getsize(ready)):
                    time.sleep(0.01)
                yield "unix:" + socket
            finally:
                daemon.terminate()
        self.assertEqual(daemon.returncode, 0)

    def test_a_running_daemon_is_used(self):
        with self.daemon() as address:
            info = json.loads(self.ok("info", "--server", address, "--json"))
            self.assertIn("cpu", info["devices"])
            for _ in range(2):
                self.ok("detect", self.frame0, self.frame1, "--server", address, "--backend", "cpu")

    def test_an_interrupt_deletes_the_scene_on_a_running_daemon(self):
        with self.daemon("--max-scenes", "1") as address:
            server = ["--server", address, "--backend", "cpu"]
            for number in (signal.SIGINT, signal.SIGTERM):
                words = [COLLIDECTL, "stream", "--scene", "funnel", "--scale", "0.2", "--frames", "1000000", *server]
                with subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as process:
                    self.assertIn("frames:", process.stderr.readline())
                    process.send_signal(number)
                    self.assertIn(f"collidectl: interrupted by signal {number.value}\n", process.stderr.read())
                self.assertEqual(process.returncode, 128 + number)
                self.ok("detect", self.frame0, self.frame1, *server)  # there is room for its scene

    def test_an_interrupted_detect_leaves_no_scene_on_a_running_daemon(self):
        out = os.path.join(self.folder.name, "frames")
        self.ok("export", "--scene", "funnel", "--frames", "2", "--t0", "0.9", "--out", out)
        frames = [os.path.join(out, f"funnel_000{i}.ply") for i in (0, 1)]
        with self.daemon("--max-scenes", "1") as address:
            server = ["--server", address, "--backend", "cpu"]
            for milliseconds in range(0, 200, 10):
                words = [COLLIDECTL, "detect", *frames, *server]
                with subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
                    time.sleep(milliseconds / 1000)
                    process.terminate()
                self.assertIn(process.returncode, (-signal.SIGTERM, 128 + signal.SIGTERM, 0))
                self.ok("detect", self.frame0, self.frame1, *server)

    def test_tradeoff_measures_judges_and_draws(self):
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
        self.check_redrawn(out, summary)

    def check_tradeoff_files(self, folder):
        with open(os.path.join(folder, "tradeoff.png"), "rb") as file:
            self.assertEqual(file.read(8), b"\x89PNG\r\n\x1a\n")
        picture = xml.etree.ElementTree.parse(os.path.join(folder, "tradeoff.svg")).getroot()
        self.assertTrue(picture.tag.endswith("svg"))
        with open(os.path.join(folder, "tradeoff.md"), encoding="utf-8") as file:
            rows = [line.split(" | ")[:3] for line in file if line.startswith("| f")]
        for positions in ("| f32", "| f64"):
            self.assertEqual(rows.count([positions, "fast", "-"]), 2)  # answers and cost
            self.assertEqual(rows.count([positions, "certified", "1e-3"]), 2)
            self.assertEqual(rows.count([positions, "exact", "auto"]), 2)

    def check_redrawn(self, folder, summary):
        """From its file, a result gives the same table and pictures; two results give more."""
        again, both = (os.path.join(self.folder.name, name) for name in ("again", "both"))
        source = ["--from", os.path.join(folder, "tradeoff.json")]
        redrawn = json.loads(self.ok("tradeoff", *source, "--out", again, "--json", COLLIDED_DAEMON="/nonexistent"))
        self.assertEqual(redrawn["results"], summary["results"])
        self.assertEqual(sorted(os.listdir(again)), ["tradeoff.md", "tradeoff.png", "tradeoff.svg"])
        for name in os.listdir(again):
            with open(os.path.join(folder, name), "rb") as first, open(os.path.join(again, name), "rb") as second:
                self.assertEqual(first.read(), second.read(), name)
        self.assertIn("f64 exact auto", self.ok("tradeoff", *source, *source, "--out", both))
        height = [xml.etree.ElementTree.parse(os.path.join(f, "tradeoff.svg")).getroot().get("viewBox").split()[3]
                  for f in (again, both)]
        self.assertGreater(float(height[1]), 1.8 * float(height[0]))

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
        # Positions that are no floats: the truth is one of the doubles alone.
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
        self.refused(2, "--repeats", "tradeoff", *frames, *out, "--repeats", "0")
        self.refused(2, "--out", "tradeoff", *frames)
        self.refused(2, "one of FRAME0 FRAME1, --scene and --from", "tradeoff", *out)
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
        self.refused(1, "the first has 6 vertices, the second 7", "tradeoff", self.frame0, other, *out)
        turned = self.put("turned.obj", FRAME0.replace("f 1 2 3", "f 1 3 2"))
        self.refused(1, "triangle 0 has other vertices", "tradeoff", self.frame0, turned, *out)
        self.refused(1, "is not known", "tradeoff", "--scene", "nothing", *out)
        self.refused(1, "none.json: cannot be read", "tradeoff", "--from", "none.json", *out)
        for text in ("", "{", "[]", '{"format": "other"}'):
            self.refused(1, "is no result of 'collidectl tradeoff'", "tradeoff", "--from", self.put("t", text), *out)

    BENCH_KEYS = ["scene", "triangles", "backend", "device", "engine", "accuracy", "steps", "step_ms", "stage_ms",
                  "counts", "device_bytes", "allocations_per_step", "graph_launches_per_step"]
    BENCH_COUNTS = ["tests", "pairs", "candidates_vt", "candidates_ee", "contacts_vt", "contacts_ee", "leaves",
                    "registrations"]

    def bench(self, *words):
        """The file that bench writes, checked for its shape."""
        out = os.path.join(self.folder.name, "bench.json")
        self.table = self.ok("bench", *words, *ONE_CPU, "--json", out)
        with open(out, encoding="ascii") as file:
            result = json.load(file)
        self.assertEqual(list(result), ["device", "settings", "runs"])
        for run in result["runs"]:
            self.assertEqual(list(run), self.BENCH_KEYS)
            self.assertEqual((run["backend"], run["device"]), ("cpu", result["device"]))
            self.assertLessEqual(0, run["step_ms"]["min"])
            self.assertLessEqual(run["step_ms"]["min"], run["step_ms"]["median"])
            self.assertLessEqual(run["step_ms"]["median"], run["step_ms"]["p95"])
            self.assertGreater(sum(run["stage_ms"].values()), 0)
            self.assertLessEqual(set(self.BENCH_COUNTS), set(run["counts"]))
            self.assertGreater(run["device_bytes"], 0)
            self.assertGreaterEqual(run["allocations_per_step"], 0)
            self.assertEqual(run["graph_launches_per_step"], 0)
            self.assertEqual(sum(run["counts"]["steps_by_engine"].values()), run["steps"])
            self.assertIn(run["scene"], self.table)
        return result

    def test_bench_measures_scenes_and_engines(self):
        words = ["--scene", "flamenco,funnel", "--scale", "0.2", "--engine", "auto,octree", "--steps", "3"]
        result = self.bench(*words, "--warm-up", "2")
        runs = result["runs"]
        self.assertEqual([(run["scene"], run["engine"]) for run in runs],
                         [("flamenco", "auto"), ("flamenco", "octree"), ("funnel", "auto"), ("funnel", "octree")])
        for run in runs:
            self.assertEqual((run["steps"], run["accuracy"]), (3, "certified"))
            for name in ("tests", "pairs", "candidates_vt", "candidates_ee", "leaves"):
                self.assertGreater(run["counts"][name], 0, (run["scene"], name))
            self.assertEqual(run["counts"]["registrations"] > 0, "lbvh" not in run["counts"]["steps_by_engine"])
        for name in ("pairs", "candidates_vt", "candidates_ee", "contacts_vt", "contacts_ee"):
            self.assertEqual(runs[0]["counts"][name], runs[1]["counts"][name])
        self.assertEqual(result["settings"], {"warm_up": 2, "scale": 0.2, "mode": "ccd", "position_format": "f32",
                                              "thickness": 0, "delta": 0, "report": "all", "kinds": ["vt", "ee"]})

    def test_bench_ends_where_the_scene_ends(self):
        """However long the warm-up is, the last step is the same."""
        words = ["--scene", "flamenco", "--scale", "0.2", "--steps", "4", "--position-format", "f64"]
        counts = [self.bench(*words, "--warm-up", n)["runs"][0]["counts"] for n in ("0", "3")]
        for name in (*self.BENCH_COUNTS, "survivors_vt", "survivors_ee"):
            self.assertEqual(counts[0][name], counts[1][name], name)
        self.assertGreater(counts[0]["contacts_vt"], 0)

    def test_bench_measures_the_step_between_two_frames(self):
        result = self.bench("--frames", self.frame0, self.frame1, "--steps", "2", "--warm-up", "1",
                            "--accuracy", "exact", "--thickness", "0.01", "--kinds", "vt")
        run = result["runs"][0]
        self.assertEqual((run["scene"], run["triangles"], run["accuracy"]), ("a to b", 2, "exact"))
        self.assertGreater(run["counts"]["contacts_vt"], 0)
        self.assertEqual(result["settings"]["scale"], None)
        self.assertEqual((result["settings"]["kinds"], result["settings"]["thickness"]), (["vt"], 0.01))

    def test_bench_measures_one_frame(self):
        result = self.bench("--frames", self.frame1, "--mode", "dcd", "--kinds", "tt", "--steps", "1")
        self.assertEqual(result["runs"][0]["scene"], "b")
        self.assertEqual(result["runs"][0]["counts"]["contacts_tt"], 1)

    def test_bench_uses_a_running_daemon(self):
        with self.daemon("--max-scenes", "1") as address:
            words = ["--scene", "funnel", "--scale", "0.1", "--engine", "auto,octree", "--steps", "2"]
            self.assertIn("octree", self.ok("bench", *words, "--server", address, "--backend", "cpu"))

    def test_bench_refuses_bad_usage(self):
        scene, frames = ["--scene", "funnel"], ["--frames", self.frame0, self.frame1]
        self.refused(2, "one of --scene and --frames", "bench")
        self.refused(2, "one of --scene and --frames", "bench", *scene, *frames)
        self.refused(2, "--mode ccd needs two frames", "bench", "--frames", self.frame0)
        self.refused(2, "--mode dcd needs one frame", "bench", *frames, "--mode", "dcd")
        self.refused(2, "--scale", "bench", *frames, "--scale", "2")
        self.refused(2, "--kinds tt needs", "bench", *scene, "--kinds", "tt")
        for steps in ("0", "-1", "many"):
            self.refused(2, "--steps", "bench", *scene, "--steps", steps)
        self.refused(2, "--warm-up", "bench", *scene, "--warm-up", "-1")
        for engines in ("grid", "octree,grid", ""):
            self.refused(2, "--engine", "bench", *scene, "--engine", engines)
        self.refused(2, "--engine", "detect", *frames[1:], "--engine", "grid")
        self.refused(2, "--accuracy", "bench", *scene, "--accuracy", "perfect")
        self.refused(2, "--position-format", "bench", *scene, "--position-format", "f16")

    def test_bench_names_what_it_cannot_use_before_any_work(self):
        nothing = {"COLLIDED_DAEMON": "/nonexistent"}
        self.refused(1, "'nothing' is not known", "bench", "--scene", "funnel,nothing", **nothing)
        self.refused(1, "scale is 100", "bench", "--scene", "funnel", "--scale", "100", **nothing)
        bad = "/nonexistent/folder/bench.json"
        self.refused(1, bad, "bench", "--scene", "funnel", "--json", bad, **nothing)
        self.refused(1, "none.ply", "bench", "--frames", "none.ply", self.frame0, **nothing)
        out = os.path.join(self.folder.name, "bench.json")
        self.refused(1, "COLLIDED_DAEMON", "bench", "--scene", "funnel", "--json", out, **nothing)
        self.assertFalse(os.path.exists(out))

    def test_nothing_is_left_behind(self):
        with tempfile.TemporaryDirectory() as folder:
            self.ok("info", TMPDIR=folder)
            far = ["--mode", "dcd", "--position-format", "f32", "--thickness", "1e39"]
            self.refused(1, "thickness", "detect", self.frame0, *far, *ONE_CPU, TMPDIR=folder)
            self.assertEqual(os.listdir(folder), [])

    def test_an_interrupt_stops_the_daemon_and_removes_its_folder(self):
        with tempfile.TemporaryDirectory() as folder:
            words = [COLLIDECTL, "stream", "--scene", "funnel", "--frames", "100000", *ONE_CPU]
            env = {**os.environ, "COLLIDED_DAEMON": DAEMON, "TMPDIR": folder}
            with subprocess.Popen(words, env=env, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
                while process.poll() is None and not glob.glob(folder + "/*/ready"):
                    time.sleep(0.01)
                with open(f"/proc/{process.pid}/task/{process.pid}/children", encoding="ascii") as file:
                    daemon = int(file.read().split()[0])
                time.sleep(0.3)
                process.terminate()
            self.assertEqual(process.returncode, 128 + 15)
            self.assertEqual(os.listdir(folder), [])
            deadline = time.monotonic() + 60
            while self.is_running(daemon) and time.monotonic() < deadline:
                time.sleep(0.05)
            self.assertFalse(self.is_running(daemon))

    def is_running(self, pid):
        try:
            with open(f"/proc/{pid}/stat", encoding="ascii") as file:
                return file.read().rsplit(")", 1)[1].split()[0] != "Z"
        except FileNotFoundError:
            return False

    def test_scenes_are_listed(self):
        self.assertIn("cloth_ball", self.ok("scenes"))
        scenes = {s["name"]: s["triangles"] for s in json.loads(self.ok("scenes", "--json"))}
        self.assertEqual(scenes["cloth_ball"], 91872)

    def test_bad_usage(self):
        self.refused(2, "needs two frames", "detect", self.frame0, *ONE_CPU)
        self.refused(2, "needs one frame", "detect", self.frame0, self.frame1, "--mode", "dcd")
        self.refused(2, "--mode", "detect", self.frame0, "--mode", "maybe")
        self.refused(2, "--thickness", "detect", self.frame0, "--thickness", "-1")
        self.refused(2, "--delta", "detect", self.frame0, "--delta", "-1")
        self.refused(2, "--accuracy", "detect", self.frame0, "--accuracy", "perfect")
        self.refused(2, "--report", "stream", "--scene", "funnel", "--report", "most")
        for kinds in ("xx", "vt,xx"):
            self.refused(2, "--kinds", "detect", self.frame0, self.frame1, "--kinds", kinds)
        for number in ("nan", "inf", "-inf"):
            self.refused(2, "--thickness", "detect", self.frame0, f"--thickness={number}")
            self.refused(2, "--delta", "detect", self.frame0, f"--delta={number}")
            self.refused(2, "--t0", "stream", "--scene", "funnel", f"--t0={number}")
            self.refused(2, "--dt", "stream", "--scene", "funnel", f"--dt={number}")
        self.refused(2, "subcommand")
        self.refused(2, "--threads", "detect", self.frame0, "--server", "x:1", "--threads", "2")

    def test_options_that_do_not_go_together(self):
        ccd = ["detect", self.frame0, self.frame1]
        dcd = ["detect", self.frame0, "--mode", "dcd"]
        stream = ["stream", "--scene", "funnel"]
        self.refused(2, "--report earliest needs", *dcd, "--report", "earliest")
        self.refused(2, "--report earliest needs", *ccd, "--report", "earliest", "--accuracy", "fast")
        self.refused(2, "--report any needs", *stream, "--report", "any", "--accuracy", "candidates")
        self.refused(2, "--kinds tt needs", *stream, "--kinds", "vt,tt")
        self.refused(2, "--thickness greater than 0", *dcd, "--accuracy", "fast")

    def test_output_that_cannot_be_written_is_an_error(self):
        for words in (["info", "--json"], ["scenes"], ["--help"]):
            with open("/dev/full", "w", encoding="ascii") as full:
                env = {**os.environ, "COLLIDED_DAEMON": DAEMON}
                words = [COLLIDECTL, *words]
                done = subprocess.run(words, stdout=full, stderr=subprocess.PIPE, text=True, env=env, timeout=240)
            self.assertEqual(done.returncode, 1)
            self.assertEqual(done.stderr, "collidectl: standard output cannot be written\n")

    def test_errors_in_the_work(self):
        other = self.put("other.obj", FRAME0 + "v 9 9 9\n")
        self.refused(1, "has 6 vertices", "detect", self.frame0, other, *ONE_CPU)
        self.refused(1, "has 7", "detect", self.frame0, other, *ONE_CPU)
        self.refused(1, "none.ply", "detect", "none.ply", self.frame0)
        self.refused(1, "empty.obj: has 0 vertices", "detect", self.put("empty.obj", ""), "--mode", "dcd")
        self.refused(1, "is not known", "stream", "--scene", "nothing")
        self.refused(1, "nonexistent", "info", "--server", "unix:/nonexistent/socket")
        self.refused(1, "COLLIDED_DAEMON", "detect", self.frame0, self.frame1, COLLIDED_DAEMON="/nonexistent")
        self.refused(1, "ended with exit code 1", "info", COLLIDED_DAEMON="/bin/false")
        bad = "/nonexistent/folder/c.csv"
        self.refused(1, bad, "detect", self.frame0, self.frame1, *ONE_CPU, "--out", bad)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
