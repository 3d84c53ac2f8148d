"""The same for asyncio: `async with collided.aio.Session(meshes) as session: contacts = await session.step(V)`.

Each object has a thread of its own that waits for the daemon, so that the event loop never does; numpy and sockets
release the interpreter's lock. Arguments, answers and errors are those of the package. A call that is cancelled loses
nothing: a frame that was sent stays in flight, and the next `receive` has its contacts.
"""

from __future__ import annotations

import asyncio
import concurrent.futures
import functools
import queue
import threading
from collections.abc import AsyncIterable, AsyncIterator, Callable, Iterable
from typing import Any, Generic, TypeVar, Unpack

import numpy as np

import collided
from collided import leftovers
from collided.callers import from_here
from collided.contacts import Contacts
from collided.frames.options import FrameOptions
from collided.watch import Watched

_T = TypeVar("_T")


async def detect(*arguments: Any, **options: Any) -> Contacts:
    """As `collided.detect`."""
    return await asyncio.to_thread(from_here(collided.detect, *arguments, **options))


async def proximity(*arguments: Any, **options: Any) -> Contacts:
    """As `collided.proximity`."""
    return await asyncio.to_thread(from_here(collided.proximity, *arguments, **options))


class _Thread:
    """Does one thing after the other, in a daemon thread: a process can end while it waits, as with no thread of a pool."""

    def __init__(self) -> None:
        self._jobs: queue.SimpleQueue[tuple[concurrent.futures.Future[Any], Callable[[], Any]] | None] = queue.SimpleQueue()
        self._is_started = self._is_stopped = False

    def start(self, function: Callable[..., _T], *arguments: Any, **options: Any) -> asyncio.Future[_T]:
        return asyncio.wrap_future(self._submit(from_here(function, *arguments, **options)))

    def _submit(self, function: Callable[[], _T]) -> concurrent.futures.Future[_T]:
        if self._is_stopped:
            raise collided.FailedPrecondition("it is closed")
        if not self._is_started:
            self._is_started = True
            threading.Thread(target=_work, args=(self._jobs,), name="collided-aio", daemon=True).start()
        future: concurrent.futures.Future[_T] = concurrent.futures.Future()
        self._jobs.put((future, function))
        return future

    async def make(self, function: Callable[[], _T]) -> _T:
        """What the function makes, which is closed if nobody waits for it any more."""
        making = self._submit(function)
        try:
            return await asyncio.shield(asyncio.wrap_future(making))
        except asyncio.CancelledError:
            making.add_done_callback(_close_what_was_made)
            raise

    def stop(self) -> None:
        self._is_stopped = True
        self._jobs.put(None)


def _work(jobs: queue.SimpleQueue[tuple[concurrent.futures.Future[Any], Callable[[], Any]] | None]) -> None:
    while (job := jobs.get()) is not None:
        future, function = job
        if future.set_running_or_notify_cancel():
            try:
                future.set_result(function())
            except BaseException as error:
                future.set_exception(error)
        del job, future, function  # which may refer to what is collected meanwhile


def _close_what_was_made(making: concurrent.futures.Future[Any]) -> None:
    if making.exception() is None:
        making.result().close()


class _Results(Generic[_T]):
    """Results of one function, in order. One whose caller was cancelled is the next caller's."""

    def __init__(self, thread: _Thread) -> None:
        self._thread = thread
        self._is_awaited: dict[asyncio.Future[_T], bool] = {}  # those that nobody has yet, in order

    @property
    def has_late(self) -> bool:
        """Whether there is one whose caller was cancelled."""
        return not all(self._is_awaited.values())

    async def next(self, function: Callable[[], _T]) -> _T:
        late = (result for result, is_awaited in self._is_awaited.items() if not is_awaited)
        result = next(late, None)
        if result is None:
            result = self._thread.start(function)
            result.add_done_callback(lambda done: done.cancelled() or done.exception())  # nobody may ask for it any more
        self._is_awaited[result] = True
        try:
            return await asyncio.shield(result)
        except asyncio.CancelledError:
            self._is_awaited[result] = False
            raise
        finally:
            if self._is_awaited[result]:
                del self._is_awaited[result]


class Session:
    """As `collided.Session`; made on entry."""

    def __init__(self, meshes: Any, **options: Any) -> None:
        self._make = functools.partial(collided.Session, meshes, **options)
        self._thread = _Thread()
        self._received: _Results[Contacts] = _Results(self._thread)
        self._session: collided.Session | None = None

    async def __aenter__(self) -> Session:
        self._session = await self._thread.make(self._make)
        self._session.leftover.kind = "aio.Session"
        self._session.leftover.streams.append(self._thread.stop)
        leftovers.watch(self, self._session.leftover)
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()

    @property
    def sync(self) -> collided.Session:
        """The session itself, for what needs no waiting: counters, positions, its scene."""
        assert self._session is not None, "the session is not open: use `async with`"
        return self._session

    async def send(self, positions: Any = None, start: Any = None, **options: Unpack[FrameOptions]) -> int:
        """As `collided.Session.send`. Once called it is done, even if it is cancelled."""
        return await asyncio.shield(self._thread.start(self.sync.send, positions, start, **options))

    async def receive(self) -> Contacts:
        """As `collided.Session.receive`; use `asyncio.timeout`."""
        return await self._received.next(self.sync.receive)

    async def step(self, positions: Any = None, start: Any = None, **options: Unpack[FrameOptions]) -> Contacts:
        """As `collided.Session.step`."""
        if self._received.has_late or self.sync.in_flight:
            raise collided.FailedPrecondition("step() with frames in flight: receive them first")
        await self.send(positions, start, **options)
        return await self.receive()

    async def run(self, frames: Iterable[Any] | AsyncIterable[Any],
                  **options: Unpack[FrameOptions]) -> AsyncIterator[Contacts]:
        """As `collided.Session.run`; frames may be made asynchronously."""
        source, end = _each(frames), object()
        while True:
            while self.sync.in_flight >= self.sync.window:  # before a frame is taken, which an error would lose
                yield await self.receive()
            positions = await anext(source, end)
            if positions is end:
                break
            await self.send(positions, **options)
        while self.sync.in_flight or self._received.has_late:
            yield await self.receive()

    @property
    def positions(self) -> dict[str, np.ndarray]:
        """Where each mesh is after the last answered frame, as of `collided.Session`."""
        return self.sync.positions

    def __repr__(self) -> str:
        return f"<aio {repr(self._session)[1:-1] if self._session else 'Session, not open'}>"

    async def close(self) -> None:
        """As `collided.Session.close`, whatever the session waits for."""
        try:
            if self._session is not None:
                await asyncio.to_thread(self._session.close)
        finally:
            self._thread.stop()


class Watcher:
    """As `collided.Watcher`: `async for frame in watcher`. An `anext` that is cancelled loses no frame."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        self._make = functools.partial(collided.Watcher, *arguments, **options)
        self._thread = _Thread()
        self._watcher: collided.Watcher | None = None
        self._shown: _Results[Watched | None] = _Results(self._thread)

    async def __aenter__(self) -> Watcher:
        self._watcher = await self._thread.make(self._make)
        self._watcher.leftover.kind = "aio.Watcher"
        self._watcher.leftover.streams.append(self._thread.stop)
        leftovers.watch(self, self._watcher.leftover)
        return self

    async def __aexit__(self, *_: object) -> None:
        if self._watcher is not None:
            await asyncio.to_thread(self._watcher.close)
        self._thread.stop()

    def __aiter__(self) -> Watcher:
        return self

    async def __anext__(self) -> Watched:
        assert self._watcher is not None, "the watcher is not open: use `async with`"
        frame = await self._shown.next(functools.partial(_next, self._watcher))
        if frame is None:
            raise StopAsyncIteration
        return frame


def _next(watcher: collided.Watcher) -> Watched | None:
    """None at the end."""
    return next(iter(watcher), None)


async def _each(frames: Iterable[Any] | AsyncIterable[Any]) -> AsyncIterator[Any]:
    if isinstance(frames, AsyncIterable):
        async for frame in frames:
            yield frame
    else:
        for frame in frames:
            yield frame
