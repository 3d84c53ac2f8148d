"""Does what a user on macOS or Windows does, against a daemon on a loopback port. It announces a local socket, as one in a container may.

usage: program.py darwin|win32 HOST:PORT     prints a line of JSON
"""

import json
import os
import sys

from pretend import pretend

SYSTEM, SERVER = sys.argv[1:3]
LOOP = pretend(SYSTEM)

import collided  # noqa: E402
import collided.aio  # noqa: E402
import collided.gpu  # noqa: E402
import collided.programs  # noqa: E402
import numpy as np  # noqa: E402

assert sys.platform == SYSTEM and not hasattr(os, "memfd_create")
FLOOR, TIP = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0.]]), np.array([[1, 1, 1], [1.25, 1, 9], [1, 1.25, 9.]])
ONE = [[0, 1, 2]]


def meshes():
    return {"ground": collided.Mesh(FLOOR, ONE, motion="static"), "tip": collided.Mesh(TIP, ONE)}


def stream(**options):
    with collided.Session(meshes(), server=SERVER, thickness=0.01, **options) as session:
        frames = ({"tip": TIP - [0, 0, 0.4 * step]} for step in range(4))
        return [round(contacts.earliest_toi, 3) for contacts in session.run(frames)], session.is_local


def batch():
    tips = TIP - np.array([0, 0, 0.4])[None] * np.arange(4)[:, None, None]
    with collided.SceneBatch(meshes(), 4, server=SERVER) as scenes:
        return scenes.step(tips, start=np.broadcast_to(TIP, tips.shape)).counts.tolist()


async def step():
    async with collided.aio.Session(meshes(), server=SERVER) as session:
        return len(await session.step({"tip": TIP - [0, 0, 2.]}))


def read():
    with open("triangle.obj", "w", encoding="utf-8") as file:
        file.write("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    return len(collided.Mesh.read("triangle.obj").vertices)


def refusal(call):
    """The error of a call that cannot succeed here."""
    try:
        call()
    except collided.Error as error:
        return f"{type(error).__name__}: {error.message}"
    return "no error"


def command():
    try:
        collided.programs.command_line()
    except SystemExit as end:
        return str(end.code)


leftover = collided.Session(meshes(), server=SERVER)  # is closed when the process ends
print(json.dumps({
    "auto": stream(), "grpc": stream(transport="grpc"), "calls": stream(transport="calls"), "batch": batch(),
    "aio": LOOP.run_until_complete(step()), "read": read(),
    "shared_memory": refusal(lambda: stream(transport="shared_memory")),
    "device": refusal(lambda: collided.gpu.DeviceSession(meshes(), server=SERVER, cuda=object())),
    "no server": refusal(lambda: collided.detect(FLOOR, FLOOR, ONE)), "command": command(),
}))
LOOP.close()
