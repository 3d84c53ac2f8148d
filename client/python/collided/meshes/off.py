"""OFF: a keyword with prefixes (ST, C, N, 4), three counts, a vertex a line, a face a line; '#' begins a comment. Normals,
colours and texture coordinates are skipped."""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np

from collided.meshes.polygons import ReadError
from collided.meshes.raw import RawMesh, coordinate, count_text, divided, lines_of, number, text_of, whole, without_mark

_KEYWORD = re.compile(rb"(ST)?C?N?(4?)OFF")


def read_off(data: bytes, _path: str) -> RawMesh:
    data = without_mark(data)
    lines = _full_lines(data)
    at, words = next(lines, (0, []))
    has_w = False
    if words and words[0].endswith(b"OFF"):
        if not (match := _KEYWORD.fullmatch(words[0])):
            raise ReadError(f"'{text_of(words[0])}' is a kind of OFF that is not read")
        if words[1:2] == [b"BINARY"]:
            raise ReadError("binary OFF is not read")
        has_w = bool(match[2])
        at, words = (at, words[1:]) if len(words) > 1 else next(lines, (at, []))
    elif not words or not words[0][:1].isdigit():
        raise ReadError("does not begin with 'OFF'")
    vertex_count, face_count = (_whole(words, i, at) for i in (0, 1))
    if len(words) > 3:
        raise ReadError("more than three counts are in this line; each vertex and face must have a line of its own", f":{at}")
    for count, what in ((vertex_count, "vertices"), (face_count, "faces")):
        if 5 * count > len(data):
            raise ReadError(f"is cut off: {count} {what} do not fit in the {len(data)} bytes of the file")
    vertices = [_vertex(words, has_w, f":{at}") for at, words in _exactly(lines, vertex_count, "vertex")]
    corners: list[int] = []
    counts, face_lines = [], []
    for at, words in _exactly(lines, face_count, "face"):
        counts.append(_whole(words, 0, at))
        if counts[-1] >= len(words):
            raise ReadError("a number is missing", f":{at}")
        corners.extend(_whole(words, i, at) for i in range(1, counts[-1] + 1))
        face_lines.append(at)
    ignored = sum(1 for _ in lines)
    notes = [f"ignored {count_text(ignored, 'line')} after the last face"] if ignored else []
    return RawMesh(notes=notes, vertices=np.array(vertices, "<f8").reshape(-1, 3), corners=np.array(corners, np.int64),
                   counts=np.array(counts, np.int64), lines=np.array(face_lines))


def _full_lines(data: bytes) -> Iterator[tuple[int, list[bytes]]]:
    """Number and words of each line that has words, without its comment."""
    for number_, line in enumerate(lines_of(data), 1):
        if words := line.split(b"#", 1)[0].split():
            yield number_, words


def _exactly(lines: Iterator[tuple[int, list[bytes]]], count: int, what: str) -> Iterator[tuple[int, list[bytes]]]:
    for i in range(count):
        line = next(lines, None)
        if line is None:
            raise ReadError(f"is cut off: {what} {i} of {count} is missing")
        yield line


def _whole(words: list[bytes], i: int, at: int) -> int:
    return whole(words[i] if i < len(words) else b"", f":{at}", 2 ** 32)


def _vertex(words: list[bytes], has_w: bool, place: str) -> list[float]:
    words = words + [b""] * 4
    vertex = [coordinate(word, place) for word in words[:3]]
    return divided(vertex, number(words[3], place), place) if has_w else vertex
