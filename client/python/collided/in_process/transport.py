"""A stream of frames for the engine in this process."""

from __future__ import annotations

import ctypes
import queue
import threading
from typing import Any

import numpy as np

from collided.errors import Error, FailedPrecondition, Unavailable, code_of
from collided.frames.updates import Update
from collided.in_process.client import LocalClient
from collided.in_process.engine import EngineScene, Result
from collided.v1 import collision_service_pb2 as api
from collided.v1 import frame_pb2, scene_pb2

_Frame = tuple[int, frame_pb2.Frame, list[Update]]
_Answer = tuple[int, frame_pb2.Frame, Result | Error]


def taken_by(stream: Any, client: LocalClient, scene_id: str, resume: bool) -> EngineScene:
    """The scene, for the one stream that it has at a time. resume: ends another one that it may have."""
    engine = client.engine(scene_id)
    if engine.stream is not None:
        if not resume:
            raise FailedPrecondition(f"scene {scene_id} has a stream already; one at a time")
        engine.stream.close()
    engine.give_up(False)
    engine.stream = stream
    return engine


class EngineTransport:
    """A thread computes, so that reading can have a timeout and a frame can be sent while another one is in work."""

    is_local = True

    def __init__(self, client: LocalClient, scene: scene_pb2.Scene, resume: bool) -> None:
        """resume: takes the scene over from a stream that may still be open."""
        self._client, self._scene_id = client, scene.scene_id
        self._engine = taken_by(self, client, scene.scene_id, resume)
        self._frames: queue.SimpleQueue[_Frame | None] = queue.SimpleQueue()
        self._answers: queue.SimpleQueue[_Answer | None] = queue.SimpleQueue()
        self._opened: api.StreamFramesResponse | None = None
        self._shown: Result | None = None  # whose arrays the last message names
        self._is_closed = False
        self._thread = threading.Thread(target=_serve, args=(self._engine, self._frames, self._answers),
                                        name="collided-engine", daemon=True)

    def open(self, request: api.OpenStream) -> None:
        opened = api.StreamOpened(scene=self._client.get_scene(self._scene_id), window=request.window or 2)
        self._opened = api.StreamFramesResponse(opened=opened)
        self._thread.start()

    def send(self, frame_id: int, head: frame_pb2.Frame, updates: list[Update]) -> list[Update]:
        kept = [_copy(update) for update in updates]
        self._frames.put((frame_id, head, kept))
        return kept

    def read(self, timeout: float | None) -> api.StreamFramesResponse | None:
        self._forget()
        if self._opened is not None:
            opened, self._opened = self._opened, None
            return opened
        if self._is_closed:
            raise Unavailable("the stream has ended")
        try:
            answer = self._answers.get(timeout=timeout)
        except queue.Empty:
            return None
        if answer is None:
            raise Unavailable("the stream has ended")
        frame_id, head, outcome = answer
        if isinstance(outcome, Error):
            return refusal(frame_id, outcome)
        self._shown = outcome
        return api.StreamFramesResponse(frame_id=frame_id, done=outcome.done(head.advance))

    def shared(self, shared_range: Any) -> memoryview:
        """Returns an array of the message that was read last."""
        return memoryview((ctypes.c_ubyte * shared_range.size).from_address(shared_range.offset)).cast("B")

    def half_close(self) -> None:
        self._frames.put(None)

    def close(self) -> None:
        """Gives the frame in work up."""
        if self._is_closed:
            return
        self._is_closed = True
        self._frames.put(None)
        self._engine.give_up(True)
        if self._thread.ident is not None and self._thread is not threading.current_thread():
            self._thread.join()
        while not self._answers.empty():
            answer = self._answers.get()
            if answer is not None and isinstance(answer[2], Result):
                answer[2].free()
        self._forget()
        if self._engine.stream is self:
            self._engine.stream = None

    def _forget(self) -> None:
        shown, self._shown = self._shown, None
        if shown is not None:
            shown.free()


def refusal(frame_id: int, error: Error) -> api.StreamFramesResponse:
    """The answer of a frame that was refused."""
    refused = frame_pb2.FrameError(code=code_of(error), message=error.message, field=error.field)
    return api.StreamFramesResponse(frame_id=frame_id, error=refused)


def _serve(engine: EngineScene, frames: queue.SimpleQueue[_Frame | None], answers: queue.SimpleQueue[_Answer | None]) -> None:
    while (frame := frames.get()) is not None:
        frame_id, head, updates = frame
        try:
            answers.put((frame_id, head, engine.detect(frame_id, head, updates)))
        except Error as error:
            answers.put((frame_id, head, error))
    answers.put(None)


def _copy(update: Update) -> Update:
    """Copies arrays that the caller may change."""

    def copied(array: np.ndarray | None) -> np.ndarray | None:
        return None if array is None else np.array(array, order="C")

    return Update(update.mesh, copied(update.positions), copied(update.start), copied(update.indices), copied(update.pose),
                  copied(update.start_pose))
