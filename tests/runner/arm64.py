#!/usr/bin/env python3
"""Runs what tests/run --arm64 has built, under QEMU: tests by ctest, the Python package from its wheel, and digests of contacts
beside those of this machine's own build.

usage: arm64.py CROSS_ROOT ARM64_ROOT SOURCE PRESET [--out FILE] [CTEST ARGUMENT...] -- ENVIRONMENT...

SOURCE is the folder of the working tree in both roots, ENVIRONMENT the command that clears the environment for a program of theirs.
Without arguments for ctest: the unit tests of what is built. Exits with 1 if a test failed or a digest differs.
"""

import argparse
import collections
import datetime
import json
import os
import pathlib
import re
import subprocess
import sys

from summary import results

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
sys.path += [str(REPOSITORY / "tests" / folder) for folder in ("bench/builds", "docs")]
from digests import digests, started  # noqa: E402
from markdown import Page  # noqa: E402

CORE = ["--label-regex", "^unit"]
PYTHON_TESTS = ["in_process/local", "session", "contacts", "batch", "input", "watch"]
PATIENCE = 3600
OWN = REPOSITORY / "build" / "cpu-release"


class Root:
    """A system in a folder, whose programs may be for arm64."""

    def __init__(self, folder, source, environment):
        self.folder, self.source, self._environment = folder, source, environment

    def command(self, *words, **environment):
        return ["chroot", self.folder, *self._environment, *(f"{name}={value}" for name, value in environment.items()), *words]

    def run(self, *words, **environment):
        return subprocess.run(self.command(*words, **environment), text=True, capture_output=True, timeout=PATIENCE, check=False)

    def said(self, *words):
        done = self.run(*words)
        if done.returncode:
            sys.exit(f"{' '.join(words)}: {done.returncode}\n{done.stdout}{done.stderr}")
        return done.stdout


def by_program(root, build, arguments):
    """What ctest's tests came to, by the program that they are in."""
    report = f"{build}/test-report.xml"
    command = ["ctest", "--test-dir", build, *arguments]
    listed = json.loads(root.said(*command, "--show-only=json-v1"))
    programs = {test["name"].split("  # ")[0]: next((pathlib.Path(word).name for word in test["command"] if "python" not in word), "")
                for test in listed["tests"] if "command" in test}
    subprocess.run(root.command(*command, "--output-on-failure", "--no-tests=error", "--output-junit", report, "--parallel",
                                str(os.cpu_count())), check=False)
    found = collections.defaultdict(lambda: {"passed": 0, "failed": [], "skipped": {}})
    for name, outcome in results(f"{root.folder}{report}"):
        program = found[programs.get(name, "not built")]
        if outcome == "passed":
            program["passed"] += 1
        elif outcome == "failed":
            program["failed"].append(name)
        else:
            program["skipped"][name] = outcome.removeprefix("skipped: ")
    return found


def install(root):
    """Installs the wheel with what it needs, without an index; returns its name."""
    (wheel,) = pathlib.Path(f"{root.folder}/root/wheels").glob("collided-*.whl")
    root.said("python3", "-m", "pip", "install", "--quiet", "--force-reinstall", "--no-index", "--no-compile", "--no-warn-script-location",
              "--break-system-packages", "--root-user-action=ignore", "--find-links", "/root/wheels", f"/root/wheels/{wheel.name}")
    return wheel.name


def example(root, server):
    """Whether the first program of the package's page prints what it shows."""
    page = Page(REPOSITORY / "client" / "python" / "README.md")
    program = page.blocks("python")[0]
    if server:
        program = program.replace("[3, 4, 5]])", f"[3, 4, 5]], server={server!r})")
    done = root.run("python3", "-c", program)
    if done.stdout != page.blocks("text")[0]:
        print(done.stdout, done.stderr, file=sys.stderr)
    return done.stdout == page.blocks("text")[0]


def python_test(root, daemon, name):
    """A test of the package, which has the daemon and the library of the wheel."""
    tests, library = f"{root.source}/tests/client/python", str(pathlib.Path(daemon).parents[1] / "lib" / "libcollided.so.1")
    done = root.run("python3", f"{tests}/{name}_test.py", daemon, f"{pathlib.Path(daemon).parent}/collidectl", root.source,
                    PYTHONPATH=tests, PYTHONDONTWRITEBYTECODE="1", COLLIDED_LIBRARY=library)
    if done.returncode == 77:
        return {"passed": 0, "failed": [], "skipped": {name: done.stdout.strip()}}
    failed, skipped, test = re.findall(r"^(?:FAIL|ERROR): (.+)", done.stderr, re.MULTILINE), {}, name
    for line in done.stderr.splitlines():
        if started_test := re.match(r"(test_\w+) \(", line):
            test = started_test[1]
        if reason := re.search(r" \.\.\. skipped ['\"](.+)['\"]$", line):
            skipped[test] = reason[1]
    ran = re.search(r"^Ran (\d+) tests?", done.stderr, re.MULTILINE)
    if done.returncode and not failed:
        failed = [f"exit code {done.returncode}"]
    if failed:
        print(done.stdout, done.stderr, file=sys.stderr)
    return {"passed": max(0, (int(ran[1]) if ran else 0) - len(failed) - len(skipped)), "failed": failed, "skipped": skipped}


def local_digests(root):
    """Of what the engine in Python's process finds: of this machine's own build, and on arm64."""
    script, library = "tests/bench/builds/local_digests.py", OWN / "client/c/libcollided.so.1"
    if not library.exists():
        return {"skipped": f"{library.relative_to(REPOSITORY)} is not built"}
    here = {**os.environ, "COLLIDED_LIBRARY": str(library), "PYTHONPATH": str(REPOSITORY / "client/python"),
            "PYTHONDONTWRITEBYTECODE": "1"}
    own = subprocess.run(["/usr/bin/python3", REPOSITORY / script], env=here, text=True, capture_output=True, check=True).stdout
    return beside(json.loads(own), json.loads(root.said("python3", f"{root.source}/{script}")))


def daemon_digests(root, daemon):
    """Of what both daemons find of the same positions, those of this machine's collidectl."""
    collidectl, own = OWN / "client/cli/collidectl", OWN / "server/collided"
    for program in (collidectl, own):
        if not program.exists():
            return {"skipped": f"{program.relative_to(REPOSITORY)} is not built"}
    found = []
    for command, known_as in (([own], None), (root.command(daemon, "--max-frame-seconds", "600"), "/tmp")):
        with started(command, folder=f"{root.folder}/tmp", known_as=known_as) as (address, *_):
            found.append(digests(collidectl, address, scale=0.5))
    return beside(*found)


def own_version():
    daemon = OWN / "server/collided"
    if not daemon.exists():
        return "build/cpu-release is not built"
    return subprocess.run([daemon, "--version"], text=True, capture_output=True, check=True).stdout.splitlines()


def beside(own, found):
    return {"same": own == found, "x86-64": own, "arm64": found}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
                                     allow_abbrev=False)
    for name in ("cross", "arm64", "source", "preset"):
        parser.add_argument(name)
    parser.add_argument("--out")
    split = sys.argv.index("--") if "--" in sys.argv else len(sys.argv)
    environment = sys.argv[split + 1:]
    options, ctest = parser.parse_known_args(sys.argv[1:split])
    cross, arm64 = Root(options.cross, options.source, environment), Root(options.arm64, options.source, environment)
    commit = subprocess.run(["git", "describe", "--always", "--dirty= (modified)", "--exclude=*"], text=True, capture_output=True,
                            check=True, cwd=REPOSITORY).stdout.strip()
    report = {"date": datetime.date.today().isoformat(), "commit": commit,
              "device": cross.said("qemu-aarch64", "--version").splitlines()[0],
              "compiler": cross.said("aarch64-linux-gnu-g++", "--version").splitlines()[0], "wheel": install(arm64)}
    daemon = arm64.said("python3", "-c", "from collided import programs; print(programs.bundled('collided'))").strip()
    report["version"] = arm64.said(daemon, "--version").splitlines()
    report["example"] = {"with a daemon": example(arm64, None), "in the process": example(arm64, "local")}
    report["x86-64"] = own_version()
    report["digests"] = {"in the process": local_digests(arm64), "daemon": daemon_digests(arm64, daemon)}
    report["python"] = {name: python_test(arm64, daemon, name) for name in PYTHON_TESTS}
    report["programs"] = by_program(cross, f"{options.source}/build/{options.preset}", ctest or CORE)
    print(json.dumps(report, indent=1))
    if options.out:
        pathlib.Path(options.out).write_text(json.dumps(report, indent=1) + "\n", encoding="utf-8")
    tests = [*report["python"].values(), *report["programs"].values()]
    good = all(report["example"].values())
    good = good and all(d.get("same", True) for d in report["digests"].values()) and not any(test["failed"] for test in tests)
    print("== OK" if good else "== FAILED")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
