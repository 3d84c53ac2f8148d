"""The same cloth with one fraction of the way for the whole scene and with one for each vertex, side by side."""

import numpy as np
from albums import sheet
from crossings import Crossings
from pictures import Painter
from simulation import Simulation

STUCK = 0.001  # a step that goes less of its way counts as stuck


def compare(cells, frames, size):
    """Simulates both without projections of contacts alone, which a solver need not have, and prints how they went. Returns the
    picture of the last frames, and how many pairs met."""
    pictures, crossed = [], 0
    for advance in ("all_or_one", "per_vertex"):
        with Simulation(cells, advance, settle=0) as simulation, Crossings(simulation) as crossings:
            ways = [step.way for _ in range(frames) for step in simulation.frame()]
            positions = simulation.session.positions
            met = crossings.count(positions)
            pictures.append(Painter(simulation, size).picture(positions, {}))
        print(f"{advance}: {np.sum(np.array(ways) < STUCK)} of {len(ways)} steps stuck, {np.mean(ways):.3f} of the motion gone, "
              f"{met} pairs meet", flush=True)
        crossed += met
    return sheet(pictures), crossed
