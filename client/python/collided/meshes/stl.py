"""STL, ASCII (of one or more solids) or binary. Each facet brings its own corners: equal ones are welded into one vertex."""

from __future__ import annotations

import numpy as np

from collided.meshes.polygons import ReadError
from collided.meshes.raw import RawMesh, coordinate, count_text, lines_of, text_of, weld, without_mark

_HEADER_BYTES = 84
_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attributes", "<u2")])


def read_stl(data: bytes, _path: str) -> RawMesh:
    mesh = _binary(data) if _is_binary(data) else _Ascii(without_mark(data)).read()
    corners = len(mesh.vertices)
    mesh.vertices, mesh.corners = weld(mesh.vertices)
    if len(mesh.vertices) < corners:
        mesh.notes.append(f"welded {count_text(corners, 'corner')} into {count_text(len(mesh.vertices), 'vertex', 'vertices')}")
    return mesh


def _is_binary(data: bytes) -> bool:
    """Binary files may begin with "solid" as well."""
    if len(data) >= _HEADER_BYTES and len(data) == _HEADER_BYTES + 50 * int.from_bytes(data[80:84], "little"):
        return True
    head = without_mark(data[:512]).lstrip()
    return head[:5].lower() != b"solid" or b"\0" in head


def _binary(data: bytes) -> RawMesh:
    if len(data) < _HEADER_BYTES:
        raise ReadError(f"is cut off, or no STL: it has {count_text(len(data), 'byte')}; the header alone has 84")
    facets = int.from_bytes(data[80:84], "little")
    end = _HEADER_BYTES + 50 * facets
    if len(data) < end:
        raise ReadError(f"is cut off, or no STL: its {count_text(facets, 'facet')} need {end} bytes; it has {len(data)}")
    corners = np.frombuffer(data, _FACET, facets, _HEADER_BYTES)["corners"]
    bad = np.flatnonzero(~np.isfinite(corners).all(axis=(1, 2)))
    if bad.size:
        raise ReadError("a position is not finite", f": facet {bad[0]}")
    mesh = RawMesh(vertices=corners.reshape(-1, 3).astype("<f4"), counts=np.full(facets, 3))
    if len(data) > end:
        mesh.notes.append(f"ignored {count_text(len(data) - end, 'byte')} after the last facet")
    return mesh


class _Ascii:
    def __init__(self, data: bytes) -> None:
        self._lines = lines_of(data)
        self._number = 0  # lines that were taken
        self._words: list[bytes] = []  # that are left of the last one, in reverse

    def read(self) -> RawMesh:
        vertices: list[list[float]] = []
        counts: list[int] = []
        lines: list[int] = []
        is_open = False
        while word := self._next():
            match word.lower():
                case b"facet":
                    lines.append(self._loop_begins())
                    counts.append(self._corners(vertices))
                case b"solid" | b"endsolid":
                    is_open = word.lower() == b"solid"
                    self._words.clear()  # the name
                case _:
                    raise ReadError(f"'{text_of(word)}' is not an STL keyword", self._place)
        if is_open:
            raise ReadError("is cut off: 'endsolid' is missing")
        return RawMesh(vertices=np.array(vertices, "<f8").reshape(-1, 3), counts=np.array(counts, np.int64), lines=np.array(lines))

    @property
    def _place(self) -> str:
        return f":{self._number}"

    def _next(self) -> bytes:
        """The next word; empty at the end of the file."""
        while True:
            if self._words:
                word = self._words.pop()
                if not word.startswith(b"#"):
                    return word
                self._words.clear()
            if self._number == len(self._lines):
                return b""
            self._words = self._lines[self._number].split()[::-1]
            self._number += 1

    def _expect(self, keyword: str) -> None:
        word = self._next()
        if not word:
            raise ReadError(f"is cut off: '{keyword}' is missing")
        if word.lower() != keyword.encode():
            raise ReadError(f"'{text_of(word)}' stands where '{keyword}' must", self._place)

    def _loop_begins(self) -> int:
        """The line where it does."""
        self._expect("normal")
        for _ in range(3):
            self._next()
        self._expect("outer")
        self._expect("loop")
        return self._number

    def _corners(self, vertices: list[list[float]]) -> int:
        count = 0
        while (word := self._next()).lower() != b"endloop":
            if not word:
                raise ReadError("is cut off: 'endloop' is missing")
            if word.lower() != b"vertex":
                raise ReadError(f"'{text_of(word)}' stands where 'vertex' or 'endloop' must", self._place)
            vertices.append([coordinate(self._next(), self._place) for _ in range(3)])
            count += 1
        self._expect("endfacet")
        return count
