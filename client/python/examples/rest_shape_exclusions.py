"""A cloth that is thick for its cells touches itself all over, even flat: what is close at rest can be left out."""

import numpy as np

import collided

y, x = np.mgrid[:21, :21] * 0.01  # cells of 10 mm
flat = np.stack([x, y, np.zeros_like(x)], axis=2).reshape(-1, 3)
corner = (np.arange(20)[:, None] * 21 + np.arange(20)).reshape(-1, 1)
cells = np.concatenate([corner + [0, 1, 21], corner + [1, 22, 21]], axis=1).reshape(-1, 3)
folded = np.where(flat[:, :1] > 0.1, [0.2, 0, 0.006] + flat * [-1, 1, 1], flat)

for exclusions in ({}, {"exclude_rings": 1, "exclude_rest_pairs": True}):
    cloth = collided.Mesh(flat, cells, **exclusions)
    with collided.Session({"cloth": cloth}, mode="dcd", thickness=0.008) as session:
        print(f"{exclusions or 'nothing excluded'}: flat {len(session.step())}, folded {len(session.step(folded))} contacts")
