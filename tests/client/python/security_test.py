#!/usr/bin/env python3
"""TLS, client certificates, tokens, and who listens at the local socket."""

import os
import socket
import sys
import tempfile
import threading
import unittest

from support import DAEMON, REPOSITORY, TIP, lowered, main, meshes

sys.path.insert(0, str(REPOSITORY / "tests" / "integration" / "support"))
from ops_daemon import Daemon, Folder  # noqa: E402

import collided  # noqa: E402

TOKEN = "token-of-client-a"


class Security(unittest.TestCase):
    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)

    def start(self, *options):
        self.daemon = Daemon(str(DAEMON), *options)
        self.addCleanup(self.daemon.__exit__)

    def served(self, **options):
        with collided.Session(meshes(), server=self.daemon.address, **options) as session:
            self.assertEqual(session.step({"tip": lowered(2)}).elements.tolist(), [[3, 0]])
            return session.is_local

    def refused(self, kind, pattern, **options):
        with self.assertRaisesRegex(kind, pattern):
            collided.Client(self.daemon.address, patience=0.5, **options).info

    def test_tls_and_client_certificates(self):
        tls = self.folder.certificates()
        path = self.folder.path
        own = {"tls_ca": path("ca.pem"), "tls_certificate": path("client.pem"), "tls_key": path("client.key")}
        self.start(*tls, "--tls-client-ca", path("ca.pem"))
        self.served(**own)
        self.refused(collided.Unavailable, "no daemon answers", tls_ca=path("ca.pem"))
        self.refused(collided.Unavailable, "ertificate|SSL|handshake", **{**own, "tls_ca": path("other.pem")})
        self.refused(collided.Unavailable, "no daemon answers")
        self.refused(collided.InvalidArgument, "tls_key is .* cannot be read", **{**own, "tls_key": path("none")})
        self.refused(collided.InvalidArgument, "tls_ca is .* is empty", tls_ca=self.folder.put("empty", ""))

    def test_tokens(self):
        table = self.folder.put("tokens.toml", f'[[tokens]]\nname = "a"\ntoken = "{TOKEN}"\n')
        self.start("--tokens-file", table, "--local-socket", self.folder.path("local"))
        self.assertTrue(self.served(token=TOKEN))
        self.assertFalse(self.served(token=TOKEN, transport="grpc"))
        self.refused(collided.Unauthenticated, "token", token="another")
        self.refused(PermissionError, "token")
        with self.assertRaisesRegex(collided.InvalidArgument, "not sent to 'gpu-host:50551' in plain text"):
            collided.Client("gpu-host:50551", token=TOKEN)
        with self.assertRaisesRegex(collided.InvalidArgument, "in plain text"):
            collided.Client("ipv6:[::1]:1,[fd00::2]:1", token=TOKEN)
        collided.Client("gpu-host:50551", token=TOKEN, allow_insecure_token=True)

    def test_a_folder_that_anyone_may_write_to_is_not_trusted(self):
        os.chmod(self.folder.name, 0o777)
        self.start("--local-socket", self.folder.path("local"))
        with collided.Session(meshes(), server=self.daemon.address) as session:
            self.assertFalse(session.is_local)
            self.assertIn("can be written to by every user", session.local_refusal)
        with self.assertRaisesRegex(collided.PermissionDenied, "not sticky"):
            collided.Session(meshes(), server=self.daemon.address, transport="shared_memory")


class Peers(unittest.TestCase):
    """A daemon's local socket at which something else listens."""

    def test_a_peer_that_answers_nonsense_is_left_for_grpc(self):
        for answer in (b"\xff\xff\xff", b"", None):
            with tempfile.TemporaryDirectory() as folder:
                daemon = Daemon(str(DAEMON), "--local-socket", folder + "/local")
                self.addCleanup(daemon.__exit__)
                os.unlink(folder + "/local")
                listener = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
                self.addCleanup(listener.close)
                listener.bind(folder + "/local")
                listener.listen()
                thread = threading.Thread(target=self.answer_once, args=(listener, answer), daemon=True)
                thread.start()
                with collided.Session(meshes(), server=daemon.address) as session:
                    self.assertFalse(session.is_local)
                    self.assertTrue(session.local_refusal)
                    self.assertEqual(len(session.step({"tip": TIP})), 0)
                thread.join()

    def answer_once(self, listener, answer):
        connection, _ = listener.accept()
        if answer is not None:
            connection.recv(1 << 16)
            connection.send(answer)
        connection.close()


if __name__ == "__main__":
    main()
