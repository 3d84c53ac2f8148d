"""A stream of frames that survives its connection and its daemon."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any, Unpack

import numpy as np

from collided.choices import choice
from collided.contacts.answer import Answer
from collided.contacts.columns import Part, read_chunk
from collided.contacts.contacts import Contacts
from collided.errors import DataLoss, DeadlineExceeded, Error, FailedPrecondition, InvalidArgument, NotFound, ResourceExhausted, error_of
from collided.frames.options import FrameOptions
from collided.frames.track import Request
from collided.layout import Layout
from collided.scene import Scene
from collided.transport.base import NotSent, Transport
from collided.transport.opening import StreamOptions, open_transport
from collided.v1 import collision_service_pb2 as api
from collided.v1 import frame_pb2

_FIRST_PAUSE, _LONGEST_PAUSE = 0.02, 1.0


@dataclass(eq=False)
class _Pending:
    """A frame that was sent and is not answered yet. wire_id: its id on the current stream."""

    frame_id: int
    request: Request
    wire_id: int = 0
    parts: list[Part] = field(default_factory=list)


class Session:
    """Frames in, contacts out, in order; a context manager. For one thread at a time.

    meshes: a Scene, which stays; or what Scene takes, with its options: then the scene is the session's own.
    window: frames in flight, 1 to the daemon's limit; 0: the daemon chooses (2).
    delivery: "lossless", or "latest_wins" (with a window above 2): waiting frames give way to newer ones.
    transport: "auto": shared memory if the daemon is on this host and offers it, else gRPC; "shared_memory"; "grpc"; "calls": a
        call for each frame, and no stream.
    output_bytes: room in shared memory for each frame's contacts; the rest comes over the socket, which is slower.
    edit_bytes: room for each frame's edit and for positions of what edits have added.
    daemon_user: another user id that the daemon may run as, to be trusted with a token over its local socket.
    take_over: from another stream of the Scene that may still be open, and then ends with Aborted.
    reconnect_seconds: how long a lost connection or daemon is waited for; 0: the loss is raised at once.

    A connection or a daemon that is lost is not noticed but in `reconnects` and `recreations`: the session connects again,
    has the scene created again if it is gone, brings it to where it was, and sends what was not answered. Answers are the
    same to the bit. If that fails, Unavailable is raised, and the next call tries again: no frame is lost.

    Exceptions of a refused frame come from `receive`, `step` or `run` in its turn; the session goes on.
    """

    def __init__(self, meshes: Any, *, window: int = 0, delivery: str = "lossless", transport: str = "auto",
                 output_bytes: int = 8 << 20, edit_bytes: int = 0, daemon_user: int | None = None,
                 take_over: bool = False, reconnect_seconds: float = 60.0, **scene_options: Any) -> None:
        if isinstance(meshes, Scene) and scene_options:
            raise InvalidArgument(f"{min(scene_options)} is given with a Scene, which has its own", field=min(scene_options))
        self.options = StreamOptions(
            window=window, delivery=choice(api.DeliveryPolicy, "DELIVERY_POLICY_", delivery, "delivery"), transport=transport,
            output_bytes=output_bytes, edit_bytes=edit_bytes, daemon_user=daemon_user)
        self._owns_scene = not isinstance(meshes, Scene)
        self.scene = meshes if isinstance(meshes, Scene) else Scene(meshes, **scene_options)
        self._reconnect_seconds = reconnect_seconds
        self._track = self.scene.track
        self._transport: Transport | None = None
        self._pending: deque[_Pending] = deque()
        self._ready: deque[Contacts | Error] = deque()
        self._sent = 0
        self._draining: float | None = None
        self._has_answered = False  # on the current stream
        self._failure: Error | None = None  # why no other stream will be opened
        self.local_refusal = ""
        self.window = 0
        self.reconnects = 0
        self.recreations = 0
        try:
            self._open(resume=take_over)
        except Error:
            self._close_scene()
            raise

    # Frames.

    def step(self, positions: Any = None, start: Any = None, *, timeout: float | None = None,
             **options: Unpack[FrameOptions]) -> Contacts:
        """Sends a frame and waits for its contacts, with nothing else in flight.

        positions: of the mesh that can move, or a mapping of meshes, by name or index, to positions (n, 3), `Sparse` or
            `Rigid`. Meshes that are not named stand still.
        start: likewise, where meshes are at t = 0 (CCD); None: where the last frame left them.
        timeout: seconds after which DeadlineExceeded is raised; the frame stays in flight, for `receive`.
        options: those of FrameOptions.

        Raises InvalidArgument before anything is sent for shapes, dtypes and meshes that cannot be, and what the daemon
        refuses the frame with: it leaves the scene unchanged.
        """
        self._check_open()
        if self.in_flight:
            raise FailedPrecondition(f"step() with {self.in_flight} frames in flight: receive them first")
        self.send(positions, start, **options)
        return self.receive(timeout)

    def send(self, positions: Any = None, start: Any = None, **options: Unpack[FrameOptions]) -> int:
        """Sends a frame, and waits for that while a whole window is in flight. Returns the frame's number, from 1.

        Arguments as of `step`. Arrays may be changed once this returns.
        """
        self._check_open()
        self._begin()
        request = self._track.request(self._layout, not self._has_begun, positions, start, options)
        while self._transport is not None and len(self._pending) >= self.window:
            self._read(None)
        pending = _Pending(self._sent + 1, request)
        self._pending.append(pending)
        try:
            self._transmit_or_recover(pending)
        except Error:
            self._pending.remove(pending)
            raise
        self._sent += 1
        return self._sent

    def receive(self, timeout: float | None = None) -> Contacts:
        """The next frame's contacts, in the order in which frames were sent. Raises what the daemon refused it with.

        timeout: seconds to wait; DeadlineExceeded if nothing came, and nothing is lost. FailedPrecondition if no frame is in
        flight.
        """
        if not self.in_flight:
            raise FailedPrecondition("receive() with no frame in flight")
        deadline = None if timeout is None else time.monotonic() + timeout
        while not self._ready:
            left = None if deadline is None else max(0.0, deadline - time.monotonic())
            if not self._read(left):
                raise DeadlineExceeded(f"frame {self._pending[0].frame_id} was not answered within {timeout} s; it is still "
                                       "in flight")
        answer = self._ready.popleft()
        if isinstance(answer, Error):
            raise answer
        return answer

    def run(self, frames: Iterable[Any], **options: Unpack[FrameOptions]) -> Iterator[Contacts]:
        """Contacts of each frame's positions, in order, with a whole window in flight."""
        for positions in frames:
            while self.in_flight >= self.window:
                yield self.receive()
            self.send(positions, **options)
        while self.in_flight:
            yield self.receive()

    # Where the scene is.

    @property
    def positions(self) -> dict[str, np.ndarray]:
        """Where each mesh is after the last answered frame: the daemon's bits, (n, 3), in the scene's format."""
        layout, form = self._track.layout, self._track.form
        return {mesh.name: self._track.state[i].real(form) for i, mesh in layout.present() if i in self._track.state}

    @property
    def in_flight(self) -> int:
        """Frames that were sent and not received."""
        return len(self._pending) + len(self._ready)

    @property
    def is_local(self) -> bool:
        """Whether positions and contacts go through shared memory; if not, `local_refusal` may say why."""
        return self._transport is not None and self._transport.is_local

    @property
    def draining_seconds(self) -> float | None:
        """Seconds until a daemon that is stopping closes the stream; None unless it is stopping."""
        return None if self._draining is None else max(0.0, self._draining - time.monotonic())

    # The end.

    def close(self) -> None:
        """Ends the stream, and deletes the scene if it is the session's own. Frames in flight are given up."""
        self._failure = FailedPrecondition("the session is closed")
        self._close_transport()
        self._close_scene()

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _close_transport(self) -> None:
        if self._transport is not None:
            self._transport.close()
            self._transport = None

    def _close_scene(self) -> None:
        if self._owns_scene:
            self.scene.close()

    # Sending and reading.

    @property
    def _layout(self) -> Layout:
        """Of the scene once all that was sent is answered."""
        edits = (pending.request.edit for pending in reversed(self._pending) if pending.request.edit is not None)
        last = next(edits, None)
        return self._track.layout if last is None else last.layout

    @property
    def _has_begun(self) -> bool:
        """Whether the scene has positions, or will have."""
        return bool(self._track.state) or any(not pending.request.head.trial for pending in self._pending)

    def _begin(self) -> None:
        """Puts a scene whose meshes all have vertices there."""
        while not self._has_begun:
            state = self._track.initial()
            if state is None:
                return
            try:
                if self._transport is None:
                    self._reopen()
                self._exchange(self._track.beginning(state))
            except NotSent:
                raise
            except Error as error:
                self._after(error)

    def _transmit_or_recover(self, pending: _Pending) -> None:
        try:
            if self._transport is None:
                self._reopen()
            else:
                self._transmit(pending)
        except Error as error:
            if not error.is_connection_lost:
                raise
            self._after(error)

    def _transmit(self, pending: _Pending) -> None:
        assert self._transport is not None
        pending.wire_id = pending.request.head.frame_id = self._track.next_id()
        pending.parts.clear()
        pending.request.updates = self._transport.send(pending.request.head, pending.request.updates)

    def _read(self, timeout: float | None) -> bool:
        """Takes one message; False if none came in time."""
        try:
            if self._transport is None:
                self._reopen()
                return True
            response = self._transport.read(timeout)
            if response is not None:
                self._take(response)
            return response is not None
        except Error as error:
            self._after(error)
            return True

    def _take(self, response: api.StreamFramesResponse) -> None:
        kind = response.WhichOneof("response")
        self._has_answered = True
        if kind == "draining":
            self._draining = time.monotonic() + response.draining.deadline_seconds
            return
        pending = self._pending[0] if self._pending else None
        if pending is None or response.frame_id != pending.wire_id:
            raise DataLoss(f"the daemon answers frame {response.frame_id}, which is not the next in flight")
        assert self._transport is not None
        if kind == "contacts":
            pending.parts.append(read_chunk(response.contacts, self._transport.shared))
            return
        self._pending.popleft()
        if kind == "done":
            pending.parts += [read_chunk(chunk, self._transport.shared) for chunk in response.done.contacts]
            del response.done.contacts[:]
            self._ready.append(self._contacts(pending, response.done))
        elif kind == "error":
            self._track.refuse()
            self._ready.append(_refusal(response.error, pending.frame_id))
        else:
            answer = Answer(pending.frame_id, frame_pb2.FrameDone(earliest_toi=1), self._track.layout, None, False, True)
            self._ready.append(Contacts.of_parts(answer, []))

    def _contacts(self, pending: _Pending, done: frame_pb2.FrameDone) -> Contacts:
        head = pending.request.head
        way = self._track.apply(pending.request, done, pending.wire_id)
        answer = Answer(pending.frame_id, done, way.layout, way, self._track.has_motion(head))
        return Contacts.of_parts(answer, pending.parts)

    def _exchange(self, request: Request) -> None:
        """A frame of the session's own, whose answer only counts."""
        assert self._transport is not None
        head, wire_id = request.head, self._track.next_id()
        head.frame_id = wire_id
        request.updates = self._transport.send(head, request.updates)
        while True:
            response = self._transport.read(None)
            assert response is not None
            if response.frame_id != wire_id or response.WhichOneof("response") == "contacts":
                continue
            if response.WhichOneof("response") == "error":
                raise _refusal(response.error, 0)
            if request.is_counted:
                self._track.apply(request, response.done, wire_id)
            elif not head.trial:
                self._track.last_applied = wire_id
            return

    # Losing and finding the daemon.

    def _check_open(self) -> None:
        """Raises why the session has ended, if it has for good."""
        if self._failure is not None:
            raise self._failure

    def _after(self, error: Error) -> None:
        """Goes on after the stream has ended, or raises why it cannot."""
        self._close_transport()
        has_idled = isinstance(error, ResourceExhausted) and self._has_answered
        if not (error.is_connection_lost or has_idled):
            self._failure = error
            raise error
        deadline = time.monotonic() + self._reconnect_seconds
        pause = _FIRST_PAUSE
        while True:
            if time.monotonic() >= deadline:
                raise error
            try:
                return self._reopen()
            except Error as again:
                self._close_transport()
                if not again.is_connection_lost:
                    raise
                error = again
            time.sleep(min(pause, max(0.0, deadline - time.monotonic())))
            pause = min(2 * pause, _LONGEST_PAUSE)

    def _reopen(self) -> None:
        """A stream on which everything that is in flight was sent again. Raises Error."""
        self._check_open()
        self.scene.client.reconnect()
        try:
            last_applied = self._open(resume=True)
        except NotFound:
            last_applied = -1
        if last_applied != self._track.last_applied:
            self._recreate()
        self.reconnects += 1
        self._draining = None
        for pending in self._pending:
            self._transmit(pending)

    def _recreate(self) -> None:
        """A new scene where the old one was: it is gone, or has applied frames whose answers were lost."""
        self._close_transport()
        self.scene.create_again()
        self._open(resume=False)
        if self._track.state:
            for request in self._track.replaying():
                self._exchange(request)
        else:
            self._track.last_applied = 0
        self.recreations += 1

    def _open(self, resume: bool) -> int:
        """Opens a stream. Returns the last frame that the scene has applied, by its id on the wire."""
        self._transport, opened, self.local_refusal = open_transport(self.scene.client, self.scene.message, self.options,
                                                                     resume)
        self.window = opened.window
        self._has_answered = False
        self._track.last_sent = max(self._track.last_sent, opened.scene.last_frame_id)
        return opened.scene.last_frame_id


def _refusal(error: frame_pb2.FrameError, frame_id: int) -> Error:
    return error_of(error.code, error.message, field=error.field, retry_after=error.retry_after_seconds or None,
                    frame_id=frame_id)
