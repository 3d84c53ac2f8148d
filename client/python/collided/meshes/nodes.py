"""Meshes that the nodes of glTF and COLLADA place, joined into one."""

from __future__ import annotations

import numpy as np

from collided.meshes.polygons import ReadError
from collided.meshes.raw import RawMesh, count_text, no_rows, weld

MAX_DEPTH = 256
_ALLOWANCE, _PER_BYTE, _PER_NODE = 1 << 23, 4, 64

# Three rows of four: Python's floats multiply faster than small arrays.
Transform = tuple[tuple[float, ...], ...]
IDENTITY: Transform = ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0))


class Expansion:
    """Limits what a mesh file can expand to.

    Meshes that nodes repeat, and arrays that several meshes share, take no bytes in the file. This counts what they make, before
    it is made. The limit follows from the size of the file, so that no file is refused for what it holds only once.
    """

    def __init__(self, data: bytes) -> None:
        self.bytes = len(data)  # with those of the files that it names
        self._used = 0

    def count(self, elements: int) -> None:
        """Counts vertices, corners of faces, ends of edges, and points."""
        self._used += elements
        limit = _ALLOWANCE + _PER_BYTE * self.bytes
        if self._used > limit:
            raise ReadError(f"expands to more than {limit} vertices and corners (a node counts as {_PER_NODE}), "
                            f"the limit for {count_text(self.bytes, 'byte')}")

    def count_node(self) -> None:
        self.count(_PER_NODE)


class Part:
    """A mesh that nodes place. faces: arrays of rows of equal length."""

    def __init__(self, vertices: list[np.ndarray], faces: list[np.ndarray], edges: list[np.ndarray], points: list[np.ndarray]) -> None:
        self.vertices = np.concatenate([np.empty((0, 3), "<f4"), *vertices])
        self.faces = [face for face in faces if len(face)]
        self.edges = np.concatenate([no_rows(2), *edges])
        self.points = np.concatenate([np.empty(0, np.int64), *points])
        self.size = len(self.vertices) + self.edges.size + len(self.points) + sum(face.size for face in self.faces)


class Placer:
    """Moves and joins parts. welds: equal positions of a part become one vertex."""

    def __init__(self, expansion: Expansion, welds: bool) -> None:
        self._expansion, self._welds = expansion, welds
        self._vertices: list[np.ndarray] = [np.empty((0, 3), "<f4")]
        self._faces: list[np.ndarray] = []
        self._edges, self._points = [no_rows(2)], [np.empty(0, np.int64)]
        self._placed = self._first = self._welded = 0

    def place(self, part: Part, transform: Transform, is_counted: bool) -> None:
        """is_counted: what the part expands to was counted as it was read."""
        if not part.size:
            return
        if not is_counted:
            self._expansion.count(part.size)
        vertices = part.vertices if transform == IDENTITY else _moved(part.vertices, transform)
        index = np.arange(len(vertices))
        if self._welds:
            vertices, index = weld(vertices)
            self._welded += len(index) - len(vertices)
        index += self._first
        is_mirror = _is_mirror(transform)
        self._vertices.append(vertices)
        self._faces += [index[face[:, ::-1] if is_mirror else face] for face in part.faces]
        if part.edges.size:
            self._edges.append(index[part.edges])
        if part.points.size:
            self._points.append(index[part.points])
        self._first += len(vertices)
        self._placed += 1

    def mesh(self) -> RawMesh:
        mesh = RawMesh(
            vertices=np.concatenate(self._vertices),
            corners=np.concatenate([np.empty(0, np.int64), *(face.ravel() for face in self._faces)]),
            counts=np.concatenate([np.empty(0, np.int64), *(np.full(len(face), face.shape[1]) for face in self._faces)]),
            edges=np.concatenate(self._edges), points=np.concatenate(self._points))
        if self._placed > 1:
            mesh.notes.append(f"joined {count_text(self._placed, 'mesh', 'meshes')} into one")
        if self._welded:
            mesh.notes.append(f"welded {count_text(self._first + self._welded, 'vertex', 'vertices')} into {self._first}")
        return mesh


def _moved(vertices: np.ndarray, transform: Transform) -> np.ndarray:
    x, y, z = vertices.astype("<f8").T
    moved = np.stack([a * x + b * y + c * z + d for a, b, c, d in transform], axis=1)
    if not np.isfinite(moved).all():
        raise ReadError("a node moves a vertex to a position that is not finite")
    return moved


def _is_mirror(m: Transform) -> bool:
    """Returns True if the transform turns a surface inside out."""
    return (m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])) < 0


def product(a: Transform, b: Transform) -> Transform:
    """Multiplies affine transforms, in the order of operations that collidectl uses."""
    p, q, r = b
    return tuple((x * p[0] + y * q[0] + z * r[0] + 0.0, x * p[1] + y * q[1] + z * r[1] + 0.0,
                  x * p[2] + y * q[2] + z * r[2] + 0.0, x * p[3] + y * q[3] + z * r[3] + t) for x, y, z, t in a)
