"""What an object looks like at a frame: the triangles, loose edges and loose vertices of its evaluated mesh, in the world."""

from dataclasses import dataclass

import numpy as np

from .refused import Refused

KINDS = {"MESH", "CURVE", "SURFACE", "FONT", "META"}


@dataclass(frozen=True, eq=False)
class Shape:
    """vertices: float64[n][3], world space. triangles: int32[m][3]; polygons: int32[m], the face that each is of. edges,
    points: loose ones. corners, starts: vertices of all faces, and where in them each face begins."""

    vertices: np.ndarray
    triangles: np.ndarray
    polygons: np.ndarray
    edges: np.ndarray
    points: np.ndarray
    corners: np.ndarray
    starts: np.ndarray

    @property
    def is_empty(self):
        return not (len(self.triangles) or len(self.edges) or len(self.points))

    def has_elements_of(self, other):
        """Whether it has the same elements, so that only its vertices have moved."""
        return len(self.vertices) == len(other.vertices) and all(
            np.array_equal(getattr(self, name), getattr(other, name)) for name in ("triangles", "edges", "points"))


def shape_of(thing, depsgraph):
    """The shape of an object with its modifiers, at the graph's frame. Raises Refused."""
    evaluated = thing.evaluated_get(depsgraph)
    mesh = evaluated.to_mesh()
    try:
        return _shape(thing, mesh, np.array(evaluated.matrix_world, np.float64))
    finally:
        evaluated.to_mesh_clear()


def _shape(thing, mesh, world):
    local = _values(mesh.vertices, "co", np.float32, 3).astype(np.float64)
    vertices = local @ world[:3, :3].T + world[:3, 3]
    bad = np.flatnonzero(~np.isfinite(vertices).all(axis=1))
    if bad.size:
        raise Refused(f"{thing.name}: the position of vertex {bad[0]} is not finite")
    mesh.calc_loop_triangles()
    ends = _values(mesh.edges, "vertices", np.int32, 2)
    corners = _values(mesh.loops, "vertex_index", np.int32)
    is_loose = np.ones(len(ends), bool)
    is_loose[_values(mesh.loops, "edge_index", np.int32)] = False
    is_point = np.ones(len(vertices), bool)
    is_point[ends.reshape(-1)] = False
    is_point[corners] = False
    return Shape(vertices, _values(mesh.loop_triangles, "vertices", np.int32, 3),
                 _values(mesh.loop_triangles, "polygon_index", np.int32), ends[is_loose], np.flatnonzero(is_point), corners,
                 _values(mesh.polygons, "loop_start", np.int32))


def has_faces_of(mesh, shape):
    """Whether vertices and faces of a shape have the same numbers in an object's own mesh: no modifier made others."""
    return (len(mesh.vertices) == len(shape.vertices) and
            np.array_equal(_values(mesh.loops, "vertex_index", np.int32), shape.corners) and
            np.array_equal(_values(mesh.polygons, "loop_start", np.int32), shape.starts))


def _values(collection, name, dtype, width=1):
    out = np.empty(len(collection) * width, dtype)
    collection.foreach_get(name, out)
    return out.reshape(-1, width) if width > 1 else out
