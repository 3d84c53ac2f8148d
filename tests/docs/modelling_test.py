#!/usr/bin/env python3
"""client/MODELLING.md: its programs in C++ against a real daemon print what the page shows.

usage: modelling_test.py DAEMON EXAMPLE... REPOSITORY
"""

import os
import pathlib
import subprocess
import sys
import unittest

DAEMON, EXAMPLES, REPOSITORY = sys.argv[1], sys.argv[2:-1], pathlib.Path(sys.argv[-1])
sys.path.insert(0, str(REPOSITORY / "tests" / "interop"))
from daemon import Daemon  # noqa: E402
from markdown import Page  # noqa: E402


class Modelling(unittest.TestCase):
    def test_the_programs_print_what_the_page_shows(self):
        daemon = Daemon(DAEMON)
        self.addCleanup(daemon.kill)
        shown = Page(REPOSITORY / "client" / "MODELLING.md").blocks("text")
        self.assertEqual(len(shown), len(EXAMPLES))
        for example, lines in zip(EXAMPLES, shown):
            done = subprocess.run([example], text=True, capture_output=True, timeout=60,
                                  env={**os.environ, "COLLIDED_SERVER": daemon.address})
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(done.stdout, lines)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
