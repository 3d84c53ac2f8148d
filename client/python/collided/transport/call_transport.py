"""Frames by DetectFrame, a call each: for callers who want no stream to stay open."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from functools import partial
from typing import Any

import grpc

from collided.connection.channel import end_elsewhere, metadata
from collided.connection.client import Client
from collided.errors import (DataLoss, Error, FailedPrecondition, InvalidArgument, NotFound, ResourceExhausted,
                             Unavailable, error_of_call)
from collided.frames.updates import Update
from collided.frames.wire import encode_frame
from collided.v1 import collision_service_pb2 as api
from collided.v1 import frame_pb2

_METHOD = "/collided.v1.CollisionService/DetectFrame"
_CODES = {InvalidArgument: 3, ResourceExhausted: 8, FailedPrecondition: 9}


class CallTransport:
    """One call at a time, on a channel of its own, which no other user of the client can close; by a thread, so that reading can
    have a timeout, and an interrupt never is in a call."""

    is_local = False

    def __init__(self, client: Client) -> None:
        self._client = client
        self._channel = client.separate_channel()
        self._detect_frame = self._channel.unary_unary(_METHOD, request_serializer=None,
                                                       response_deserializer=api.DetectFrameResponse.FromString)
        self._scene_id = ""
        self._opened: api.StreamFramesResponse | None = None
        self._requests: queue.SimpleQueue[bytes | None] = queue.SimpleQueue()
        self._answers: queue.SimpleQueue[api.DetectFrameResponse | Error] = queue.SimpleQueue()
        self._frame_id = 0  # of the call
        self._is_astray = False  # a frame was applied, and counts as refused

    def open(self, request: api.OpenStream) -> None:
        self._scene_id = request.scene_id
        opened = api.StreamOpened(scene=self._client.get_scene(request.scene_id), window=1)
        self._opened = api.StreamFramesResponse(opened=opened)
        options = self._client.options
        ask = partial(self._detect_frame, timeout=options.deadline, metadata=metadata(options, self._scene_id))
        # A daemon thread, so that a process can end while it waits.
        threading.Thread(target=_serve, args=(ask, self._requests, self._answers), name="collided-calls", daemon=True).start()

    def send(self, frame_id: int, head: frame_pb2.Frame, updates: list[Update]) -> list[Update]:
        if self._is_astray:
            raise Unavailable("the scene is where a frame has left it that was refused")
        request, kept = encode_frame(frame_id, head, updates, self._scene_id)
        self._frame_id = frame_id
        self._requests.put(request)
        return kept

    def read(self, timeout: float | None) -> api.StreamFramesResponse | None:
        if self._opened is not None:
            opened, self._opened = self._opened, None
            return opened
        if not self._frame_id:
            raise Unavailable("no call is open")
        try:
            answer = self._answers.get(timeout=timeout)
        except queue.Empty:
            return None
        frame_id, self._frame_id = self._frame_id, 0
        if isinstance(answer, Error):
            return api.StreamFramesResponse(frame_id=frame_id, error=self._refusal(answer, frame_id))
        if not answer.HasField("done"):
            raise DataLoss(f"the daemon's answer to frame {frame_id} has no end")
        answer.done.contacts.extend(answer.contacts)
        return api.StreamFramesResponse(frame_id=frame_id, done=answer.done)

    def _refusal(self, error: Error, frame_id: int) -> frame_pb2.FrameError:
        """Of a frame that was refused. Raises other errors."""
        if isinstance(error, NotFound):  # its lease may have ended, as no stream keeps it
            raise Unavailable(error.message)
        if type(error) not in _CODES:
            raise error
        message = error.message
        if isinstance(error, ResourceExhausted) and error.retry_after is None:
            # The daemon may have gone on with the frame, and only its answer was too large.
            self._is_astray = self._client.get_scene(self._scene_id).last_frame_id == frame_id
            if self._is_astray:
                message += "; the next frame begins where the scene was before this one"
        return frame_pb2.FrameError(code=_CODES[type(error)], message=message, field=error.field,
                                    retry_after_seconds=error.retry_after or 0)

    def shared(self, shared_range: Any) -> memoryview:
        raise DataLoss(f"contacts.shared names {shared_range.size} bytes, but there is no shared memory")

    def half_close(self) -> None:
        pass  # there is no stream

    def close(self) -> None:
        self._requests.put(None)
        end_elsewhere(self._channel.close)


def _serve(ask: Callable[[bytes], api.DetectFrameResponse], requests: queue.SimpleQueue[bytes | None],
           answers: queue.SimpleQueue[api.DetectFrameResponse | Error]) -> None:
    while (request := requests.get()) is not None:
        try:
            answers.put(ask(request))
        except grpc.RpcError as error:
            answers.put(error_of_call(error))
        except ValueError:  # of gRPC, where the transport was closed meanwhile
            break
    answers.put(Unavailable("the transport is closed"))  # for whoever still waits
