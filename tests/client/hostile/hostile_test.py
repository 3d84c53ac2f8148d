#!/usr/bin/env python3
"""Clients of each language against a daemon that misbehaves (evil_daemon.py): each call ends with a typed error, in time, and
in little memory.

usage: hostile_test.py LANGUAGE REPOSITORY BUILD_FOLDER [PROGRAM]
"""

import pathlib
import resource
import subprocess
import sys
import unittest

try:
    import grpc  # noqa: F401
except ImportError as missing:
    print(f"skipped: {missing} (Debian: python3-grpcio)")
    sys.exit(77)

LANGUAGE = sys.argv[1]
REPOSITORY, BUILD = (pathlib.Path(argument).resolve() for argument in sys.argv[2:4])
sys.path.insert(0, str(pathlib.Path(__file__).parent))
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / LANGUAGE))
from evil_daemon import BEHAVIOURS, LATE, EvilDaemon  # noqa: E402

SECONDS = 1  # the clients' patience and deadline
MOST_SECONDS = 40  # several waits, one after the other, on a host that is busy
MOST_BYTES = 400 << 20


def command():
    """Returns the command of the client's program."""
    if LANGUAGE == "python":
        return [sys.executable, str(REPOSITORY / "tests" / "client" / "hostile" / "client.py")]
    if LANGUAGE == "cpp":
        return [sys.argv[4]]
    if LANGUAGE == "go":
        from go_workspace import Missing, Workspace
        try:
            return Workspace(REPOSITORY, BUILD).built(REPOSITORY / "tests" / "client" / "hostile" / "client.go")
        except Missing as missing:
            skip(missing)
    import node_package
    try:
        package = node_package.built(REPOSITORY, BUILD)
    except node_package.Missing as missing:
        skip(missing)
    return [node_package.node(), str(REPOSITORY / "tests" / "client" / "hostile" / "client.mjs"), str(package)]


def skip(why):
    print(f"skipped: {why}")
    sys.exit(77)


SCENARIOS = {"python": {"stream", "advance", "limits", "pairs", "call", "watch", "mesh", "list", "set", "local", "timeouts"},
             "cpp": {"stream", "session", "large", "limits", "watch", "mesh", "list", "set", "local"},
             "go": {"stream", "advance", "limits", "pairs", "session", "call", "watch", "mesh", "list"},
             "node": {"stream", "advance", "limits", "pairs", "session", "call", "watch", "mesh", "list"}}[LANGUAGE]


class Hostile(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.command = command()
        cls.daemon = EvilDaemon()
        cls.addClassCleanup(cls.daemon.close)

    def run_client(self, asked, seconds):
        """Code, seconds and message by behaviour and scenario. seconds: the client's patience and deadline."""
        lines = "".join(f"{name} {scenario} {self.daemon.address}\n" for name, scenario in asked)
        done = subprocess.run([*self.command, str(seconds)], input=lines, text=True, capture_output=True, timeout=120)
        self.assertEqual(done.returncode, 0, done.stderr[-4000:])
        answers = {}
        for line in done.stdout.splitlines():
            name, scenario, code, took, *message = line.split(" ", 4)
            answers[name, scenario] = code, float(took), "".join(message)
        self.assertEqual(sorted(answers), sorted(asked))
        return answers

    def test_each_behaviour_ends_with_an_error_in_time_and_in_little_memory(self):
        asked = [(name, scenario) for name, behaviour in BEHAVIOURS.items() for scenario in behaviour.scenarios
                 if scenario in SCENARIOS]
        answers = self.run_client(asked, SECONDS)
        # On a busy host the honest parts of a behaviour may exceed the limit, too.
        late = [(name, scenario) for (name, scenario), (code, *_) in answers.items()
                if code in (LATE, "UNAVAILABLE") and code not in BEHAVIOURS[name].expected]
        answers |= self.run_client(late, 10 * SECONDS) if late else {}
        for (name, scenario), (code, seconds, message) in answers.items():
            with self.subTest(behaviour=name, scenario=scenario):
                self.assertIn(code, BEHAVIOURS[name].expected, message)
                if LANGUAGE != "cpp":  # which names fields as the protocol's enum does
                    self.assertIn(BEHAVIOURS[name].says, message)
                self.assertLess(seconds, MOST_SECONDS, message)
        self.assertLess(1024 * resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss, MOST_BYTES)

    def test_an_endpoint_that_refuses_connections_at_first_is_waited_for(self):
        (answer,) = self.run_client([("EndpointThatComesLater", "stream")], 20).values()
        self.assertEqual(answer[0], "ok", answer)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2, warnings="ignore")
