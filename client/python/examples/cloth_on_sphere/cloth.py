"""Cloth as XPBD: distances that are kept, each with a compliance, projected colour by colour."""

from dataclasses import dataclass

import numpy as np

# What holds a cell together: neighbours along rows and columns, diagonals, and second neighbours against bending, each
# with its compliance in m/N: how much it yields.
STRETCH, SHEAR, BEND = 0.0, 0.1, 3.0
DIRECTIONS = [((0, 1), STRETCH), ((1, 0), STRETCH), ((1, 1), SHEAR), ((1, -1), SHEAR), ((0, 2), BEND), ((2, 0), BEND)]


@dataclass
class Group:
    """Pairs of vertices, no two of which share a vertex: projecting them at once is a Gauss-Seidel sweep."""

    a: np.ndarray
    b: np.ndarray
    length: np.ndarray
    compliance: float

    def project(self, p, lambdas, time_step, mass):
        """Moves both vertices of each pair half of the way to their length; less, if they yield."""
        apart = p[self.a] - p[self.b]
        now = np.sqrt(np.einsum("ij,ij->i", apart, apart))
        yielding = self.compliance / time_step**2
        change = (self.length - now - yielding * lambdas) / (2 / mass + yielding)
        lambdas += change
        moved = apart * (change / (mass * np.maximum(now, 1e-12)))[:, None]
        p[self.a] += moved
        p[self.b] -= moved


class Cloth:
    """Distances of a grid of rows x rows vertices, as long as they are in `rest`. mass: of a vertex."""

    def __init__(self, rest, mass):
        self.mass = mass
        rows = int(round(len(rest)**0.5))
        self.groups = [Group(a, b, np.linalg.norm(rest[a] - rest[b], axis=1), compliance)
                       for step, compliance in DIRECTIONS for a, b in colours(rows, *step)]

    def lambdas(self):
        """The multipliers of a time step's begin."""
        return [np.zeros(len(group.a)) for group in self.groups]

    def project(self, p, lambdas, time_step):
        """One sweep over all distances, in place."""
        for group, own in zip(self.groups, lambdas):
            group.project(p, own, time_step, self.mass)


def colours(rows, down, right):
    """The pairs (i, j), (i + down, j + right) of a grid in two halves, in each of which no vertex is in two pairs."""
    i, j = np.mgrid[:rows - down, max(0, -right):rows - max(0, right)].reshape(2, -1)
    a, b = i * rows + j, (i + down) * rows + j + right
    odd = (i // down if down else j // right) % 2 == 1
    return [(a[half], b[half]) for half in (~odd, odd)]
