"""This program runs the Python client against a daemon that misbehaves. It reads lines "BEHAVIOUR SCENARIO ADDRESS" and runs
all of them at once. For each it prints the code of the error, or ok, then the seconds that it took and the message."""

import sys
import threading
import time

import collided
import numpy as np

SECONDS = float(sys.argv[1])
PRINTING = threading.Lock()
FLOOR = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0]], "<f4")
TIP = np.array([[1, 1, 1], [1.25, 1, 9], [1, 1.25, 9]], "<f4")
ONE = np.array([[0, 1, 2]], "<u4")


def meshes(with_vertices=False):
    if with_vertices:
        return {"floor": collided.Mesh(FLOOR, ONE), "tip": collided.Mesh(TIP, ONE)}
    return {name: collided.Mesh(None, ONE, vertex_count=3) for name in ("floor", "tip")}


def stream(client, transport="grpc"):
    with collided.Session(meshes(), server=client, transport=transport, window=2 if transport == "grpc" else 1,
                          reconnect_seconds=SECONDS) as session:
        frames = 2 if transport == "grpc" else 1
        for _ in range(frames):
            session.send({"floor": FLOOR, "tip": TIP})
        for _ in range(frames):
            contacts = session.receive(timeout=SECONDS)
            assert contacts.meshes.tolist() == [[1, 0]], contacts.meshes


def advance(client):
    with collided.Session(meshes(), server=client, transport="grpc", reconnect_seconds=SECONDS) as session:
        session.step({"floor": FLOOR, "tip": TIP})
        target = TIP - np.float32([0, 0, 2])
        contacts = session.step({"tip": target}, advance="per_vertex")
        assert (contacts.advanced, contacts.way) == (0.25, 0.75)
        assert (contacts.shortened.ids.tolist(), contacts.shortened.fractions.tolist()) == ([3, 4], [0.25, 0.5])
        gone = collided.move_along(TIP, target, contacts.fractions("tip"))
        assert gone[:, 2].tolist() == session.positions["tip"][:, 2].tolist() == [0.5, 8, 7]


def limits(client):
    with collided.Session(meshes(), server=client, transport="grpc", reconnect_seconds=SECONDS) as session:
        session.step({"floor": FLOOR, "tip": TIP})
        limits = session.step({"tip": TIP - np.float32([0, 0, 2])}, advance=True, limits=True).limits
        assert (limits.elements.tolist(), limits.toi.tolist(), limits.meshes.tolist()) == ([[3, 0], [0, 3]], [0.5, 0.75], [[1, 0], [0, 1]])


def pairs(client):
    with collided.Session(meshes(), server=client, transport="grpc", reconnect_seconds=SECONDS, mode="dcd", fields=["pair_states"]) as session:
        contacts = session.step({"floor": FLOOR, "tip": TIP})
        assert list(contacts.pairs) == [("floor", "tip", collided.PairState.OVERLAPPING, (0, 1), 3, 0.25)], contacts.pairs
        assert (contacts.vs.distance.tolist(), contacts.vs.meshes.tolist()) == ([-0.25], [[1, 0]])
        assert contacts.vt.signed_distances.tolist() == [-0.25]


def timeouts(client):
    """The last error, if none took much longer than the call's timeout, which is far below the client's deadline."""
    client = collided.Client(client.address, token=client.options.token)
    with collided.Session(meshes(), server=client, transport="grpc") as session:
        session.step({"floor": FLOOR, "tip": TIP})
        session.send({"tip": TIP})
        for most in (2, 3):
            begun = time.monotonic()
            try:
                session.receive(timeout=0.1)
            except collided.DeadlineExceeded as error:
                late = error
            assert time.monotonic() - begun < most, time.monotonic() - begun
        assert session.in_flight == 1
        raise late


def watch(client):
    scene = client.create_scene(collided.layout.Layout.of(meshes()), collided.SceneOptions(), 0)
    with collided.Watcher(client, scene.scene_id, meshes=["tip"]) as watcher:
        repr(watcher.receive(timeout=SECONDS))


def batch(client):
    with collided.SceneBatch(meshes(with_vertices=True), 2, server=client, transport="calls") as scenes:
        positions = np.stack([np.concatenate([FLOOR, TIP])] * 2)
        assert scenes.step(positions).counts.tolist() == [1, 0]


def mesh(client):
    scene = client.create_scene(collided.layout.Layout.of(meshes()), collided.SceneOptions(), 0)
    client.get_mesh(scene.scene_id, 0)


SCENARIOS = {"stream": stream, "advance": advance, "limits": limits, "pairs": pairs, "call": lambda client: stream(client, "calls"), "watch": watch,
             "timeouts": timeouts, "set": batch, "local": lambda client: stream(client, "shared_memory"), "mesh": mesh,
             "list": lambda client: client.scenes()}


def play(behaviour, scenario, address):
    begun, code, message = time.monotonic(), "ok", ""
    try:
        with collided.Client(address, token=behaviour, patience=SECONDS, deadline=SECONDS) as client:
            SCENARIOS[scenario](client)
    except collided.Error as error:
        code, message = error.code, error.message
    except BaseException as error:
        code, message = "UNTYPED", repr(error)
    line = f"{behaviour} {scenario} {code} {time.monotonic() - begun:.3f} {message[:200]!r}\n"
    with PRINTING:
        sys.stdout.write(line)


if __name__ == "__main__":
    threads = [threading.Thread(target=play, args=line.split()) for line in sys.stdin]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
