"""The same for asyncio: `async with collided.aio.Session(meshes) as session: contacts = await session.step(V)`.

Each object has a thread of its own that waits for the daemon, so that the event loop never does; numpy and sockets
release the interpreter's lock. Arguments, answers and errors are those of the package. A call that is cancelled loses
nothing: a frame that was sent stays in flight, and the next `receive` has its contacts.
"""

from __future__ import annotations

import asyncio
import concurrent.futures
import functools
from collections import deque
from collections.abc import AsyncIterable, AsyncIterator, Callable, Iterable
from typing import Any, TypeVar, Unpack

import numpy as np

import collided
from collided.contacts import Contacts
from collided.frames.options import FrameOptions
from collided.watch import Watched

_T = TypeVar("_T")


async def detect(*arguments: Any, **options: Any) -> Contacts:
    """As `collided.detect`."""
    return await asyncio.to_thread(collided.detect, *arguments, **options)


async def proximity(*arguments: Any, **options: Any) -> Contacts:
    """As `collided.proximity`."""
    return await asyncio.to_thread(collided.proximity, *arguments, **options)


class _Thread:
    """Does one thing after the other."""

    def __init__(self) -> None:
        self._pool = concurrent.futures.ThreadPoolExecutor(1, "collided-aio")

    def start(self, function: Callable[..., _T], *arguments: Any, **options: Any) -> asyncio.Future[_T]:
        return asyncio.get_running_loop().run_in_executor(self._pool, functools.partial(function, *arguments, **options))

    def stop(self) -> None:
        self._pool.shutdown(wait=False)


class Session:
    """As `collided.Session`; made on entry."""

    def __init__(self, meshes: Any, **options: Any) -> None:
        self._make = functools.partial(collided.Session, meshes, **options)
        self._thread = _Thread()
        self._late: deque[asyncio.Future[Contacts]] = deque()  # receives that were cancelled
        self._session: collided.Session | None = None

    async def __aenter__(self) -> Session:
        self._session = await self._thread.start(self._make)
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
        waiting = self._late.popleft() if self._late else self._thread.start(self.sync.receive)
        try:
            return await asyncio.shield(waiting)
        except asyncio.CancelledError:
            self._late.appendleft(waiting)
            raise

    async def step(self, positions: Any = None, start: Any = None, **options: Unpack[FrameOptions]) -> Contacts:
        """As `collided.Session.step`."""
        if self._late or self.sync.in_flight:
            raise collided.FailedPrecondition("step() with frames in flight: receive them first")
        await self.send(positions, start, **options)
        return await self.receive()

    async def run(self, frames: Iterable[Any] | AsyncIterable[Any],
                  **options: Unpack[FrameOptions]) -> AsyncIterator[Contacts]:
        """As `collided.Session.run`; frames may be made asynchronously."""
        async for positions in _each(frames):
            while self.sync.in_flight >= self.sync.window:
                yield await self.receive()
            await self.send(positions, **options)
        while self.sync.in_flight or self._late:
            yield await self.receive()

    @property
    def positions(self) -> dict[str, np.ndarray]:
        """Where each mesh is after the last answered frame, as of `collided.Session`."""
        return self.sync.positions

    async def close(self) -> None:
        """As `collided.Session.close`, whatever the session waits for."""
        for future in self._late:  # nobody will ask for these any more
            future.add_done_callback(lambda done: done.cancelled() or done.exception())
        try:
            if self._session is not None:
                await asyncio.to_thread(self._session.close)
        finally:
            self._thread.stop()


class Watcher:
    """As `collided.Watcher`: `async for frame in watcher`."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        self._make = functools.partial(collided.Watcher, *arguments, **options)
        self._thread = _Thread()
        self._watcher: collided.Watcher | None = None

    async def __aenter__(self) -> Watcher:
        self._watcher = await self._thread.start(self._make)
        return self

    async def __aexit__(self, *_: object) -> None:
        if self._watcher is not None:
            await asyncio.to_thread(self._watcher.close)
        self._thread.stop()

    async def __aiter__(self) -> AsyncIterator[Watched]:
        assert self._watcher is not None, "the watcher is not open: use `async with`"
        frames = iter(self._watcher)
        while True:
            frame: Watched | None = await self._thread.start(lambda: next(frames, None))
            if frame is None:
                return
            yield frame


async def _each(frames: Iterable[Any] | AsyncIterable[Any]) -> AsyncIterator[Any]:
    if isinstance(frames, AsyncIterable):
        async for frame in frames:
            yield frame
    else:
        for frame in frames:
            yield frame
