#!/usr/bin/env python3
"""The package finds the daemon and the command line in itself, in collided_cuda and on PATH, and its scripts run them.

usage: programs_test.py DAEMON COLLIDECTL REPOSITORY
"""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import collided
from support import COLLIDECTL, DAEMON, FLOOR, ONE, STRICT, TIP, lowered, main, np

SCRIPT = """#!{python}
import sys
from collided.programs import {function}
if __name__ == "__main__":
    sys.exit({function}())
"""  # as installers write it
FIND = "from collided.connection.own_daemon import find_daemon; print(find_daemon())"


class Programs(unittest.TestCase):
    """A copy of the package, with a folder that is on PATH."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        self.package, self.bin = self.root / "site" / "collided", self.root / "bin"
        shutil.copytree(pathlib.Path(collided.__file__).parent, self.package, ignore=shutil.ignore_patterns("__pycache__"))
        self.bin.mkdir()

    def run_python(self, *words, **environment):
        clean = {"PATH": str(self.bin), "PYTHONPATH": str(self.root / "site"), "PYTHONDONTWRITEBYTECODE": "1"}
        return subprocess.run([sys.executable, *words], text=True, capture_output=True, timeout=60, cwd=self.root,
                              env={**clean, **environment})

    def program(self, path, source=None):
        """A program that says its name and arguments, or a link to a real one."""
        path.parent.mkdir(parents=True, exist_ok=True)
        if source is not None:
            path.symlink_to(source.resolve())
        else:
            path.write_text('#!/bin/sh\necho "$0 $*"\n')
            path.chmod(0o755)
        return str(path)

    def script(self, name, function):
        """The script that an installer puts on PATH."""
        path = self.bin / name
        path.write_text(SCRIPT.format(python=sys.executable, function=function))
        path.chmod(0o755)
        return path

    def found(self, **environment):
        done = self.run_python("-c", FIND, **environment)
        return done.stdout.strip() or done.stderr.strip().splitlines()[-1]

    def cuda(self):
        self.root.joinpath("site", "collided_cuda").mkdir()
        self.root.joinpath("site", "collided_cuda", "__init__.py").touch()
        return self.root / "site" / "collided_cuda" / "bin" / "collided"

    def test_the_variable_comes_first_then_cuda_then_the_package_then_path(self):
        self.script("collided", "daemon")
        self.assertIn("no program 'collided' is in this package or on PATH", self.found())
        on_path = self.program(self.root / "more" / "collided")
        path = f"{self.bin}:{self.root / 'more'}"
        self.assertEqual(self.found(PATH=path), on_path)
        own = self.program(self.package / "bin" / "collided")
        self.assertEqual(self.found(PATH=path), own)
        cuda = self.program(self.cuda())
        self.assertEqual(self.found(PATH=path), cuda)
        self.assertEqual(self.found(PATH=path, COLLIDED_DAEMON=on_path), on_path)
        self.assertIn("COLLIDED_DAEMON is '/none', which is not a program", self.found(PATH=path, COLLIDED_DAEMON="/none"))

    def test_a_package_for_cuda_without_a_program_is_passed_over(self):
        own = self.program(self.package / "bin" / "collided")
        self.cuda()
        self.assertEqual(self.found(), own)

    def test_the_daemon_of_the_package_answers(self):
        self.program(self.package / "bin" / "collided", DAEMON)
        detect = (f"import collided, numpy as np; v = np.array({np.vstack([FLOOR, TIP]).tolist()}); "
                  f"w = np.array({np.vstack([FLOOR, lowered(2)]).tolist()}); "
                  f"print(collided.detect(v, w, {[*ONE.tolist(), [3, 4, 5]]}).elements.tolist())")
        done = self.run_python(*STRICT, "-c", detect, PATH=f"{self.bin}{os.pathsep}{os.defpath}")
        self.assertEqual((done.stdout, done.stderr), ("[[3, 0]]\n", ""))

    def test_the_scripts_become_the_programs(self):
        for name, function in (("collided", "daemon"), ("collidectl", "command_line")):
            script, own = self.script(name, function), self.program(self.package / "bin" / name)
            done = self.run_python(script, "--some", "option")
            self.assertEqual((done.stdout, done.returncode), (f"{own} --some option\n", 0))
        for name, program in (("collided", DAEMON), ("collidectl", COLLIDECTL)):
            pathlib.Path(self.package, "bin", name).unlink()
            self.program(self.package / "bin" / name, program)
            done = self.run_python(self.bin / name, "--version")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertRegex(done.stdout, rf"^{name} \d+\.\d+\.\d+")

    def test_the_command_line_starts_the_daemon_that_python_would_start(self):
        script = self.script("collidectl", "command_line")
        path = self.package / "bin" / "collidectl"
        path.parent.mkdir()
        path.write_text('#!/bin/sh\necho "$COLLIDED_DAEMON"\n')
        path.chmod(0o755)
        self.assertEqual(self.run_python(script).stdout, "\n")
        cuda = self.program(self.cuda())
        self.assertEqual(self.run_python(script).stdout, f"{cuda}\n")
        self.assertEqual(self.run_python(script, COLLIDED_DAEMON="/mine").stdout, "/mine\n")

    def test_a_script_without_a_program_runs_the_next_on_path_or_says_where_one_comes_from(self):
        for name, function in (("collided", "daemon"), ("collidectl", "command_line")):
            script = self.script(name, function)
            done = self.run_python(script)
            self.assertEqual(done.returncode, 1)
            for word in (f"{name}: no program '{name}' is in this package or on PATH", "wheel", "Debian package", "container",
                         "another host", "COLLIDED_SERVER"):
                self.assertIn(word, done.stderr)
            self.assertNotIn("Traceback", done.stderr)
            on_path = self.program(self.root / "more" / name)
            done = self.run_python(script, "x", PATH=f"{self.bin}{os.pathsep}{self.root / 'more'}")
            self.assertEqual(done.stdout, f"{on_path} x\n")


if __name__ == "__main__":
    main()
