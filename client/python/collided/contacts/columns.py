"""The arrays of a frame's contacts, from the daemon's chunks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from collided.columns import COLUMNS, Column
from collided.contacts.checks import CONTACTS, LIMITS, check_chunk, check_limits
from collided.errors import DataLoss
from collided.v1 import contact_pb2

Arrays = dict[str, np.ndarray]


@dataclass(frozen=True, eq=False)
class Part:
    """Contacts of one kind; fields that were not sent are absent."""

    kind: int
    count: int
    arrays: Arrays


def read_chunk(chunk: contact_pb2.ContactChunk, shared: Callable[[Any], memoryview] | None = None, field: str = CONTACTS) -> Part:
    """A chunk of the daemon's; arrays in shared memory are copied from where `shared` finds their ranges. field: of the answer,
    which errors name."""
    check_chunk(chunk, field)
    arrays: Arrays = {}
    for name, column in COLUMNS.items():
        data: Any = getattr(chunk, name)
        if not data and shared is not None and chunk.HasField("shared"):
            data = shared(getattr(chunk.shared, name))
        if len(data):
            arrays[name] = _array(data, column, chunk.count, field)
    return Part(chunk.kind, chunk.count, arrays)


def read_limits(chunks: Sequence[contact_pb2.ContactChunk], are_asked: bool,
                shared: Callable[[Any], memoryview] | None = None) -> list[Part]:
    """Reads chunks of what limits a frame's way, which have every array but `features` and `signed_distances`. are_asked: the frame has `limits`. Raises
    DataLoss."""
    check_limits(chunks, are_asked)
    parts = [read_chunk(chunk, shared, LIMITS) for chunk in chunks]
    for part in parts:
        for column in COLUMNS.values():
            if column.in_limits and column.name not in part.arrays:
                _array(b"", column, part.count, LIMITS)
    return parts


def _array(data: bytes | memoryview, column: Column, count: int, field: str) -> np.ndarray:
    if len(data) != count * column.width:
        raise DataLoss(f"{field}.{column.name} has {len(data)} bytes for {count} contacts; it needs {count * column.width}")
    return np.frombuffer(bytes(data), column.dtype).reshape(count, *column.shape)  # bytes() copies no bytes


def joined(parts: list[Part], name: str) -> np.ndarray | None:
    """The column of all parts, one after the other; None if there are contacts, and none of them has it."""
    column = COLUMNS[name]
    if parts and all(name not in part.arrays for part in parts):
        return None
    if len(parts) == 1:
        return parts[0].arrays[name]
    missing = [np.full((part.count, *column.shape), column.missing, column.dtype) if name not in part.arrays
               else part.arrays[name] for part in parts]
    return np.concatenate(missing) if missing else np.empty((0, *column.shape), column.dtype)
