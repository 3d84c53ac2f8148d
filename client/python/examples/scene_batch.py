"""A thousand scenes in one call: in each a tetrahedron falls to a floor, from another height."""

import numpy as np

import collided

WORLDS = 1000
floor = np.array([[-4, -4, 0], [4, -4, 0], [0, 4, 0]])
body = np.array([[0, 0, 0], [1, 0, 1], [0, 1, 1], [-1, -1, 1]])
faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
heights = (np.arange(WORLDS) + 0.5) / WORLDS


def bodies(fallen):
    """Those of all worlds: an array of shape (worlds, vertices, 3)."""
    return body + (heights - fallen)[:, None, None] * [0, 0, 1]


meshes = {"floor": collided.Mesh(floor, [[0, 1, 2]], motion="static"), "body": collided.Mesh(body, faces)}
with collided.SceneBatch(meshes, WORLDS, position_format="f64") as batch:
    batch.step(bodies(0))  # where they begin; the static floor comes with the first step by itself
    for fallen in (0.25, 0.5, 0.75):
        contacts = batch.step(bodies(fallen))
        touching = contacts.worlds[contacts.counts > 0]
        print(f"{len(contacts.all)} contacts in {len(touching)} worlds, from {touching[0]} to {touching[-1]}")
