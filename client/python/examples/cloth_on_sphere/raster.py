"""Triangles as pixels, in numpy: an orthographic view, in which the nearest triangle of each pixel is seen."""

from dataclasses import dataclass

import numpy as np


@dataclass
class View:
    """What is seen along `direction`: `width` metres around `centre`, on a picture of (columns, rows) pixels."""

    direction: tuple[float, float, float]
    centre: tuple[float, float, float]
    width: float
    size: tuple[int, int]

    def __post_init__(self):
        forward = np.array(self.direction) / np.linalg.norm(self.direction)
        right = np.cross(forward, [0, 0, 1])
        right /= np.linalg.norm(right)
        self.axes = np.stack([right, np.cross(forward, right), forward])

    def project(self, points):
        """Column, row and depth of points: (n, 3), in pixels, the last in metres."""
        seen = (points - np.array(self.centre)) @ self.axes.T
        seen[:, :2] = seen[:, :2] * (self.size[0] / self.width) + np.array(self.size) / 2
        return seen


@dataclass
class Pixels:
    """Of each pixel that a triangle covers: its number, the triangle, the weights of its corners, the depth."""

    number: np.ndarray
    triangle: np.ndarray
    weights: np.ndarray
    depth: np.ndarray

    def __getitem__(self, rows):
        return Pixels(self.number[rows], self.triangle[rows], self.weights[rows], self.depth[rows])


def rasterize(view, vertices, triangles):
    """The pixels of a view, each with the triangle nearest to the viewer."""
    corners = view.project(vertices)[triangles]
    triangle, pixel = _in_boxes(corners, view.size)
    sides = corners[triangle, :, :2] - pixel[:, None, :]
    a, b, c = sides.transpose(1, 2, 0)
    weights = np.stack([_area(b, c), _area(c, a), _area(a, b)], axis=1)
    total = weights.sum(axis=1)
    weights /= np.where(total == 0, np.nan, total)[:, None]
    covered = (weights >= 0).all(axis=1)
    triangle, pixel, weights = triangle[covered], pixel[covered], weights[covered]
    depth = np.einsum("ij,ij->i", weights, corners[triangle, :, 2])
    pixels = Pixels(pixel[:, 1] * view.size[0] + pixel[:, 0], triangle, weights, depth)
    pixels = pixels[np.lexsort((depth, pixels.number))]
    return pixels[np.unique(pixels.number, return_index=True)[1]]


def _in_boxes(corners, size):
    """The pixels in the box around each triangle, as triangles and (column, row)."""
    low = np.clip(np.ceil(corners[:, :, :2].min(axis=1)), 0, None).astype(int)
    high = np.clip(np.floor(corners[:, :, :2].max(axis=1)), None, np.array(size) - 1).astype(int)
    box = np.maximum(0, high - low + 1)
    count = box.prod(axis=1)
    triangle = np.repeat(np.arange(len(corners)), count)
    k = np.arange(len(triangle)) - np.repeat(np.cumsum(count) - count, count)
    return triangle, low[triangle] + np.stack([k % box[triangle, 0], k // box[triangle, 0]], axis=1)


def _area(a, b):
    return a[0] * b[1] - a[1] * b[0]
