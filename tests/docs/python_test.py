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


# The tutorial's solver with another scene: a soft cube, whose vertices hold each other at all distances, falls down stairs.
STAIRS = """
def surface(size, cells):
    grid = np.stack(np.meshgrid(*[np.arange(cells + 1)] * 3, indexing="ij"), -1).reshape(-1, 3)
    outside = np.flatnonzero(((grid == 0) | (grid == cells)).any(axis=1))
    number = np.full(len(grid), -1)
    number[outside] = np.arange(len(outside))
    quads = []
    for axis in range(3):
        u, v = np.eye(3, dtype=int)[(axis + 1) % 3], np.eye(3, dtype=int)[(axis + 2) % 3]
        for side in (0, cells):
            for i, j in np.ndindex(cells, cells):
                at = side * np.eye(3, dtype=int)[axis] + i * u + j * v
                ring = [at, at + u, at + u + v, at + v]
                quads.append(ring if side else ring[::-1])
    a, b, c, d = number[np.array(quads) @ [(cells + 1)**2, cells + 1, 1]].T
    return size * grid[outside] / cells, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


STAIRS, RISE, RUN = 6, 0.15, 0.35
profile = [(-2, STAIRS * RISE)]
for i in range(STAIRS):
    profile += [(i * RUN, (STAIRS - i) * RISE), (i * RUN, (STAIRS - i - 1) * RISE)]
table = np.array([(x, y, z) for x, z in [*profile, (4, 0)] for y in (-1.0, 1.0)])
treads = 2 * np.arange(len(table) // 2 - 1)[:, None]
stairs = np.concatenate([treads + [0, 2, 1], treads + [1, 2, 3]])
cube, triangles = surface(0.3, 3)
k = np.array([[0, -0.2, 1], [0.2, 0, 0], [-1, 0, 0]]) / np.hypot(1, 0.2)
cloth = (cube + [-0.32, -0.15, 0.95]) @ (np.eye(3) + np.sin(0.2) * k + (1 - np.cos(0.2)) * k @ k).T + [0, 0, 0.08]
edges = np.stack(np.triu_indices(len(cloth), 1), 1)
apart = np.linalg.norm(cloth[edges[:, 0]] - cloth[edges[:, 1]], axis=1)
extent = np.ptp(cloth, axis=0).max()
edges = edges[(apart < 0.62 * extent) | (apart > 1.2 * extent)]
length = np.linalg.norm(cloth[edges[:, 0]] - cloth[edges[:, 1]], axis=1)
movable = np.concatenate([np.zeros(len(table)), np.ones(len(cloth))])
meshes = {"table": collided.Mesh(table, stairs, motion="static"), "cloth": (cloth, triangles)}
GAP = 0.004
with (collided.Session(meshes, mode="dcd_and_ccd", thickness=0.008, min_separation=0.001) as session,
      collided.Session(meshes, mode="dcd", accuracy="exact", kinds=["tt"]) as judge):
    ways, crossings = [], 0
    for step, way in zip(range(2000), simulate(session, np.full_like(cloth, [1.2, 0.1, 0]))):
        ways.append(way)
        if step % 10 == 0:
            crossings += len(judge.step({"cloth": session.positions["cloth"]}))
    x, z = session.positions["cloth"].mean(axis=0)[[0, 2]]
    print(min(ways), crossings, np.mean(ways), x, z)
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

    def test_the_tutorials_solver_never_stops_a_jelly_cube_on_stairs(self):
        """With one fraction of the way for the whole scene, 1,800 of the 2,000 steps stop it."""
        *parts, _ = Page(REPOSITORY / "client" / "TUTORIAL.md").blocks("python")
        printed = run_with_package("\n".join([*parts, STAIRS]), self.daemon.address, PACKAGE, timeout=230)
        least, crossings, mean, x, z = map(float, printed.splitlines()[-1].split())
        self.assertEqual(crossings, 0)
        self.assertGreater(least, 0.5)
        self.assertGreater(mean, 0.99)
        self.assertGreater(x, 2)  # at the bottom
        self.assertLess(z, 0.2)

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
        page = Page(REPOSITORY / "README.md")
        (program,), (shown,) = page.blocks("python"), page.blocks("text")
        self.assertEqual(self.printed_by(program), shown)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
