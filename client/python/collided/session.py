"""A stream of frames that survives its connection and its daemon."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Iterable, Iterator
from functools import partial
from typing import Any, Unpack

import numpy as np

from collided import leftovers
from collided.choices import check_flag, choice
from collided.contacts.contacts import Contacts
from collided.errors import DeadlineExceeded, Error, FailedPrecondition, InvalidArgument
from collided.frames.options import FrameOptions
from collided.leftovers import Leftover
from collided.options import check_seconds
from collided.scene import Scene
from collided.stream import Stream
from collided.transport.opening import StreamOptions
from collided.v1 import collision_service_pb2 as api


class Session:
    """Frames in, contacts out, in order; a context manager. For one thread at a time.

    meshes: a Scene, which stays; or what Scene takes, with its options: then the scene is the session's own.
    window: frames in flight, 1 to the daemon's limit; 0: the daemon chooses (2).
    delivery: "lossless", or "latest_wins" (with a window above 2): waiting frames give way to newer ones.
    transport: "auto": shared memory if the daemon is on this host and offers it, else gRPC; "shared_memory"; "grpc";
        "calls": a call for each frame, and no stream.
    output_bytes: room in shared memory for each frame's contacts; the rest comes over the socket, which is slower.
    edit_bytes: room for each frame's edit and for positions of what edits have added.
    daemon_user: another user id that the daemon may run as, to be trusted with a token over its local socket.
    take_over: from another stream of the Scene that may still be open, and then ends with Aborted.
    reconnect_seconds: how long a lost connection or daemon is waited for; 0: the loss is raised at once.

    A connection or a daemon that is lost is not noticed but in `reconnects` and `recreations`: the session connects again,
    has the scene created again if it is gone, brings it to where it was, and sends what was not answered. Answers are the
    same to the bit. If that fails, Unavailable is raised, and the next call tries again: no frame is lost.

    Exceptions of a refused frame come from `receive`, `step` or `run` in its turn; the session goes on.

    An interrupt, such as KeyboardInterrupt, leaves the session usable: a frame is in flight if it was interrupted in `receive`,
    or in `step` once it was sent, and is not if it was before; `in_flight` tells. The next call connects again.

    The session is of the process that made it: in one that is forked from it, calls raise FailedPrecondition, and `close` does
    nothing.
    """

    def __init__(self, meshes: Any, *, window: int = 0, delivery: str = "lossless", transport: str = "auto",
                 output_bytes: int = 8 << 20, edit_bytes: int = 0, daemon_user: int | None = None,
                 take_over: bool = False, reconnect_seconds: float = 60.0, **scene_options: Any) -> None:
        check_seconds(reconnect_seconds, "reconnect_seconds")
        check_flag(take_over, "take_over")
        if isinstance(meshes, Scene) and scene_options:
            raise InvalidArgument(f"{min(scene_options)} is given with a Scene, which has its own",
                                  field=min(scene_options))
        policy = choice(api.DeliveryPolicy, "DELIVERY_POLICY_", delivery, "delivery")
        stream_options = StreamOptions(window=window, delivery=policy, transport=transport, output_bytes=output_bytes,
                                       edit_bytes=edit_bytes, daemon_user=daemon_user)
        self._owns_scene = not isinstance(meshes, Scene)
        self.scene = meshes if isinstance(meshes, Scene) else Scene(meshes, **scene_options)
        try:
            self._stream = Stream(self.scene, stream_options, reconnect_seconds, take_over)
        except BaseException as error:
            if self._owns_scene:
                self.scene.give_up(error)
            raise
        ends = [partial(self._stream.close, FailedPrecondition("the session is closed"))]
        self.leftover = leftovers.watch(self, self.scene.left_by("Session", ends) if self._owns_scene else
                                        Leftover("Session", ends, name=self.scene.name))

    # Frames.

    def step(self, positions: Any = None, start: Any = None, *, timeout: float | None = None,
             **options: Unpack[FrameOptions]) -> Contacts:
        """Sends a frame and waits for its contacts, with nothing else in flight.

        positions: of the mesh that can move, or a mapping of meshes, by name or index, to positions (n, 3), `Sparse` or
            `Rigid`. Meshes that are not named stand still.
        start: likewise, where meshes are at t = 0 (CCD); None: where the last frame left them.
        timeout: seconds after which DeadlineExceeded is raised; the frame stays in flight, for `receive`, unless `in_flight` is
            0: where a daemon was lost before its first frame. What a scene takes to be put where it was, or where it begins,
            once a daemon answers, comes on top.
        options: those of FrameOptions.

        Raises InvalidArgument before anything is sent for shapes, dtypes and meshes that cannot be, and what the daemon
        refuses the frame with: it leaves the scene unchanged.
        """
        until = _end_of(timeout)
        self._stream.check()
        self._stream.check_open()
        if self.in_flight:
            raise FailedPrecondition(f"step() with {self.in_flight} frames in flight: receive them first")
        self._send(positions, start, options, until)
        return self._receive(timeout, until)

    def send(self, positions: Any = None, start: Any = None, **options: Unpack[FrameOptions]) -> int:
        """Sends a frame, and waits for that while a whole window is in flight. Returns the frame's number, from 1: its
        contacts' `frame_id`, not the `wire_id` that watchers see.

        Arguments as of `step`. Arrays may be changed once this returns. If it is interrupted, the frame is not in flight.
        """
        self._stream.check()
        self._stream.check_open()
        return self._send(positions, start, options, math.inf)

    def _send(self, positions: Any, start: Any, options: FrameOptions, until: float) -> int:
        is_first = not self._stream.begin(until)
        if options.get("edit") is not None:
            self._stream.finish_edits()
        request = self.scene.track.request(self._stream.layout, is_first, positions, start, options)
        return self._stream.send(request, until)

    def receive(self, timeout: float | None = None) -> Contacts:
        """The next frame's contacts, in the order in which frames were sent. Raises what the daemon refused it with.

        timeout: seconds to wait, as of `step`; DeadlineExceeded if nothing came, and nothing is lost. FailedPrecondition if no
        frame is in flight.
        """
        until = _end_of(timeout)
        self._stream.check()
        if not self.in_flight:
            raise FailedPrecondition("receive() with no frame in flight")
        return self._receive(timeout, until)

    def _receive(self, timeout: float | None, until: float) -> Contacts:
        while not self._stream.ready:
            if not self._stream.read(until) or (time.monotonic() > until and not self._stream.ready):
                frame = self._stream.first_unanswered()
                raise DeadlineExceeded(f"frame {frame} was not answered within {timeout} s; it is still in flight")
        answer = self._stream.take()
        if isinstance(answer, Error):
            raise answer
        return answer

    def run(self, frames: Iterable[Any], **options: Unpack[FrameOptions]) -> Iterator[Contacts]:
        """Contacts of each frame's positions, in order, with a whole window in flight."""
        source, end = iter(frames), object()
        while True:
            while self.in_flight >= self.window:  # before a frame is taken, which an error would lose
                yield self.receive()
            positions = next(source, end)
            if positions is end:
                break
            self.send(positions, **options)
        while self.in_flight:
            yield self.receive()

    # Where the scene is.

    @property
    def positions(self) -> dict[str, np.ndarray]:
        """Where each mesh is after the last answered frame: the daemon's bits, (n, 3), in the scene's format, read-only.

        Before the first one: where the meshes' vertices are; empty if a mesh has none, as then nothing is anywhere yet.
        """
        track = self.scene.track
        state = track.state or track.initial() or {}
        return {mesh.name: _read_only(state[i].real(track.form)) for i, mesh in track.layout.present() if i in state}

    @property
    def in_flight(self) -> int:
        """Frames that were sent and not received."""
        return self._stream.in_flight

    @property
    def window(self) -> int:
        """How many frames may be in flight."""
        return self._stream.window

    @property
    def reconnects(self) -> int:
        """How often the connection was lost and found again."""
        return self._stream.reconnects

    @property
    def recreations(self) -> int:
        """How often the scene had to be created again."""
        return self._stream.recreations

    @property
    def resent(self) -> int:
        """How many frames were sent again, because a loss left them without an answer."""
        return self._stream.resent

    @property
    def is_local(self) -> bool:
        """Whether positions and contacts go through shared memory; if not, `local_refusal` may say why."""
        return self._stream.is_local

    @property
    def local_refusal(self) -> str:
        """Why they do not, although the daemon is on this host and offers it, for people; else empty."""
        return self._stream.local_refusal

    @property
    def draining_seconds(self) -> float | None:
        """Seconds until a daemon that is stopping closes the stream; None unless it is stopping."""
        end = self._stream.draining
        return None if end is None else max(0.0, end - time.monotonic())

    # The end.

    def close(self) -> None:
        """Ends the stream, and deletes the scene if it is the session's own. Answers in flight are given up."""
        if self._stream.is_foreign:
            return
        self.leftover.take()
        if not self._owns_scene:
            self._stream.finish()
        self.leftover.end_streams()
        if self._owns_scene:
            self.scene.close()

    def __repr__(self) -> str:
        if self._stream.has_ended:
            return f"<Session of {self.scene.name}: closed>"
        way = "shared memory" if self.is_local else "gRPC"
        return f"<Session of {self.scene.name}: {way}, {self.in_flight} of {self.window} frames in flight>"

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _end_of(timeout: float | None) -> float:
    """When it ends, by time.monotonic(). Raises InvalidArgument."""
    if timeout is None:
        return math.inf
    check_seconds(timeout, "timeout")
    return math.inf if timeout > threading.TIMEOUT_MAX else time.monotonic() + float(timeout)


def _read_only(array: np.ndarray) -> np.ndarray:
    view = array.view()
    view.flags.writeable = False
    return view
