#!/usr/bin/env python3
"""The package's types hold on every system: what Linux alone has is used behind `sys.platform`, which mypy understands.

usage: types_test.py DAEMON COLLIDECTL REPOSITORY
"""

import pathlib
import subprocess
import sys
import tempfile
import unittest

try:
    import mypy.api  # noqa: F401
except ImportError as missing:
    print(f"skipped: {missing} (Debian: mypy)")
    sys.exit(77)

PACKAGE = pathlib.Path(sys.argv[3]) / "client" / "python"


class Types(unittest.TestCase):
    def test_they_are_the_same_on_every_system(self):
        with tempfile.TemporaryDirectory() as cache:
            found = {}
            for system in ("linux", "darwin", "win32"):
                # Types of other packages, whose number depends on what is installed, are not what is tried.
                words = [sys.executable, "-m", "mypy", "--platform", system, "--python-version", "3.11", "--cache-dir", cache,
                         "--ignore-missing-imports", "-p", "collided"]
                done = subprocess.run(words, cwd=PACKAGE, text=True, capture_output=True, timeout=150)
                self.assertIn(done.returncode, (0, 1), done.stderr)
                found[system] = [line for line in done.stdout.splitlines() if ": error: " in line]
        print({system: len(errors) for system, errors in found.items()}, "errors")
        self.assertEqual(found["darwin"], found["linux"])
        self.assertEqual(found["win32"], found["linux"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
