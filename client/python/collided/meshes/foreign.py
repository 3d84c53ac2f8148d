"""Meshes of other libraries, none of which is needed: trimesh, meshio, and whatever looks like them."""

from __future__ import annotations

from typing import Any

import numpy as np

from collided.errors import InvalidArgument


def parts_of(source: Any) -> dict[str, Any]:
    """Vertices, triangles, edges and points of an object, as arguments of Mesh."""
    if hasattr(source, "vertices") and hasattr(source, "faces"):
        return {"vertices": source.vertices, "triangles": source.faces}
    if hasattr(source, "points") and hasattr(source, "cells_dict"):
        return _of_cells(source.points, source.cells_dict)
    if isinstance(source, (tuple, list)) and len(source) == 2 and _is_table(source[1]):
        return {"vertices": source[0], "triangles": source[1]}
    if isinstance(source, (np.ndarray, list)):
        return {"triangles": source}
    raise InvalidArgument(f"a mesh cannot be made of {type(source).__name__}: it must be a Mesh, a path, a pair "
                          "(vertices, triangles), triangles, or have vertices and faces, or points and cells_dict")


def _is_table(values: Any) -> bool:
    try:
        return np.ndim(values) == 2
    except ValueError:  # rows of several lengths
        return False


def _of_cells(points: Any, cells: dict[str, Any]) -> dict[str, Any]:
    """meshio's cells: triangles and quads are surfaces, lines loose edges, vertices loose points."""
    quads = np.reshape(cells.get("quad", ()), (-1, 4))
    triangles = [np.reshape(cells.get("triangle", ()), (-1, 3)), quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]
    known = {"triangle", "quad", "line", "vertex"}
    if not known & cells.keys():
        raise InvalidArgument(f"the mesh has cells {sorted(cells)}; it must have some of {sorted(known)}")
    return {"vertices": _in_space(np.asarray(points)), "triangles": np.concatenate(triangles).astype("<i8"),
            "edges": np.reshape(cells.get("line", ()), (-1, 2)).astype("<i8"),
            "points": np.reshape(cells.get("vertex", ()), (-1,)).astype("<i8")}


def _in_space(points: np.ndarray) -> np.ndarray:
    """Points of the plane are at z = 0."""
    return np.pad(points, ((0, 0), (0, 1))) if points.ndim == 2 and points.shape[1] == 2 else points
