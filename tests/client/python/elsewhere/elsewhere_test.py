#!/usr/bin/env python3
"""The package runs on macOS and Windows, and with a daemon elsewhere whose port is forwarded to this host.

usage: elsewhere_test.py DAEMON COLLIDECTL REPOSITORY
"""

import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import collided
from support import COLLIDECTL, DAEMON, STREAMS, Case, Daemon, lowered, main, meshes

HERE = pathlib.Path(__file__).resolve().parent


def port_of(daemon):
    """The daemon's address on TCP."""
    return next(line for line in pathlib.Path(daemon.folder.name, "ready").read_text().split() if line.startswith("127.0.0.1:"))


class Systems(Case):
    """The package runs in a process from which the test takes away what another system lacks."""

    options = ("--address", "127.0.0.1:0")

    def run_on(self, system):
        with tempfile.TemporaryDirectory() as folder:
            # The daemon and the command line are on PATH, and cannot be run there.
            for program in (DAEMON, COLLIDECTL):
                pathlib.Path(folder, program.name).symlink_to(program.resolve())
            path = os.pathsep.join([str(HERE), os.environ["PYTHONPATH"]])
            environment = {"PATH": folder, "PYTHONPATH": path, "PYTHONDONTWRITEBYTECODE": "1"}
            command = [sys.executable, "-W", "default", HERE / "program.py", system, port_of(self.daemon)]
            done = subprocess.run(command, cwd=folder, env=environment, text=True, capture_output=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("ResourceWarning: unclosed Session of scene", done.stderr)
        return json.loads(done.stdout)

    def check(self, system):
        said = self.run_on(system)
        needs_linux = f"FailedPrecondition: shared memory with a daemon needs Linux, and this is {system}"
        advice = (f"runs on Linux, and this is {system}: run it in a container, in WSL or on a Linux host, and name the daemon's address "
                  "as server='host:port' or in COLLIDED_SERVER")
        streamed = [[1.0, 1.0, 1.0, 0.475], False]
        self.assertEqual(said, {
            "auto": streamed, "grpc": streamed, "calls": streamed, "batch": [0, 0, 0, 1], "aio": 1, "read": 3,
            "shared_memory": needs_linux, "device": needs_linux, "no server": f"FailedPrecondition: collided {advice}",
            "command": f"collidectl: collidectl {advice}"})

    def test_on_macos(self):
        self.check("darwin")

    def test_on_windows(self):
        self.check("win32")


class Forwarded(unittest.TestCase):
    """A loopback address is not always this host: the daemon behind it announces a socket that is elsewhere."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.socket = pathlib.Path(folder.name, "local")
        self.server = self.start()

    def start(self):
        daemon = Daemon(str(DAEMON), "--local-socket", str(self.socket), "--address", "127.0.0.1:0")
        self.addCleanup(daemon.kill)
        return port_of(daemon)

    def check(self, reason):
        """Streams go over gRPC, and shared memory that is asked for is refused with the reason."""
        options = {"server": self.server, "thickness": 0.01}
        with collided.Session(meshes(), **options) as session:
            self.assertEqual(session.step({"tip": lowered(2)}).elements.tolist(), [[3, 0]])
            self.assertFalse(session.is_local)
            self.assertRegex(session.local_refusal, reason)
        with collided.SceneBatch(meshes(), 2, **options) as batch:
            self.assertEqual(batch.step([lowered(0), lowered(2)], start=[lowered(0)] * 2).counts.tolist(), [0, 1])
            self.assertFalse(batch.is_local)
        with self.assertRaisesRegex(collided.Error, reason):
            collided.Session(meshes(), transport="shared_memory", **options)

    def test_its_socket_is_not_here(self):
        self.socket.unlink()
        self.check(f"no daemon answers at {self.socket}: No such file or directory")

    def test_its_socket_is_another_daemons(self):
        self.socket.unlink()
        other = self.start()
        self.check(f"the local socket {self.socket} belongs to another daemon than the one at {self.server}; gRPC reaches it")
        for transport in STREAMS:  # and that daemon's own clients use it
            with collided.Session(meshes(), server=other, transport=transport) as session:
                self.assertEqual(session.is_local, transport == "shared_memory")

    def test_its_socket_is_no_daemons(self):
        self.socket.unlink()
        self.socket.write_text("")
        self.check(f"no daemon answers at {self.socket}: Connection refused")


if __name__ == "__main__":
    main()
