"""Attacks on the entrances of a real daemon, and its state after them. Usage: entrance_test.py DAEMON"""

import contextlib
import fcntl
import os
import pathlib
import re
import resource
import socket
import struct
import subprocess
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from ops_daemon import SERVING, Daemon, DaemonCase, Folder  # noqa: E402

import grpc  # noqa: E402

PROGRAM = sys.argv[1]


def run(*options):
    return subprocess.run([PROGRAM, *options], capture_output=True, text=True, timeout=60, check=False)


def tcp(address):
    host, port = address.rsplit(":", 1)
    return socket.create_connection((host, int(port)), 30)


class Case(DaemonCase):
    program = PROGRAM


class Listening(Case):
    def refused(self, *options):
        done = run("--backend", "cpu", *options)
        self.assertEqual(done.returncode, 1, done.stderr)
        return done.stderr.splitlines()[-1]

    def test_the_reason_is_told(self):
        self.assertEqual(self.refused("--address", "unix:/nowhere/socket"),
                         "collided: cannot listen on /nowhere/socket: folder /nowhere: No such file or directory")
        with socket.create_server(("127.0.0.1", 0)) as taken:
            address = f"127.0.0.1:{taken.getsockname()[1]}"
            self.assertEqual(self.refused("--address", address),
                             f"collided: cannot listen on {address}: Address already in use")
        self.assertIn("192.0.2.1:50551: Cannot assign", self.refused("--address", "192.0.2.1:50551", "--allow-insecure"))

    def test_nothing_but_the_reason_is_told(self):
        done = run("--backend", "cpu", "--address", "unix:/nowhere/socket")
        self.assertNotIn("{", done.stderr)

    def test_every_address_of_a_name_is_served(self):
        daemon = self.start(address="localhost:0")
        port = int(daemon.address.rsplit(":", 1)[1])
        families = {family for family, *_ in socket.getaddrinfo("localhost", port, type=socket.SOCK_STREAM)}
        for family in families:
            with self.subTest(family=family), socket.socket(family) as client:
                client.connect(("127.0.0.1" if family == socket.AF_INET else "::1", port))
        self.assertEqual(daemon.health(), SERVING)


class Descriptors(Case):
    def test_a_time_without_any_is_told_and_passes(self):
        daemon = self.start()
        waiting = tcp(daemon.http_address)  # a new one would not get in
        self.addCleanup(waiting.close)
        daemon.wait_for(lambda: self.is_accepted(waiting), "connection")
        before = resource.prlimit(daemon.process.pid, resource.RLIMIT_NOFILE)
        resource.prlimit(daemon.process.pid, resource.RLIMIT_NOFILE, (3, before[1]))
        waiting.sendall(b"GET /readyz HTTP/1.1\r\nHost: a\r\nConnection: close\r\n")
        daemon.wait_for(lambda: "not ready" in daemon.log() or self.knock(daemon, waiting), "trouble")
        waiting.sendall(b"\r\n")
        answer = waiting.makefile("rb").read().decode()
        self.assertTrue(answer.startswith("HTTP/1.1 503"), answer)
        self.assertIn("Too many open files", answer)
        resource.prlimit(daemon.process.pid, resource.RLIMIT_NOFILE, before)
        daemon.wait_for(lambda: daemon.http("/readyz") == (200, "ready\n"), "ready")
        self.assertEqual(daemon.health(), SERVING)
        self.assertEqual(daemon.stop(), 0)

    def is_accepted(self, connection):
        """The kernel shows no inode for the daemon's end before that."""
        near, far = (f":{end[1]:04X}" for end in (connection.getpeername(), connection.getsockname()))
        with open("/proc/net/tcp", encoding="ascii") as table:
            rows = [line.split() for line in table]
        return any(row[1].endswith(near) and row[2].endswith(far) and row[9] != "0" for row in rows[1:])

    def knock(self, daemon, waiting):
        """A client must be waiting to connect, and must not fall silent."""
        tcp(daemon.address).close()
        waiting.sendall(b"X: y\r\n")
        return False


class Tls(Case):
    def setUp(self):
        super().setUp()
        self.tls = self.folder.certificates()
        self.credentials = grpc.ssl_channel_credentials(self.folder.read("ca.pem"), self.folder.read("client.key"),
                                                        self.folder.read("client.pem"))

    def reloads(self, daemon, result):
        found = re.search(rf'collided_certificate_reloads_total{{result="{result}"}} (\d+)', daemon.http("/metrics")[1])
        return int(found[1])

    def test_files_that_cannot_be_used_do_no_harm(self):
        daemon = self.start(*self.tls, "--tls-client-ca", self.folder.path("ca.pem"))
        self.assertEqual(self.reloads(daemon, "refused"), 0)  # shown from the start: an alert asks for its increase
        for count, (name, text) in enumerate((("server.pem", ""), ("server.key", ""), ("ca.pem", "garbage")), 1):
            with self.subTest(name=name):
                good = self.folder.read(name).decode()
                self.folder.put(name, text)
                daemon.wait_for(lambda: daemon.process.poll() is not None or self.reloads(daemon, "refused") == count,
                                "refusal")
                self.assertIsNone(daemon.process.poll(), daemon.log())
                self.assertEqual(daemon.health(credentials=self.credentials), SERVING)
                self.assertEqual(daemon.http("/readyz"), (200, "ready\n"))
                self.assertIn(self.folder.path(name), daemon.log())
                self.folder.put(name, good)
        self.folder.sign("server", "localhost", "ca")
        daemon.wait_for(lambda: self.reloads(daemon, "taken") == 1, "renewal")
        self.assertEqual(daemon.health(credentials=self.credentials), SERVING)
        self.assertEqual(daemon.stop(), 0)


class Http(Case):
    def test_slow_clients_keep_nobody_waiting(self):
        daemon = self.start()
        slow = [tcp(daemon.http_address) for _ in range(500)]
        for client in slow:
            try:
                client.send(b"GET /metrics HTTP/1.1\r\nX: ")
            except OSError:  # it had to make room
                pass
        ended = sum(self.is_ended(client) for client in slow)
        for path in ("/healthz", "/readyz", "/metrics"):
            self.assertEqual(daemon.http(path)[0], 200)
        self.assertLess(ended, 500)
        for client in slow:
            client.close()

    def is_ended(self, client):
        client.setblocking(False)
        try:
            return client.recv(1) == b""
        except BlockingIOError:
            return False
        except OSError:
            return True


class Local(Case):
    """Closing what a client sent takes as long as the client likes."""

    def lingering(self):
        """A TCP socket whose last close takes a minute, and its other end."""
        server = socket.create_server(("127.0.0.1", 0))
        near = socket.create_connection(server.getsockname())
        far, _ = server.accept()
        near.setblocking(False)
        try:
            while True:
                near.send(bytes(1 << 20))
        except BlockingIOError:
            pass
        near.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 60))
        server.close()
        self.addCleanup(far.close)
        return near

    def nested(self):
        """A Unix socket with such a socket in transit."""
        near, far = socket.socketpair(socket.AF_UNIX, socket.SOCK_DGRAM)
        inner = self.lingering()
        socket.send_fds(near, [b"x"], [inner.fileno()])
        inner.close()
        near.close()
        return far

    def give(self, daemon, path, *packets):
        """Packets with files whose last holder is the daemon: it must not close them before their sender does."""
        with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as client:
            client.settimeout(30)
            client.connect(path)
            daemon.halt()
            for files in packets:
                socket.send_fds(client, [b"\xff"], [file.fileno() for file in files])
                for file in files:
                    file.close()
            daemon.go_on()
            with contextlib.suppress(ConnectionResetError):  # a packet was not read
                while client.recv(1 << 16):
                    pass

    def test_files_that_close_slowly_hold_nothing_up(self):
        path = self.folder.path("local")
        daemon = self.start("--local-socket", path)
        self.give(daemon, path, [self.lingering()])
        self.give(daemon, path, [self.nested()])
        self.give(daemon, path, [self.lingering() for _ in range(6)])
        self.give(daemon, path, [self.lingering()], [self.lingering()])  # nobody reads the second packet
        self.give(daemon, path, [])
        self.assertEqual(daemon.stop(), 0)
        self.assertTrue(daemon.log().endswith(" info stopped\n"), daemon.log())


class Stop(Case):
    def test_a_log_that_nobody_takes_holds_nothing_up(self):
        ready = self.folder.path("ready")
        reader, writer = os.pipe()
        self.addCleanup(os.close, reader)
        with subprocess.Popen([PROGRAM, "--backend", "cpu", "--address", "127.0.0.1:0", "--ready-file", ready,
                               "--grace-seconds", "0"], stderr=writer) as process:
            self.addCleanup(process.kill)
            Daemon.wait_for(self, lambda: os.path.exists(ready), "start")
            fcntl.fcntl(writer, fcntl.F_SETFL, os.O_NONBLOCK)
            try:
                while True:
                    os.write(writer, bytes(4096))
            except BlockingIOError:
                pass
            fcntl.fcntl(writer, fcntl.F_SETFL, 0)
            process.terminate()
            try:
                self.assertEqual(process.wait(30), 0)
            finally:
                process.kill()
                os.close(writer)

    def log(self):
        return "no log"


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
