"""A frame as the bytes of a request: encoded here because protobuf's own encoder copies positions twice."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from collided.frames.updates import Update
from collided.v1 import frame_pb2

# Tags of fields that have a length: number << 3 | 2.
_SCENE_ID = b"\x0a"  # DetectFrameRequest.scene_id
_FRAME = b"\x12"  # StreamFramesRequest.frame and DetectFrameRequest.frame
_UPDATES = b"\x1a"  # Frame.updates
_MESH = b"\x08"  # MeshUpdate.mesh, a varint
_SPARSE, _RIGID, _START, _POSITIONS = b"\x12", b"\x1a", b"\x22", b"\x2a"
_INDICES = b"\x0a"
_MATRIX, _START_MATRIX = b"\x0a", b"\x12"


@lru_cache(256)  # sizes are the same from frame to frame
def varint(value: int) -> bytes:
    """As protobuf writes an unsigned number."""
    out = bytearray()
    while value > 0x7F:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    out.append(value)
    return bytes(out)


class _Parts:
    """Pieces of a message, of which the last ones may be arrays in their callers' memory."""

    def __init__(self) -> None:
        self.pieces: list[Any] = []
        self.size = 0

    def add(self, piece: Any, size: int) -> None:
        self.pieces.append(piece)
        self.size += size

    def field(self, tag: bytes, array: np.ndarray | None) -> None:
        if array is None or not array.size:
            return
        head = tag + varint(array.nbytes)
        self.add(head, len(head))
        self.add(array.reshape(-1).view(np.uint8).data, array.nbytes)

    def message(self, tag: bytes, parts: _Parts) -> None:
        head = tag + varint(parts.size)
        self.add(head, len(head))
        self.pieces += parts.pieces
        self.size += parts.size


def encode_frame(head: frame_pb2.Frame, updates: list[Update], scene_id: str = "") -> tuple[bytes, list[Update]]:
    """A StreamFramesRequest, or with a scene's id a DetectFrameRequest; and the updates as views of it.

    head: the frame without its updates.
    """
    frame = _Parts()
    options = head.SerializeToString()
    frame.add(options, len(options))
    for update in updates:
        frame.message(_UPDATES, _update(update))
    request = _Parts()
    if scene_id:
        scene = scene_id.encode()
        field = _SCENE_ID + varint(len(scene)) + scene
        request.add(field, len(field))
    request.message(_FRAME, frame)
    message = b"".join(request.pieces)
    return message, _views(message, request.pieces, updates)


def _views(message: bytes, pieces: list[Any], updates: list[Update]) -> list[Update]:
    """The updates in the message's memory instead of their callers'."""
    offsets, at = [], 0
    for piece in pieces:
        if isinstance(piece, memoryview):
            offsets.append(at)
        at += len(piece)
    left = iter(offsets)

    def view(array: np.ndarray | None) -> np.ndarray | None:
        if array is None or not array.size:
            return array
        return np.frombuffer(message, array.dtype, array.size, next(left)).reshape(array.shape)

    # In the order in which _update() writes them.
    return [Update(u.mesh, indices=view(u.indices), pose=view(u.pose), start_pose=view(u.start_pose),
                   start=view(u.start), positions=view(u.positions)) for u in updates]


def _update(update: Update) -> _Parts:
    out = _Parts()
    if update.mesh:
        index = _MESH + varint(update.mesh)
        out.add(index, len(index))
    if update.indices is not None:
        sparse = _Parts()
        sparse.field(_INDICES, update.indices)
        out.message(_SPARSE, sparse)
    if update.pose is not None:
        rigid = _Parts()
        rigid.field(_MATRIX, update.pose)
        rigid.field(_START_MATRIX, update.start_pose)
        out.message(_RIGID, rigid)
    out.field(_START, update.start)
    out.field(_POSITIONS, update.positions)
    return out
