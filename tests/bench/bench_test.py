"""The benchmarks' output is complete and consistent. Usage: bench_test.py CHECK PROGRAM

CHECK: run, levels, engines (collided_bench), stages (collided_stage_bench), embree (collided_embree_bench), watch
(collided_watch_bench), in_process (collided_in_process_bench), switches (collided_switches_bench), solids
(collided_solids_bench), peers (solids/peers.py), exact (collided_exact_bench), subdivision (collided_subdivision_bench), reuse
(collided_reuse_bench), trials (collided_trials_bench) or advance_costs (collided_advance_costs_bench).
"""

import importlib.util
import json
import subprocess
import sys
import unittest

CHECK, PROGRAM = sys.argv[1:3]
SMALL = ["--scene", "one_cell", "--scale", "0.2"]
STEPS = 2


def printed(*options):
    return subprocess.run([PROGRAM, *options], stdout=subprocess.PIPE, text=True, check=True).stdout


def parsed(*options):
    return json.loads(printed(*options))


class Bench(unittest.TestCase):
    def run_of(self, *options):
        (scene,) = parsed(*SMALL, "--steps", str(STEPS), *options)["scenes"]
        return scene

    def check_run(self):
        one, other = self.run_of("--threads", "1"), self.run_of("--threads", "2")
        self.assertEqual((one["scene"], one["steps"]), ("one_cell", STEPS))
        self.assertGreater(one["counts"]["contacts_vt"] + one["counts"]["contacts_ee"], 0)
        self.assertGreater(one["device_bytes"], 0)
        self.assertLess(0, sum(one["stage_ms"].values()))
        self.assertEqual(one["digest"], other["digest"])
        self.assertNotEqual(one["digest"], self.run_of("--accuracy", "fast", "--scalar", "f64")["digest"])
        same = printed(*SMALL, "--check-same", "--threads", "1")
        self.assertEqual(len(same.splitlines()), 4)  # modes and number formats
        self.assertEqual(same, printed(*SMALL, "--check-same", "--threads", "2"))

    def check_trials(self):
        (run,) = parsed(*SMALL, "--frames", "40", "--warm-up", "1", "--period", "20")["runs"]
        self.assertEqual((run["scene"], run["frames"], run["period"]), ("one_cell", 40, 20))
        self.assertEqual(list(run["sides"]), ["auto", "lbvh", "octree"])
        self.assertIn(run["best_engine"], ("lbvh", "octree"))
        self.assertGreater(run["engine_trials"], 0)
        self.assertGreater(run["time_ratio"], 0)
        for side in run["sides"].values():
            self.assertLessEqual(side["p50_ms"], side["p95_ms"])
            self.assertLessEqual(side["p95_ms"], side["max_ms"])

    def check_advance_costs(self):
        (run,) = parsed(*SMALL, "--rounds", str(STEPS))["runs"]
        self.assertEqual((run["scene"], run["rounds"]), ("one_cell", STEPS))
        self.assertEqual(set(run["sides"]), {"plain", "all_or_one", "per_mesh", "per_vertex"})
        self.assertEqual(run["sides"]["plain"]["ratio"], 1)
        for name, side in run["sides"].items():
            self.assertGreater(side["step_ms"], 0)
            if name != "plain":
                self.assertGreater(side["advance_ms"], 0)
                self.assertLessEqual(side["advanced"], side["way"])

    def check_levels(self):
        (scene,) = parsed(*SMALL, "--steps", str(STEPS), "--compare-levels")["scenes"]
        contacts = {run["level"]: run["contacts"] for run in scene["levels"]}
        self.assertEqual(list(contacts),
                         ["fast", "guarded", "certified", "exact", "certified earliest", "certified any"])
        self.assertGreaterEqual(contacts["guarded"], contacts["certified"])
        self.assertGreaterEqual(contacts["certified"], contacts["exact"])
        self.assertGreater(contacts["exact"], 0)
        self.assertEqual((contacts["certified earliest"], contacts["certified any"]), (STEPS, 0))

    def check_engines(self):
        runs = parsed(*SMALL, "--steps", str(STEPS), "--compare-engines")["runs"]
        self.assertEqual([run["engine"] for run in runs],
                         ["octree", "top-down", "bottom-up", "uniform-grid", "two-level-grid", "lbvh", "vss", "all-pairs"])
        for run in runs:
            self.assertEqual(run["pairs_by_step"], runs[0]["pairs_by_step"], run["engine"])
            self.assertEqual(len(run["tests_by_step"]), STEPS)
            self.assertGreaterEqual(run["counts"]["tests"], run["counts"]["pairs"])

    def check_stages(self):
        ran = parsed("--scene", "flamenco", "--scale", "0.3", "--benchmark_min_time=0.001", "--benchmark_format=json",
                     "--benchmark_filter=-sort/.*000000/")
        self.assertTrue(ran["context"]["scene"].startswith("flamenco, "))
        groups = {run["name"].split("/")[0] for run in ran["benchmarks"] if not run.get("error_occurred")}
        self.assertEqual(groups, {"boxes", "exact", "fast", "filter", "frame", "hierarchy", "octree", "order", "pairs",
                                  "proximity", "separation", "sort"})

    def check_watch(self):
        ran = parsed(*SMALL, "--backend", "cpu", "--threads", "1", "--blocks", "2", "--frames", "3")
        self.assertEqual((ran["frames"], ran["watchers"], ran["stopped"]), (6, 4, 1))
        for of in ("alone_ms", "watched_ms"):
            self.assertLess(0, ran[of]["p50"])
            self.assertLessEqual(ran[of]["p50"], ran[of]["p99"])
        self.assertAlmostEqual(ran["ratio"]["p99"], ran["watched_ms"]["p99"] / ran["alone_ms"]["p99"])

    def check_batch(self):
        """Exits with 1 where one call and a call each find different numbers of contacts."""
        ran = parsed("--backend", "cpu", "--threads", "1", "--worlds", "5", "--rounds", "2", "--commit", "abc")
        self.assertEqual((ran["worlds"], ran["triangles"], ran["rounds"], ran["commit"]), (5, 500, 2, "abc"))
        self.assertGreater(ran["contacts"], 0)
        self.assertAlmostEqual(ran["ratio"], ran["a_call_each_ms"]["p50"] / ran["one_call_ms"]["p50"])
        for lane in ("one_call", "grpc_stream", "shared_memory", "shared_memory_in_place"):
            self.assertLess(0, ran[f"{lane}_ms"]["beside_p50"])

    def check_in_process(self):
        ran, = parsed(*SMALL, "--backend", "cpu", "--threads", "1", "--frames", "3")["runs"]
        self.assertEqual([lane["name"] for lane in ran["transports"]], ["grpc", "shared_memory", "in_process"])
        for lane in ran["transports"]:
            self.assertLess(0, lane["beside_engine_ms"]["p50"])
            self.assertLess(lane["beside_engine_ms"]["p50"], lane["whole_ms"])
        self.assertEqual(ran["transports"][1]["ratio_to_shared_memory"]["p50"], 1)

    def check_switches(self):
        runs = {run["name"]: run for run in parsed("--backend", "cpu", "--scale", "0.3", "--frames", "3",
                                                   "--warm-up", "5", "--threads", "1")["runs"]}
        full = runs["full model"]
        self.assertLess(runs["rigid ball"]["bytes_in"], full["bytes_in"])
        self.assertEqual(runs["rigid ball"]["bytes_in"], runs["static ball"]["bytes_in"] + 96)
        self.assertAlmostEqual(runs["Q16"]["bytes_in"] * 2, full["bytes_in"])
        self.assertLess(runs["DCD alone"]["device_bytes"], full["device_bytes"])
        self.assertNotIn("start_positions", runs["DCD alone"]["memory"])
        self.assertNotIn("rigid", full["memory"])
        self.assertIn("rigid", runs["rigid ball"]["memory"])
        # All make the same step, the frames that leave the scene elsewhere too.
        self.assertEqual(runs["trial, both ends sent"]["contacts"], full["contacts"])
        self.assertEqual(runs["both ends sent"]["contacts"], full["contacts"])
        for name in ("both ends sent", "advance, both ends sent", "trial, both ends sent"):
            self.assertEqual(runs[name]["bytes_in"], 2 * full["bytes_in"])
        for run in runs.values():
            self.assertLess(0, run["caller_ms"])

    def check_solids(self):
        runs = {run["name"]: run for run in parsed("--backend", "cpu", "--triangles", "2000", "--frames", "2",
                                                   "--threads", "1")["runs"]}
        self.assertGreater(runs["depths alone"]["inside"], 0)
        self.assertEqual(runs["states and depths"]["inside"], runs["depths alone"]["inside"])
        self.assertEqual([runs[name]["pairs"] for name in ("plain", "states", "states and depths alone")], [0, 1, 1])
        self.assertEqual(runs["within 0.01"]["contacts"], runs["within 0.01, signed"]["contacts"])
        self.assertNotIn("inside", runs["crossings"]["stages_ms"])
        self.assertLess(runs["plain"]["device_bytes"], runs["states"]["device_bytes"])

    def check_peers(self):
        """Of libraries that are not installed it says so. collided itself has nothing wrong."""
        ran = subprocess.run([sys.executable, PROGRAM, "--triangles", "500", "--rounds", "1"], stdout=subprocess.PIPE, text=True,
                             check=True)
        found = json.loads(ran.stdout)
        lanes = {(lane["library"], lane["name"]): lane for lane in found["lanes"]}
        ours = [lane for (library, _), lane in lanes.items() if library == "collided"]
        self.assertEqual((len(ours), len(lanes)), (2, 12))
        self.assertGreater(found["inside"], 0)
        for lane in ours:
            self.assertEqual(lane["wrong_by_case"], {})
            for count in ("inside", "on_surface", "depth"):
                self.assertEqual(lane[count]["wrong"], 0, count)
                self.assertGreater(lane[count]["of"], 300, count)
            self.assertEqual([lane["balls"][count]["wrong"] for count in ("inside", "depth")], [0, 0])
            self.assertEqual(lane["balls"]["depth"]["of"], found["inside"])
            self.assertGreater(lane["balls"]["again"]["cpu_ms"], 0)
        self.assertEqual([ours[1][count]["wrong"] for count in ("state", "deepest")], [0, 0])
        modules = {"libigl": ["igl"], "trimesh": ["trimesh", "rtree"], "python-fcl": ["fcl", "trimesh"], "warp-lang": ["warp"]}
        for (library, name), lane in lanes.items():
            if library != "collided":
                is_there = all(importlib.util.find_spec(module) for module in modules[library])
                self.assertEqual(lane.get("skipped"), None if is_there else "not installed", name)

    def check_exact(self):
        runs = parsed("--backend", "cpu", "--scene", "coincident", "--scale", "0.2", "--frames", "2")["runs"]
        self.assertEqual([run["scalar"] for run in runs], ["f32", "f64"])
        for run in runs:
            self.assertGreater(run["contacts"], 1000)
            self.assertGreaterEqual(run["decisions"], run["contacts"])
            self.assertAlmostEqual(run["ratio"], run["exact_ms"] / run["certified_ms"])

        runs = parsed("--backend", "cpu", "--costly", "--frames", "2")["runs"]
        self.assertEqual(len(runs), 16)
        for run in runs:
            self.assertGreater(run["decisions"], 0, run["scene"])

    def check_subdivision(self):
        """Smaller pieces are in no more cells, and find no more."""
        (scene,) = parsed("--scene", "funnel", "--scale", "0.4", "--steps", str(STEPS))["scenes"]
        boxes, triangles = scene["boxes"], scene["triangles"]
        for count in ("registrations", "tests", "pairs"):
            self.assertLessEqual(triangles[count], boxes[count], count)
        self.assertLess(triangles["registrations"], boxes["registrations"])
        self.assertGreater(triangles["pairs"], 0.9 * boxes["pairs"])
        self.assertGreaterEqual(boxes["tests"], boxes["pairs"])

    def check_reuse(self):
        """Exits with 1 where contacts differ."""
        run, = parsed("--scene", "cloth_ball", "--scale", "0.2", "--frames", "40", "--threads", "1", "--reuse",
                      "on")["runs"]
        self.assertEqual(run["searched"] + run["made"] + run["reused"], 40)
        self.assertGreater(run["reused"], run["made"])
        self.assertGreater(run["list_bytes"], 0)
        self.assertAlmostEqual(run["step_ratio"], run["reuse_step_ms"] / run["search_step_ms"])

    def check_parts(self):
        """Exits with 1 where results differ."""
        (scene,) = parsed("--scene", "cloth_ball", "--scale", "0.3", "--steps", str(STEPS), "--warm-up", "1",
                          "--threads", "2", "--parts", "1", "3")["scenes"]
        one, three = scene["in_parts"]
        for run, parts in (one, 1), (three, 3):
            self.assertTrue(run["same_bytes"])
            self.assertEqual([len(run["part_ms"]), len(run["shares"]), len(run["devices"])], [parts] * 3)
            self.assertAlmostEqual(sum(run["shares"]), 1)
            self.assertGreaterEqual(run["max_over_mean"], 1)
        self.assertEqual(three["bytes_to_devices"], 3 * one["bytes_to_devices"])
        cost = dict(scene["one"]["stage_ms"])
        boxes, levels = cost.pop("boxes"), cost.pop("levels")
        work = sum(ms for stage, ms in cost.items() if stage not in ("upload", "download"))
        self.assertAlmostEqual(three["predicted_ms"], boxes + 2 * levels + work / 3)

    def check_embree(self):
        """Exits with 1 where Embree and the engine find different numbers of pairs."""
        match = parsed("--scene", "funnel", "--scale", "0.2", "--rounds", "1", "--json")
        self.assertTrue(match["agree"])
        self.assertGreater(match["pairs"]["engine"], 0)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], f"Bench.check_{CHECK}"])
