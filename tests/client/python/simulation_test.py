#!/usr/bin/env python3
"""The example that simulates a cloth on a sphere: no triangles meet beyond a common corner, and the cloth lies, folds and moves."""

import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import unittest

import numpy as np
from support import REPOSITORY, Case, main

EXAMPLE = REPOSITORY / "client" / "python" / "examples" / "cloth_on_sphere"
sys.path.insert(0, str(EXAMPLE))
import simulation  # noqa: E402
from crossings import Crossings  # noqa: E402

CELLS, FRAMES = 16, 300


class Motion(Case):
    """One run, about which each test asks something else."""

    options = ("--threads", "1")  # steps are too short for two threads to pay on a busy machine

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.crossed, cls.folds, cls.advanced, cls.ways, cls.cloth, cls.moving = [], [], [], [], [], []
        with simulation.Simulation(CELLS, server=cls.server) as sim, Crossings(sim, server=cls.server) as crossings:
            for _ in range(FRAMES):
                steps = sim.frame()
                positions = sim.session.positions
                cls.crossed.append(crossings.count(positions))
                cls.folds.append(len(sim.folds(steps[-1].near)))
                cls.advanced += [step.advanced for step in steps]
                cls.ways += [step.way for step in steps]
                cls.cloth.append(positions["cloth"].copy())
                cls.moving.append(np.mean(np.sum(sim.velocity**2, axis=1)))
            cls.on_sphere = len(steps[-1].near.between("sphere", "cloth"))

    def test_no_triangles_meet_after_any_frame(self):
        self.assertEqual(self.crossed, [0] * FRAMES)

    def test_the_cloth_lies_on_the_sphere(self):
        self.assertGreater(self.on_sphere, 0)
        top = simulation.HEIGHT + simulation.RADIUS
        self.assertTrue(0 < self.cloth[-1][:, 2].max() - top < 3 * simulation.REACH)
        self.assertGreater(self.cloth[-1][:, 2].min(), simulation.MIN_SEPARATION)

    def test_it_folds_onto_itself(self):
        self.assertGreater(max(self.folds), 10)
        self.assertGreater(sum(count > 0 for count in self.folds), FRAMES / 10)

    def test_it_is_not_frozen_and_loses_the_energy_of_its_fall(self):
        self.assertGreater(statistics.median(self.advanced), 0.99)
        self.assertGreater(min(self.ways), 0.9)
        self.assertGreater(min(self.moving), 0)
        self.assertLess(self.moving[-1], max(self.moving) / 4)
        self.assertLess(self.cloth[-1][:, 2].mean(), self.cloth[0][:, 2].mean() - 0.2)

    def test_it_is_not_frozen_where_no_projection_of_contacts_comes_last(self):
        """With one fraction for the whole scene, 567 of the 600 steps are stuck."""
        with simulation.Simulation(CELLS, settle=0, server=self.server) as sim, Crossings(sim, server=self.server) as crossings:
            for _ in range(FRAMES):
                self.assertGreater(min(step.way for step in sim.frame()), 0.5)
                self.assertEqual(crossings.count(sim.session.positions), 0)
            self.assertLess(sim.session.positions["cloth"][:, 2].mean(), self.cloth[0][:, 2].mean() - 0.2)

    def test_a_second_try_by_what_limits_it_goes_all_the_way(self):
        """With none 52 of the 600 steps do."""
        with (simulation.Simulation(CELLS, settle=0, tries=1, server=self.server) as sim,
              Crossings(sim, server=self.server) as crossings):
            ways = []
            for _ in range(FRAMES):
                ways += [step.way for step in sim.frame()]
                self.assertEqual(crossings.count(sim.session.positions), 0)
            self.assertGreater(min(ways), 0.99)
            self.assertGreater(ways.count(1), 0.95 * len(ways))
            self.assertLess(sim.session.positions["cloth"][:, 2].mean(), self.cloth[0][:, 2].mean() - 0.2)

    def test_it_is_the_same_to_the_bit_each_time(self):
        frames = 50
        with simulation.Simulation(CELLS, server=self.server) as sim:
            for _ in range(frames):
                sim.frame()
            self.assertEqual(sim.session.positions["cloth"].tobytes(), self.cloth[frames - 1].tobytes())


class Program(Case):
    """The example as it is run."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def printed(self, *options):
        done = subprocess.run([sys.executable, EXAMPLE, "--cells", "8", "--frames", "4", *options], text=True,
                              capture_output=True, timeout=100, env={**os.environ, "COLLIDED_SERVER": self.server})
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_it_tells_how_it_goes(self):
        self.assertEqual(self.printed(), "frame 4: 0 pairs met so far, 0 contacts, 0 of folds, "
                                         "advanced 1.000 (least 1.000)\n")

    def test_it_draws_what_moves(self):
        try:
            from PIL import Image
        except ImportError as missing:
            self.skipTest(f"{missing} (Debian: python3-pil)")
        animation, sheet, folder = self.folder / "a.gif", self.folder / "sheet.png", self.folder / "frames"
        self.printed("--every", "2", "--size", "120", "90", "--animation", animation, "--sheet", sheet,
                     "--pictures", folder)
        self.assertEqual(sorted(path.name for path in folder.iterdir()), ["0002.png", "0004.png"])
        with Image.open(animation) as moving, Image.open(sheet) as still:
            self.assertEqual((moving.n_frames, still.size), (2, (240, 90)))
        first, second = (np.asarray(Image.open(folder / name)).astype(int) for name in ("0002.png", "0004.png"))
        red, green, blue = first.reshape(-1, 3).T
        self.assertTrue((blue > red + 50).any() and (red > blue + 50).any(), "neither cloth nor sphere is seen")
        self.assertGreater(np.abs(first - second).max(), 50)


    def test_it_draws_one_fraction_beside_one_for_each_vertex(self):
        try:
            from PIL import Image
        except ImportError as missing:
            self.skipTest(f"{missing} (Debian: python3-pil)")
        file = self.folder / "comparison.png"
        printed = self.printed("--frames", "60", "--size", "120", "90", "--compare", file).splitlines()
        self.assertRegex(printed[0], r"^all_or_one: \d+ of 120 steps stuck, 0\.\d+ of the motion gone, 0 pairs meet$")
        self.assertRegex(printed[1], r"^per_vertex: 0 of 120 steps stuck, [01]\.\d+ of the motion gone, 0 pairs meet$")
        with Image.open(file) as picture:
            self.assertEqual(picture.size, (240, 90))
            one, each = np.split(np.asarray(picture).astype(int), 2, axis=1)
        self.assertGreater(np.abs(one - each).max(), 50)


if __name__ == "__main__":
    main()
