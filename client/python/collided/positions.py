"""Positions: their formats on the wire, and the formulas by which a client has the daemon's bits.

Every operation is in binary64, none fused, and the result is rounded to the scene's format once.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from collided.arrays import matrix as as_matrix
from collided.arrays import numbers, points
from collided.errors import InvalidArgument
from collided.v1 import scene_pb2

_LAST_STEP = 65535


@dataclass(frozen=True)
class Box:
    """The box that Q16 positions are encoded in: corners of three finite coordinates each, in order."""

    lower: Sequence[float]
    upper: Sequence[float]

    def __post_init__(self) -> None:
        lower, upper = (numbers(corner, f"box.{name}") for name, corner in (("lower", self.lower), ("upper", self.upper)))
        for name, corner in (("lower", lower), ("upper", upper)):
            if corner.shape != (3,):
                raise InvalidArgument(f"box.{name} has shape {corner.shape}; it must be (3,)", field="quantization_box")
        if not (np.isfinite([lower, upper]).all() and (lower <= upper).all()):
            raise InvalidArgument(f"the box is from {lower.tolist()} to {upper.tolist()}; corners must be finite and "
                                  "in order", field="quantization_box")
        object.__setattr__(self, "lower", tuple(map(float, lower)))
        object.__setattr__(self, "upper", tuple(map(float, upper)))

    @staticmethod
    def around(*positions: Any) -> Box:
        """The smallest box of all these positions."""
        arrays = [points(p, "positions") for p in positions]
        return Box(np.min([a.min(axis=0) for a in arrays], axis=0), np.max([a.max(axis=0) for a in arrays], axis=0))

    @property
    def step(self) -> np.ndarray:
        """Length of a step along each axis."""
        return (np.array(self.upper) - np.array(self.lower)) / _LAST_STEP


def pack_quantized(positions: Any, box: Box) -> np.ndarray:
    """Positions as Q16: uint16[n][3], each coordinate at the nearest step of the box.

    Raises InvalidArgument for a position outside the box: what was clamped into it would not be where it was.
    """
    p = points(positions, "positions").astype("<f8", copy=False)
    lower, upper, step = np.array(box.lower), np.array(box.upper), box.step
    outside = ~((p >= lower) & (p <= upper))
    if outside.any():
        vertex, axis = np.argwhere(outside)[0]
        raise InvalidArgument(f"positions[{vertex}].{'xyz'[axis]} is {p[vertex, axis]!r}, outside the box, "
                              f"{lower[axis]!r} to {upper[axis]!r}", field="positions")
    quotient = np.divide(p - lower, step, out=np.zeros_like(p), where=step > 0)
    # Away from zero at a half, where numpy's own rounding goes to even.
    floor = np.floor(quotient)
    rounded = floor + (quotient - floor >= 0.5)
    return np.minimum(rounded, _LAST_STEP).astype("<u2")


def unpack_quantized(encoded: np.ndarray, box: Box) -> np.ndarray:
    """The float32 positions that the daemon computes with."""
    return (np.array(box.lower) + encoded.astype("<f8") * box.step).astype("<f4")


def move_along(positions: np.ndarray, target: np.ndarray, fraction: float | np.ndarray) -> np.ndarray:
    """Where the daemon is after it went `fraction` (0 to 1) of the way from `positions` to `target`, in their dtype.

    fraction: `Contacts.advanced`, or a frame's `from_last_fraction`; or (n,), one for each of n positions: those of an advance
        per vertex or per mesh, as `Contacts.fractions` has them.
    """
    x, p = numbers(positions, "positions"), numbers(target, "target")
    if x.shape != p.shape:
        raise InvalidArgument(f"target has shape {p.shape}, positions have {x.shape}", field="target")
    a = _fractions(fraction, x.shape[:1])
    if a.ndim == 0 and a in (0, 1):
        return (p if a else x).astype(x.dtype)
    x64, a = x.astype("<f8"), a.reshape(-1, 1) if a.ndim else a
    between = (x64 + a * (p.astype("<f8") - x64)).astype(x.dtype)
    return np.where(a == 0, x, np.where(a == 1, p, between)).astype(x.dtype) if a.ndim else between


def _fractions(fraction: Any, each: tuple[int, ...] | None = None) -> np.ndarray:
    """One number from 0 to 1 as float64, or, of the shape `each`, one for each position."""
    a = numbers(fraction, "fraction").astype("<f8")
    if a.ndim and a.shape != each:
        raise InvalidArgument(f"fraction has shape {a.shape}; it must be one number{f', or {each}' if each else ''}", field="fraction")
    bad = np.flatnonzero(~((a >= 0) & (a <= 1)))
    if bad.size:
        where = f"fraction[{bad[0]}]" if a.ndim else "fraction"
        raise InvalidArgument(f"{where} is {float(a.flat[bad[0]])!r}; it must be from 0 to 1", field="fraction")
    return a


def pose_along(start: Any, target: Any, fraction: float) -> np.ndarray:
    """Returns the pose of a rigid mesh after an advance went `fraction` (0 to 1) of the way from the pose `start` to `target`.

    start, target: the rows of [R | t], (3, 4), or matrices (4, 4). The daemon takes turns of up to 3 radians.
    fraction: one number, such as each of `Contacts.fractions` of the mesh.
    The result is float64[3][4]. Raises InvalidArgument for another fraction or shape. Between 0 and 1 it also raises it for
    rotations that are half a turn apart or not finite.
    """
    rows, other_rows = as_matrix(start, "start"), as_matrix(target, "target")
    f = float(_fractions(fraction))
    if f in (0, 1):
        return other_rows if f else rows
    # The names of proto/CONVENTIONS.md. numpy's own sums may have another order.
    a, b = rows.T.tolist(), other_rows.T.tolist()
    c, v = _half_turn(a, b)
    q, m = _dot(v, v), 2 * f - 1
    h = 2 * (f * (1 - f)) / (c + math.sqrt(max(0.0, 1 - (m * m) * q)))
    s, r = f * c + h * q, f - h * c

    def turn(along: float, across: float, turned: float, x: list[float]) -> list[float]:
        scale = across * _dot(v, x)
        return [along * x_i + (scale * v_i + turned * z_i) for x_i, v_i, z_i in zip(x, v, _cross(v, x))]

    backs = [turn(1 - 2 * q, 2, -2 * c, b_k) for b_k in b[:3]]
    columns = [turn(1 - 2 * (r * q), 2 * r, 2 * s, [x + f * (y - x) for x, y in zip(*pair)]) for pair in zip(a, backs)]
    way = _minus(b[3], a[3])
    columns.append([x + (f * y + h * z) for x, y, z in zip(a[3], way, _cross(way, v))])
    return np.array([*zip(*columns)], "<f8")


def _half_turn(a: list[list[float]], b: list[list[float]]) -> tuple[float, list[float]]:
    """The rotation between two poses, given by their columns, as a unit quaternion."""
    cosine, sine = 1.0, [0.0] * 3
    for k in range(3):
        cosine += _dot(a[k], b[k])
        sine = [x + y for x, y in zip(sine, _cross(a[k], _minus(b[k], a[k])))]
    if not 0 < cosine < math.inf:
        raise InvalidArgument("target has a rotation that is half a turn from that of start, or one of them is not finite; "
                              "they must turn by less", field="target")
    length = math.sqrt(cosine * cosine + _dot(sine, sine))
    return cosine / length, [(1 / length) * x for x in sine]


def _minus(u: list[float], v: list[float]) -> list[float]:
    return [x - y for x, y in zip(u, v)]


def _dot(u: list[float], v: list[float]) -> float:
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


def _cross(u: list[float], v: list[float]) -> list[float]:
    return [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]


def move_rigidly(positions: np.ndarray, transform: Any) -> np.ndarray:
    """Where a pose, the rows of [R | t], puts the vertices of a rigid mesh from where its first frame had them."""
    x, rows = points(positions, "positions"), as_matrix(transform, "transform")
    x64 = x.astype("<f8")
    columns = [((r[0] * x64[:, 0] + r[1] * x64[:, 1]) + r[2] * x64[:, 2]) + r[3] for r in rows]
    return np.stack(columns, axis=1).astype(x.dtype)


@dataclass(frozen=True)
class Format:
    """How a scene's positions are on the wire (`dtype`) and in the engine (`real`)."""

    name: str
    dtype: np.dtype
    real: np.dtype
    box: Box | None = None

    @property
    def number(self) -> scene_pb2.PositionFormat:
        """The protocol's value."""
        return _number(self.name)

    def encode(self, values: Any, argument: str, count: int | None) -> np.ndarray:
        """Positions as contiguous bytes of the wire. May be the caller's own memory, or a copy."""
        array = points(values, argument, count)
        if self.box is not None:
            is_encoded = array.dtype.newbyteorder("=") == np.uint16
            return np.ascontiguousarray(array, self.dtype) if is_encoded else pack_quantized(array, self.box)
        if array.dtype == self.dtype:
            return np.ascontiguousarray(array)
        with np.errstate(over="ignore", invalid="ignore"):  # what overflows is refused by the daemon, with its vertex
            return np.ascontiguousarray(array, self.dtype)

    def decode(self, wire: np.ndarray) -> np.ndarray:
        """Positions as the engine has them."""
        return wire if self.box is None or wire.dtype == self.real else unpack_quantized(wire, self.box)


@dataclass(frozen=True)
class FormatRow:
    """A format of positions: on the wire and in the engine. has_box: coordinates are steps of a box."""

    dtype: np.dtype
    real: np.dtype
    has_box: bool = False

    @property
    def position_bytes(self) -> int:
        """Bytes of one vertex's position on the wire."""
        return 3 * self.dtype.itemsize


# Keys are the words for the protocol's values.
FORMATS = {"f32": FormatRow(np.dtype("<f4"), np.dtype("<f4")),
           "f64": FormatRow(np.dtype("<f8"), np.dtype("<f8")),
           "q16": FormatRow(np.dtype("<u2"), np.dtype("<f4"), has_box=True)}


def _number(name: str) -> scene_pb2.PositionFormat:
    return scene_pb2.PositionFormat.Value(f"POSITION_FORMAT_{name.upper()}")


_ROWS = {_number(name): row for name, row in FORMATS.items()}


def format_row(number: scene_pb2.PositionFormat) -> FormatRow | None:
    """The format of the protocol's value; None for one that this client does not know."""
    return _ROWS.get(number)


def shown_dtype(number: scene_pb2.PositionFormat) -> np.dtype:
    """The type in which the daemon shows positions of a scene: as they are in the engine."""
    row = format_row(number) or FORMATS["f32"]
    return row.real


def format_named(name: str, box: Box | None) -> Format:
    """The format of this word, with a box if it needs one."""
    row = FORMATS[name]
    if row.has_box != (box is not None):
        with_box = " or ".join(repr(word) for word, each in FORMATS.items() if each.has_box)
        raise InvalidArgument(f"position_format is {name!r} and quantization_box is {box}; {with_box} and a box go together",
                              field="quantization_box")
    return Format(name, row.dtype, row.real, box)
