"""A mesh of a scene."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from collided.arrays import UINT32_MAX, check_below, check_length, ids, is_whole, points
from collided.choices import check_flag, check_text, choice, word
from collided.errors import InvalidArgument
from collided.meshes.files import read_mesh_file
from collided.meshes.foreign import parts_of
from collided.v1 import scene_pb2


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles, loose edges (hair, threads) and loose points (particles), of any of which it has one or more.

    vertices: float[n][3], where the mesh is before the first frame, in the unit of the positions; a scene that is given
        them begins there, and frames need not name meshes that stand still. None: the first frame has them.
    triangles, edges, points: integers of shape (n, 3), (n, 2), (n,): vertex numbers within the mesh. All arrays are numpy's
        once the mesh is made: copies, read-only.
    name: 1 to 128 bytes, unique in the scene; empty: the scene chooses "mesh 0" and so on.
    vertex_count: needed without `vertices` only where vertices follow the last one that an element has.
    motion: "deformable"; "static", which never moves; or "rigid", which `Rigid` moves after the first frame.
    groups, collide_mask: bits of 32; two meshes are tested if each one's mask has a group of the other. 0: group 1, all.
    self_contacts: whether the mesh is tested with itself.
    exclude_rings: 0 to 8; leave out self contacts of features that so many edges or fewer connect.
    exclude_rest_pairs: leave out self contacts of features within the scene's rest_distance where the mesh begins.
    half_thickness: half of what the mesh is thick beyond the scene's `thickness`, >= 0, finite, in the unit of the positions.
        Two meshes are in contact up to `thickness` and both halves, a mesh and itself up to `thickness` and twice its half.
    solid: whether the mesh bounds a volume: of triangles alone, each edge used as often in one direction as in the other, and a volume
        above 0 where it begins, outside where normals (b - a) x (c - a) point to. The daemon refuses others.
    notes: what `read` welded, joined or dropped, such as "welded 36 corners into 8 vertices".

    Raises InvalidArgument for shapes, dtypes and vertex numbers that cannot be.
    """

    vertices: Any = None
    triangles: Any = ()
    edges: Any = field(default=(), kw_only=True)
    points: Any = field(default=(), kw_only=True)
    name: str = field(default="", kw_only=True)
    vertex_count: int = field(default=0, kw_only=True)
    motion: str = field(default="deformable", kw_only=True)
    groups: int = field(default=0, kw_only=True)
    collide_mask: int = field(default=0, kw_only=True)
    self_contacts: bool = field(default=True, kw_only=True)
    exclude_rings: int = field(default=0, kw_only=True)
    exclude_rest_pairs: bool = field(default=False, kw_only=True)
    half_thickness: float = field(default=0.0, kw_only=True)
    solid: bool = field(default=False, kw_only=True)
    notes: tuple[str, ...] = field(default=(), kw_only=True)

    def __post_init__(self) -> None:
        for name, corners in (("triangles", 3), ("edges", 2), ("points", 0)):
            given = getattr(self, name)
            self._keep(name, ids(() if given is None else given, name, corners))
        if self.vertices is not None:
            self._keep("vertices", points(self.vertices, "vertices"))
        self._check_whole("vertex_count", UINT32_MAX)
        object.__setattr__(self, "vertex_count", self._count())
        for name in ("triangles", "edges", "points"):
            check_below(getattr(self, name), self.vertex_count, name)
        check_text(self.name, "name")
        motion = choice(scene_pb2.MeshMotion, "MESH_MOTION_", self.motion, "motion")
        object.__setattr__(self, "motion", word(scene_pb2.MeshMotion, "MESH_MOTION_", motion or 1))
        for name, limit in (("groups", UINT32_MAX), ("collide_mask", UINT32_MAX), ("exclude_rings", 8)):
            self._check_whole(name, limit)
        for name in ("self_contacts", "exclude_rest_pairs", "solid"):
            object.__setattr__(self, name, check_flag(getattr(self, name), name))
        check_length(self.half_thickness, "half_thickness")

    def _check_whole(self, name: str, limit: int) -> None:
        value = getattr(self, name)
        if not is_whole(value, limit):
            raise InvalidArgument(f"{name} is {value!r}; it must be from 0 to {limit}", field=name)

    def _keep(self, name: str, array: np.ndarray) -> None:
        """A copy: the scene is made of it, perhaps again, whatever becomes of the caller's array."""
        own = np.array(array, order="C")
        own.flags.writeable = False
        object.__setattr__(self, name, own)

    def _count(self) -> int:
        if self.vertices is not None:
            if self.vertex_count not in (0, len(self.vertices)):
                raise InvalidArgument(f"vertex_count is {self.vertex_count}; vertices have {len(self.vertices)} rows",
                                      field="vertex_count")
            return len(self.vertices)
        arrays = [array for array in (self.triangles, self.edges, self.points) if array.size]
        named = 1 + max((int(array.max()) for array in arrays), default=-1)
        if not 0 <= self.vertex_count <= UINT32_MAX or 0 < self.vertex_count < named:
            raise InvalidArgument(f"vertex_count is {self.vertex_count}; elements name {named} vertices",
                                  field="vertex_count")
        return self.vertex_count or named

    @staticmethod
    def read(path: str | os.PathLike[str], **options: Any) -> Mesh:
        """The mesh of a file: OBJ, PLY, STL, OFF, glTF, GLB or COLLADA. Every position is the file's, to the bit.

        Polygons are split into triangles; `notes` says what was welded, joined or dropped. `l` and `p` lines of an OBJ are
        loose edges and points. options: those of Mesh. Raises InvalidArgument naming file and place for what cannot be read.
        """
        return Mesh(**{**read_mesh_file(os.fspath(path)), **options})

    @staticmethod
    def of(source: Any, **options: Any) -> Mesh:
        """The mesh of a Mesh, a path, a trimesh-like object (`vertices`, `faces`), a meshio mesh (`points`, `cells_dict`),
        a pair (vertices, triangles), a mapping of Mesh's arguments, or an array of triangles alone. options: those of Mesh.
        """
        if isinstance(source, Mesh):
            return replace(source, **options)
        if isinstance(source, (str, os.PathLike)):
            return Mesh.read(source, **options)
        if isinstance(source, Mapping):
            return Mesh(**{**source, **options})
        return Mesh(**{**parts_of(source), **options})

    def __repr__(self) -> str:
        """One line, however many elements there are."""
        counts = ((self.vertex_count, "vertex"), (len(self.triangles), "triangle"), (len(self.edges), "edge"),
                  (len(self.points), "point"))
        return f"<Mesh {self.name!r}: {', '.join(counted(n, word) for n, word in counts if n)}, {self.motion}{', solid' * self.solid}>"

    @property
    def element_count(self) -> int:
        """Triangles, loose edges and loose points."""
        return len(self.triangles) + len(self.edges) + len(self.points)

    @property
    def corners(self) -> np.ndarray:
        """int64[n][3]: vertices of the elements, in their order: triangles, then loose edges as a b b, then loose points as a a a."""
        return np.concatenate([self.triangles, self.edges[:, [0, 1, 1]], np.stack([self.points] * 3, axis=1)]).astype(np.int64)

    @cached_property
    def edge_count(self) -> int:
        """Pairs of vertices that are two corners of a triangle, or the ends of a loose edge."""
        sides = np.concatenate([*(self.triangles[:, [i, (i + 1) % 3]] for i in range(3)), self.edges]).astype(np.int64)
        low, high = sides.min(axis=1), sides.max(axis=1)
        return len(np.unique(low * self.vertex_count + high))

    @property
    def is_static(self) -> bool:
        """Whether `motion` is "static"."""
        return self.motion == "static"

    @property
    def is_rigid(self) -> bool:
        """Whether `motion` is "rigid"."""
        return self.motion == "rigid"

    def spec(self, with_triangles: bool = True) -> scene_pb2.MeshSpec:
        """The mesh as the protocol has it."""
        spec = scene_pb2.MeshSpec(
            name=self.name, vertex_count=self.vertex_count, groups=self.groups, collide_mask=self.collide_mask,
            motion=choice(scene_pb2.MeshMotion, "MESH_MOTION_", self.motion, "motion"),
            no_self_contacts=not self.self_contacts, exclude_rings=self.exclude_rings,
            exclude_rest_pairs=self.exclude_rest_pairs, half_thickness=self.half_thickness, solid=self.solid,
            triangle_count=len(self.triangles), edges=self.edges.tobytes(), points=self.points.tobytes())
        if with_triangles:
            spec.triangles = self.triangles.tobytes()
        return spec


def counted(count: int, word: str) -> str:
    """As in "1 vertex" and "2,048 triangles"."""
    plural = {"vertex": "vertices", "mesh": "meshes"}.get(word, word + "s")
    return f"{count:,} {word if count == 1 else plural}"


def as_mesh(source: Any, name: str) -> Mesh:
    """A mesh of a scene, with the name that it has there."""
    try:
        mesh = Mesh.of(source)
        return mesh if mesh.name == name else replace(mesh, name=name)
    except InvalidArgument as error:
        raise InvalidArgument(f"mesh {name!r}: {error.message}", field=error.field) from None
