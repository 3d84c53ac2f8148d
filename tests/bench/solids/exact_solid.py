"""Decides in rational numbers where points are to a closed mesh. It shares no code with what it judges.

Coordinates are whole multiples of 1 / _SCALE, which makes most of the arithmetic that of integers. Floats only leave out triangles that
are certainly of no account, with margins far above their errors.
"""

from fractions import Fraction
from typing import NamedTuple

import numpy as np

_DIRECTIONS = ((7919, 3571, 2741), (-3001, 7043, 1511), (1733, -2969, 6947), (-5501, -1201, 4099), (6203, 811, -9973))
_MARGIN = 1e-9  # of the size of what is compared
_SCALE = 2**256
_ON = float("inf")  # in place of a winding number


class Place(NamedTuple):
    """winding: how often the mesh encloses the point. squared_distance: 0 on the surface, None outside."""

    winding: int
    squared_distance: Fraction | None

    @property
    def is_on(self):
        return self.squared_distance == 0

    @property
    def is_inside(self):
        return not self.is_on and self.winding >= 1


class ExactSolid:
    def __init__(self, vertices, triangles):
        self.vertices, self.triangles = np.asarray(vertices, float), np.asarray(triangles)
        self.lower, self.upper = self.vertices.min(axis=0), self.vertices.max(axis=0)
        self.corners = self.vertices[self.triangles]
        self.centers = self.corners.mean(axis=1)
        self.radii = np.linalg.norm(self.corners - self.centers[:, None], axis=2).max(axis=1)
        self.rays = [_Ray(direction, self.corners) for direction in _DIRECTIONS]

    def place(self, point):
        """Returns the Place of a point, whose coordinates are taken as they are, to the last bit."""
        point = np.asarray(point, float)
        if (point < self.lower).any() or (point > self.upper).any():
            return Place(0, None)
        winding = self._winding(point)
        if winding == _ON:
            return Place(0, Fraction(0))
        return Place(winding, self._squared_distance(point) if winding >= 1 else None)

    def _winding(self, point):
        for ray in self.rays:
            candidates = ray.candidates(point)
            winding = _winding(_exact(point), [[_exact(corner) for corner in self.corners[t]] for t in candidates], ray.direction)
            if winding is not None:
                return winding
        raise ValueError(f"every ray from {point} meets an edge")

    def _near(self, point):
        """Returns the triangles that may be the nearest."""
        away = np.linalg.norm(self.centers - point, axis=1)
        near = np.flatnonzero(away - self.radii <= away.min() * (1 + _MARGIN))
        distances = _distances(self.corners[near] - point)
        return near[distances <= distances.min() + _MARGIN * self.radii[near]]

    def _squared_distance(self, point):
        near, point = self._near(point), _exact(point)
        return min(_to_triangle(*(_minus(_exact(corner), point) for corner in self.corners[t])) for t in near) / _SCALE**2


class _Ray:
    """Boxes of the triangles as seen along a direction."""

    def __init__(self, direction, corners):
        x, y, z = direction
        self.direction = direction
        self.across = np.array([[y, -x, 0], [0, z, -y]], float).T
        seen = corners @ self.across
        margin = _MARGIN * np.abs(seen).max()
        self.lower, self.upper = seen.min(axis=1) - margin, seen.max(axis=1) + margin

    def candidates(self, point):
        seen = point @ self.across
        return np.flatnonzero(((self.lower <= seen) & (seen <= self.upper)).all(axis=1))


def _winding(point, triangles, direction):
    """Counts the triangles through which the ray leaves, less those through which it enters. Returns None if it meets an edge, _ON for
    a point of a triangle."""
    winding, meets_edge = 0, False
    for corners in triangles:
        a, b, c = (_minus(corner, point) for corner in corners)
        sides = [_dot(direction, _cross(*pair)) for pair in ((b, c), (c, a), (a, b))]
        if min(sides) < 0 < max(sides):
            continue
        volume = _dot(a, _cross(b, c))
        if volume == 0 and _to_triangle(a, b, c) == 0:
            return _ON
        meets_edge |= 0 in sides
        is_ahead = (volume > 0) == (sides[0] > 0)
        winding += is_ahead * (1 if sides[0] > 0 else -1)
    return None if meets_edge else winding


def _to_triangle(a, b, c):
    """Returns the squared distance of the origin to a triangle that has an area."""
    normal = _cross(_minus(b, a), _minus(c, a))
    if all(_dot(normal, _cross(*pair)) >= 0 for pair in ((a, b), (b, c), (c, a))):
        return Fraction(_dot(a, normal) ** 2, _dot(normal, normal))
    return min(_to_segment(*pair) for pair in ((a, b), (b, c), (c, a)))


def _to_segment(a, b):
    along = _minus(b, a)
    way, length2 = -_dot(a, along), _dot(along, along)
    if 0 < way < length2:
        return _dot(a, a) - Fraction(way**2, length2)
    return Fraction(_dot(a, a) if way <= 0 else _dot(b, b))


def _distances(corners):
    """Returns distances of the origin to triangles, in floats."""
    a, b, c = corners.transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    faces = np.all([np.einsum("ij,ij->i", normal, np.cross(p, q)) >= 0 for p, q in ((a, b), (b, c), (c, a))], axis=0)
    out = np.min([_segment_distances(p, q) for p, q in ((a, b), (b, c), (c, a))], axis=0)
    to_plane = np.abs(np.einsum("ij,ij->i", a, normal)) / np.linalg.norm(normal, axis=1)
    return np.where(faces, np.minimum(to_plane, out), out)


def _segment_distances(a, b):
    along = b - a
    t = np.clip(-np.einsum("ij,ij->i", a, along) / np.einsum("ij,ij->i", along, along), 0, 1)
    return np.linalg.norm(a + t[:, None] * along, axis=1)


def _exact(point):
    ratios = [float(x).as_integer_ratio() for x in point]
    if max(denominator for _, denominator in ratios) > _SCALE:
        raise ValueError(f"{point} has coordinates that are no multiples of 2^-256")
    return tuple(numerator * (_SCALE // denominator) for numerator, denominator in ratios)


def _minus(p, q):
    return tuple(x - y for x, y in zip(p, q))


def _dot(p, q):
    return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]


def _cross(p, q):
    return p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]
