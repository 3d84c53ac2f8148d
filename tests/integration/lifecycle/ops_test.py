"""A real daemon's configuration, monitoring, security and shutdown. Usage: ops_test.py DAEMON DEPLOY_FOLDER"""

import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from ops_daemon import NOT_SERVING, SERVICE, SERVING, Daemon, DaemonCase, Folder  # noqa: E402

import grpc  # noqa: E402

PROGRAM, DEPLOY = sys.argv[1:3]
TOKEN = '[[tokens]]\nname = "a"\ntoken = "0123456789abcdef"\n'


def run(*options, **environment):
    return subprocess.run([PROGRAM, *options], capture_output=True, text=True, timeout=60,
                          env={**os.environ, **environment})


class Case(DaemonCase):
    program = PROGRAM

    def sound(self, *options, **environment):
        done = run("--check", *options, **environment)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stderr

    def refused(self, part, *options, **environment):
        for check in (["--check"], []):
            done = run(*check, *options, **environment)
            self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
            self.assertIn(part, done.stderr)


class Configuration(Case):
    def test_the_documented_file_is_sound(self):
        self.assertEqual(self.sound("--config", os.path.join(DEPLOY, "collided.toml")), "")

    def test_what_is_not_sound_is_named_and_does_not_start(self):
        self.refused("max-scene is not an option", "--config", self.folder.put("c.toml", "max-scene = 1\n"))
        self.refused("c.toml:2: --max-window", "--config", self.folder.put("c.toml", "\nmax-window = 0\n"))
        self.refused("--max-scenes", COLLIDED_MAX_SCENES="nan")
        self.refused("/nowhere", "--config", "/nowhere")
        self.refused("/nowhere", "--tokens-file", "/nowhere")

    def test_output_that_cannot_be_written_is_an_error(self):
        for word in ("--help", "--version", "--check"):
            with open("/dev/full", "w", encoding="ascii") as full:
                done = subprocess.run([PROGRAM, word], stdout=full, stderr=subprocess.PIPE, text=True, timeout=60)
            self.assertEqual((done.returncode, done.stderr), (1, "collided: standard output cannot be written\n"), word)

    def test_a_bad_tokens_file_is_named_without_its_tokens(self):
        path = self.folder.put("tokens.toml", TOKEN + TOKEN)
        self.refused("tokens.toml:4: the token of a appears twice", "--tokens-file", path)
        path = self.folder.put("tokens.toml", TOKEN[:-2])
        done = run("--check", "--tokens-file", path)
        self.assertEqual(done.returncode, 2)
        self.assertNotIn("0123456789", done.stdout + done.stderr)

    def test_tls_files_are_checked(self):
        tls = self.folder.certificates()
        self.assertEqual(self.sound(*tls, "--tls-client-ca", self.folder.path("ca.pem")), "")
        self.refused("--tls-key", *tls[:3], self.folder.path("client.key"))
        self.refused("--tls-client-ca", *tls, "--tls-client-ca", self.folder.path("ca.key"))

    def test_what_is_exposed_must_be_asked_for_and_is_warned_of(self):
        public = ["--address", "0.0.0.0:0"]
        self.refused("--allow-insecure", *public)
        warnings = self.sound(*public, "--allow-insecure")
        self.assertIn("without TLS", warnings)
        self.assertIn("clients need not authenticate", warnings)
        daemon = self.start("--allow-insecure", address="0.0.0.0:0")
        self.assertIn("without TLS", daemon.log())
        self.assertEqual(daemon.stop(), 0)

    def test_flags_environment_and_file_in_this_order(self):
        path = self.folder.put("c.toml", 'log-format = "json"\nlog-level = "debug"\n')
        os.environ["COLLIDED_LOG_FORMAT"] = "text"
        self.addCleanup(os.environ.pop, "COLLIDED_LOG_FORMAT")
        self.assertNotIn("{", self.start("--config", path).log())
        flags = self.start("--config", path, "--log-format", "json")
        self.assertEqual({json.loads(line)["level"] for line in flags.log().splitlines()}, {"info"})


class Reload(Case):
    def test_takes_up_what_may_change(self):
        path = self.folder.put("c.toml", "threads = 1\n")
        daemon = self.start("--config", path)
        self.folder.put("c.toml", 'threads = 2\nlog-format = "json"\n')
        lines = [json.loads(line) for line in daemon.reload().splitlines()]
        self.assertEqual(lines[0]["message"], "configuration read again")
        changed = "threads has changed, which takes effect only after a restart"
        daemon.wait_for(lambda: changed in daemon.log(), "warning")
        self.folder.put("c.toml", 'threads = 1\nlog-level = "off"\n')
        daemon.signal(signal.SIGHUP)
        self.assertEqual(daemon.stop(), 0)
        self.assertNotIn("stopped", daemon.log())

    def test_what_is_not_sound_changes_nothing(self):
        tokens = self.folder.put("tokens.toml", TOKEN)
        path = self.folder.put("c.toml", f'tokens-file = "{tokens}"\n')
        daemon = self.start("--config", path)
        self.folder.put("c.toml", f'tokens-file = "{tokens}"\nlog-format = "json"\nmax-scenes = 0\n')
        said = daemon.reload()
        self.assertIn("error configuration not read again", said)
        self.assertIn("--max-scenes", said)
        self.folder.put("c.toml", f'tokens-file = "{tokens}"\nlog-format = "json"\n')
        self.folder.put("tokens.toml", "[[tokens]]\n")
        said = daemon.reload()
        self.assertIn("error configuration not read again", said)
        self.assertIn("tokens.toml:1", said)
        self.folder.put("tokens.toml", TOKEN)
        self.assertEqual(json.loads(daemon.reload().splitlines()[0])["message"], "configuration read again")
        self.assertEqual(daemon.stop(), 0)


class Watched(Case):
    def test_metrics_please_promtool(self):
        daemon = self.start()
        status, text = daemon.http("/metrics")
        self.assertEqual(status, 200)
        self.assertIn("\ncollided_build_info{", text)
        if not shutil.which("promtool"):
            self.skipTest("promtool is not installed")
        said = subprocess.run(["promtool", "check", "metrics"], input=text, capture_output=True, text=True, timeout=60)
        self.assertEqual((said.returncode, said.stdout + said.stderr), (0, ""))

    def test_health_is_told_for_each_service_and_over_all(self):
        daemon = self.start()
        self.assertEqual(daemon.http("/readyz"), (200, "ready\n"))
        self.assertEqual(daemon.http("/healthz")[0], 200)
        self.assertEqual(daemon.http("/")[0], 404)
        for service in ("", SERVICE):
            self.assertEqual(daemon.health(service), SERVING)
        with self.assertRaises(grpc.RpcError) as caught:
            daemon.health("no.Service")
        self.assertEqual(caught.exception.code(), grpc.StatusCode.NOT_FOUND)

    def test_an_http_address_in_use_is_named(self):
        daemon = self.start()
        done = run("--address", "127.0.0.1:0", "--http-address", daemon.http_address)
        self.assertEqual(done.returncode, 1)
        self.assertIn(daemon.http_address, done.stderr)


class Drain(Case):
    def drain(self):
        daemon = self.start("--grace-seconds", "600")
        over, call = self.hold(daemon)
        daemon.signal(signal.SIGTERM)
        daemon.wait_for(lambda: daemon.http("/readyz") == (503, "draining\n"), "draining")
        for service in ("", SERVICE):
            self.assertEqual(daemon.health(service), NOT_SERVING)
        self.assertEqual(daemon.http("/healthz")[0], 200)
        self.assertIsNone(daemon.process.poll())
        return daemon, over, call

    def test_waits_for_what_is_open_and_exits_with_0(self):
        daemon, over, call = self.drain()
        over.set()
        self.assertEqual(daemon.process.wait(60), 0)
        self.assertNotEqual(call.code(), grpc.StatusCode.UNAVAILABLE)

    def test_a_second_signal_cuts_the_grace_short(self):
        daemon, _, call = self.drain()
        daemon.signal(signal.SIGTERM)
        self.assertEqual(daemon.process.wait(60), 0)
        self.assertIsNotNone(call.exception(60))

    def test_the_grace_ends(self):
        grace = 0.5
        daemon = self.start("--grace-seconds", str(grace))
        _, call = self.hold(daemon)
        begin = time.monotonic()
        daemon.signal(signal.SIGTERM)
        self.assertEqual(daemon.process.wait(60), 0)
        self.assertGreaterEqual(time.monotonic() - begin, grace)
        self.assertIsNotNone(call.exception(60))


class Tls(Case):
    def credentials(self, client=None):
        shown = (self.folder.read(f"{client}.key"), self.folder.read(f"{client}.pem")) if client else (None, None)
        return grpc.ssl_channel_credentials(self.folder.read("ca.pem"), *shown)

    def refuses(self, daemon, credentials):
        with self.assertRaises(grpc.RpcError) as caught:
            daemon.health(credentials=credentials)
        self.assertEqual(caught.exception.code(), grpc.StatusCode.UNAVAILABLE)

    def test_the_server_shows_its_certificate(self):
        daemon = self.start(*self.folder.certificates())
        self.assertEqual(daemon.health(credentials=self.credentials()), SERVING)
        self.refuses(daemon, None)
        self.assertEqual(daemon.stop(), 0)

    def test_clients_show_theirs(self):
        daemon = self.start(*self.folder.certificates(), "--tls-client-ca", self.folder.path("ca.pem"))
        self.assertEqual(daemon.health(credentials=self.credentials("client")), SERVING)
        self.refuses(daemon, self.credentials())
        self.refuses(daemon, self.credentials("stranger"))
        self.assertEqual(daemon.health(credentials=self.credentials("client")), SERVING)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
