#!/usr/bin/env python3
"""Scenes on several devices of a daemon, which are told as those on one are: to the bit."""

from recovery_test import break_connection, play, pose, scene, sheet
from support import STREAMS, TRANSPORTS, Case, assert_same, main, meshes, np

import collided
from collided.v1 import batch_pb2
from collided.v1 import collision_service_pb2 as api

BOTH = ("cpu:0", "cpu:1")


class OnTwoDevices(Case):
    MEGABYTES = 64  # of each
    options = ("--backend", "cpu", "--device", ",".join(BOTH), "--max-device-mb", str(2 * MEGABYTES),
               "--max-device-mb-per-client", str(2 * MEGABYTES), "--max-scene-mb", str(2 * MEGABYTES))

    def devices(self):
        """Of the daemon, by id."""
        with collided.Client(self.server) as client:
            info = client.call("GetServerInfo", api.GetServerInfoRequest())
            return {device.id: device for device in info.devices}

    def held(self):
        """Bytes that scenes hold of each device, where none is awaited."""
        return {name: device.max_bytes - device.free_bytes for name, device in self.devices().items()}


FIELDS = tuple(field for field in collided.options.FIELDS if field != "features")  # which parts do not tell


class Answers(OnTwoDevices):
    def both(self, what, part_devices, **options):
        """A session on one device and one in parts, to which the same happens."""
        return [self.session(what(), **options, **place) for place in ({"device": "cpu:0"}, {"part_devices": part_devices})]

    def expect_same(self, one, parts):
        self.assertEqual([answer.frame_id for answer in one], [answer.frame_id for answer in parts])
        self.assertGreater(sum(map(len, one)), 100)
        for of_one, of_parts in zip(one, parts):
            assert_same(self, of_one, of_parts)

    def test_continuous_frames_of_all_kinds_have_the_same_bytes(self):
        for transport in STREAMS:
            for part_devices in (BOTH, ("cpu:1", "cpu:0", "cpu:1")):
                with self.subTest(transport=transport, part_devices=part_devices):
                    sessions = self.both(scene, part_devices, position_format="f64", edit_bytes=8192, window=3,
                                         transport=transport)
                    self.assertEqual([session.is_local for session in sessions], [transport == "shared_memory"] * 2)
                    self.expect_same(*(play(session, 25) for session in sessions))
                    for session in sessions:
                        session.close()

    def test_discrete_frames_do(self):
        start = sheet(8, 0.06)[0]
        for transport in TRANSPORTS:
            with self.subTest(transport):
                sessions = self.both(scene, BOTH, mode="dcd", thickness=0.03, kinds=("vt", "ee", "tt"), fields=FIELDS, transport=transport)
                answers = [[session.step({"cloth": (start - [0, 0, 0.01 * step]).astype("<f4"),
                                          "ball": collided.Rigid(pose(step))}) for step in range(1, 8)]
                           for session in sessions]
                self.expect_same(*answers)

    def test_a_stream_that_breaks_is_resumed(self):
        for transport in STREAMS:
            sessions = self.both(scene, BOTH, position_format="f64", edit_bytes=8192, window=3, transport=transport)
            told = [play(session, 9) for session in sessions]
            break_connection(sessions[1])
            for session, answers in zip(sessions, told):
                answers.append(session.step({"cloth": sheet(8, 0)[0] - [0, 0, 0.02]}))
            self.expect_same(*told)
            self.assertEqual((sessions[1].reconnects, sessions[1].recreations), (1, 0))

    def test_a_frame_tells_what_each_part_had(self):
        one, parts = self.both(scene, BOTH, transport="grpc")
        moved = {"cloth": (sheet(8, 0)[0] - [0, 0, 0.05]).astype("<f4")}
        contacts, of_parts = one.step(moved), parts.step(moved)
        self.assertEqual(list(contacts.metrics.parts), [])
        told = of_parts.metrics.parts
        self.assertEqual(len(told), 2)
        self.assertAlmostEqual(sum(part.share for part in told), 1)
        self.assertEqual(sum(part.contacts for part in told), len(contacts))
        self.assertEqual(sum(part.pairs for part in told), contacts.metrics.counts.pairs)
        self.assertAlmostEqual(max(part.step_milliseconds for part in told), of_parts.metrics.step_milliseconds)


class Memory(OnTwoDevices):
    def test_each_device_counts_its_parts_until_the_scene_ends(self):
        self.assertEqual(self.held(), {"cpu:0": 0, "cpu:1": 0})
        session = self.session(scene(), part_devices=BOTH)
        session.step({"cloth": sheet(8, 0)[0].astype("<f4")})
        message = session.scene.refresh()
        self.assertEqual((list(message.spec.part_devices), message.device_id, message.spec.device), (list(BOTH), "cpu:0", ""))
        by_part = [sum(part.bytes for part in message.memory if part.part.startswith(f"parts[{k}].")) for k in (0, 1)]
        whole = sum(part.bytes for part in message.memory) - sum(by_part)
        held, devices = self.held(), self.devices()
        self.assertEqual([devices[name].scenes for name in BOTH], [1, 1])
        self.assertGreaterEqual(held["cpu:1"], by_part[1])
        self.assertGreaterEqual(held["cpu:0"], by_part[0] + whole)
        self.assertLess(held["cpu:1"], by_part[1] + whole)
        session.close()
        self.assertEqual(self.held(), {"cpu:0": 0, "cpu:1": 0})

    def test_two_parts_on_one_device_are_one_scene_there(self):
        session = self.session(scene(), part_devices=("cpu:1", "cpu:1"))
        session.step({"cloth": sheet(8, 0)[0].astype("<f4")})
        self.assertEqual([self.devices()[name].scenes for name in BOTH], [0, 1])
        self.assertEqual(self.held()["cpu:0"], 0)
        session.close()

    def test_an_estimate_has_the_memory_of_each_part(self):
        with collided.Client(self.server) as client:
            one, parts = (client.estimate(scene(), **place) for place in ({"device": "cpu:1"}, {"part_devices": BOTH[::-1]}))
        bytes_of_one = {part.part: part.bytes for part in one.memory}
        bytes_of_parts = {part.part: part.bytes for part in parts.memory}
        self.assertEqual(parts.device_id, "cpu:1")
        for k in (0, 1):
            self.assertEqual(bytes_of_parts[f"parts[{k}].positions"], bytes_of_one["positions"])
        self.assertIn("merge", parts.stages)

    def test_a_part_that_has_no_room_on_its_device_refuses_the_scene(self):
        vertices, triangles = sheet(200, 0)  # four parts have room on two devices alone
        large = collided.Mesh(vertices.astype("<f4"), triangles)
        error = self.refused(collided.ResourceExhausted, "max_device_bytes of cpu:1 is .* need at least", self.session,
                             {"large": large}, part_devices=("cpu:1",) * 4)
        self.assertIn("the vertices and triangles of spec.meshes", str(error))
        self.session({"large": large}, part_devices=BOTH * 2)


class Refusals(OnTwoDevices):
    def expect_refused(self, kind, field, message, **options):
        error = self.refused(kind, message, self.session, meshes(), **options)
        self.assertEqual(error.field, field)

    def test_devices_that_cannot_be(self):
        bad, missing = collided.InvalidArgument, collided.FailedPrecondition
        self.expect_refused(missing, "spec.part_devices[1]", r"spec\.part_devices\[1\] is cpu:2, but this daemon serves cpu:0",
                            part_devices=("cpu:0", "cpu:2"))
        self.expect_refused(missing, "spec.part_devices[0]", "is cuda:0, but this daemon serves", part_devices=("cuda:0",))
        self.expect_refused(bad, "spec.part_devices[0]", 'is "", but must be', part_devices=("",))
        self.expect_refused(bad, "spec.part_devices[0]", 'is "gpu", but must be cpu:0 or cpu:1', part_devices=("gpu",))
        self.expect_refused(bad, "spec.part_devices[0]", "is cpu:0, but spec.backend is BACKEND_CUDA|no usable CUDA",
                            part_devices=("cpu:0",), backend="cuda")
        self.expect_refused(bad, "spec.part_devices", "has 5 or more parts on cpu:1, more than 4", part_devices=("cpu:1",) * 5)
        self.expect_refused(bad, "spec.part_devices", "has 65 parts, more than 64", part_devices=("cpu:1",) * 65)
        self.expect_refused(bad, "spec.device", "spec.part_devices says where", part_devices=BOTH, device="cpu:1")

    def test_what_parts_do_not_do(self):
        self.expect_refused(collided.InvalidArgument, "spec.reuse", "a scene in parts has no lists of neighbours",
                            part_devices=BOTH, reuse="on")
        with collided.Client(self.server) as client:
            with collided.Scene(meshes(), server=client, part_devices=BOTH) as scene_in_parts:
                spec = scene_in_parts.refresh().spec
            request = batch_pb2.CreateScenesRequest(spec=spec, count=2)
            error = self.refused(collided.InvalidArgument, "a set of worlds is on one device", client.call, "CreateScenes",
                                 request)
        self.assertEqual(error.field, "spec.part_devices")


if __name__ == "__main__":
    main()
