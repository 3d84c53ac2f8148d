#!/usr/bin/env python3
"""Tests each limit of the entrance, and how it identifies callers. Usage: network_entrance_test.py DAEMON

tests/sharing runs floods through the entrance (`run --entrance`).
"""

import concurrent.futures
import contextlib
import functools
import grp
import os
import pathlib
import pwd
import re
import socket
import ssl
import struct
import sys
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / "tests/integration/support"), str(ROOT / "tests/sharing")]
from ops_daemon import SERVICE, Daemon, Folder  # noqa: E402: without gRPC for Python the test ends as skipped here
from entrance import Entrance, wait_for  # noqa: E402: without HAProxy, here

import grpc  # noqa: E402
import numpy as np  # noqa: E402

import collided  # noqa: E402
from collided.v1 import collision_service_pb2 as api  # noqa: E402

from attacks.catalogue import Target  # noqa: E402
from attacks.http2 import (  # noqa: E402
    DATA, END_STREAM, HEADERS, INFO, PREFACE, SETTINGS, WINDOW_UPDATE, Http2, frame, resets, text)
from attacks.tip import tip_request  # noqa: E402
from ways import MAX_MB, peak_mb  # noqa: E402

PROGRAM = sys.argv[1]
INFO_OF_ONE = (("authorization", "Bearer token-of-client-one"),)
EMPTY = bytes(5)  # a message without fields


def setUpModule():
    """Starts a daemon that knows three clients by tokens. The certificate `client` names sim-1."""
    Case.folder = folder = Folder()
    unittest.addModuleCleanup(folder.cleanup)
    folder.certificates()
    Case.pem = folder.put("both.pem", (folder.read("server.pem") + folder.read("server.key")).decode())
    tokens = "".join(f'[[tokens]]\nname = "{name}"\ntoken = "token-of-{name}"\n'
                     for name in ("client-one", "client-two", "client-sim-1"))
    Case.daemon = Daemon(PROGRAM, "--name", "only", "--tokens-file", folder.put("tokens.toml", tokens),
                         address=f"unix:{folder.path('socket')}")
    unittest.addModuleCleanup(Case.daemon.__exit__)


def in_a_thread(function):
    """Calls it in a thread of its own. OpenSSL has a queue of errors for each thread. Python 3.13 with OpenSSL 3.5 leaves the error
    of a connection that was refused there, and raises it at the next read of another one, which is well."""
    @functools.wraps(function)
    def call(*arguments):
        with concurrent.futures.ThreadPoolExecutor(1) as thread:
            return thread.submit(function, *arguments).result()
    return call


class Case(unittest.TestCase):
    shared = None

    def enter(self, *options, plain=False, **more):
        how = ["--plain-text"] if plain else ["--certificate", self.pem]
        entrance = Entrance([f"only={self.daemon.address},{self.daemon.http_address}"], *how, *options, **more)
        self.addCleanup(entrance.close)
        return entrance

    def plain(self):
        """Returns the one entrance of all tests that need no TLS and no option."""
        if Case.shared is None:
            Case.shared = Entrance([f"only={self.daemon.address},{self.daemon.http_address}"], "--plain-text")
            unittest.addModuleCleanup(Case.shared.close)
        return Case.shared

    def client(self, entrance, certificate=None, **options):
        own = {"tls_certificate": self.folder.path(f"{certificate}.pem"), "tls_key": self.folder.path(f"{certificate}.key")}
        client = collided.Client(entrance.address, tls_ca=self.folder.path("ca.pem"), tls_server_name="localhost", patience=10,
                                 **(own if certificate else {}), **options)
        self.addCleanup(client.close)
        return client

    def target(self, entrance, token="token-of-client-one", source="127.0.0.2"):
        """Describes an entrance without TLS to an attack."""
        host, port = entrance.address.split(":")
        return Target(int(port), 0, token, "", 0, source, host)

    @in_a_thread
    def begun(self, entrance, certificate, source="127.0.0.2"):
        """Opens a connection with HTTP/2 over TLS."""
        context = ssl.create_default_context(cafile=self.folder.path("ca.pem"))
        context.check_hostname = False
        context.set_alpn_protocols(["h2"])
        if certificate:
            context.load_cert_chain(self.folder.path(f"{certificate}.pem"), self.folder.path(f"{certificate}.key"))
        peer = context.wrap_socket(self.target(entrance, source=source).bytes())
        self.addCleanup(peer.close)
        with contextlib.suppress(OSError):
            peer.sendall(PREFACE + frame(SETTINGS, 0, 0))
            peer.recv(1)  # the entrance's SETTINGS come once it has taken the connection
        return peer

    def calls(self, method):
        """Counts the calls of a method that the daemon has seen, by code."""
        text = self.daemon.http("/metrics")[1]
        found = re.findall(rf'collided_calls_total{{code="(\w+)",method="{method}"}} (\d+)', text)
        return {code: int(count) for code, count in found}


class Identity(Case):
    def test_a_token_reaches_the_daemon(self):
        entrance = self.enter()
        self.assertEqual(self.client(entrance, token="token-of-client-one").info.version, "0.1.0")
        for token in ("", "token-of-nobody-at-all"):
            with self.subTest(token=token), self.assertRaises(collided.Unauthenticated):
                self.client(entrance, token=token).info

    def scenes(self, client):
        return {scene.scene_id for scene in client.scenes()}

    def test_a_certificate_stands_for_its_token(self):
        names = self.folder.put("clients", "sim-1 token-of-client-sim-1\n")
        entrance = self.enter("--client-ca", self.folder.path("ca.pem"), "--client-tokens", names)
        meshes = {"one": collided.Mesh(np.eye(3), np.array([[0, 1, 2]]))}
        with collided.Scene(meshes, server=self.client(entrance, "client")) as scene:
            self.assertEqual(self.scenes(self.client(entrance, token="token-of-client-sim-1")), {scene.id})
            # A token names its caller, whatever the certificate says.
            self.assertEqual(self.scenes(self.client(entrance, "client", token="token-of-client-two")), set())
        with self.assertRaises(collided.Unauthenticated):
            self.client(entrance).info

    def test_a_certificate_without_a_token_is_nobody(self):
        names = self.folder.put("clients", "sim-2 token-of-client-sim-1\n")
        entrance = self.enter("--client-ca", self.folder.path("ca.pem"), "--client-tokens", names)
        with self.assertRaises(collided.Unauthenticated):
            self.client(entrance, "client").info

    def test_a_certificate_of_another_ca_is_refused(self):
        entrance = self.enter("--client-ca", self.folder.path("ca.pem"))
        self.assertTrue(is_over(self.begun(entrance, "stranger")))
        self.assertFalse(is_over(self.begun(entrance, "client"), 0.1))
        self.assertFalse(is_over(self.begun(entrance, None), 0.1))

    def test_a_required_certificate_is_required(self):
        entrance = self.enter("--client-ca", self.folder.path("ca.pem"), "--certificates-required")
        self.assertTrue(is_over(self.begun(entrance, None)))
        self.assertTrue(self.client(entrance, "client", token="token-of-client-one").info.version)


@in_a_thread
def is_over(connection, seconds=5):
    """True if the other end closes a connection within this time."""
    connection.settimeout(seconds)
    try:
        while connection.recv(1 << 16):
            pass
    except TimeoutError:
        return False
    except OSError:
        pass
    return True


def kinds(data):
    """Returns the kinds of the complete frames in `data`."""
    found = set()
    while len(data) >= 9 and len(data) >= (end := 9 + int.from_bytes(data[:3], "big")):
        found.add(data[3])
        data = data[end:]
    return found


def has_user(name):
    try:
        return pwd.getpwnam(name) is not None
    except KeyError:
        return False


class User(Case):
    @unittest.skipUnless(os.geteuid() == 0 and has_user("haproxy"), "only root starts HAProxy as another user")
    def test_haproxy_needs_no_more_than_the_group_of_the_daemons_socket(self):
        with contextlib.ExitStack() as undo:
            for path, mode in ((self.folder.name, 0o711), (self.folder.path("socket"), 0o660)):
                undo.callback(os.chmod, path, os.stat(path).st_mode & 0o777)
                os.chmod(path, mode)
            os.chown(self.folder.path("socket"), 0, grp.getgrnam("nogroup").gr_gid)
            entrance = self.enter(user="haproxy", group="nogroup")
            self.assertTrue(self.client(entrance, token="token-of-client-one").info.version)
            self.assertRegex(pathlib.Path(f"/proc/{entrance.process.pid}/status").read_text(),
                             rf"Uid:\t{pwd.getpwnam('haproxy').pw_uid}\t")


class Connections(Case):
    def test_an_address_has_its_connections_and_no_more(self):
        entrance = self.enter(plain=True, limits={"CONNECTIONS_OF_AN_ADDRESS": 5})
        target = self.target(entrance)
        peers = [self.enterContext(Http2(target)) for _ in range(5)]
        self.assertTrue(is_over(self.enterContext(target.tcp())))
        self.assertTrue(self.info(self.target(entrance, source="127.0.0.3")))
        for peer in peers:
            self.assertFalse(is_over(peer.socket, 0.05))

    def info(self, target):
        """True if a new connection has its first call answered."""
        with contextlib.closing(grpc.insecure_channel(target.address)) as channel:
            return channel.unary_unary(f"/{SERVICE}/GetServerInfo")(b"", timeout=10, metadata=INFO_OF_ONE)

    def test_new_connections_of_an_address_come_at_a_rate(self):
        entrance = self.enter(plain=True, limits={"NEW_CONNECTIONS_OF_AN_ADDRESS": 5})
        target = self.target(entrance)
        first = self.enterContext(Http2(target))
        for _ in range(4):
            target.tcp().close()
        self.assertTrue(is_over(self.enterContext(target.tcp())))
        self.assertFalse(is_over(first.socket, 0.05))
        self.assertTrue(self.info(self.target(entrance, source="127.0.0.3")))

    def test_a_certificate_has_its_connections_from_all_addresses(self):
        entrance = self.enter("--client-ca", self.folder.path("ca.pem"), limits={"CONNECTIONS_OF_A_CERTIFICATE": 2})
        peers = [self.begun(entrance, "client", f"127.0.0.{2 + index}") for index in range(3)]
        self.assertEqual([is_over(peer, 0.3) for peer in peers], [False, False, True])

    def test_the_entrance_is_ready_beside_a_flood_until_the_daemon_is_gone(self):
        daemon = Daemon(PROGRAM, "--name", "only", address=f"unix:{self.folder.path('other')}")
        self.addCleanup(daemon.__exit__)
        entrance = Entrance([f"only={daemon.address},{daemon.http_address}"], "--plain-text", "--connections", "2")
        self.addCleanup(entrance.close)
        host, port = entrance.address.split(":")
        for _ in range(20):  # most wait for one of two places
            peer = socket.socket()
            self.addCleanup(peer.close)
            peer.setblocking(False)
            peer.connect_ex((host, int(port)))
        wait_for(lambda: entrance.states("calls") and "\nCurrConns: 4\n" in entrance.ask("show info"), "flood")
        self.assertEqual(entrance.http("/readyz")[0], 200)
        self.assertIn("haproxy_frontend_connections_total", entrance.http("/metrics")[1])
        self.assertEqual([entrance.http("/metrics")[0] for _ in range(20)], [200] * 19 + [429])
        daemon.process.kill()
        wait_for(lambda: entrance.http("/readyz")[0] == 503, "the daemon's end")

    def test_the_absence_of_a_daemon_is_told(self):
        nowhere = f"unix:{self.folder.path('nowhere')}"
        entrance = Entrance([f"only={nowhere},{self.daemon.http_address}"], "--plain-text")
        self.addCleanup(entrance.close)
        with self.assertRaises(grpc.RpcError) as refused:
            self.info(self.target(entrance))
        self.assertEqual((refused.exception.code(), refused.exception.details()),
                         (grpc.StatusCode.UNAVAILABLE, "no daemon behind the entrance answers"))


class Silence(Case):
    def test_who_makes_no_call_is_ended_and_a_silent_stream_is_not(self):
        entrance = self.enter(limits=None, edits={"timeout client 10s": "timeout client 500ms",
                                                  "timeout http-request 10s": "timeout http-request 500ms"})
        target = self.target(entrance)
        target.tls_ca = self.folder.path("ca.pem")
        meshes = {"one": collided.Mesh(np.eye(3), np.array([[0, 1, 2]]))}
        with collided.Session(meshes, server=self.client(entrance, token="token-of-client-one"), reconnect_seconds=0,
                              transport="grpc") as session:
            session.step({"one": np.eye(3)})
            hello, nothing = self.enterContext(target.bytes()), self.enterContext(target.bytes())
            hello.sendall(b"\x16\x03\x01")
            begun, headers = self.enterContext(Http2(target)), self.enterContext(Http2(target))
            headers.send(headers.headers(flags=0))
            for name, peer in (("handshake", hello), ("connection", nothing), ("no call", begun.socket),
                               ("headers", headers.socket)):
                with self.subTest(name):
                    self.assertTrue(is_over(peer))
            session.step({"one": np.eye(3)})
            self.assertEqual(session.reconnects, 0)


class Calls(Case):
    def is_answered(self, peer, extra=b""):
        """True if a call is answered with HEADERS; False if the connection ends."""
        peer.reads, data = False, b""
        with contextlib.suppress(OSError):
            stream = peer.next
            peer.send(peer.headers(INFO, extra=extra) + frame(DATA, END_STREAM, stream, EMPTY))
            while HEADERS not in kinds(data):
                data += peer.receive()
            return True
        return False

    def test_a_connection_that_only_resets_is_ended_by_its_next_call(self):
        entrance = self.plain()
        for count, is_answered in ((60, True), (200, False)):
            with self.subTest(count), Http2(self.target(entrance)) as peer:
                peer.send(resets(peer, count))
                time.sleep(0.3)
                self.assertEqual(self.is_answered(peer), is_answered)

    def test_a_call_that_is_reset_at_once_never_reaches_the_daemon(self):
        entrance = self.plain()
        before = self.calls("StreamFrames")
        with Http2(self.target(entrance)) as peer:
            peer.send(frame(WINDOW_UPDATE, 0, 0, struct.pack(">I", 1 << 20)))  # for 100 answers
            for _ in range(100):
                peer.send(resets(peer, 1))
                self.assertTrue(self.is_answered(peer))
        self.assertEqual(self.calls("StreamFrames"), before)

    def test_a_guesser_of_tokens_is_ended(self):
        entrance = self.plain()
        with Http2(self.target(entrance, token="token-of-a-guesser")) as peer:
            self.assertEqual([self.is_answered(peer) for _ in range(23)], [True] * 21 + [False] * 2)

    def test_headers_that_are_too_long_are_refused_by_their_size(self):
        entrance = self.plain()
        with contextlib.closing(grpc.insecure_channel(entrance.address)) as channel:
            call = channel.unary_unary(f"/{SERVICE}/GetServerInfo")
            with self.assertRaises(grpc.RpcError) as refused:
                call(b"", timeout=10, metadata=(*INFO_OF_ONE, ("x-long", "y" * 6000)))
            self.assertEqual(refused.exception.code(), grpc.StatusCode.RESOURCE_EXHAUSTED)
            self.assertRegex(refused.exception.details(),
                             r"^headers have 6\d\d\d bytes, more than the entrance's limit of 6144$")
            self.assertTrue(call(b"", timeout=10, metadata=INFO_OF_ONE))

    def test_an_address_has_its_open_calls_and_the_whole_has_them(self):
        for limit, said in (("OPEN_CALLS_OF_AN_ADDRESS", "this address has 2 open calls, the entrance's limit"),
                            ("OPEN_CALLS", "the entrance has 2 open calls, its limit")):
            with self.subTest(limit):
                entrance = self.enter(plain=True, limits={limit: 2})
                with contextlib.closing(grpc.insecure_channel(entrance.address)) as channel:
                    watches = [channel.unary_stream("/grpc.health.v1.Health/Watch")(b"") for _ in range(2)]
                    for watch in watches:
                        next(watch)
                    with self.assertRaises(grpc.RpcError) as refused:
                        channel.unary_unary(f"/{SERVICE}/GetServerInfo")(b"", timeout=10, metadata=INFO_OF_ONE)
                    self.assertEqual((refused.exception.code(), refused.exception.details()),
                                     (grpc.StatusCode.RESOURCE_EXHAUSTED, said))

    def test_binary_metadata_is_left_out(self):
        entrance = self.plain()
        before = self.calls("GetServerInfo").get("OK", 0)
        with Http2(self.target(entrance)) as peer:
            self.assertTrue(self.is_answered(peer, b"\x00\x05x-bin\x01!"))
        self.assertEqual(self.calls("GetServerInfo").get("OK"), before + 1)


    def test_headers_that_end_a_daemon_do_not_reach_it(self):
        """CVE-2023-1428: gRPC 1.51 calls abort() where one of these is followed by more than 8 KiB of headers."""
        entrance = self.plain()
        for name, value in ((b"grpclb_client_stats", b"x"), (b"te", b"x")):
            for count, size in ((1, 5000), (8, 600), (50, 60), (60, 30), (1, 9000), (60, 200), (200, 30)):
                with self.subTest(name, count=count, size=size), Http2(self.target(entrance)) as peer:
                    lines = b"\x00" + text(name) + text(value)
                    lines += b"".join(b"\x00" + text(b"x-%d" % index) + text(b"y" * size) for index in range(count))
                    with contextlib.suppress(OSError):
                        self.is_answered(peer, lines)
                    self.assertIsNone(self.daemon.process.poll(), self.daemon.log()[-1000:])
        with Http2(self.target(entrance)) as peer:
            self.assertTrue(self.is_answered(peer, b""))


class Uploads(Case):
    CLIENTS = 32
    # A field of a later version, which the daemon skips, so that the test needs the memory of messages alone.
    PADDING = b"\x82\x7d\x80\x80\x80\x02" + bytes(4 << 20)

    def test_all_of_32_clients_that_begin_with_4_mb_are_served(self):
        entrance = self.enter()
        credentials = grpc.ssl_channel_credentials(self.folder.read("ca.pem"))
        options = [("grpc.use_local_subchannel_pool", 1), ("grpc.ssl_target_name_override", "localhost")]
        request = tip_request().SerializeToString() + self.PADDING
        channels = [grpc.secure_channel(entrance.address, credentials, options) for _ in range(self.CLIENTS)]
        metadata = [[("authorization", f"Bearer token-of-client-{name}")] for name in ("one", "two", "sim-1")]
        calls = [channel.unary_unary(f"/{SERVICE}/CreateScene").future(request, timeout=60, metadata=metadata[index % 3])
                 for index, channel in enumerate(channels)]
        scenes = {api.CreateSceneResponse.FromString(call.result()).scene.scene_id for call in calls}
        self.assertEqual(len(scenes), self.CLIENTS)
        self.assertLess(peak_mb(self.daemon.process) + peak_mb(entrance.process), MAX_MB)
        for channel in channels:
            channel.close()


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
