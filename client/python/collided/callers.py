"""Warnings that point at the caller's line, however deep in the package, or in which of its threads, they come up."""

from __future__ import annotations

import asyncio
import contextvars
import functools
import os
import sys
import warnings
from collections.abc import Callable
from typing import Any, TypeVar

_T = TypeVar("_T")
_Place = tuple[str, int, str, Any]  # arguments of warnings.warn_explicit

_OWN = tuple(os.path.dirname(os.path.abspath(str(module))) + os.sep for module in (__file__, asyncio.__file__))
_place: contextvars.ContextVar[_Place | None] = contextvars.ContextVar("place", default=None)


def warn(message: str) -> None:
    file, line, module, registry = _place.get() or _caller()
    warnings.warn_explicit(message, UserWarning, file, line, module, registry)


def from_here(function: Callable[..., _T], *arguments: Any, **options: Any) -> Callable[[], _T]:
    """The call, for another thread: its warnings point at this one's caller."""
    context = contextvars.copy_context()
    context.run(_place.set, _place.get() or _caller())
    return functools.partial(context.run, function, *arguments, **options)


def _caller() -> _Place:
    """The innermost line outside this package and asyncio, which calls coroutines."""
    frame = sys._getframe(1)
    while frame.f_back is not None and frame.f_code.co_filename.startswith(_OWN):
        frame = frame.f_back
    registry = frame.f_globals.setdefault("__warningregistry__", {})
    return frame.f_code.co_filename, frame.f_lineno, frame.f_globals.get("__name__") or "<unknown>", registry
