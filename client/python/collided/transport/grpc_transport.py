"""A frame stream over gRPC, on a connection of its own."""

from __future__ import annotations

import queue
from typing import Any

import grpc

from collided.errors import DataLoss
from collided.frames.updates import Update
from collided.frames.wire import encode_frame
from collided.transport.base import NotSent
from collided.transport.messages import Messages
from collided.v1 import collision_service_pb2 as api
from collided.v1 import frame_pb2

_METHOD = "/collided.v1.CollisionService/StreamFrames"


class GrpcTransport:
    is_local = False

    def __init__(self, channel: grpc.Channel, metadata: list[tuple[str, str]], max_message_bytes: int) -> None:
        self._max_message_bytes = max_message_bytes
        self._requests: queue.SimpleQueue[bytes | None] = queue.SimpleQueue()
        requests = iter(self._requests.get, None)
        stream = channel.stream_stream(_METHOD, request_serializer=None,
                                       response_deserializer=api.StreamFramesResponse.FromString)
        self._messages = Messages(channel, lambda: stream(requests, metadata=metadata))

    def open(self, request: api.OpenStream) -> None:
        self._requests.put(api.StreamFramesRequest(open=request).SerializeToString())

    def send(self, frame_id: int, head: frame_pb2.Frame, updates: list[Update]) -> list[Update]:
        message, kept = encode_frame(frame_id, head, updates)
        if len(message) > self._max_message_bytes:
            raise NotSent(f"frame has {len(message)} bytes; the daemon's limit for a message is "
                          f"{self._max_message_bytes} (max-message-mb)", field="frame")
        self._requests.put(message)
        return kept

    def read(self, timeout: float | None) -> api.StreamFramesResponse | None:
        return self._messages.next(timeout)

    def shared(self, shared_range: Any) -> memoryview:
        raise DataLoss(f"contacts.shared names {shared_range.size} bytes, but there is no shared memory over gRPC")

    def half_close(self) -> None:
        self._requests.put(None)

    def close(self) -> None:
        self._requests.put(None)
        self._messages.close()
