#!/usr/bin/env python3
"""The figures of deploy/CAPACITY.md are those of the results that it links to, and its example is what collidectl tells.

usage: capacity_test.py DAEMON COLLIDECTL REPOSITORY
"""

import json
import math
import os
import pathlib
import re
import shlex
import subprocess
import sys
import unittest

DAEMON, COLLIDECTL = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
REPOSITORY = pathlib.Path(sys.argv[3]).resolve()
from markdown import Page  # noqa: E402

DEPLOY = REPOSITORY / "deploy"
PAGE = Page(DEPLOY / "CAPACITY.md")
FLAT = " ".join(PAGE.text.split())


def result(path):
    return json.loads((REPOSITORY / "tests" / "bench" / "results" / path).read_text())


def number(shown):
    return float(shown.replace(",", ""))


class Figures(unittest.TestCase):
    def expect(self, shown, value, where):
        """`shown` is the value, rounded to as many digits."""
        self.assertAlmostEqual(number(shown), value, delta=0.5000001 * 10 ** -len(shown.partition(".")[2]), msg=where)

    def expect_row(self, shown, values, where):
        for cell, value in zip(shown, values, strict=True):
            self.expect(cell, value, where)

    def told(self, pattern):
        found = re.search(pattern, FLAT)
        self.assertTrue(found, pattern)
        return found.groups()


class Capacity(Figures):
    def test_each_file_is_named_with_its_commit(self):
        links = set(re.findall(r"\]\((\.\./tests/bench/results/[^)]*)\)", PAGE.text))
        self.assertEqual(len(links), 13)
        for link in links:
            head = json.loads((DEPLOY / link).read_text())
            self.assertIn("commit " + head["commit"], FLAT, link)

    def test_streams(self):
        runs = {(gpu, run["triangles"], run["streams"]): run for gpu, file in (("H100", "2026-11-26-h100"), ("H200", "2026-11-23-h200"))
                for run in result(f"load/{file}-streams.json")["runs"]}
        for gpu, triangles, *shown in PAGE.table("Frames a second over gRPC")[1:]:
            of = {streams: runs[gpu, int(number(triangles)), streams] for streams in (1, 8, 64)}
            rates = [of[streams]["frames_per_second"] for streams in (1, 8, 64)]
            self.expect_row(shown, [*rates, of[8]["p99_ms"], 1000 / rates[1]], triangles)

    def test_sets_and_a_thousand_streams(self):
        frame = result("load/2026-11-23-h200-batch.json")["shared_memory_in_place_ms"]["p50"]
        self.expect_row(self.told(r"each take ([\d.]+) ms through shared memory, ([\d,]+) frames"), (frame, 1e6 / frame), "set")
        thousand = result("load/2026-11-23-h200-load-1000.json")
        self.expect_row(self.told(r"each, ([\d,]+) triangles, had a median of ([\d.]+) ms and a p99 of ([\d.]+)"),
                        (thousand["input"]["scene"]["triangles"], *(thousand["latency_ms"][p] for p in ("p50", "p99"))), "1,000")

    def test_steps(self):
        runs = {(run["scene"], run["engine"], run["triangles"], run["steps"]): run
                for run in result("steps/2026-11-23-h200-steps.json")["runs"]}
        for name, engine, triangles, *shown in PAGE.table("Steps a second of one scene")[1:]:
            scene, _, steps = name.replace(" (real cloth)", "").partition(", ")
            run = runs[scene, engine, int(number(triangles)), int(steps.split()[0]) if steps else 50]
            held = run["device_bytes"]
            self.expect_row(shown, [1000 / run["step_ms"]["median"], held / 1e6, held / run["triangles"], 1e11 // held], name)
        touching = runs["touching_boxes", "auto", 20736, 50]
        self.expect(*self.told(r"holds ([\d,]+) bytes a triangle\."), touching["device_bytes"] / touching["triangles"], "touching")

    def test_cores(self):
        found = {}
        for run in result("steps/2026-11-23-cpu-in-process.json")["runs"]:
            found[run["triangles"], 1] = next(t["whole_ms"] for t in run["transports"] if t["name"] == "shared_memory")
        for run in result("steps/2026-11-21-cpu-end-to-end.json")["runs"]:
            found[run["triangles"], 2] = next(t["latency_ms"]["p50"] for t in run["transports"]
                                              if t["transport"] == "shared, in place")
        rows = PAGE.table("## A core")[1:]
        self.assertEqual(len(rows), len(found))
        for triangles, threads, shown in rows:
            self.expect(shown, 1000 / found[int(number(triangles)), int(threads)], triangles)

    def test_levels(self):
        cpu = {run["accuracy"]: run for run in result("levels/2026-11-23-cpu-level-memory.json")["runs"]}
        for level, on_cpu, single, double in PAGE.table("## Memory by level")[1:]:
            run = cpu.pop(level.lower())
            self.expect(on_cpu, run["device_bytes"] / run["triangles"], level)
            for shown, scalar in ((single, "f32"), (double, "f64")):
                if shown:
                    self.expect(shown, self.on_h200(level.lower(), scalar), level)
        self.assertEqual(cpu, {})

    @staticmethod
    def on_h200(level, scalar):
        scenes = result(f"steps/2026-11-22-h200-ccd-{level}-{scalar}.json")["scenes"]
        scene = next(scene for scene in scenes if scene["scene"] == "cloth_ball")
        return scene["device_bytes"] / scene["triangles"]

    def test_positions(self):
        runs = {run["name"]: run["bytes_in"] for run in result("updates/2026-11-23-h200-switches.json")["runs"]}
        for name, *shown in PAGE.table("Bytes of positions in a frame")[1:]:
            sent = runs["full model" if name == "F32" else name]
            self.expect_row(shown, [sent, sent / 46363, sent * 60 * 8e-9], name)

    def test_transports(self):
        runs = result("steps/2026-11-21-h200-end-to-end.json")["runs"]
        lanes = ("grpc tcp", "grpc unix", "shared, copied", "shared, in place")
        for shown, run in zip(PAGE.table("Both ways, and what a frame takes")[1:], runs, strict=True):
            found = {lane["transport"]: lane for lane in run["transports"]}
            whole = [found[lane]["latency_ms"]["p50"] for lane in lanes]
            self.expect_row(shown, [run["bytes_up"], run["bytes_down"], found["grpc tcp"]["engine_ms"]["p50"], *whole], shown)

    def test_waits(self):
        shares = self.told(r"([\d.]+) times at 0\.7, ([\d.]+) at 0\.9 and ([\d.]+) at 0\.95")
        self.expect_row(shares, [u / (2 * (1 - u)) for u in (0.7, 0.9, 0.95)], "waits")


class Example(Figures):
    def setUp(self):
        command, self.verdict = PAGE.blocks(after="## An example")
        words = shlex.split(command)
        self.assertEqual(words[0], "collidectl")
        self.words = [COLLIDECTL, *words[1:], "--backend", "cpu", "--threads", "1"]

    def run_it(self, *more):
        env = {**os.environ, "COLLIDED_DAEMON": str(DAEMON)}
        return subprocess.run([*self.words, *more], capture_output=True, text=True, env=env, timeout=120, check=True).stdout

    def test_the_verdict_is_printed(self):
        self.assertIn("\n" + self.verdict, self.run_it())

    def test_the_table_follows_the_formula(self):
        told = json.loads(self.run_it("--json"))
        runs = result("steps/2026-11-23-h200-steps.json")["runs"]
        knot = next(run for run in runs if (run["scene"], run["engine"]) == ("reef_knot", "auto"))
        gigabits = told["network"]["gigabits_in_per_second"] / told["workload"]["scenes"]
        each = {"memory": (told["usable_bytes"] / 1e9, knot["device_bytes"] / 1e6, told["usable_bytes"] // knot["device_bytes"]),
                "time": (700, 60 * 0.0995, told["scenes_per_device"]["time"]),
                "network": (17.5, gigabits, told["scenes_per_device"]["network"])}
        for name, *cells in PAGE.table("| | of a GPU |")[1:]:
            self.expect_row([cell.split()[0] for cell in cells], each[name], name)
        self.assertEqual(each["time"][2], math.floor(700 / (60 * 0.0995)))
        self.assertEqual(each["network"][2], math.floor(17.5 / gigabits))
        self.assertEqual(told["contact_bytes"]["vertex_triangle"], int(*self.told(r"A contact takes (\d+) bytes")))

    def test_the_cost_follows_the_formula(self):
        price, cost, frames, million = map(number, self.told(
            r"At ([\d.]+) an hour for a GPU, two cost ([\d.]+) an hour, and a million of the ([\d,]+) frames a second cost ([\d.]+)\."))
        self.assertEqual((cost, frames), (2 * price, 200 * 60))
        self.assertAlmostEqual(million, cost / (3600 * frames) * 1e6, delta=0.0005)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
