"""OBJ: lines "v x y z", "f a b c ...", "l a b ..." and "p a ..."; indices may be a/b/c, and negative ones count back."""

from __future__ import annotations

import codecs
import re
from typing import Any

import numpy as np

from collided.errors import InvalidArgument
from collided.meshes.polygons import fans

_AFTER_SLASH = re.compile(rb"/[^\s]*")
_CONTINUED = re.compile(rb"\\\r?\n")


def read_obj(data: bytes) -> dict[str, Any]:
    """Vertices and elements, as arguments of Mesh."""
    text = data.removeprefix(codecs.BOM_UTF8)
    lines = [line.strip() for line in _CONTINUED.sub(b" ", text).split(b"\n")]
    keys = np.array([line[:2].replace(b"\t", b" ") for line in lines], dtype="S2")
    vertex_lines = np.flatnonzero(keys == b"v ")
    vertices = _vertices(lines, vertex_lines)
    parts: dict[str, Any] = {"vertices": vertices}
    for key, name, elements_of in ((b"f ", "triangles", fans), (b"l ", "edges", _segments), (b"p ", "points", _each)):
        at = np.flatnonzero(keys == key)
        corners, counts = _words(lines, at)
        before = np.searchsorted(vertex_lines, np.repeat(at, counts))
        parts[name] = elements_of(_from_zero(corners, before, len(vertices), np.repeat(at, counts)), counts,
                                  f"line {key.decode().strip()!r}")
    return parts


def _vertices(lines: list[bytes], at: np.ndarray) -> np.ndarray:
    """The first three numbers of each line."""
    rows = [lines[i].split(None, 4)[1:4] for i in at]
    try:
        vertices = np.array(rows, dtype="S").astype("<f8") if rows else np.empty((0, 3))
    except ValueError as error:
        raise InvalidArgument(f"a vertex is not three numbers: {error}") from None
    if vertices.ndim != 2 or vertices.shape[1] != 3:
        raise InvalidArgument("a vertex has fewer than three numbers")
    bad = np.flatnonzero(~np.isfinite(vertices).all(axis=1))
    if bad.size:
        raise InvalidArgument(f"line {at[bad[0]] + 1}: position {vertices[bad[0]].tolist()} is not finite")
    return vertices


def _words(lines: list[bytes], at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """All indices of these lines, and how many each has."""
    rows = [_AFTER_SLASH.sub(b"", lines[i]).split()[1:] for i in at]
    counts = np.fromiter(map(len, rows), int, len(rows))
    try:
        return np.array([word for row in rows for word in row], dtype="S").astype(np.int64), counts
    except (ValueError, OverflowError) as error:
        raise InvalidArgument(f"an index is not a number: {error}") from None


def _from_zero(corners: np.ndarray, before: np.ndarray, vertices: int, line: np.ndarray) -> np.ndarray:
    """Indices from 0; `before`: vertices that precede each one's line."""
    index = np.where(corners < 0, corners + before, corners - 1)
    bad = np.flatnonzero((index < 0) | (index >= vertices))
    if bad.size:
        raise InvalidArgument(f"line {line[bad[0]] + 1}: vertex index {corners[bad[0]]} is out of range; there are "
                              f"{vertices} vertices")
    return index


def _segments(corners: np.ndarray, counts: np.ndarray, argument: str) -> np.ndarray:
    """A line of several vertices is as many edges, less one."""
    if counts.size and int(counts.min()) < 2:
        raise InvalidArgument(f"{argument} {int(counts.argmin())} has {int(counts.min())} vertices; it needs 2")
    is_last = np.zeros(len(corners), bool)
    is_last[np.cumsum(counts) - 1] = True
    at = np.flatnonzero(~is_last)
    return np.stack([corners[at], corners[at + 1]], axis=1) if at.size else np.empty((0, 2), np.int64)


def _each(corners: np.ndarray, _counts: np.ndarray, _argument: str) -> np.ndarray:
    return corners
