#!/usr/bin/env python3
"""The messages that the package has are those of the protocol.

usage: generated_test.py DAEMON COLLIDECTL REPOSITORY
"""

import filecmp
import importlib
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

try:
    import grpc  # noqa: F401
    from google.protobuf import descriptor_pb2, descriptor_pool
except ImportError as missing:
    print(f"skipped: {missing} (Debian: python3-grpcio, python3-protobuf)")
    sys.exit(77)
if not shutil.which("protoc"):
    print("skipped: protoc is not installed (Debian: protobuf-compiler)")
    sys.exit(77)

REPOSITORY = pathlib.Path(sys.argv[3])
PACKAGE, PROTO = REPOSITORY / "client" / "python", REPOSITORY / "proto"
ADVICE = "run client/python/generate"


def without_json_names(fields, messages):
    """Declarations as protoc writes them into Python: names for JSON follow from the others."""
    for field in fields:
        field.ClearField("json_name")
    for message in messages:
        without_json_names([*message.field, *message.extension], message.nested_type)


class Generated(unittest.TestCase):
    def test_its_messages_and_calls_are_those_of_the_protocol(self):
        """The test compares what a file declares, not how it is written, so that any compiler will do."""
        files = sorted(path.relative_to(PROTO) for path in (PROTO / "collided" / "v1").glob("*.proto"))
        done = subprocess.run(["protoc", "-I", PROTO, "--include_imports", "-o", "/dev/stdout", *files], capture_output=True, check=True,
                              timeout=60, cwd=PROTO)
        pool = descriptor_pool.DescriptorPool()
        for file in descriptor_pb2.FileDescriptorSet.FromString(done.stdout).file:
            pool.Add(file)
        for file in files:
            has, wanted = descriptor_pb2.FileDescriptorProto(), descriptor_pb2.FileDescriptorProto()
            importlib.import_module(f"collided.v1.{file.stem}_pb2").DESCRIPTOR.CopyToProto(has)
            pool.FindFileByName(str(file)).CopyToProto(wanted)
            for declaration in (has, wanted):
                without_json_names(declaration.extension, declaration.message_type)
            self.assertEqual(has, wanted, f"{file} has changed: {ADVICE}")
        from collided.v1.collision_service_pb2_grpc import CollisionServiceStub
        service = pool.FindServiceByName("collided.v1.CollisionService")
        with grpc.insecure_channel("unix:/none") as channel:
            self.assertEqual(set(vars(CollisionServiceStub(channel))), {method.name for method in service.methods}, ADVICE)

    def test_its_code_is_what_its_compiler_makes(self):
        with tempfile.TemporaryDirectory() as folder:
            made = subprocess.run([PACKAGE / "generate", folder], text=True, capture_output=True, timeout=60)
            if made.returncode == 77:
                self.skipTest(made.stderr.strip())
            self.assertEqual(made.returncode, 0, made.stderr)
            again, committed = pathlib.Path(folder, "collided", "v1"), PACKAGE / "collided" / "v1"
            names = sorted(path.name for path in again.iterdir())
            self.assertEqual(names, sorted(path.name for path in committed.iterdir() if path.is_file()), ADVICE)
            self.assertEqual(filecmp.cmpfiles(again, committed, names, shallow=False)[1:], ([], []), ADVICE)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
