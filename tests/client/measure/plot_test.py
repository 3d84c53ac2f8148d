#!/usr/bin/env python3
"""client/measure/plot: its pictures show the data, and data that cannot be drawn are reported.

usage: plot_test.py REPOSITORY
"""

import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree

REPOSITORY = pathlib.Path(sys.argv[1]).resolve()
PLOT = REPOSITORY / "client" / "measure" / "plot"
RESULTS = REPOSITORY / "tests" / "bench" / "results"
FUNNEL = RESULTS / "tradeoff" / "2026-11-21-h200-tradeoff-funnel.json"
NBODY = RESULTS / "tradeoff" / "2026-11-21-h200-tradeoff-nbody.json"
SVG = "{http://www.w3.org/2000/svg}"


def run_python(*words):
    return subprocess.run([sys.executable, *map(str, words)], capture_output=True, text=True, timeout=120)


class PlotTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def put(self, name, content):
        path = self.folder / name
        path.write_text(content if isinstance(content, str) else json.dumps(content))
        return path

    def draw(self, *results, out="pictures", picture_format="svg"):
        """The pictures by name."""
        done = run_python(PLOT, *results, "--out", self.folder / out, "--format", picture_format)
        self.assertEqual(done.returncode, 0, done.stderr)
        paths = [pathlib.Path(line) for line in done.stdout.splitlines()]
        self.assertEqual(sorted(paths), sorted((self.folder / out).iterdir()))
        return {path.stem: path for path in paths}

    def refused(self, exit_code, part, *words):
        done = run_python(PLOT, *words, "--out", self.folder / "none")
        self.assertEqual(done.returncode, exit_code, done.stdout + done.stderr)
        self.assertIn(part, done.stderr)
        self.assertNotIn("Traceback", done.stderr)
        self.assertFalse((self.folder / "none").exists())


class Svg:
    def __init__(self, path):
        self.root = xml.etree.ElementTree.parse(path).getroot()

    def texts(self):
        return ["".join(text.itertext()).strip() for text in self.root.iter(f"{SVG}text")]

    def points(self, series):
        """Where the markers of a series are, in its order; y grows downward."""
        (group,) = [group for group in self.root.iter(f"{SVG}g") if group.get("id") == series]
        return [(float(use.get("x")), float(use.get("y"))) for use in group.iter(f"{SVG}use")]

    def series(self):
        ids = [group.get("id") or "" for group in self.root.iter(f"{SVG}g")]
        return [name for name in ids if re.match(r"row\d", name)]


def by_series(result):
    series = {}
    for run in result["runs"]:
        series.setdefault(f"{run['level']}.{run['position_format']}", []).append(run)
    return series


def panel_points(svg, row, panel, result, value):
    """(x, y of the picture, milliseconds, value) of all runs."""
    return [(*point, run["median_ms"]["narrow"], value(run)) for name, runs in by_series(result).items()
            for point, run in zip(svg.points(f"{row}.{panel}.{name}"), runs, strict=True)]


class Tradeoffs(PlotTest):
    VALUES = {"missed": lambda run: run["contacts"]["sum"]["missed"],
              "false": lambda run: run["contacts"]["sum"]["false"],
              "early": lambda run: max(0, run["contacts"]["toi_gap"]["p99"])}

    @classmethod
    def setUpClass(cls):
        cls.results = [json.loads(path.read_text()) for path in (FUNNEL, NBODY)]
        with tempfile.TemporaryDirectory() as folder:
            run_python(PLOT, FUNNEL, NBODY, "--out", folder, "--format", "svg").check_returncode()
            cls.svg = Svg(pathlib.Path(folder) / "tradeoff.svg")

    def test_each_run_is_a_point_of_each_panel_of_its_results_row(self):
        expected = [f"row{row}.{panel}.{name}" for row, result in enumerate(self.results)
                    for panel in self.VALUES for name in by_series(result)]
        self.assertEqual(sorted(self.svg.series()), sorted(expected))
        for row, result in enumerate(self.results):
            for panel, value in self.VALUES.items():
                points = panel_points(self.svg, f"row{row}", panel, result, value)
                self.assertEqual(len(points), len(result["runs"]))

    def test_points_are_where_the_data_puts_them(self):
        for row, result in enumerate(self.results):
            for panel, value in self.VALUES.items():
                with self.subTest(row=row, panel=panel):
                    points = panel_points(self.svg, f"row{row}", panel, result, value)
                    self.check_on_logarithm([(x, ms) for x, _, ms, _ in points], sign=1)
                    self.check_on_logarithm([(y, v) for _, y, _, v in points if v > 0], sign=-1)
                    zeros = {y for _, y, _, v in points if v == 0}
                    self.assertLessEqual(len(zeros), 1)
                    self.assertTrue(all(zero > y for zero in zeros for _, y, _, v in points if v > 0))

    def check_on_logarithm(self, places, sign):
        """Places are a linear function of their values' logarithms, rising or falling by `sign`."""
        values = sorted(places, key=lambda place: place[1])
        if len({value for _, value in values}) < 2:
            return
        (low, first), (high, last) = values[0], values[-1]
        slope = (high - low) / math.log(last / first)
        self.assertGreater(sign * slope, 0)
        for place, value in places:
            self.assertAlmostEqual(place, low + slope * math.log(value / first), delta=0.01)

    def test_its_words_are_those_of_the_data(self):
        texts = self.svg.texts()
        for text in ("funnel: 18,504 triangles, NVIDIA H200", "nbody: 146,000 triangles, NVIDIA H200",
                     "fast", "guarded", "certified", "exact", "1e-3", "1e-5", "auto",
                     "78 late", "51 late", "1,572 late", "675 late"):
            self.assertIn(text, texts)
        self.assertEqual(texts.count("Missed contacts"), 2)

    def test_another_number_moves_its_point_alone(self):
        changed = json.loads(FUNNEL.read_text())
        self.assertEqual(changed["runs"][0]["level"], "fast")
        changed["runs"][0]["contacts"]["sum"]["missed"] += 3
        before = Svg(self.draw(FUNNEL, out="before")["tradeoff"])
        after = Svg(self.draw(self.put("changed.json", changed), out="after")["tradeoff"])
        moved = [name for name in before.series() if before.points(name) != after.points(name)]
        self.assertEqual(moved, ["row0.missed.fast.f32"])

    def test_a_result_without_contacts_and_times_is_drawn(self):
        result = json.loads(FUNNEL.read_text())
        for run in result["runs"]:
            run["contacts"]["sum"] = dict.fromkeys(run["contacts"]["sum"], 0)
            run["contacts"]["toi_gap"] = None
            run["median_ms"]["narrow"] = 0
        svg = Svg(self.draw(self.put("empty.json", result))["tradeoff"])
        self.assertEqual(len(svg.series()), 3 * len(by_series(result)))


class Steps(PlotTest):
    def test_stages_tests_and_sizes_have_a_picture_each(self):
        path = RESULTS / "steps" / "2026-11-22-h200-steps.json"
        sheets = next(run for run in json.loads(path.read_text())["runs"]
                      if run["scene"] == "graded_sheets" and run["engine"] == "octree")["stage_ms"]
        # The kinds' narrow phases run side by side, and transfers are no part of a step.
        step = sum(ms for stage, ms in sheets.items() if not stage.startswith("narrow") and stage[-4:] != "load")
        step += max(sheets["narrow_vt"], sheets["narrow_ee"])
        pictures = self.draw(path)
        self.assertEqual(sorted(pictures), ["scale", "stages", "tests"])
        texts = Svg(pictures["stages"]).texts()
        for text in ("NVIDIA H200, engine octree", "graded_sheets", "180,000 triangles", "narrow phase", f"{step:.3g}"):
            self.assertIn(text, texts)
        texts = Svg(pictures["tests"]).texts()
        for text in ("one_cell", "octree", "lbvh"):
            self.assertIn(text, texts)
        self.assertIn("cloth_ball, octree", Svg(pictures["scale"]).texts())

    def test_files_of_one_kind_go_into_one_picture(self):
        runs = json.loads((RESULTS / "steps" / "2026-11-22-h200-steps.json").read_text())
        halves = [self.put(f"{half}.json", {"device": runs["device"], "runs": runs["runs"][half::2]})
                  for half in (0, 1)]
        texts = Svg(self.draw(*halves, FUNNEL)["tests"]).texts()
        for scene in {run["scene"] for run in runs["runs"]}:
            self.assertIn(scene, texts)
        self.assertTrue((self.folder / "pictures" / "tradeoff.svg").exists())

    def test_simulations_have_a_panel_each(self):
        texts = Svg(self.draw(RESULTS / "stepping" / "2026-11-22-h200-advance.json")["advance"]).texts()
        for name in ("cloth_on_sphere", "sheets", "soft_boxes", "box_stack", "knot"):
            self.assertIn(f"{name}: 0 pairs of triangles met", texts)

    def test_streams_have_a_line_for_each_scene(self):
        runs = [{"scene": scene, "streams": streams, "triangles": 500, "frames_per_second": 1000.0 * streams,
                 "p50_ms": 1.0, "p99_ms": 2.0} for scene in ("small", "large") for streams in (1, 4)]
        result = {"format": "collided streams 1", "device": "a device", "runs": runs}
        words = Svg(self.draw(self.put("streams.json", result))["streams"]).texts()
        self.assertIn("small: 500 triangles", words)
        self.assertIn("large: 500 triangles", words)
        del runs[3]["p99_ms"]
        self.refused(1, "'p99_ms' is missing", self.put("streams.json", result))

    def test_overload_has_a_line_for_each_delivery(self):
        rates = [{"delivery": delivery, "fraction": fraction, "answered_per_second": 100.0 * fraction, "latency_p99_ms": 2.0,
                  "service_p99_ms": 1.0} for delivery in ("lossless", "latest-wins") for fraction in (0.5, 1, 2)]
        result = {"format": "collided overload 1", "device": "a device", "p99_ms": 20.0, "highest_per_second": 100.0, "rates": rates}
        words = Svg(self.draw(self.put("overload.json", result))["overload"]).texts()
        self.assertIn("lossless, a device", words)
        self.assertIn("latest-wins, a device", words)
        rates[0]["service_p99_ms"] = -1.0
        self.refused(1, "-1.0 is less than 0", self.put("overload.json", result))

    def test_one_picture_shows_one_device(self):
        run = {"scene": "funnel", "engine": "octree", "triangles": 1, "counts": {"tests": 1}}
        other = self.put("other.json", {"device": "CPU", "runs": [run]})
        self.refused(1, "the results are of CPU and NVIDIA H200", other, RESULTS / "steps" / "2026-11-22-h200-steps.json")


class Files(PlotTest):
    def test_the_same_result_gives_the_same_bytes(self):
        for picture_format in ("svg", "png"):
            first, again = (self.draw(FUNNEL, out=f"{out}-{picture_format}", picture_format=picture_format)["tradeoff"]
                            for out in ("first", "again"))
            self.assertEqual(first.read_bytes(), again.read_bytes())
        self.assertEqual(first.read_bytes()[:8], b"\x89PNG\r\n\x1a\n")

    def test_what_is_no_result_is_named(self):
        self.refused(1, "none.json", "none.json")
        self.refused(1, "a.json: is not JSON", self.put("a.json", "{"))
        for content in ([], {}, 3, {"scenes": []}):
            self.refused(1, "b.json: is not a measurement result: it has no 'runs'", self.put("b.json", content))
        other_format = self.put("c.json", {"format": "collided tradeoff 2", "runs": []})
        self.refused(1, "'collided tradeoff 2' is not one of", other_format)
        self.refused(1, "the results hold nothing", self.put("d.json", {"device": "CPU", "runs": []}))

    def test_a_bad_field_is_named(self):
        for change, part in ((lambda run: run.pop("median_ms"), "'median_ms' is missing"),
                             (lambda run: run.update(level="perfect"), "'perfect' is not one of fast, guarded"),
                             (lambda run: run["contacts"]["sum"].update(missed="many"), "'many' is not a finite"),
                             (lambda run: run["median_ms"].update(narrow=math.nan), "nan is not a finite number"),
                             (lambda run: run["median_ms"].update(narrow=-1), "-1 is less than 0"),
                             (lambda run: run["contacts"]["toi_gap"].update(worst=math.inf), "inf is not a finite"),
                             (lambda run: run.update(contacts=None), "is not a measurement result")):
            result = json.loads(FUNNEL.read_text())
            change(result["runs"][2])
            self.refused(1, part, FUNNEL, self.put("bad.json", result))
        result["runs"] = []
        self.refused(1, "bad.json: is not a measurement result: it has no runs", self.put("bad.json", result))

    def test_bad_usage_and_help(self):
        self.refused(2, "RESULT")
        self.refused(2, "--format", FUNNEL, "--format", "gif")
        done = run_python(PLOT, "--help")
        self.assertEqual((done.returncode, done.stdout.split()[:2]), (0, ["usage:", "plot"]))

    def test_without_matplotlib_it_tells_how_to_get_it(self):
        done = run_python("-S", PLOT, FUNNEL, "--out", self.folder)  # -S: no installed packages
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertEqual(done.stderr,
                         "plot: matplotlib is not installed (Debian: apt-get install python3-matplotlib)\n")


if __name__ == "__main__":
    if run_python("-c", "import matplotlib").returncode != 0:
        print("skipped: matplotlib is not installed (Debian: python3-matplotlib)")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1], verbosity=2)
