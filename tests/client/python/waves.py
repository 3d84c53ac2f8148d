"""Sheets of waves: dense meshes that meet in many places."""

import numpy as np

SIDE = 16


def grid(side=SIDE):
    """Triangles of a sheet of side * side vertices."""
    ids = np.arange(side * side).reshape(side, side)
    upper = np.stack([ids[:-1, :-1], ids[:-1, 1:], ids[1:, :-1]], -1)
    lower = np.stack([ids[:-1, 1:], ids[1:, 1:], ids[1:, :-1]], -1)
    return np.concatenate([upper.reshape(-1, 3), lower.reshape(-1, 3)])


def wave(phase, height, dtype, side=SIDE):
    """Vertices of a sheet over the unit square, about `height`."""
    x, y = np.meshgrid(np.linspace(0, 1, side), np.linspace(0, 1, side), indexing="ij")
    z = height + 0.2 * np.sin(7 * x + phase) * np.cos(5 * y)
    return np.stack([x + 0.1 * np.sin(9 * y + phase), y, z], -1).reshape(-1, 3).astype(dtype)
