"""Builds the package: its modules, and collided/v1, which protoc generates from the repository's .proto files.

Nothing is written beside the sources, so that a build needs no clean-up and a read-only checkout will do.
"""

import atexit
import importlib.util
import pathlib
import shutil
import subprocess
import sys
import tempfile

from setuptools import setup
from setuptools.command.build_py import build_py

PROTO = pathlib.Path(__file__).resolve().parents[2] / "proto"
SCRATCH = tempfile.mkdtemp(prefix="collided-build-")
atexit.register(shutil.rmtree, SCRATCH, ignore_errors=True)


def generator():
    """The command that generates stubs: Debian's protoc and its gRPC plugin, or grpcio-tools."""
    protoc, plugin = shutil.which("protoc"), shutil.which("grpc_python_plugin")
    if protoc and plugin:
        return [protoc, f"--plugin=protoc-gen-grpc={plugin}"], "--grpc_out"
    if importlib.util.find_spec("grpc_tools"):
        return [sys.executable, "-m", "grpc_tools.protoc"], "--grpc_python_out"
    sys.exit("collided needs protoc and grpc_python_plugin (Debian: protobuf-compiler, protobuf-compiler-grpc), "
             "or grpcio-tools, to generate the protocol's messages")


class BuildWithStubs(build_py):
    """The modules of the package and the messages of the protocol."""

    def run(self):
        super().run()
        if getattr(self, "editable_mode", False):
            sys.exit("collided cannot be installed in editable mode: its messages are generated into the build")
        files = sorted(PROTO.glob("collided/v1/*.proto"))
        if not files:
            sys.exit(f"no .proto files in {PROTO}: install the package from its repository")
        command, grpc_out = generator()
        messages = [f"--python_out={self.build_lib}", f"--pyi_out={self.build_lib}", *map(str, files)]
        calls = [f"{grpc_out}={self.build_lib}", str(PROTO / "collided/v1/collision_service.proto")]
        for outputs in (messages, calls):
            subprocess.run([*command, f"-I{PROTO}", *outputs], check=True)
        package = pathlib.Path(self.build_lib, "collided", "v1", "__init__.py")
        package.write_text('"""Messages of the protocol, generated from proto/collided/v1."""\n')


setup(cmdclass={"build_py": BuildWithStubs},
      options={"build": {"build_base": SCRATCH}, "egg_info": {"egg_base": SCRATCH}})
