"""PLY, ASCII or binary of either byte order: positions of "vertex", corners of "face", strips of "tristrips"; all else is
skipped."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from collided.meshes.polygons import ReadError
from collided.meshes.raw import RawMesh, lines_of, number, strip_faces, text_of

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

    @property
    def corners(self) -> _Property | None:
        """The list of a face's vertices."""
        return next((p for p in self.lists if p.name in _CORNERS), None)


class _Body(Protocol):
    """Where the elements are read from."""

    def table(self, element: _Element, lengths: dict[str, int], most: int) -> np.ndarray:
        """The next rows, up to `most`, whose lists have these lengths. Does not move on."""

    def skip(self, element: _Element, lengths: dict[str, int], rows: int) -> None:
        """Moves on behind so many of them."""


def read_ply(data: bytes, _path: str) -> RawMesh:
    order, elements, body_at = _header(data)
    body: _Body = _Binary(data, body_at, order) if order else _Text(data, body_at)
    mesh = RawMesh()
    for element in elements:
        if element.name == "vertex":
            mesh.vertices = _vertices(body, element)
        elif element.name in ("face", "tristrips") and element.count:
            corners, counts = _corners(body, element)
            if element.name == "tristrips":
                corners, counts = _faces_of_strips(corners, counts)
            mesh.corners, mesh.counts = np.append(mesh.corners, corners), np.append(mesh.counts, counts)
        else:
            for _ in _runs(body, element):
                pass
    return mesh


def _header_lines(data: bytes) -> Any:
    """Each line, and where the next one begins. After a line that CR alone ends, an LF is the first byte of binary data."""
    has_cr_lines = data.startswith(b"ply\r") and not data.startswith(b"ply\r\n")
    at = 0
    while at < len(data):
        ends = [end for end in (data.find(b"\n", at), data.find(b"\r", at, at + 4096 if not has_cr_lines else len(data))) if end >= 0]
        end = min(ends, default=len(data))
        line, at = data[at:end], end + (1 if has_cr_lines or data[end:end + 2] != b"\r\n" else 2)
        yield line, at


def _header(data: bytes) -> tuple[str, list[_Element], int]:
    order, elements, body_at = None, [], 0
    for number_, (line, at) in enumerate(_header_lines(data), 1):
        words = line.split()
        if number_ == 1 and line != b"ply":
            break
        if words[:1] == [b"end_header"]:
            body_at = at
            break
        order = _header_line(words, order, elements, f":{number_}") if number_ > 1 and words else order
    if not data.startswith((b"ply\n", b"ply\r")):
        raise ReadError("does not begin with 'ply'")
    if not body_at:
        raise ReadError("is cut off in its header")
    if order is None:
        raise ReadError("has no format line")
    for element in elements:
        if element.name in ("face", "tristrips") and element.count and not element.corners:
            raise ReadError(f"element {element.name} lacks the list vertex_indices")
        if element.count and not element.properties:
            raise ReadError(f"element {element.name} has no properties")
        if element.count > len(data) - body_at:
            raise ReadError(f"is cut off: {element.count} of element {element.name} do not fit in the "
                            f"{len(data) - body_at} bytes that follow the header")
    return order, elements, body_at


def _type(word: bytes, place: str) -> str:
    if word.decode("latin-1") not in _TYPES:
        raise ReadError(f"type '{text_of(word)}' is not a PLY type", place)
    return _TYPES[word.decode("latin-1")]


def _header_line(words: list[bytes], order: str | None, elements: list[_Element], place: str) -> str | None:
    """Adds what a line declares; returns the byte order."""
    key, words = words[0], words[1:] + [b""] * 4
    if key == b"format":
        if words[0].decode("latin-1") not in _ORDERS:
            raise ReadError(f"format '{text_of(words[0])}' is not a PLY format", place)
        return _ORDERS[words[0].decode("latin-1")]
    if key == b"element":
        count = number(words[1], place, int)
        if count < 0:
            raise ReadError(f"'{text_of(words[1])}' is not a number", place)
        if count >= 2 ** 64:
            raise ReadError(f"number {text_of(words[1])} is out of range", place)
        elements.append(_Element(words[0].decode("latin-1"), count))
    elif key == b"property":
        if not elements:
            raise ReadError("a property stands before any element", place)
        count_type = _type(words[1], place) if words[0] == b"list" else ""
        if count_type.startswith("f"):
            raise ReadError("a list's length must be an integer type", place)
        kind, name = words[2:4] if count_type else words[:2]
        property_ = _Property(name.decode("latin-1"), _type(kind, place), count_type)
        elements[-1].properties.append(property_)
        if elements[-1].name in ("face", "tristrips") and property_ is elements[-1].corners and property_.type[0] == "f":
            raise ReadError(f"{property_.name} must be of an integer type", place)
    elif key not in (b"comment", b"obj_info"):
        raise ReadError(f"'{text_of(key)}' is not a PLY keyword", place)
    return order


def _runs(body: _Body, element: _Element) -> Any:
    """Tables of successive rows whose lists have the same lengths; most files have one."""
    left, at_once = element.count if element.properties else 0, element.count
    while left > 0:
        lengths = {p.name: 0 for p in element.lists}
        for name in lengths:  # a list's place depends on the lengths of those before it
            lengths[name] = int(body.table(element, lengths, 1)["count of " + name][0])
            if lengths[name] < 0:
                raise ReadError(f"a list of {lengths[name]} does not fit in the file", f": {element.name} {element.count - left}")
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
            raise ReadError(f"is cut off within element {element.name}")
        return np.frombuffer(self._data, dtype, rows, self._at)

    def skip(self, element: _Element, lengths: dict[str, int], rows: int) -> None:
        self._at += rows * _dtype(element, lengths, self._order).itemsize


class _Text(_Body):
    def __init__(self, data: bytes, at: int) -> None:
        try:
            if b"_" in data[at:]:
                raise ValueError
            self._numbers = np.array(data[at:].split(), dtype="S").astype("<f8")
        except ValueError:
            first = 1 + len(lines_of(data[:at])) - 1
            for line_number, line in enumerate(lines_of(data[at:]), first):
                for word in line.split():
                    number(word, f":{line_number}")
            raise
        self._at = 0

    def table(self, element: _Element, lengths: dict[str, int], most: int) -> np.ndarray:
        dtype = _dtype(element, lengths, "")
        width = dtype.itemsize // 8
        rows = min(most, (len(self._numbers) - self._at) // width)
        if rows < 1:
            raise ReadError(f"is cut off within element {element.name}")
        return self._numbers[self._at:self._at + rows * width].view(dtype)

    def skip(self, element: _Element, lengths: dict[str, int], rows: int) -> None:
        self._at += rows * (_dtype(element, lengths, "").itemsize // 8)


def _vertices(body: _Body, element: _Element) -> np.ndarray:
    if not {"x", "y", "z"} <= {p.name for p in element.properties if not p.count_type}:
        raise ReadError("element vertex lacks one of the properties x, y, z")
    tables = [np.stack([rows[axis] for axis in "xyz"], axis=1) for _, rows in _runs(body, element)]
    vertices = np.concatenate(tables) if tables else np.empty((0, 3))
    return vertices.astype(vertices.dtype.newbyteorder("=")) if vertices.dtype.kind == "f" else vertices.astype("<f8")


def _corners(body: _Body, element: _Element) -> tuple[np.ndarray, np.ndarray]:
    """The vertices that all rows list, and how many each lists."""
    assert element.corners
    name = element.corners.name
    corners, counts, row = [np.empty(0, np.int64)], [np.empty(0, np.int64)], 0
    for lengths, rows in _runs(body, element):
        values = rows[name].reshape(-1)
        if values.dtype.kind == "f" and (broken := np.flatnonzero(values != np.floor(values))).size:  # of text
            raise ReadError(f"vertex index {values[broken[0]]} is not an integer",
                            f": {element.name} {row + broken[0] // lengths[name]}")
        if values.dtype.kind == "f":
            values = np.clip(values, -2.0 ** 62, 2.0 ** 62)
        corners.append(values.astype(np.int64))
        counts.append(np.full(len(rows), lengths[name]))
        row += len(rows)
    return np.concatenate(corners), np.concatenate(counts)


def _faces_of_strips(corners: np.ndarray, counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """An index below 0 restarts a strip."""
    ends = np.union1d(np.cumsum(counts), np.flatnonzero(corners < 0))
    faces = np.concatenate([strip_faces(part[part >= 0]) for part in np.split(corners, ends)])
    return faces.ravel(), np.full(len(faces), 3)
