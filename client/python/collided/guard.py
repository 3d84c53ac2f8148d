"""Calls of an object that is for one thread at a time, any of which may be interrupted."""

from __future__ import annotations

import threading
import weakref
from collections.abc import Callable

from collided.errors import Error, FailedPrecondition

_NOBODY, _INTERRUPTED = 0, -1  # instead of the thread that is in a call


class Guard:
    """A context around each call. What anything but an Error ends, such as KeyboardInterrupt, may have been anywhere, here
    as well; that it was not left still shows when the next call begins, which settles what it has left behind."""

    def __init__(self, settle: Callable[[], None], failure: Callable[[], Error | None]) -> None:
        """Both are methods of the object that has this guard, which weak references keep collectable without the cycle collector.

        failure: why the object is closed, which another thread may do during a call: then anything else may fail.
        """
        self._settle, self._failure = weakref.WeakMethod(settle), weakref.WeakMethod(failure)
        self._inside = _NOBODY

    @property
    def was_interrupted(self) -> bool:
        """Outside of calls: whether the last one was."""
        return self._inside != _NOBODY

    def settle(self) -> None:
        """What the last call has left behind, if it was interrupted. Raises FailedPrecondition if another thread is in it."""
        if self._inside != _NOBODY:
            with self:
                pass

    def __enter__(self) -> None:
        here = threading.get_ident()
        if self._inside != _NOBODY:
            if self._inside not in (here, _INTERRUPTED):
                raise FailedPrecondition("another thread is in a call of this session, which is for one at a time")
            settle = self._settle()
            assert settle is not None
            settle()
        self._inside = here

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: object) -> None:
        self._inside = _NOBODY if kind is None or issubclass(kind, Error) else _INTERRUPTED
        why = self._failure() if isinstance(error, Exception) else None
        failure = None if why is None else why()
        if failure is not None and failure is not error:
            raise failure from None
