"""A stream of frames for the engine in this process, with positions and contacts on its device."""

from __future__ import annotations

from collections import deque
from typing import Any

from collided.errors import Error, FailedPrecondition, Unavailable
from collided.frames.updates import Incoming, Update
from collided.gpu.cuda import Cuda
from collided.in_process.client import LocalClient
from collided.in_process.engine import OnDevice, Result
from collided.in_process.transport import refusal, taken_by
from collided.v1 import collision_service_pb2 as api
from collided.v1 import frame_pb2, scene_pb2

_ALIGNMENT = 64  # of a room


class Rooms:
    """Memory of the scene's device for the contacts of so many frames in flight, each with room for so many bytes."""

    def __init__(self, cuda: Cuda, frames: int, frame_bytes: int) -> None:
        self.cuda = cuda
        self._frames, self._room = frames, frame_bytes // _ALIGNMENT * _ALIGNMENT
        self.output_bytes = frames * self._room
        self.address = cuda.allocate(self.output_bytes) if self.output_bytes else 0

    def room(self, frame: int) -> tuple[int, int]:
        """Address and size."""
        return (self.address + frame % self._frames * self._room if self._room else 0), self._room

    def __del__(self) -> None:
        if getattr(self, "address", 0):
            self.cuda.free(self.address)


class DeviceTransport:
    """A frame is computed while it is sent: the caller's arrays are read where they are, behind the streams that write them, and may
    be changed once `send` returns."""

    def __init__(self, client: LocalClient, scene: scene_pb2.Scene, rooms: Rooms) -> None:
        device = client.get_scene(scene.scene_id).device_id
        if not device.startswith(rooms.cuda.backend):
            raise FailedPrecondition(f"the scene is on {device}, and a DeviceSession needs one on {rooms.cuda.backend}: device='cuda'")
        self._rooms = rooms
        self._engine = taken_by(self, client, scene.scene_id, resume=False)
        self._answers: deque[api.StreamFramesResponse] = deque()
        self._sent = 0

    def send(self, frame_id: int, head: frame_pb2.Frame, updates: list[Update]) -> list[Update]:
        if self._engine.stream is not self:
            raise Unavailable("the stream has ended")
        place = OnDevice(self._stream_of(updates), *self._rooms.room(self._sent))
        self._sent += 1
        try:
            result = self._engine.detect(frame_id, head, updates, place)
        except Error as error:
            self._answers.append(refusal(frame_id, error))
            return []
        self._answers.append(self._answer(frame_id, head, result))
        return []

    def _stream_of(self, updates: list[Update]) -> int | None:
        """A stream behind which all arrays are there; the host waits for others, which is rare."""
        cuda = self._rooms.cuda
        arrays: list[Any] = [array for update in updates for array in (update.positions, update.start)]
        streams = {array.stream or cuda.default_stream for array in arrays if isinstance(array, Incoming)}
        last = streams.pop() if streams else cuda.default_stream
        for stream in streams:
            cuda.synchronize(stream or 0)
        return last

    def _answer(self, frame_id: int, head: frame_pb2.Frame, result: Result) -> api.StreamFramesResponse:
        try:
            done = result.done_on_device(head.advance, self._rooms.address)
        finally:
            result.free()
        return api.StreamFramesResponse(frame_id=frame_id, done=done)

    def read(self, timeout: float | None) -> api.StreamFramesResponse:
        if not self._answers:
            raise Unavailable("the stream has ended")
        return self._answers.popleft()

    def close(self) -> None:
        """Leaves the scene to another stream."""
        if self._engine.stream is self:
            self._engine.stream = None
