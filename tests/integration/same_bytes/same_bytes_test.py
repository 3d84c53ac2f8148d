#!/usr/bin/env python3
"""The same frames have the same contacts, to the byte, whatever way they go: engines, lists of neighbours, threads, transports,
windows, calls, losses of connection and daemon, parts, sets, GPUs.

COLLIDED_SAME_BYTES_STREAMS random streams (default 4) go each way; a stream that fails is told with its seed.
"""

import os
import pathlib
import sys
import unittest

sys.path[:0] = [str(pathlib.Path(sys.argv[3]) / "tests" / "client" / "python")]
from random_stream import RandomStream
from recovery_test import break_connection
from support import DAEMON, Daemon, Supervised, main, np

import collided
from collided.columns import COLUMNS

STREAMS = int(os.environ.get("COLLIDED_SAME_BYTES_STREAMS", "4"))
ENGINES = ("octree", "top_down_octree", "bottom_up_octree", "uniform_grid", "two_level_grid", "lbvh", "vss", "all_pairs")


def told(contacts):
    """All that was said of a frame's contacts."""
    columns = {"kinds": contacts.kinds.tobytes()}
    columns |= {name: getattr(contacts, name).tobytes() for name in COLUMNS if len(contacts) and contacts.has_column(name)}
    return {**columns, "summary": (contacts.earliest_toi, contacts.any_contact, contacts.advanced)}


def play(session, frames, disturb=lambda sent: None):
    """What was said of each frame, with the window full: contacts, or what it was refused with."""
    answers = []

    def receive():
        try:
            answers.append(told(session.receive()))
        except collided.Error as error:
            answers.append((type(error).__name__, error.field))

    for sent, frame in enumerate(frames, 1):
        while session.in_flight >= session.window:
            receive()
        session.send(frame.positions, frame.start, **frame.options)
        disturb(sent)
    while session.in_flight:
        receive()
    return answers


class SameBytes(unittest.TestCase):
    maxDiff = 2000

    @classmethod
    def setUpClass(cls):
        """The first computes on one thread; the others have more, or a second device."""
        cls.daemon = cls.served("--backend", "cpu", "--threads", "1")
        cls.streams = [RandomStream(seed) for seed in range(STREAMS)]
        cls.expected = [cls.answers(stream, cls.daemon) for stream in cls.streams]

    @classmethod
    def served(cls, *options):
        daemon = Supervised("--grace-seconds", "0.1", *options)
        cls.addClassCleanup(daemon.close)
        return daemon

    @staticmethod
    def answers(stream, daemon, disturb=lambda session, sent: None, **options):
        """With one frame in flight over gRPC, unless options say otherwise."""
        options = {"window": 1, "transport": "grpc", "edit_bytes": 8192, **stream.options, **options}
        with collided.Session(stream.meshes(), server=daemon.address, **options) as session:
            return play(session, stream.frames, lambda sent: disturb(session, sent))

    def each_is_as_expected(self, daemon=None, only=lambda stream: True, expected=None, **options):
        for stream, expected in zip(self.streams, expected or self.expected):
            if only(stream):
                with self.subTest(seed=stream.seed, **{name: str(value) for name, value in options.items()}):
                    self.assertEqual(self.answers(stream, daemon or self.daemon, **options), expected)

    def test_streams_have_contacts_and_refusals_are_few(self):
        frames = [answer for answers in self.expected for answer in answers]
        refused = [answer for answer in frames if isinstance(answer, tuple)]
        self.assertLess(len(refused), len(frames) / 4, refused)
        self.assertGreater(sum(len(answer["kinds"]) for answer in frames if isinstance(answer, dict)), 100 * len(self.streams))

    def test_again(self):
        self.each_is_as_expected()

    def test_engines(self):
        for engine in ENGINES:
            self.each_is_as_expected(broad_phase=engine)

    def test_lists_of_neighbours(self):
        self.each_is_as_expected(only=lambda stream: stream.reuses, reuse="on")
        self.each_is_as_expected(reuse="off")

    def test_threads(self):
        for threads in (2, 5):
            self.each_is_as_expected(self.served("--backend", "cpu", "--threads", str(threads)))

    def test_transports_and_windows(self):
        self.each_is_as_expected(transport="shared_memory")
        self.each_is_as_expected(transport="calls", window=0)
        self.each_is_as_expected(window=5)
        self.each_is_as_expected(transport="shared_memory", window=8)

    def test_streams_that_break_and_are_resumed(self):
        for transport in ("grpc", "shared_memory"):
            self.each_is_as_expected(transport=transport, window=3, disturb=lambda session, sent: sent % 3 or break_connection(session))

    def test_daemons_that_are_killed(self):
        self.each_is_as_expected(window=3, disturb=lambda session, sent: sent % 7 or self.daemon.kill())

    def test_parts(self):
        parts = self.served("--backend", "cpu", "--device", "cpu:0,cpu:1")
        self.each_is_as_expected_in_parts(parts, ("cpu:0", "cpu:1"), ("cpu:1", "cpu:0", "cpu:1"))

    def each_is_as_expected_in_parts(self, daemon, *devices_of_parts):
        """But for the closest features, which parts do not tell."""
        fields = [field for field in collided.options.FIELDS if field != "features"]
        expected = [self.answers(stream, self.daemon, fields=fields) for stream in self.streams]
        for devices in devices_of_parts:
            self.each_is_as_expected(daemon, expected=expected, part_devices=devices, fields=fields)

    def test_a_gpu(self):
        try:
            Daemon(str(DAEMON), "--backend", "cuda").kill()
        except RuntimeError:
            self.skipTest("no CUDA device can be used")
        gpu = self.served("--backend", "cuda")
        self.each_is_as_expected(gpu)
        self.each_is_as_expected(gpu, transport="shared_memory", window=8)
        self.each_is_as_expected(gpu, only=lambda stream: stream.reuses, reuse="on")
        self.each_is_as_expected_in_parts(gpu, ("cuda:0", "cuda:0"))


class Sets(unittest.TestCase):
    """Each world of a set is told what a scene of its own is."""

    WORLDS = 3

    def test_worlds(self):
        daemon = Supervised("--backend", "cpu")
        self.addCleanup(daemon.close)
        for seed in range(STREAMS):
            with self.subTest(seed=seed):
                self.expect_same(daemon.address, RandomStream(seed, is_plain=True))

    def expect_same(self, address, stream):
        """World w goes through the stream's frames, beginning with the w-th."""
        orders = [stream.frames[world:] + stream.frames[:world] for world in range(self.WORLDS)]
        with collided.SceneBatch(stream.meshes(), self.WORLDS, server=address, **stream.options) as worlds:
            begin = stream.meshes()["cloth"].vertices  # where sessions are before their first frames
            worlds.step(np.stack([begin] * self.WORLDS))
            sessions = [collided.Session(stream.meshes(), server=address, **stream.options) for _ in orders]
            for frames in zip(*orders):
                moved = np.stack([frame.positions["cloth"] for frame in frames])
                of_set = worlds.step(moved)
                for world, (session, frame) in enumerate(zip(sessions, frames)):
                    alone, beside = told(session.step(frame.positions)), told(of_set[world])
                    del alone["summary"], beside["summary"]  # the set's is that of all its worlds
                    self.assertEqual(beside, alone, f"world {world}")
            for session in sessions:
                session.close()


if __name__ == "__main__":
    main(seconds=120 * STREAMS)
