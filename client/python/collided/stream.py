"""A stream of frames that goes on when its connection or its daemon is lost."""

from __future__ import annotations

import math
import os
import time
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, field

from collided.callers import warn
from collided.contacts.answer import Answer
from collided.contacts.checks import check_done, check_total
from collided.contacts.columns import Part, read_chunk, read_limits
from collided.contacts.contacts import Contacts
from collided.contacts.pairs import read_pairs
from collided.errors import (DataLoss, DeadlineExceeded, Error, FailedPrecondition, NotFound, ResourceExhausted, Unavailable,
                             Unimplemented, error_of_frame)
from collided.frames.advance import read_advance
from collided.frames.state import State
from collided.frames.track import NOWHERE, Request
from collided.guard import Guard
from collided.layout import Layout
from collided.scene import Scene
from collided.transport.base import NotSent, Transport
from collided.transport.opening import StreamOptions, open_transport
from collided.v1 import collision_service_pb2 as api
from collided.v1 import contact_pb2, frame_pb2

_FIRST_PAUSE, _LONGEST_PAUSE = 0.02, 1.0
_FIRST_ATTEMPT = 0.5  # seconds for a stream to be opened again, however short the caller's timeout is; it doubles
_MOST_FRUITLESS = 8  # streams in a row that end before they have answered a frame
_LATEST_WINS = api.DELIVERY_POLICY_LATEST_WINS
_GONE = -2  # instead of the last frame that a scene has applied


@dataclass(eq=False)
class _Pending:
    """A frame that was sent and is not answered yet. wire_id: its id on the current stream.

    response: the last one of its answer, which then only has to be handed on.
    """

    frame_id: int
    request: Request
    wire_id: int = 0
    parts: list[Part] = field(default_factory=list)
    limits: list[Part] = field(default_factory=list)
    shortened: list[frame_pb2.ShortenedWays] = field(default_factory=list)
    pairs: list[contact_pb2.MeshPairs] = field(default_factory=list)
    response: api.StreamFramesResponse | None = None


class Stream:
    """Frames in flight, their answers in order, and the transport of the moment.

    After a call that was interrupted nobody knows what the transport has sent and read, so another one is opened; `sent`,
    `received` and a frame's `response` say what is done, and all that follows from them may be done again.
    """

    def __init__(self, scene: Scene, options: StreamOptions, reconnect_seconds: float, take_over: bool) -> None:
        self._scene, self._options, self._reconnect_seconds = scene, options, reconnect_seconds
        self._track = scene.track
        self._transport: Transport | None = None
        self._pending: deque[_Pending] = deque()
        self._has_answered = False  # the current transport
        self._kinds = {"contacts", "limits", "shortened", "pairs", "done", "error"} | (
            {"skipped"} if options.delivery == _LATEST_WINS else set())
        self._unused: set[str] = set()  # options that were warned of
        self._failure: Error | None = None  # why no other one will be opened
        self.ready: deque[Contacts | Error] = deque()
        self.sent = self.received = 0  # the numbers of the last frames that were
        self._process = os.getpid()
        self._guard = Guard(self._settle, self._why_closed)
        self.draining: float | None = None
        self.local_refusal = ""
        self.window = 0
        self.reconnects = 0
        self.recreations = 0
        self.resent = 0
        self._next_move = 0.0  # when leaving a daemon that stops is tried
        self._wait_ends = math.inf  # that for a daemon that is lost
        self._attempt, self._attempt_ends = _FIRST_ATTEMPT, math.inf
        self._fruitless = 0  # streams that were opened since a frame was answered
        if self._open(resume=take_over) != self._track.last_applied:
            self._recreate()

    @property
    def in_flight(self) -> int:
        """Frames that were sent and whose answers were not taken."""
        return self.sent - self.received

    @property
    def is_local(self) -> bool:
        return self._transport is not None and self._transport.is_local

    @property
    def layout(self) -> Layout:
        """Of the scene once all that was sent is answered."""
        for pending in reversed(self._pending):
            if pending.request.edit is not None:
                return pending.request.edit.layout
        return self._track.layout

    @property
    def has_begun(self) -> bool:
        """Whether the scene has positions, or will have."""
        return bool(self._track.state) or any(not pending.request.head.trial for pending in self._pending)

    @property
    def is_foreign(self) -> bool:
        """Whether a fork has copied it from the process that it belongs to."""
        return os.getpid() != self._process

    def check(self) -> None:
        """Before each call of the session: whether it may be, after the last one."""
        if self.is_foreign:
            raise FailedPrecondition("the session belongs to another process, which this one was forked from; make another one")
        self._guard.settle()

    def check_open(self) -> None:
        """Raises why the stream has ended, if it has for good."""
        if self._failure is not None:
            raise self._failure

    @property
    def has_ended(self) -> bool:
        """Returns True once it has ended for good."""
        return self._failure is not None

    def _why_closed(self) -> Error | None:
        return self._failure

    def begin(self, until: float) -> bool:
        """Puts a scene whose meshes all have vertices there. Whether the scene has positions, or will have. Raises
        DeadlineExceeded if the daemon is lost and not found `until` then."""
        while not self.has_begun:
            state = self._track.initial()
            if state is None:
                return False
            with self._guard:
                if not self._begin(state, until):
                    raise DeadlineExceeded("the daemon was not found in time; the frame was not sent")
        return True

    def _begin(self, state: State, until: float) -> bool:
        try:
            if self._transport is None:
                self._reopen(until)
            self._exchange(self._track.beginning(state))
        except Error as error:
            if isinstance(error, NotSent) or error.frame_id:
                raise
            return self._after(error, until)
        return True

    def finish_edits(self) -> None:
        """Waits until the edits in flight are answered: one that is refused leaves another layout to the next one."""
        with self._guard:
            until = self._deadline()
            while any(pending.request.edit is not None for pending in self._pending):
                self._read_by(until, "an edit was not answered")

    def send(self, request: Request, until: float) -> int:
        """Waits for a credit, and sends. Nothing is in flight that was not before if it raises. If the daemon is lost and not
        found `until` then, the frame is in flight and sent later."""
        with self._guard:
            try:
                self._send(request, until)
            except BaseException:
                self._forget_unsent()
                raise
            self.sent += 1
            return self.sent

    def _send(self, request: Request, until: float) -> None:
        if self.draining is not None and self._transport is not None:
            self._leave()
        deadline = self._deadline()
        while self._transport is not None and len(self._pending) >= self.window:
            self._read_by(deadline, f"{self.window} frames are in flight, the whole window, and none was answered")
        pending = _Pending(self.sent + 1, request)
        self._pending.append(pending)
        self._transmit_or_recover(pending, until)

    def _forget_unsent(self) -> None:
        while self._pending and self._pending[-1].frame_id > self.sent:
            self._pending.pop()

    def take(self) -> Contacts | Error:
        """The first answer that is ready."""
        with self._guard:
            answer = self.ready[0]
            self.received = answer.frame_id
            self.ready.popleft()
            return answer

    def read(self, until: float) -> bool:
        """Takes one message; False if none came `until` then."""
        with self._guard:
            return self._read(until)

    def _read(self, until: float) -> bool:
        try:
            if self._transport is None:
                self._reopen(until)
                return True
            response = self._transport.read(None if until == math.inf else _left(until))
            if response is not None:
                self._take(response)
            return response is not None
        except Error as error:
            return self._after(error, until)

    def _deadline(self) -> float:
        """Returns the time at which a wait that begins now ends, if the caller sets no timeout."""
        return min(time.monotonic() + self._scene.client.options.deadline, self._attempt_ends)

    def _read_by(self, until: float, what: str) -> None:
        """As _read. Raises DeadlineExceeded once it is later."""
        if time.monotonic() >= until or not self._read(until):
            raise DeadlineExceeded(f"{what} within {self._scene.client.options.deadline:g} s (deadline)")

    def close(self, reason: Error) -> None:
        """No other transport will be opened."""
        self._failure = reason
        self._close_transport()

    def finish(self) -> None:
        """Waits until the daemon has ended the stream, so that the scene is free for another one, and where the track says; for
        as long as for a call."""
        try:
            if self._guard.was_interrupted:
                self._guard.settle()
                self._open(resume=True)  # in place of the one that was interrupted, whose end nobody would notice
        except Error:
            return
        if self._transport is None:
            return
        self._transport.half_close()
        deadline = self._deadline()
        try:
            while time.monotonic() < deadline and (response := self._transport.read(_left(deadline))) is not None:
                self._take(response)
        except Error:  # the end
            pass

    def first_unanswered(self) -> int:
        """Number of the frame that is waited for."""
        return self._pending[0].frame_id

    def _settle(self) -> None:
        """Puts things where `sent`, `received` and answers say that they are."""
        self._give_up_transport()
        self._forget_unsent()
        if self._pending and self._pending[0].response is not None:
            self._hand_on(self._pending[0], self._pending[0].response)
        while self.ready and self.ready[0].frame_id <= self.received:
            self.ready.popleft()

    # Messages.

    def _transmit_or_recover(self, pending: _Pending, until: float) -> None:
        is_open = self._transport is not None
        try:
            if is_open:
                self._transmit(pending)
            else:
                self._reopen(until)
        except Error as error:
            if is_open and isinstance(error, (NotSent, Unimplemented)):
                raise
            self._after(error, until)

    def _transmit(self, pending: _Pending) -> None:
        assert self._transport is not None
        request = pending.request
        self._scene.client.check_known(request.head, "frame")
        pending.wire_id = self._track.next_id()
        pending.parts.clear()
        pending.limits.clear()
        pending.shortened.clear()
        pending.pairs.clear()
        request.updates, request.way = self._transport.send(pending.wire_id, request.head, request.updates), None
        if pending is self._pending[0]:
            self._track.foresee(request)

    def _take(self, response: api.StreamFramesResponse) -> None:
        kind = response.WhichOneof("response")
        self._has_answered = True
        if kind == "draining":
            self.draining = time.monotonic() + response.draining.deadline_seconds
            return
        if kind is None:
            return  # of a later version
        pending = self._pending[0] if self._pending else None
        if pending is None or response.frame_id != pending.wire_id:
            raise DataLoss(f"the daemon answers frame {response.frame_id}, which is not the next in flight")
        assert self._transport is not None
        if kind not in self._kinds:
            raise DataLoss(f"the daemon answers frame {response.frame_id} with {kind!r}, which is no answer of this stream")
        if kind == "contacts":
            pending.parts.append(read_chunk(response.contacts, self._transport.shared))
            return
        if kind == "limits":
            pending.limits += read_limits([response.limits], pending.request.head.limits, self._transport.shared)
            return
        if kind == "shortened":
            pending.shortened.append(response.shortened)
            return
        if kind == "pairs":
            pending.pairs.append(response.pairs)
            return
        if kind == "done":
            done = response.done
            pending.parts += [read_chunk(chunk, self._transport.shared) for chunk in done.contacts]
            pending.limits += read_limits(done.limits, pending.request.head.limits, self._transport.shared)
            del done.contacts[:], done.limits[:]
        pending.response = response
        self._hand_on(pending, response)

    def _hand_on(self, pending: _Pending, response: api.StreamFramesResponse) -> None:
        """Makes the answer of the first frame in flight ready. May be done again, wherever it was interrupted."""
        answer = self._answer(pending, response)
        if not self.ready or self.ready[-1].frame_id != pending.frame_id:
            self.ready.append(answer)
        self._pending.popleft()
        self._fruitless = 0

    def _answer(self, pending: _Pending, response: api.StreamFramesResponse) -> Contacts | Error:
        kind = response.WhichOneof("response")
        if kind == "done":
            return self._contacts(pending, response.done)
        if kind == "error":
            return error_of_frame(response.error, pending.frame_id)
        done = frame_pb2.FrameDone(earliest_toi=1)
        answer = Answer(pending.frame_id, pending.wire_id, done, self._track.layout, None, False, True)
        return Contacts.of_parts(answer, [])

    def _contacts(self, pending: _Pending, done: frame_pb2.FrameDone) -> Contacts:
        head = pending.request.head
        check_done(done)
        check_total(done, pending.parts)
        self._warn_of_unused(done.metrics.unused_options)
        advance = read_advance(head, done, pending.shortened, self._track.layout_of(pending.request))
        is_told = self._track.tells_pairs(head, self._scene.message.spec)
        pairs = read_pairs(pending.pairs, done, self._track.layout_of(pending.request), is_told)
        way = self._track.apply(pending.request, advance, pending.wire_id)
        answer = Answer(pending.frame_id, pending.wire_id, done, way.layout, way, self._track.has_motion(head), advance=advance,
                        limits=pending.limits, pairs=pairs)
        return Contacts.of_parts(answer, pending.parts)

    def _warn_of_unused(self, options: Iterable[str]) -> None:
        """Once for each option."""
        for option in set(options) - self._unused:
            self._unused.add(option)
            rule = ": it counts in frames with advance=True" if option == "spec.min_separation" else ""
            warn(f"{option.removeprefix('spec.')} is set and had no effect on a frame{rule}")

    def _exchange(self, request: Request) -> int:
        """A frame of the stream's own. Its id on the wire. Raises Error with that if it is refused."""
        assert self._transport is not None
        head = request.head
        self._scene.client.check_known(head, "frame")
        wire_id = self._track.next_id()
        request.updates = self._transport.send(wire_id, head, request.updates)
        deadline = self._deadline()
        while True:
            response = self._read_own(deadline)
            kind = response.WhichOneof("response")
            if kind == "draining":
                self._take(response)
                continue
            if response.frame_id != wire_id or kind not in ("contacts", "pairs", "done", "error"):
                raise DataLoss(f"the daemon answers frame {response.frame_id} with {kind!r} instead of frame {wire_id}")
            if kind == "error":
                raise error_of_frame(response.error, wire_id)
            if kind == "done":
                check_done(response.done)
                if request.is_counted:
                    self._track.apply(request, None, wire_id)
                return wire_id

    def _read_own(self, deadline: float) -> api.StreamFramesResponse:
        """A message of a stream that is being put where it was. Raises DeadlineExceeded."""
        assert self._transport is not None
        response = self._transport.read(_left(deadline)) if time.monotonic() < deadline else None
        if response is None:
            raise DeadlineExceeded(f"the daemon at {self._scene.client.place} did not put the scene where it was in time "
                                   "(deadline, or the call's timeout)")
        return response

    # Losing and finding the daemon.

    def _after(self, error: Error, until: float) -> bool:
        """Goes on after the stream has ended, or raises why it cannot. False if it has not `until` then."""
        self._give_up_transport()
        if isinstance(error, DeadlineExceeded) and time.monotonic() >= until:
            return False
        has_idled = isinstance(error, ResourceExhausted) and self._has_answered and not isinstance(error, NotSent)
        if not (error.is_connection_lost or has_idled):
            if not isinstance(error, DeadlineExceeded):  # of a call, which may be made again
                self._failure = error
            raise error
        if self._fruitless >= _MOST_FRUITLESS:
            self._fruitless, self._wait_ends = 0, math.inf
            raise error
        if self._wait_ends == math.inf:
            self._wait_ends = time.monotonic() + self._reconnect_seconds
        pause = _FIRST_PAUSE
        if self._fruitless:
            pause = min(_FIRST_PAUSE * 2**self._fruitless, _LONGEST_PAUSE)
            time.sleep(min(pause, _left(min(until, self._wait_ends))))
        while (left := _left(min(until, self._wait_ends))) > 0:
            try:
                self._reopen(min(until, self._wait_ends))
                return True
            except Error as again:
                self._close_transport()
                if isinstance(again, DeadlineExceeded) and time.monotonic() >= until:
                    return False
                if not again.is_connection_lost:
                    raise
                error = again
            time.sleep(min(pause, left))
            pause = min(2 * pause, _LONGEST_PAUSE)
        if until < self._wait_ends:
            return False
        self._wait_ends = math.inf
        raise error

    def _reopen(self, until: float) -> None:
        """A stream on which everything that is in flight was sent again. Raises Error. Once a daemon answers, which is waited for
        `until` then, the rest may take longer by an attempt's time, which grows, so that callers who wait for shorter times
        get there as well."""
        self.check_open()
        self._scene.client.reconnect()
        self._scene.client.connect(_left(until))  # if nobody answers, nobody is asked more
        self._attempt_ends = max(until, time.monotonic() + self._attempt)
        try:
            self._reopen_in_time()
        except DeadlineExceeded:
            self._attempt = min(2 * self._attempt, self._scene.client.options.deadline)
            raise
        finally:
            self._attempt_ends = math.inf
        self._attempt, self._wait_ends = _FIRST_ATTEMPT, math.inf

    def _reopen_in_time(self) -> None:
        last_applied = self._resume()
        if last_applied != self._track.last_applied or self._begins_on_last_way():
            self._recreate()
        self.reconnects += 1
        self._fruitless += 1
        self.draining = None
        self._transmit_all()

    def _begins_on_last_way(self) -> bool:
        """Whether what is in flight does: a frame that was given up with its stream leaves the scene where it was, but may leave
        it without the way that led there."""
        return bool(self._pending) and self._pending[0].request.head.HasField("from_last_fraction")

    def _resume(self) -> int:
        """The last frame that the scene has applied; _GONE: the scene is."""
        # A call tells at once that the scene is gone; opening a stream would wait for an endpoint that is gone.
        if self._scene.message.endpoint and not self._scene.client.has_scene(self._scene.id):
            return _GONE
        try:
            return self._open(resume=True)
        except NotFound:
            return _GONE
        except Error as error:
            # The scene's endpoint may be gone, and proxies may not pass on why a stream was refused: a call is told.
            if not error.is_connection_lost or self._scene.client.has_scene(self._scene.id):
                raise
            return _GONE

    def _leave(self) -> None:
        """From a daemon that stops to another one, with nothing in flight. Where there is none, frames are answered until the
        daemon closes the stream, and this is tried again."""
        if time.monotonic() < self._next_move:
            return
        self._next_move = time.monotonic() + _LONGEST_PAUSE
        until = self._deadline()
        while self._pending and self._transport is not None:
            self._read_by(until, "the frames in flight were not answered")
        if self.draining is None or self._transport is None:  # it has been lost meanwhile
            return
        try:
            self._scene.move()
        except Error:
            return
        try:
            self._close_transport()
            self._restore()
            self.draining = None
        except Error as error:
            self._after(error, math.inf)

    def _transmit_all(self) -> None:
        """As many at a time as the window has, which may be another one than before."""
        waiting = list(self._pending)
        self.resent += sum(pending.wire_id > 0 for pending in waiting)
        for sent, pending in enumerate(waiting):
            deadline = self._deadline()
            while sent - (len(waiting) - len(self._pending)) >= self.window:
                self._take(self._read_own(deadline))
            self._transmit(pending)

    def _recreate(self) -> None:
        """A new scene where the old one was: it is gone, or has applied frames whose answers were lost."""
        self._close_transport()
        self._scene.create_again()
        self._restore()

    def _restore(self) -> None:
        """Opens the new scene, and puts it where the old one was."""
        self._track.last_applied = NOWHERE  # unless this comes to its end
        try:
            self._open(resume=False)
        except NotFound as error:  # it was created a moment ago: a proxy asked another daemon, or its own has ended since
            raise Unavailable(error.message) from None
        last_applied = 0
        for request in self._track.replaying() if self._track.state else ():
            wire_id = self._exchange(request)
            last_applied = last_applied if request.head.trial else wire_id
        self._track.last_applied = last_applied
        self.recreations += 1

    def _open(self, resume: bool) -> int:
        """Opens a stream. Returns the last frame that the scene has applied, by its id on the wire."""
        self._transport, opened, self.local_refusal = open_transport(
            self._scene.client, self._scene.message, self._options, resume, _left(self._deadline()))
        self.window = opened.window
        self._has_answered = False
        self._track.last_sent = max(self._track.last_sent, opened.scene.last_frame_id)
        return opened.scene.last_frame_id

    def _give_up_transport(self) -> None:
        """Whatever it has not answered."""
        self._close_transport()
        if self._options.transport == "calls":  # one may be under way, after which the scene is elsewhere
            self._track.last_applied = NOWHERE

    def _close_transport(self) -> None:
        if self._transport is not None:
            self._transport.close()
            self._transport = None


def _left(until: float) -> float:
    """Seconds until then."""
    return max(0.0, until - time.monotonic())
