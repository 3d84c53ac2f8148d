#!/usr/bin/env python3
"""A session on the device of an engine in this process, whose device is the host: contacts stay where the session has room.

On a GPU device_test.py does the same. usage: in_process_test.py DAEMON COLLIDECTL REPOSITORY, with COLLIDED_LIBRARY in the
environment
"""

import sys
import unittest

from device_arrays import InDlpack, OnDevice
from host_cuda import CpuMemory
from support import FLOOR, ONE, TIP, lowered, meshes, np

import collided
from collided.columns import COLUMNS
from collided.gpu import DeviceSession


def device_session(made=None, **options):
    return DeviceSession(made or meshes(), server="local", device="cpu", cuda=CpuMemory(), **options)


class InThisProcess(unittest.TestCase):
    def test_arrays_of_every_library_go_in_and_contacts_stay(self):
        for wrap in (OnDevice, InDlpack, np.asarray):
            with self.subTest(wrap.__name__), device_session() as session:
                self.assertEqual(len(session.step({"tip": wrap(TIP)}).vt), 0)
                contacts = session.step({"tip": wrap(lowered(2))})
                self.assertEqual((len(contacts.vt), len(contacts.ee), contacts.on_host), (1, 0, []))
                self.assertEqual(contacts.vt.elements.to_host().tolist(), [[3, 0]])
                np.testing.assert_allclose(contacts.vt.toi.to_host(), [0.5], atol=1e-9)
                self.assertTrue(contacts.done.any_contact)
                self.assertGreater(contacts.done.metrics.step_milliseconds, 0)

    def many(self, count):
        """As many tips above one floor."""
        offsets = np.linspace(0, 1, count, dtype="<f4")[:, None, None] * np.float32([0.5, 0.5, 0])
        tips = (TIP + offsets).reshape(-1, 3).astype("<f4")
        triangles = np.arange(3 * count, dtype="<u4").reshape(-1, 3)
        return {"floor": collided.Mesh(FLOOR, ONE, motion="static"),
                "tips": collided.Mesh(tips, triangles, self_contacts=False)}, tips

    def test_contacts_are_those_of_a_session_and_the_rest_comes_to_the_host(self):
        made, tips = self.many(100)
        down = {"tips": tips - np.float32([0, 0, 2])}
        fields = collided.options.FIELDS
        with collided.Session(made, server="local", device="cpu", fields=fields) as session:
            expected = session.step(down)
        self.assertEqual(len(expected.vt), 100)
        for room, on_host in ((0, [100]), (4000, range(1, 100)), (1 << 20, [0])):
            with device_session(made, output_bytes=room, fields=fields) as session:
                session.step({"tips": OnDevice(tips)})
                found = session.step({"tips": OnDevice(down["tips"])})
                rest = [part for part in found.on_host if part.kind == 1]
                late = sum(part.count for part in rest)
                self.assertIn(late, on_host)
                for name in filter(expected.vt.has_column, COLUMNS):
                    here = [getattr(found.vt, name).to_host()] if len(found.vt) else []
                    both = np.concatenate(here + [part.arrays[name] for part in rest])
                    self.assertEqual(both.tobytes(), np.ascontiguousarray(getattr(expected.vt, name)).tobytes(), name)

    def test_what_limits_a_way_is_that_of_a_session(self):
        made, tips = self.many(100)
        down = {"tips": tips - np.float32([0, 0, 2])}
        with collided.Session(made, server="local", device="cpu", min_separation=0.1) as session:
            expected = session.step(down, advance="per_vertex", limits=True)
        self.assertEqual(len(expected.limits), 100)
        for room in (0, 1 << 20):
            with device_session(made, output_bytes=room, min_separation=0.1) as session:
                self.assertEqual(len(session.step({"tips": OnDevice(tips)}).limits), 0)
                found = session.step({"tips": OnDevice(down["tips"])}, advance="per_vertex", limits=True)
                self.assertEqual(found.limits.records.tobytes(), expected.limits.records.tobytes())
                self.assertEqual(found.limits.meshes.tolist(), expected.limits.meshes.tolist())
                with self.assertRaisesRegex(collided.FailedPrecondition, "of a DeviceSession"):
                    found.limits.points

    def test_arrays_may_change_once_they_are_sent_and_a_window_has_its_own_contacts(self):
        with device_session(window=2) as session:
            moving = TIP.copy()
            session.step({"tip": OnDevice(moving)})
            for depth in (2, 0):
                moving[:] = lowered(depth)
                session.send({"tip": OnDevice(moving)})
            with self.assertRaisesRegex(collided.FailedPrecondition, "whole window"):
                session.send({"tip": TIP})
            first, second = session.receive(), session.receive()
            self.assertEqual((len(first.vt), len(second.vt)), (1, 1))
            self.assertNotEqual(first.vt.toi.address, second.vt.toi.address)
            self.assertEqual(first.vt.toi.address % 64, 0)

    def test_memory_lives_as_long_as_its_arrays(self):
        with device_session() as session:
            session.step({"tip": OnDevice(TIP)})
            kept = session.step({"tip": OnDevice(lowered(2))}).vt.toi
        self.assertEqual(kept.to_host().shape, (1,))

    def test_what_is_refused_names_its_field_and_the_session_goes_on(self):
        with device_session() as session:
            session.step({"tip": OnDevice(TIP)})
            for error, field, arguments in ((collided.InvalidArgument, "updates[0].end", {"positions": OnDevice(TIP * np.inf)}),
                                            (collided.Unimplemented, "edit", {"edit": collided.Edit({"tip": None})})):
                with self.assertRaises(error) as caught:
                    session.step(**arguments)
                self.assertEqual(caught.exception.field, field)
            self.assertEqual(len(session.step({"tip": OnDevice(lowered(2))}).vt), 1)
        for window in (0, 1025):
            with self.assertRaisesRegex(collided.ResourceExhausted, f"window is {window}; it must be from 1 to 1024"):
                device_session(window=window)

    def test_a_scene_elsewhere_is_refused(self):
        memory = CpuMemory()
        memory.backend = "cuda"
        with self.assertRaisesRegex(collided.FailedPrecondition, "the scene is on cpu:0, and a DeviceSession needs one on cuda"):
            DeviceSession(meshes(), server="local", device="cpu", cuda=memory)

    def test_one_stream_at_a_time(self):
        with collided.Scene(meshes(), server="local", device="cpu") as scene:
            with DeviceSession(scene, cuda=CpuMemory()) as session:
                session.step({"tip": OnDevice(TIP)})
                with self.assertRaises(collided.FailedPrecondition):
                    scene.session()
                with scene.session(take_over=True) as other, self.assertRaises(collided.Unavailable):
                    session.step({"tip": OnDevice(TIP)})
            with scene.session() as other:
                self.assertEqual(len(other.step({"tip": lowered(2)}).vt), 1)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
