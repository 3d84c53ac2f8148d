"""collidectl's TLS and token options against a real daemon. Usage: collidectl_security_test.py DAEMON COLLIDECTL"""

import json
import pathlib
import subprocess
import sys
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from ops_daemon import Daemon, Folder  # noqa: E402

PROGRAM, COLLIDECTL = sys.argv[1:3]
TOKEN, OTHER_TOKEN = "token-of-client-a", "token-of-client-b"
# A triangle, and a corner of another one that passes straight through its inside.
FRAMES = ["v 0 0 0\nv 4 0 0\nv 0 4 0\nv 1 1 1\nv 1.5 1 3\nv 1 1.5 3\nf 1 2 3\nf 4 5 6\n",
          "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 1 1 -1\nv 1.5 1 1\nv 1 1.5 1\nf 1 2 3\nf 4 5 6\n"]


class Security(unittest.TestCase):
    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)
        self.server_tls = self.folder.certificates()
        self.folder.sign("expired", "sim-1", "ca", days=0)  # OpenSSL 3.5 makes none that ends before it begins
        time.sleep(1.1)

    def start(self, *options):
        self.daemon = Daemon(PROGRAM, *options)
        self.addCleanup(self.daemon.__exit__)

    def start_mutual(self):
        self.start(*self.server_tls, "--tls-client-ca", self.folder.path("ca.pem"))

    def start_with_tokens(self, *options):
        table = f'[[tokens]]\nname = "a"\ntoken = "{TOKEN}"\n'
        self.start("--tokens-file", self.folder.put("tokens.toml", table), *options)

    def ca(self, name="ca"):
        return ["--tls-ca", self.folder.path(f"{name}.pem")]

    def shown(self, name):
        return ["--tls-cert", self.folder.path(f"{name}.pem"), "--tls-key", self.folder.path(f"{name}.key")]

    def token(self, text):
        return ["--token-file", self.folder.put("token", text)]

    def ctl(self, *words):
        words = [COLLIDECTL, *words, "--server", self.daemon.address]
        return subprocess.run(words, capture_output=True, text=True, timeout=120, check=False)

    def served(self, *options):
        """Both a call and a stream of frames."""
        info = self.ctl("info", "--json", *options)
        self.assertEqual(info.returncode, 0, info.stderr)
        self.assertTrue(json.loads(info.stdout)["version"])
        frames = [self.folder.put(f"{i}.obj", text) for i, text in enumerate(FRAMES)]
        detected = self.ctl("detect", "--frames", *frames, "--backend", "cpu", *options)
        self.assertEqual(detected.returncode, 0, detected.stderr)

    def refused(self, parts, *options, code=1):
        """One sentence that has all `parts`, and no secret."""
        done = self.ctl("info", *options)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        said = done.stderr.splitlines()
        self.assertEqual(len(said), 1, done.stderr)
        self.assertTrue(said[0].startswith("collidectl: "), done.stderr)
        for part in parts:
            self.assertIn(part, said[0])
        self.assertNotIn("oken-of", done.stderr)
        self.assertEqual(done.stdout, "")

    def unreachable(self, reason, *options):
        self.refused(["UNAVAILABLE", self.daemon.address, reason], *options)

    def test_tls_needs_the_right_ca(self):
        self.start(*self.server_tls)
        self.served(*self.ca())
        self.unreachable("certificate verify failed", *self.ca("other"))
        self.served(*self.ca())

    def test_plain_text_and_tls_do_not_meet(self):
        self.start(*self.server_tls)
        self.unreachable("")
        self.start()
        self.served()
        self.unreachable("wrong version number", *self.ca())

    def test_a_certificate_for_another_name_is_not_taken(self):
        self.start("--tls-certificate", self.folder.path("client.pem"), "--tls-key", self.folder.path("client.key"))
        self.unreachable("not in peer certificate", *self.ca())

    def test_a_daemon_does_not_start_with_an_expired_certificate(self):
        with self.assertRaisesRegex(RuntimeError, "--tls-certificate .*expired.pem: has expired"):
            self.start("--tls-certificate", self.folder.path("expired.pem"), "--tls-key",
                       self.folder.path("expired.key"))

    def test_a_daemon_that_asks_for_certificates_takes_only_good_ones(self):
        self.start_mutual()
        self.served(*self.ca(), *self.shown("client"))
        self.unreachable("", *self.ca())
        self.unreachable("", *self.ca(), *self.shown("stranger"))
        self.unreachable("", *self.ca(), *self.shown("expired"))
        self.served(*self.ca(), *self.shown("client"))

    def test_files_that_cannot_be_used_are_named(self):
        self.start_mutual()
        self.refused(["tls_ca", "/nowhere"], "--tls-ca", "/nowhere")
        self.refused(["--token-file", "/nowhere"], "--token-file", "/nowhere")
        self.refused(["--tls-cert"], *self.ca(), "--tls-cert", self.folder.path("client.pem"), code=2)
        self.refused(["--tls-key"], *self.ca(), "--tls-key", self.folder.path("client.key"), code=2)
        self.refused(["--tls-ca"], *self.shown("client"), code=2)
        self.refused(["token"], *self.ca(), *self.token("two words"))

    def test_a_token_must_be_known(self):
        self.start_with_tokens()
        self.served(*self.token(TOKEN))
        self.refused(["UNAUTHENTICATED"])
        self.refused(["UNAUTHENTICATED"], *self.token(OTHER_TOKEN))
        self.assertNotIn("oken-of", self.daemon.log())

    def test_tokens_and_tls_together(self):
        self.start_with_tokens(*self.server_tls)
        self.served(*self.ca(), *self.token(TOKEN))
        self.refused(["UNAUTHENTICATED"], *self.ca(), *self.token(OTHER_TOKEN))
        self.unreachable("", *self.token(TOKEN))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
