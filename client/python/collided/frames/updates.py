"""New positions of meshes, as callers say them and as arrays of the wire."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from collided.arrays import OneLine, check_below, ids, matrix
from collided.errors import InvalidArgument
from collided.layout import Layout
from collided.positions import Format


@dataclass(frozen=True, eq=False)
class Incoming:
    """A caller's array on the device. keep: what holds its memory."""

    address: int
    nbytes: int
    stream: int
    keep: Any


@dataclass(frozen=True, eq=False, repr=False)
class Sparse(OneLine):
    """New positions of some vertices: only these move.

    indices: integers[n], strictly ascending, numbered within the mesh. positions: (n, 3). start: (n, 3), where they are at
    t = 0 (CCD); None: where the last frame left them.
    """

    indices: Any
    positions: Any
    start: Any = None


@dataclass(frozen=True, eq=False, repr=False)
class Rigid(OneLine):
    """The pose of a rigid mesh: p -> R p + t of its first positions, as the rows of [R | t], (3, 4) or (4, 4).

    start: the pose at t = 0 (CCD); None: where the last frame left the mesh. In CCD a frame turns it by 3 radians at most.
    """

    matrix: Any
    start: Any = None


@dataclass(eq=False)
class Update:
    """One mesh's part of a frame: arrays of the wire, which may be the caller's memory until the frame is sent."""

    mesh: int
    positions: np.ndarray | None = None
    start: np.ndarray | None = None
    indices: np.ndarray | None = None
    pose: np.ndarray | None = None
    start_pose: np.ndarray | None = None


class Context(NamedTuple):
    """What a frame's updates are checked against. has_starts: not in scenes of DCD."""

    layout: Layout
    format: Format
    has_starts: bool = True


def updates_of(context: Context, positions: Any, start: Any) -> list[Update]:
    """Updates of the meshes that `positions` names; `start` may name the same."""
    moved = _by_mesh(context.layout, positions, "positions")
    starts = _by_mesh(context.layout, start, "start")
    if alone := starts.keys() - moved.keys():
        raise InvalidArgument(f"start names mesh {min(alone)}, and positions do not", field="start")
    return [_update(context, index, value, starts.get(index)) for index, value in sorted(moved.items())]


def _by_mesh(layout: Layout, values: Any, argument: str) -> dict[int, Any]:
    if values is None:
        return {}
    if isinstance(values, Mapping):
        return layout.by_index(values, argument)
    if len(layout.movable) != 1:
        raise InvalidArgument(f"{argument} is not a mapping of meshes, which the scene needs: {len(layout.movable)} of its "
                              "meshes can move", field=argument)
    return {layout.movable[0]: values}


def _update(context: Context, index: int, value: Any, start: Any) -> Update:
    mesh = context.layout.mesh(index)
    where = f"positions[{mesh.name!r}]"
    if isinstance(value, (Rigid, Sparse)) and start is not None:
        raise InvalidArgument(f"start names mesh {mesh.name!r}, whose update has a start of its own", field="start")
    if isinstance(value, Rigid):
        if not mesh.is_rigid:
            raise InvalidArgument(f"{where} is a pose, and the mesh's motion is {mesh.motion!r}", field=where)
        return Update(index, pose=matrix(value.matrix, where + ".matrix"),
                      start_pose=None if value.start is None else matrix(value.start, where + ".start"))
    if isinstance(value, Sparse):
        return _sparse(context, index, value, where)
    encode = context.format.encode
    return Update(index, positions=encode(value, where, mesh.vertex_count),
                  start=None if start is None else encode(start, f"start[{mesh.name!r}]", mesh.vertex_count))


def _sparse(context: Context, index: int, value: Sparse, where: str) -> Update:
    indices = ids(value.indices, where + ".indices")
    check_below(indices, context.layout.mesh(index).vertex_count, where + ".indices")
    falls = np.flatnonzero(indices[1:] <= indices[:-1])
    if falls.size:
        raise InvalidArgument(f"{where}.indices[{falls[0] + 1}] is {indices[falls[0] + 1]}, after {indices[falls[0]]}; "
                              "they must ascend strictly", field=where)
    encode = context.format.encode
    return Update(index, indices=indices, positions=encode(value.positions, where + ".positions", len(indices)),
                  start=None if value.start is None else encode(value.start, where + ".start", len(indices)))
