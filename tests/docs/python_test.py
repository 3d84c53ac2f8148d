#!/usr/bin/env python3
"""Programs of the pages that use the Python package, against a real daemon: they print what the pages show.

usage: python_test.py DAEMON PYTHON_PACKAGE REPOSITORY
"""

import pathlib
import sys
import unittest

try:
    import grpc  # noqa: F401
    import numpy  # noqa: F401
except ImportError as missing:
    print(f"skipped: {missing} (Debian: python3-grpcio, python3-numpy)")
    sys.exit(77)

DAEMON, PACKAGE, REPOSITORY = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3])
sys.path.insert(0, str(REPOSITORY / "tests" / "interop"))
from daemon import Daemon  # noqa: E402
from markdown import Page  # noqa: E402
from run_page import run_with_package  # noqa: E402

FRAMES = """
import collided, numpy as np
vertices = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0], [1, 1, 1], [1.25, 1, 9], [1, 1.25, 9]], "f4")
triangles = [[0, 1, 2], [3, 4, 5]]
frames = [vertices - np.array([[0, 0, 2 * (i > 2)] for i in range(6)], "f4")]
"""


class Pages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon(DAEMON)
        cls.addClassCleanup(cls.daemon.kill)

    def printed_by(self, program):
        return run_with_package(program, self.daemon.address, PACKAGE)

    def test_they_print_what_the_programs_in_cpp_do(self):
        for name, count in (("MODELLING", 2), ("EDITING", 1)):
            page = Page(REPOSITORY / "client" / f"{name}.md")
            programs = page.blocks("python")
            self.assertEqual(len(programs), count)
            for program, shown in zip(programs, page.blocks("text"), strict=True):
                self.assertEqual(self.printed_by(program), shown)

    def test_the_tutorial_is_one_program(self):
        page = Page(REPOSITORY / "client" / "TUTORIAL.md")
        self.assertEqual(self.printed_by("\n".join(page.blocks("python"))), "".join(page.blocks("text")))

    def test_the_first_example(self):
        program = Page(REPOSITORY / "client" / "EXAMPLES.md").blocks("python")[0]
        printed = self.printed_by(program)
        self.assertEqual(printed, "vertex 3, triangle 0, t = 0.500000000\n")
        self.assertIn(f"# {printed}", program)

    def test_the_five_lines_of_the_clients(self):
        (program,) = Page(REPOSITORY / "client" / "README.md").blocks("python")
        self.assertLessEqual(len(program.splitlines()), 5)
        self.assertEqual(self.printed_by(program), "[[3 0]] [0.5]\n")

    def test_the_lines_of_the_readme(self):
        (program,) = Page(REPOSITORY / "README.md").blocks("python")
        self.assertEqual(self.printed_by(FRAMES + program), "[[3 0]] [0.5]\n")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
