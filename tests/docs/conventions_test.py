#!/usr/bin/env python3
"""proto/CONVENTIONS.md against a real daemon: its program, its table of what is filled, and what it says in prose.

usage: conventions_test.py DAEMON STUBS_FOLDER REPOSITORY
"""

import pathlib
import sys
import unittest

try:
    import grpc
    import numpy as np
except ImportError as missing:
    print(f"skipped: {missing} (Debian: python3-grpcio, python3-numpy)")
    sys.exit(77)

DAEMON, STUBS, REPOSITORY = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3])
sys.path[:0] = [STUBS, str(REPOSITORY / "tests" / "interop")]
from collided.v1 import collision_service_pb2 as api  # noqa: E402
from collided.v1 import collision_service_pb2_grpc as rpc  # noqa: E402
from collided.v1 import contact_pb2, frame_pb2, scene_pb2  # noqa: E402
from daemon import Daemon  # noqa: E402
from markdown import Page  # noqa: E402
from run_page import run_python  # noqa: E402

PAGE = Page(REPOSITORY / "proto" / "CONVENTIONS.md")
FIELDS = [contact_pb2.CONTACT_FIELD_ELEMENTS, contact_pb2.CONTACT_FIELD_STENCIL, contact_pb2.CONTACT_FIELD_TOI,
          contact_pb2.CONTACT_FIELD_DISTANCE, contact_pb2.CONTACT_FIELD_WEIGHTS, contact_pb2.CONTACT_FIELD_NORMAL,
          contact_pb2.CONTACT_FIELD_FLAGS, contact_pb2.CONTACT_FIELD_FEATURES]
TRIANGLE = np.array([[0, 1, 2]], "<u4").tobytes()
FLOOR = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0]], "<f4")
# Two tips, whose contacts come one after the other.
TIPS = [np.array([[x, 1, 1], [x + 0.25, 1, 9], [x, 1.25, 9]], "<f4") for x in (0.5, 1.5)]
FALLS = (1.25, 1.125)


def refusal_of(call):
    """The code's name, or None if the call succeeded."""
    try:
        call()
    except grpc.RpcError as error:
        return error.code().name
    return None


class Conventions(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon(DAEMON, "--max-scenes-per-client", "64")  # one for each row of a table
        cls.addClassCleanup(cls.daemon.kill)
        channel = grpc.insecure_channel(cls.daemon.address)
        cls.addClassCleanup(channel.close)
        cls.stub = rpc.CollisionServiceStub(channel)

    def make(self, mode="CCD", level="CERTIFIED", report="ALL", motion=scene_pb2.MESH_MOTION_DEFORMABLE, thickness=None,
             kinds=()):
        """A floor and two tips above it; DCD: by default with a thickness that both tips are within."""
        if thickness is None:
            thickness = 0.5 if mode == "DCD" else 0
        meshes = [scene_pb2.MeshSpec(name=name, vertex_count=3, triangles=TRIANGLE, motion=motion if name == "floor" else 0)
                  for name in ("floor", "tip 0", "tip 1")]
        spec = scene_pb2.SceneSpec(
            mode=f"DETECTION_MODE_{mode}", accuracy=f"ACCURACY_{level}", report=f"REPORT_{report}", fields=FIELDS,
            thickness=thickness, kinds=kinds, meshes=meshes)
        return self.stub.CreateScene(api.CreateSceneRequest(spec=spec), timeout=30).scene

    def fall(self, scene, frame_id=1, positions=None):
        """The tips fall onto the floor (CCD), or are near it (DCD)."""
        is_ccd = scene.spec.mode == scene_pb2.DETECTION_MODE_CCD
        updates = [frame_pb2.MeshUpdate(mesh=0, positions=(FLOOR if positions is None else positions).tobytes())]
        for i, (tip, by) in enumerate(zip(TIPS, FALLS)):
            fallen = tip - np.array([0, 0, by if is_ccd else 0.75], "<f4")
            start = tip.tobytes() if is_ccd else b""
            updates.append(frame_pb2.MeshUpdate(mesh=i + 1, start_positions=start, positions=fallen.tobytes()))
        request = api.DetectFrameRequest(scene_id=scene.scene_id, frame=frame_pb2.Frame(frame_id=frame_id, updates=updates))
        return self.stub.DetectFrame(request, timeout=30)

    def test_the_program_prints_what_the_page_shows(self):
        printed = run_python("\n".join(PAGE.blocks("python")), self.daemon.address, STUBS)
        self.assertEqual(printed, "".join(PAGE.blocks("text")))

    def test_the_table_says_what_is_filled(self):
        header, *rows = PAGE.table(after="## What is filled")
        self.assertEqual(header[:3], ["mode", "level", "report"])
        told = {(mode, level.strip(), report): cells
                for mode, levels, report, *cells in rows for level in levels.split(",")}
        self.assertEqual(len(told), 2 * 5 * 3)
        for case, cells in told.items():
            with self.subTest(case):
                self.assertEqual(self.filled(*case), cells)

    def filled(self, mode, level, report):
        """A row of the table, as the daemon answers."""
        try:
            done = self.fall(self.make(mode, level, report))
        except grpc.RpcError as error:
            self.assertEqual(error.code(), grpc.StatusCode.INVALID_ARGUMENT)
            return ["refused", "", "", "", ""]
        chunks, end = list(done.contacts), done.done
        count = sum(chunk.count for chunk in chunks)
        self.assertEqual(count, end.contact_count)
        for chunk in chunks:
            self.assertEqual((len(chunk.elements), len(chunk.stencils)), (8 * chunk.count, 16 * chunk.count))

        def has(*arrays):
            present = {bool(getattr(chunk, array)) for chunk in chunks for array in arrays} or {False}
            self.assertEqual(len(present), 1, "filled in some chunks, not in others")
            return present.pop()

        self.assertEqual(has("toi"), end.earliest_toi < 1)
        contacts = {0: "none", 1: "one"}.get(count, "all")
        return [contacts, *("yes" if it else "no" for it in (
            has("toi"), has("distance", "weights", "normals", "flags"), has("features"), end.any_contact))]

    def test_the_table_of_flags_has_their_masks(self):
        told = {name.strip("`"): int(mask) for name, mask, _ in PAGE.table(after="## Flags")[1:]}
        proto = {name.removeprefix("CONTACT_FLAG_"): value for name, value in contact_pb2.ContactFlag.items() if value}
        self.assertEqual(told, proto)

    def test_all_flags_are_as_the_page_says(self):
        for mode in ("CCD", "DCD"):
            for level in ("GUARDED", "CERTIFIED", "EXACT"):
                for chunk in self.fall(self.make(mode, level)).contacts:
                    for flags in chunk.flags:
                        self.assertIn(flags & 3, (1,) if level == "EXACT" else (1, 2))
        for mode in ("CCD", "DCD"):
            self.assertEqual({f for c in self.fall(self.make(mode, "FAST")).contacts for f in c.flags}, {0})

    def test_triangle_pairs_hold_ids_and_in_dcd_flags(self):
        kinds = [contact_pb2.CONTACT_KIND_TRIANGLE_TRIANGLE]
        crossing = TIPS[0] - np.array([0, 0, 2], "<f4")
        for mode, level in (("DCD", "CANDIDATES"), ("DCD", "CERTIFIED"), ("DCD", "EXACT"), ("CCD", "CANDIDATES")):
            scene = self.make(mode, level, kinds=kinds)
            updates = [frame_pb2.MeshUpdate(mesh=i, positions=positions.tobytes())
                       for i, positions in enumerate((FLOOR, crossing, TIPS[1]))]
            request = api.DetectFrameRequest(
                scene_id=scene.scene_id, frame=frame_pb2.Frame(frame_id=1, updates=updates))
            (chunk,) = self.stub.DetectFrame(request, timeout=30).contacts
            self.assertEqual(np.frombuffer(chunk.elements, "<u4").tolist(), [0, 1])
            self.assertEqual(list(chunk.flags), [1] if mode == "DCD" else [])
            self.assertFalse(chunk.stencils or chunk.toi or chunk.distance or chunk.weights or chunk.normals)
        self.assertEqual(refusal_of(lambda: self.make("CCD", "FAST", kinds=kinds)), "INVALID_ARGUMENT")

    def test_thickness_is_the_distance_between_the_features(self):
        for level in ("FAST", "GUARDED", "CERTIFIED", "EXACT"):
            near = self.fall(self.make("DCD", level, thickness=0.25)).contacts  # exactly as far apart as that
            self.assertEqual([chunk.count for chunk in near], [2], level)
            self.assertFalse(self.fall(self.make("DCD", level, thickness=0.249)).done.any_contact, level)
        (chunk,) = self.fall(self.make(thickness=0.25)).contacts
        np.testing.assert_allclose(np.frombuffer(chunk.distance, "<f8"), [0.25, 0.25], atol=1e-6)
        np.testing.assert_allclose(np.frombuffer(chunk.toi, "<f8"), [0.75 / fall for fall in FALLS], atol=1e-6)

    def test_without_start_positions_a_step_begins_where_the_last_one_ended(self):
        scene = self.make()
        (first,) = self.fall(scene).contacts
        self.assertEqual(first.count, 2)
        risen = frame_pb2.MeshUpdate(mesh=1, positions=TIPS[0].tobytes())
        frame = frame_pb2.Frame(frame_id=2, updates=[risen])
        request = api.DetectFrameRequest(scene_id=scene.scene_id, frame=frame)
        (chunk,) = [c for c in self.stub.DetectFrame(request, timeout=30).contacts
                    if c.kind == contact_pb2.CONTACT_KIND_VERTEX_TRIANGLE]
        elements = np.frombuffer(chunk.elements, "<u4").reshape(-1, 2).tolist()
        risen_at = np.frombuffer(chunk.toi, "<f8")[elements.index([3, 0])]
        np.testing.assert_allclose(risen_at, (FALLS[0] - 1) / FALLS[0], atol=1e-6)  # it was below the floor

    def test_weights_and_normals_come_only_if_asked_for(self):
        meshes = self.make().spec.meshes
        spec = scene_pb2.SceneSpec(mode="DETECTION_MODE_CCD", meshes=[
            scene_pb2.MeshSpec(name=mesh.name, vertex_count=3, triangles=TRIANGLE) for mesh in meshes])
        scene = self.stub.CreateScene(api.CreateSceneRequest(spec=spec), timeout=30).scene
        for chunk in self.fall(scene).contacts:
            self.assertTrue(chunk.elements and chunk.stencils and chunk.toi and chunk.distance and chunk.flags)
            self.assertFalse(chunk.weights or chunk.normals or chunk.features)

    def test_the_id_of_a_refused_frame_may_be_used_again(self):
        scene = self.make()
        self.fall(scene, frame_id=3)
        bad = FLOOR.copy()
        bad[0, 0] = np.nan
        self.assertEqual(refusal_of(lambda: self.fall(scene, 7, bad)), "INVALID_ARGUMENT")
        self.assertIsNone(refusal_of(lambda: self.fall(scene, 7)))
        self.assertEqual(refusal_of(lambda: self.fall(scene, 7)), "FAILED_PRECONDITION")

    def test_a_static_mesh_that_is_moved_is_refused(self):
        scene = self.make(motion=scene_pb2.MESH_MOTION_STATIC)
        self.fall(scene, 1)
        self.assertEqual(refusal_of(lambda: self.fall(scene, 2)), "INVALID_ARGUMENT")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
