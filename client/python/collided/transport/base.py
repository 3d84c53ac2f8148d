"""What a session needs of a transport."""

from __future__ import annotations

from typing import Any, Protocol

from collided.errors import ResourceExhausted
from collided.frames.updates import Update
from collided.v1 import collision_service_pb2 as api
from collided.v1 import frame_pb2


class NotSent(ResourceExhausted):
    """A frame that is too large: nothing was sent, and the stream goes on."""


class Transport(Protocol):
    """One thread at a time."""

    is_local: bool

    def open(self, request: api.OpenStream) -> None:
        """Sends the first message, whose answer is read as any other."""

    def send(self, frame_id: int, head: frame_pb2.Frame, updates: list[Update]) -> list[Update]:
        """Sends a frame of these updates, which may be in their callers' memory. The same in memory that stays as it is.
        Raises NotSent.

        head: the frame without its id and its updates."""

    def read(self, timeout: float | None) -> api.StreamFramesResponse | None:
        """The next message; None if none came in time. Raises Error at the end."""

    def shared(self, shared_range: Any) -> memoryview:
        """Bytes of the output region."""

    def half_close(self) -> None:
        """No more frames will come: the daemon answers those in flight, and ends the stream."""

    def close(self) -> None:
        """Ends the stream, and frames in flight, if it has not ended."""
