"""No secret in what the daemon and collidectl write, at the most verbose level. Usage: secrets_test.py DAEMON COLLIDECTL"""

import base64
import hashlib
import pathlib
import secrets
import subprocess
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from ops_daemon import DaemonCase  # noqa: E402

import grpc  # noqa: E402

PROGRAM, COLLIDECTL = sys.argv[1:3]
FRAMES = ["v 0 0 0\nv 4 0 0\nv 0 4 0\nv 1 1 1\nv 1.5 1 3\nv 1 1.5 3\nf 1 2 3\nf 4 5 6\n",
          "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 1 1 -1\nv 1.5 1 1\nv 1 1.5 1\nf 1 2 3\nf 4 5 6\n"]


def lines_of_key(pem):
    """The base64 of a PEM file, whose lines are secrets each."""
    return [line for line in pem.splitlines() if line and not line.startswith("-----")]


def forms(secret):
    """How a secret could be written: itself, and what a log may make of its bytes."""
    raw = secret.encode()
    return {secret, raw.hex(), base64.b64encode(raw).decode().rstrip("=")[:-1]}


def found_in(text, named):
    """Names of the secrets that a text has a form of."""
    return [name for name, secret in named.items() if any(form in text for form in forms(secret))]


class Search(unittest.TestCase):
    def test_finds_each_form_and_nothing_else(self):
        named = {"token": "a-token-of-tests"}
        for form in forms(named["token"]):
            self.assertEqual(found_in(f"level=debug said {form} here", named), ["token"])
        self.assertEqual(found_in("level=debug client=a", named), [])


class Logs(DaemonCase):
    program = PROGRAM

    def setUp(self):
        super().setUp()
        self.tokens = {name: secrets.token_urlsafe(24) for name in ("known", "hashed", "renewed", "wrong", "broken")}
        self.said = ""
        tls = self.folder.certificates()
        self.daemon = self.start(*tls, "--tls-client-ca", self.folder.path("ca.pem"), "--tokens-file", self.write("known"),
                                 "--log-level", "trace", "--log-format", self.log_format)
        keys = {f"{name} key, line {i}": line for name in ("server", "client") for i, line in
                enumerate(lines_of_key(self.folder.read(f"{name}.key").decode()))}
        self.assertGreater(len(keys), 4)
        self.secrets = self.tokens | keys

    def write(self, plain, more=""):
        digest = hashlib.sha256(self.tokens["hashed"].encode()).hexdigest()
        return self.folder.put("tokens.toml", f'[[tokens]]\nname = "a"\ntoken = "{self.tokens[plain]}"\n[[tokens]]\nname = "b"\n'
                                              f'sha256 = "{digest}"\n{more}')

    def ctl(self, token, *words):
        words = [COLLIDECTL, *words, "--server", self.daemon.address, "--tls-ca", self.folder.path("ca.pem"), "--tls-cert",
                 self.folder.path("client.pem"), "--tls-key", self.folder.path("client.key"), "--token-file",
                 self.folder.put("token", self.tokens[token])]
        done = subprocess.run(words, capture_output=True, text=True, timeout=120, check=False)
        self.said += done.stdout + done.stderr
        return done.returncode

    def credentials(self):
        return grpc.ssl_channel_credentials(self.folder.read("ca.pem"), self.folder.read("client.key"),
                                            self.folder.read("client.pem"))

    def refuse(self, header):
        with self.assertRaises(grpc.RpcError) as caught:
            self.daemon.info(self.credentials(), (("authorization", header),))
        self.assertEqual(caught.exception.code(), grpc.StatusCode.UNAUTHENTICATED)
        self.said += caught.exception.details()

    def serve_all(self):
        """Frames, refusals of every kind, reloads good and bad."""
        frames = [self.folder.put(f"{i}.obj", text) for i, text in enumerate(FRAMES)]
        for token in ("known", "hashed"):
            self.assertEqual(self.ctl(token, "detect", "--frames", *frames, "--backend", "cpu"), 0, self.said)
        self.assertEqual(self.ctl("wrong", "info"), 1)
        for header in ("Bearer {}", "Basic {}", "Bearer {} {}", "{}"):
            self.refuse(header.format(self.tokens["wrong"], self.tokens["known"]))
        self.write("known", f'[[tokens]]\nname = "c"\ntoken = "{self.tokens["broken"]}')
        self.assertIn("not read again", self.daemon.reload())
        self.write("renewed")
        self.daemon.reload()
        self.assertEqual(self.ctl("renewed", "info"), 0, self.said)
        self.assertEqual(self.ctl("known", "info"), 1)
        self.said += self.daemon.http("/metrics")[1]

    def check(self):
        self.serve_all()
        self.assertEqual(self.daemon.stop(), 0)
        log = self.daemon.log()
        # The log is as verbose as it gets, and has these clients' frames and refusals.
        self.assertRegex(log, "(?i)debug")
        self.assertRegex(log, "UNAUTHENTICATED|token")
        self.assertGreater(len(log.splitlines()), 8, log)
        self.assertEqual(found_in(log, self.secrets), [])
        self.assertEqual(found_in(self.said, self.secrets), [])


class Text(Logs):
    log_format = "text"

    def test_has_no_secret(self):
        self.check()


class Json(Logs):
    log_format = "json"

    def test_has_no_secret(self):
        self.check()


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
