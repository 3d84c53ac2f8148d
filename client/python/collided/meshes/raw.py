"""What the readers of all formats share: lines, numbers, and how faces as a file has them become triangles."""

from __future__ import annotations

import codecs
import os
import re
import stat
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from collided.meshes.polygons import ReadError, triangulate


_MAX_BYTES = 8 << 30
_WITHOUT_WAITING: int = getattr(os, "O_NONBLOCK", 0)  # Windows has neither it nor FIFOs in its file system
_MAX_FAST = 64  # bytes of a word
_ZEROS = re.compile(rb"([+-]?)0*(?=[0-9]+$)")


def contents(path: str) -> bytes:
    # Opened without waiting, as a FIFO may have no writer; and asked once it is open, as the path may be another file by then.
    with open(path, "rb", opener=lambda name, flags: os.open(name, flags | _WITHOUT_WAITING)) as file:
        about = os.fstat(file.fileno())
        if not stat.S_ISREG(about.st_mode):
            raise ReadError("it is not a regular file")
        if about.st_size > _MAX_BYTES:
            raise ReadError(f"it has {about.st_size} bytes; the limit is {_MAX_BYTES}")
        return file.read()


def no_rows(columns: int) -> np.ndarray:
    return np.empty((0, columns), np.int64)


@dataclass
class RawMesh:
    """Faces, edges and points as a reader found them, before anything is checked."""

    vertices: np.ndarray = field(default_factory=lambda: np.empty((0, 3)))
    corners: np.ndarray = field(default_factory=lambda: np.empty(0, np.int64))
    counts: np.ndarray = field(default_factory=lambda: np.empty(0, np.int64))  # corners of each face
    lines: np.ndarray | None = None  # of the file, for each face; None if the format has no lines
    edges: np.ndarray = field(default_factory=lambda: no_rows(2))
    points: np.ndarray = field(default_factory=lambda: np.empty(0, np.int64))
    notes: list[str] = field(default_factory=list)

    def place(self, face: int) -> str:
        return f": face {face}" if self.lines is None else f":{self.lines[face]}"

    def finish(self) -> dict[str, Any]:
        """Arguments of Mesh: indices are checked, repeated corners dropped, faces split."""
        self._check()
        self._drop_repeated_corners()
        triangles = triangulate(self.vertices, self.corners, self.counts, self.place)
        is_loose = len(self.edges) or len(self.points)
        if len(self.vertices) < 3 and not is_loose:
            raise ReadError(f"has {count_text(len(self.vertices), 'vertex', 'vertices')}; a mesh needs 3")
        if not len(triangles) and not is_loose:
            raise ReadError("has no faces")
        return {"vertices": self.vertices, "triangles": triangles, "edges": self.edges, "points": self.points,
                "notes": tuple(self.notes)}

    def _check(self) -> None:
        bad = np.flatnonzero(~np.isfinite(self.vertices).all(axis=1))
        if bad.size:
            raise ReadError(f"vertex {bad[0]} has a position that is not finite")
        few = np.flatnonzero(self.counts < 3)
        if few.size:
            raise ReadError(f"the face has {count_text(int(self.counts[few[0]]), 'corner')}; it needs 3", self.place(few[0]))
        n = len(self.vertices)
        self._check_below(n, self.corners, lambda i: self.place(int(np.searchsorted(np.cumsum(self.counts), i, "right"))))
        self._check_below(n, self.edges.ravel(), lambda i: f": edge {i // 2}")
        self._check_below(n, self.points, lambda i: f": point {i}")

    @staticmethod
    def _check_below(n: int, values: np.ndarray, place: Callable[[int], str]) -> None:
        bad = np.flatnonzero((values < 0) | (values >= n))
        if bad.size:
            raise ReadError(f"vertex index {values[bad[0]]} is out of range; {vertices_there(n)}", place(int(bad[0])))

    def _drop_repeated_corners(self) -> None:
        """Drops corners that equal the next one, and faces that then have fewer than three."""
        if not self.counts.size:
            return
        starts = np.cumsum(self.counts) - self.counts
        following = np.append(self.corners[1:], 0)
        following[starts + self.counts - 1] = self.corners[starts]
        is_kept = self.corners != following
        if is_kept.all():
            return
        left = np.add.reduceat(is_kept.astype(np.int64), starts)
        is_face = left >= 3
        corners, faces = int((self.counts - left)[is_face].sum()), int((~is_face).sum())
        if corners:
            self.notes.append(f"dropped {count_text(corners, 'repeated corner')}")
        if faces:
            self.notes.append(f"dropped {count_text(faces, 'face')} with fewer than 3 different corners")
        self.corners = self.corners[is_kept & np.repeat(is_face, self.counts)]
        self.counts = left[is_face]
        if self.lines is not None:
            self.lines = self.lines[is_face]


def weld(vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vertices without those that equal an earlier one, and the new index of each. -0 and 0 are one position."""
    rows = np.ascontiguousarray(vertices.astype("<f8") + 0.0).view("V24").ravel()
    _, first, inverse = np.unique(rows, return_index=True, return_inverse=True)
    order = np.argsort(first)  # in which they come in the file
    place = np.empty(len(order), np.int64)
    place[order] = np.arange(len(order))
    return vertices[first[order]], place[inverse.ravel()]


def lines_of(data: bytes) -> list[bytes]:
    """Lines, which end with LF, CR LF, or CR alone."""
    if b"\r" in data:
        data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    return data.split(b"\n")


def without_mark(data: bytes) -> bytes:
    """The text without UTF-8's byte order mark, as editors on Windows write it."""
    return data.removeprefix(codecs.BOM_UTF8)


def text_of(word: bytes) -> str:
    return word[:40].decode("utf-8", "replace").replace("\0", "\ufffd")


def number(word: bytes, place: str, kind: Callable[[bytes], Any] = float) -> Any:
    """The number that a word spells; Python's own spellings, such as 1_000, are none."""
    if not word:
        raise ReadError("a number is missing", place)
    try:
        if b"_" in word or word.strip() != word:
            raise ValueError
        if kind is int and len(word) > _MAX_FAST and _ZEROS.match(word):  # which int() takes few of
            word = _ZEROS.sub(rb"\1", word)[:_MAX_FAST]
        return kind(word)
    except ValueError:
        raise ReadError(f"'{text_of(word)}' is not a number", place) from None


def whole(word: bytes, place: str, limit: int = 2 ** 64) -> int:
    """A number from 0 up to the limit."""
    value = number(word, place, int)
    if b"-" in word:
        raise ReadError(f"'{text_of(word)}' is not a number", place)
    if value >= limit:
        raise ReadError(f"number {text_of(word)} is out of range", place)
    return int(value)


def fast_numbers(words: list[bytes], kind: type) -> np.ndarray | None:
    """The numbers of all words at once; None if one of them may be none, or is so long that an array of equal words were large."""
    text = b" ".join(words)
    if b"_" in text or b"\0" in text or max(map(len, words), default=0) > _MAX_FAST:
        return None
    try:
        return np.array(words, "S").astype("<f8" if kind is float else np.int64)
    except (ValueError, OverflowError):
        return None


def coordinate(word: bytes, place: str) -> float:
    value = number(word, place)
    if value - value != 0:
        raise ReadError(f"position {text_of(word)} is not finite" if b"n" in word.lower() else
                        f"number {text_of(word)} is out of range", place)
    return value


def divided(vertex: list[float], w: float, place: str) -> list[float]:
    """A homogeneous position divided by its w."""
    if w == 0:
        raise ReadError("w is 0: the vertex is at infinity", place)
    if w - w != 0:
        raise ReadError("w is not finite", place)
    vertex = [x / w for x in vertex]
    if any(x - x != 0 for x in vertex):
        raise ReadError("the position divided by its w is not finite", place)
    return vertex


def float_table(rows: list[list[bytes]], lines: Iterable[int]) -> np.ndarray:
    """Coordinates, a row each of one length; slow only where a word must be named."""
    table = fast_numbers([word for row in rows for word in row], float)
    if table is not None and np.isfinite(table).all():
        return table.reshape(len(rows), -1)
    return np.array([[coordinate(word, f":{line}") for word in row] for row, line in zip(rows, lines)])


def strip_faces(strip: np.ndarray) -> np.ndarray:
    """Triangles of a strip; every other one turns round."""
    if len(strip) < 3:
        return no_rows(3)
    faces = np.stack([strip[:-2], strip[1:-1], strip[2:]], axis=1)
    faces[1::2, :2] = faces[1::2, 1::-1]
    return faces


def fan_faces(fan: np.ndarray) -> np.ndarray:
    return np.stack([np.repeat(fan[:1], max(len(fan) - 2, 0)), fan[1:-1], fan[2:]], axis=1) if len(fan) > 2 else no_rows(3)


def count_text(count: int, noun: str, plural: str = "") -> str:
    return f"{count} {noun if count == 1 else plural or noun + 's'}"


def vertices_there(count: int) -> str:
    return f"there {'is' if count == 1 else 'are'} {count_text(count, 'vertex', 'vertices')}"
