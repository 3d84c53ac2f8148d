"""Bearer tokens and certificate names over gRPC, against a real daemon. Usage: tokens_test.py DAEMON"""

import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from ops_daemon import SERVING, Daemon, Folder  # noqa: E402

import grpc  # noqa: E402

PROGRAM = sys.argv[1]


def tokens(name, token):
    return f'[[tokens]]\nname = "{name}"\ntoken = "{token}"\n'


def bearer(token):
    return (("authorization", f"Bearer {token}"),)


class Tokens(unittest.TestCase):
    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)
        self.path = self.folder.put("tokens.toml", tokens("a", "token-of-client-a"))
        self.daemon = Daemon(PROGRAM, "--tokens-file", self.path)
        self.addCleanup(self.daemon.__exit__)

    def refused(self, metadata):
        with self.assertRaises(grpc.RpcError) as caught:
            self.daemon.info(metadata=metadata)
        self.assertEqual(caught.exception.code(), grpc.StatusCode.UNAUTHENTICATED)
        self.assertNotIn("oken-of", caught.exception.details())

    def test_a_call_needs_a_known_token(self):
        self.assertTrue(self.daemon.info(metadata=bearer("token-of-client-a")))
        for metadata in ((), bearer("token-of-client-b"), (("authorization", "Basic token-of-client-a"),)):
            self.refused(metadata)
        self.assertNotIn("oken-of", self.daemon.log())

    def test_health_needs_none(self):
        self.assertEqual(self.daemon.health(), SERVING)

    def test_a_reload_exchanges_them_and_a_bad_file_does_not(self):
        self.folder.put("tokens.toml", tokens("b", "token-of-client-b"))
        self.daemon.reload()
        self.assertTrue(self.daemon.info(metadata=bearer("token-of-client-b")))
        self.refused(bearer("token-of-client-a"))
        self.folder.put("tokens.toml", tokens("c", "short"))
        self.assertIn("not read again", self.daemon.reload())
        self.assertTrue(self.daemon.info(metadata=bearer("token-of-client-b")))

    def test_refusals_are_counted(self):
        self.refused(())
        self.assertIn('\ncollided_rejected_total{reason="UNAUTHENTICATED"} 1\n', self.daemon.http("/metrics")[1])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
