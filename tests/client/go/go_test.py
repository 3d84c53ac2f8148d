#!/usr/bin/env python3
"""The package for Go against a real daemon: its own tests, gofmt, vet, its example and the programs of its page.

usage: go_test.py DAEMON REPOSITORY BUILD_FOLDER
"""

import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

from go_workspace import PACKAGE, Missing, Workspace

REPOSITORY, BUILD = (pathlib.Path(argument).resolve() for argument in sys.argv[2:4])
DAEMON = str(pathlib.Path(sys.argv[1]).resolve())
try:
    WORKSPACE = Workspace(REPOSITORY, BUILD)
except Missing as missing:
    print(f"skipped: {missing}")
    sys.exit(77)

sys.path += [str(REPOSITORY / "tests" / folder) for folder in ("interop", "docs")]
from daemon import Daemon  # noqa: E402
from markdown import Page  # noqa: E402
from run_page import README_SOCKET  # noqa: E402

PACKAGES = [PACKAGE, f"{PACKAGE}/internal/features", f"{PACKAGE}/test", f"{PACKAGE}/examples/first_contact"]
FIRST_CONTACT = b"vertex 3, triangle 0, t = 0.500000000\n"


class Go(unittest.TestCase):
    def test_its_own_tests_pass(self):
        WORKSPACE.run("test", "-count=1", "-timeout=150s", f"{PACKAGE}/internal/features", f"{PACKAGE}/test", COLLIDED_DAEMON=DAEMON)

    def test_it_is_formatted_and_nothing_is_suspicious(self):
        gofmt = shutil.which("gofmt")
        unformatted = subprocess.run([gofmt, "-l", REPOSITORY / "client" / "go", REPOSITORY / "tests" / "interop"],
                                     text=True, capture_output=True, timeout=60, check=True)
        self.assertEqual(unformatted.stdout, "")
        WORKSPACE.run("vet", *PACKAGES)

    def test_the_example_starts_a_daemon_or_takes_one(self):
        example = f"{PACKAGE}/examples/first_contact"
        self.assertEqual(WORKSPACE.run("run", example, COLLIDED_DAEMON=DAEMON), FIRST_CONTACT)
        daemon = Daemon(DAEMON)
        self.addCleanup(daemon.kill)
        self.assertEqual(WORKSPACE.run("run", example, daemon.address), FIRST_CONTACT)

    def test_the_programs_of_the_page_print_what_they_say(self):
        daemon = Daemon(DAEMON)
        self.addCleanup(daemon.kill)
        page = Page(REPOSITORY / "client" / "go" / "README.md")
        programs, outputs = page.blocks("go"), page.blocks("text")
        self.assertEqual(len(programs), len(outputs))
        for program, output in zip(programs, outputs):
            with tempfile.TemporaryDirectory() as folder:
                file = pathlib.Path(folder) / "main.go"
                file.write_text(program.replace(README_SOCKET, daemon.address))
                self.assertEqual(WORKSPACE.run("run", file).decode(), output)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
