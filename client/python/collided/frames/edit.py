"""Changes of what a scene is made of."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from collided.arrays import OneLine
from collided.choices import check_text
from collided.errors import InvalidArgument
from collided.layout import Layout
from collided.meshes import Mesh, as_mesh
from collided.options import words
from collided.v1 import scene_pb2


@dataclass(frozen=True, eq=False, repr=False)
class Edit(OneLine):
    """Meshes that are replaced, added or removed with a frame, and pairs of meshes that are not tested any more, or again.

    meshes: by name or index. None removes a mesh; a name that is new adds one. A mesh without elements keeps those that it
        has, and needs as many vertices.
    exclude, include: pairs of meshes, by name or index.

    A mesh that is added, or gets another number of vertices or another motion, has positions in the same frame, or is where
    its `vertices` are.
    """

    meshes: Mapping[str | int, Any] = field(default_factory=dict)
    exclude: Iterable[tuple[str | int, str | int]] = ()
    include: Iterable[tuple[str | int, str | int]] = ()


@dataclass(frozen=True, eq=False)
class Applied:
    """An edit of a scene: its message and what it makes of the scene.

    begun: meshes whose positions begin anew. rested: meshes whose rest pairs do.
    """

    message: scene_pb2.SceneEdit
    layout: Layout
    begun: frozenset[int]
    rested: frozenset[int]


def apply_edit(edit: Edit, before: Layout, has_own_distances: bool) -> Applied:
    """has_own_distances: what is near at rest goes by each mesh's own contact distance. Raises InvalidArgument for meshes that
    are not there."""
    if not isinstance(edit, Edit) or not isinstance(edit.meshes, Mapping):
        raise InvalidArgument(f"edit is {edit!r}; it must be an Edit, with a mapping of meshes", field="edit")
    meshes, message = list(before.meshes), scene_pb2.SceneEdit()
    begun, rested = set(), set()
    for key, source in edit.meshes.items():
        index = _place(key, meshes, {edited.mesh for edited in message.meshes})
        old = meshes[index] if index < len(meshes) else None
        mesh_edit = message.meshes.add(mesh=index)
        new = None if source is None else _replacement(source, key, old)
        if new is not None:
            mesh_edit.spec.CopyFrom(new.spec())
            if _begins_at_rest(new, old, has_own_distances):
                rested.add(index)
            new = _with_elements_of(new, old)
            if old is None or (old.vertex_count, old.motion) != (new.vertex_count, new.motion):
                begun.add(index)
        meshes[index:index + 1] = [new]
    removed = {i for i, mesh in enumerate(meshes) if mesh is None}
    excluded = {pair for pair in before.excluded if not removed & set(pair)}
    after = Layout(tuple(meshes))
    for name, target in (("exclude", message.exclude_meshes), ("include", message.include_meshes)):
        for pair in words(getattr(edit, name), f"edit.{name}"):
            first, second = after.pair(pair)
            target.add(first=first, second=second)
            excluded.add((first, second)) if name == "exclude" else excluded.discard((first, second))
    return Applied(message, replace(after, excluded=frozenset(excluded)), frozenset(begun), frozenset(rested))


def _place(key: str | int, meshes: list[Mesh | None], edited: set[int]) -> int:
    """Index of the mesh that is there, or of a free place for a new one, which this edit has not freed."""
    if isinstance(key, str):
        check_text(key, "edit.meshes")
        found = next((i for i, mesh in enumerate(meshes) if mesh is not None and mesh.name == key), None)
        if found is not None:
            return found
        return next((i for i, mesh in enumerate(meshes) if mesh is None and i not in edited), len(meshes))
    if isinstance(key, bool) or not isinstance(key, int) or not 0 <= key <= len(meshes):
        raise InvalidArgument(f"edit.meshes has {key!r}; it must be a name, or an index up to {len(meshes)}",
                              field="edit.meshes")
    return key


def _replacement(source: Any, key: str | int, old: Mesh | None) -> Mesh:
    name = key if isinstance(key, str) else old.name if old is not None else ""
    return as_mesh(source, name or (source.name if isinstance(source, Mesh) and source.name else f"mesh {key}"))


def _begins_at_rest(new: Mesh, old: Mesh | None, has_own_distances: bool) -> bool:
    """Whether the pairs that the mesh leaves out are those near each other in the edit's frame."""
    if new.element_count or old is None or not (old.self_contacts and old.exclude_rest_pairs):
        return True
    return has_own_distances and new.half_thickness != old.half_thickness


def _with_elements_of(new: Mesh, old: Mesh | None) -> Mesh:
    """A mesh without elements keeps those of the old one."""
    if new.element_count or old is None:
        return new
    return replace(new, triangles=old.triangles, edges=old.edges, points=old.points)
