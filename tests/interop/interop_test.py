#!/usr/bin/env python3
"""Talks to the daemon with stubs generated from the .proto files and nothing of ours.

usage: interop_test.py DAEMON STUBS_FOLDER

The scene: a large static triangle at z = 0, and above its inside a small one that stands on its
corner 0 (scene-wide vertex 3). In a frame that corner moves from z = 1 to z = 1 - depth: it meets
the large triangle at t = 1 / depth, and nothing else meets.
"""

import queue
import sys
import unittest

try:
    import grpc
    import numpy as np
except ImportError as missing:
    print(f"skipped: {missing} (Debian: python3-grpcio, python3-numpy)")
    sys.exit(77)

from daemon import Daemon

DAEMON, STUBS = sys.argv[1:3]
sys.path.insert(0, STUBS)
from collided.v1 import collision_service_pb2 as api  # noqa: E402
from collided.v1 import collision_service_pb2_grpc as rpc  # noqa: E402
from collided.v1 import contact_pb2, frame_pb2, scene_pb2  # noqa: E402

FLOOR = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0]], "<f4")
STANDING = np.array([[1, 1, 0], [1.25, 1, 8], [1, 1.25, 8]], "<f4")
TRIANGLE = np.array([[0, 1, 2]], "<u4").tobytes()
INVALID_ARGUMENT = 3


def standing_at(z):
    return (STANDING + np.array([0, 0, z], "<f4")).astype("<f4").tobytes()


def frame(frame_id, depth, with_floor):
    updates = [frame_pb2.MeshUpdate(mesh=1, start_positions=standing_at(1), positions=standing_at(1 - depth))]
    if with_floor:
        updates.insert(0, frame_pb2.MeshUpdate(mesh=0, positions=FLOOR.tobytes()))
    return frame_pb2.Frame(frame_id=frame_id, updates=updates)


def spec():
    return scene_pb2.SceneSpec(
        display_name="interop", mode=scene_pb2.DETECTION_MODE_CCD, position_format=scene_pb2.POSITION_FORMAT_F32,
        meshes=[
            scene_pb2.MeshSpec(name="floor", vertex_count=3, triangles=TRIANGLE, motion=scene_pb2.MESH_MOTION_STATIC),
            scene_pb2.MeshSpec(name="standing", vertex_count=3, triangles=TRIANGLE),
        ])


class Stream:
    """A frame stream, one frame at a time."""

    def __init__(self, stub, scene_id):
        self.requests = queue.Queue()
        self.responses = stub.StreamFrames(iter(self.requests.get, None), timeout=60)
        self.requests.put(api.StreamFramesRequest(open=api.OpenStream(scene_id=scene_id)))
        self.opened = next(self.responses)

    def ask(self, frame_message):
        """The contact chunks and the closing message of one frame."""
        self.requests.put(api.StreamFramesRequest(frame=frame_message))
        chunks = []
        for response in self.responses:
            assert response.frame_id == frame_message.frame_id, response
            if response.WhichOneof("response") != "contacts":
                return chunks + list(response.done.contacts), response
            chunks.append(response.contacts)
        raise AssertionError("the stream ended within a frame")

    def close(self):
        self.requests.put(None)
        return list(self.responses)


class Interop(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        daemon = Daemon(DAEMON)
        cls.addClassCleanup(daemon.kill)
        cls.addClassCleanup(daemon.stop)
        cls.channel = grpc.insecure_channel(daemon.address)
        cls.addClassCleanup(cls.channel.close)
        cls.stub = rpc.CollisionServiceStub(cls.channel)

    def make_scene(self):
        scene = self.stub.CreateScene(api.CreateSceneRequest(spec=spec()), timeout=30).scene
        self.addCleanup(lambda: self.stub.DeleteScene(api.DeleteSceneRequest(scene_id=scene.scene_id), timeout=30))
        self.assertEqual((scene.vertex_count, scene.edge_count, scene.triangle_count), (6, 6, 2))
        return scene.scene_id

    def expect_contact(self, chunks, end, depth):
        self.assertEqual(end.WhichOneof("response"), "done", end)
        self.assertEqual(end.done.contact_count, 1)
        self.assertEqual(len(chunks), 1)
        chunk = chunks[0]
        self.assertEqual(chunk.kind, contact_pb2.CONTACT_KIND_VERTEX_TRIANGLE)
        self.assertEqual(chunk.count, 1)
        np.testing.assert_array_equal(np.frombuffer(chunk.elements, "<u4").reshape(-1, 2), [[3, 0]])
        np.testing.assert_array_equal(np.frombuffer(chunk.stencils, "<u4").reshape(-1, 4), [[3, 0, 1, 2]])
        toi = np.frombuffer(chunk.toi, "<f8")
        np.testing.assert_allclose(toi, [1 / depth], atol=1e-3)
        self.assertLessEqual(toi[0], 1 / depth)
        self.assertTrue(end.done.any_contact)
        self.assertEqual(end.done.earliest_toi, toi[0])

    def test_ten_frames_have_the_contact_that_was_built_in(self):
        stream = Stream(self.stub, self.make_scene())
        self.assertEqual(stream.opened.WhichOneof("response"), "opened")
        for i in range(10):
            depth = 1.25 + 0.25 * i
            self.expect_contact(*stream.ask(frame(i + 1, depth, with_floor=i == 0)), depth)
        self.assertEqual(stream.close(), [])

    def test_a_frame_without_contact_is_empty(self):
        stream = Stream(self.stub, self.make_scene())
        chunks, end = stream.ask(frame(1, 0.5, with_floor=True))
        self.assertEqual((chunks, end.done.contact_count, end.done.earliest_toi), ([], 0, 1))
        self.assertTrue(end.done.metrics.stages)
        self.assertFalse(end.done.any_contact)
        stream.close()

    def test_an_override_holds_for_its_frame_alone(self):
        stream = Stream(self.stub, self.make_scene())
        asked = frame(1, 2, with_floor=True)
        asked.report = scene_pb2.REPORT_ANY_HIT
        asked.accuracy = scene_pb2.ACCURACY_FAST
        asked.delta = 1e-3
        chunks, end = stream.ask(asked)
        self.assertEqual((chunks, end.done.contact_count, end.done.any_contact), ([], 0, True))
        self.expect_contact(*stream.ask(frame(2, 4, with_floor=False)), 4)
        stream.close()

    def test_a_nan_is_refused_and_the_next_frame_is_right(self):
        stream = Stream(self.stub, self.make_scene())
        self.expect_contact(*stream.ask(frame(1, 2, with_floor=True)), 2)
        bad = frame(2, 2, with_floor=False)
        positions = STANDING.copy()
        positions[1, 2] = np.nan
        bad.updates[0].positions = positions.tobytes()
        chunks, end = stream.ask(bad)
        self.assertEqual((chunks, end.WhichOneof("response"), end.error.code), ([], "error", INVALID_ARGUMENT))
        self.assertTrue(end.error.message)
        self.expect_contact(*stream.ask(frame(3, 4, with_floor=False)), 4)
        stream.close()

    def test_the_unary_call_gives_the_same(self):
        request = api.DetectFrameRequest(scene_id=self.make_scene(), frame=frame(1, 2, with_floor=True))
        answer = self.stub.DetectFrame(request, timeout=30)
        self.assertEqual([c.count for c in answer.contacts], [1])
        np.testing.assert_allclose(np.frombuffer(answer.contacts[0].toi, "<f8"), [0.5], atol=1e-3)

    def test_an_unknown_scene_is_not_found(self):
        with self.assertRaises(grpc.RpcError) as caught:
            self.stub.GetScene(api.GetSceneRequest(scene_id="no such scene"), timeout=30)
        self.assertEqual(caught.exception.code(), grpc.StatusCode.NOT_FOUND)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
