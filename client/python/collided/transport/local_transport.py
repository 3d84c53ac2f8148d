"""A frame stream over the daemon's local socket: positions and contacts are in shared memory."""

from __future__ import annotations

import select
import socket
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from google.protobuf.message import DecodeError

from collided.errors import DataLoss, Unavailable, error_of
from collided.frames.updates import Update
from collided.transport.base import NotSent
from collided.transport.peer import check_trusted, connect_to_socket
from collided.transport.region import ALIGNMENT, MAX_PACKET_BYTES, Region, RegionLayout
from collided.v1 import collision_service_pb2 as api
from collided.v1 import frame_pb2, local_pb2, shared_range_pb2

_VERSION = 1
_MAX_INLINE_BYTES = 64  # up to this many go into the packet itself


@dataclass(frozen=True)
class LocalPeer:
    """The socket to connect to, and who may listen there."""

    path: str
    address: str
    daemon_user: int | None
    token: str


class LocalTransport:
    is_local = True

    def __init__(self, peer: LocalPeer, layout: RegionLayout) -> None:
        self._socket = connect_to_socket(peer.path, socket.SOCK_SEQPACKET)
        try:
            check_trusted(self._socket, peer.path, peer.address, peer.daemon_user)
            self._region = Region(layout.input_bytes + layout.output_bytes)
        except Exception:
            self._socket.close()
            raise
        self._layout = layout
        self._token = peer.token
        self._frames = 0  # sent so far; the next one's part of the input follows from it
        self._used = 0  # bytes of that part that are taken

    def open(self, request: api.OpenStream) -> None:
        opening = local_pb2.LocalOpen(version=_VERSION, token=self._token, input_bytes=self._layout.input_bytes,
                                      output_bytes=self._layout.output_bytes, open=request)
        packet = local_pb2.LocalRequest(open=opening).SerializeToString()
        try:
            socket.send_fds(self._socket, [packet], [self._region.file])
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
        start, size, room = shared_range.offset, shared_range.size, self._layout.output_bytes
        if start > room or size > room - start:
            raise DataLoss(f"contacts.shared names {size} bytes at offset {start}; the output region has {room}")
        at = self._layout.input_bytes + start
        return self._region.bytes[at:at + size].data

    def close(self) -> None:
        try:
            self._socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass  # it has ended already
        self._socket.close()
        self._region.close()

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

    def _put(self, array: np.ndarray | None, out: Any, shared: str, inline: str) -> None:
        """In the input region; in the packet itself if it is small, or there is no room."""
        if array is None or not array.size:
            return
        placed = self._place(array.reshape(-1).view(np.uint8)) if array.nbytes > _MAX_INLINE_BYTES else None
        if placed is None:
            setattr(out, inline, array.tobytes())
        else:
            getattr(out, shared).CopyFrom(placed)

    def _place(self, data: np.ndarray) -> shared_range_pb2.SharedRange | None:
        if data.size > self._layout.frame_bytes - self._used:
            return None
        start = self._frames % self._layout.window * self._layout.frame_bytes + self._used
        self._used = min(-(-(self._used + data.size) // ALIGNMENT) * ALIGNMENT, self._layout.frame_bytes)
        np.copyto(self._region.bytes[start:start + data.size], data)
        return shared_range_pb2.SharedRange(offset=start, size=data.size)

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
