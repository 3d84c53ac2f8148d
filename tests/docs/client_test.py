#!/usr/bin/env python3
"""The C++ of client/cpp/README.md, compiled (client_example.py), against a real daemon.

usage: client_test.py DAEMON EXAMPLE REPOSITORY
"""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

DAEMON, EXAMPLE, REPOSITORY = (pathlib.Path(argument).resolve() for argument in sys.argv[1:4])
sys.path.insert(0, str(REPOSITORY / "tests" / "interop"))
from daemon import Daemon  # noqa: E402

# Odd frames have the tip above the floor, even ones below it.
SAID = """\
session: frame 1
callback: frame 1
first, shared memory: 0 vertex-triangle contacts
2 points, open
shared, shared memory: 1 vertex-triangle contacts
frame 3, shared memory: 1 vertex-triangle contacts
frame 4, shared memory: 1 vertex-triangle contacts
frame 5, shared memory: 1 vertex-triangle contacts
"""


class Examples(unittest.TestCase):
    def test_they_compile_find_the_contacts_and_go_on_after_a_lost_connection(self):
        with tempfile.TemporaryDirectory() as folder:
            daemon = Daemon(str(DAEMON), "--local-socket", folder + "/local")
            self.addCleanup(daemon.kill)
            done = subprocess.run([EXAMPLE], text=True, capture_output=True, timeout=60,
                                  env={**os.environ, "COLLIDED_SERVER": daemon.address})
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stdout, SAID)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
