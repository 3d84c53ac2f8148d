#!/usr/bin/env python3
"""Wheels of a build: one for this machine runs without its build; one for others brings its libraries and their licences, and
draws what deploy/quickstart ends with.

usage: wheel_test.py REPOSITORY BUILD
"""

import pathlib
import re
import socket
import subprocess
import sys
import tempfile
import unittest
import zipfile

REPOSITORY, BUILD = (pathlib.Path(word).resolve() for word in sys.argv[1:3])
sys.path.insert(0, str(REPOSITORY / "tests" / "docs"))
from markdown import Page  # noqa: E402

PAGE = REPOSITORY / "client" / "python" / "README.md"
NOTHING = {"LC_ALL": "C.UTF-8"}  # no PATH: only what is in the wheel


def run(*command, **options):
    done = subprocess.run([str(word) for word in command], text=True, capture_output=True, timeout=400, **options)
    if done.returncode:
        raise AssertionError(f"{command}: {done.returncode}\n{done.stdout}\n{done.stderr}")
    return done.stdout


def reaches_pypi():
    try:
        socket.create_connection(("pypi.org", 443), 5).close()
    except OSError:
        return False
    return True


class Wheels(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def environment(self, *options):
        run("/usr/bin/python3", "-m", "venv", *options, self.folder / "venv")
        return self.folder / "venv" / "bin" / "python"

    def check_example(self, python):
        """The first program of the package's page, and what it prints."""
        page = Page(PAGE)
        self.assertEqual(run(python, "-c", page.blocks("python")[0], env=NOTHING), page.blocks("text")[0])

    def check_engine_in_process(self, python):
        """The same program without a daemon."""
        page = Page(PAGE)
        program = page.blocks("python")[0].replace("[3, 4, 5]])", "[3, 4, 5]], server='local')")
        self.assertIn("server='local'", program)
        self.assertEqual(run(python, "-c", program, env=NOTHING), page.blocks("text")[0])

    def test_one_for_this_machine(self):
        python = self.environment("--system-site-packages")
        wheels = self.folder / "wheels"
        said = run(python, REPOSITORY / "deploy" / "wheel", "--local", "--build", BUILD, wheels)
        (wheel,) = wheels.glob("*.whl")
        self.assertIn(str(wheel), said)
        self.assertRegex(wheel.name, r"^collided-[0-9.]+-py3-none-linux_\w+\.whl$")
        run(python, "-m", "pip", "install", "--no-index", "--no-deps", wheel)
        self.check_example(python)
        self.check_engine_in_process(python)
        for program in ("collided", "collidectl"):
            self.assertRegex(run(self.folder / "venv" / "bin" / program, "--version", env=NOTHING), r"\d+\.\d+\.\d+")

    @unittest.skipUnless(reaches_pypi(), "PyPI is not reached")
    def test_one_for_others_draws_the_picture(self):
        wheels = self.folder / "wheels"
        run(REPOSITORY / "deploy" / "wheel", "--build", BUILD, wheels)
        names = sorted((wheel.name for wheel in wheels.glob("*.whl")), reverse=True)
        self.assertEqual(len(names), 2, names)
        self.assertRegex(names[0], r"-py3-none-manylinux_2_\d+_\w+\.whl$")
        self.assertRegex(names[1], r"-py3-none-any\.whl$")
        with zipfile.ZipFile(wheels / names[0]) as wheel:
            inside = wheel.namelist()
        self.assertTrue([name for name in inside if re.search(r"collided\.libs/libgrpc\+\+", name)], inside)
        self.assertTrue([name for name in inside if re.search(r"dist-info/licenses/libgrpc\+\+", name)], inside)

        out = self.folder / "quickstart"
        said = run(REPOSITORY / "deploy" / "quickstart", "--wheel", wheels / names[0], "--out", out, "--cells", 8, "--frames", 8)
        self.assertIn("quickstart: done", said)
        self.assertEqual((out / "contacts.png").read_bytes()[:8], b"\x89PNG\r\n\x1a\n")
        self.assertEqual((out / "contacts.gif").read_bytes()[:6], b"GIF89a")
        self.check_example(out / "venv" / "bin" / "python")
        self.check_engine_in_process(out / "venv" / "bin" / "python")

    def test_bad_words_are_refused(self):
        for words in (["--frames", "0"], ["--cells", "many"], ["--wheel", self.folder / "none.whl"], ["--what"]):
            done = subprocess.run([str(word) for word in (REPOSITORY / "deploy" / "quickstart", *words)], text=True,
                                  capture_output=True, check=False, timeout=60)
            self.assertEqual(done.returncode, 2, words)
            self.assertTrue(done.stderr)
        done = subprocess.run([REPOSITORY / "deploy" / "wheel", "--build", self.folder, self.folder / "out"], text=True,
                              capture_output=True, check=False, timeout=400)
        self.assertEqual(done.returncode, 1)
        self.assertIn("is not built", done.stderr)


if __name__ == "__main__":
    del sys.argv[1:]
    unittest.main()
