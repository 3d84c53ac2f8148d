"""A frame stream over the daemon's local socket: positions and contacts are in shared memory."""

from __future__ import annotations

import select
import socket
from dataclasses import fields
from typing import Any

import numpy as np
from google.protobuf.message import DecodeError

from collided.errors import DataLoss, Unavailable, error_of
from collided.frames.updates import Update
from collided.transport.base import NotSent
from collided.transport.peer import LocalPeer, connect_to_trusted
from collided.transport.region import ALIGNMENT, MAX_PACKET_BYTES, Memory
from collided.v1 import collision_service_pb2 as api
from collided.v1 import frame_pb2, local_pb2, shared_range_pb2

_VERSION = 1
_MAX_INLINE_BYTES = 64  # up to this many go into the packet itself


class LocalTransport:
    is_local = True

    def __init__(self, peer: LocalPeer, memory: Memory) -> None:
        self._memory = memory
        try:
            self._socket = connect_to_trusted(peer)
        except Exception:
            memory.close()
            raise
        self._token = peer.token
        self._frames = 0  # sent so far; the next one's part of the input follows from it
        self._used = 0  # bytes of that part that are taken

    def open(self, request: api.OpenStream) -> None:
        opening = local_pb2.LocalOpen(version=_VERSION, token=self._token, open=request)
        files = self._memory.describe(opening)
        packet = local_pb2.LocalRequest(open=opening).SerializeToString()
        try:
            if files:
                socket.send_fds(self._socket, [packet], files)
            else:
                self._socket.send(packet)
        except OSError:
            pass  # a daemon that refuses the connection has closed it by now, and its answer can still be read

    def send(self, head: frame_pb2.Frame, updates: list[Update]) -> list[Update]:
        message = local_pb2.LocalRequest(frame=head)
        for update in updates:
            self._add(update, message.frame)
        packet = message.SerializeToString()
        if len(packet) > MAX_PACKET_BYTES:
            packet = self._in_region(message.frame)
        self._frames += 1
        self._used = 0
        try:
            self._socket.send(packet)
        except OSError:
            pass  # reading tells why the stream has ended
        return [_copy(update) for update in updates]  # the daemon is at work meanwhile

    def read(self, timeout: float | None) -> api.StreamFramesResponse | None:
        if timeout is not None and not select.select([self._socket], [], [], timeout)[0]:
            return None
        data = self._receive()
        if not data:
            raise Unavailable("the daemon's local socket was closed")
        try:
            packet = local_pb2.LocalResponse.FromString(data)
        except DecodeError:
            raise DataLoss("the daemon's packet is not a LocalResponse") from None
        if not packet.HasField("closed"):
            return packet.frame
        closed = packet.closed
        if closed.code == 0:
            raise Unavailable("the stream has ended")
        raise error_of(closed.code, closed.message, field=closed.field)

    def _receive(self) -> bytes:
        """A packet; empty at the end. A reset may be reported before the daemon's last packets."""
        for _ in range(2):
            try:
                return self._socket.recv(MAX_PACKET_BYTES)
            except ConnectionResetError:
                continue
            except OSError:
                break
        return b""

    def shared(self, shared_range: shared_range_pb2.SharedRange) -> memoryview:
        return self._memory.output(shared_range.offset, shared_range.size)

    def half_close(self) -> None:
        self._shut_down(socket.SHUT_WR)

    def close(self) -> None:
        self._shut_down(socket.SHUT_RDWR)
        self._socket.close()
        self._memory.close()

    def _shut_down(self, how: int) -> None:
        try:
            self._socket.shutdown(how)
        except OSError:
            pass  # it has ended already

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
        placed = None if is_small else self._place(array)
        if placed is not None:
            getattr(out, shared).CopyFrom(placed)
        elif isinstance(array, np.ndarray):
            setattr(out, inline, array.tobytes())
        else:
            self._used = 0
            raise NotSent(f"{inline} have {array.nbytes} bytes, more than the memory for one frame has left; edit_bytes makes "
                          "room", field="frame")

    def _place(self, array: Any) -> shared_range_pb2.SharedRange | None:
        """None if there is no room."""
        room = self._memory.layout.frame_bytes
        if array.nbytes > room - self._used:
            return None
        start = self._memory.start_of(self._frames) + self._used
        self._used = min(-(-(self._used + array.nbytes) // ALIGNMENT) * ALIGNMENT, room)
        self._memory.write(start, array)
        return shared_range_pb2.SharedRange(offset=start, size=array.nbytes)

    def _in_region(self, frame: frame_pb2.Frame) -> bytes:
        """The packet that names where the frame's message lies, as it is too long for one."""
        message = np.frombuffer(frame.SerializeToString(), np.uint8)
        placed = self._place(message)
        if placed is None:
            self._used = 0
            raise NotSent(f"frame is {message.size} bytes besides what is in shared memory, more than a packet and "
                          "the memory for one frame hold; edit_bytes makes room", field="frame")
        return local_pb2.LocalRequest(shared_frame=placed).SerializeToString()


def _copy(update: Update) -> Update:
    arrays = {field.name: getattr(update, field.name) for field in fields(update)}
    return Update(**{name: value.copy() if isinstance(value, np.ndarray) else value for name, value in arrays.items()})
