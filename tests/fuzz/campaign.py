#!/usr/bin/env python3
"""Runs fuzzers that are built, several processes each, all targets at once, and writes what they did as JSON.

Needs nothing but Python and the programs. Processes of a target learn from each other through its folder of inputs.
"""

import argparse
import datetime
import json
import os
import pathlib
import re
import subprocess
import threading
import time

OPTIONS = ["-max_len=4096", "-timeout=60", "-rss_limit_mb=4096"]
FINDINGS = ("crash-", "leak-", "timeout-", "oom-")  # slow-unit- is no finding
RESTARTS = 20  # of a process that keeps ending with a finding
GRACE = 20  # seconds after the last that a process may take for its last input


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("targets", nargs="*", help="default: all of --seeds")
    here = pathlib.Path(__file__).resolve().parent
    parser.add_argument("--binaries", type=pathlib.Path, required=True, help="folder of the fuzzers, fuzz_TARGET")
    parser.add_argument("--out", type=pathlib.Path, required=True,
                        help="folder for corpus/, findings/, logs/ and result.json; one that has them is gone on with, and figures are added up")
    parser.add_argument("--seeds", type=pathlib.Path, required=True, help="folder of the seeds, in a folder for each target")
    parser.add_argument("--dictionaries", type=pathlib.Path, default=here / "dictionaries")
    parser.add_argument("--suppressions", type=pathlib.Path, default=here.parent / "lsan.supp")
    parser.add_argument("--workers", type=int, default=1, help="processes of each target (1)")
    parser.add_argument("--seconds", type=float, default=60, help="of each process (60)")
    parser.add_argument("--one-by-one", action="store_true", help="one target after the other")
    parser.add_argument("--device", default=None, help="name of the machine (its CPU)")
    parser.add_argument("--commit", default=None, help="of the programs (git's HEAD)")
    return parser.parse_args()


def processor():
    names = re.findall(r"^model name\s*: (.*)$", pathlib.Path("/proc/cpuinfo").read_text(), re.M)
    return f"{names[0] if names else 'CPU'}, {len(os.sched_getaffinity(0))} cores"


def head():
    command = ["git", "-C", str(pathlib.Path(__file__).resolve().parent), "rev-parse", "--short=8", "HEAD"]
    return subprocess.run(command, capture_output=True, text=True, check=False).stdout.strip() or "unknown"


class Target:
    """One fuzzer, its folders, and what its processes did."""

    def __init__(self, name, options):
        self.name = name
        self.corpus, self.findings, self.logs = (options.out / folder for folder in (f"corpus/{name}", "findings", "logs"))
        for folder in (self.corpus, self.findings, self.logs):
            folder.mkdir(parents=True, exist_ok=True)
        self.command = [str(options.binaries / f"fuzz_{name}"), *OPTIONS, "-print_final_stats=1",
                        f"-artifact_prefix={self.findings}/{name}-"]
        dictionary = options.dictionaries / f"{name}.dict"
        if dictionary.exists():
            self.command.append(f"-dict={dictionary}")
        self.inputs = [str(self.corpus), str(options.seeds / name)]
        self.environment = os.environ | {"LSAN_OPTIONS": f"suppressions={options.suppressions}"}
        self.lock = threading.Lock()
        self.did = {"worker_seconds": 0.0, "cpu_seconds": 0.0, "executions": 0, "edges": 0, "features": 0}
        self.ended_badly = []

    def work(self, number, seconds):
        """One process for `seconds`; one that ends with a finding is started again for what is left."""
        end = time.monotonic() + seconds
        for attempt in range(RESTARTS):
            left = end - time.monotonic()
            if left < 1:
                return
            if self.run_once(f"{self.name}-{number}-{attempt}.log", int(left)) == 0:
                return

    def run_once(self, log_name, seconds):
        log, start = self.logs / log_name, time.monotonic()
        with log.open("wb") as output:
            process = subprocess.Popen([*self.command, f"-max_total_time={seconds}", *self.inputs], stdout=output,
                                       stderr=subprocess.STDOUT, env=self.environment)
        stop = threading.Timer(seconds + GRACE, process.kill)
        stop.start()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        stop.cancel()
        self.count(log.read_text(errors="replace"), time.monotonic() - start, usage.ru_utime + usage.ru_stime)
        if process.returncode != 0:
            with self.lock:
                self.ended_badly.append({"log": log_name, "exit_code": process.returncode})
        return process.returncode

    def count(self, log, seconds, cpu_seconds):
        seen = figures(log)
        with self.lock:
            self.did["worker_seconds"] += seconds
            self.did["cpu_seconds"] += cpu_seconds
            self.did["executions"] += seen["executions"]
            for name in ("edges", "features"):
                self.did[name] = max(self.did[name], seen[name])

    def result(self, earlier):
        """What was done, with what an earlier run in the same folder did."""
        whole = {}
        for name, value in self.did.items():
            before = earlier.get(name, 0)
            whole[name] = max(before, value) if name in ("edges", "features") else round(before + value, 1)
        whole["corpus"] = sum(1 for _ in self.corpus.iterdir())
        whole["findings"] = sorted(file.name for file in self.findings.glob(f"{self.name}-*")
                                   if file.name.removeprefix(f"{self.name}-").startswith(FINDINGS))
        whole["ended_badly"] = earlier.get("ended_badly", []) + self.ended_badly
        return whole


def figures(log):
    """Executions, edges and features from libFuzzer's log; one that was killed has no final statistics."""
    def last(pattern):
        found = re.findall(pattern, log, re.M)
        return int(found[-1]) if found else 0
    return {"executions": max(last(r"^stat::number_of_executed_units:\s*(\d+)"), last(r"^#(\d+)\s")),
            "edges": last(r"\bcov: (\d+)"), "features": last(r"\bft: (\d+)")}


def run(targets, options):
    groups = [[target] for target in targets] if options.one_by_one else [targets]
    for group in groups:
        threads = [threading.Thread(target=target.work, args=(number, options.seconds))
                   for target in group for number in range(options.workers)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()


def line(name, did):
    return (f"{name:18} {did['cpu_seconds']:8.0f} s CPU {did['executions']:12.0f} executions {did['edges']:7} edges "
            f"{did['features']:7} features {did['corpus']:6} inputs {len(did['findings']):3} findings")


def main():
    options = arguments()
    options.out = options.out.resolve()
    names = options.targets or sorted(folder.name for folder in options.seeds.iterdir())
    targets = [Target(name, options) for name in names]
    file = options.out / "result.json"
    earlier = json.loads(file.read_text())["targets"] if file.exists() else {}
    run(targets, options)
    done = {target.name: target.result(earlier.get(target.name, {})) for target in targets}
    result = {"date": datetime.datetime.now(datetime.timezone.utc).date().isoformat(), "commit": options.commit or head(),
              "device": options.device or processor(), "workers": options.workers, "targets": earlier | done}
    file.write_text(json.dumps(result, indent=1) + "\n")
    for name, did in done.items():
        print(line(name, did))
        for finding in did["findings"]:
            print(f"  {options.out / 'findings' / finding}")
        for ended in did["ended_badly"]:
            print(f"  ended with {ended['exit_code']}: {options.out / 'logs' / ended['log']}")
    return 1 if any(did["findings"] or did["ended_badly"] for did in done.values()) else 0


if __name__ == "__main__":
    raise SystemExit(main())
