"""What other libraries answer of two meshes, each called as its documentation advises.

A lane has `build(first, second)` and `ask(built)`, which returns an Answer. Its module is imported when the lane is made.
"""

import importlib
import importlib.util
from dataclasses import dataclass, field

import numpy as np

_INFINITE = 1e9  # farther than anything here, for queries that want a limit


@dataclass
class Answer:
    """inside, depths: of the vertices of (second in first, first in second). depths hold what is inside, above 0, and NaN where the
    library says nothing. state, deepest: of the pair; None
    where it does not say."""

    inside: list = field(default_factory=list)
    depths: list = field(default_factory=list)
    state: str | None = None
    deepest: float | None = None


class Lane:
    """library: a distribution. modules: the one to import, and others that it needs. keeps_tree: a second question of the same meshes needs
    no new tree. one_in: of the balls' vertices one in so many is asked, where more would take minutes."""

    library, name = "", ""
    modules = ()
    keeps_tree, one_in = True, 1
    answers = ("inside", "depth")

    def __init__(self):
        self.imported = importlib.import_module(self.modules[0])

    @classmethod
    def is_installed(cls):
        return all(importlib.util.find_spec(module) for module in cls.modules)

    def build(self, first, second, one_in=1):
        """Returns what the questions need of each mesh that has triangles, with the vertices to ask it for: one in so many."""
        pairs = [(first, second), (second, first)] if len(second.triangles) else [(first, second)]
        return [(self.prepare(solid), np.ascontiguousarray(points.vertices[::one_in])) for solid, points in pairs]

    def ask(self, built):
        answer = Answer()
        for solid, points in built:
            inside, depths = self.query(solid, points)
            answer.inside.append(inside)
            answer.depths.append(depths)
        return answer

    def close(self, built):
        """Ends what `build` returned. Memory alone ends by itself."""


class _Igl(Lane):
    library, modules, keeps_tree = "libigl", ("igl",), False

    def prepare(self, solid):
        return np.ascontiguousarray(solid.vertices), np.ascontiguousarray(solid.triangles.astype(np.int64))


class _IglSigned(_Igl):
    sign = ""

    def query(self, solid, points):
        core = importlib.import_module("igl.pyigl_core")
        sign = getattr(core, f"SIGNED_DISTANCE_TYPE_{self.sign}")
        distances = self.imported.signed_distance(points, *solid, sign)[0]
        return distances < 0, -distances


class IglWinding(_IglSigned):
    name, sign = "signed_distance, WINDING_NUMBER", "WINDING_NUMBER"


class IglFast(_IglSigned):
    name, sign = "signed_distance, FAST_WINDING_NUMBER", "FAST_WINDING_NUMBER"


class IglPseudonormal(_IglSigned):
    name, sign = "signed_distance, PSEUDONORMAL", "PSEUDONORMAL"


class IglInside(_Igl):
    name = "fast_winding_number, then AABB of those inside"

    def query(self, solid, points):
        inside = self.imported.fast_winding_number(*solid, points) > 0.5
        depths = np.full(len(points), np.nan)
        if inside.any():
            tree = self.imported.AABB()
            tree.init(*solid)
            depths[inside] = np.sqrt(tree.squared_distance(*solid, points[inside])[0])
        return inside, depths


class _Trimesh(Lane):
    library, modules = "trimesh", ("trimesh", "rtree")

    def prepare(self, solid):
        return self.imported.Trimesh(solid.vertices, solid.triangles, process=False)


class TrimeshSigned(_Trimesh):
    name, one_in = "proximity.signed_distance", 200

    def query(self, solid, points):
        distances = self.imported.proximity.signed_distance(solid, points)
        return distances > 0, distances


class TrimeshInside(_Trimesh):
    name = "contains, then closest_point of those inside"

    def query(self, solid, points):
        inside = solid.contains(points)
        depths = np.full(len(points), np.nan)
        if inside.any():
            depths[inside] = self.imported.proximity.closest_point(solid, points[inside])[1]
        return inside, depths


class Fcl(Lane):
    """Convex meshes are volumes, others skins: hierarchies of triangles. deepest: the greatest penetration_depth of the contacts."""

    library, modules, name = "python-fcl", ("fcl", "trimesh"), "trimesh.collision.CollisionManager"
    answers = ("state", "deepest")

    def __init__(self):
        super().__init__()
        self.trimesh = importlib.import_module("trimesh")

    def build(self, first, second, one_in=1):
        if not len(second.triangles):
            return None
        manager = self.trimesh.collision.CollisionManager()
        for name, shape in (("first", first), ("second", second)):
            manager.add_object(name, self.trimesh.Trimesh(shape.vertices, shape.triangles, process=False))
        return manager

    def ask(self, built):
        if built is None:
            return Answer()
        collides, contacts = built.in_collision_internal(return_data=True)
        return Answer(state="not apart" if collides else "apart", deepest=max((contact.depth for contact in contacts), default=0.0))


class _Warp(Lane):
    """On the CPU, in single precision, as Warp's meshes are."""

    library, modules, kernel = "warp-lang", ("warp",), ""
    needs_winding_number = False

    def __init__(self):
        super().__init__()
        self.imported.config.quiet = True
        self.imported.init()
        self.kernels = importlib.import_module("warp_kernels")

    def prepare(self, solid):
        wp = self.imported
        return wp.Mesh(wp.array(solid.vertices.astype(np.float32), dtype=wp.vec3, device="cpu"),
                       wp.array(solid.triangles.astype(np.int32).ravel(), dtype=wp.int32, device="cpu"),
                       support_winding_number=self.needs_winding_number)

    def query(self, solid, points):
        wp = self.imported
        distances = wp.empty(len(points), dtype=wp.float32, device="cpu")
        at = wp.array(points.astype(np.float32), dtype=wp.vec3, device="cpu")
        wp.launch(getattr(self.kernels, self.kernel), dim=len(points), inputs=[solid.id, at, _INFINITE], outputs=[distances], device="cpu")
        found = distances.numpy().astype(float)
        return found < 0, -found


class WarpNormal(_Warp):
    name, kernel = "mesh_query_point_sign_normal", "by_normal"


class WarpWinding(_Warp):
    name, kernel, needs_winding_number = "mesh_query_point_sign_winding_number", "by_winding_number", True


class WarpParity(_Warp):
    name, kernel = "mesh_query_point_sign_parity", "by_parity"


LANES = (IglWinding, IglFast, IglPseudonormal, IglInside, TrimeshSigned, TrimeshInside, Fcl, WarpNormal, WarpWinding, WarpParity)
