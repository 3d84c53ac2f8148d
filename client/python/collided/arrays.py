"""Arrays that callers pass, checked and in the form of the wire: little-endian, contiguous."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from collided.errors import InvalidArgument

UINT32_MAX = 2**32 - 1
INDEX = np.dtype("<u4")


class OneLine:
    """The repr of a dataclass (repr=False) whose fields may be large arrays: a line with their types and shapes."""

    def __repr__(self) -> str:
        assert dataclasses.is_dataclass(self)
        fields = (f"{field.name}={_outline(getattr(self, field.name))}" for field in dataclasses.fields(self))
        return f"{type(self).__name__}({', '.join(fields)})"


def _outline(value: Any) -> str:
    if hasattr(value, "dtype") and hasattr(value, "shape"):
        return f"<{value.dtype} {tuple(value.shape)}>"
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key!r}: {_outline(entry)}" for key, entry in value.items()) + "}"
    text = repr(value)
    is_short = len(text) <= 100 and "\n" not in text
    if is_short:
        return text
    size = f" of {len(value)}" if hasattr(value, "__len__") else ""
    return f"<{type(value).__name__}{size}>"


def real(value: Any) -> float:
    """A real number as a double; NaN for what is none."""
    if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
        return math.nan
    try:
        return float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.inf


def check_length(value: Any, argument: str) -> None:
    """Whether it is a length: finite, and at least 0."""
    if not 0 <= real(value) < math.inf:
        raise InvalidArgument(f"{argument} is {value!r}; it must be finite and at least 0", field=argument)


def is_whole(value: Any, most: float) -> bool:
    """Whether it is an integer from 0 to `most`; a bool is none."""
    return not isinstance(value, bool) and isinstance(value, (int, np.integer)) and 0 <= value <= most


def numbers(values: Any, argument: str) -> np.ndarray:
    """An array of real numbers."""
    try:
        array = np.asarray(values)
    except (TypeError, ValueError) as error:
        raise InvalidArgument(f"{argument} is no array of numbers: {error}", field=argument) from None
    if array.dtype.kind not in "fiu":
        raise InvalidArgument(f"{argument} has dtype {array.dtype}; it must be of real numbers", field=argument)
    return array


def points(values: Any, argument: str, count: int | None = None) -> np.ndarray:
    """An array of shape (n, 3), of `count` rows if that is given."""
    array = numbers(values, argument)
    if array.ndim != 2 or array.shape[1] != 3:
        raise InvalidArgument(f"{argument} has shape {array.shape}; it must be (n, 3)", field=argument)
    if count is not None and len(array) != count:
        raise InvalidArgument(f"{argument} has {len(array)} rows; it must have {count}", field=argument)
    return array


def ids(values: Any, argument: str, corners: int = 0) -> np.ndarray:
    """Vertex numbers as uint32, of shape (n, corners), or (n,) for 0 corners."""
    try:
        array = np.asarray(values)
    except (TypeError, ValueError) as error:
        raise InvalidArgument(f"{argument} is no array of integers: {error}", field=argument) from None
    shape = f"(n, {corners})" if corners else "(n,)"
    if array.size == 0:
        return np.empty((0, corners) if corners else (0,), INDEX)
    if array.dtype.kind not in "iu":
        raise InvalidArgument(f"{argument} has dtype {array.dtype}; it must be of integers", field=argument)
    if array.ndim != (2 if corners else 1) or (corners and array.shape[1] != corners):
        raise InvalidArgument(f"{argument} has shape {array.shape}; it must be {shape}", field=argument)
    low, high = int(array.min()), int(array.max())
    if low < 0 or high > UINT32_MAX:
        raise InvalidArgument(f"{argument} has index {low if low < 0 else high}; indices are from 0 to {UINT32_MAX}",
                              field=argument)
    return np.ascontiguousarray(array, INDEX)


def check_below(array: np.ndarray, limit: int, argument: str) -> None:
    """Whether all vertex numbers are of a mesh that has `limit` vertices."""
    if array.size and int(array.max()) >= limit:
        raise InvalidArgument(f"{argument} has index {int(array.max())}; the mesh has {limit} vertices", field=argument)


def matrix(values: Any, argument: str) -> np.ndarray:
    """The rows of [R | t] as float64 of shape (3, 4), from that or from a matrix of shape (4, 4)."""
    array = numbers(values, argument)
    if array.shape == (4, 4):
        if not np.array_equal(array[3], (0, 0, 0, 1)):
            raise InvalidArgument(f"{argument} has the last row {array[3].tolist()}; it must be 0 0 0 1",
                                  field=argument)
        array = array[:3]
    if array.shape != (3, 4):
        raise InvalidArgument(f"{argument} has shape {array.shape}; it must be (3, 4) or (4, 4)", field=argument)
    return np.array(array, "<f8", order="C")
