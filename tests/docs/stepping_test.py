#!/usr/bin/env python3
"""client/STEPPING.md: its programs in C++ and Python against a real daemon. They come to rest, and print the same bits.

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
        heights = [float(line.split()[0]) for line in done.stdout.splitlines()]
        self.assertEqual(len(heights), 6)
        self.assertLess(heights[-1], 0.1)
        self.assertGreaterEqual(min(heights), 0.001)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
