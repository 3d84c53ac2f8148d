"""Closes what callers forget to close: once nothing refers to it any more, and when the process ends.

A finalizer may run in any thread, between any two instructions, so it must neither wait nor take a lock. It queues the work
for a thread of this module and warns. When the process ends, that thread has a fifth of a second for everything that is
still open: a daemon that does not answer in time ends the scene when its lease ends.
"""

from __future__ import annotations

import atexit
import contextlib
import os
import queue
import sys
import threading
import warnings
import weakref
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, Protocol

EXIT_SECONDS = 0.2  # that the end of the process waits for daemons
CLOSE_SECONDS = 2.0  # that closing a connection is waited for; gRPC does not ask the daemon for that
CALL_SECONDS = 5.0  # after which a daemon that does not answer is given up


class Resident(Protocol):
    """A scene on a daemon."""

    @property
    def name(self) -> str: ...

    def ask_to_delete(self) -> Any:
        """Asks the daemon to delete it, without waiting. Returns the answer, a grpc.Future; None if no daemon could be asked."""

    def disconnect(self) -> None:
        """Ends the connection, unless it is the caller's."""


class Leftover:
    """The streams and the scene that an object has open. It must not refer to that object, or nothing would ever be collected.

    kind: the object's class, for the warning. streams: functions that end streams without waiting. resident: the scene to
        delete; None if it is the caller's. name: the scene's, if there is no resident.
    """

    def __init__(self, kind: str, streams: Sequence[Callable[[], object]], resident: Resident | None = None,
                 name: str = "") -> None:
        self.kind, self.streams, self.resident = kind, list(streams), resident
        self._name = name
        self._process = os.getpid()
        self._is_over = False
        self.finalizer: weakref.finalize | None = None

    def take(self) -> bool:
        """Returns True to the first caller, who then closes it; False in a process that was forked from its own."""
        if self._is_over or os.getpid() != self._process:
            return False
        self._is_over = True
        _open.discard(self)
        if self.finalizer is not None:
            self.finalizer.detach()  # Python ignores an interrupt that comes while a finalizer runs
        return True

    @property
    def is_over(self) -> bool:
        """Returns True once somebody has taken it."""
        return self._is_over

    def end_streams(self) -> None:
        for end in self.streams:
            end()

    def warn(self) -> None:
        name = self._name if self.resident is None else self.resident.name
        said = f"unclosed {self.kind} of {name}; use 'with' or close()"
        warnings.warn(said, ResourceWarning, stacklevel=4)  # the line that let it go


class _Closer:
    """A thread that ends what was queued. It sends the calls of all that is queued before it waits for any answer."""

    def __init__(self) -> None:
        self._jobs: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()  # its put() may interrupt itself
        self._unanswered: set[Leftover] = set()
        self._waiting: list[threading.Event] = []
        self.queued: set[Leftover] = set()
        # A daemon thread, so that a process can end while it waits.
        self._thread = threading.Thread(target=self._serve, name="collided-closer", daemon=True)
        self._thread.start()

    def end(self, leftover: Leftover) -> None:
        self.queued.add(leftover)
        self._jobs.put(partial(self._end, leftover))

    def do(self, job: Callable[[], None]) -> None:
        self._jobs.put(job)

    def do_and_wait(self, job: Callable[[], None], seconds: float) -> None:
        """Does it in the closer's thread, and waits for that, but no longer than so many seconds."""
        if threading.current_thread() is self._thread:
            job()
            return
        # An interrupt may leave the lock of an Event taken, but not that of a SimpleQueue.
        done: queue.SimpleQueue[None] = queue.SimpleQueue()

        def do() -> None:
            try:
                job()
            finally:
                done.put(None)

        self._jobs.put(do)
        with contextlib.suppress(queue.Empty):
            done.get(timeout=seconds)

    def wait(self, seconds: float) -> bool:
        """Waits until all that was queued has ended. False if it takes longer, and in the closer's own thread."""
        if threading.current_thread() is self._thread:
            return False
        ended = threading.Event()
        self._jobs.put(partial(self._waiting.append, ended))
        return ended.wait(seconds)

    def _serve(self) -> None:
        while True:
            with contextlib.suppress(Exception):  # of a connection that is gone
                self._jobs.get()()
            if not self._unanswered:
                for ended in self._waiting:
                    ended.set()
                self._waiting.clear()

    def _end(self, leftover: Leftover) -> None:
        with contextlib.suppress(Exception):  # the scene is deleted all the same
            leftover.end_streams()
        answer = None if leftover.resident is None else leftover.resident.ask_to_delete()
        if answer is None:
            self._finish(leftover)
        else:
            self._unanswered.add(leftover)
            answer.add_done_callback(lambda _: self._jobs.put(partial(self._finish, leftover)))

    def _finish(self, leftover: Leftover) -> None:
        self._unanswered.discard(leftover)
        self.queued.discard(leftover)
        if leftover.resident is not None:
            leftover.resident.disconnect()


_open: set[Leftover] = set()
_last: dict[Callable[[], None], None] = {}  # what the process does at its end, once all is closed
_closer: _Closer | None = None
_start_lock = threading.Lock()


def watch(owner: object, leftover: Leftover) -> Leftover:
    """Closes `leftover` once `owner` is collected, or when the process ends, unless it was taken by then."""
    _started()
    _open.add(leftover)
    leftover.finalizer = weakref.finalize(owner, _forgotten, leftover)
    leftover.finalizer.atexit = False  # _at_exit() does it, within its time
    return leftover


def when_collected(owner: object, close: Callable[[], None]) -> weakref.finalize:
    """Calls `close`, which does not wait, in the closer's thread once `owner` is collected; not when the process ends."""
    closer = _started()
    finalizer = weakref.finalize(owner, closer.do, close)
    finalizer.atexit = False
    return finalizer


def abandon(leftover: Leftover) -> None:
    """Closes it now, without waiting, and without a warning: the caller never had it."""
    if leftover.take():
        _started().end(leftover)


def settle(seconds: float = CALL_SECONDS) -> bool:
    """Waits for scenes of forgotten objects that are still being deleted. Whether there were any, and all are gone."""
    return _closer is not None and bool(_closer.queued) and _closer.wait(seconds)


def do_elsewhere(job: Callable[[], None]) -> None:
    """Closes something of gRPC's in the closer's thread, where no interrupt comes. Waits for that, but not for ever."""
    _started().do_and_wait(job, CLOSE_SECONDS)


def after_all(end: Callable[[], None]) -> None:
    """Calls `end` when the process ends, once everything has been closed."""
    _started()
    _last[end] = None


def _forgotten(leftover: Leftover) -> None:
    if leftover.take():
        _started().end(leftover)
        leftover.warn()


def _started() -> _Closer:
    """Returns the closer. Whoever registers a finalizer starts it, since starting a thread takes a lock."""
    global _closer
    if _closer is None:
        with _start_lock:
            if _closer is None:
                _closer = _Closer()
                _register_at_exit()
    return _closer


def _register_at_exit() -> None:
    atexit.register(_at_exit)
    processes = sys.modules.get("multiprocessing.process")
    if processes is not None and processes.parent_process() is not None:  # it ends with os._exit(), after these finalizers
        from multiprocessing import util

        util.Finalize(None, _at_exit, exitpriority=0)


def _at_exit() -> None:
    forgotten = [leftover for leftover in _open.copy() if leftover.take()]
    if _closer is None:
        return
    for leftover in forgotten:
        _closer.end(leftover)
    settle(EXIT_SECONDS)
    for end in _last:
        end()
    for leftover in forgotten:
        try:
            leftover.warn()
        except ResourceWarning:  # where warnings are errors
            sys.excepthook(*sys.exc_info())


def _in_forked_process() -> None:
    """Forgets everything: open objects belong to the parent process, and fork() does not copy the thread."""
    global _closer, _start_lock
    _closer, _start_lock = None, threading.Lock()
    _open.clear()
    _last.clear()


if sys.platform != "win32":  # where no process forks
    os.register_at_fork(after_in_child=_in_forked_process)
