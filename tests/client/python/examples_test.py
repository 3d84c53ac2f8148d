#!/usr/bin/env python3
"""The examples of the package and the programs of its README, with what they print."""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

from support import DAEMON, REPOSITORY, main

sys.path.insert(0, str(REPOSITORY / "tests" / "docs"))
from markdown import Page  # noqa: E402

PACKAGE = REPOSITORY / "client" / "python"
MESH = "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 1 1 0.5\nv 1.25 1 9\nv 1 1.25 9\nf 1 2 3\nf 4 5 6\n"
PRINTED = {
    "box_on_floor": "399 contacts with 19 directions\n"
                    "60 kept: [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]], [0.005] m apart\n"
                    + "".join(f"vertex {vertex} above triangle {triangle}: face\n"
                              for vertex, triangle in ((289, 324), (291, 388), (293, 328), (295, 392))),
    "box_in_box": "4.5 m: apart\n"
                  "  4 m: 'room' and 'box' touch\n"
                  "3.5 m: 'room' and 'box' overlap, 0 and 4 vertices inside, 0.5 deep\n"
                  "       vertex 8 comes out along [0. 0. 1.]\n"
                  "  3 m: 'room' and 'box' overlap, 0 and 4 vertices inside, 1 deep\n"
                  "       vertex 8 comes out along [0. 0. 1.]\n"
                  "1.5 m: 'box' inside 'room', 1.5 deep\n"
                  "  0 m: 'room' and 'box' overlap, 0 and 4 vertices inside, 1 deep\n"
                  "       vertex 9 comes out along [ 0.  0. -1.]\n",
    "first_contact": "vertex 3 meets triangle 0 at t = 0.500000000, at [1. 1. 0.]\n",
    "line_search": "first contact at 0.350, went 0.25, contacts 0, height 0.5\n",
    "scene_batch": "".join(f"250 contacts in 250 worlds, from {first} to {first + 249}\n" for first in (0, 250, 500)),
    "touching": "<Contacts of frame 1: 1 vertex-triangle>\nvertex 3 and triangle 0: 0.5 apart\n",
    "sparse_update": "28 bytes, 0 vertex meets the ceiling\n28 bytes, 1 vertex meets the ceiling\n",
    "resume_after_kill": "".join(f"frame {frame}: {int(frame == 3)} contacts, {int(frame > 2)} recreations\n"
                                 for frame in range(1, 7)),
    "rest_shape_exclusions": "nothing excluded: flat 3080, folded 11928 contacts\n"
                             "{'exclude_rings': 1, 'exclude_rest_pairs': True}: flat 0, folded 8488 contacts\n",
}


def printed_by(*words):
    return subprocess.run([sys.executable, *words], text=True, capture_output=True, timeout=60,
                          env={**os.environ, "COLLIDED_DAEMON": str(DAEMON)})


class Examples(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        mesh = pathlib.Path(folder.name, "mesh.obj")
        mesh.write_text(MESH)
        self.arguments = (mesh, "0.6")

    def test_each_prints_what_it_should(self):
        examples = {path.stem: path for path in (PACKAGE / "examples").glob("*.py")}
        self.assertEqual(examples.keys(), PRINTED.keys())
        for name, path in examples.items():
            with self.subTest(name):
                done = printed_by(path, *(self.arguments if name == "touching" else ()))
                self.assertEqual((done.stdout, done.returncode), (PRINTED[name], 0), done.stderr)

    def test_programs_of_the_page_print_what_it_shows(self):
        page = Page(PACKAGE / "README.md")
        done = printed_by("-c", "\n".join(page.blocks("python")))
        self.assertEqual((done.stdout, done.returncode), ("".join(page.blocks("text")), 0), done.stderr)


if __name__ == "__main__":
    main()
