#!/usr/bin/python3
"""Regenerates the two frames, byte for byte: a cloth falls onto a ball and folds.

usage: simulate.py FOLDER    (writes before.ply and after.ply)

A mass-spring cloth, small explicit steps, metres and seconds. Every operation is one that IEEE 754 rounds in one way
only, and sums have a fixed order, so that the bytes are the same on every machine.
"""

import math
import pathlib
import struct
import sys

import numpy as np

CELLS = 32  # of the cloth, along each side
SIDE = 1.0
MASS = 0.3 / (CELLS + 1) ** 2  # of a vertex, kg
GRAVITY = -9.81
SPEED = -2.0  # of the cloth's fall when it is let go

BALL_RADIUS = 0.3
BALL_SPLITS = 2  # of an icosahedron
BALL_GAP = 0.01  # what keeps cloth and ball apart
FRICTION = 0.995  # what a step leaves of the velocity of vertices on the ball

STRETCH, SHEAR, BEND = 400.0, 200.0, 24.0  # stiffness, N/m
DAMPING = 0.03  # of springs, N s/m
AIR = 0.0002  # N s/m
FOLD_GAP = 0.6 * SIDE / CELLS  # vertices of different folds repel each other within that
FOLD_STIFFNESS, FOLD_DAMPING = 800.0, 0.05

STEP = 1 / 2400
STEPS = 520  # until the first frame
STEPS_OF_NEIGHBOURS = 8  # of one list of pairs that may come near
FRAME = 1 / 30  # from the first frame to the second


def dot(a, b):
    return a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1] + a[:, 2] * b[:, 2]


def length(a):
    return np.sqrt(dot(a, a))


def cloth():
    """Almost upright, with its lower edge above the ball: positions and triangles."""
    along = (np.arange(CELLS + 1) / CELLS - 0.5) * SIDE
    across, up = along[:, None], along[None, :] + 0.5 * SIDE
    grid = np.empty((CELLS + 1, CELLS + 1, 3))
    grid[..., 0] = across + 0.013
    grid[..., 1] = 0.02 + 0.06 * up + 0.03 * across
    grid[..., 2] = BALL_RADIUS + 0.03 + 0.998 * up
    triangles = []
    for i in range(CELLS):
        for j in range(CELLS):
            a = i * (CELLS + 1) + j
            b, c, d = a + 1, a + CELLS + 1, a + CELLS + 2
            triangles += [(a, c, b), (c, d, b)] if (i + j) % 2 else [(a, c, d), (a, d, b)]
    return grid.reshape(-1, 3), triangles


def on_ball(point):
    scale = BALL_RADIUS / math.sqrt(point[0] * point[0] + point[1] * point[1] + point[2] * point[2])
    return tuple(scale * x for x in point)


def ball():
    """An icosahedron whose triangles are split into four: positions and triangles."""
    g = (1 + math.sqrt(5)) / 2
    points = [on_ball(p) for p in [
        (-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g),
        (0, -1, -g), (0, 1, -g), (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]]
    triangles = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2),
                 (10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5),
                 (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    middles = {}

    def middle(a, b):
        edge = min(a, b), max(a, b)
        if edge not in middles:
            middles[edge] = len(points)
            points.append(on_ball([x + y for x, y in zip(points[edge[0]], points[edge[1]])]))
        return middles[edge]

    for _ in range(BALL_SPLITS):
        split = []
        for a, b, c in triangles:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            split += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        triangles = split
    return np.array(points), triangles


def springs(rest):
    """(ends, other ends, lengths, stiffness) for each direction on the grid."""
    ids = np.arange((CELLS + 1) ** 2).reshape(CELLS + 1, CELLS + 1)
    found = []
    for i, j, stiffness in ((0, 1, STRETCH), (1, 0, STRETCH), (1, 1, SHEAR), (1, -1, SHEAR), (0, 2, BEND), (2, 0, BEND)):
        width = CELLS + 1 - abs(j)
        a = ids[:CELLS + 1 - i, max(0, -j):max(0, -j) + width].ravel()
        b = ids[i:, max(0, j):max(0, j) + width].ravel()
        found.append((a, b, length(rest[b] - rest[a]), stiffness))
    return found


def neighbours(positions, rest):
    """Pairs of vertices that may come within FOLD_GAP soon, without those that are close in the cloth itself."""
    reach = 2 * FOLD_GAP
    order = np.argsort(positions[:, 0], kind="stable")
    x = positions[order, 0]
    counts = np.searchsorted(x, x + reach) - np.arange(len(x)) - 1
    first = np.repeat(np.arange(len(x)), counts)
    second = first + 1 + np.arange(len(first)) - np.repeat(np.cumsum(counts) - counts, counts)
    a, b = order[first], order[second]
    apart = np.abs(positions[b] - positions[a])
    kept = (apart[:, 1] < reach) & (apart[:, 2] < reach) & (length(rest[b] - rest[a]) > 1.5 * FOLD_GAP)
    return a[kept], b[kept]


def pull(forces, a, b, directions, strengths):
    """Adds forces that draw the vertices a and b together."""
    pulls = strengths[:, None] * directions
    np.add.at(forces, a, pulls)
    np.add.at(forces, b, -pulls)


def forces_on(positions, velocities, all_springs, pairs):
    forces = -AIR * velocities
    forces[:, 2] += MASS * GRAVITY
    for a, b, rest_length, stiffness in all_springs:
        apart = positions[b] - positions[a]
        now = length(apart)
        along = apart / now[:, None]
        speed = dot(velocities[b] - velocities[a], along)
        pull(forces, a, b, along, stiffness * (now - rest_length) + DAMPING * speed)
    a, b = pairs
    apart = positions[b] - positions[a]
    now = length(apart)
    near = now < FOLD_GAP
    a, b, now = a[near], b[near], now[near]
    along = apart[near] / now[:, None]
    speed = dot(velocities[b] - velocities[a], along)
    pull(forces, a, b, along, FOLD_DAMPING * np.minimum(speed, 0) - FOLD_STIFFNESS * (FOLD_GAP - now))
    return forces


def keep_off_ball(positions, velocities):
    distance = length(positions)
    inside = distance < BALL_RADIUS + BALL_GAP
    outward = positions[inside] / distance[inside][:, None]
    positions[inside] = (BALL_RADIUS + BALL_GAP) * outward
    sinking = np.minimum(dot(velocities[inside], outward), 0)
    velocities[inside] = FRICTION * (velocities[inside] - sinking[:, None] * outward)


def simulate(rest):
    """Positions and velocities of the first frame."""
    positions, velocities = rest.copy(), np.zeros_like(rest)
    velocities[:, 2] = SPEED
    all_springs = springs(rest)
    for step in range(STEPS):
        if step % STEPS_OF_NEIGHBOURS == 0:
            pairs = neighbours(positions, rest)
        velocities += forces_on(positions, velocities, all_springs, pairs) * (STEP / MASS)
        positions += velocities * STEP
        keep_off_ball(positions, velocities)
    return positions, velocities


def ahead(positions, velocities):
    """Positions a frame later if nothing is in the way: the step that a simulator passes to collision detection."""
    later = positions + velocities * FRAME
    later[:, 2] += 0.5 * GRAVITY * FRAME * FRAME
    return later


def write_ply(path, positions, triangles):
    header = (f"ply\nformat binary_little_endian 1.0\nelement vertex {len(positions)}\nproperty double x\n"
              f"property double y\nproperty double z\nelement face {len(triangles)}\n"
              "property list uchar uint vertex_indices\nend_header\n")
    faces = b"".join(struct.pack("<BIII", 3, *triangle) for triangle in triangles)
    path.write_bytes(header.encode() + positions.astype("<f8").tobytes() + faces)


def main(folder):
    rest, cloth_triangles = cloth()
    ball_positions, ball_triangles = ball()
    triangles = cloth_triangles + [tuple(v + len(rest) for v in triangle) for triangle in ball_triangles]
    positions, velocities = simulate(rest)
    for name, frame in (("before", positions), ("after", ahead(positions, velocities))):
        write_ply(pathlib.Path(folder) / f"{name}.ply", np.concatenate([frame, ball_positions]), triangles)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(sys.argv[1])
