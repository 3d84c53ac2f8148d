#!/usr/bin/env python3
"""Positions and contacts as arrays on a real GPU, of a daemon and of the engine in this process: the same bytes as over the host.

usage: device_test.py DAEMON COLLIDECTL REPOSITORY. Skipped without a GPU. Arrays are those of torch and cupy, where they are
installed, and of libcudart.
"""

import ctypes
import importlib.util
import sys
import unittest

from device_arrays import InDlpack, OnDevice, with_a_number_before
from support import DAEMON, np

import collided
from collided.v1 import scene_pb2

LIBRARIES = [name for name in ("torch", "cupy") if importlib.util.find_spec(name)]
CUDART = "cudart"
FIELDS = ("elements", "stencils", "toi", "distance", "weights", "normals", "flags", "features")


def sheet(n, height, depth):
    """n x n vertices in waves of this depth."""
    u, v = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n), indexing="ij")
    vertices = np.stack([u, v, height + depth * np.sin(9 * u) * np.cos(7 * v)], -1).reshape(-1, 3)
    corner = np.arange(n * n).reshape(n, n)
    a, b, c, d = corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]
    triangles = np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    return vertices.astype(np.float32), triangles


class ByDlpack:
    """An array that has nothing but DLPack."""

    def __init__(self, array):
        self._array = array

    def __dlpack__(self, stream=None):
        return self._array.__dlpack__()

    def __dlpack_device__(self):
        return self._array.__dlpack_device__()


class Copied:
    """An array's bytes in memory of libcudart's."""

    def __init__(self, array):
        self._cuda = collided.gpu.Cuda()
        self.address = self._cuda.allocate(array.nbytes)
        self._cuda.copy(self.address, array.ctypes.data, array.nbytes)

    def __del__(self):
        self._cuda.free(self.address)


def by_cudart(array):
    return OnDevice(array, memory=Copied(array))


def by_dlpack(array):
    if LIBRARIES:
        return ByDlpack(on_device(LIBRARIES[0], array))
    return InDlpack(array, memory=Copied(with_a_number_before(array)))


def on_device(library, array):
    if library == CUDART:
        return by_cudart(array)
    if library == "cupy":
        import cupy
        return cupy.asarray(array)
    import torch
    return torch.from_numpy(array).cuda()


class Stream:
    """A stream of libcudart that does not wait for the default stream."""

    def __init__(self):
        self.cuda = collided.gpu.Cuda()
        self._library, self.stream = self.cuda._library, ctypes.c_void_p()
        self._library.cudaStreamCreateWithFlags(ctypes.byref(self.stream), ctypes.c_uint(1))
        self._scratch = self.cuda.allocate(2 << 28)

    def copy(self, to, source, size):
        """Copies behind the work that the stream holds."""
        self._library.cudaMemcpyAsync(ctypes.c_void_p(to), ctypes.c_void_p(source), ctypes.c_size_t(size), 3, self.stream)

    def work(self):
        """Keeps the device busy for about 0.1 s."""
        for _ in range(500):
            self.copy(self._scratch, self._scratch + (1 << 28), 1 << 28)

    def is_done(self):
        return self._library.cudaStreamQuery(self.stream) == 0

    def close(self):
        self.cuda.synchronize(self.stream.value)
        self._library.cudaStreamDestroy(self.stream)
        self.cuda.free(self._scratch)


class OnTheDevice(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.client = collided.Client(daemon=collided.OwnDaemon("--cuda-ipc", program=str(DAEMON)))
        cls.addClassCleanup(cls.client.close)
        if not any(device.backend == scene_pb2.BACKEND_CUDA for device in cls.client.info.devices):
            raise unittest.SkipTest("no GPU here")
        cls.server = cls.client
        low, high = sheet(200, 0, 0.05), sheet(150, 0.1, 0.02)
        cls.meshes = {"low": collided.Mesh(*low), "high": collided.Mesh(*high)}
        cls.frames = [high[0] - np.float32([0, 0, 0.03 * step]) for step in range(1, 6)]
        with collided.Session(cls.meshes, server=cls.client, backend="cuda") as session:
            cls.expected = [session.step({"high": frame}) for frame in cls.frames]

    def device_session(self, **options):
        session = collided.gpu.DeviceSession(self.meshes, server=self.server, backend="cuda", **options)
        self.addCleanup(session.close)
        return session

    def check_same(self, found, expected):
        self.assertEqual(len(found), len(expected))
        for field in FIELDS if len(found) else ():  # columns of no rows are not sent
            got = getattr(found, field).to_host()
            wanted = np.ascontiguousarray(getattr(expected, field)).astype(got.dtype)
            self.assertEqual(got.tobytes(), wanted.tobytes(), field)

    def check_same_bytes(self, make):
        with self.device_session(output_bytes=32 << 20) as session:
            for frame, expected in zip(self.frames, self.expected):
                found = session.step({"high": make(frame)})
                for kind in ("vt", "ee"):
                    self.check_same(getattr(found, kind), getattr(expected, kind))
        self.assertGreater(len(expected), 10000)

    def test_arrays_of_other_libraries_go_in(self):
        for library in [CUDART, *LIBRARIES]:
            with self.subTest(library):
                self.check_same_bytes(lambda frame: on_device(library, frame))

    def test_dlpack_goes_in(self):
        self.check_same_bytes(by_dlpack)

    @unittest.skipUnless(LIBRARIES, "neither torch nor cupy is installed")
    def test_contacts_are_arrays_of_other_libraries(self):
        with self.device_session() as session:
            for frame in self.frames:
                found = session.step({"high": on_device(LIBRARIES[0], frame)})
            library = __import__(LIBRARIES[0])
            toi = library.as_tensor(found.vt.toi, device="cuda") if LIBRARIES[0] == "torch" else library.asarray(found.vt.toi)
            self.assertEqual(float(toi.min()), float(self.expected[-1].vt.toi.min()))

    def test_a_frame_begins_after_the_callers_stream(self):
        stream = Stream()
        self.addCleanup(stream.close)
        moving, last = by_cudart(self.frames[0]), by_cudart(self.frames[1])
        moving.__cuda_array_interface__["stream"] = stream.stream.value
        with self.device_session(output_bytes=32 << 20) as session:
            session.step({"high": moving})
            stream.work()
            stream.copy(moving.memory.address, last.memory.address, self.frames[1].nbytes)
            self.assertFalse(stream.is_done())
            found = session.step({"high": moving})
            self.check_same(found.vt, self.expected[1].vt)

    def test_a_refused_edit_leaves_the_meshes_as_they_were(self):
        with self.device_session(window=2) as session:
            session.step({"high": by_cudart(self.frames[0])})
            edit = collided.Edit({"extra": collided.Mesh(vertices=np.full((3, 3), np.inf), triangles=[[0, 1, 2]])})
            session.send({"high": by_cudart(self.frames[0])}, edit=edit)
            with self.assertRaisesRegex(collided.FailedPrecondition, "an edit is in flight"):
                session.send(edit=edit)
            with self.assertRaises(collided.InvalidArgument):
                session.receive()
            found = session.step({"high": by_cudart(self.frames[1])})
            self.assertEqual(len(found.vt), len(self.expected[1].vt))


class InThisProcess(OnTheDevice):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.server = "local"

    def test_a_refused_edit_leaves_the_meshes_as_they_were(self):
        with self.device_session() as session:
            session.step({"high": by_cudart(self.frames[0])})
            with self.assertRaisesRegex(collided.Unimplemented, "edit is given"):
                session.step(edit=collided.Edit({"low": None}))
            self.check_same(session.step({"high": by_cudart(self.frames[1])}).vt, self.expected[1].vt)

    def test_what_is_not_on_the_device_is_refused(self):
        class OnHost(collided.gpu.Cuda):
            def allocate(self, size):
                self.buffer = ctypes.create_string_buffer(size + 64)
                return -(-ctypes.addressof(self.buffer) // 64) * 64

            def free(self, address):
                del self.buffer

        with self.device_session(cuda=OnHost()) as session:
            with self.assertRaisesRegex(collided.InvalidArgument, "room must lie in memory of cuda:0, but its byte 0 is in that of"):
                session.step({"high": by_cudart(self.frames[0])})
        with self.assertRaisesRegex(collided.FailedPrecondition, "the scene is on cpu:0"):
            collided.gpu.DeviceSession(self.meshes, server="local", backend="cpu")


if __name__ == "__main__":
    result = unittest.main(argv=sys.argv[:1], verbosity=2, exit=False).result
    if result.skipped and not result.testsRun:
        print(f"skipped: {result.skipped[0][1]}")
        sys.exit(77)
    sys.exit(not result.wasSuccessful())
