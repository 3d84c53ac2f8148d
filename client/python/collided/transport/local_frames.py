"""A frame as a packet of the local socket, with its arrays in the memory that client and daemon share."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from collided.frames import tags
from collided.frames.tags import field, varint
from collided.frames.updates import Update
from collided.transport.base import NotSent
from collided.transport.region import ALIGNMENT, MAX_PACKET_BYTES, Memory, Part
from collided.v1 import frame_pb2

_MAX_INLINE_BYTES = 64  # up to this many go into the packet itself
_NOTHING = Part(0, 0)


class LocalFrames:
    """Packs frames, one at a time, each in a part of the input of its own."""

    def __init__(self, memory: Memory) -> None:
        self._memory = memory
        self._frames = 0  # packed so far
        self._part = _NOTHING  # the frame's
        self._used = 0  # bytes of it
        self._placed: list[tuple[Part, int, Any]] = []  # arrays, and where they go
        self._views: dict[int, np.ndarray] = {}  # of the part, by the id of the array that was placed there

    def pack(self, frame_id: int, head: frame_pb2.Frame, updates: list[Update]) -> bytes:
        """The packet. Raises NotSent."""
        self._begin(self._lasting_part(updates) or self._memory.part(self._frames))
        frame = b"".join([tags.FRAME_ID, varint(frame_id), head.SerializeToString(),
                          *(field(tags.UPDATES, self._update(update)) for update in updates)])
        packet = field(tags.FRAME, frame)
        if len(packet) > MAX_PACKET_BYTES:
            packet = self._in_region(frame)
        self._copy()  # last, as it takes the place of all else in the processor's caches
        self._frames += 1
        return packet

    def lasting(self, updates: list[Update]) -> list[Update]:
        """The updates of the last frame, in memory that stays as it is."""
        out = [Update(u.mesh, self._stay(u.positions), self._stay(u.start), self._stay(u.indices), u.pose, u.start_pose)
               for u in updates]
        self._begin(_NOTHING)
        return out

    def _stay(self, array: Any) -> Any:
        if not isinstance(array, np.ndarray):
            return array
        view = self._views.get(id(array))
        return array.copy() if view is None else view

    def _lasting_part(self, updates: list[Update]) -> Part | None:
        """A part for positions of whole meshes. Not for those of a first frame, which may be needed for good."""
        if not self._frames:
            return None
        size = 0
        for update in updates:
            if update.indices is not None:
                return None
            for array in (update.start, update.positions):
                size += 0 if array is None else _aligned(array.nbytes)
        return self._memory.lasting_part(size)

    def _begin(self, part: Part) -> None:
        self._part, self._used, self._placed, self._views = part, 0, [], {}

    def _update(self, update: Update) -> bytes:
        """A MeshUpdate, whose arrays are given places."""
        out = tags.MESH + varint(update.mesh) if update.mesh else b""
        if update.pose is not None:
            pose = field(tags.MATRIX, update.pose.tobytes())
            if update.start_pose is not None:
                pose += field(tags.START_MATRIX, update.start_pose.tobytes())
            out += field(tags.RIGID, pose)
        if update.indices is not None:
            out += field(tags.SPARSE, self._array(update.indices, tags.SHARED_INDICES, tags.INDICES, "indices"))
        out += self._array(update.start, tags.SHARED_START, tags.START, "start_positions")
        return out + self._array(update.positions, tags.SHARED_POSITIONS, tags.POSITIONS, "positions")

    def _array(self, array: Any, shared: bytes, inline: bytes, name: str) -> bytes:
        """Where it is in the input region; the array itself if it is small, or there is no room."""
        if array is None or not array.nbytes:
            return b""
        is_small = array.nbytes <= _MAX_INLINE_BYTES and isinstance(array, np.ndarray)
        start = None if is_small else self._place(array)
        if start is not None:
            return _range(shared, start, array.nbytes)
        if not isinstance(array, np.ndarray):
            raise NotSent(f"{name} have {array.nbytes} bytes, more than the memory for one frame has left; edit_bytes makes "
                          "room", field="frame")
        return field(inline, array.tobytes())

    def _place(self, array: Any) -> int | None:
        """Its offset in the input region; None if there is no room."""
        part, at = self._part, self._used
        if array.nbytes > part.size - at:
            return None
        self._used = at + _aligned(array.nbytes)
        self._placed.append((part, at, array))
        return part.start + at

    def _copy(self) -> None:
        """All arrays to their places."""
        for part, at, array in self._placed:
            if part.bytes is None:
                self._memory.write(part.start + at, array)
            else:
                self._views[id(array)] = view = np.ndarray(array.shape, array.dtype, part.bytes, at)
                view[...] = array

    def _in_region(self, frame: bytes) -> bytes:
        """The packet that names where the frame's message lies, as it is too long for one."""
        if self._part.bytes is not None:  # which has room for positions alone
            self._part, self._used = self._memory.part(self._frames), 0
        start = self._place(np.frombuffer(frame, np.uint8))
        if start is None:
            raise NotSent(f"frame is {len(frame)} bytes besides what is in shared memory, more than a packet and "
                          "the memory for one frame hold; edit_bytes makes room", field="frame")
        return _range(tags.SHARED_FRAME, start, len(frame))


@lru_cache(256)  # a mesh's positions lie in few places
def _range(tag: bytes, offset: int, size: int) -> bytes:
    """A SharedRange."""
    return field(tag, tags.OFFSET + varint(offset) + tags.SIZE + varint(size))


def _aligned(size: int) -> int:
    return -(-size // ALIGNMENT) * ALIGNMENT
