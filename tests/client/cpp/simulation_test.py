#!/usr/bin/env python3
"""The C++ example that simulates a cloth on a sphere: no triangles meet beyond a common corner; the cloth folds and moves.

usage: simulation_test.py DAEMON EXAMPLE REPOSITORY
"""

import os
import pathlib
import re
import subprocess
import sys
import unittest

DAEMON, EXAMPLE, REPOSITORY = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3])
sys.path.insert(0, str(REPOSITORY / "tests" / "interop"))
from daemon import Daemon  # noqa: E402

FRAMES, CELLS = 150, 16
LINE = re.compile(r"frame (\d+): (\d+) pairs met so far, \d+ contacts, (\d+) of folds, advanced ([\d.]+)")


class Simulation(unittest.TestCase):
    def setUp(self):
        self.daemon = Daemon(DAEMON)
        self.addCleanup(self.daemon.kill)

    def printed(self):
        done = subprocess.run([EXAMPLE, str(FRAMES), str(CELLS)], text=True, capture_output=True, timeout=100,
                              env={**os.environ, "COLLIDED_SERVER": self.daemon.address})
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def test_it_never_crosses_folds_and_is_the_same_each_time(self):
        printed = self.printed()
        frames, crossings, folds, advanced = zip(*(map(float, line) for line in LINE.findall(printed)))
        self.assertEqual((frames[-1], crossings[-1]), (FRAMES, 0))
        self.assertGreater(max(folds), 10)
        self.assertGreater(min(advanced), 0.99)
        self.assertEqual(self.printed(), printed)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
