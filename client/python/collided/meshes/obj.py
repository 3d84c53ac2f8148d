"""OBJ: lines "v x y z", "f a b c ...", "l a b ..." and "p a ..."; indices may be a/b/c, and negative ones count back."""

from __future__ import annotations

import re

import numpy as np

from collided.meshes.polygons import ReadError
from collided.meshes.raw import (RawMesh, count_text, divided, fast_numbers, float_table, lines_of, no_rows, number,
                                 vertices_there, without_mark)

_AFTER_SLASH = re.compile(rb"(?<=\S)/\S*")
_KEYS = {key + end: key[0] for key in (b"v", b"f", b"l", b"p") for end in (b"", b" ")}
_BLANKS = bytes.maketrans(b"\t\x0b\x0c", b"   ")
_COMMENT = re.compile(rb"#.*")


def read_obj(data: bytes, _path: str) -> RawMesh:
    lines = _logical_lines(lines_of(without_mark(data)))
    keys = np.fromiter((_KEYS.get(line[:2].translate(_BLANKS), 0) for line in lines), np.uint8, len(lines))
    vertex_lines = np.flatnonzero(keys == ord("v"))
    mesh = RawMesh(vertices=_vertices(lines, vertex_lines))
    for key in "flp":
        at = np.flatnonzero(keys == ord(key))
        corners, counts = _words(lines, at)
        before = np.searchsorted(vertex_lines, np.repeat(at, counts))
        indices = _from_zero(corners, before, len(mesh.vertices), np.repeat(at, counts))
        if key == "f":
            mesh.corners, mesh.counts, mesh.lines = indices, counts, at + 1
        elif key == "l":
            mesh.edges = _segments(indices, counts, at)
        else:
            mesh.points = indices
    return mesh


def _logical_lines(lines: list[bytes]) -> list[bytes]:
    """Strips comments, and joins a line that ends in a backslash with the next one, which is left empty."""
    lines = [_COMMENT.sub(b"", line) if b"#" in line else line for line in lines]
    at = 0
    while at < len(lines):
        end = at
        while end < len(lines) and lines[end].endswith(b"\\"):
            end += 1
        if end > at:
            chain = lines[at:end + 1]
            lines[at:end + 1] = [b" ".join(line.removesuffix(b"\\") for line in chain), *[b""] * (len(chain) - 1)]
        at = end + 1
    return [line.strip() for line in lines]


def _vertices(lines: list[bytes], at: np.ndarray) -> np.ndarray:
    """Three coordinates; a fourth number alone is a weight w, three or four more are a colour."""
    rows = [lines[i].split()[1:] for i in at]
    if not rows:
        return np.empty((0, 3))
    counts = np.fromiter(map(len, rows), int, len(rows))
    bad = np.flatnonzero((counts < 3) | (counts == 5) | (counts > 7))
    if bad.size and counts[bad[0]] < 3:
        float_table([rows[bad[0]]], [at[bad[0]] + 1])  # names a word that is no number, rather
        raise ReadError("a number is missing", f":{at[bad[0]] + 1}")
    if bad.size:
        raise ReadError(f"the vertex has {counts[bad[0]]} numbers; it needs 3, 4 with a weight, or 6 or 7 with a colour",
                        f":{at[bad[0]] + 1}")
    vertices = float_table([row[:3] for row in rows], at + 1)
    for i in np.flatnonzero(counts == 4):
        place = f":{at[i] + 1}"
        vertices[i] = divided(vertices[i].tolist(), number(rows[i][3], place), place)
    return vertices


def _words(lines: list[bytes], at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """All indices of these lines, and how many each has."""
    rows = [_AFTER_SLASH.sub(b"", lines[i]).split()[1:] for i in at]
    counts = np.fromiter(map(len, rows), int, len(rows))
    indices = fast_numbers([word for row in rows for word in row], int)
    if indices is None:
        slow = [number(word, f":{i + 1}", int) for row, i in zip(rows, at) for word in row]
        indices = np.clip(np.array(slow, object), -2 ** 62, 2 ** 62).astype(np.int64)
    return indices, counts


def _from_zero(corners: np.ndarray, before: np.ndarray, vertices: int, line: np.ndarray) -> np.ndarray:
    """Indices from 0; `before`: vertices that precede each one's line."""
    index = np.where(corners < 0, corners + before, corners - 1)
    bad = np.flatnonzero((index < 0) | (index >= vertices))
    if bad.size:
        there = f"; {vertices_there(vertices)}" if corners[bad[0]] > 0 else ""
        raise ReadError(f"vertex index {corners[bad[0]]} is out of range{there}", f":{line[bad[0]] + 1}")
    return index


def _segments(corners: np.ndarray, counts: np.ndarray, line: np.ndarray) -> np.ndarray:
    """A line of several vertices is as many edges, less one."""
    few = np.flatnonzero(counts < 2)
    if few.size:
        raise ReadError(f"the line has {count_text(int(counts[few[0]]), 'vertex', 'vertices')}; it needs 2", f":{line[few[0]] + 1}")
    is_last = np.zeros(len(corners), bool)
    is_last[np.cumsum(counts) - 1] = True
    at = np.flatnonzero(~is_last)
    return np.stack([corners[at], corners[at + 1]], axis=1) if at.size else no_rows(2)
