"""What the daemon said of a frame besides its contacts."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from collided.contacts.columns import Part
from collided.contacts.pairs import MeshPairs
from collided.frames.advance import Advance
from collided.frames.state import State, Way
from collided.layout import Layout
from collided.v1 import frame_pb2


@dataclass(eq=False)
class Answer:
    """The end of a frame. way: None where the client does not know the positions, as of a frame that it watches. has_layout:
    the layout is the frame's, and not that of a later edit. advance: how far meshes went; None where they went all of their ways.
    limits: contacts that limit the way. pairs: meshes that are not apart; None in a frame without states of pairs."""

    frame_id: int
    wire_id: int
    done: frame_pb2.FrameDone
    layout: Layout
    way: Way | None
    has_motion: bool
    is_skipped: bool = False
    has_layout: bool = True
    advance: Advance | None = None
    limits: list[Part] = field(default_factory=list)
    pairs: MeshPairs | None = None

    @cached_property
    def starts(self) -> np.ndarray:
        """Positions of all vertices of the scene at t = 0."""
        return self._all(self.way.start) if self.way and self.has_motion else self.ends

    @cached_property
    def ends(self) -> np.ndarray:
        """Positions of all vertices of the scene at t = 1."""
        return self._all(self.way.end) if self.way else np.empty((0, 3))

    def _all(self, state: State) -> np.ndarray:
        assert self.way is not None
        return np.concatenate([state[i].real(self.way.form).astype("<f8") for i, _ in self.layout.present()])
