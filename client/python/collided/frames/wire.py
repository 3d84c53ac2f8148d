"""A frame as the bytes of a gRPC request: encoded here because protobuf's own encoder copies positions twice."""

from __future__ import annotations

from typing import Any

import numpy as np

from collided.frames import tags
from collided.frames.tags import varint
from collided.frames.updates import Update
from collided.v1 import frame_pb2


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


def encode_frame(frame_id: int, head: frame_pb2.Frame, updates: list[Update],
                 scene_id: str = "") -> tuple[bytes, list[Update]]:
    """A StreamFramesRequest, or with a scene's id a DetectFrameRequest; and the updates as views of it.

    head: the frame without its id and its updates.
    """
    frame = _Parts()
    options = tags.FRAME_ID + varint(frame_id) + head.SerializeToString()
    frame.add(options, len(options))
    for update in updates:
        frame.message(tags.UPDATES, _update(update))
    request = _Parts()
    if scene_id:
        scene = scene_id.encode()
        field = tags.SCENE_ID + varint(len(scene)) + scene
        request.add(field, len(field))
    request.message(tags.FRAME, frame)
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
        index = tags.MESH + varint(update.mesh)
        out.add(index, len(index))
    if update.indices is not None:
        sparse = _Parts()
        sparse.field(tags.INDICES, update.indices)
        out.message(tags.SPARSE, sparse)
    if update.pose is not None:
        rigid = _Parts()
        rigid.field(tags.MATRIX, update.pose)
        rigid.field(tags.START_MATRIX, update.start_pose)
        out.message(tags.RIGID, rigid)
    out.field(tags.START, update.start)
    out.field(tags.POSITIONS, update.positions)
    return out
