"""Kernels of NVIDIA Warp that ask a mesh for signed distances, NaN where it has none within the limit."""

import warp as wp


@wp.func
def signed_distance(mesh: wp.uint64, found: wp.MeshQueryPoint, point: wp.vec3):
    if not found.result:
        return wp.nan
    return found.sign * wp.length(wp.mesh_eval_position(mesh, found.face, found.u, found.v) - point)


@wp.kernel
def by_normal(mesh: wp.uint64, points: wp.array(dtype=wp.vec3), limit: float, distances: wp.array(dtype=float)):
    i = wp.tid()
    distances[i] = signed_distance(mesh, wp.mesh_query_point_sign_normal(mesh, points[i], limit), points[i])


@wp.kernel
def by_winding_number(mesh: wp.uint64, points: wp.array(dtype=wp.vec3), limit: float, distances: wp.array(dtype=float)):
    i = wp.tid()
    distances[i] = signed_distance(mesh, wp.mesh_query_point_sign_winding_number(mesh, points[i], limit), points[i])


@wp.kernel
def by_parity(mesh: wp.uint64, points: wp.array(dtype=wp.vec3), limit: float, distances: wp.array(dtype=float)):
    i = wp.tid()
    distances[i] = signed_distance(mesh, wp.mesh_query_point_sign_parity(mesh, points[i], limit), points[i])
