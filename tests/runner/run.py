#!/usr/bin/env python3
"""Runs ctest, and the tests that read a clock once more on clocks that started seconds ago; shows progress and sums up.

usage: run.py BUILD_FOLDER HEADLINE [CTEST ARGUMENT...]

Exits with 1 if a test failed, else with what ctest exited with.
"""

import os
import pathlib
import shutil
import subprocess
import sys

import young_clock
from progress import Progress
from summary import Summary

# With these options, ctest's own output is what the user wants.
RAW = ("-V", "-VV", "--verbose", "--extra-verbose", "--debug", "-N", "--show-only", "--print-labels", "--help", "--version")
# unit-no-clock is pure arithmetic, integration-any-clock a daemon that answers within seconds.
YOUNG = ["-L", "^unit$|-any-clock$"]


def run_stage(command, log, is_raw):
    """ctest's exit code; all its output is in the log."""
    width = shutil.get_terminal_size().columns - 1
    progress = Progress(sys.stdout, width)
    ctest = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    for line in ctest.stdout:
        log.write(line)
        text = line.decode(errors="replace").rstrip("\n")
        if is_raw:
            print(text, flush=True)
        else:
            progress.line(text)
    progress.end()
    log.flush()
    return ctest.wait()


def ctest_command(build, report, arguments):
    report.unlink(missing_ok=True)
    return ["ctest", "--test-dir", str(build), "--output-on-failure", "--output-junit", str(report),
            "--test-output-size-passed", "8192", "--parallel", str(os.cpu_count()), *arguments]


def main(build, headline, *arguments):
    build = pathlib.Path(build).resolve()
    report, young_report, log_path = (build / f"test-{name}" for name in ("report.xml", "report-young.xml", "log.txt"))
    is_raw = any(argument.split("=")[0] in RAW for argument in arguments)
    summary = Summary()
    notes = []
    with open(log_path, "wb") as log:
        code = run_stage(ctest_command(build, report, ["--no-tests=error", *arguments]), log, is_raw)
        summary.add(report)
        young = f"the tests that know a clock, on one of {young_clock.AGE} s"
        if not report.exists():
            pass  # nothing ran: a list was asked for, or no test matched
        elif reason := young_clock.obstacle():
            notes.append(f"   skipped: {young}: {reason}")
        else:
            print(f"tests/run: {young}", flush=True)
            command = ctest_command(build, young_report, ["--no-tests=ignore", *arguments, *YOUNG])
            code = run_stage(young_clock.command() + command, log, is_raw) or code
            summary.add(young_report, f" [clock of {young_clock.AGE} s]")
    print(f"\n== tests/run: {headline}")
    if report.exists():
        print(*summary.lines(), *notes, f"   report: {report}", f"   log: {log_path}", summary.counts(), sep="\n")
    if summary.failed:
        code = 1
    print("== FAILED" if code else "== OK")
    return code


if __name__ == "__main__":
    try:
        sys.exit(main(*sys.argv[1:]))
    except KeyboardInterrupt:
        sys.exit(130)
