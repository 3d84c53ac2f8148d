"""PLY, ASCII or binary of either byte order: positions of "vertex", corners of "face"; all else is skipped."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from collided.errors import InvalidArgument
from collided.meshes.polygons import fans

_TYPES = {"char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
          "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4",
          "double": "f8", "float64": "f8"}
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_CORNERS = ("vertex_indices", "vertex_index")


@dataclass
class _Property:
    name: str
    type: str
    count_type: str = ""  # of a list's length; empty: no list


@dataclass
class _Element:
    name: str
    count: int
    properties: list[_Property] = field(default_factory=list)

    @property
    def lists(self) -> list[_Property]:
        return [p for p in self.properties if p.count_type]


class _Body(Protocol):
    """Where the elements are read from."""

    def table(self, element: _Element, lengths: dict[str, int], most: int) -> np.ndarray:
        """The next rows, up to `most`, whose lists have these lengths. Does not move on."""

    def skip(self, element: _Element, lengths: dict[str, int], rows: int) -> None:
        """Moves on behind so many of them."""


def read_ply(data: bytes) -> dict[str, Any]:
    """Vertices and triangles, as arguments of Mesh."""
    order, elements, body_at = _header(data)
    body: _Body = _Binary(data, body_at, order) if order else _Text(data[body_at:])
    vertices, triangles = np.empty((0, 3)), np.empty((0, 3), np.int64)
    for element in elements:
        if element.name == "vertex":
            vertices = _vertices(body, element)
        elif element.name == "face":
            triangles = _triangles(body, element, len(vertices))
        else:
            for _ in _runs(body, element):
                pass
    return {"vertices": vertices, "triangles": triangles}


def _header(data: bytes) -> tuple[str, list[_Element], int]:
    end = data.find(b"end_header")
    body_at = data.find(b"\n", end) + 1
    if not data.startswith(b"ply") or end < 0 or body_at == 0:
        raise InvalidArgument("the file does not begin with a PLY header")
    order, elements = None, []
    for number, line in enumerate(data[:end].decode("latin-1").splitlines(), 1):
        try:
            match line.split():
                case ["format", name, *_]:
                    order = _ORDERS[name]
                case ["element", name, count]:
                    elements.append(_Element(name, int(count)))
                case ["property", "list", count_type, kind, name]:
                    elements[-1].properties.append(_Property(name, _TYPES[kind], _TYPES[count_type]))
                case ["property", kind, name]:
                    elements[-1].properties.append(_Property(name, _TYPES[kind]))
        except (KeyError, ValueError, IndexError):
            raise InvalidArgument(f"line {number} of the header cannot be read: {line[:40]!r}") from None
    if order is None:
        raise InvalidArgument("the header names no format")
    for element in elements:
        if not 0 <= element.count <= len(data):
            raise InvalidArgument(f"{element.count} elements {element.name!r} do not fit in {len(data)} bytes")
    return order, elements, body_at


def _runs(body: _Body, element: _Element) -> Any:
    """Tables of successive rows whose lists have the same lengths; most files have one."""
    left, at_once = element.count if element.properties else 0, element.count
    while left > 0:
        lengths = {p.name: 0 for p in element.lists}
        for name in lengths:  # a list's place depends on the lengths of those before it
            lengths[name] = int(body.table(element, lengths, 1)["count of " + name][0])
            if lengths[name] < 0:
                raise InvalidArgument(f"a list {name!r} of {element.name!r} has the length {lengths[name]}")
        rows = body.table(element, lengths, min(left, at_once))
        same = np.ones(len(rows), bool)
        for name, length in lengths.items():
            same &= rows["count of " + name] == length
        equal = len(rows) if same.all() else int(same.argmin())
        yield lengths, rows[:equal]
        body.skip(element, lengths, equal)
        left -= equal
        at_once = max(64, 2 * equal)  # where lengths alternate, few rows are looked at in vain


def _dtype(element: _Element, lengths: dict[str, int], order: str) -> np.dtype:
    """Of a row whose lists have these lengths; of text ("") doubles hold every type exactly."""
    fields: list[Any] = []
    for p in element.properties:
        kind = order + p.type if order else "f8"
        if p.count_type:
            fields.append(("count of " + p.name, order + p.count_type if order else "f8"))
            fields.append((p.name, kind, (lengths[p.name],)))
        else:
            fields.append((p.name, kind))
    return np.dtype(fields)


class _Binary(_Body):
    def __init__(self, data: bytes, at: int, order: str) -> None:
        self._data, self._at, self._order = data, at, order

    def table(self, element: _Element, lengths: dict[str, int], most: int) -> np.ndarray:
        dtype = _dtype(element, lengths, self._order)
        rows = min(most, (len(self._data) - self._at) // dtype.itemsize)
        if rows < 1:
            raise InvalidArgument(f"the file is cut off within {element.name!r}")
        return np.frombuffer(self._data, dtype, rows, self._at)

    def skip(self, element: _Element, lengths: dict[str, int], rows: int) -> None:
        self._at += rows * _dtype(element, lengths, self._order).itemsize


class _Text(_Body):
    def __init__(self, text: bytes) -> None:
        try:
            self._numbers = np.array(text.split(), dtype="S").astype("<f8")
        except ValueError as error:
            raise InvalidArgument(f"a word is not a number: {error}") from None
        self._at = 0

    def table(self, element: _Element, lengths: dict[str, int], most: int) -> np.ndarray:
        dtype = _dtype(element, lengths, "")
        width = dtype.itemsize // 8
        rows = min(most, (len(self._numbers) - self._at) // width)
        if rows < 1:
            raise InvalidArgument(f"the file is cut off within {element.name!r}")
        return self._numbers[self._at:self._at + rows * width].view(dtype)

    def skip(self, element: _Element, lengths: dict[str, int], rows: int) -> None:
        self._at += rows * (_dtype(element, lengths, "").itemsize // 8)


def _vertices(body: _Body, element: _Element) -> np.ndarray:
    if not {"x", "y", "z"} <= {p.name for p in element.properties if not p.count_type}:
        raise InvalidArgument("element vertex lacks one of the properties x, y, z")
    tables = [np.stack([rows[axis] for axis in "xyz"], axis=1) for _, rows in _runs(body, element)]
    vertices = np.concatenate(tables) if tables else np.empty((0, 3))
    return vertices.astype(vertices.dtype.newbyteorder("=")) if vertices.dtype.kind == "f" else vertices.astype("<f8")


def _triangles(body: _Body, element: _Element, vertices: int) -> np.ndarray:
    indices = next((p for p in element.lists if p.name in _CORNERS), None)
    if indices is None:
        raise InvalidArgument("element face lacks the list vertex_indices")
    if "f" in (indices.type[0], indices.count_type[0]):
        raise InvalidArgument(f"the list {indices.name} has a floating-point type; lengths and indices must be integers")
    corners, counts = [np.empty(0, np.int64)], [np.empty(0, np.int64)]
    for lengths, rows in _runs(body, element):
        values = rows[indices.name].reshape(-1)
        if values.dtype.kind == "f" and (broken := values[values != np.floor(values)]).size:  # of text
            raise InvalidArgument(f"vertex index {broken[0]} is not an integer")
        corners.append(values.astype(np.int64))
        counts.append(np.full(len(rows), lengths[indices.name]))
    all_corners = np.concatenate(corners)
    bad = np.flatnonzero((all_corners < 0) | (all_corners >= vertices))
    if bad.size:
        raise InvalidArgument(f"vertex index {all_corners[bad[0]]} is out of range; there are {vertices} vertices")
    return fans(all_corners, np.concatenate(counts), "face")
