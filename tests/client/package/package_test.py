#!/usr/bin/env python3
"""An installation that was moved is enough to build programs with find_package(collided) and pkg-config.

usage: package_test.py CMAKE REPOSITORY BUILD EXAMPLE_BUILD
"""

import os
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
IN_C = REPOSITORY / "client" / "c" / "example"
sys.path.insert(0, str(REPOSITORY / "tests" / "interop"))
from daemon import Daemon  # noqa: E402

# The example is built as the library was.
SETTINGS = ("CMAKE_GENERATOR", "CMAKE_BUILD_TYPE", "CMAKE_CXX_COMPILER", "CMAKE_CXX_COMPILER_LAUNCHER", "CMAKE_CXX_FLAGS",
            "CMAKE_C_COMPILER", "CUDAToolkit_ROOT")
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
        cls.first = cls.prefix.with_name("first_prefix")
        for folder in (cls.prefix, cls.first, EXAMPLE_BUILD):
            shutil.rmtree(folder, ignore_errors=True)
            cls.addClassCleanup(shutil.rmtree, folder, ignore_errors=True)
        run(CMAKE, "--install", BUILD, "--prefix", cls.first)
        cls.first.rename(cls.prefix)

    def test_programs_library_and_public_headers_are_installed(self):
        installed = {path.relative_to(self.prefix).as_posix() for path in self.prefix.rglob("*") if path.is_file()}
        self.assertLessEqual({"bin/collided", "bin/collidectl", "include/collided/client/cpp/session.hpp",
                              "include/collided/client/in_process/local.hpp", "include/collided/collided/client.hpp",
                              "include/collided/collided/local.hpp", "include/collided/collided.h", "lib/libcollided.so",
                              "lib/pkgconfig/collided.pc", "lib/pkgconfig/collided-c.pc", "include/collided/collided/v1/scene.pb.h",
                              "share/man/man1/collidectl-stream.1", "share/man/man8/collided.8",
                              "share/man/man5/collided.toml.5", "share/bash-completion/completions/collided",
                              "share/zsh/site-functions/_collidectl", "share/doc/collided/examples/collided.toml",
                              "share/fish/vendor_completions.d/collidectl.fish"}, installed)
        self.assertFalse([path for path in installed if "transport" in path or "_state.hpp" in path])
        self.assertFalse([path for path in installed if "/server/" in path or "/gpu/" in path])

    def test_nothing_that_others_read_names_a_folder_of_the_build(self):
        folders = [str(folder) for folder in (self.first, self.prefix, BUILD, REPOSITORY)]
        for file in [*self.prefix.rglob("*.cmake"), *self.prefix.rglob("*.pc"), *self.prefix.rglob("*.hpp")]:
            text = file.read_text()
            self.assertFalse([folder for folder in folders if folder in text], file)
            if file.suffix == ".cmake":
                self.assertNotRegex(text, r"/usr/lib[^ ]*\.so", f"{file} names a library of this machine by its path")

    def pkg_config(self, package):
        variables = {**os.environ, "PKG_CONFIG_PATH": str(self.prefix / "lib" / "pkgconfig")}
        return subprocess.run(["pkg-config", "--cflags", "--libs", package], text=True, capture_output=True, check=True,
                              timeout=60, env=variables).stdout.split()

    def test_a_program_in_c_is_built_by_cmake_and_by_pkg_config_and_needs_no_daemon(self):
        printed = "step 0: 0 contacts\nstep 1: 0 contacts\nstep 2: 0 contacts\nstep 3: 1 contacts\n" \
                  "  vertex 3, triangle 0, t = 0.5000\n"
        self.configure(IN_C)
        self.assertEqual(run(EXAMPLE_BUILD / "first_contact"), printed)
        program = EXAMPLE_BUILD / "by_pkg_config"
        run("cc", "-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", IN_C / "first_contact.c", "-o", program,
            *self.pkg_config("collided-c"), f"-Wl,-rpath,{self.prefix}/lib")
        self.assertEqual(run(program), printed)

    def test_pkg_config_knows_what_the_client_is_linked_with(self):
        words = self.pkg_config("collided")
        libraries = [word for word in words if word.startswith("-l")]
        self.assertLess(libraries.index("-lcollided_client"), libraries.index("-lcollided_proto"))
        self.assertLess(libraries.index("-lcollided_proto"), libraries.index("-lprotobuf"))
        includes = [pathlib.Path(word[2:]).resolve() for word in words if word.startswith("-I")]
        self.assertIn(self.prefix / "include" / "collided", includes)
        self.assertTrue((self.prefix / "lib" / "libcollided_client.a").is_file())

    def configure(self, example):
        known = settings()
        shutil.rmtree(EXAMPLE_BUILD, ignore_errors=True)
        run(CMAKE, "-S", example, "-B", EXAMPLE_BUILD, "-G", known.pop("CMAKE_GENERATOR"),
            f"-DCMAKE_PREFIX_PATH={self.prefix}", *(f"-D{key}={value}" for key, value in known.items()))
        run(CMAKE, "--build", EXAMPLE_BUILD)

    def build(self, example):
        self.configure(example)
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
