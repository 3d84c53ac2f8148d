"""Messages of a gRPC stream, one at a time, with a timeout."""

from __future__ import annotations

import queue
import threading
from typing import Any

import grpc

from collided.errors import Error, Unavailable, error_of_call


class Messages:
    """gRPC has no timeout for one message of a stream: once one is asked for, a thread reads, a message for each request."""

    def __init__(self, call: Any) -> None:
        self._call = call
        self._requests: queue.SimpleQueue[bool] = queue.SimpleQueue()
        self._answers: queue.SimpleQueue[Any] | None = None
        self._is_requested = False
        self.is_cancelled = False  # by `cancel`

    def next(self, timeout: float | None) -> Any:
        """The next message; None if none came in time. Raises Error at the end."""
        if self._answers is None or (self.is_cancelled and not self._is_requested):
            if timeout is None or self.is_cancelled:
                return self._next()
            self._answers = queue.SimpleQueue()
            # A daemon thread, so that a process can end while it waits.
            threading.Thread(target=self._serve, args=(self._answers,), name="collided-reader", daemon=True).start()
        if not self._is_requested:
            self._requests.put(True)
            self._is_requested = True
        try:
            answer = self._answers.get(timeout=timeout)
        except queue.Empty:
            return None
        self._is_requested = False
        if isinstance(answer, Error):
            raise answer
        return answer

    def _serve(self, answers: queue.SimpleQueue[Any]) -> None:
        while self._requests.get():
            try:
                answers.put(self._next())
            except Error as error:
                answers.put(error)
        answers.put(Unavailable("the stream was cancelled"))  # for whoever began to wait meanwhile

    def _next(self) -> Any:
        try:
            return next(self._call)
        except StopIteration:
            raise Unavailable("the stream has ended") from None
        except grpc.RpcError as error:
            raise error_of_call(error) from None

    def cancel(self) -> None:
        """Ends the call; whoever waits for a message is told."""
        self.is_cancelled = True
        self._call.cancel()
        self._requests.put(False)
