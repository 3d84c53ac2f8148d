"""A connection that several threads use for calls."""

from __future__ import annotations

import threading

import collided.leftovers as leftovers
from collided.connection.channel import ask_for_info, open_channel
from collided.connection.features import Features
from collided.connection.options import ConnectOptions
from collided.v1 import collision_service_pb2 as api


class Connection:
    """A channel, and what the daemon says of itself. It is closed once it is retired and its calls are done: another thread's
    must not end with it.
    """

    def __init__(self, address: str, options: ConnectOptions) -> None:
        self.address = address
        self.channel = open_channel(address, options)
        self.info: api.GetServerInfoResponse | None = None  # once the daemon has answered
        self.features: Features | None = None  # likewise
        self._options = options
        self._lock = threading.Lock()
        self._calls = 0
        self._is_retired = False
        # gRPC keeps a channel open that nobody refers to.
        self._unless_retired = leftovers.when_collected(self, self.channel.close)

    def ask(self, patience: float) -> None:
        """Has the daemon answer within so many seconds, if it has not yet. Raises Error."""
        if self.info is None:
            info = ask_for_info(self.channel, self.address, self._options, patience)
            self.features, self.info = Features(info, self.address), info

    def begin_call(self) -> None:
        with self._lock:
            self._calls += 1

    def end_call(self) -> None:
        with self._lock:
            self._calls -= 1
            is_over = self._is_retired and not self._calls
        if is_over:
            self.channel.close()

    def retire(self) -> None:
        """No other call begins."""
        self._unless_retired.detach()
        with self._lock:
            self._is_retired = True
            is_over = not self._calls
        if is_over:
            self.channel.close()
