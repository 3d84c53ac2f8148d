"""Pairs of meshes for peers.py: two bumpy balls, and small ones in which vertices, edges and faces meet, or nearly do."""

import itertools
from typing import NamedTuple

import numpy as np


class Shape(NamedTuple):
    """Triangles face outward; without any the vertices are loose points."""

    vertices: np.ndarray
    triangles: np.ndarray

    def moved(self, by):
        return Shape(self.vertices + by, self.triangles)


class Case(NamedTuple):
    """first is a solid; second a solid or loose points. state: of the pair, "" where there is none to judge; "by vertices":
    overlapping if a vertex is inside, else apart."""

    name: str
    first: Shape
    second: Shape
    state: str = ""


def box(lower, upper):
    corners = np.array(np.meshgrid(*zip(lower, upper), indexing="ij"), float).reshape(3, 8).T
    sides = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    return Shape(corners, np.array([t for a, b, c, d in sides for t in ((a, b, c), (a, c, d))]))


def reversed_shape(shape):
    return Shape(shape.vertices, shape.triangles[:, ::-1])


def together(first, second):
    return Shape(np.concatenate([first.vertices, second.vertices]),
                 np.concatenate([first.triangles, second.triangles + len(first.vertices)]))


def unit_ball(bands, sectors):
    """As tests/gpu/solid_shapes.cpp has it: around the z-axis."""
    down = np.pi * np.arange(1, bands)[:, None] / bands
    around = 2 * np.pi * np.arange(sectors) / sectors
    rings = np.stack([np.sin(down) * np.cos(around), np.sin(down) * np.sin(around), np.cos(down) + 0 * around], axis=2)
    last = (bands - 1) * sectors + 1

    def at(i, j):
        return 0 if i == 0 else last if i == bands else 1 + (i - 1) * sectors + j % sectors

    triangles = []
    for i, j in itertools.product(range(bands), range(sectors)):
        if i > 0:
            triangles.append((at(i, j), at(i + 1, j), at(i, j + 1)))
        if i + 1 < bands:
            triangles.append((at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)))
    return Shape(np.concatenate([[[0, 0, 1]], rings.reshape(-1, 3), [[0, 0, -1]]]), np.array(triangles))


def two_balls(triangles):
    """The pair of solids_bench.cpp in its first frame: about so many triangles each, the second one turned."""
    bands = round((triangles / 2) ** 0.5)
    ball = unit_ball(bands, bands)
    x, y, z = ball.vertices.T
    bumpy = ball.vertices * (1 + 0.02 * np.sin(9 * x) * np.sin(7 * y) * np.sin(8 * z))[:, None]
    x, y, z = bumpy.T
    turned = np.stack([z, 0.8 * x - 0.6 * y, 0.6 * x + 0.8 * y], axis=1) + [1.97, 0, 0.1]
    return Case("two balls", Shape(bumpy, ball.triangles), Shape(turned, ball.triangles), "overlapping")


def grid(*coordinates):
    """Loose points of which each coordinate takes all these values."""
    return Shape(np.array(list(itertools.product(coordinates, repeat=3)), float), np.empty((0, 3), int))


def turned_boxes(seed, gap):
    """A turned box, and one that points to the middle of its largest face with a corner, `gap` away from it."""
    random = np.random.default_rng(seed)
    axes = _rotation(random.normal(size=(3, 3)))
    to_diagonal = _rotation(np.array([[1, 1, 0], [1, 0, 1], [1, 0, 0]], float))[:, [1, 2, 0]]  # the last column is along (1, 1, 1)
    plate, cube = box((-1, -1, -0.5), (1, 1, 0.5)), box((0, 0, 0), (1, 1, 1))
    pointing = cube.vertices @ to_diagonal + [0.1, 0.2, 0.5 + gap]
    return Shape(plate.vertices @ axes.T, plate.triangles), Shape(pointing @ axes.T, cube.triangles)


def _rotation(columns):
    """Turns so that the first column is where it was, but of length 1."""
    q, r = np.linalg.qr(columns)
    q *= np.sign(np.diag(r))
    q[:, 2] *= np.linalg.det(q)
    return q


def small_cases():
    cube, far = box((0, 0, 0), (1, 1, 1)), 1e6
    room = together(box((0, 0, 0), (4, 4, 4)), reversed_shape(box((1, 1, 1), (3, 3, 3))))
    twice = together(box((0, 0, 0), (2, 2, 2)), box((1, 1, 1), (3, 3, 3)))
    ball = unit_ball(12, 16)
    cases = [
        Case("points at a cube's corners, edges, diagonals", cube, grid(-1, 0, 0.25, 0.5, 0.75, 1, 2)),
        Case("points at a ball's vertices' heights", ball,
             Shape(np.concatenate([ball.vertices * s for s in (0.5, 1, 1.5)]), np.empty((0, 3), int))),
        Case("points in and around a room's cavity", room, grid(-1, 0, 0.5, 1, 2, 3, 3.5, 4, 5)),
        Case("points at two cubes of one mesh", twice, grid(-1, 0, 0.5, 1, 1.5, 2, 2.5, 3, 4)),
        Case("flush, whole faces", cube, cube.moved([1, 0, 0]), "touching"),
        Case("flush, shifted", cube, cube.moved([0.25, 0.5, 1]), "touching"),
        Case("a common edge", cube, cube.moved([1, 1, 0]), "touching"),
        Case("a common corner", cube, cube.moved([1, 1, 1]), "touching"),
        Case("the same cube twice", cube, cube, "overlapping"),
        Case("half of each other, faces in line", cube, cube.moved([0.5, 0, 0]), "overlapping"),
        Case("crossed bars", box((-3, -0.5, -0.5), (3, 0.5, 0.5)), box((-0.25, -3, -0.25), (0.25, 3, 0.25)), "overlapping"),
        Case("a bar through a ball", ball, box((-2, 0.15, 0.1), (2, 0.19, 0.14)), "overlapping"),
        Case("a box in a box", box((0, 0, 0), (4, 4, 4)), box((1, 1, 1), (2, 2, 2)), "second inside"),
        Case("a box in a box, on its floor", box((0, 0, 0), (4, 4, 4)), box((1, 1, 0), (2, 2, 1)), "overlapping"),
        Case("a box in a cavity", room, box((1.5, 1.5, 1.5), (2.5, 2.5, 2.5)), "apart"),
        Case("a box that fills a cavity", room, box((1, 1, 1), (3, 3, 3)), "touching"),
        Case("a box where two cubes of one mesh are", twice, box((1.25, 1.25, 1.25), (1.75, 1.75, 1.75)), "second inside"),
        Case("1e6 away, 1e-9 deep", cube.moved([far, far, far]),
             box((far + 1 - 1e-9, far + 0.25, far + 0.25), (far + 2, far + 0.75, far + 0.75)), "overlapping"),
        Case("1e6 away, flush", cube.moved([far, far, far]), box((far + 1, far + 0.25, far + 0.25), (far + 2, far + 0.75, far + 0.75)),
             "touching"),
        Case("1e6 away, 1e-9 apart", cube.moved([far, far, far]),
             box((far + 1 + 1e-9, far + 0.25, far + 0.25), (far + 2, far + 0.75, far + 0.75)), "apart"),
    ]
    return cases + [Case(f"turned, a corner 1e-12 {word} a face", *turned_boxes(seed, gap), "by vertices")
                    for seed in range(10) for word, gap in (("from", 1e-12), ("in", -1e-12))]
