"""Reads which meshes touch, overlap, or are one inside the other: pairs that are not apart, one of them a solid."""

from __future__ import annotations

import enum
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from collided.columns import NO_VERTEX
from collided.errors import DataLoss
from collided.layout import Layout
from collided.v1 import contact_pb2, frame_pb2

_MOST_SHOWN = 4  # pairs in one line of text


class PairState(enum.IntEnum):
    """Lists the relations of two meshes that are not apart. proto/CONVENTIONS.md, "States of pairs", defines them.

    TOUCHING: the surfaces have points in common. They have no common volume or, if one is no solid, no triangles that go through
        each other.
    OVERLAPPING: the meshes meet in more than that, or a vertex of one is inside the other and the states below do not hold.
    FIRST_INSIDE: the surfaces have no point in common. All vertices of the first mesh are inside the second, and none of the second is
        inside the first.
    SECOND_INSIDE: the same the other way round.
    """

    TOUCHING = contact_pb2.MESH_PAIR_STATE_TOUCHING
    OVERLAPPING = contact_pb2.MESH_PAIR_STATE_OVERLAPPING
    FIRST_INSIDE = contact_pb2.MESH_PAIR_STATE_FIRST_INSIDE
    SECOND_INSIDE = contact_pb2.MESH_PAIR_STATE_SECOND_INSIDE


class MeshPair(NamedTuple):
    """A row of MeshPairs: two meshes that are not apart.

    first, second: names of the meshes. The first has the lower index.
    inside: vertices of the first that are inside the second, and of the second inside the first.
    deepest: the deepest of these vertices, by its scene-wide id, the least of several; None without such a vertex.
    depth: its distance from the other mesh's surface, in the unit of the positions; 0 without such a vertex.
    """

    first: str
    second: str
    state: PairState
    inside: tuple[int, int]
    deepest: int | None
    depth: float

    def __str__(self) -> str:
        if self.state == PairState.FIRST_INSIDE:
            return f"{self.first!r} inside {self.second!r}, {self.depth:g} deep"
        if self.state == PairState.SECOND_INSIDE:
            return f"{self.second!r} inside {self.first!r}, {self.depth:g} deep"
        deep = f", {self.inside[0]} and {self.inside[1]} vertices inside, {self.depth:g} deep" if any(self.inside) else ""
        return f"{self.first!r} and {self.second!r} {'touch' if self.state == PairState.TOUCHING else 'overlap'}{deep}"


@dataclass(frozen=True, eq=False, repr=False)
class MeshPairs:
    """A table of the pairs of meshes, one of them a solid, that are not apart. Rows ascend by first, then second mesh. Iteration and an
    index return rows as MeshPair.

    meshes: uint32[n][2], indices of the meshes, the lower one first.
    states: uint8[n], values of PairState.
    inside: uint32[n][2], vertices of the first mesh that are inside the second, and of the second inside the first.
    deepest: uint32[n], scene-wide id of the deepest of these vertices, the least of several; 2^32 - 1 without such a vertex.
    depths: float64[n], its distance from the other mesh's surface, in the unit of the positions; 0 without such a vertex.
    """

    layout: Layout
    meshes: np.ndarray
    states: np.ndarray
    inside: np.ndarray
    deepest: np.ndarray
    depths: np.ndarray

    def between(self, first: str | int, second: str | int) -> MeshPair | None:
        """Returns the row of two meshes, by name or index, in any order. None if they are apart, not tested, or both no solids."""
        rows = np.flatnonzero((self.meshes == self.layout.pair((first, second))).all(axis=1))
        return self[int(rows[0])] if rows.size else None

    def __getitem__(self, row: int) -> MeshPair:
        first, second = (self.layout.mesh(int(mesh)).name for mesh in self.meshes[row])
        deepest = int(self.deepest[row])
        return MeshPair(first, second, PairState(int(self.states[row])), (int(self.inside[row, 0]), int(self.inside[row, 1])),
                        None if deepest == NO_VERTEX else deepest, float(self.depths[row]))

    def __len__(self) -> int:
        return len(self.states)

    def __iter__(self) -> Iterator[MeshPair]:
        return (self[row] for row in range(len(self)))

    def __repr__(self) -> str:
        shown = [str(self[row]) for row in range(min(len(self), _MOST_SHOWN))]
        if len(self) > _MOST_SHOWN:
            shown.append(f"{len(self) - _MOST_SHOWN:,} more")
        return f"<MeshPairs: {'; '.join(shown) or 'none'}>"


def read_pairs(messages: Sequence[contact_pb2.MeshPairs], done: frame_pb2.FrameDone, layout: Layout,
               are_asked: bool) -> MeshPairs | None:
    """Reads the pairs of an answer: `messages`, and then `done`. Returns None for a frame without them. Raises DataLoss.

    layout: that of the frame.
    """
    if done.HasField("pairs"):
        messages = [*messages, done.pairs]
    columns = {name: _joined(messages, name, dtype, width) for name, dtype, width in (
        ("meshes", "<u4", 2), ("states", "u1", 1), ("inside", "<u4", 2), ("deepest", "<u4", 1), ("depths", "<f8", 1))}
    pairs = MeshPairs(layout, **columns)
    if len(pairs) and not are_asked:
        raise DataLoss(f"pairs has {len(pairs)} pairs, and the frame did not ask for them")
    _check(pairs)
    return pairs if are_asked else None


def _joined(messages: Sequence[contact_pb2.MeshPairs], name: str, dtype: str, width: int) -> np.ndarray:
    for message in messages:
        needed = len(message.states) * width * np.dtype(dtype).itemsize
        if len(getattr(message, name)) != needed:
            raise DataLoss(f"pairs.{name} has {len(getattr(message, name))} bytes for {len(message.states)} pairs; it needs {needed}")
    array = np.frombuffer(b"".join(getattr(message, name) for message in messages), dtype)
    return array if width == 1 else array.reshape(-1, width)


def _check(pairs: MeshPairs) -> None:
    if not len(pairs):
        return
    layout, (first, second) = pairs.layout, pairs.meshes.astype(np.int64).T
    counts = np.diff(layout.vertex_offsets)
    if second.max() >= len(counts) or (counts[pairs.meshes] == 0).any():
        raise DataLoss(f"pairs.meshes names mesh {second.max()}, or one that was removed; the scene has {len(counts)}")
    if (first >= second).any() or (np.diff(first * len(counts) + second) <= 0).any():
        raise DataLoss("pairs.meshes does not ascend, first mesh before second")
    if not np.isin(pairs.states, list(PairState)).all():
        raise DataLoss(f"pairs.states has a state that is not in 1 to {max(PairState):d}")
    if (pairs.inside > counts[pairs.meshes]).any():
        raise DataLoss("pairs.inside has more vertices than a mesh has")
    is_deep = pairs.inside.any(axis=1)
    if ((pairs.deepest != NO_VERTEX) != is_deep).any() or (pairs.deepest[is_deep] >= layout.vertex_offsets[-1]).any():
        raise DataLoss("pairs.deepest names a vertex that the scene does not have, or none where one is inside")
    if not ((pairs.depths >= 0) & (pairs.depths < np.inf)).all():
        raise DataLoss("pairs.depths has a depth that is not 0 or more, or infinite")
