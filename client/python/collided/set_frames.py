"""Frames of a set: over a stream where the daemon grants one, else by DetectBatch."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from collided.connection.client import Client
from collided.contacts.checks import check_total
from collided.contacts.columns import Part, read_chunk
from collided.errors import DataLoss, DeadlineExceeded, Error, ResourceExhausted, error_of_frame
from collided.frames.updates import Update
from collided.transport.base import NotSent, Transport
from collided.transport.opening import StreamOptions, open_transport
from collided.v1 import batch_pb2, contact_pb2, frame_pb2, scene_pb2


@dataclass(eq=False)
class SetAnswer:
    """What came of a frame. begins: for each of `parts`, where the contacts of each world in the frame begin, and its end."""

    frame_id: int
    parts: list[Part] = field(default_factory=list)
    begins: list[np.ndarray] = field(default_factory=list)
    errors: list[frame_pb2.WorldError] = field(default_factory=list)
    done: frame_pb2.FrameDone = field(default_factory=frame_pb2.FrameDone)


class SetFrames:
    """One frame at a time, on a connection of their own. Over a stream the arrays are copied once, to where the daemon reads
    them, and contacts once."""

    def __init__(self, client: Client, scene: scene_pb2.Scene, options: StreamOptions) -> None:
        self._client, self._scene, self._options = client, scene, options
        self._transport: Transport | None = None
        self._has_no_stream = options.transport == "calls"
        self._channel: Any = None  # of calls
        self._last_id = self._applied = 0  # frames; the latter as of the stream's opening

    @property
    def is_local(self) -> bool:
        """Whether frames go through shared memory now."""
        return self._transport is not None and self._transport.is_local

    def ask(self, head: frame_pb2.Frame, update: Update, worlds: np.ndarray) -> SetAnswer:
        """The answer to a frame of these worlds. Raises Error where the whole frame is refused."""
        self._open()
        self._last_id += 1
        if self._transport is None:
            return self._call(head, update, worlds)
        try:
            return self._exchange(head, update, worlds)
        except Error as error:
            if error.frame_id or isinstance(error, NotSent):
                raise
            self._close_transport()
            if not (error.is_connection_lost or isinstance(error, ResourceExhausted)):
                raise
            self._open()  # it may have ended for having been idle
            if self._transport is None or self._applied >= self._last_id:  # the answer is lost
                raise
        except BaseException:  # such as KeyboardInterrupt: nobody knows what was sent and read
            self._close_transport()
            raise
        return self._exchange(head, update, worlds)

    def close(self) -> None:
        self._close_transport()
        if self._channel is not None:
            self._channel.close()

    def _open(self) -> None:
        if self._transport is not None or self._has_no_stream:
            return
        try:
            self._transport, opened, _ = open_transport(self._client, self._scene, self._options, True,
                                                         self._client.options.deadline)
        except ResourceExhausted:
            if self._options.transport != "auto":
                raise
            self._has_no_stream = True
            return
        self._applied = opened.scene.last_frame_id
        self._last_id = max(self._last_id, self._applied)

    def _close_transport(self) -> None:
        if self._transport is not None:
            self._transport.close()
            self._transport = None

    def _exchange(self, head: frame_pb2.Frame, update: Update, worlds: np.ndarray) -> SetAnswer:
        transport = self._transport
        assert transport is not None
        self._client.check_known(head, "frame")
        transport.send(self._last_id, head, [update])
        answer, seen = SetAnswer(self._last_id), set(worlds.tolist())
        until = time.monotonic() + self._client.options.deadline
        while True:
            left = until - time.monotonic()
            response = transport.read(left) if left > 0 else None
            if response is None:
                raise DeadlineExceeded(f"frame {self._last_id} of the set was not answered in "
                                       f"{self._client.options.deadline:g} s")
            kind = response.WhichOneof("response")
            if response.frame_id != self._last_id:
                continue  # of a step that was interrupted, or of no frame
            if kind == "error":
                raise error_of_frame(response.error, self._last_id)
            if kind == "world_errors":
                for refused in response.world_errors.errors:
                    if refused.world not in seen:
                        raise DataLoss(f"world_errors names world {refused.world}, which is not in the frame, or twice")
                    seen.remove(refused.world)
                    answer.errors.append(refused)
            for chunk in [response.contacts] if kind == "contacts" else response.done.contacts:
                answer.parts.append(read_chunk(chunk, transport.shared))
                answer.begins.append(_begins_by_column(chunk, worlds, transport))
            if kind == "done":
                del response.done.contacts[:]
                answer.done = response.done
                check_total(answer.done, answer.parts)
                return answer

    def _call(self, head: frame_pb2.Frame, update: Update, worlds: np.ndarray) -> SetAnswer:
        most = self._client.info.limits.max_message_bytes
        if self._channel is None:
            self._channel = self._client.separate_channel(max_answer_bytes=most)
        frame = batch_pb2.SetFrame(
            scene_id=self._scene.scene_id, frame_id=self._last_id, worlds=head.worlds, mode=head.mode, accuracy=head.accuracy,
            positions=b"" if update.positions is None else update.positions.tobytes(),
            start_positions=b"" if update.start is None else update.start.tobytes())
        if head.HasField("delta"):
            frame.delta = head.delta
        request = batch_pb2.DetectBatchRequest(frames=[frame], max_answer_bytes=most)
        answers = self._client.call("DetectBatch", request, self._scene.scene_id, channel=self._channel).answers
        if len(answers) != 1:
            raise DataLoss(f"answers has {len(answers)} entries for 1 frame")
        answer = answers[0]
        if answer.HasField("error"):
            raise error_of_frame(answer.error, self._last_id)
        if not answer.HasField("done"):
            raise DataLoss(f"the daemon's answer to frame {self._last_id} of the set has no end")
        return SetAnswer(self._last_id, [read_chunk(of_kind.contacts) for of_kind in answer.contacts],
                         [_begins(of_kind, len(worlds)) for of_kind in answer.contacts], list(answer.errors), answer.done)


def _begins_by_column(chunk: contact_pb2.ContactChunk, worlds: np.ndarray, transport: Transport) -> np.ndarray:
    data: Any = chunk.worlds or transport.shared(chunk.shared.worlds)
    column = np.frombuffer(data, "<u4") if len(data) == 4 * chunk.count else np.empty(0, "<u4")
    begin, end = np.searchsorted(column, worlds, "left"), np.searchsorted(column, worlds, "right")
    if (end - begin).sum() != chunk.count or (begin[1:] != end[:-1]).any():
        raise DataLoss(f"contacts.worlds has {len(data)} bytes that do not divide {chunk.count} contacts among {len(worlds)} "
                       "worlds")
    return np.append(begin, chunk.count)


def _begins(contacts: batch_pb2.WorldContacts, worlds: int) -> np.ndarray:
    begin = np.frombuffer(contacts.begin, "<u8").astype(np.int64) if len(contacts.begin) % 8 == 0 else np.empty(0, np.int64)
    if len(begin) != worlds + 1 or begin[0] != 0 or begin[-1] != contacts.contacts.count or (np.diff(begin) < 0).any():
        raise DataLoss(f"contacts.begin has {len(contacts.begin)} bytes that do not divide {contacts.contacts.count} "
                       f"contacts among {worlds} worlds")
    return begin
