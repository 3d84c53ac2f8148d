"""Reads how far a scene, its meshes or its vertices went in a frame that advances."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from collided.errors import DataLoss
from collided.layout import Layout
from collided.v1 import frame_pb2


class Shortened(NamedTuple):
    """Lists what did not go all of its way in a frame that advances per mesh or per vertex. All else that moves went all of it.

    ids: uint32[n], strictly ascending, of meshes, or of vertices, numbered within the scene.
    fractions: float64[n], how far each went, in [0, 1).
    """

    ids: np.ndarray = np.empty(0, "<u4")
    fractions: np.ndarray = np.empty(0, "<f8")

    def of(self, first: int, count: int) -> np.ndarray:
        """Returns how far each of `count` meshes or vertices went, from the id `first` on: float64[count], in [0, 1]."""
        begin, end = np.searchsorted(self.ids, np.array([first, first + count], self.ids.dtype))
        out = np.ones(count)
        out[self.ids[begin:end] - first] = self.fractions[begin:end]
        return out


@dataclass(frozen=True, eq=False)
class Advance:
    """Tells how far a scene went in one frame.

    mode: what went its own fraction of the way.
    least: the least fraction of anything that moves.
    """

    mode: frame_pb2.AdvanceMode
    least: float
    shortened: Shortened
    layout: Layout

    def fraction(self, mesh: int) -> float | np.ndarray:
        """Returns how far a mesh went, in [0, 1]: float64[n] if each vertex has a fraction of its own."""
        if self.mode == frame_pb2.ADVANCE_MODE_PER_MESH:
            return float(self.shortened.of(mesh, 1)[0])
        if self.mode == frame_pb2.ADVANCE_MODE_PER_VERTEX:
            fractions = self.shortened.of(int(self.layout.vertex_offsets[mesh]), self.layout.mesh(mesh).vertex_count)
            return float(fractions.min()) if self.layout.mesh(mesh).is_rigid else fractions
        return self.least


def read_advance(head: frame_pb2.Frame, done: frame_pb2.FrameDone, messages: Sequence[frame_pb2.ShortenedWays],
                 layout: Layout) -> Advance | None:
    """Reads the answer to a frame: `messages`, and then `done`. Returns None for one without `advance`. Raises DataLoss.

    head, layout: those of the frame.
    """
    if done.HasField("shortened"):
        messages = [*messages, done.shortened]
    shortened = _joined(messages) if messages else Shortened()
    count, what = _most(head, layout)
    if shortened.ids.size and shortened.ids[-1] >= count:
        raise DataLoss(f"shortened.ids names {shortened.ids[-1]}; the frame has {count} {what} that may go a way of their own")
    return Advance(head.advance_mode, done.advanced, shortened, layout) if head.advance else None


def _most(head: frame_pb2.Frame, layout: Layout) -> tuple[int, str]:
    """Returns how many ids there may be, and of what."""
    if head.advance_mode == frame_pb2.ADVANCE_MODE_PER_VERTEX:
        return int(layout.vertex_offsets[-1]), "vertices"
    return len(layout.meshes) if head.advance_mode == frame_pb2.ADVANCE_MODE_PER_MESH else 0, "meshes"


def _joined(messages: Sequence[frame_pb2.ShortenedWays]) -> Shortened:
    for message in messages:
        if len(message.ids) % 4 or 2 * len(message.ids) != len(message.fractions):
            raise DataLoss(f"shortened has {len(message.ids)} bytes of ids and {len(message.fractions)} of fractions; it needs 4 "
                           "and 8 for each")
    ids = np.frombuffer(b"".join(message.ids for message in messages), "<u4")
    fractions = np.frombuffer(b"".join(message.fractions for message in messages), "<f8")
    falls = np.flatnonzero(ids[1:] <= ids[:-1])
    if falls.size:
        raise DataLoss(f"shortened.ids has {ids[falls[0] + 1]} after {ids[falls[0]]}; they must ascend strictly")
    if not ((fractions >= 0) & (fractions < 1)).all():
        raise DataLoss("shortened.fractions has a fraction that is not in [0, 1)")
    return Shortened(ids, fractions)
