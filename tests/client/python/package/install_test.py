#!/usr/bin/env python3
"""The package as a user installs it, without an index: the lines of its README run.

usage: install_test.py DAEMON COLLIDECTL REPOSITORY
"""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

try:
    import ensurepip  # noqa: F401
    import wheel  # noqa: F401
except ImportError as missing:
    print(f"skipped: {missing} (Debian: python3-venv, python3-wheel)")
    sys.exit(77)

DAEMON, COLLIDECTL, REPOSITORY = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3])
PACKAGE = REPOSITORY / "client" / "python"
sys.path.insert(0, str(REPOSITORY / "tests" / "docs"))
from markdown import Page  # noqa: E402


class Installed(unittest.TestCase):
    def run_in(self, folder, *words, **environment):
        clean = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "COLLIDED_SERVER")}
        done = subprocess.run(words, cwd=folder, text=True, capture_output=True, timeout=120, env={**clean, **environment})
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def test_it_installs_without_an_index_and_the_first_lines_run(self):
        before = sorted(PACKAGE.rglob("*"))
        with tempfile.TemporaryDirectory() as folder:
            self.run_in(folder, sys.executable, "-m", "venv", "--system-site-packages", "venv")
            python = f"{folder}/venv/bin/python"
            pip = [python, "-m", "pip", "install", "--no-index", "--no-build-isolation", "--no-cache-dir"]
            self.run_in(folder, *pip, PACKAGE, PATH=f"{folder}/venv/bin")  # without a compiler
            where = pathlib.Path(self.run_in(folder, python, "-c", "import collided; print(collided.__path__[0])").strip())
            self.assertTrue(where.is_relative_to(folder), where)
            for file in ("py.typed", "v1/frame_pb2.pyi", "v1/collision_service_pb2_grpc.py"):
                self.assertTrue((where / file).exists(), file)
            first, *_ = Page(PACKAGE / "README.md").blocks("python")
            shown, *_ = Page(PACKAGE / "README.md").blocks("text")
            self.assertEqual(self.run_in(folder, python, "-c", first, COLLIDED_DAEMON=DAEMON), shown)
            for script, program in (("collided", DAEMON), ("collidectl", COLLIDECTL)):
                path = os.pathsep.join([f"{folder}/venv/bin", str(pathlib.Path(program).resolve().parent)])
                said = self.run_in(folder, f"{folder}/venv/bin/{script}", "--version", PATH=path)
                self.assertEqual(said, self.run_in(folder, program, "--version"))
        self.assertEqual(sorted(PACKAGE.rglob("*")), before, "the build left something beside the sources")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
