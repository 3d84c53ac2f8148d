"""The arrays of a frame's contacts, from the daemon's chunks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from collided.contacts.checks import check_chunk
from collided.errors import DataLoss
from collided.v1 import contact_pb2

NO_VERTEX = 2**32 - 1


@dataclass(frozen=True)
class Column:
    """A field of contacts: its dtype, the shape of one entry, and what stands where a kind of contact has none."""

    name: str
    dtype: np.dtype
    shape: tuple[int, ...]
    missing: Any


COLUMNS = {column.name: column for column in (
    Column("elements", np.dtype("<u4"), (2,), NO_VERTEX),
    Column("stencils", np.dtype("<u4"), (4,), NO_VERTEX),
    Column("toi", np.dtype("<f8"), (), np.nan),
    Column("distance", np.dtype("<f8"), (), np.nan),
    Column("weights", np.dtype("<f8"), (2,), np.nan),
    Column("normals", np.dtype("<f4"), (3,), np.nan),
    Column("flags", np.dtype("u1"), (), 0))}
Arrays = dict[str, np.ndarray]


@dataclass(frozen=True, eq=False)
class Part:
    """Contacts of one kind; fields that were not sent are absent."""

    kind: int
    count: int
    arrays: Arrays


def read_chunk(chunk: contact_pb2.ContactChunk, shared: Callable[[Any], memoryview] | None = None) -> Part:
    """A chunk of the daemon's; arrays in shared memory are copied from where `shared` finds their ranges."""
    check_chunk(chunk)
    arrays: Arrays = {}
    for name, column in COLUMNS.items():
        data: Any = getattr(chunk, name)
        if not data and shared is not None and chunk.HasField("shared"):
            data = shared(getattr(chunk.shared, name))
        if len(data):
            arrays[name] = _array(data, column, chunk.count)
    return Part(chunk.kind, chunk.count, arrays)


def _array(data: bytes | memoryview, column: Column, count: int) -> np.ndarray:
    width = column.dtype.itemsize * int(np.prod(column.shape, dtype=int))
    if len(data) != count * width:
        raise DataLoss(f"contacts.{column.name} has {len(data)} bytes for {count} contacts; it needs {count * width}")
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
