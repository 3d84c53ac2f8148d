"""collidectl bench: what it measures and writes.

Usage: bench_test.py COLLIDECTL DAEMON"""

import json
import os

import support
from support import FRAME0, FRAME1, ONE_CPU


class Bench(support.CollidectlTest):
    BENCH_KEYS = ["scene", "triangles", "backend", "device", "engine", "accuracy", "steps", "step_ms", "stage_ms",
                  "counts", "device_bytes", "allocations_per_step", "graph_launches_per_step"]
    BENCH_COUNTS = ["tests", "pairs", "candidates_vertex_triangle", "candidates_edge_edge",
                    "contacts_vertex_triangle", "contacts_edge_edge", "leaves", "registrations"]

    def bench(self, *words):
        """The file that bench writes, checked for its shape."""
        out = os.path.join(self.folder.name, "bench.json")
        self.table = self.ok("bench", *words, *ONE_CPU, "--out", out)
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
            for name in ("tests", "pairs", "candidates_vertex_triangle", "candidates_edge_edge", "leaves"):
                self.assertGreater(run["counts"][name], 0, (run["scene"], name))
            without_cells = {"lbvh", "all-pairs"} & set(run["counts"]["steps_by_engine"])
            self.assertEqual(run["counts"]["registrations"] > 0, not without_cells)
        for name in self.BENCH_COUNTS[1:6]:
            self.assertEqual(runs[0]["counts"][name], runs[1]["counts"][name])
        self.assertEqual(result["settings"], {"warm_up": 2, "scale": 0.2, "mode": "ccd", "position_format": "f32",
                                              "thickness": 0, "delta": 0, "report": "all", "kinds": ["vt", "ee"]})

    def test_bench_ends_where_the_scene_ends(self):
        """However long the warm-up is, the last step is the same."""
        words = ["--scene", "flamenco", "--scale", "0.2", "--steps", "4", "--position-format", "f64",
                 "--engine", "octree"]
        counts = [self.bench(*words, "--warm-up", n)["runs"][0]["counts"] for n in ("0", "3")]
        for name in (*self.BENCH_COUNTS, "survivors_vertex_triangle", "survivors_edge_edge"):
            self.assertEqual(counts[0][name], counts[1][name], name)
        self.assertGreater(counts[0]["contacts_vertex_triangle"], 0)

    def test_bench_measures_the_step_between_two_frames(self):
        result = self.bench("--frames", self.frame0, self.frame1, "--steps", "2", "--warm-up", "1",
                            "--accuracy", "exact", "--thickness", "0.01", "--kinds", "vt")
        run = result["runs"][0]
        self.assertEqual((run["scene"], run["triangles"], run["accuracy"]), ("a to b", 2, "exact"))
        self.assertGreater(run["counts"]["contacts_vertex_triangle"], 0)
        self.assertEqual(result["settings"]["scale"], None)
        self.assertEqual((result["settings"]["kinds"], result["settings"]["thickness"]), (["vt"], 0.01))

    def test_bench_measures_one_frame(self):
        result = self.bench("--frames", self.frame1, "--mode", "dcd", "--kinds", "tt", "--steps", "1")
        self.assertEqual(result["runs"][0]["scene"], "b")
        self.assertEqual(result["runs"][0]["counts"]["contacts_triangle_triangle"], 1)

    def test_bench_uses_a_running_daemon(self):
        with self.daemon("--max-scenes", "1") as address:
            words = ["--scene", "funnel", "--scale", "0.1", "--engine", "auto,octree", "--steps", "2"]
            self.assertIn("octree", self.ok("bench", *words, "--server", address, "--backend", "cpu"))

    def test_bench_prints_json_as_every_command_does(self):
        words = ["bench", "--scene", "funnel", "--scale", "0.1", "--steps", "2", "--warm-up", "0", *ONE_CPU]
        out = os.path.join(self.folder.name, "bench.json")
        printed = json.loads(self.ok(*words, "--json", "--out", out))
        with open(out, encoding="ascii") as file:
            self.assertEqual(json.load(file), printed)
        self.assertEqual(printed["runs"][0]["scene"], "funnel")
        done = support.ctl(*words, "--out", "-")
        self.assertEqual(json.loads(done.stdout)["runs"][0]["steps"], 2)
        self.assertIn("median ms", done.stderr)
        self.assertFalse(os.path.exists("-"))
        self.refused(2, "both want standard output", *words, "--json", "--out", "-")
        self.refused(2, "bench.json", *words, "--json", "bench.json")

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
        self.refused(2, "--engine", "detect", "--frames", *frames[1:], "--engine", "grid")
        self.refused(2, "--accuracy", "bench", *scene, "--accuracy", "perfect")
        self.refused(2, "--position-format", "bench", *scene, "--position-format", "f16")

    def test_names_that_are_not_utf8_lose_no_result(self):
        frames = [os.fsencode(self.folder.name) + name for name in (b"/\xff0.obj", b"/\xff1.obj")]
        for text, frame in zip((FRAME0, FRAME1), frames):
            with open(frame, "w", encoding="ascii") as file:
                file.write(text)
        out = os.path.join(self.folder.name, "out.json")
        bench = ["bench", "--frames", *frames, "--steps", "1", "--warm-up", "0", *ONE_CPU]
        load = ["load", "--frames", *frames, "--rate", "20", "--seconds", "0.2", *ONE_CPU]
        for words in (bench, load):
            told = json.loads(self.ok(*words, "--out", out, "--json"))
            with open(out, encoding="utf-8") as file:
                self.assertEqual(json.load(file), told)
            self.assertIn("\ufffd", json.dumps(told, ensure_ascii=False))
        out = os.path.join(self.folder.name, "tradeoff")
        words = [*frames, "--levels", "fast", "--formats", "f32", "--repeats", "1", *ONE_CPU, "--out", out, "--json"]
        told = json.loads(self.ok("tradeoff", *words))
        self.assertIn("\ufffd", told["results"][0]["name"])

    def test_bench_names_what_it_cannot_use_before_any_work(self):
        nothing = {"COLLIDED_DAEMON": "/nonexistent"}
        self.refused(2, "'nothing' is not known", "bench", "--scene", "funnel,nothing", **nothing)
        self.refused(1, "scale is 100", "bench", "--scene", "funnel", "--scale", "100", **nothing)
        bad = "/nonexistent/folder/bench.json"
        self.refused(1, bad, "bench", "--scene", "funnel", "--out", bad, **nothing)
        self.refused(1, "none.ply", "bench", "--frames", "none.ply", self.frame0, **nothing)
        out = os.path.join(self.folder.name, "bench.json")
        self.refused(1, "COLLIDED_DAEMON", "bench", "--scene", "funnel", "--out", out, **nothing)
        self.assertFalse(os.path.exists(out))


if __name__ == "__main__":
    support.main()
