#!/usr/bin/env python3
"""A page of client/: its program in C++ against a real daemon prints what the page shows.

usage: printing_page_test.py DAEMON EXAMPLE REPOSITORY PAGE
"""

import os
import pathlib
import subprocess
import sys
import unittest

DAEMON, EXAMPLE, REPOSITORY, PAGE = *sys.argv[1:3], pathlib.Path(sys.argv[3]), sys.argv[4]
sys.path.insert(0, str(REPOSITORY / "tests" / "interop"))
from daemon import Daemon  # noqa: E402
from markdown import Page  # noqa: E402


class PrintingPage(unittest.TestCase):
    def test_the_program_prints_what_the_page_shows(self):
        daemon = Daemon(DAEMON)
        self.addCleanup(daemon.kill)
        done = subprocess.run([EXAMPLE], text=True, capture_output=True, timeout=60,
                              env={**os.environ, "COLLIDED_SERVER": daemon.address})
        self.assertEqual(done.returncode, 0, done.stderr)
        (shown,) = Page(REPOSITORY / "client" / PAGE).blocks("text")
        self.assertEqual(done.stdout, shown)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
