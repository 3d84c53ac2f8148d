"""Polygons as triangles: fans of convex ones, ears of others, as collidectl splits them (client/scenes/mesh_files)."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np

MAX_CONCAVE_CORNERS = 10_000  # the time to split a concave polygon grows with the square of its corners
_FLAT = 1e-12  # below this extent, or area, of a polygon of size 1 there is no plane to split it in
_ERROR_BOUND = 3.3306690738754716e-16  # Shewchuk's bound for an orientation

Point = tuple[float, float]


class ReadError(ValueError):
    """A file cannot be read. place: where in it, as it follows the file's name, such as ":3" or ": face 7"."""

    def __init__(self, message: str, place: str = "") -> None:
        super().__init__(message)
        self.place = place


def triangulate(vertices: np.ndarray, corners: np.ndarray, counts: np.ndarray, place: Callable[[int], str]) -> np.ndarray:
    """Triangles in the order of the polygons, of `counts[i]` corners each, which follow one another in `corners`."""
    sizes = counts - 2
    starts, offsets = np.cumsum(counts) - counts, np.cumsum(sizes) - sizes
    out = np.empty((int(sizes.sum()), 3), np.int64)
    for n in np.unique(counts):
        which = np.flatnonzero(counts == n)
        rows = corners[starts[which, None] + np.arange(n)]
        if n == 3:
            out[offsets[which]] = rows
            continue
        normals_are_short, points = _project(vertices[rows].astype("<f8"))
        is_fan = ~normals_are_short & _are_convex(points)
        fan = rows[is_fan]
        for i in range(2, n):
            out[offsets[which[is_fan]] + i - 2] = np.stack([fan[:, 0], fan[:, i - 1], fan[:, i]], axis=1)
        for i in map(int, np.flatnonzero(~is_fan)):
            face = int(which[i])
            split = _split(vertices[rows[i]], normals_are_short[i], points[i])
            if split is None and n > MAX_CONCAVE_CORNERS:
                raise ReadError(f"the face of {n} corners is not convex; such faces may have {MAX_CONCAVE_CORNERS}",
                                place(face))
            if split is None:
                raise ReadError(f"the face of {n} corners crosses itself", place(face))
            out[offsets[face]:offsets[face] + n - 2] = rows[i][split]
    return out


def _split(corners: np.ndarray, has_no_plane: bool, points: np.ndarray) -> np.ndarray | None:
    """Triangles of one polygon's corners; None if it crosses itself."""
    n = len(corners)
    fan = np.array([[0, i - 1, i] for i in range(2, n)])
    if has_no_plane:
        return fan if _is_straight(corners) else None  # a straight one has no area to keep
    p = [(float(x), float(y)) for x, y in points]
    if _is_convex(p):
        return fan
    if n > MAX_CONCAVE_CORNERS or _cross(p, points):
        return None
    return _EarClipping(p, points).run()


def _scaled(corners: np.ndarray) -> np.ndarray:
    """Scaled by a power of two, so that the largest coordinate of each polygon is in [0.5, 1), or 0."""
    exponents = np.frexp(np.abs(corners).max(axis=(1, 2)))[1]
    return np.ldexp(corners, -exponents[:, None, None])


def _normalised(corners: np.ndarray) -> np.ndarray:
    """Relative to the first corner, and of size 1. Scaled first so that no difference overflows."""
    corners = _scaled(corners)
    return _scaled(corners - corners[:, :1])


def _dot(a: np.ndarray, b: np.ndarray) -> Any:
    return a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2]


def _cross_product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.stack([a[..., 1] * b[..., 2] - a[..., 2] * b[..., 1], a[..., 2] * b[..., 0] - a[..., 0] * b[..., 2],
                     a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]], axis=-1)


def _is_straight(corners: np.ndarray) -> bool:
    corners = _normalised(corners[None].astype("<f8"))[0]
    areas = _cross_product(corners, corners[int(_dot(corners, corners).argmax())])
    return bool((_dot(areas, areas) <= _FLAT * _FLAT).all())


def _project(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Returns which polygons have no plane, and all corners in the plane of the Newell normal."""
    corners = _normalised(corners)
    normals = np.zeros((len(corners), 3))
    for i in range(corners.shape[1]):
        normals = normals + _cross_product(corners[:, i], corners[:, (i + 1) % corners.shape[1]])
    squares = _dot(normals, normals)
    has_no_plane = squares <= _FLAT * _FLAT
    normals = normals / np.where(has_no_plane, 1, np.sqrt(squares))[:, None]
    axes = np.abs(normals).argmin(axis=1)
    u = np.eye(3)[axes] - normals * np.take_along_axis(normals, axes[:, None], axis=1)
    u = u / np.sqrt(_dot(u, u))[:, None]
    w = _cross_product(normals, u)
    points = np.stack([_dot(corners, u[:, None]), _dot(corners, w[:, None])], axis=-1)
    return has_no_plane, np.where(np.abs(points) < 2.0 ** -200, 0.0, points)


def _are_convex(p: np.ndarray) -> np.ndarray:
    """Returns True for polygons that are strictly convex beyond rounding."""
    n = p.shape[1]
    result = np.ones(len(p), bool)
    for i in range(n):
        result &= _turns_left(p[:, i], p[:, (i + 1) % n], p[:, (i + 2) % n])
        if 0 < i < n - 1:
            result &= _turns_left(p[:, 0], p[:, i], p[:, i + 1])
        if i > 1:
            result &= _turns_left(p[:, 0], p[:, 1], p[:, i])
    return result


def _turns_left(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    left = (a[:, 0] - c[:, 0]) * (b[:, 1] - c[:, 1])
    right = (a[:, 1] - c[:, 1]) * (b[:, 0] - c[:, 0])
    return left - right > _ERROR_BOUND * (np.abs(left) + np.abs(right))


def _orientation(a: Point, b: Point, c: Point) -> int:
    """1 if the corner a, b, c turns left, -1 if it turns right, 0 if it is straight; exact."""
    left, right = (a[0] - c[0]) * (b[1] - c[1]), (a[1] - c[1]) * (b[0] - c[0])
    difference, bound = left - right, _ERROR_BOUND * (abs(left) + abs(right))
    if difference > bound:
        return 1
    if -difference > bound:
        return -1
    (ax, ay), (bx, by), (cx, cy) = (map(Fraction, p) for p in (a, b, c))
    exact = (ax - cx) * (by - cy) - (ay - cy) * (bx - cx)
    return (exact > 0) - (exact < 0)


def _is_convex(p: list[Point]) -> bool:
    n = len(p)
    return all(_orientation(p[i], p[(i + 1) % n], p[(i + 2) % n]) > 0
               and (not 0 < i < n - 1 or _orientation(p[0], p[i], p[i + 1]) > 0)
               and (i < 2 or _orientation(p[0], p[1], p[i]) > 0) for i in range(n))


def _cross(p: list[Point], points: np.ndarray) -> bool:
    """Whether two sides cross, at a corner or between corners, or run along each other in one direction. Sides may touch,
    and run along each other in opposite directions, as bridges to holes do."""
    n = len(p)
    following = np.roll(points, -1, axis=0)
    lower, upper = np.minimum(points, following), np.maximum(points, following)
    for i in range(n):
        meets = ((lower[i + 1:] <= upper[i]) & (lower[i] <= upper[i + 1:])).all(axis=1)
        for j in np.flatnonzero(meets) + i + 1:
            if _sides_cross(p, i, int(j), bool((np.maximum(lower[i], lower[j]) < np.minimum(upper[i], upper[j])).any())):
                return True
    return False


def _sides_cross(p: list[Point], i: int, j: int, overlaps: bool) -> bool:
    a, b, c, d = p[i], p[(i + 1) % len(p)], p[j], p[(j + 1) % len(p)]
    ac, ad = _orientation(a, b, c), _orientation(a, b, d)
    ca, cb = _orientation(c, d, a), _orientation(c, d, b)
    if ac * ad < 0 and ca * cb < 0:
        return True
    if ac == 0 and ad == 0:
        return (b[0] - a[0]) * (d[0] - c[0]) + (b[1] - a[1]) * (d[1] - c[1]) > 0 and overlaps
    return _goes_through(p, j, i, ac) or _goes_through(p, i, j, ca)


def _goes_through(p: list[Point], c: int, s: int, side: int) -> bool:
    """Whether the path goes from one side of side s to the other at corner c, which is on that `side` of it."""
    a, b, at = p[s], p[(s + 1) % len(p)], p[c]
    if side != 0 or at in (a, b) or not all(min(a[k], b[k]) <= at[k] <= max(a[k], b[k]) for k in (0, 1)):
        return False
    return _orientation(a, b, p[c - 1]) * _orientation(a, b, p[(c + 1) % len(p)]) < 0


class _EarClipping:
    """Why any order of ears is right stands in client/scenes/mesh_files/polygons.cpp."""

    def __init__(self, p: list[Point], points: np.ndarray) -> None:
        n = len(p)
        self._p, self._x, self._y = p, points[:, 0], points[:, 1]
        self._before, self._after = [(i - 1) % n for i in range(n)], [(i + 1) % n for i in range(n)]
        self._is_left, self._left, self._at = np.ones(n, bool), n, 0
        self._is_ear = [False] * n

    def run(self) -> np.ndarray | None:
        triangles = []
        self._find_ears()
        while self._left > 3:
            ear = self._choose()
            if ear is None:
                return None
            triangles.append([self._before[ear], ear, self._after[ear]])
            self._clip(ear)
        if self._turn(self._at) < 0:
            return None
        return np.array([*triangles, [self._before[self._at], self._at, self._after[self._at]]])

    def _turn(self, i: int) -> int:
        return _orientation(self._p[self._before[i]], self._p[i], self._p[self._after[i]])

    def _ear_at(self, i: int, least: int) -> bool:
        """Whether the triangle at the corner turns left and holds no other corner; least 0: nor has one on its sides."""
        if self._turn(i) <= 0:
            return False
        a, b, c = self._p[self._before[i]], self._p[i], self._p[self._after[i]]
        inside = self._is_left & (self._x >= min(a[0], b[0], c[0])) & (self._x <= max(a[0], b[0], c[0]))
        inside &= (self._y >= min(a[1], b[1], c[1])) & (self._y <= max(a[1], b[1], c[1]))
        return not any(
            q not in (a, b, c) and _orientation(a, b, q) >= least and _orientation(b, c, q) >= least
            and _orientation(c, a, q) >= least for q in (self._p[j] for j in np.flatnonzero(inside)))

    def _ring(self) -> list[int]:
        ring, i = [self._at], self._after[self._at]
        while i != self._at:
            ring.append(i)
            i = self._after[i]
        return ring

    def _find_ears(self) -> None:
        for i in self._ring():
            self._is_ear[i] = self._ear_at(i, 0)

    def _choose(self) -> int | None:
        """The next ear; where corners touch sides, or are straight, what still keeps the area."""
        i = self._at
        while not self._is_ear[i]:
            i = self._after[i]
            if i == self._at:
                break
        if self._is_ear[i]:
            return i
        self._find_ears()
        for test in (lambda i: self._is_ear[i], lambda i: self._ear_at(i, 1), lambda i: self._turn(i) == 0):
            for i in self._ring():
                if test(i):
                    return i
        return None

    def _clip(self, i: int) -> None:
        before, after = self._before[i], self._after[i]
        self._after[before], self._before[after] = after, before
        self._is_left[i] = False
        self._left -= 1
        for j in (before, after):
            self._is_ear[j] = self._ear_at(j, 0)
        self._at = after
