"""collidectl load: counts, percentiles and refusals against real daemons, one of which stands still for two seconds.

Usage: load_test.py COLLIDECTL DAEMON"""

import contextlib
import datetime
import json
import os
import re
import signal
import socket
import subprocess
import time
import urllib.request

import support
from support import COLLIDECTL, DAEMON, ONE_CPU

SMALL = ["--scene", "reef_knot", "--scale", "0.1", "--steps", "8"]
PATIENT = ["--drain-seconds", "120"]  # every frame is answered, however busy the machine is
STANDSTILL = 2.0  # seconds


class LoadTest(support.CollidectlTest):
    @contextlib.contextmanager
    def loaded_daemon(self, *options):
        """A daemon with metrics: its process and the words that make collidectl use it."""
        log, path = (os.path.join(self.folder.name, name) for name in ("log", "socket"))
        words = [DAEMON, "--address", "unix:" + path, "--backend", "cpu", "--threads", "1", "--http-address",
                 "127.0.0.1:0", *options]
        with open(log, "w", encoding="utf-8") as file, subprocess.Popen(words, stderr=file) as daemon:
            try:
                yield daemon, ["--server", "unix:" + path, "--metrics-url", self.metrics_url(daemon, log)]
            finally:
                daemon.send_signal(signal.SIGCONT)
                daemon.terminate()

    def metrics_url(self, daemon, log):
        while daemon.poll() is None:
            with open(log, encoding="utf-8") as file:
                found = re.search(r"metrics and health on (\S+)", file.read())
            if found:
                return f"http://{found[1]}/metrics"
            time.sleep(0.01)
        self.fail("the daemon has ended")

    def load(self, *words):
        return json.loads(self.ok("load", *SMALL, *PATIENT, *words, "--json"))

    def check_times(self, times):
        values = [times[name] for name in ("min", "p50", "p90", "p95", "p99", "p99.9", "p99.99", "max")]
        self.assertEqual(values, sorted(values))
        self.assertGreater(values[0], 0)


class Runs(LoadTest):
    def test_generations_run_on_new_scenes_of_the_same_daemon(self):
        with self.loaded_daemon("--max-scenes", "4", "--max-scenes-per-client", "4") as (_, server):  # those of the run before are gone
            words = ["--clients", "2", "--scenes", "2", "--rate", "10", "--seconds", "0.5", "--warm-up", "0",
                     "--generations", "3", *server]
            result = self.load(*words)
            text = self.ok("load", *SMALL, *PATIENT, *words)
            with urllib.request.urlopen(server[-1]) as page:
                frames = int(re.search(r"^collided_frames_total (\d+)", page.read().decode(), re.M)[1])
        self.assertEqual([run["answered"] for run in result["generations"]], [20] * 3)
        self.assertEqual(frames, 2 * 3 * 20)
        for run in result["generations"]:
            self.assertGreater(run["setup_seconds"], 0)
            self.assertTrue(0 < run["p50_ms"] <= run["p99_ms"] <= run["max_ms"])
        self.assertEqual(result["latency_ms"]["max"], result["generations"][-1]["max_ms"])
        self.assertRegex(text, r"generation of scenes +setup s(?s:.*)\n3 +\d")
        self.refused(2, "--generations", "load", *SMALL, "--find-max", "--p99", "1s", "--generations", "2")

    def test_an_open_loop_sends_what_is_due_and_agrees_with_the_daemon(self):
        out, html = (os.path.join(self.folder.name, name) for name in ("load.json", "load.html"))
        with self.loaded_daemon() as (_, server):
            words = [*SMALL, *PATIENT, "--clients", "3", "--scenes", "2", "--rate", "20", "--seconds", "1.5", *server]
            text = self.ok("load", *words, "--out", out, "--html", html)
            url = server[-1]
            with urllib.request.urlopen(url) as page:
                frames = int(re.search(r"^collided_frames_total (\d+)", page.read().decode(), re.M)[1])
        with open(out, encoding="utf-8") as file:
            result = json.load(file)
        self.assertEqual(result["frames"], {"due": 180, "sent": 180, "answered": 180, "skipped": 0, "refused": 0,
                                            "unanswered": 0, "unsent": 0})
        self.assertEqual(frames, 180 + 6 * 5, "and five of each stream's warm-up")
        comparison = result["comparison"]
        self.assertEqual(comparison["answered"], {"tester": 180, "daemon": 180})
        self.assertLess(comparison["max_difference_percent"], 1)
        self.assertEqual(result["daemon_counters"]["answered"], 180)
        for times in (result["latency_ms"], result["service_ms"], result["daemon_ms"]["total"]):
            self.check_times(times)
            self.assertEqual(times["count"], 180)
        version = json.loads(self.ok("info", *ONE_CPU, "--json"))["version"]
        self.assertEqual((result["version"], result["host"], result["device"]), (version, socket.gethostname(), "CPU, 1 threads"))
        ended = datetime.datetime.strptime(result["date"], "%Y-%m-%dT%H:%M:%SZ").replace(tzinfo=datetime.timezone.utc)
        self.assertLess(abs((datetime.datetime.now(datetime.timezone.utc) - ended).total_seconds()), 120)
        self.assertGreater(result["tester"]["cpu_ms_per_frame"], 0)
        self.assertEqual(sum(second["answered"] for second in result["series"]), 180)
        said = f"collided {version} on CPU, 1 threads, tested from {socket.gethostname()}, {result['date']}"
        for part in (said, "6 streams (3 clients, 2 scenes each) on 6 connections", "open loop, fixed arrivals",
                     "180 answered", "ms of CPU a frame"):
            self.assertIn(part, text)
        with open(html, encoding="utf-8") as file:
            page = file.read()
        self.assertIn("<svg", page)
        self.assertIn(said, page)
        self.assertNotIn("http", page)

    def test_its_own_daemon_lets_all_streams_in(self):
        result = self.load(*ONE_CPU, "--clients", "200", "--shared-connections", "--rate", "1", "--seconds", "1",
                           "--warm-up", "1", "--workers", "2")
        self.assertEqual(result["load"]["streams"], 200)
        self.assertEqual(result["frames"]["answered"], 200)
        self.assertEqual(result["comparison"]["answered"], {"tester": 200, "daemon": 200})
        self.assertEqual(result["tester"]["threads"], 4, "not one for each stream")

    def test_poisson_arrivals_and_a_ramp(self):
        words = [*ONE_CPU, "--clients", "2", "--ramp", "0:100:1,100:100:0.2", "--arrivals", "poisson"]
        first, same = self.load(*words, "--seed", "7"), self.load(*words, "--seed", "7")
        self.assertEqual(first["frames"]["due"], same["frames"]["due"])
        self.assertEqual(first["load"]["arrivals"], "poisson")
        self.assertTrue(60 < first["frames"]["answered"] < 220, first["frames"])  # 140, with a deviation of 12

    def test_a_closed_loop_over_recorded_frames(self):
        recorded = os.path.join(self.folder.name, "recorded")
        self.ok("export", "--scene", "reef_knot", "--scale", "0.1", "--frames", "4", "--out", recorded)
        files = sorted(os.path.join(recorded, name) for name in os.listdir(recorded))
        words = ["--frames", *reversed(files), "--closed-loop", "--seconds", "0.5", "--window", "3", "--json", *ONE_CPU]
        result = json.loads(self.ok("load", *PATIENT, *words))
        self.assertEqual(result["load"]["loop"], "closed")
        self.assertGreater(result["frames"]["answered"], 0)
        self.assertEqual(result["frames"]["sent"], result["frames"]["answered"])
        self.assertEqual(result["input"]["name"], f"4 recorded frames from {files[0]}", "in natural order")

    def test_the_highest_rate_is_found(self):
        words = ["--find-max", "--p99", "10s", "--from", "20", "--trial-seconds", "0.2", "--precision", "1"]
        with self.loaded_daemon("--max-frames-per-second", "60") as (_, server):
            result = self.load(*words, *server)
        trials = result["find_max"]["trials"]
        self.assertEqual([trial["frames_per_second"] for trial in trials[:2]], [20, 40])
        self.assertTrue(trials[0]["held"])
        self.assertFalse(trials[-1]["held"])
        self.assertIn("refused", trials[-1]["failure"])
        self.assertGreaterEqual(result["find_max"]["frames_per_second"], 20)


    def test_a_result_that_cannot_be_written_is_told(self):
        words = ["load", *SMALL, "--rate", "20", "--seconds", "0.2", *ONE_CPU, "--json", "--out", "/dev/full"]
        done = support.ctl(*words)
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("/dev/full: cannot be written: No space left", done.stderr)
        self.assertEqual(json.loads(done.stdout)["frames"]["due"], 4)


class Refusals(LoadTest):
    def test_refused_frames_are_counted_by_reason(self):
        with self.loaded_daemon("--max-frames-per-second", "20") as (_, server):
            result = self.load("--rate", "500", "--seconds", "1", *server)
        refused = result["refused"]["RESOURCE_EXHAUSTED"]
        self.assertGreater(refused["count"], 0, "unless 500 frames took 25 seconds")
        self.assertIn("max_frames_per_second is 20", refused["first"])
        self.assertEqual(refused["count"] + result["frames"]["answered"], 500)
        self.assertEqual(result["comparison"]["refused RESOURCE_EXHAUSTED"]["daemon"], refused["count"])

    def test_skipped_frames_are_counted(self):
        words = ["--delivery", "latest-wins", "--window", "8", "--closed-loop", "--seconds", "0.5"]
        with self.loaded_daemon() as (_, server):
            result = self.load(*words, *server)
        self.assertGreater(result["frames"]["skipped"], 0)
        self.assertEqual(result["comparison"]["skipped"]["daemon"], result["frames"]["skipped"])

    def test_a_daemon_whose_limits_are_too_low_is_not_loaded(self):
        with self.loaded_daemon() as (_, server):
            words = ["load", *SMALL, "--clients", "300", "--rate", "1", *server]
            self.refused(1, "--max-scenes 64, --max-scenes-per-client 16, --max-streams 256", *words)
            self.refused(1, "start it with --max-scenes 300", *words)

    def test_metrics_that_are_not_there_are_told_before_the_work(self):
        with self.daemon() as address:
            words = ["load", *SMALL, "--rate", "1", "--server", address, "--metrics-url"]
            self.refused(1, "no metrics from http://127.0.0.1:1/metrics", *words, "127.0.0.1:1")
            self.refused(2, "--metrics-url", *words, "https://127.0.0.1:1/metrics")

    def test_bad_options(self):
        self.refused(2, "one of --rate, --ramp, --closed-loop and --find-max", "load", *SMALL)
        self.refused(2, "one of --rate, --ramp, --closed-loop and --find-max", "load", *SMALL, "--rate", "1",
                     "--closed-loop")
        self.refused(2, "one of --scene and --frames", "load", "--rate", "1")
        self.refused(2, "FROM:TO:SECONDS", "load", *SMALL, "--ramp", "10")
        self.refused(2, "--seconds", "load", *SMALL, "--ramp", "1:2:3", "--seconds", "3")
        self.refused(2, "--find-max and --p99", "load", *SMALL, "--find-max")
        self.refused(2, "--find-max and --p99", "load", *SMALL, "--rate", "1", "--p99", "5ms")
        for bound in ("5 apples", "5", "ms", "", "1e999s"):
            self.refused(2, "--p99", "load", *SMALL, "--find-max", f"--p99={bound}")
        for bound in ("-5ms", "0s", "nanms", "infs"):
            self.refused(2, f"--p99: '{bound}' is not a time greater than 0", "load", *SMALL, "--find-max", f"--p99={bound}")
        for seed in ("-1", "99999999999999999999", "1.5", "x"):
            self.refused(2, "--seed", "load", *SMALL, "--rate", "1", "--arrivals", "poisson", f"--seed={seed}")
        self.refused(2, "two frames or more", "load", "--frames", self.frame0, "--rate", "1")
        self.refused(2, "--html", "load", *SMALL, "--rate", "1", "--html", "-")
        self.refused(2, "--metrics-url", "load", *SMALL, "--rate", "1", "--metrics-url", "127.0.0.1:1")
        self.refused(2, "at most 100000", "load", *SMALL, "--rate", "1", "--clients", "70000", "--scenes", "70000")
        for rate in ("0", "-1", "nan"):
            self.refused(2, "--rate", "load", *SMALL, f"--rate={rate}")
        self.refused(1, "nonexistent", "load", *SMALL, "--rate", "1", "--html", "/nonexistent/load.html")


class Standstill(LoadTest):
    def load_a_daemon_that_stands_still(self, *words):
        """It is stopped for two seconds once frames flow."""
        with self.loaded_daemon() as (daemon, server):
            command = [COLLIDECTL, "load", *SMALL, *PATIENT, *words, "--seconds", "5", "--json", *server]
            with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as tester:
                self.assertIn(" s: ", self.first_second(tester.stderr))
                daemon.send_signal(signal.SIGSTOP)
                time.sleep(STANDSTILL)
                daemon.send_signal(signal.SIGCONT)
                printed, errors = tester.communicate(timeout=120)
            self.assertEqual(tester.returncode, 0, errors)
        return json.loads(printed)

    @staticmethod
    def first_second(lines):
        return next((line for line in lines if " s: " in line), "")

    def test_an_open_loop_shows_it_in_its_percentiles(self):
        result = self.load_a_daemon_that_stands_still("--rate", "50")
        latency = result["latency_ms"]
        for name in ("p99", "p99.9", "max"):
            self.assertGreater(latency[name], 1500, name)
        self.assertGreater(latency["p90"], 700, "two of five seconds' frames waited")
        self.assertGreater(latency["mean"], 200)
        self.assertEqual(result["frames"]["answered"], 250)
        self.assertLess(result["comparison"]["max_difference_percent"], 1)

    def test_a_closed_loop_hides_it_in_its_mean(self):
        result = self.load_a_daemon_that_stands_still("--closed-loop")
        latency = result["latency_ms"]
        self.assertGreater(latency["max"], 1500)
        self.assertLess(latency["p90"], latency["max"] / 2)
        self.assertLess(latency["mean"], latency["max"] / 4)


class Interrupts(LoadTest):
    def interrupt(self, tester):
        """What is printed by a tester that is interrupted after its first second."""
        self.assertIn(" s: ", Standstill.first_second(tester.stderr))
        tester.send_signal(signal.SIGINT)
        printed, errors = tester.communicate(timeout=60)
        self.assertEqual(tester.returncode, 128 + signal.SIGINT, errors)
        self.assertIn("collidectl: interrupted by signal 2\n", errors)
        return json.loads(printed)

    def test_what_was_measured_so_far_is_reported(self):
        command = [COLLIDECTL, "load", *SMALL, "--rate", "50", "--seconds", "1000", "--json", *ONE_CPU]
        env = {**os.environ, "COLLIDED_DAEMON": DAEMON, "TMPDIR": self.folder.name}
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
        with subprocess.Popen(command, env=env, text=True, **pipes) as tester:
            result = self.interrupt(tester)
        self.assertTrue(result["interrupted"])
        self.assertGreater(result["frames"]["answered"], 0)
        self.assertLess(result["throughput"]["seconds"], 100)
        self.assertEqual([name for name in os.listdir(self.folder.name) if name.startswith("collided-")], [])

    def test_a_daemon_that_is_killed_is_reported_with_what_was_measured(self):
        with self.loaded_daemon() as (daemon, server):
            command = [COLLIDECTL, "load", *SMALL, "--rate", "50", "--seconds", "1000", "--json", *server]
            with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as tester:
                Standstill.first_second(tester.stderr)
                daemon.kill()
                printed, errors = tester.communicate(timeout=60)
        self.assertEqual(tester.returncode, 1, errors)
        result = json.loads(printed)
        self.assertEqual(result["streams_ended"]["UNAVAILABLE"]["count"], 1)
        self.assertIn("1 of 1 streams ended early: UNAVAILABLE", errors)


if __name__ == "__main__":
    support.main()
