"""collidectl bench --end-to-end: what it measures and writes.

Usage: end_to_end_test.py COLLIDECTL DAEMON"""

import json
import os

import json_keys
import support
from support import ONE_CPU

TIMES = ["latency_ms", "engine_ms", "overhead_ms"]


class EndToEnd(json_keys.KeyChecks, support.CollidectlTest):
    def measure(self, *words):
        out = os.path.join(self.folder.name, "bench.json")
        table = self.ok("bench", "--end-to-end", *words, *ONE_CPU, "--out", out)
        with open(out, encoding="ascii") as file:
            result = json.load(file)
        self.assertEqual(list(result), ["device", "settings", "runs"])
        self.check(result, "bench --end-to-end")
        for run in result["runs"]:
            self.check_run(run, table)
        return result

    def check_run(self, run, table):
        names = [way["transport"] for way in run["transports"]]
        self.assertEqual(names, ["grpc tcp", "grpc unix", "shared, copied", "shared, in place"])
        for name in (*names, *("bare " + bare for bare in run["bare_ms"])):
            self.assertIn(name, table)
        self.assertEqual(list(run["bare_ms"]), ["tcp", "tcp, held", "unix", "unix, held", "few bytes, held"])
        for bare in run["bare_ms"].values():
            self.assertLess(0, bare["p50"])
            self.assertLessEqual(bare["p50"], bare["p99"])
        for way in run["transports"]:
            for name in TIMES:
                self.assertLessEqual(way[name]["p50"], way[name]["p99"])
            self.assertLess(0, way["engine_ms"]["p50"])
            self.assertLess(way["engine_ms"]["p50"], way["latency_ms"]["p99"])
            for bare, ratio in (("tcp", "overhead_to_bare_tcp"), ("tcp, held", "overhead_to_held_tcp")):
                self.assertAlmostEqual(way[ratio], way["overhead_ms"]["p50"] / run["bare_ms"][bare]["p50"])

    def test_a_scene_as_it_is_and_in_the_sizes_asked_for(self):
        words = ["--scene", "funnel", "--scale", "0.2", "--steps", "4", "--warm-up", "1", "--kinds", "vt"]
        result = self.measure(*words, "--megabytes", "0.05,0.2")
        self.assertEqual((result["settings"]["kinds"], result["settings"]["warm_up"]), (["vt"], 1))
        runs = result["runs"]
        self.assertEqual([(run["scene"], run["frames"]) for run in runs], [("funnel", 4)] * 3)
        self.assertEqual(runs[0]["scale"], 0.2)
        for run, bytes_up in zip(runs[1:], (50e3, 200e3)):
            self.assertLess(abs(run["bytes_in"] - bytes_up), 0.2 * bytes_up)

    def test_discrete_frames_in_doubles(self):
        scene = ["--scene", "cloth_ball", "--scale", "0.1", "--position-format", "f64"]
        words = [*scene, "--mode", "dcd", "--thickness", "0.05"]
        run = self.measure(*words, "--steps", "2", "--warm-up", "0", "--megabytes", "0.02")["runs"][0]
        self.assertEqual((run["scene"], run["bytes_in"]), ("cloth_ball", 24 * run["vertices"]))
        self.assertGreater(run["bytes_out"], 0)

    def test_the_scale_is_that_of_the_scene_which_is_played_by_default(self):
        words = ["--scale", "0.1", "--steps", "1", "--warm-up", "0", "--megabytes", "0.02"]
        run = self.measure(*words)["runs"][0]
        self.assertEqual((run["scene"], run["scale"]), ("cloth_ball", 0.1))

    def test_bad_usage(self):
        whole = ["bench", "--end-to-end"]
        self.refused(2, "--server", *whole, "--server", "unix:/nonexistent/socket")
        self.refused(2, "--frames", *whole, "--frames", self.frame0, self.frame1)
        self.refused(2, "--end-to-end", "bench", "--scene", "funnel", "--megabytes", "1")
        self.refused(2, "one --scene", *whole, "--scene", "funnel,nbody")
        self.refused(2, "one --engine", *whole, "--engine", "octree,lbvh")
        for megabytes in ("0", "-1", "nan", "much", "1e9"):
            self.refused(2, "--megabytes", *whole, f"--megabytes={megabytes}")
        self.refused(1, "scale is", *whole, "--megabytes", "1000")


if __name__ == "__main__":
    support.main()
