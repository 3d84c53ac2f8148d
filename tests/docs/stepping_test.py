#!/usr/bin/env python3
"""client/STEPPING.md: its programs in C++ and Python against a real daemon. They come to rest, and print the same bits. Their loops
are short, as is the tutorial's.

usage: stepping_test.py DAEMON EXAMPLE PYTHON_PACKAGE REPOSITORY
"""

import os
import pathlib
import subprocess
import sys
import unittest

try:
    import grpc  # noqa: F401
    import numpy  # noqa: F401
except ImportError as missing:
    print(f"skipped: {missing} (Debian: python3-grpcio, python3-numpy)")
    sys.exit(77)

DAEMON, EXAMPLE, PACKAGE, REPOSITORY = *sys.argv[1:4], pathlib.Path(sys.argv[4])
sys.path.insert(0, str(REPOSITORY / "tests" / "interop"))
from daemon import Daemon  # noqa: E402
from markdown import Page  # noqa: E402
from run_page import run_with_package  # noqa: E402

PAGE = Page(REPOSITORY / "client" / "STEPPING.md")


def loop_of(program, begin):
    """Returns the lines of a loop: its head, and what is indented more; in C++ the brace, too."""
    lines = program.splitlines()
    first = next(i for i, line in enumerate(lines) if line.lstrip().startswith(begin))
    indent = len(lines[first]) - len(lines[first].lstrip())
    last = next((i for i, line in enumerate(lines) if i > first and line and len(line) - len(line.lstrip()) <= indent), len(lines))
    return [line for line in lines[first:last + lines[last:last + 1].count(" " * indent + "}")] if line]


class Stepping(unittest.TestCase):
    def setUp(self):
        self.daemon = Daemon(DAEMON)
        self.addCleanup(self.daemon.kill)

    def test_programs_agree_and_come_to_rest_above_the_floor(self):
        done = subprocess.run([EXAMPLE], text=True, capture_output=True, timeout=60,
                              env={**os.environ, "COLLIDED_SERVER": self.daemon.address})
        self.assertEqual(done.returncode, 0, done.stderr)
        (program,) = PAGE.blocks("python")
        self.assertEqual(done.stdout, run_with_package(program, self.daemon.address, PACKAGE))
        *heights, ways = zip(*([float(value) for value in line.split()] for line in done.stdout.splitlines()))
        self.assertEqual(len(heights), 3)
        for vertex in heights:
            self.assertEqual(len(vertex), 6)
            self.assertLess(vertex[-1], 0.1)
            self.assertGreaterEqual(min(vertex), 0.001)
        self.assertGreater(min(ways), 0.5)

    def test_loops_have_20_lines_at_most_and_advance_per_vertex(self):
        tutorial = "\n".join(Page(REPOSITORY / "client" / "TUTORIAL.md").blocks("python"))
        for program, begin in ((*PAGE.blocks("cpp"), "for (int step"), (*PAGE.blocks("python"), "for step in"),
                               (tutorial, "while True")):
            loop = loop_of(program, begin)
            self.assertLessEqual(len(loop), 20)
            self.assertRegex("\n".join(loop), "(?i)per_vertex")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
