"""Shared by the tests of collidectl batch and merge."""

import csv
import os
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import support  # noqa: E402
from support import FRAME0, FRAME1, ONE_CPU, ctl  # noqa: E402, F401

LEVEL = ["--thickness", "0.01"]
BROKEN = {"missing": "does not exist", "nan": "position nan is not finite", "cut": "face", "larger": "the frames differ"}


class BatchTest(support.CollidectlTest):
    def setUp(self):
        super().setUp()
        self.data, self.out = (os.path.join(self.folder.name, name) for name in ("data", "results"))
        os.mkdir(self.data)

    def frames(self, folder, numbers, pattern="f{}.obj"):
        """A vertex that passes through a triangle from each frame to the next, earlier each time."""
        os.makedirs(os.path.join(self.data, folder), exist_ok=True)
        for number in numbers:
            text = FRAME1 if number % 2 else FRAME0
            self.put(os.path.join("data", folder, pattern.format(number)), text.replace("v 1 1 1\n", f"v 1 1 {1 + number / 8}\n"))

    def broken(self):
        """A list of pairs of which four are broken, each in its own way, and two are whole."""
        self.put("data/a0.obj", FRAME0)
        self.put("data/a1.obj", FRAME1)
        self.put("data/nan.obj", FRAME1.replace("v 1 1 -1", "v 1 nan -1"))
        self.put("data/cut.obj", FRAME1[:-4])
        self.put("data/larger.obj", FRAME1 + "v 9 9 9\n")
        pairs = ["a0.obj,a1.obj", *(f"a0.obj,{name}.obj" for name in BROKEN), "a1.obj,a0.obj"]
        return self.put("data/pairs.csv", "frame0,frame1\n" + "\n".join(pairs) + "\n")

    def batch(self, *words, code=0, dataset=None, **environment):
        done = ctl("batch", dataset or self.data, "--out", self.out, *LEVEL, *words, **environment)
        self.assertEqual(done.returncode, code, done.stderr)
        return done

    def merged(self, *words, code=0, folder=None):
        """The table, byte for byte."""
        table = os.path.join(self.folder.name, "table.csv")
        done = ctl("merge", folder or self.out, "--out", table, *words)
        self.assertEqual(done.returncode, code, done.stderr)
        return pathlib.Path(table).read_bytes()

    def table(self, *words, **how):
        return list(csv.DictReader(self.merged(*words, **how).decode().splitlines()))

    def file(self, shard, of, ending="results"):
        return pathlib.Path(self.out, f"shard-{shard:04}-of-{of:04}.{ending}")
