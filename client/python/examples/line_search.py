"""A line search: how far along a direction a cloth can go before it touches a ball, halving the step until it is free.

Each position is sent once: a trial asks about the whole way, and `from_last_fraction` goes to a point of it.
"""

import numpy as np

import collided

y, x = np.mgrid[:9, :9] / 8
cloth = np.stack([x, y, np.ones_like(x)], axis=2).reshape(-1, 3)
corner = (np.arange(8)[:, None] * 9 + np.arange(8)).reshape(-1, 1)
cells = np.concatenate([corner + [0, 1, 9], corner + [1, 10, 9]], axis=1).reshape(-1, 3)
tip = np.array([[0.4, 0.4, -0.5], [0.6, 0.4, -0.5], [0.5, 0.5, 0.3]])

with collided.Session({"tip": collided.Mesh(tip, [[0, 1, 2]], motion="static"), "cloth": (cloth, cells)}) as session:
    tried = session.step({"cloth": cloth - [0, 0, 2]}, trial=True)
    fraction = 1.0
    while fraction > tried.earliest_toi:
        fraction /= 2
    contacts = session.step(from_last_fraction=fraction)
    height = session.positions["cloth"][0, 2]
    print(f"first contact at {tried.earliest_toi:.3f}, went {fraction}, contacts {len(contacts)}, height {height}")
