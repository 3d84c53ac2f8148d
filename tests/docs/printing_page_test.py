#!/usr/bin/env python3
"""A page of client/: its programs in C++ against a real daemon print what the page shows.

usage: printing_page_test.py DAEMON REPOSITORY PAGE EXAMPLE...
"""

import os
import pathlib
import subprocess
import sys
import unittest

DAEMON, REPOSITORY, PAGE, EXAMPLES = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3], sys.argv[4:]
sys.path.insert(0, str(REPOSITORY / "tests" / "interop"))
from daemon import Daemon  # noqa: E402
from markdown import Page  # noqa: E402


class PrintingPage(unittest.TestCase):
    def test_the_programs_print_what_the_page_shows(self):
        daemon = Daemon(DAEMON)
        self.addCleanup(daemon.kill)
        shown = Page(REPOSITORY / "client" / PAGE).blocks("text")
        self.assertEqual(len(shown), len(EXAMPLES))
        for example, lines in zip(EXAMPLES, shown):
            done = subprocess.run([example], text=True, capture_output=True, timeout=60,
                                  env={**os.environ, "COLLIDED_SERVER": daemon.address})
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(done.stdout, lines)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
