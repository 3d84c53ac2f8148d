"""One question, one line."""

from __future__ import annotations

from typing import Any

import numpy as np

from collided.arrays import ids, points
from collided.contacts import Contacts
from collided.errors import InvalidArgument
from collided.meshes import Mesh
from collided.session import Session


def detect(V0: Any, V1: Any, F: Any = None, *, edges: Any = None, particles: Any = None, **options: Any) -> Contacts:
    """What meets while vertices move from V0 to V1 on straight lines, at constant speed.

    V0, V1: positions (n, 3) at t = 0 and t = 1, in any unit; float32 as such, all else as float64.
    F: triangles (m, 3); edges: loose edges (m, 2); particles: loose points (m,). One of them or more.
    options: those of SceneOptions but `mode`, such as thickness=1e-3 and accuracy="exact", and of ConnectOptions; server: a
        daemon, by default $COLLIDED_SERVER or one that this process starts once and keeps.

    Raises InvalidArgument for arrays that cannot be, and what the daemon refuses them with, such as NaN.
    """
    start = points(V0, "V0")
    end = points(V1, "V1", len(start))
    return _ask(start, end, F, edges, particles, _of_mode("ccd", options))


def proximity(V: Any, F: Any = None, *, thickness: float, edges: Any = None, particles: Any = None,
              **options: Any) -> Contacts:
    """What is within `thickness` of each other where the vertices V are; arguments as of `detect`."""
    return _ask(None, points(V, "V"), F, edges, particles, {**_of_mode("dcd", options), "thickness": thickness})


def _of_mode(mode: str, options: dict[str, Any]) -> dict[str, Any]:
    if options.setdefault("mode", mode) != mode:
        raise InvalidArgument(f"mode is {options['mode']!r}; detect() is always 'ccd' and proximity() 'dcd'", field="mode")
    return options


def _ask(start: np.ndarray | None, end: np.ndarray, triangles: Any, edges: Any, particles: Any,
         options: dict[str, Any]) -> Contacts:
    if triangles is None and edges is None and particles is None:
        raise InvalidArgument("there are no triangles, edges or particles; one of them is needed", field="F")
    for values, argument, columns in ((triangles, "F", 3), (edges, "edges", 2), (particles, "particles", 0)):
        if values is not None:
            ids(values, argument, columns)
    mesh = Mesh(triangles=triangles, edges=edges, points=particles, vertex_count=len(end), name="mesh")
    is_single = all(array is None or array.dtype == np.float32 for array in (start, end))
    if "position_format" not in options:
        options["position_format"] = "f32" if is_single else "f64"
    with Session(mesh, **options) as session:
        return session.step(end, start)
