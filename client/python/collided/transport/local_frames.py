"""A frame as a packet of the local socket, with its arrays in the memory that client and daemon share."""

from __future__ import annotations

from typing import Any

import numpy as np

from collided.frames.updates import Update
from collided.transport.base import NotSent
from collided.transport.region import ALIGNMENT, MAX_PACKET_BYTES, Memory, Part
from collided.v1 import frame_pb2, local_pb2

_MAX_INLINE_BYTES = 64  # up to this many go into the packet itself
_NOTHING = Part(0, 0)


class LocalFrames:
    """Packs frames, one at a time, each in a part of the input of its own."""

    def __init__(self, memory: Memory) -> None:
        self._memory = memory
        self._frames = 0  # packed so far
        self._part = _NOTHING  # the frame's
        self._used = 0  # bytes of it
        self._views: dict[int, np.ndarray] = {}  # of the part, by the id of the array that was placed there

    def pack(self, head: frame_pb2.Frame, updates: list[Update]) -> bytes:
        """The packet. Raises NotSent."""
        self._begin(self._lasting_part(updates) or self._memory.part(self._frames))
        message = local_pb2.LocalRequest(frame=head)
        for update in updates:
            self._add(update, message.frame)
        packet = message.SerializeToString()
        if len(packet) > MAX_PACKET_BYTES:
            packet = self._in_region(message.frame)
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
        self._part, self._used, self._views = part, 0, {}

    def _add(self, update: Update, frame: frame_pb2.Frame) -> None:
        out = frame.updates.add(mesh=update.mesh)
        if update.pose is not None:
            out.rigid.matrix = update.pose.tobytes()
            out.rigid.start_matrix = b"" if update.start_pose is None else update.start_pose.tobytes()
        if update.indices is not None:
            out.sparse.SetInParent()
            self._put(update.indices, out.sparse, "shared_indices", "indices")
        self._put(update.start, out, "shared_start_positions", "start_positions")
        self._put(update.positions, out, "shared_positions", "positions")

    def _put(self, array: Any, out: Any, shared: str, inline: str) -> None:
        """In the input region; in the packet itself if it is small, or there is no room."""
        if array is None or not array.nbytes:
            return
        is_small = array.nbytes <= _MAX_INLINE_BYTES and isinstance(array, np.ndarray)
        if not is_small and self._place(array, getattr(out, shared)):
            return
        if not isinstance(array, np.ndarray):
            raise NotSent(f"{inline} have {array.nbytes} bytes, more than the memory for one frame has left; edit_bytes makes "
                          "room", field="frame")
        setattr(out, inline, array.tobytes())

    def _place(self, array: Any, out: Any) -> bool:
        """False if there is no room."""
        part, at = self._part, self._used
        if array.nbytes > part.size - at:
            return False
        self._used = at + _aligned(array.nbytes)
        if part.bytes is None:
            self._memory.write(part.start + at, array)
        else:
            self._views[id(array)] = view = np.ndarray(array.shape, array.dtype, part.bytes, at)
            view[...] = array
        out.offset, out.size = part.start + at, array.nbytes
        return True

    def _in_region(self, frame: frame_pb2.Frame) -> bytes:
        """The packet that names where the frame's message lies, as it is too long for one."""
        message = np.frombuffer(frame.SerializeToString(), np.uint8)
        if self._part.bytes is not None:  # which has room for positions alone
            self._part, self._used = self._memory.part(self._frames), 0
        packet = local_pb2.LocalRequest()
        if not self._place(message, packet.shared_frame):
            raise NotSent(f"frame is {message.size} bytes besides what is in shared memory, more than a packet and "
                          "the memory for one frame hold; edit_bytes makes room", field="frame")
        return packet.SerializeToString()


def _aligned(size: int) -> int:
    return -(-size // ALIGNMENT) * ALIGNMENT
