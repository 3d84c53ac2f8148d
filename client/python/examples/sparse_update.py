"""Only what changed is sent: one vertex of a sheet is pulled up to a ceiling, while all others stand still."""

import numpy as np

import collided

y, x = np.mgrid[:101, :101] / 10
sheet = np.stack([x, y, np.zeros_like(x)], axis=2).reshape(-1, 3)
corner = (np.arange(100)[:, None] * 101 + np.arange(100)).reshape(-1, 1)
cells = np.concatenate([corner + [0, 1, 101], corner + [1, 102, 101]], axis=1).reshape(-1, 3)
ceiling = np.array([[0, 0, 1], [20, 0, 1], [0, 20, 1]])

with collided.Session({"ceiling": collided.Mesh(ceiling, [[0, 1, 2]], motion="static"), "sheet": (sheet, cells)}) as session:
    for height in (0.5, 1.5):
        contacts = session.step({"sheet": collided.Sparse([5100], [[5, 5, height]])})
        print(f"{contacts.metrics.bytes_in} bytes, {len(contacts.vt)} vertex meets the ceiling")
