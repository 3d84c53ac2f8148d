"""Frames by DetectFrame, a call each: for callers who want no stream to stay open."""

from __future__ import annotations

from collections import deque
from typing import Any

from collided.connection.client import Client
from collided.errors import DataLoss, Error, FailedPrecondition, InvalidArgument, NotFound, ResourceExhausted, Unavailable
from collided.frames.updates import Update
from collided.frames.wire import encode_frame
from collided.v1 import collision_service_pb2 as api
from collided.v1 import frame_pb2

_METHOD = "/collided.v1.CollisionService/DetectFrame"
_CODES = {InvalidArgument: 3, ResourceExhausted: 8, FailedPrecondition: 9}


class CallTransport:
    is_local = False

    def __init__(self, client: Client) -> None:
        self._client = client
        self._detect_frame = client.channel().unary_unary(_METHOD, request_serializer=None,
                                                          response_deserializer=api.DetectFrameResponse.FromString)
        self._scene_id = ""
        self._answers: deque[api.StreamFramesResponse] = deque()

    def open(self, request: api.OpenStream) -> None:
        self._scene_id = request.scene_id
        opened = api.StreamOpened(scene=self._client.get_scene(request.scene_id), window=1)
        self._answers.append(api.StreamFramesResponse(opened=opened))

    def send(self, frame_id: int, head: frame_pb2.Frame, updates: list[Update]) -> list[Update]:
        request, kept = encode_frame(frame_id, head, updates, self._scene_id)
        try:
            answer = self._client.call(self._detect_frame, request, self._scene_id)
        except (InvalidArgument, ResourceExhausted, FailedPrecondition) as error:
            self._answers.append(api.StreamFramesResponse(frame_id=frame_id, error=_refusal(error)))
            return kept
        except NotFound as error:  # its lease may have ended, as no stream keeps it
            raise Unavailable(error.message) from None
        answer.done.contacts.extend(answer.contacts)
        self._answers.append(api.StreamFramesResponse(frame_id=frame_id, done=answer.done))
        return kept

    def read(self, timeout: float | None) -> api.StreamFramesResponse | None:
        if not self._answers:
            raise Unavailable("no call is open")
        return self._answers.popleft()

    def shared(self, shared_range: Any) -> memoryview:
        raise DataLoss(f"contacts.shared names {shared_range.size} bytes, but there is no shared memory")

    def half_close(self) -> None:
        pass  # there is no stream

    def close(self) -> None:
        self._answers.clear()


def _refusal(error: Error) -> frame_pb2.FrameError:
    return frame_pb2.FrameError(code=_CODES[type(error)], message=error.message, field=error.field,
                                retry_after_seconds=error.retry_after or 0)
