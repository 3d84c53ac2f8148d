"""A box sinks into a room: it is apart, touches, overlaps, and is inside. Both are solids, 1 m and 4 m wide."""

import numpy as np

import collided
from collided import PairState


def box(lower, upper):
    """Eight corners, and twelve triangles whose normals point outside."""
    corners = np.array(np.meshgrid(*zip(lower, upper), indexing="ij")).reshape(3, 8).T
    sides = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    return corners, [t for a, b, c, d in sides for t in ((a, b, c), (a, c, d))]


room, sinking = box((0, 0, 0), (4, 4, 4)), box((1.25, 1.5, 0), (2.25, 2.5, 1))
meshes = {"room": collided.Mesh(*room, solid=True, motion="static"), "box": collided.Mesh(*sinking, solid=True, motion="rigid")}
with collided.Session(meshes, mode="dcd", kinds=["vs"], accuracy="exact", position_format="f64") as session:
    for height in (4.5, 4, 3.5, 3, 1.5, 0):
        pose = np.eye(3, 4)
        pose[2, 3] = height
        contacts = session.step({"box": collided.Rigid(pose)})
        pair = contacts.pairs.between("room", "box")
        print(f"{height:3} m: {pair or 'apart'}")
        if pair and pair.state == PairState.OVERLAPPING:
            deepest = contacts[contacts.elements[:, 0] == pair.deepest]
            print(f"       vertex {pair.deepest} comes out along {deepest.normals[0].round(6) + 0.0}")
