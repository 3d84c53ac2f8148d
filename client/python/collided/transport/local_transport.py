"""A frame stream over the daemon's local socket: positions and contacts are in shared memory."""

from __future__ import annotations

import select
import socket
import sys
from typing import Any

from google.protobuf.message import DecodeError

from collided.errors import DataLoss, Unavailable, error_of
from collided.frames.updates import Update
from collided.transport.local_frames import LocalFrames
from collided.transport.peer import LocalPeer, connect_to_trusted
from collided.transport.region import MAX_PACKET_BYTES, Memory
from collided.v1 import collision_service_pb2 as api
from collided.v1 import frame_pb2, local_pb2, shared_range_pb2

_VERSION = 1


class LocalTransport:
    is_local = True

    def __init__(self, peer: LocalPeer, memory: Memory) -> None:
        self._memory = memory
        try:
            self._socket = connect_to_trusted(peer)
        except Exception:
            memory.close()
            raise
        self._token, self._deadline = peer.options.token, peer.options.deadline
        self._frames = LocalFrames(memory)
        self._packet = memoryview(bytearray(MAX_PACKET_BYTES))

    def open(self, request: api.OpenStream) -> None:
        opening = local_pb2.LocalOpen(version=_VERSION, token=self._token, open=request)
        files = self._memory.describe(opening)
        packet = local_pb2.LocalRequest(open=opening).SerializeToString()
        try:
            if sys.platform == "linux" and files:
                socket.send_fds(self._socket, [packet], files)
            else:
                self._socket.send(packet)
        except OSError:
            pass  # a daemon that refuses the connection has closed it by now, and its answer can still be read

    def send(self, frame_id: int, head: frame_pb2.Frame, updates: list[Update]) -> list[Update]:
        packet = self._frames.pack(frame_id, head, updates)
        try:
            self._socket.send(packet)
        except BlockingIOError:
            raise Unavailable(f"the daemon did not take a frame within {self._deadline:g} s (deadline)") from None
        except OSError:
            pass  # reading tells why the stream has ended
        return self._frames.lasting(updates)  # the daemon is at work meanwhile

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
                return bytes(self._packet[:self._socket.recv_into(self._packet)])
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
