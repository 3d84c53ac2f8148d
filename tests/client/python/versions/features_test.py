"""A client that is newer than the daemon refuses to ask for what the daemon does not know, and says what is missing.

The client is this package with a protocol that has gained fields, an enum value and a method in release 99.0.0; the daemon is the one
that was built, which is older than that.
"""

import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

REPOSITORY = pathlib.Path(sys.argv[3])
sys.path.append(str(REPOSITORY / "tests/proto"))
import newer


def newer_package(folder):
    """This package with the protocol of release 99.0.0."""
    protos = folder / "proto"
    newer.write_protocol(REPOSITORY, protos)
    out = folder / "package"
    shutil.copytree(REPOSITORY / "client/python/collided", out / "collided", ignore=shutil.ignore_patterns("__pycache__", "v1"))
    files = [str(file) for file in sorted(protos.glob("collided/v1/*.proto"))]
    subprocess.run(["protoc", f"-I{protos}", f"--python_out={out}", *files], check=True, stderr=subprocess.DEVNULL)
    subprocess.run(["protoc", f"-I{protos}", f"--grpc_out={out}", f"--plugin=protoc-gen-grpc={shutil.which('grpc_python_plugin')}",
                    str(protos / "collided/v1/collision_service.proto")],
                   check=True, stderr=subprocess.DEVNULL)
    return out


if not (shutil.which("protoc") and shutil.which("grpc_python_plugin")):
    print("skipped: protoc or grpc_python_plugin is not installed (Debian: protobuf-compiler, protobuf-compiler-grpc)")
    sys.exit(77)
FOLDER = tempfile.TemporaryDirectory()
sys.path.insert(0, str(newer_package(pathlib.Path(FOLDER.name))))

import collided
import compatibility
import numpy as np
from collided.connection.features import Features, additions
from collided.options import FIELDS
from collided.v1 import collision_service_pb2 as api
from collided.v1 import frame_pb2, scene_pb2
from collided.v1.contact_pb2 import ContactField
from support import STREAMS, TIP, Supervised, lowered, meshes


class NewerClient(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Supervised()
        cls.addClassCleanup(cls.daemon.close)

    def setUp(self):
        self.client = collided.Client(self.daemon.address)
        self.addCleanup(self.client.close)

    def refused(self, what, call, *arguments, **named):
        with self.assertRaises(collided.Unimplemented) as caught:
            call(*arguments, **named)
        error, version = caught.exception, self.client.info.version
        self.assertEqual(error.field, what)
        self.assertEqual(error.message, f"{what} needs a daemon of release {newer.RELEASE} or later; the daemon at {self.daemon.address} is {version}")

    def spec(self, **more):
        spec = scene_pb2.SceneSpec(mode=scene_pb2.DETECTION_MODE_CCD, **more)
        spec.meshes.add(name="a", vertex_count=3, triangles=b"\0\0\0\0\1\0\0\0\2\0\0\0")
        return spec

    def test_what_the_client_has_gained(self):
        self.assertLessEqual(newer.NAMES, additions().keys())
        self.assertEqual({additions()[name] for name in newer.NAMES}, {newer.RELEASE})

    def test_the_daemon_lists_what_its_own_protocol_has_gained(self):
        gained = compatibility.additions(compatibility.compile_protocol(REPOSITORY / "proto"))
        self.assertEqual(list(self.client.info.features), sorted(gained))

    def test_a_field_is_refused(self):
        for method, request in (("CreateScene", api.CreateSceneRequest), ("EstimateScene", api.EstimateSceneRequest)):
            self.refused("spec.mirrored", self.client.call, method, request(spec=self.spec(mirrored=True)))
        self.assertEqual(self.client.scenes(), [])

    def test_a_field_of_one_of_many_is_refused(self):
        spec = self.spec()
        spec.meshes.add(name="b", layers=2)
        self.refused("spec.meshes[1].layers", self.client.call, "CreateScene", api.CreateSceneRequest(spec=spec))

    def test_a_value_is_refused(self):
        self.refused("spec.report = REPORT_DEEPEST", self.client.call, "EstimateScene", api.EstimateSceneRequest(spec=self.spec(report=99)))

    def test_a_value_is_refused_where_it_is_an_option(self):
        self.refused("spec.report = REPORT_DEEPEST", collided.Scene, meshes(), server=self.client, report="deepest")

    def test_a_method_is_refused(self):
        self.refused("MoveScene", self.client.call, "MoveScene", api.GetMeshRequest(scene_id="a"))

    def test_what_is_not_set_is_no_hindrance(self):
        self.client.call("EstimateScene", api.EstimateSceneRequest(spec=self.spec(mirrored=False)))

    def test_an_option_of_a_frame_is_refused_and_the_stream_goes_on(self):
        for transport in (*STREAMS, "calls"):
            with self.subTest(transport), collided.Session(meshes(), server=self.client, transport=transport) as session:
                session.step(TIP)
                self.refused("frame.report = REPORT_DEEPEST", session.step, lowered(2), report="deepest")
                self.assertAlmostEqual(session.step(lowered(2)).earliest_toi, 0.5)
                self.assertEqual(session.reconnects, 0)

    def test_an_opening_is_refused(self):
        self.client.connect()
        self.refused("open.is_mirrored", self.client.check_known, api.OpenStream(is_mirrored=True), "open")

    def test_all_fields_of_contacts_are_those_that_the_daemon_knows(self):
        self.client.connect().features = Features(api.GetServerInfoResponse(version="0.1.0"), "here")
        known = [field for field in FIELDS if field not in ("features", "signed_distance")]
        with collided.Session(meshes(), server=self.client, mode="dcd_and_ccd", thickness=0.5) as session:
            asked = self.client.get_scene(session.scene.id).spec.fields
            self.assertEqual([ContactField.Name(field) for field in asked], [f"CONTACT_FIELD_{field.upper()}" for field in known])
            self.assertEqual(len(session.step({"tip": lowered(0.75)}, mode="dcd").kept), 1)
        with self.assertRaisesRegex(collided.Unimplemented, r"spec\.fields\[0\] = CONTACT_FIELD_FEATURES needs a daemon of release 0\.2\.0"):
            collided.Scene(meshes(), server=self.client, fields=["features"])
        solid = {"body": collided.Mesh(np.eye(4)[:, :3], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], solid=True)}
        with self.assertRaisesRegex(collided.Unimplemented, r"spec\.meshes\[0\]\.solid needs a daemon of release 0\.2\.0"):
            collided.Scene(solid, server=self.client, mode="dcd")

    def test_a_daemon_that_knows_it_is_asked(self):
        features = Features(api.GetServerInfoResponse(version="99.0.0", features=sorted(additions())), "here")
        features.check_method("MoveScene")
        features.check(frame_pb2.Frame(friction=0.5, report=99), "frame")
        with self.assertRaises(collided.Unimplemented):
            Features(api.GetServerInfoResponse(version="99.0.0", features=sorted(newer.NAMES - {"collided.v1.Frame.friction"})), "here").check(
                frame_pb2.Frame(friction=0.5), "frame")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
