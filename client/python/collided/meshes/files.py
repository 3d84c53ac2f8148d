"""Mesh files by their extension."""

from __future__ import annotations

import pathlib
from typing import Any

from collided.errors import InvalidArgument
from collided.meshes.obj import read_obj
from collided.meshes.ply import read_ply

_READERS = {".obj": read_obj, ".ply": read_ply}


def read_mesh_file(path: str) -> dict[str, Any]:
    """Vertices and elements of a file, as arguments of Mesh."""
    reader = _READERS.get(pathlib.Path(path).suffix.lower())
    if reader is None:
        raise InvalidArgument(f"{path}: the extension must be .obj or .ply")
    try:
        return reader(pathlib.Path(path).read_bytes())
    except ValueError as error:  # InvalidArgument, and numpy's own
        raise InvalidArgument(f"{path}: {getattr(error, 'message', error)}") from None
