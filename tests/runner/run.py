#!/usr/bin/env python3
"""Runs ctest, and the tests that read a clock once more on clocks that started seconds ago; shows progress and sums up.

usage: run.py BUILD_FOLDER HEADLINE [CTEST ARGUMENT...]

Exits with 1 if a test failed, else with what ctest exited with.
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import time

import summary

# With these options, ctest's own output is what the user wants.
RAW = ("-V", "-VV", "--verbose", "--extra-verbose", "--debug", "-N", "--show-only", "--print-labels", "--help", "--version")
AGE = 5  # seconds, of a young clock
# unit-no-clock is pure arithmetic, integration-any-clock a daemon that answers within seconds.
YOUNG = ["--no-tests=ignore", "-L", "^unit$|-any-clock$"]
RESULT = re.compile(r"\s*(\d+)/(\d+) Test\s+#\d+: (.+?) \.{3,}(.*)$")
NOISE = re.compile(r"\s*(Start\s+\d+: |Test project |Internal ctest changing into directory: |Connected to MAKE jobserver)")


class Progress:
    """Shows failures with their output, and how far ctest is: in one line of a terminal, elsewhere in a line for every 5 %."""

    def __init__(self, out, width):
        self.out, self.width, self.clear = out, width, "\r\033[K" if out.isatty() else ""
        self.started = time.monotonic()
        self.failed = self.skipped = self.told = 0
        self.is_over = False

    def line(self, text):
        self.is_over = self.is_over or re.match(r"\d+% tests passed", text) is not None  # the sum of one stage alone
        if result := RESULT.match(text):
            self.result(int(result[1]), int(result[2]), result[3].split("  # ")[0], result[4])
        elif not self.is_over and not NOISE.match(text):
            self.show(text + "\n")

    def result(self, number, total, name, verdict):
        was_skipped = "***Skipped" in verdict or "(Disabled)" in verdict
        self.skipped += was_skipped
        if "***" in verdict and not was_skipped:
            self.failed += 1
            self.show(f"FAILED {name}: {' '.join(verdict.replace('***', ' ').split())}\n")
            return  # its output comes next
        state = f"{100 * number // total:3} % ({number} of {total}), {self.failed} failed, {self.skipped} skipped"
        if self.clear:
            self.show(f"{state}  {name}"[:self.width])
        elif 20 * number // total > self.told:
            self.told = 20 * number // total
            self.show(f"{state}, {time.monotonic() - self.started:.0f} s\n")

    def show(self, text):
        self.out.write(self.clear + text)
        self.out.flush()


def young_clock():
    """The command that runs another on clocks of AGE seconds, a Linux time namespace, and why it cannot be used here."""
    offsets = pathlib.Path("/proc/self/timens_offsets")
    ahead = dict(line.split()[:2] for line in offsets.read_text().splitlines()) if offsets.exists() else {}  # by name
    command = ["unshare", "--time", "--fork", *(["--map-current-user"] if os.geteuid() != 0 else [])]
    for name, clock in (("monotonic", time.CLOCK_MONOTONIC), ("boottime", time.CLOCK_BOOTTIME)):
        # Offsets count from the machine's own clock, and this one may be ahead of it already.
        command += [f"--{name}", str(AGE - int(time.clock_gettime(clock)) + int(ahead.get(name, 0)))]
    try:
        tried = subprocess.run([*command, "true"], capture_output=True, text=True, timeout=30, check=False)
    except FileNotFoundError:
        return command, "unshare (util-linux) is not installed"
    said = tried.stderr.strip().splitlines() or [f"unshare exited with {tried.returncode}"]
    return command, said[0] if tried.returncode != 0 else None


def run_stage(log, build, report, arguments, prefix=()):
    """ctest's exit code; all its output is in the log."""
    report.unlink(missing_ok=True)
    command = [*prefix, "ctest", "--test-dir", str(build), "--output-on-failure", "--output-junit", str(report),
               "--test-output-size-passed", "8192", "--parallel", str(os.cpu_count()), *arguments]
    is_raw = any(argument.split("=")[0] in RAW for argument in arguments)
    progress = Progress(sys.stdout, shutil.get_terminal_size().columns - 1)
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT) as ctest:
        for line in ctest.stdout:
            log.write(line)
            text = line.decode(errors="replace").rstrip("\n")
            print(text, flush=True) if is_raw else progress.line(text)
    progress.show("")
    return ctest.returncode


def main(build, headline, *arguments):
    build = pathlib.Path(build).resolve()
    report, young_report, log_path = (build / f"test-{name}" for name in ("report.xml", "report-young.xml", "log.txt"))
    found, notes = [], []
    with open(log_path, "wb") as log:
        code = run_stage(log, build, report, ["--no-tests=error", *arguments])
        if report.exists():  # else a list was asked for, or no test matched
            found += summary.results(report)
            prefix, obstacle = young_clock()
            stage = f"the tests that know a clock, on one of {AGE} s"
            if obstacle:
                notes.append(f"   skipped: {stage}: {obstacle}")
            else:
                print(f"tests/run: {stage}", flush=True)
                code = run_stage(log, build, young_report, [*arguments, *YOUNG], prefix) or code
                found += summary.results(young_report, f" [clock of {AGE} s]") if young_report.exists() else []
    print(f"\n== tests/run: {headline}")
    if report.exists():
        *told, counts = summary.lines(found)
        print(*told, *notes, f"   report: {report}", f"   log: {log_path}", counts, sep="\n")
    if any(outcome == "failed" for _, outcome in found):
        code = 1
    print("== FAILED" if code else "== OK")
    return code


if __name__ == "__main__":
    try:
        sys.exit(main(*sys.argv[1:]))
    except KeyboardInterrupt:
        sys.exit(130)
