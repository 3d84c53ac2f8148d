"""A daemon that is killed in the middle of a stream: the session starts another one, and the loop does not notice."""

import os

import numpy as np

import collided

floor = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0]])
falling = np.array([[1, 1, 1], [1.25, 1, 9], [1, 1.25, 9]])
daemon = collided.OwnDaemon()  # what a session without a server has; here to have something to kill

with collided.Session({"floor": (floor, [[0, 1, 2]]), "falling": (falling, [[0, 1, 2]])},
                      server=collided.Client(daemon=daemon)) as session:
    for frame in range(1, 7):
        contacts = session.step({"falling": falling - [0, 0, 0.4 * frame]})
        print(f"frame {frame}: {len(contacts)} contacts, {session.recreations} recreations")
        if frame == 2:
            os.killpg(daemon.pid, 9)
daemon.stop()
