"""Shared by the tests of collidectl; each is called with COLLIDECTL DAEMON, the paths of the programs."""

import contextlib
import csv
import os
import subprocess
import sys
import tempfile
import time
import unittest

COLLIDECTL, DAEMON = sys.argv[1:3]
ONE_CPU = ["--backend", "cpu", "--threads", "1"]

# A triangle and a vertex of another triangle that passes straight through its inside at t = 0.5.
FRAME0 = "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 1 1 1\nv 1.5 1 3\nv 1 1.5 3\nf 1 2 3\nf 4 5 6\n"
FRAME1 = "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 1 1 -1\nv 1.5 1 1\nv 1 1.5 1\nf 1 2 3\nf 4 5 6\n"


def cube(x, size=2, y=0):
    """An OBJ file's text: a cube of quads whose lower corner is at (x, y, y)."""
    corners = [(x + size * (i & 1), y + size * (i >> 1 & 1), y + size * (i >> 2)) for i in range(8)]
    faces = ("1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6")
    return "".join("v {} {} {}\n".format(*corner) for corner in corners) + "".join(f"f {face}\n" for face in faces)


def ctl(*words, cwd=None, **environment):
    env = {**os.environ, "COLLIDED_DAEMON": DAEMON, **environment}
    return subprocess.run([COLLIDECTL, *words], capture_output=True, text=True, env=env, cwd=cwd, timeout=240)


class CollidectlTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.frame0 = self.put("a.obj", FRAME0)
        self.frame1 = self.put("b.obj", FRAME1)

    def put(self, name, text):
        path = os.path.join(self.folder.name, name)
        with open(path, "w", encoding="ascii") as file:
            file.write(text)
        return path

    def ok(self, *words, **environment):
        done = ctl(*words, **environment)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def refused(self, exit_code, part, *words, **environment):
        done = ctl(*words, **environment)
        self.assertEqual(done.returncode, exit_code, done.stdout + done.stderr)
        self.assertIn(part, done.stderr)
        self.assertTrue(done.stderr.startswith("collidectl: "), done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)

    def rows(self, name):
        with open(name, encoding="ascii", newline="") as file:
            return list(csv.DictReader(file))

    @contextlib.contextmanager
    def daemon(self, *options):
        """Address of a running daemon."""
        socket, ready = (os.path.join(self.folder.name, name) for name in ("s", "ready"))
        words = [DAEMON, "--address", "unix:" + socket, "--backend", "cpu", "--threads", "1", "--ready-file", ready]
        with subprocess.Popen([*words, "--log-level", "off", *options]) as daemon:
            try:
                while daemon.poll() is None and not (os.path.exists(ready) and os.path.getsize(ready)):
                    time.sleep(0.01)
                yield "unix:" + socket
            finally:
                daemon.terminate()
        self.assertEqual(daemon.returncode, 0)


def main():
    unittest.main(argv=sys.argv[:1], verbosity=2)
