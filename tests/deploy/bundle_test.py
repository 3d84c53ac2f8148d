#!/usr/bin/env python3
"""deploy/bundle makes a folder that runs, replaces its own, and no other.

usage: bundle_test.py REPOSITORY BUILD
"""

import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

REPOSITORY, BUILD = (pathlib.Path(word).resolve() for word in sys.argv[1:3])


class Bundle(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.out = pathlib.Path(folder.name) / "out"

    def bundle(self, *words):
        return subprocess.run([REPOSITORY / "deploy/bundle", "--preset", BUILD.name, *words], text=True, capture_output=True, check=False, timeout=120)

    def test_an_installed_prefix_is_left_as_it_is(self):
        (self.out / "bin").mkdir(parents=True)
        shutil.copy("/bin/true", self.out / "bin/collided")
        mine = self.out / "mine"
        mine.write_text("mine")
        done = self.bundle(self.out)
        self.assertEqual(done.returncode, 1, done)
        self.assertIn("neither empty nor an earlier bundle", done.stderr)
        self.assertEqual(mine.read_text(), "mine")

    def test_one_folder_is_named(self):
        for words in ([], [self.out, self.out]):
            self.assertEqual(self.bundle(*words).returncode, 2)

    def test_a_bundle_runs_from_elsewhere_and_is_replaced(self):
        for _ in range(2):
            done = self.bundle(self.out)
            self.assertEqual(done.returncode, 0, done)
            left = self.out / "left"
            self.assertFalse(left.exists())
            left.write_text("of the first")
        moved = self.out.rename(self.out.with_name("moved"))
        for program in ("collided", "collidectl"):
            said = subprocess.run([moved / "bin" / program, "--version"], text=True, capture_output=True, check=True, env={"LC_ALL": "C.UTF-8"})
            self.assertIn("0.", said.stdout)
        needed = subprocess.run(["ldd", moved / "bin/collided"], text=True, capture_output=True, check=True).stdout
        self.assertIn(f"{moved}/bin/../lib/libgrpc++.so", needed)
        self.assertNotIn("not found", needed)


if __name__ == "__main__":
    if BUILD.parent != REPOSITORY / "build":
        print(f"skipped: {BUILD} is no preset's build within {REPOSITORY}/build")
        sys.exit(77)
    if missing := [tool for tool in ("patchelf", "ldd", "strip") if not shutil.which(tool)]:
        print(f"skipped: {', '.join(missing)} is missing")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1])
