#!/usr/bin/env python3
"""Digests of what the engine in the process finds in frames of two waves, as JSON, for builds to be compared.

usage: local_digests.py   (with COLLIDED_LIBRARY in the environment, and the package `collided` installed or on PYTHONPATH)

The positions come from additions, products and roundings alone, so that every machine has the same; sines differ in the last bit.
"""

import hashlib
import json

import collided
import numpy as np

SIDE = 16
CASES = {
    "ccd": {},
    "exact, f64": {"accuracy": "exact", "position_format": "f64"},
    "guarded": {"accuracy": "guarded"},
    "candidates": {"accuracy": "candidates"},
    "dcd, thick": {"mode": "dcd", "thickness": 0.03},
    "dcd, triangles": {"mode": "dcd", "kinds": ["tt"]},
    "q16": {"position_format": "q16", "quantization_box": collided.Box((-2, -2, -2), (3, 3, 3))},
    "earliest": {"report": "earliest_only"},
}


def triangles():
    ids = np.arange(SIDE * SIDE).reshape(SIDE, SIDE)
    upper = np.stack([ids[:-1, :-1], ids[:-1, 1:], ids[1:, :-1]], -1)
    lower = np.stack([ids[:-1, 1:], ids[1:, 1:], ids[1:, :-1]], -1)
    return np.concatenate([upper.reshape(-1, 3), lower.reshape(-1, 3)])


def folded(x):
    return np.abs(x - np.floor(x) - 0.5) * (1 + 0.1 * x * x)


def wave(phase, height):
    along = np.arange(SIDE) / (SIDE - 1)
    x, y = np.meshgrid(along, along, indexing="ij")
    z = height + 0.8 * folded(1.25 * x + phase) * folded(0.8125 * y + 0.25)
    return np.stack([x + 0.1 * folded(1.5 * y + phase), y, z], -1).reshape(-1, 3)


def found(options):
    """Numbers of contacts in each frame, and one digest of them all."""
    cloth = collided.Mesh(wave(0, 0.5), triangles())
    ground = collided.Mesh(wave(0.375, 0), triangles(), motion="rigid")
    digest, counts = hashlib.sha256(), []
    with collided.Session({"cloth": cloth, "ground": ground}, server="local", device="cpu", fields=collided.options.FIELDS,
                          **options) as session:
        for step in range(1, 6):
            pose = np.eye(3, 4)
            pose[2, 3] = 0.05 * step
            contacts = session.step({"cloth": wave(0.0625 * step, 0.5 - 0.15 * step), "ground": collided.Rigid(pose)})
            counts.append(len(contacts))
            digest.update(contacts.records.tobytes())
    return {"contacts": counts, "sha256": digest.hexdigest()}


print(json.dumps({name: found(options) for name, options in CASES.items()}))
