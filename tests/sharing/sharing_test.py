"""That the check of tests/sharing can fail, and the catalogue's size. Usage: sharing_test.py DAEMON"""

import copy
import pathlib
import subprocess
import sys
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[0] / "integration/support")]
from ops_daemon import Daemon, Folder  # noqa: E402: without gRPC for Python the test ends as skipped here

import honest  # noqa: E402

PROGRAM = sys.argv[1]
TOKEN = "token-of-honest-0"


def run(*options):
    return subprocess.run([sys.executable, HERE / "run", "--daemon", PROGRAM, *options], capture_output=True, text=True,
                          timeout=120, check=False)


class TheCatalogue(unittest.TestCase):
    def test_has_many_attacks_of_each_kind(self):
        lines = run("--list").stdout.splitlines()
        self.assertGreater(len(lines), 40)

    def test_knows_what_it_does_not_have(self):
        done = run("--only", "nothing")
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertIn("nothing", done.stderr)


class TheEntrance(unittest.TestCase):
    def test_plays_attacks_through_the_entrance(self):
        """All of them are integration.sharing_entrance and integration.sharing_address."""
        done = run("--entrance", "--counts", "--seconds", "1", "--only", "reset_storm")
        if done.returncode == 77:
            self.skipTest(done.stdout)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("1 of 1 entries", done.stdout)


class TheCheckFails(unittest.TestCase):
    def test_if_a_daemon_serves_nobody(self):
        done = run("--only", "stopped_daemon", "--seconds", "1", "--tries", "1", "--patience", "1")
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        self.assertRegex(done.stdout, "FAULT p99 is .* would be fair")
        self.assertRegex(done.stdout, "FAULT a newcomer during")
        self.assertIn("0 of 1 entries", done.stdout)

    def test_if_a_contact_is_wrong(self):
        folder = Folder()
        self.addCleanup(folder.cleanup)
        tokens = folder.put("tokens.toml", f'[[tokens]]\nname = "a"\ntoken = "{TOKEN}"\n')
        with Daemon(PROGRAM, "--tokens-file", tokens, "--local-socket", folder.path("local")) as daemon:
            server = honest.Server(daemon.address)
            wrong = copy.deepcopy(honest.right_answers(server, TOKEN))
            wrong[3] = wrong[4]
            clients = honest.Clients(server, [TOKEN], wrong)
            daemon.wait_for(clients.faults, "fault")
            clients.close()
            self.assertIn("contacts of step 3 are wrong", clients.faults()[0])
            with self.assertRaises(ValueError):
                honest.visit(server, TOKEN, wrong[:-1] + [wrong[0]], 30)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
