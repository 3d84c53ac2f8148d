"""Messages of a gRPC stream, one at a time, with a timeout."""

from __future__ import annotations

import concurrent.futures
from typing import Any

import grpc

from collided.errors import Unavailable, error_of_call


class Messages:
    """gRPC has no timeout for one message of a stream: where one is asked for, a thread waits, and goes on waiting."""

    def __init__(self, call: Any) -> None:
        self._call = call
        self._reader = concurrent.futures.ThreadPoolExecutor(1, "collided-reader")
        self._pending: concurrent.futures.Future[Any] | None = None

    def next(self, timeout: float | None) -> Any:
        """The next message; None if none came in time. Raises Error at the end."""
        if self._pending is None and timeout is None:
            return self._next()
        if self._pending is None:
            self._pending = self._reader.submit(self._next)
        done, _ = concurrent.futures.wait([self._pending], timeout)
        if not done:
            return None
        pending, self._pending = self._pending, None
        return pending.result()

    def _next(self) -> Any:
        try:
            return next(self._call)
        except StopIteration:
            raise Unavailable("the stream has ended") from None
        except grpc.RpcError as error:
            raise error_of_call(error) from None

    def cancel(self) -> None:
        """Ends the call; whoever waits for a message is told."""
        self._call.cancel()
        self._reader.shutdown(wait=False)
