#!/usr/bin/env python3
"""What the real daemon tells the service manager that started it, over the protocol of sd_notify(3).

usage: notify_test.py DAEMON
"""

import os
import pathlib
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

DAEMON = sys.argv[1]
PATIENCE = 60  # seconds


class Notify(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.config = self.folder / "collided.toml"
        self.manager = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.addCleanup(self.manager.close)
        self.manager.bind(f"{folder.name}/notify")
        self.manager.settimeout(PATIENCE)

    def start(self, config="", **environment):
        self.config.write_text(config)
        self.socket = f"unix:{self.folder}/socket"
        self.daemon = subprocess.Popen(
            [DAEMON, "--config", self.config, "--backend", "cpu", "--log-level", "off", "--address", self.socket],
            env={**os.environ, "NOTIFY_SOCKET": f"{self.folder}/notify", **environment})
        self.addCleanup(self.daemon.wait)
        self.addCleanup(self.daemon.kill)

    def told(self):
        """The next message's assignments."""
        return dict(line.split("=", 1) for line in self.manager.recv(65536).decode().splitlines())

    def told_of(self, name):
        """The next message that has `name`; WATCHDOG=1 may come before."""
        while name not in (message := self.told()):
            self.assertEqual(message, {"WATCHDOG": "1"})
        return message

    def test_ready_comes_once_clients_can_connect(self):
        self.start()
        self.assertEqual(self.told(), {"READY": "1", "STATUS": f"serves on {self.socket}"})
        with socket.socket(socket.AF_UNIX) as client:
            client.connect(f"{self.folder}/socket")

    def test_a_reload_is_announced_and_ends(self):
        self.start("max-scenes = 3\n")
        self.told()
        before = time.clock_gettime_ns(time.CLOCK_MONOTONIC) // 1000
        self.daemon.send_signal(signal.SIGHUP)
        reloading = self.told()
        self.assertEqual(reloading["RELOADING"], "1")
        self.assertGreaterEqual(int(reloading["MONOTONIC_USEC"]), before)
        self.assertEqual(self.told(), {"READY": "1", "STATUS": f"serves on {self.socket}"})

    def test_a_refused_reload_says_why_in_the_status(self):
        self.start("max-scenes = 3\n")
        self.told()
        self.config.write_text("max-scenes = 0\n")
        self.daemon.send_signal(signal.SIGHUP)
        self.assertEqual(self.told()["RELOADING"], "1")
        said = self.told()
        self.assertEqual(said["READY"], "1")
        self.assertRegex(said["STATUS"], r"^serves on .*; configuration not read again: .*max-scenes")

    def test_stopping_asks_for_the_time_of_the_grace(self):
        self.start("grace-seconds = 200\n")
        self.told()
        self.daemon.terminate()
        said = self.told()
        self.assertEqual(said["STOPPING"], "1")
        self.assertGreaterEqual(int(said["EXTEND_TIMEOUT_USEC"]), 200_000_000)
        self.assertEqual(self.daemon.wait(PATIENCE), 0)  # no call is open: it does not wait

    def test_the_watchdog_hears_it_again_and_again(self):
        self.start(WATCHDOG_USEC="400000")
        self.told_of("READY")
        for _ in range(3):
            self.assertEqual(self.told(), {"WATCHDOG": "1"})

    def test_a_watchdog_of_another_process_is_not_answered(self):
        self.start(WATCHDOG_USEC="1000", WATCHDOG_PID="1")
        self.told_of("READY")
        self.daemon.send_signal(signal.SIGHUP)
        self.assertEqual(self.told()["RELOADING"], "1")

    def test_a_manager_that_is_gone_harms_nothing(self):
        self.start(WATCHDOG_USEC="1000")
        self.told_of("READY")
        self.manager.close()
        os.unlink(self.folder / "notify")
        self.daemon.terminate()
        self.assertEqual(self.daemon.wait(PATIENCE), 0)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
