"""Messages of a gRPC stream, one at a time, with a timeout."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from typing import Any

import grpc

from collided.connection.channel import end_elsewhere
from collided.errors import Cancelled, Error, Unavailable, error_of_call


class Messages:
    """A thread begins the call and reads, a message for each request, because gRPC has no timeout for one message.

    No call of gRPC's is made in the caller's thread. An interrupt that comes while gRPC takes one of its locks, by functions
    in Python, leaves that lock taken for good.
    """

    def __init__(self, channel: grpc.Channel, begin: Callable[[], Any]) -> None:
        """begin: makes the call on `channel`, which `close` closes, too."""
        self._channel, self._begin = channel, begin
        self._call: Any = None
        self._requests: queue.SimpleQueue[bool] = queue.SimpleQueue()
        self._answers: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._is_requested = False
        self.is_cancelled = False  # by `close`
        # A daemon thread, so that a process can end while it waits.
        threading.Thread(target=self._serve, name="collided-reader", daemon=True).start()

    def next(self, timeout: float | None) -> Any:
        """The next message; None if none came in time. Raises Error at the end."""
        if not self._is_requested:
            if self.is_cancelled:
                raise _cancelled()
            self._requests.put(True)
            self._is_requested = True
        try:
            answer = self._answers.get(timeout=None if timeout is None else float(timeout))
        except queue.Empty:
            return None
        self._is_requested = False
        if isinstance(answer, Error):
            raise answer
        return answer

    def _serve(self) -> None:
        try:
            self._call = self._begin()
        except ValueError:  # of gRPC, where the channel was closed meanwhile
            self.is_cancelled = True
        while not self.is_cancelled and self._requests.get():
            try:
                self._answers.put(self._next())
            except Error as error:
                self._answers.put(error)
        self._end()  # `close` may have come before the call was made
        self._answers.put(_cancelled())  # for whoever began to wait meanwhile

    def _next(self) -> Any:
        try:
            return next(self._call)
        except StopIteration:
            raise Unavailable("the stream has ended") from None
        except grpc.RpcError as error:
            raise error_of_call(error) from None

    def close(self) -> None:
        """Ends the call and its channel. A thread that waits for a message then raises Cancelled."""
        self.is_cancelled = True
        self._requests.put(False)
        end_elsewhere(self._end)

    def _end(self) -> None:
        if self._call is not None:
            self._call.cancel()
        self._channel.close()


def _cancelled() -> Error:
    return Cancelled("the stream was cancelled")
