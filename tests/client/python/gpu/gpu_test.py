#!/usr/bin/env python3
"""Positions and contacts on the device, without one: CUDA's calls on host memory, and a daemon that takes its handles.

What a GPU would add, that another process opens the memory, tests/integration/local has for the C++ client.
"""

import ctypes
import socket
import tempfile
import threading

from device_arrays import InDlpack, OnDevice
from host_cuda import HostCuda
from support import TIP, Case, lowered, main, meshes, np

import collided
from collided.columns import COLUMNS
from collided.gpu import Cuda, DeviceSession
from collided.v1 import collision_service_pb2 as api
from collided.v1 import contact_pb2, frame_pb2, local_pb2, scene_pb2


class Broken(HostCuda):
    def cudaMalloc(self, pointer, size):
        return 2

    def cudaGetErrorString(self, code):
        return b"out of memory"


class DeviceDaemon:
    """Answers a device session's frames of the floor and the tip with the contacts that another session finds; refuses edits.

    named: the meshes that each frame had positions of.
    """

    def __init__(self, path, session):
        self.session = session
        self.named = []
        self.listener = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self.listener.bind(path)
        self.listener.listen()
        self.thread = threading.Thread(target=self.serve, daemon=True)
        self.thread.start()

    def serve(self):
        connection, _ = self.listener.accept()
        with self.listener, connection:
            self.answer_frames(connection)

    def answer_frames(self, connection):
        opening = local_pb2.LocalRequest.FromString(connection.recv(1 << 16)).open
        assert opening.cuda_ipc_handle == opening.output_cuda_ipc_handle and not opening.input_bytes
        self.memory = int(opening.cuda_ipc_handle.rstrip(b"\0"))
        self.room = opening.output_bytes // opening.open.window
        scene = scene_pb2.Scene(scene_id=opening.open.scene_id)
        self.answer(connection, 0, opened=api.StreamOpened(scene=scene, window=opening.open.window))
        sent = 0
        while packet := connection.recv(1 << 16):
            frame = local_pb2.LocalRequest.FromString(packet).frame
            if frame.HasField("edit"):
                self.answer(connection, frame.frame_id, error=frame_pb2.FrameError(code=3, message="no edits", field="edit"))
                continue
            moved = {update.mesh: self.positions(update) for update in frame.updates}
            self.named.append(sorted(moved))
            moved.pop(0, None)
            contacts = self.session.step(moved, trial=frame.trial)
            done = contacts.answer.done
            if len(contacts):
                done.contacts.append(self.placed(contacts, sent % opening.open.window * self.room))
            self.answer(connection, frame.frame_id, done=done)
            sent += 1

    def answer(self, connection, frame_id, **what):
        response = api.StreamFramesResponse(frame_id=frame_id, **what)
        connection.send(local_pb2.LocalResponse(frame=response).SerializeToString())

    def positions(self, update):
        if not update.HasField("shared_positions"):
            return np.frombuffer(update.positions, "<f4").reshape(-1, 3)
        shared = update.shared_positions
        assert shared.offset % 8 == 0
        return np.frombuffer(ctypes.string_at(self.memory + shared.offset, shared.size), "<f4").reshape(-1, 3)

    def placed(self, contacts, at):
        chunk = contact_pb2.ContactChunk(kind=1, count=len(contacts))
        for name in filter(contacts.has_column, COLUMNS):
            data = np.ascontiguousarray(getattr(contacts, name)).tobytes()
            ctypes.memmove(self.memory + at, data, len(data))
            place = getattr(chunk.shared, name)
            place.offset, place.size = at, len(data)
            at += -(-len(data) // 64) * 64
        return chunk


class Device(Case):
    def setUp(self):
        self.cuda = Cuda(HostCuda())

    def device_session(self, **options):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        scene = collided.Scene(meshes(), server=self.server)
        self.addCleanup(scene.close)
        path = folder.name + "/local"
        self.daemon = DeviceDaemon(path, self.session())
        scene.client.info.local_socket = path
        session = DeviceSession(scene, cuda=self.cuda, output_bytes=8192, **options)
        self.addCleanup(session.close)
        return session

    def expect_hit_on_device(self, contacts):
        self.assertEqual((len(contacts.vt), len(contacts.ee), contacts.on_host), (1, 0, []))
        self.assertEqual(contacts.vt.elements.to_host().tolist(), [[3, 0]])
        np.testing.assert_allclose(contacts.vt.toi.to_host(), [0.5], atol=1e-3)
        described = contacts.vt.stencils.__cuda_array_interface__
        self.assertEqual((described["shape"], described["typestr"], described["version"]), ((1, 4), "<u4", 3))
        self.assertEqual(described["data"][0] % 64, self.address_of(contacts) % 64)
        self.assertTrue(contacts.done.any_contact)

    def address_of(self, contacts):
        return contacts.vt.stencils.owner.address

    def test_arrays_of_every_library_go_in_and_contacts_stay(self):
        for wrap in (OnDevice, InDlpack, np.asarray):
            session = self.device_session()
            self.assertEqual(len(session.step({"tip": wrap(TIP)}).vt), 0)
            self.expect_hit_on_device(session.step({"tip": wrap(lowered(2))}))
            self.assertEqual(len(session.step(wrap(lowered(2))).vt), 0)

    def test_a_window_of_frames_has_its_own_contacts(self):
        session = self.device_session(window=2)
        session.step({"tip": OnDevice(TIP)})
        for depth in (2, 0):
            session.send({"tip": OnDevice(lowered(depth))})
        self.refused(collided.FailedPrecondition, "whole window", session.send, {"tip": TIP})
        first, second = session.receive(), session.receive()
        self.expect_hit_on_device(first)
        self.expect_hit_on_device(second)
        self.assertNotEqual(first.vt.toi.address, second.vt.toi.address)

    def test_a_refused_edit_leaves_the_meshes_as_they_were(self):
        session = self.device_session(window=2)
        session.step({"tip": OnDevice(TIP)})
        session.send(edit=collided.Edit({"tip": None}))
        self.refused(collided.FailedPrecondition, "an edit is in flight", session.send, edit=collided.Edit({"tip": None}))
        self.refused(collided.InvalidArgument, "no edits", session.receive)
        self.expect_hit_on_device(session.step({"tip": OnDevice(lowered(2))}))

    def test_a_trial_is_no_first_frame(self):
        session = self.device_session(window=2)
        session.step({"tip": OnDevice(TIP)}, trial=True)
        session.step({"tip": OnDevice(TIP)})
        session.step({"tip": OnDevice(TIP)})
        self.assertEqual(self.daemon.named, [[0, 1], [0, 1], [1]])

    def test_memory_lives_as_long_as_its_arrays(self):
        session = self.device_session()
        contacts = session.step({"tip": OnDevice(lowered(2))})
        kept = session.step({"tip": OnDevice(TIP)}).vt.toi
        del contacts
        session.close()
        self.assertEqual(kept.to_host().shape, (1,))

    def test_arrays_that_cannot_go_are_refused_by_name(self):
        session = self.device_session()
        for pattern, wrong in ((r"positions\['tip'\] has dtype float64 on the device; it must be float32", TIP.astype(float)),
                               (r"positions\['tip'\] has shape \(2, 3\); it must be \(3, 3\)", TIP[:2])):
            for wrap in (OnDevice, InDlpack):
                self.refused(collided.InvalidArgument, pattern, session.step, {"tip": wrap(wrong)})
        gaps = OnDevice(TIP, strides=(24, 4))
        self.refused(collided.InvalidArgument, r"strides \(24, 4\) on the device; it must be contiguous", session.step, gaps)

    def test_a_daemon_without_cuda_ipc_and_a_device_without_memory_say_so(self):
        self.refused(collided.Error, "cuda", DeviceSession, meshes(), server=self.server, cuda=self.cuda)
        self.refused(collided.ResourceExhausted, "CUDA cannot allocate .* bytes: out of memory", DeviceSession, meshes(),
                     server=self.server, cuda=Cuda(Broken()))

    def test_contacts_that_lie_elsewhere_are_not_believed(self):
        session = self.device_session()
        contacts = collided.gpu.DeviceContacts(1)
        chunk = contact_pb2.ContactChunk(kind=1, count=1)
        chunk.shared.toi.offset, chunk.shared.toi.size = 16380, 8
        self.refused(collided.DataLoss, "toi has 8 bytes at offset 16380", contacts.add, chunk, session._memory)
        chunk.shared.toi.offset, chunk.shared.toi.size = 0, 16
        self.refused(collided.DataLoss, "needs 8", contacts.add, chunk, session._memory)


if __name__ == "__main__":
    main()
