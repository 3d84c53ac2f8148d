#!/usr/bin/env python3
"""Clients in several languages send the same scene to one daemon: they get the same bytes, and make it in one call.

usage: contacts_test.py DAEMON CPP_PROGRAM LANGUAGE REPOSITORY BUILD_FOLDER

LANGUAGE is python (plain stubs), package (that of Python), node or go; its client is compared with that in C++. Two sheets of bumps pass through each other
in five frames, the last one sparse, with a discrete frame after each; each client prints, for each frame, the arrays of its contacts.
Before the third frame they try to advance to where it goes, and print the arrays of what limits the way.
"""

import os
import pathlib
import shutil
import socket
import subprocess
import sys
import unittest
import urllib.request

DAEMON, CPP, LANGUAGE = sys.argv[1:4]
REPOSITORY, BUILD = (pathlib.Path(argument).resolve() for argument in sys.argv[4:6])
HERE = pathlib.Path(__file__).resolve().parent
sys.path += [str(REPOSITORY / "tests" / folder) for folder in ("interop", "client/node", "client/go")]
import go_workspace  # noqa: E402
import node_package  # noqa: E402
from daemon import Daemon  # noqa: E402


def printed(command, **environment):
    return subprocess.run(command, stdout=subprocess.PIPE, timeout=100, check=True, env={**os.environ, **environment}).stdout


def python_client():
    try:
        import grpc  # noqa: F401
        import numpy  # noqa: F401
    except ImportError as missing:
        print(f"skipped: {missing} (Debian: python3-grpcio, python3-numpy)")
        sys.exit(77)
    stubs = str(BUILD / "tests" / "interop" / "interop_stubs")
    return lambda address: printed([sys.executable, HERE / "contacts.py", address], PYTHONPATH=stubs)


def package_client():
    package = str(BUILD / "tests" / "client" / "python" / "package")
    return lambda address: printed([sys.executable, HERE / "contacts_package.py", address, "grpc"], PYTHONPATH=package)


def node_client():
    """Inside the package, where its own name is known."""
    program, node = node_package.built(REPOSITORY, BUILD) / "contacts.mjs", node_package.node()
    shutil.copy(HERE / program.name, program)
    return lambda address: printed([node, program, address])


def go_client():
    workspace = go_workspace.Workspace(REPOSITORY, BUILD)
    return lambda address: workspace.run("run", HERE / "contacts.go", address)


try:
    CLIENT = {"python": python_client, "package": package_client, "node": node_client, "go": go_client}[LANGUAGE]()
except (go_workspace.Missing, node_package.Missing) as missing:
    print(f"skipped: {missing}")
    sys.exit(77)


class Contacts(unittest.TestCase):
    def test_they_are_the_same_bytes(self):
        with socket.create_server(("127.0.0.1", 0)) as free:
            http = "{}:{}".format(*free.getsockname())
        daemon = Daemon(DAEMON, "--http-address", http)
        self.addCleanup(daemon.kill)
        expected, found = printed([CPP, daemon.address]), CLIENT(daemon.address)
        self.assertGreater(len(expected), 100_000, "the sheets do not meet")
        first = next((i for i, pair in enumerate(zip(expected, found)) if pair[0] != pair[1]), min(len(expected), len(found)))
        self.assertTrue(found == expected, f"{len(found)} bytes instead of {len(expected)}; byte {first} is the first that differs")
        calls = urllib.request.urlopen(f"http://{http}/metrics", timeout=20).read().decode()
        self.assertIn('method="CreateScene"', calls)
        self.assertNotIn('method="UploadMesh"', calls)  # a call for each mesh, however small it is


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
