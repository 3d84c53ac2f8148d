"""Clients of one tide, each a process of its own: some end as they should, some die, some stop reading and stay.

Each gets (server, seed, backend) and ends by itself, but for those of STALLING, which stop themselves until they are killed.
"""

import os
import random
import signal
import socket
import threading
import time

import numpy as np

import collided

FRAMES = 12
PAUSE = 0.1  # seconds between frames: the daemon's other work on this machine comes first
FLOOR = np.array([[-9, -9, 0], [99, -9, 0], [-9, 99, 0]], "<f4")
LEASE = 1.0  # seconds: what a client leaves behind is gone soon


def sheet(side, height, **options):
    """A cloth of side * side vertices."""
    y, x = np.mgrid[:side, :side]
    corner = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).reshape(-1, 1)
    triangles = np.concatenate([corner + [0, 1, side], corner + [1, side + 1, side]], axis=1).reshape(-1, 3)
    vertices = np.stack([x, y, np.full((side, side), height)], axis=2).reshape(-1, 3).astype("<f4")
    return collided.Mesh(vertices, triangles, **options)


def resting(side, height):
    """A cloth whose rest shape leaves out what is near in it."""
    return sheet(side, height, exclude_rest_pairs=True)


def scene(server, backend, side, height=1.0, lease=LEASE):
    return collided.Scene({"floor": collided.Mesh(FLOOR, [[0, 1, 2]], motion="static"), "cloth": resting(side, height)},
                          server=server, backend=backend, lease_seconds=lease, rest_distance=1.5)


def expect(condition, what):
    if not condition:
        raise AssertionError(what)


def changing(transport, server, seed, backend):
    """Frames, edits and new rest shapes; each vertex of a cloth that falls through the floor must be found."""
    rng = random.Random(seed)
    side = rng.randint(3, 12)
    with scene(server, backend, side) as made, made.session(transport=transport) as session:
        for step in range(FRAMES):
            if step % 4 == 1:  # another cloth, with a rest shape of its own
                side = rng.randint(3, 12)
                session.step(edit=collided.Edit({"cloth": resting(side, 1.0)}))
            if step % 4 == 2:
                session.step(edit=collided.Edit({"more": sheet(rng.randint(2, 9), 50.0)}))
            if step % 4 == 3:
                session.step(edit=collided.Edit({"more": None}))
            above, below = sheet(side, 1.0).vertices, sheet(side, -1.0).vertices
            contacts = session.step({"cloth": below}, start={"cloth": above})
            expect(len(contacts.vt) == side * side, f"{len(contacts.vt)} vertices of {side * side} met the floor")
            time.sleep(PAUSE)


def batch(server, seed, backend):
    """Sets of scenes."""
    side, worlds = random.Random(seed).randint(3, 8), 4
    meshes = {"floor": collided.Mesh(FLOOR, [[0, 1, 2]], motion="static"), "cloth": sheet(side, 1.0)}
    above, below = (np.broadcast_to(sheet(side, height).vertices, (worlds, side * side, 3)) for height in (1.0, -1.0))
    with collided.SceneBatch(meshes, worlds, server=server, backend=backend, lease_seconds=LEASE) as scenes:
        for _ in range(FRAMES):
            contacts = scenes.step(below, start=above)
            expect(len(contacts.all.vt) == worlds * side * side, "not all vertices met the floor")
            time.sleep(PAUSE)


def watched(server, seed, backend):
    """A scene and who watches it until it is gone."""
    with scene(server, backend, 6) as made:
        watcher = made.watch(max_contacts_per_kind=10)
        seen = []
        reader = threading.Thread(target=lambda: seen.extend(watcher))
        reader.start()
        with made.session() as session:
            for step in range(FRAMES):
                session.step({"cloth": sheet(6, 1.0 + step % 2).vertices})
                time.sleep(PAUSE)
    reader.join()
    expect(seen, "the watcher saw no frame")


def leaving(server, seed, backend):
    """Goes without deleting its scene, which its lease ends."""
    with scene(server, backend, 5).session() as session:
        session.step()


def dying(transport, server, seed, backend):
    """Killed with frames in flight."""
    session = scene(server, backend, 12).session(transport=transport, window=8)
    for step in range(random.Random(seed).randint(1, 8)):
        session.send({"cloth": sheet(12, -1.0 + step % 2 * 2).vertices})
    os.kill(os.getpid(), signal.SIGKILL)


def stalling(transport, server, seed, backend):
    """Stops reading with a whole window in flight."""
    session = scene(server, backend, 12).session(transport=transport, window=8)
    for step in range(8):
        session.send({"cloth": sheet(12, -1.0 + step % 2 * 2).vertices})
    os.kill(os.getpid(), signal.SIGSTOP)


def silent(server, seed, backend):
    """Connects to every socket and says nothing."""
    host, port = server.rsplit(":", 1)
    remote = socket.create_connection((host, int(port)))
    local = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    local.connect(collided.Client(server).info.local_socket)
    os.kill(os.getpid(), signal.SIGSTOP)
    remote.close()


def leaking(server, seed, backend):
    """The fault that the soak must find: a scene that stays, as no finalizer runs in its process."""
    scene(server, backend, 5, lease=3600.0)
    os._exit(0)


HONEST = {"grpc": (changing, "grpc"), "shared memory": (changing, "shared_memory"), "calls": (changing, "calls"),
          "set": (batch,), "watched": (watched,), "leaving": (leaving,)}
DYING = {"dying, grpc": (dying, "grpc"), "dying, shared memory": (dying, "shared_memory")}
STALLING = {"stalling, grpc": (stalling, "grpc"), "stalling, shared memory": (stalling, "shared_memory"),
            "silent": (silent,)}
