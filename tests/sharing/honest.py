"""Clients that do as they should: each streams frames at a modest rate and checks every answer."""

import dataclasses
import math
import threading
import time

import numpy as np

import collided

RATE = 20  # frames a second of each
LOOK = 0.2  # seconds
STEPS = 8  # frames after which they repeat


def grid(side, z):
    x, y = np.meshgrid(np.linspace(-1, 1, side), np.linspace(-1, 1, side))
    vertices = np.stack([x.ravel(), y.ravel(), np.full(side * side, z)], axis=1)
    corner = np.arange(side * side).reshape(side, side)
    a, b, c, d = (part.ravel() for part in (corner[:-1, :-1], corner[:-1, 1:], corner[1:, :-1], corner[1:, 1:]))
    return vertices, np.vstack([np.stack([a, b, c], axis=1), np.stack([b, d, c], axis=1)])


FLOOR, CLOTH = grid(8, 0.0), grid(6, 1.0)
START = CLOTH[0] * [0.9, 0.87, 1]


def end(step):
    """The cloth falls, further with each step; from the third on it meets the floor."""
    return START - [0, 0, 0.5 + 0.25 * (step % STEPS)]


@dataclasses.dataclass
class Server:
    """Describes where clients connect, and how."""

    address: str
    options: dict = dataclasses.field(default_factory=dict)  # of the sessions: TLS
    transports: tuple = ("grpc", "shared_memory")  # in turns


def open_session(server, token, patience, transport):
    meshes = {"floor": collided.Mesh(*FLOOR, motion="static"), "cloth": collided.Mesh(START, CLOTH[1])}
    return collided.Session(meshes, server=server.address, token=token, patience=patience, deadline=patience,
                            transport=transport, reconnect_seconds=0, **server.options)


def bytes_of(contacts):
    return tuple(array.tobytes() for array in (contacts.kinds, contacts.elements, contacts.toi, contacts.flags))


def right_answers(server, token):
    """Of each step, from a client that is alone."""
    with open_session(server, token, 30, "grpc") as session:
        answers = [session.step({"cloth": end(step)}, {"cloth": START}) for step in range(STEPS)]
    counts = [len(answer) for answer in answers]
    assert counts[0] == 0 and counts[-1] > 0, counts
    return [bytes_of(answer) for answer in answers]


def visit(server, token, answers, patience):
    """A client that is new: seconds until it has the right contacts of one frame."""
    began = time.monotonic()
    with open_session(server, token, patience, "grpc") as session:
        step = STEPS - 1
        contacts = session.step({"cloth": end(step)}, {"cloth": START}, timeout=patience)
        if bytes_of(contacts) != answers[step]:
            raise ValueError("a newcomer's contacts are wrong")
    return time.monotonic() - began


def percentile(values, part):
    return sorted(values)[max(0, math.ceil(part * len(values)) - 1)]


class Client(threading.Thread):
    def __init__(self, server, token, transport, answers):
        super().__init__(daemon=True)
        self.session = open_session(server, token, 30, transport)
        self.answers = answers
        self.times = []  # when a frame was sent and how long its answer took
        self.waits_since = None
        self.fault = None
        self.over = threading.Event()

    def run(self):
        try:
            due = time.monotonic()
            step = 0
            while not self.over.is_set():
                self.frame(step)
                step += 1
                due = max(due + 1 / RATE, time.monotonic())
                self.over.wait(due - time.monotonic())
            if not self.waits_since:
                self.session.close()
        except Exception as error:  # noqa: BLE001: whatever it is, it is what happened to this client
            self.fault = f"{type(error).__name__}: {error}"

    def frame(self, step):
        sent = self.waits_since = time.monotonic()
        self.session.send({"cloth": end(step)}, {"cloth": START})
        while True:
            try:
                contacts = self.session.receive(timeout=LOOK)
                break
            except collided.DeadlineExceeded:
                if self.over.is_set():
                    return
        self.times.append((sent, time.monotonic() - sent))
        self.waits_since = None
        if bytes_of(contacts) != self.answers[step % STEPS]:
            raise ValueError(f"contacts of step {step} are wrong")
        if self.session.draining_seconds is not None:
            self.over.set()


class Clients:
    def __init__(self, server, tokens, answers):
        ways = server.transports
        self.all = [Client(server, token, ways[i % len(ways)], answers) for i, token in enumerate(tokens)]
        for client in self.all:
            client.start()
            time.sleep(1 / RATE / len(tokens))  # not all at the same moment

    def measure(self, seconds, more=lambda: False):
        """Times of frames from now on, in ms, for so long and for as long as `more`; one that waits counts as it is."""
        began = time.monotonic()
        while time.monotonic() < began + seconds or more():
            time.sleep(0.02)
        now, times = time.monotonic(), []
        for client in self.all:
            times += [took for sent, took in list(client.times) if sent >= began]
            waits_since = client.waits_since
            if waits_since and now - waits_since > LOOK:
                times.append(now - waits_since)
        milliseconds = [1000 * took for took in times] or [1000 * seconds]
        return {"frames": len(times), "p50_ms": round(percentile(milliseconds, 0.5), 2),
                "p99_ms": round(percentile(milliseconds, 0.99), 2)}

    def faults(self):
        return [client.fault for client in self.all if client.fault]

    def close(self):
        for client in self.all:
            client.over.set()
        for client in self.all:
            client.join(5)
