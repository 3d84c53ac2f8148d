#!/usr/bin/env python3
"""The tables of tests/bench/FIGURES.md have the numbers of the results that they link to, and every result is described.

usage: figures_test.py REPOSITORY
"""

import fnmatch
import json
import pathlib
import re
import statistics
import subprocess
import sys
import unittest

REPOSITORY = pathlib.Path(sys.argv[1]).resolve()
BENCH = REPOSITORY / "tests" / "bench"
RESULTS = BENCH / "results"
from markdown import Page  # noqa: E402

FIGURES, DESCRIBED = Page(BENCH / "FIGURES.md"), Page(RESULTS / "README.md")
NOT_BROAD = re.compile("narrow_|order|upload|download")
NO_HEAD = {"2026-11-22-cpu-sorts.json"}  # as Google Benchmark writes it


def result(path):
    return json.loads((RESULTS / path).read_text())


def words_of(path):
    """What tests/bench/table prints of a result, as rows of cells."""
    printed = subprocess.run([sys.executable, BENCH / "table", RESULTS / path], capture_output=True, text=True, check=True)
    return {tuple(cell.strip() for cell in line.strip("|").split("|")) for line in printed.stdout.splitlines()
            if line.startswith("|")}


class Figures(unittest.TestCase):
    def expect(self, shown, value, where):
        """`shown` is the value, rounded to as many digits."""
        digits = len(shown.partition(".")[2])
        self.assertAlmostEqual(float(shown.replace(",", "")), value, delta=0.5000001 * 10**-digits, msg=where)

    def test_steps(self):
        frames = {"cloth_ball_92_93 (real frames)": "cloth_ball92 to cloth_ball93", "cloth_funnel_227_228 (real frames)": "227 to 228"}
        found = {(run["scene"], run["triangles"], run["steps"], run["engine"]): run
                 for run in result("steps/2026-11-22-h200-steps.json")["runs"]}
        for name, triangles, _, step, broad, lbvh in FIGURES.table("A step runs as one CUDA graph launch")[1:]:
            scene, _, steps = name.partition(", ")
            key = frames.get(scene, scene), int(triangles.replace(",", "")), int(steps.split()[0]) if steps else 50
            self.expect(step, found[*key, "octree"]["step_ms"]["median"], name)
            self.expect(broad, self.broad(found[*key, "octree"]), name)
            if lbvh:
                self.expect(lbvh, self.broad(found[*key, "lbvh"]), name)

    @staticmethod
    def broad(run):
        return sum(ms for stage, ms in run["stage_ms"].items() if not NOT_BROAD.match(stage))

    def test_many_streams(self):
        fastest, thousand = (result(f"load/2026-11-23-h200-{name}.json") for name in ("find-max", "load-1000"))
        shown = re.search(r"hold ([\d,]+)\nframes a second with a p99 below 5 ms \(([\d.]+)\), the daemon's engine taking "
                          r"([\d.]+) ms.* with a median of ([\d.]+) ms .* p99 of (\d+)\.", FIGURES.text, re.DOTALL).groups()
        self.assertAlmostEqual(int(shown[0].replace(",", "")), fastest["find_max"]["frames_per_second"], delta=50)
        self.expect(shown[1], fastest["latency_ms"]["p99"], "p99 of 8 streams")
        self.expect(shown[2], fastest["daemon_ms"]["engine"]["p50"], "engine")
        self.expect(shown[3], thousand["latency_ms"]["p50"], "median of 1,000 streams")
        self.expect(shown[4], thousand["latency_ms"]["p99"], "p99 of 1,000 streams")

    def test_throughput_against_streams(self):
        found, before = result("load/2026-11-26-h100-streams.json"), result("load/2026-11-23-h200-streams.json")
        small = {run["streams"]: run for run in found["runs"] if run["scene"] == "small"}
        large = {run["streams"]: run for run in before["runs"] if run["scene"] == "large"}
        alone, beside = found["mixed"]["alone"], found["mixed"]["beside_heavy"]
        text = FIGURES.text[FIGURES.text.index("## Many streams"):]
        for shown, value in ((r"get\n([\d,]+) frames", small[16]["frames_per_second"]),
                             (r"64 get ([\d,]+)\.", small[64]["frames_per_second"]),
                             (r"take ([\d.]+) ms alone", alone["p99_ms"]), (r"and ([\d.]+) beside", beside["p99_ms"]),
                             (r"takes ([\d,]+) frames", beside["heavy_frames_per_second"]),
                             (r"([\d,]+) later", large[32]["frames_per_second"])):
            self.expect(re.search(shown, text)[1], value, shown)

    def test_generations_of_scenes(self):
        runs = {(run["scenes"], run["commit"]): run["generations"] for run in result("load/2026-11-27-h200-generations.json")["runs"]}
        rows = FIGURES.table("| scenes, generation |")[1:]
        self.assertEqual(len(rows), 6)
        for name, *shown in rows:
            scenes, generation = int(name.split(",")[0]), ("first", "second", "third").index(name.split()[-1])
            for numbers, commit in ((shown[:3], "5d9d03ee"), (shown[3:], "ea66d98c")):
                for number, key in zip(numbers, ("p50_ms", "p99_ms", "max_ms")):
                    if number:
                        self.expect(number, runs[scenes, commit][generation][key], (name, key))

    def test_trials(self):
        runs = {(run["scene"], run["period"] > 0): run for run in result("steps/2026-11-27-h200-trials.json")["runs"]}
        rows = FIGURES.table("| scene | time | p95 |")[1:]
        self.assertEqual(len(rows), len(runs))
        for name, time, p95 in rows:
            run = runs[name.split(",")[0], "changing" in name]
            self.expect(time, run["time_ratio"], name)
            self.expect(p95, run["p95_ratio"], name)

    def test_before_and_after(self):
        rows = {row["row"]: row for row in result("steps/2026-11-23-h200-builds.json")["rows"]}
        shown = FIGURES.table("Two builds in turns")[1:]
        bounded = {f"streams, {streams} of 500 triangles" for streams in (4, 16, 48)}  # by the daemon's limit, as the page says
        self.assertEqual([row[0] for row in shown], [row for row in rows if row not in bounded])
        for name, *numbers in shown:
            for number, key in zip(numbers, ("before", "after", "ratio")):
                self.expect(number, rows[name][key], (name, key))

    def test_parts(self):
        rows = FIGURES.table("`slowest` the slowest part over")[1:]
        self.assertGreater(len(rows), 10)
        for scene, triangles, devices, *shown, _ in rows:
            if scene:
                runs = self.runs_in_parts(scene, int(triangles.replace(",", "")))
            self.expect_parts(shown, *runs[int(devices)], (scene, devices))

    def runs_in_parts(self, scene, triangles):
        """The run on one device and each in parts, by the number of devices."""
        for file in (RESULTS / "steps").glob("2026-11-26-h200-parts-*.json"):
            for found in json.loads(file.read_text())["scenes"]:
                if scene.startswith(found["scene"]) and found["triangles"] == triangles:
                    return {len(run["devices"]): (found["one"], run) for run in found["in_parts"]}
        self.fail(f"no file has {scene} of {triangles} triangles")

    def expect_parts(self, shown, one, run, where):
        self.assertTrue(run["same_bytes"])
        keys = ("step_ms", "speed_up", "wall_speed_up", "predicted_speed_up", "max_over_mean")
        for number, value in zip(shown, (one["step_ms"], *(run[key] for key in keys)), strict=True):
            self.expect(number, value, where)

    def test_placement(self):
        rates = {name: [run["frames_per_second"] for run in result(f"load/2026-11-26-h200-placement-{name}.json")["runs"]]
                 for name in ("four-20k", "four-500")}
        shown = re.search(r"they get ([\d,]+) frames a second on one GPU, ([\d,]+) on two \(([\d.]+)\ntimes\) and "
                          r"([\d,]+) on four \(([\d.]+) times\)", FIGURES.text).groups()
        one, two, four = map(statistics.median, rates["four-20k"])
        for number, value in zip(shown, (one, two, two / one, four, four / one)):
            self.expect(number, value, "400 streams")
        shown = re.search(r"64 streams get ([\d,]+) on one GPU, ([\d,]+) on two and ([\d,]+) on four", FIGURES.text).groups()
        for number, values in zip(shown, rates["four-500"]):
            self.expect(number, statistics.median(values), "64 streams")

    def test_sets_of_scenes(self):
        found = result("load/2026-11-23-h200-batch.json")
        lanes = ("shared_memory_in_place_ms", "shared_memory_ms", "grpc_stream_ms", "one_call_ms", "a_call_each_ms")
        for (way, shown), lane in zip(FIGURES.table("1,000 scenes of 500 triangles each")[1:], lanes, strict=True):
            self.expect(shown, found[lane]["p50"], way)

    def test_tests_of_engines(self):
        others, subdivided = (words_of(f"steps/{name}.json") for name in ("2026-11-21-engines-tests", "2026-11-23-vss-tests"))
        rows = FIGURES.table("| tests | octree |")[1:]
        self.assertGreater(len(rows), 10)
        for row in rows:
            self.assertIn(tuple(row[:-1]), others)
            self.assertIn((row[0], row[-1]), subdivided)

    def test_switches(self):
        self.expect_rows("commit 32be86c ([file](results/updates", "updates/2026-11-23-h200-switches.json")
        self.expect_rows("commit eb3e53a", "updates/2026-11-23-cpu-switches.json")

    def test_contacts_of_solvers(self):
        runs = {run["name"]: run for run in result("updates/2026-11-30-h200-switches-contacts.json")["runs"]}
        rows = FIGURES.table("commit 1a2aa5b0")[1:]
        self.assertEqual(len(rows), 6)
        for name, step, caller, contacts in rows:
            self.expect(step, runs[name]["step_ms"], name)
            self.expect(caller, runs[name]["caller_ms"], name)
            self.assertEqual(contacts, f"{runs[name]['contacts']:,}")

    def test_questions_about_solids(self):
        found = [{run["name"]: run for run in result(f"solids/2026-11-30-h200-solids{kind}.json")["runs"]}
                 for kind in ("", "-exact", "-million")]
        rows = FIGURES.table("| questions |")[1:]
        self.assertEqual([row[0] for row in rows], list(found[0]))
        for name, *shown in rows:
            times = [runs[name][time] for runs in found for time in ("stages_sum_ms", "caller_ms")]
            for number, time in zip(shown, times, strict=True):
                self.expect(number, time, name)

    def test_solids_beside_other_libraries(self):
        found = result("solids/2026-11-30-cpu-solids-peers.json")
        lanes = {f"{lane['library']}: {lane['name']}": lane for lane in found["lanes"]}
        wrong, balls = (FIGURES.table(f"| {title} |")[1:] for title in ("wrong, of small cases", "two balls"))
        self.assertEqual([[row[0] for row in rows] for rows in (wrong, balls)], [list(lanes)] * 2)
        for name, *shown in wrong:
            self.expect_counts(shown, lanes[name], ("inside", "on_surface", "depth", "depth_at_1e-5", "state", "deepest"))
        for name, *shown in balls:
            lane = lanes[name]["balls"]
            self.expect_counts(shown[:3], lane, ("inside", "depth", "depth_at_1e-5"))
            for number, time in zip(shown[3:], ("with_build", "again"), strict=True):
                self.assertEqual(bool(number), time in lane, name)
                if number:
                    self.expect(number, lane[time]["cpu_ms"], (name, time))

    def expect_counts(self, shown, counts, names):
        """Wrong answers, of how many; no cell for what is not asked."""
        self.assertEqual(shown, [f"{counts[name]['wrong']} of {counts[name]['of']:,}" if name in counts else "" for name in names])

    def expect_rows(self, after, path):
        rows, printed = FIGURES.table(after)[1:], words_of(path)
        self.assertGreater(len(rows), 10)
        for row in rows:
            self.assertIn(tuple(row), printed)

    def test_levels(self):
        columns = ("guarded", "certified", "exact", "certified earliest", "certified any")
        for positions, scene, *shown in FIGURES.table("The cost of the levels")[1:]:
            scenes = result(f"levels/2026-11-21-cpu-levels-{positions.lower()}.json")["scenes"]
            levels = {level["level"]: level for row in scenes if row["scene"] == scene for level in row["levels"]}
            for level, ratio in zip(columns, shown, strict=True):
                self.expect(ratio, levels[level]["total_ratio"], f"{positions} {scene} {level}")

    def test_whole_frames(self):
        for after, path in (("commit 504aaa8", "h200"), ("commit 2bdc9d4", "cpu")):
            runs = result(f"steps/2026-11-21-{path}-end-to-end.json")["runs"]
            for row, run in zip(FIGURES.table(after)[1:], runs, strict=True):
                lanes = {lane["transport"]: lane for lane in run["transports"]}
                self.expect(row[0].split()[0], run["bytes_up"] / 1e6, path)
                self.expect(row[1], lanes["grpc tcp"]["engine_ms"]["p50"], path)
                for shown, lane in zip(row[2:5], ("grpc tcp", "shared, copied", "shared, in place")):
                    self.expect_pair(shown, lanes[lane]["overhead_ms"]["p50"], lanes[lane]["overhead_to_held_tcp"])
                self.expect(row[5], run["bare_ms"]["tcp, held"]["p50"], path)
                self.expect(row[6], run["bare_ms"]["few bytes, held"]["p50"], path)

    def expect_pair(self, shown, first, second):
        self.expect(shown.split()[0], first, shown)
        self.expect(shown.split()[1].strip("()"), second, shown)

    def test_in_process(self):
        runs = result("steps/2026-11-23-cpu-in-process.json")["runs"]
        for row, run in zip(FIGURES.table("of an engine in the client's own process")[1:], runs, strict=True):
            lanes = {lane["name"]: lane for lane in run["transports"]}
            self.expect(row[0], run["triangles"], "triangles")
            self.expect(row[3], lanes["shared_memory"]["beside_engine_ms"]["p50"], "shared memory")
            for shown, name in ((row[2], "grpc"), (row[4], "in_process")):
                self.expect_pair(shown, lanes[name]["beside_engine_ms"]["p50"], lanes[name]["ratio_to_shared_memory"]["p50"])

    def test_device(self):
        runs = result("steps/2026-11-23-h200-device.json")["runs"]
        lanes = ("device to device", "device to device, client polls", "device to host", "host to host")
        for row, run in zip(FIGURES.table("A simulator on the daemon's GPU can leave")[1:], runs, strict=True):
            found = {lane["lane"]: lane for lane in run["lanes"]}
            self.expect(row[1], run["triangles"], "triangles")
            self.expect(row[3], found["device to device, client polls"]["step_ms"]["p50"], row[0])
            for shown, lane in zip(row[4:], lanes, strict=True):
                self.expect(shown, found[lane]["over_step_ms"]["p50"], f"{row[0]}, {lane}")


class Results(unittest.TestCase):
    def test_each_has_its_date_and_its_commit(self):
        files = sorted(RESULTS.glob("*/*.json"))
        self.assertGreater(len(files), 30)
        for file in files:
            if file.name not in NO_HEAD:
                head = json.loads(file.read_text())
                self.assertEqual(head["date"], file.name[:10], file.name)
                self.assertRegex(head["commit"], "^[0-9a-f]{7}", file.name)

    def test_each_is_described(self):
        patterns = [name for row in DESCRIBED.table("| files |")[1:] for name in re.findall(r"`([^`]*)`", row[0] + row[2])]
        for file in sorted(RESULTS.glob("*/*")):
            name = file.name[len("2026-11-23-"):]
            self.assertTrue(any(fnmatch.fnmatch(name, pattern) for pattern in patterns), file.name)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
