"""The protocol breaks no client of a release, and what it has added to requests says so.

The releases are the images in proto/releases, made by tests/proto/make_image. buf compares the same ones in proto.breaking, where
it is installed; this test needs protoc alone. Each rule is tested on a protocol that breaks it.
"""

import pathlib
import re
import shutil
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

import compatibility

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
PROTO = REPOSITORY / "proto"
IMAGES = sorted(PROTO.glob("releases/*.binpb"))


class Releases(unittest.TestCase):
    def test_there_is_an_image(self):
        self.assertIn("0.1.0.binpb", [image.name for image in IMAGES])

    def test_no_release_is_broken(self):
        now = compatibility.compile_protocol(PROTO)
        for image in IMAGES:
            with self.subTest(image.name):
                self.assertEqual(compatibility.breaks(compatibility.read_image(image), now), [])

    def test_what_requests_have_gained_names_its_release(self):
        now = compatibility.compile_protocol(PROTO)
        self.assertEqual(compatibility.unnamed(compatibility.read_image(PROTO / "releases/0.1.0.binpb"), now), [])
        for name, release in compatibility.additions(now).items():
            self.assertRegex(release, r"^\d+\.\d+\.\d+$", name)


class Changes(unittest.TestCase):
    """Changes of a copy of the protocol, compared with the copy as it was."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        shutil.copytree(PROTO / "collided", self.folder / "collided")
        self.before = compatibility.compile_protocol(self.folder)

    def change(self, name, pattern, replacement):
        file = self.folder / f"collided/v1/{name}.proto"
        text, count = re.subn(pattern, replacement, file.read_text(), count=1, flags=re.MULTILINE)
        self.assertEqual(count, 1, pattern)
        file.write_text(text)

    def broken(self):
        return compatibility.breaks(self.before, compatibility.compile_protocol(self.folder))

    def refused(self, name, pattern, replacement, *complaints):
        self.change(name, pattern, replacement)
        self.assertEqual(self.broken(), sorted(complaints))

    def test_nothing_is_compatible(self):
        self.assertEqual(self.broken(), [])

    def test_a_new_field_is_compatible(self):
        self.refused("frame", r"^message Frame \{", "message Frame {\n  bool mirrored = 99;")

    def test_another_number(self):
        self.refused("frame", r"uint64 frame_id = 1;", "uint64 frame_id = 99;",
                     "collided.v1.Frame.frame_id = 1 is gone and not reserved")

    def test_another_name(self):
        self.refused("frame", r"uint64 frame_id = 1;", "uint64 number = 1;", "collided.v1.Frame: 1 was frame_id, is number")

    def test_another_type(self):
        self.refused("frame", r"uint64 frame_id = 1;", "fixed64 frame_id = 1;", "collided.v1.Frame.frame_id: type was 4, is 6")

    def test_another_message(self):
        self.refused("frame", r"SceneEdit edit = 11;", "MeshEdit edit = 11;",
                     "collided.v1.Frame.edit: type_name was .collided.v1.SceneEdit, is .collided.v1.MeshEdit")

    def test_one_instead_of_many(self):
        self.refused("frame", r"repeated MeshUpdate updates = 3;", "MeshUpdate updates = 3;",
                     "collided.v1.Frame.updates: label was 3, is 1")

    def test_presence_that_is_lost(self):
        self.refused("frame", r"optional double delta = 4;", "double delta = 4;",
                     "collided.v1.Frame.delta: oneof was '_delta', is ''",
                     "collided.v1.Frame.delta: proto3_optional was True, is False")

    def test_a_field_that_leaves_its_oneof(self):
        self.refused("local", r"(  oneof response \{\n(?:.*\n)*?)    // Last packet.\n    LocalClosed closed = 2;\n  \}",
                     r"\1  }\n  LocalClosed closed = 2;", "collided.v1.LocalResponse.closed: oneof was 'response', is ''")

    def test_a_field_that_is_gone_must_be_reserved(self):
        self.refused("frame", r"^  bool trial = 8;", "", "collided.v1.Frame.trial = 8 is gone and not reserved")
        self.refused("frame", r"^message Frame \{", "message Frame {\n  reserved 8;",
                     "collided.v1.Frame.trial = 8 is gone and not reserved")
        self.change("frame", r"^  reserved 8;", '  reserved 8;\n  reserved "trial";')
        self.assertEqual(self.broken(), [])

    def test_what_is_reserved_stays_so(self):
        self.refused("collision_service", r'^  reserved 2;\n  reserved "contacts";', "",
                     "collided.v1.WatchSceneResponse: 2 to 2 is reserved no longer",
                     "collided.v1.WatchSceneResponse: contacts is reserved no longer")

    def test_an_enum_value_with_another_number(self):
        self.refused("scene", r"REPORT_ANY_HIT = 3;", "REPORT_ANY_HIT = 4;",
                     "collided.v1.Report.REPORT_ANY_HIT = 3 is gone and not reserved")

    def test_a_method_that_is_gone(self):
        self.refused("collision_service", r"^  rpc GetMesh.*;", "", "collided.v1.CollisionService.GetMesh is gone")

    def test_a_method_that_streams_no_longer(self):
        self.refused("collision_service", r"returns \(stream WatchSceneResponse\)", "returns (WatchSceneResponse)",
                     "collided.v1.CollisionService.WatchScene: server_streaming was True, is False")

    def test_a_message_that_is_gone(self):
        self.change("error_details", r"^message RpcStatus \{", "message CallStatus {")
        self.assertEqual(self.broken(), ["collided.v1.RpcStatus is gone"])

    def unnamed(self):
        return compatibility.unnamed(self.before, compatibility.compile_protocol(self.folder))

    def add(self, option=""):
        """A field, an enum value and a method; and a field that no request has."""
        field, value = (f" [({kind}_added_in) = {option}]" if option else "" for kind in ("field", "value"))
        body = f"{{ option (method_added_in) = {option}; }}" if option else ";"
        self.change("collision_service", r'^import "collided', 'import "collided/v1/added_in.proto";\nimport "collided')
        self.change("scene", r"^message MeshEdit \{", f"message MeshEdit {{\n  bool mirrored = 99{field};")
        self.change("scene", r"REPORT_ANY_HIT = 3;", f"REPORT_ANY_HIT = 3;\n  REPORT_LAST = 4{value};")
        self.change("collision_service", r"^  rpc GetMesh\(", f"  rpc Ping(GetMeshRequest) returns (GetMeshResponse){body}\n  rpc GetMesh(")
        self.change("collision_service", r"^message GetMeshResponse \{", "message GetMeshResponse {\n  bool is_mirrored = 99;")

    def test_what_requests_gain_must_name_its_release(self):
        self.add()
        self.assertEqual(self.unnamed(), ["collided.v1.CollisionService.Ping", "collided.v1.MeshEdit.mirrored", "collided.v1.REPORT_LAST"])

    def test_what_requests_gain_and_names_its_release_is_found(self):
        self.add('"0.2.0"')
        self.assertEqual(self.unnamed(), [])
        self.assertEqual(compatibility.additions(compatibility.compile_protocol(self.folder)), compatibility.additions(self.before) |
                         dict.fromkeys(["collided.v1.CollisionService.Ping", "collided.v1.MeshEdit.mirrored", "collided.v1.REPORT_LAST"], "0.2.0"))


if __name__ == "__main__":
    unittest.main(verbosity=2)
