"""Mesh files by their extension."""

from __future__ import annotations

import os
import pathlib
import stat
from typing import Any

from collided.errors import InvalidArgument
from collided.meshes.obj import read_obj
from collided.meshes.ply import read_ply

_MAX_BYTES = 8 << 30
_READERS = {".obj": read_obj, ".ply": read_ply}


def read_mesh_file(path: str) -> dict[str, Any]:
    """Vertices and elements of a file, as arguments of Mesh."""
    reader = _READERS.get(pathlib.Path(path).suffix.lower())
    if reader is None:
        raise InvalidArgument(f"{path}: the extension must be .obj or .ply")
    try:
        return reader(_contents(path))
    except ValueError as error:  # InvalidArgument, and numpy's own
        raise InvalidArgument(f"{path}: {getattr(error, 'message', error)}") from None


def _contents(path: str) -> bytes:
    # Opened without waiting, as a FIFO may have no writer; and asked once it is open, as the path may be another file by then.
    with open(path, "rb", opener=lambda name, flags: os.open(name, flags | os.O_NONBLOCK)) as file:
        about = os.fstat(file.fileno())
        if not stat.S_ISREG(about.st_mode):
            raise InvalidArgument("it is not a regular file")
        if about.st_size > _MAX_BYTES:
            raise InvalidArgument(f"it has {about.st_size} bytes; the limit is {_MAX_BYTES}")
        return file.read()
