"""A frame stream over gRPC, on a connection of its own."""

from __future__ import annotations

import concurrent.futures
import queue
from typing import Any

import grpc

from collided.errors import DataLoss, ResourceExhausted, Unavailable, error_of_call
from collided.frames.updates import Update
from collided.frames.wire import encode_frame
from collided.v1 import collision_service_pb2 as api
from collided.v1 import frame_pb2

_METHOD = "/collided.v1.CollisionService/StreamFrames"


class GrpcTransport:
    is_local = False

    def __init__(self, channel: grpc.Channel, metadata: list[tuple[str, str]], max_message_bytes: int) -> None:
        self._channel = channel
        self._max_message_bytes = max_message_bytes
        self._requests: queue.SimpleQueue[bytes | None] = queue.SimpleQueue()
        stream = channel.stream_stream(_METHOD, request_serializer=None,
                                       response_deserializer=api.StreamFramesResponse.FromString)
        self._call = stream(iter(self._requests.get, None), metadata=metadata)
        self._reader = concurrent.futures.ThreadPoolExecutor(1, "collided-reader")
        self._pending: concurrent.futures.Future[api.StreamFramesResponse] | None = None

    def open(self, request: api.OpenStream) -> None:
        self._requests.put(api.StreamFramesRequest(open=request).SerializeToString())

    def send(self, head: frame_pb2.Frame, updates: list[Update]) -> list[Update]:
        message, kept = encode_frame(head, updates)
        if len(message) > self._max_message_bytes:
            raise ResourceExhausted(f"frame has {len(message)} bytes; the daemon's limit for a message is "
                                    f"{self._max_message_bytes} (max-message-mb)", field="frame")
        self._requests.put(message)
        return kept

    def read(self, timeout: float | None) -> api.StreamFramesResponse | None:
        # gRPC has no timeout for one message of a stream: where one is asked for, a thread waits, and goes on waiting.
        if self._pending is None and timeout is None:
            return self._next()
        if self._pending is None:
            self._pending = self._reader.submit(self._next)
        try:
            response = self._pending.result(timeout)
        except concurrent.futures.TimeoutError:
            if not self._pending.done():
                return None
            raise
        self._pending = None
        return response

    def _next(self) -> api.StreamFramesResponse:
        try:
            return next(self._call)
        except StopIteration:
            raise Unavailable("the stream has ended") from None
        except grpc.RpcError as error:
            raise error_of_call(error) from None

    def shared(self, shared_range: Any) -> memoryview:
        raise DataLoss(f"contacts.shared names {shared_range.size} bytes, but there is no shared memory over gRPC")

    def half_close(self) -> None:
        self._requests.put(None)

    def close(self) -> None:
        self._requests.put(None)
        self._call.cancel()
        self._channel.close()
        self._reader.shutdown(wait=False)
