#!/usr/bin/env python3
"""The engine in this process answers as a daemon does, bit for bit, and says what it does not have.

usage: local_test.py DAEMON COLLIDECTL REPOSITORY, with COLLIDED_LIBRARY in the environment
"""

import ctypes
import gc
import os
import subprocess
import sys
import tempfile
import threading
import unittest
import warnings
from unittest import mock

from support import DAEMON, FLOOR, ONE, STRICT, TIP, lowered, meshes, turned
from waves import grid, wave

import numpy as np

import collided
from collided.in_process import library


def times(contacts):
    """Times of impact are lower bounds."""
    return [round(time, 9) for time in contacts.toi.tolist()]


POSE = np.eye(3, 4)
CASES = {
    "ccd": {},
    "exact": {"accuracy": "exact", "dtype": "<f8"},
    "candidates": {"accuracy": "candidates"},
    "dcd": {"mode": "dcd", "thickness": 0.03, "accuracy": "guarded"},
    "triangles": {"mode": "dcd", "kinds": ["tt"]},
    "crossings": {"mode": "dcd", "kinds": ["vt", "et"]},
    "q16": {"position_format": "q16", "quantization_box": collided.Box((-1, -1, -1), (2, 2, 2))},
    "fields": {"fields": ["normal", "weights", "toi"]},
    "earliest": {"report": "earliest_only"},
    "rest": {"rest": True, "rest_distance": 0.01, "mode": "dcd_and_ccd", "thickness": 0.02},
    "excluded": {"exclude": [("cloth", "cloth")]},
    "thick": {"half": 0.05, "mode": "dcd", "thickness": 0.01},
    "thick rest": {"half": 0.02, "rest": True, "mode": "dcd"},
}


def run(server, options):
    """Contacts of frames with whole, sparse, rigid, trial and advancing updates."""
    options = dict(options)
    dtype, rest, half = options.pop("dtype", "<f4"), options.pop("rest", False), options.pop("half", 0)
    fields = {"fields": options.pop("fields", collided.options.FIELDS)}
    made = {"cloth": collided.Mesh(wave(0, 0.5, dtype), grid(), exclude_rest_pairs=rest, half_thickness=half),
            "ground": collided.Mesh(wave(2, 0, dtype), grid(), motion="rigid")}
    out, kind = [], {} if options.get("mode") else {"from_last_fraction": 0.5}
    with collided.Session(made, server=server, device="cpu", **fields, **options) as session:
        for step in range(1, 4):
            pose = POSE.copy()
            pose[2, 3] = 0.05 * step
            out.append(session.step({"cloth": wave(0.4 * step, 0.5 - 0.15 * step, dtype), "ground": collided.Rigid(pose)}))
        few = collided.Sparse([3, 77, 200], wave(1, -0.2, dtype)[[3, 77, 200]])
        out.append(session.step({"cloth": few}, trial=True, **kind))
        out.append(session.step({"cloth": few}))
        if options == {}:
            for i, mode in enumerate((True, "per_mesh", "per_vertex")):
                turn = collided.Rigid(turned((1, 2, 2), 0.9 * (i + 1), POSE[:, 3]))
                out.append(session.step({"cloth": wave(3 + i, 0.4 - 0.2 * i, dtype), "ground": turn}, advance=mode, limits=True, delta=1e-6))
        return out, session.positions


class SameAsADaemon(unittest.TestCase):
    def test_bit_for_bit_in_every_option(self):
        for name, options in CASES.items():
            with self.subTest(name):
                (here, places), (there, wanted) = run("local", options), run(None, options)
                self.assertGreater(sum(map(len, there)), 0 if name == "earliest" else 20)
                for mine, theirs in zip(here, there, strict=True):
                    self.assertEqual(mine.records.tobytes(), theirs.records.tobytes())
                    self.assertEqual(mine.records.dtype, theirs.records.dtype)
                    for fact in ("earliest_toi", "any_contact", "advanced", "way", "frame_id", "wire_id"):
                        self.assertEqual(getattr(mine, fact), getattr(theirs, fact), fact)
                    for array in ("ids", "fractions"):
                        self.assertEqual(getattr(mine.shortened, array).tobytes(), getattr(theirs.shortened, array).tobytes())
                    self.assertEqual(mine.limits.records.tobytes(), theirs.limits.records.tobytes())
                    for count in ("contacts_vertex_triangle", "contacts_edge_edge", "contacts_triangle_triangle",
                                  "contacts_edge_triangle", "candidates_vertex_triangle", "survivors_vertex_triangle"):
                        self.assertEqual(getattr(mine.metrics.counts, count), getattr(theirs.metrics.counts, count))
                for mesh in wanted:
                    self.assertEqual(places[mesh].tobytes(), wanted[mesh].tobytes())

    def test_one_question(self):
        moved = np.concatenate([FLOOR, lowered(2)])
        contacts = collided.detect(np.concatenate([FLOOR, TIP]), moved, [[0, 1, 2], [3, 4, 5]], server="local")
        self.assertEqual((contacts.elements.tolist(), times(contacts)), ([[3, 0]], [0.5]))

    def test_loose_elements_and_what_a_scene_says_of_itself(self):
        hair = collided.Mesh([[1, 1, 1], [1, 1, 2]], edges=[[0, 1]], points=[0])
        with collided.Session({"floor": collided.Mesh(FLOOR, ONE), "hair": hair}, server="local") as session:
            self.assertEqual(len(session.step({"hair": [[1, 1, -1], [1, 1, 0.5]]})), 1)
            message = session.scene.refresh()
            self.assertEqual((message.vertex_count, message.edge_count, message.last_frame_id), (5, 4, 2))
            self.assertGreater(message.memory[0].bytes, 0)


class Frames(unittest.TestCase):
    def test_many_in_flight_are_answered_in_order(self):
        with collided.Session(meshes(), server="local", window=8) as session:
            contacts = list(session.run([lowered(depth) for depth in (0.5, 2, 0.1) * 10]))
            self.assertEqual([c.frame_id for c in contacts], list(range(1, 31)))
            self.assertEqual([len(c) for c in contacts], [0, 1, 1] + [0, 1, 1] * 9)

    def test_the_callers_array_may_change_once_a_frame_is_sent(self):
        with collided.Session(meshes(), server="local", window=4) as session:
            positions = lowered(2)
            session.send(positions)
            positions[:] = TIP
            self.assertEqual(times(session.receive()), [0.5])

    def test_contacts_stay_after_later_frames_and_the_end(self):
        with collided.Session(meshes(), server="local") as session:
            contacts = session.step(lowered(2))
            session.step(lowered(-3))
        gc.collect()
        self.assertEqual(contacts.stencils.tolist(), [[3, 0, 1, 2]])

    def test_a_refused_frame_leaves_the_scene_where_it_was(self):
        with collided.Session(meshes(), server="local") as session:
            session.step(lowered(0.5))
            with self.assertRaises(collided.InvalidArgument) as caught:
                session.step(np.full_like(TIP, np.nan))
            self.assertEqual((caught.exception.field, caught.exception.frame_id), ("updates[0].end", 2))
            self.assertEqual(times(session.step(lowered(2))), [0.333333333])

    def test_sessions_in_threads(self):
        found = []

        def work(depth):
            with collided.Session(meshes(), server="local") as session:
                found.extend(times(session.step(lowered(depth))))

        threads = [threading.Thread(target=work, args=(depth,)) for depth in (2, 3, 4, 5)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(sorted(found), [0.2, 0.25, 0.333333333, 0.5])

    def test_a_second_session_takes_the_scene_over(self):
        with collided.Scene(meshes(), server="local") as scene:
            first = scene.session()
            first.step(lowered(0.5))
            with self.assertRaises(collided.FailedPrecondition):
                scene.session()
            with scene.session(take_over=True) as second:
                self.assertEqual(times(second.step(lowered(2))), [0.333333333])
            first.close()

    def test_closing_in_the_middle_of_a_frame_does_not_wait_for_it(self):
        rng = np.random.default_rng(5)
        crowd = rng.random((3000, 3))
        triangles = rng.permutation(3000).reshape(-1, 3)
        session = collided.Session(collided.Mesh(crowd, triangles), server="local", accuracy="exact", device="cpu")
        session.send(rng.random((3000, 3)))
        session.close()
        with self.assertRaises(collided.FailedPrecondition):
            session.receive()

    def test_a_forgotten_session_is_closed_with_a_warning(self):
        session = collided.Session(meshes(), server="local")
        client = session.scene.client
        session.step(lowered(2))
        with self.assertWarns(ResourceWarning):
            del session
            gc.collect()
        collided.leftovers.settle()
        self.assertFalse(client._scenes)

    def test_options_without_effect_are_warned_of(self):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            with collided.Session(meshes(), server="local", min_separation=0.1) as session:
                session.step(lowered(0.5))
        self.assertIn("min_separation is set and had no effect", str(caught[0].message))


class WhatItDoesNotHave(unittest.TestCase):
    def refused(self, field, call, *arguments, **options):
        with self.assertRaises(collided.Unimplemented) as caught:
            call(*arguments, **options)
        self.assertEqual(caught.exception.field, field)

    def test_each_says_so(self):
        with collided.Session(meshes(), server="local") as session:
            session.step(lowered(0.5))
            self.refused("edit", session.step, edit=collided.Edit(exclude=[("floor", "tip")]))
            self.assertEqual(times(session.step(lowered(2))), [0.333333333], "the session goes on")
            scene, client = session.scene, session.scene.client
            for call in (scene.watch, client.scenes, lambda: client.estimate(meshes()), lambda: client.get_mesh(scene.id, 0),
                         lambda: client.info):
                self.refused("server", call)
            self.refused("server", collided.SceneBatch, meshes(), 3, server=client)
        for transport in ("grpc", "shared_memory", "calls"):
            self.refused("transport", collided.Session, meshes(), server="local", transport=transport)
        self.refused("delivery", collided.Session, meshes(), server="local", delivery="latest_wins", window=3)
        self.refused("part_devices", collided.Session, meshes(), server="local", part_devices=["cpu:0", "cpu:0"])

    def test_options_of_a_connection_are_refused(self):
        with self.assertRaises(collided.InvalidArgument) as caught:
            collided.Session(meshes(), server="local", token="secret")
        self.assertEqual(caught.exception.field, "token")

    def test_bad_options_name_their_field(self):
        for options, field in (({"device": "tpu"}, "device"), ({"mode": "dcd", "accuracy": "fast"}, "thickness"),
                               ({"expected_contacts": 2**32 - 1, "kinds": ["tt"]}, "triangle_triangle"),
                               ({"kinds": ["et"]}, "edge_triangle")):
            with self.assertRaises(collided.InvalidArgument) as caught:
                collided.Session(meshes(), server="local", **options)
            self.assertEqual(caught.exception.field, field)


class TheLibrary(unittest.TestCase):
    def loaded(self, path):
        with mock.patch.dict(os.environ, {"COLLIDED_LIBRARY": str(path)}):
            return collided.Session(meshes(), server="local")

    def test_a_missing_one_and_another_one_say_what_is_needed(self):
        for path in ("/nowhere/libcollided.so", "libc.so.6"):
            with self.assertRaises(collided.FailedPrecondition) as caught:
                self.loaded(path)
            self.assertIn(path, str(caught.exception))
            self.assertEqual(caught.exception.field, "server")

    def test_without_the_variable_it_is_the_packages_own_or_the_loaders(self):
        with mock.patch.dict(os.environ), tempfile.TemporaryDirectory() as folder, \
                mock.patch.object(collided.programs, "__file__", f"{folder}/programs.py"):
            del os.environ["COLLIDED_LIBRARY"]
            self.assertEqual(library.find_library(), "libcollided.so.1")
            os.makedirs(f"{folder}/lib")
            open(f"{folder}/lib/libcollided.so.1", "w").close()
            self.assertEqual(library.find_library(), f"{folder}/lib/libcollided.so.1")

    def test_structures_are_those_of_the_header(self):
        sizes = {"Mesh": 104, "SceneSpec": 144, "DeviceInfo": 160, "Topology": 72, "Update": 80, "Frame": 112, "Contacts": 88,
                 "Facts": 264, "MeshPair": 40}
        for name, size in sizes.items():
            self.assertEqual(ctypes.sizeof(getattr(library, name)), size, name)

    def test_no_daemon_is_needed(self):
        program = ("import collided, numpy as np\n"
                   "V = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0], [1, 1, 1], [1.25, 1, 9], [1, 1.25, 9]])\n"
                   "W = V - [0, 0, 2] * np.array([[0]] * 3 + [[1]] * 3)\n"
                   "print(collided.detect(V, W, [[0, 1, 2], [3, 4, 5]], server='local').toi.round(9).tolist())\n")
        kept = {name: os.environ[name] for name in ("PYTHONPATH", "COLLIDED_LIBRARY")}
        done = subprocess.run([sys.executable, *STRICT, "-c", program], text=True, capture_output=True, timeout=60,
                              env={**kept, "PATH": "/nowhere"}, check=False)
        self.assertEqual((done.stdout, done.stderr), ("[0.5]\n", ""))


if __name__ == "__main__":
    os.environ["COLLIDED_DAEMON"] = str(DAEMON)
    unittest.main(argv=sys.argv[:1])
