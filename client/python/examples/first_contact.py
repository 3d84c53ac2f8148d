"""Two triangles, one of which falls through the other: what meets, when and where."""

import numpy as np

import collided

floor = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0]])
above = np.array([[1, 1, 1], [1.25, 1, 9], [1, 1.25, 9]])
V0, V1 = np.concatenate([floor, above]), np.concatenate([floor, above - [0, 0, 2]])

contacts = collided.detect(V0, V1, [[0, 1, 2], [3, 4, 5]])
for (vertex, triangle), t, point in zip(contacts.vt.elements, contacts.vt.toi, contacts.vt.points[1]):
    print(f"vertex {vertex} meets triangle {triangle} at t = {t:.9f}, at {point.round(9)}")
