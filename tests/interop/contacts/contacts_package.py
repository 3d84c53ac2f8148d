#!/usr/bin/env python3
"""The scene of contacts_test.py with the Python package. usage: contacts_package.py ADDRESS TRANSPORT."""

import sys

import numpy as np
from contacts import FIELDS, SIDE, sheet, triangles

import collided


def put(contacts):
    sys.stdout.buffer.write(np.array(len(contacts), "<u4").tobytes())
    for field in FIELDS:
        if contacts.has_column(field):
            sys.stdout.buffer.write(getattr(contacts, field).tobytes())


def put_both(contacts):
    put(contacts.vt)
    put(contacts.ee)


def main(address, transport):
    cells = np.frombuffer(triangles(), "<u4").reshape(-1, 3)
    meshes = {"lower": collided.Mesh(triangles=cells, motion="static"), "upper": cells}
    with collided.Session(meshes, server=address, transport=transport, position_format="f64", mode="dcd_and_ccd",
                          thickness=0.25) as session:
        for frame in range(5):
            upper = sheet(0.125, 2 - frame, 11, 5)
            positions = {"upper": upper, "lower": sheet(0, 0, 7, 13)} if frame == 0 else {"upper": upper}
            if frame == 4:  # every third vertex alone, back through the lower sheet
                positions = {"upper": collided.Sparse(np.arange(0, SIDE * SIDE, 3), upper[::3] + [0, 0, 3])}
            if frame == 2:
                put_both(session.step(positions, trial=True, advance="per_vertex", limits=True).limits)
            put_both(session.step(positions))
            put_both(session.step(mode="dcd"))


main(*sys.argv[1:])
