#!/usr/bin/env python3
"""What is installed is enough to build a program with find_package(collided), which runs against the installed daemon.

usage: package_test.py CMAKE REPOSITORY BUILD EXAMPLE_BUILD
"""

import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

CMAKE = sys.argv[1]
REPOSITORY, BUILD, EXAMPLE_BUILD = (pathlib.Path(argument).resolve() for argument in sys.argv[2:5])
EXAMPLE = REPOSITORY / "client" / "cpp" / "examples" / "first_contact"
TWO_PLACES = REPOSITORY / "client" / "in_process" / "example"
sys.path.insert(0, str(REPOSITORY / "tests" / "interop"))
from daemon import Daemon  # noqa: E402

# The example is built as the library was.
SETTINGS = ("CMAKE_GENERATOR", "CMAKE_BUILD_TYPE", "CMAKE_CXX_COMPILER", "CMAKE_CXX_COMPILER_LAUNCHER", "CMAKE_CXX_FLAGS",
            "CUDAToolkit_ROOT")
PRINTED = """step 0: 0 contacts
step 1: 0 contacts
step 2: 0 contacts
step 3: 1 contacts
  vertex 3, triangle 0, t = 0.6667
step 4: 0 contacts
step 5: 0 contacts
"""


def run(*command):
    done = subprocess.run([str(word) for word in command], text=True, capture_output=True, timeout=400)
    assert done.returncode == 0, f"{command}\n{done.stdout}{done.stderr}"
    return done.stdout


def settings():
    lines = (line.partition("=") for line in (BUILD / "CMakeCache.txt").read_text().splitlines() if "=" in line)
    return {key.partition(":")[0]: value for key, _, value in lines if key.partition(":")[0] in SETTINGS}


class Package(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.prefix = EXAMPLE_BUILD.parent / "prefix"  # always the same, so that a compiler cache knows its headers
        shutil.rmtree(cls.prefix, ignore_errors=True)
        for folder in (cls.prefix, EXAMPLE_BUILD):
            cls.addClassCleanup(shutil.rmtree, folder, ignore_errors=True)
        run(CMAKE, "--install", BUILD, "--prefix", cls.prefix)

    def test_programs_library_and_public_headers_are_installed(self):
        installed = {path.relative_to(self.prefix).as_posix() for path in self.prefix.rglob("*") if path.is_file()}
        self.assertLessEqual({"bin/collided", "bin/collidectl", "include/collided/client/cpp/session.hpp",
                              "include/collided/client/in_process/local.hpp", "include/collided/collided/v1/scene.pb.h",
                              "share/man/man1/collidectl-stream.1", "share/man/man8/collided.8",
                              "share/man/man5/collided.toml.5", "share/bash-completion/completions/collided",
                              "share/zsh/site-functions/_collidectl", "share/doc/collided/examples/collided.toml",
                              "share/fish/vendor_completions.d/collidectl.fish"}, installed)
        self.assertFalse([path for path in installed if "transport" in path or "_state.hpp" in path])
        self.assertFalse([path for path in installed if "/server/" in path or "/gpu/" in path])

    def build(self, example):
        known = settings()
        shutil.rmtree(EXAMPLE_BUILD, ignore_errors=True)
        run(CMAKE, "-S", example, "-B", EXAMPLE_BUILD, "-G", known.pop("CMAKE_GENERATOR"),
            f"-DCMAKE_PREFIX_PATH={self.prefix}", *(f"-D{key}={value}" for key, value in known.items()))
        run(CMAKE, "--build", EXAMPLE_BUILD)
        daemon = Daemon(self.prefix / "bin" / "collided")
        self.addCleanup(daemon.kill)
        return daemon

    def test_the_example_finds_the_package_and_prints_the_contact(self):
        daemon = self.build(EXAMPLE)
        self.assertEqual(run(EXAMPLE_BUILD / "first_contact", daemon.address), PRINTED)
        daemon.stop()

    def test_a_program_with_the_engine_linked_in_prints_the_same_without_a_daemon(self):
        daemon = self.build(TWO_PLACES)
        for arguments in ([], [daemon.address]):
            self.assertEqual(run(EXAMPLE_BUILD / "two_places", *arguments), PRINTED)
        daemon.stop()

    def test_another_minor_version_is_not_found(self):
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "CMakeLists.txt").write_text(
                "cmake_minimum_required(VERSION 3.25)\nproject(later LANGUAGES NONE)\nfind_package(collided 0.2 REQUIRED)\n")
            done = subprocess.run([CMAKE, "-S", folder, "-B", f"{folder}/build", f"-DCMAKE_PREFIX_PATH={self.prefix}"],
                                  text=True, capture_output=True, timeout=60)
        self.assertNotEqual(done.returncode, 0)
        self.assertIn('requested version "0.2"', done.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
