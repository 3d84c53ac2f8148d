#!/usr/bin/env python3
"""The short C++ examples print what they should.

usage: examples_test.py DAEMON PROGRAM...
"""

import pathlib
import subprocess
import sys
import unittest

DAEMON, *PROGRAMS = (pathlib.Path(argument).resolve() for argument in sys.argv[1:])
REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(REPOSITORY / "tests" / "interop"))
from daemon import Daemon  # noqa: E402

PRINTED = {
    "line_search": "first contact at 0.350, went 0.25, contacts 0, height 0.5\n",
    "rest_shape_exclusions": "nothing excluded: flat 3080, folded 11928 contacts\n"
                             "without what is close at rest: flat 0, folded 8488 contacts\n",
    "resume_after_kill": "".join(f"frame {frame}: {int(frame == 3)} contacts, {int(frame > 2)} recreations\n"
                                 for frame in range(7)),
    "scene_set": "250 contacts in 250 worlds\n" * 3,
    "sparse_update": "28 bytes, 0 vertex meets the ceiling\n28 bytes, 1 vertex meets the ceiling\n",
}


def run(*words):
    return subprocess.run(words, text=True, capture_output=True, timeout=60)


class Examples(unittest.TestCase):
    def test_each_prints_what_it_should(self):
        self.assertEqual({path.name for path in PROGRAMS}, PRINTED.keys())
        daemon = Daemon(DAEMON)
        self.addCleanup(daemon.kill)
        for program in PROGRAMS:
            with self.subTest(program.name):
                done = run(program, DAEMON if program.name == "resume_after_kill" else daemon.address)
                self.assertEqual((done.stdout, done.returncode), (PRINTED[program.name], 0), done.stderr)
        daemon.stop()

    def test_each_tells_how_it_is_used(self):
        for program in PROGRAMS:
            with self.subTest(program.name):
                done = run(program)
                self.assertEqual((done.stderr.split()[:2], done.returncode), (["usage:", program.name], 2))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
