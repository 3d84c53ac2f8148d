"""Meshes that the nodes of glTF and COLLADA place, joined into one."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from collided.meshes.polygons import ReadError
from collided.meshes.raw import RawMesh, count_text, no_rows, weld

MAX_DEPTH = 256
_MAX_COPIED = 1 << 25  # vertices and corners of repeated meshes, which take no bytes in the file
IDENTITY = np.eye(4)


@dataclass
class Part:
    """A mesh that one node places."""

    vertices: list[np.ndarray] = field(default_factory=list)
    faces: list[np.ndarray] = field(default_factory=list)  # each of rows of equal length
    edges: list[np.ndarray] = field(default_factory=list)
    points: list[np.ndarray] = field(default_factory=list)

    @property
    def vertex_count(self) -> int:
        return sum(map(len, self.vertices))


class Placer:
    """Moves and joins parts. welds: equal positions of a part become one vertex."""

    def __init__(self, welds: bool) -> None:
        self._welds = welds
        self._parts: list[tuple[np.ndarray, Part, np.ndarray]] = []
        self._first = self._copied = self._welded = 0
        self._seen: set[object] = set()

    def place(self, key: object, transform: np.ndarray, part: Part) -> None:
        vertices = np.concatenate([np.empty((0, 3), "<f4"), *part.vertices])
        if key in self._seen:
            self._copied += len(vertices) + sum(face.size for face in part.faces)
        self._seen.add(key)
        if self._copied > _MAX_COPIED:
            raise ReadError(f"its nodes repeat meshes to more than {_MAX_COPIED} vertices and corners")
        if not np.array_equal(transform, IDENTITY):
            vertices = vertices.astype("<f8")
            x, y, z = vertices.T
            vertices = np.stack([row[0] * x + row[1] * y + row[2] * z + row[3] for row in transform[:3]], axis=1)
            if not np.isfinite(vertices).all():
                raise ReadError("a node moves a vertex to a position that is not finite")
        index = np.arange(len(vertices))
        if self._welds:
            before = len(vertices)
            vertices, index = weld(vertices)
            self._welded += before - len(vertices)
        moved = Part([], [self._first + index[face[:, ::-1] if _is_mirror(transform) else face] for face in part.faces],
                     [self._first + index[edge] for edge in part.edges], [self._first + index[point] for point in part.points])
        self._parts.append((vertices, moved, index))
        self._first += len(vertices)

    def mesh(self) -> RawMesh:
        faces = [face for _, part, _ in self._parts for face in part.faces]
        mesh = RawMesh(
            vertices=np.concatenate([np.empty((0, 3), "<f4"), *(vertices for vertices, _, _ in self._parts)]),
            corners=np.concatenate([np.empty(0, np.int64), *(face.ravel() for face in faces)]),
            counts=np.concatenate([np.empty(0, np.int64), *(np.full(len(face), face.shape[1]) for face in faces)]),
            edges=np.concatenate([no_rows(2), *(edge for _, part, _ in self._parts for edge in part.edges)]),
            points=np.concatenate([np.empty(0, np.int64), *(point for _, part, _ in self._parts for point in part.points)]))
        if len(self._parts) > 1:
            mesh.notes.append(f"joined {count_text(len(self._parts), 'mesh', 'meshes')} into one")
        if self._welded:
            mesh.notes.append(f"welded {count_text(self._first + self._welded, 'vertex', 'vertices')} into {self._first}")
        return mesh


def _is_mirror(m: np.ndarray) -> bool:
    """Returns True if the transform turns a surface inside out."""
    return (m[0, 0] * (m[1, 1] * m[2, 2] - m[1, 2] * m[2, 1]) - m[0, 1] * (m[1, 0] * m[2, 2] - m[1, 2] * m[2, 0])
            + m[0, 2] * (m[1, 0] * m[2, 1] - m[1, 1] * m[2, 0])) < 0


def product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Multiplies affine transforms, in the order of operations that collidectl uses."""
    out = np.eye(4)
    for r in range(3):
        for c in range(4):
            out[r, c] = a[r, 0] * b[0, c] + a[r, 1] * b[1, c] + a[r, 2] * b[2, c] + (a[r, 3] if c == 3 else 0.0)
    return out
