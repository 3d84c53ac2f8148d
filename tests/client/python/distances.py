"""Distances of pairs of features, a row each, in binary64."""

import numpy as np


def _dot(u, v):
    return (u * v).sum(axis=-1)


def _vertex_edge(p, a, b):
    along = b - a
    with np.errstate(divide="ignore", invalid="ignore"):
        t = np.nan_to_num(_dot(p - a, along) / _dot(along, along)).clip(0, 1)
    return np.linalg.norm(p - a - t[:, None] * along, axis=-1)


def vertex_triangle(x):
    """Distances between vertex 0 and the triangle of the others: x is float64[n][4][3], the result float64[n]."""
    p, a, b, c = np.moveaxis(x, 1, 0)
    least = np.min([_vertex_edge(p, *edge) for edge in ((a, b), (b, c), (c, a))], axis=0)
    normal = np.cross(b - a, c - a)
    inside = np.all([_dot(np.cross(end - begin, p - begin), normal) > 0 for begin, end in ((a, b), (b, c), (c, a))], axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        height = abs(_dot(p - a, normal)) / np.linalg.norm(normal, axis=-1)
    return np.where(inside, height, least)


def edge_edge(x):
    """Distances between the edge of vertices 0 and 1 and that of the others: x is float64[n][4][3], the result float64[n]."""
    a, b, c, d = np.moveaxis(x, 1, 0)
    least = np.min([_vertex_edge(*ends) for ends in ((a, c, d), (b, c, d), (c, a, b), (d, a, b))], axis=0)
    u, v, w = b - a, d - c, a - c
    uu, uv, vv, uw, vw = _dot(u, u), _dot(u, v), _dot(v, v), _dot(u, w), _dot(v, w)
    with np.errstate(divide="ignore", invalid="ignore"):
        s, t = (uv * vw - vv * uw) / (uu * vv - uv * uv), (uu * vw - uv * uw) / (uu * vv - uv * uv)
    inside = (s > 0) & (s < 1) & (t > 0) & (t < 1)
    return np.where(inside, np.linalg.norm(w + np.nan_to_num(s)[:, None] * u - np.nan_to_num(t)[:, None] * v, axis=-1), least)
