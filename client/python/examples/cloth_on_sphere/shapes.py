"""Meshes of the simulation: vertices (n, 3) and triangles (n, 3)."""

import numpy as np


def grid_triangles(rows, columns):
    """Triangles of a grid of rows x columns vertices; diagonals alternate, so that no direction is stiffer."""
    i, j = np.mgrid[:rows - 1, :columns - 1]
    a = (i * columns + j).ravel()
    b, c, d = a + 1, a + columns, a + columns + 1
    even = ((i + j) % 2 == 0).ravel()[:, None]
    first = np.where(even, np.stack([a, b, d], 1), np.stack([a, b, c], 1))
    second = np.where(even, np.stack([a, d, c], 1), np.stack([b, d, c], 1))
    return np.concatenate([first, second])


def sheet(cells, side, height):
    """A square about the z axis, of cells x cells; not quite flat, so that nothing is balanced on an edge."""
    y, x = side * (np.mgrid[:cells + 1, :cells + 1] / cells - 0.5)
    z = height + 0.002 * np.sin(9 * x + 5 * y)
    return np.stack([x, y, z], axis=2).reshape(-1, 3), grid_triangles(cells + 1, cells + 1)


def sphere(radius, height, meridians=32, parallels=16):
    """A sphere about the z axis, poles included."""
    down = np.pi * np.arange(1, parallels)[:, None] / parallels
    around = 2 * np.pi * np.arange(meridians)[None, :] / meridians
    rings = radius * np.stack(np.broadcast_arrays(np.sin(down) * np.cos(around), np.sin(down) * np.sin(around),
                                                  np.cos(down)), axis=2).reshape(-1, 3)
    vertices = np.concatenate([rings, [[0, 0, radius], [0, 0, -radius]]]) + [0, 0, height]
    north, south, last = len(rings), len(rings) + 1, len(rings) - meridians
    k = np.arange(meridians)
    after = (k + 1) % meridians
    ring = meridians * np.arange(parallels - 2)[:, None]
    a, b = (ring + k).ravel(), (ring + after).ravel()
    parts = [(a, a + meridians, b), (b, a + meridians, b + meridians), (np.full(meridians, north), k, after),
             (np.full(meridians, south), last + after, last + k)]
    return vertices, np.concatenate([np.stack(part, axis=1) for part in parts])


def floor(side):
    """A square at height 0."""
    return side / 2 * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]), np.array([[0, 1, 2], [0, 2, 3]])
