"""Clients whose frames are allowed, and as costly as frames can be."""

import numpy as np

import collided

from attacks.calls import in_threads
from attacks.catalogue import attack


def soup(count, size, seed=1):
    """Triangles that share no vertices, all within `size`."""
    vertices = np.random.default_rng(seed).uniform(-size, size, (3 * count, 3))
    return vertices, np.arange(3 * count).reshape(-1, 3)


def stream(target, told, over, vertices, triangles, moved, **options):
    with collided.Session({"hostile": collided.Mesh(vertices, triangles)}, server=target.address, token=target.token,
                          window=8, transport="grpc", reconnect_seconds=0, **options) as session:
        for i in range(1 << 30):
            while session.in_flight >= session.window:
                if over.is_set():
                    return
                try:
                    session.receive(timeout=0.2)
                    told["frames"] += 1
                except collided.DeadlineExceeded:
                    pass
            session.send(moved if i % 2 else vertices)
            told["sent"] += 1


@attack("scenes")
def one_cell(target, told, over):
    """All triangles in one cell, and each moves through the others."""
    vertices, triangles = soup(400, 1e-3)
    spread = np.array([[1e3, 0, 0], [0, 1e3, 0], [0, 0, 1e3]])  # one triangle far away makes the cells large
    vertices = np.vstack([vertices, spread])
    triangles = np.vstack([triangles, [[1200, 1201, 1202]]])
    stream(target, told, over, vertices, triangles, vertices[::-1].copy())


@attack("scenes")
def all_pairs_touch(target, told, over):
    """Triangles that all share one point in space."""
    vertices, triangles = soup(300, 1)
    vertices[::3] *= 1e-9
    stream(target, told, over, vertices, triangles, -vertices, thickness=0.01)


def far_apart(count):
    vertices, triangles = soup(count, 1)
    return vertices * 2.0 ** np.random.default_rng(2).integers(-200, 20, vertices.shape), triangles


@attack("scenes")
def exponents_far_apart(target, told, over):
    """Numbers that exact arithmetic needs many words for."""
    vertices, triangles = far_apart(60)
    stream(target, told, over, vertices, triangles, -vertices, accuracy="exact")


@attack("scenes")
def long_exact_frames(target, told, over):
    """Four scenes at once whose frames take seconds."""
    vertices, triangles = far_apart(300)
    in_threads(4, lambda: stream(target, told, over, vertices, triangles, -vertices, accuracy="exact"))
