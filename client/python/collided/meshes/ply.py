"""PLY, ASCII or binary of either byte order: positions of "vertex", corners of "face", strips of "tristrips"; all else is
skipped, and a note says so of what "edge" has and of what follows the last element."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from collided.meshes.polygons import ReadError
from collided.meshes.raw import RawMesh, count_text, fast_numbers, lines_of, number, strip_faces, text_of, whole, without_mark

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
    def lists(self) -> list[int]:
        """Numbers of the properties that are lists."""
        return [i for i, p in enumerate(self.properties) if p.count_type]

    @property
    def corners(self) -> int | None:
        """The property that lists a face's vertices."""
        is_face = self.name in ("face", "tristrips")
        return next((i for i in self.lists if is_face and self.properties[i].name in _CORNERS), None)

    def min_bytes(self, order: str) -> int:
        """The minimum size of a row."""
        return sum(np.dtype(p.count_type or p.type).itemsize if order else 1 for p in self.properties)


class _Body(Protocol):
    """Where the elements are read from. In its tables "0", "1" and so on are the properties, "n0" and so on lengths of lists."""

    unit: str  # of what is left: bytes or words

    @property
    def left(self) -> int:
        """Returns how much of the body is left."""

    def table(self, element: _Element, lengths: dict[int, int], most: int) -> np.ndarray:
        """The next rows, up to `most`, whose lists have these lengths. Does not move on."""

    def skip(self, element: _Element, lengths: dict[int, int], rows: int) -> None:
        """Moves on behind so many of them."""


def read_ply(data: bytes, _path: str) -> RawMesh:
    data = without_mark(data)
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
            if element.name == "edge" and element.count:
                mesh.notes.append(f"ignored {count_text(element.count, 'edge')}")
    if body.left:
        mesh.notes.append(f"ignored {count_text(body.left, body.unit)} after the last element")
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
    elements: list[_Element] = []
    order, body_at = None, 0
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
        if element.name in ("face", "tristrips") and element.count and element.corners is None:
            raise ReadError(f"element {element.name} lacks the list vertex_indices")
        if element.count and not element.properties:
            raise ReadError(f"element {element.name} has no properties")
        if element.count * element.min_bytes(order) > len(data) - body_at:
            raise ReadError(f"is cut off: {element.count} of element {element.name} do not fit in the "
                            f"{max(len(data) - body_at, 0)} bytes that follow the header")
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
        name = words[0].decode("latin-1")
        if any(element.name == name for element in elements):
            raise ReadError(f"the header has the element '{text_of(words[0])}' twice", place)
        elements.append(_Element(name, whole(words[1], place)))
    elif key == b"property":
        if not elements:
            raise ReadError("a property stands before any element", place)
        count_type = _type(words[1], place) if words[0] == b"list" else ""
        if count_type.startswith("f"):
            raise ReadError("a list's length must be an integer type", place)
        kind, property_name = words[2:4] if count_type else words[:2]
        _add_property(elements[-1], _Property(property_name.decode("latin-1"), _type(kind, place), count_type), place)
    elif key not in (b"comment", b"obj_info"):
        raise ReadError(f"'{text_of(key)}' is not a PLY keyword", place)
    return order


def _add_property(element: _Element, added: _Property, place: str) -> None:
    if not added.name:
        raise ReadError("the property has no name", place)
    if element.name in ("face", "tristrips") and added.count_type and added.name in _CORNERS:
        if added.type[0] == "f":
            raise ReadError(f"{added.name} must be of an integer type", place)
        if element.corners is not None:
            raise ReadError(f"element {element.name} has two lists of vertices", place)
    if any(known.name == added.name for known in element.properties):
        raise ReadError(f"element {element.name} has the property '{added.name[:40]}' twice", place)
    element.properties.append(added)


def _runs(body: _Body, element: _Element) -> Any:
    """Tables of successive rows whose lists have the same lengths; most files have one."""
    left, at_once = element.count if element.properties else 0, element.count
    while left > 0:
        lengths = {i: 0 for i in element.lists}
        for i in lengths:  # a list's place depends on the lengths of those before it
            lengths[i] = _length(body, element, body.table(element, lengths, 1)[f"n{i}"][0], element.count - left)
        rows = body.table(element, lengths, min(left, at_once))
        same = np.ones(len(rows), bool)
        for i, length in lengths.items():
            same &= rows[f"n{i}"] == length
        equal = len(rows) if same.all() else int(same.argmin())
        yield lengths, rows[:equal]
        body.skip(element, lengths, equal)
        left -= equal
        at_once = max(64, 2 * equal)  # where lengths alternate, few rows are looked at in vain


def _length(body: _Body, element: _Element, length: Any, row: int) -> int:
    """A list's length, checked."""
    if length != np.floor(length):
        raise ReadError(f"a list's length {_shown(length)} is not an integer", f": {element.name} {row}")
    if length < 0:
        raise ReadError(f"a list of {_shown(length)} does not fit in the file", f": {element.name} {row}")
    if length > body.left:
        raise _cut_off(element)
    return int(length)


def _cut_off(element: _Element) -> ReadError:
    return ReadError(f"is cut off within element {element.name}")


def _shown(value: Any) -> str:
    return repr(float(value)).removesuffix(".0")


def _dtype(element: _Element, lengths: dict[int, int], order: str) -> np.dtype:
    """Of a row whose lists have these lengths; of text ("") doubles hold every type exactly."""
    fields: list[Any] = []
    for i, p in enumerate(element.properties):
        kind = order + p.type if order else "f8"
        if p.count_type:
            fields.append((f"n{i}", order + p.count_type if order else "f8"))
            fields.append((str(i), kind, (lengths[i],)))
        else:
            fields.append((str(i), kind))
    return np.dtype(fields)


class _Binary(_Body):
    unit = "byte"

    def __init__(self, data: bytes, at: int, order: str) -> None:
        self._data, self._at, self._order = data, at, order

    @property
    def left(self) -> int:
        return len(self._data) - self._at

    def table(self, element: _Element, lengths: dict[int, int], most: int) -> np.ndarray:
        dtype = _dtype(element, lengths, self._order)
        rows = min(most, self.left // dtype.itemsize)
        if rows < 1:
            raise _cut_off(element)
        return np.frombuffer(self._data, dtype, rows, self._at)

    def skip(self, element: _Element, lengths: dict[int, int], rows: int) -> None:
        self._at += rows * _dtype(element, lengths, self._order).itemsize


class _Text(_Body):
    unit = "word"

    def __init__(self, data: bytes, at: int) -> None:
        words = data[at:].split()
        self._words, self._at = len(words), 0
        self._error: ReadError | None = None  # of the word behind the numbers
        numbers = fast_numbers(words, float)
        self._numbers = self._up_to_an_error(data, at) if numbers is None else numbers

    def _up_to_an_error(self, data: bytes, at: int) -> np.ndarray:
        numbers: list[float] = []
        try:
            for line_number, line in enumerate(lines_of(data[at:]), len(lines_of(data[:at]))):
                for word in line.split():
                    numbers.append(number(word, f":{line_number}"))
        except ReadError as error:
            self._error = error
        return np.array(numbers, "<f8")

    @property
    def left(self) -> int:
        return self._words - self._at

    def table(self, element: _Element, lengths: dict[int, int], most: int) -> np.ndarray:
        dtype = _dtype(element, lengths, "")
        width = dtype.itemsize // 8
        rows = min(most, (len(self._numbers) - self._at) // width)
        if rows < 1:
            raise self._error or _cut_off(element)
        return self._numbers[self._at:self._at + rows * width].view(dtype)

    def skip(self, element: _Element, lengths: dict[int, int], rows: int) -> None:
        self._at += rows * (_dtype(element, lengths, "").itemsize // 8)


def _vertices(body: _Body, element: _Element) -> np.ndarray:
    places = {p.name: str(i) for i, p in enumerate(element.properties) if not p.count_type}
    if not {"x", "y", "z"} <= places.keys():
        raise ReadError("element vertex lacks one of the properties x, y, z")
    tables = [np.stack([rows[places[axis]] for axis in "xyz"], axis=1) for _, rows in _runs(body, element)]
    vertices = np.concatenate(tables) if tables else np.empty((0, 3))
    return vertices.astype(vertices.dtype.newbyteorder("=")) if vertices.dtype.kind == "f" else vertices.astype("<f8")


def _corners(body: _Body, element: _Element) -> tuple[np.ndarray, np.ndarray]:
    """The vertices that all rows list, and how many each lists."""
    assert element.corners is not None
    name, length_of = str(element.corners), element.corners
    corners, counts, row = [np.empty(0, np.int64)], [np.empty(0, np.int64)], 0
    for lengths, rows in _runs(body, element):
        values = rows[name].reshape(-1)
        if values.dtype.kind == "f" and (broken := np.flatnonzero(values != np.floor(values))).size:  # of text
            raise ReadError(f"vertex index {_shown(values[broken[0]])} is not an integer",
                            f": {element.name} {row + broken[0] // lengths[length_of]}")
        if values.dtype.kind == "f":
            values = np.clip(values, -2.0 ** 62, 2.0 ** 62)
        corners.append(values.astype(np.int64))
        counts.append(np.full(len(rows), lengths[length_of]))
        row += len(rows)
    return np.concatenate(corners), np.concatenate(counts)


def _faces_of_strips(corners: np.ndarray, counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """An index below 0 restarts a strip."""
    ends = np.union1d(np.cumsum(counts), np.flatnonzero(corners < 0))
    faces = np.concatenate([strip_faces(part[part >= 0]) for part in np.split(corners, ends)])
    return faces.ravel(), np.full(len(faces), 3)
