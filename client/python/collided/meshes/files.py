"""Mesh files by their extension: the same set, read alike, as collidectl (client/scenes/mesh_files)."""

from __future__ import annotations

import pathlib
from collections.abc import Callable
from typing import Any

from collided.errors import InvalidArgument
from collided.meshes.dae import read_dae
from collided.meshes.gltf import read_gltf
from collided.meshes.obj import read_obj
from collided.meshes.off import read_off
from collided.meshes.ply import read_ply
from collided.meshes.polygons import ReadError
from collided.meshes.raw import RawMesh, contents
from collided.meshes.stl import read_stl

_READERS: dict[str, Callable[[bytes, str], RawMesh]] = {
    ".obj": read_obj, ".ply": read_ply, ".stl": read_stl, ".off": read_off, ".gltf": read_gltf, ".glb": read_gltf,
    ".dae": read_dae}
_EXTENSIONS = ".obj, .ply, .stl, .off, .gltf, .glb or .dae"


def read_mesh_file(path: str) -> dict[str, Any]:
    """Vertices and elements of a file, as arguments of Mesh."""
    reader = _READERS.get(pathlib.Path(path).suffix.lower())
    if reader is None:
        raise InvalidArgument(f"{path}: the extension must be {_EXTENSIONS}; Mesh.of takes what trimesh or meshio read")
    try:
        return reader(contents(path), path).finish()
    except ReadError as error:
        raise InvalidArgument(f"{path}{error.place}: {error}") from None
    except MemoryError:
        raise InvalidArgument(f"{path}: does not fit in memory") from None
    except ValueError as error:  # InvalidArgument, and numpy's own
        raise InvalidArgument(f"{path}: {getattr(error, 'message', error)}") from None
