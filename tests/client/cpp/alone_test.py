#!/usr/bin/env python3
"""Another project takes the C++ client alone from the source tree; it then needs gRPC and protobuf alone.

usage: alone_test.py CMAKE REPOSITORY BUILD FOLDER
"""

import json
import pathlib
import shutil
import subprocess
import sys
import unittest

CMAKE = sys.argv[1]
REPOSITORY, BUILD, FOLDER = (pathlib.Path(argument).resolve() for argument in sys.argv[2:5])
NEEDED = {"Protobuf", "gRPC", "Threads"}
SEARCHES = {"find_package", "find_library", "find_path", "find_file", "find_program", "pkg_check_modules", "pkg_search_module"}
SETTINGS = ("CMAKE_GENERATOR", "CMAKE_BUILD_TYPE", "CMAKE_CXX_COMPILER", "CMAKE_CXX_COMPILER_LAUNCHER")


def run(*command):
    done = subprocess.run([str(word) for word in command], text=True, capture_output=True, timeout=280, check=False)
    assert done.returncode == 0, f"{command}\n{done.stdout}{done.stderr}"
    return done.stdout


def settings():
    lines = (line.partition("=") for line in (BUILD / "CMakeCache.txt").read_text().splitlines() if "=" in line)
    return {key.partition(":")[0]: value for key, _, value in lines if key.partition(":")[0] in SETTINGS}


def configure(name, *options):
    """Configures the project. Returns its build folder and what the repository's files searched for."""
    source, build = FOLDER / name, FOLDER / name / "build"
    shutil.rmtree(source, ignore_errors=True)
    source.mkdir(parents=True)
    text = (REPOSITORY / "tests/client/cpp/alone/CMakeLists.txt.in").read_text()
    (source / "CMakeLists.txt").write_text(text.replace("@REPOSITORY@", str(REPOSITORY)).replace(
        "@EXAMPLE@", str(REPOSITORY / "client/cpp/examples/first_contact/main.cpp")))
    known, trace = settings(), source / "trace.json"
    run(CMAKE, "-S", source, "-B", build, "-G", known.pop("CMAKE_GENERATOR"), "--trace-expand", "--trace-format=json-v1",
        f"--trace-redirect={trace}", *(f"-D{key}={value}" for key, value in known.items()), *options)
    calls = (json.loads(line) for line in trace.read_text().splitlines())
    return build, [call["args"][0] for call in calls if call.get("cmd", "").lower() in SEARCHES
                   and pathlib.Path(call["file"]).is_relative_to(REPOSITORY)
                   and not pathlib.Path(call["file"]).is_relative_to(FOLDER)]


def compiled(build):
    return {command["file"].removeprefix(f"{REPOSITORY}/")
            for command in json.loads((build / "compile_commands.json").read_text())}


class Alone(unittest.TestCase):
    def tearDown(self):
        shutil.rmtree(FOLDER, ignore_errors=True)

    def test_only_grpc_and_protobuf_are_searched_and_a_program_of_the_forwarding_header_compiles(self):
        build, searched = configure("plain", "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON")
        self.assertEqual(set(searched), NEEDED)
        self.assertFalse([file for file in compiled(build) if file.startswith(("gpu/", "server/", "client/cli", "tests/"))])
        self.assertIn("client/cpp/transport/local/local_transport.cpp", compiled(build))
        self.assertFalse((build / "_deps/collided-build/client/cpp/package").exists(), "nothing is installed for others")
        run(CMAKE, "--build", build, "--target", "simulator")

    def test_parts_that_need_linux_can_be_left_out(self):
        build, _ = configure("anywhere", "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON", "-DCOLLIDED_CLIENT_LOCAL=OFF")
        local = {pathlib.Path(file).name for file in compiled(build) if "/transport/local/" in file}
        self.assertEqual(local, {"local_layout.cpp", "no_local.cpp"})

    def test_another_word_is_refused(self):
        done = subprocess.run([CMAKE, "-S", REPOSITORY, "-B", FOLDER / "wrong", "-DCOLLIDED_BUILD=server"], text=True,
                              capture_output=True, timeout=60, check=False)
        self.assertNotEqual(done.returncode, 0)
        self.assertIn('COLLIDED_BUILD is "server"; it must be all or client', done.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
