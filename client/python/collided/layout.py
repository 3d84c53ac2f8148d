"""What a scene is made of at one moment, and how its features are numbered."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from collided.arrays import is_whole
from collided.choices import check_text
from collided.errors import FailedPrecondition, InvalidArgument
from collided.meshes import Mesh, as_mesh
from collided.v1 import scene_pb2


@dataclass(frozen=True, eq=False)
class Layout:
    """Meshes by index; None where an edit removed one. Pairs of indices that are not tested."""

    meshes: tuple[Mesh | None, ...]
    excluded: frozenset[tuple[int, int]] = field(default_factory=frozenset)
    element_counts: tuple[int, ...] | None = None  # of meshes whose elements are not known here

    @staticmethod
    def of(source: Any, exclude: Iterable[Any] = ()) -> Layout:
        """From a mapping of names to meshes, a list of meshes, or one mesh. exclude: pairs that are not tested."""
        if isinstance(source, Mapping) and not {"vertices", "triangles", "edges", "points"} & source.keys():
            named = list(source.items())
        elif isinstance(source, (list, tuple)) and source and all(isinstance(mesh, Mesh) for mesh in source):
            named = [(mesh.name or f"mesh {i}", mesh) for i, mesh in enumerate(source)]
        else:
            named = [(source.name if isinstance(source, Mesh) and source.name else "mesh", source)]
        for name, _ in named:
            check_text(name, "meshes")
        if not named:
            raise InvalidArgument("a scene needs one mesh or more", field="meshes")
        layout = Layout(tuple(as_mesh(mesh, name) for name, mesh in named))
        return replace(layout, excluded=frozenset(map(layout.pair, exclude)))

    @cached_property
    def _indices(self) -> dict[str, int]:
        return {mesh.name: i for i, mesh in enumerate(self.meshes) if mesh is not None}

    @staticmethod
    def of_spec(spec: scene_pb2.SceneSpec) -> Layout:
        """As the daemon tells it, without elements; meshes without vertices were removed."""
        meshes = (Mesh(name=mesh.name, vertex_count=mesh.vertex_count) if mesh.vertex_count else None
                  for mesh in spec.meshes)
        counts = (mesh.triangle_count + mesh.edge_count + mesh.point_count for mesh in spec.meshes)
        return Layout(tuple(meshes), element_counts=tuple(counts))

    def index(self, mesh: str | int) -> int:
        """Index of a mesh that is there, by name or index."""
        if isinstance(mesh, str):
            if mesh not in self._indices:
                known = ", ".join(map(repr, self._indices))
                raise InvalidArgument(f"mesh {mesh!r} is not in the scene, which has {known[:400]}", field="mesh")
            return self._indices[mesh]
        if not is_whole(mesh, len(self.meshes) - 1):
            raise InvalidArgument(f"mesh is {mesh!r}; it must be a name, or an index below {len(self.meshes)}",
                                  field="mesh")
        if self.meshes[mesh] is None:
            raise InvalidArgument(f"mesh {mesh} was removed", field="mesh")
        return int(mesh)

    def by_index(self, values: Mapping[str | int, Any], argument: str) -> dict[int, Any]:
        """Values of meshes, each named once."""
        out: dict[int, Any] = {}
        names: dict[int, str | int] = {}
        for mesh, value in values.items():
            index = self.index(mesh)
            if index in out:
                raise InvalidArgument(f"{argument} names mesh {index} twice: {names[index]!r} and {mesh!r}", field=argument)
            out[index], names[index] = value, mesh
        return out

    def mesh(self, index: int) -> Mesh:
        """A mesh that is there."""
        mesh = self.meshes[index]
        assert mesh is not None
        return mesh

    def present(self) -> Iterable[tuple[int, Mesh]]:
        return ((i, mesh) for i, mesh in enumerate(self.meshes) if mesh is not None)

    @cached_property
    def movable(self) -> list[int]:
        """Indices of the meshes that are not static."""
        return [i for i, mesh in self.present() if not mesh.is_static]

    @cached_property
    def removed(self) -> list[int]:
        """Indices of meshes that an edit has removed."""
        return [i for i, mesh in enumerate(self.meshes) if mesh is None]

    @cached_property
    def vertex_offsets(self) -> np.ndarray:
        """First scene-wide vertex of each mesh, and the number of all."""
        return _sums([0 if mesh is None else mesh.vertex_count for mesh in self.meshes])

    @cached_property
    def element_offsets(self) -> np.ndarray:
        """First scene-wide element (triangle, loose edge or loose point) of each mesh, and the number of all."""
        return _sums(self.element_counts or [0 if mesh is None else mesh.element_count for mesh in self.meshes])

    @cached_property
    def edge_offsets(self) -> np.ndarray:
        """First scene-wide edge of each mesh, and the number of all. Raises FailedPrecondition where elements are not known."""
        self._check_elements()
        return _sums([0 if mesh is None else mesh.edge_count for mesh in self.meshes])

    @cached_property
    def corners(self) -> np.ndarray:
        """int64[n][3]: the scene-wide vertices of every element, a b b of a loose edge, a a a of a loose point. Raises
        FailedPrecondition where elements are not known."""
        self._check_elements()
        rows = [mesh.corners + self.vertex_offsets[i] for i, mesh in self.present()]
        return np.concatenate([np.empty((0, 3), np.int64), *rows])

    def _check_elements(self) -> None:
        if self.element_counts is not None:
            raise FailedPrecondition("the meshes' elements are not known here, so neither are their edges")

    def pair(self, pair: Any) -> tuple[int, int]:
        """Two meshes, in order."""
        try:
            first, second = pair
        except (TypeError, ValueError):
            raise InvalidArgument(f"{pair!r} is no pair of meshes", field="excluded_meshes") from None
        low, high = sorted((self.index(first), self.index(second)))
        return low, high


def _sums(counts: Iterable[int]) -> np.ndarray:
    return np.concatenate([[0], np.cumsum(list(counts), dtype=np.int64)]).astype(np.int64)
