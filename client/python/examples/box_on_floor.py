"""The contacts that a rigid-body solver takes: a box stands 5 mm above a floor of 2.5 cm cells, and both are kept 20 mm apart."""

import numpy as np

import collided
from collided import OnTriangle


def floor(cells, size):
    """A flat square, two triangles a cell."""
    y, x = np.divmod(np.arange((cells + 1) ** 2), cells + 1)
    a = (y * (cells + 1) + x)[(x < cells) & (y < cells)]
    b, c, d = a + 1, a + cells + 2, a + cells + 1
    return np.stack([x * size, y * size, 0 * x], 1), np.concatenate([np.stack(t, 1) for t in ((a, b, c), (a, c, d))])


def box(lower, upper):
    corners = np.array(np.meshgrid(*zip(lower, upper), indexing="ij")).reshape(3, 8).T
    sides = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    return corners, [t for a, b, c, d in sides for t in ((a, b, c), (a, c, d))]


meshes = {"floor": collided.Mesh(*floor(16, 0.025), motion="static"),
          "box": collided.Mesh(*box((0.11, 0.12, 0.005), (0.21, 0.22, 0.105)), motion="rigid")}
with collided.Session(meshes, mode="dcd", thickness=0.02, position_format="f64") as session:
    contacts = session.step()
kept = contacts.kept
print(f"{len(contacts)} contacts with {len(np.unique(contacts.normals.round(3), axis=0))} directions")
print(f"{len(kept)} kept: {np.unique(kept.normals.round(3) + 0.0, axis=0).tolist()}, {np.unique(kept.distance.round(6)).tolist()} m apart")
corners = kept.vt[kept.vt.elements[:, 0] >= len(meshes["floor"].vertices)]  # of the box; the others are the floor's
for contact, place in zip(corners, OnTriangle.of(corners.features)):
    print("vertex {} above triangle {}: {}".format(*contact["elements"], OnTriangle(place).name.lower()))
