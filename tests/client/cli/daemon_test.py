"""collidectl with its own daemon and with running ones: which is used, and what is left behind.

Usage: daemon_test.py COLLIDECTL DAEMON"""

import glob
import json
import os
import pathlib
import pwd
import re
import signal
import socket
import subprocess
import tempfile
import time

import support
from support import COLLIDECTL, DAEMON, ONE_CPU


PROTO = pathlib.Path(__file__).resolve().parents[3] / "proto" / "collided" / "v1" / "collision_service.proto"


class Daemon(support.CollidectlTest):
    def test_a_running_daemon_is_used(self):
        with self.daemon() as address:
            info = json.loads(self.ok("info", "--server", address, "--json"))
            self.assertEqual(info["devices"]["cpu:0"]["scenes"], 0)
            self.assertEqual(info["local_socket"], "")
            for _ in range(2):
                self.ok("detect", "--frames", self.frame0, self.frame1, "--server", address, "--backend", "cpu")

    def test_a_daemon_whose_kernels_are_compiled_is_waited_for_and_told_of(self):
        line = "compiling the kernels for cuda:0 (a GPU)"
        script = self.put("daemon", f"#!/bin/sh\necho '[warning] {line}'\nsleep 2.5\nexec {DAEMON} \"$@\"\n")
        os.chmod(script, 0o700)
        done = support.ctl("detect", "--frames", self.frame0, self.frame1, *ONE_CPU, COLLIDED_DAEMON=script)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stderr, f"collidectl: waiting for its daemon: {line}\n")

    def test_info_tells_every_limit(self):
        limits = {"max-vertices": 5, "max-triangles": 6, "max-window": 7, "max-idle-seconds": 8.5,
                  "max-lease-seconds": 90, "max-scenes": 10, "max-streams": 11, "max-scenes-per-client": 12,
                  "max-streams-per-client": 13, "max-frames-per-second": 14.5,
                  "max-frame-seconds": 19.5, "max-accuracy": "guarded"}
        megabytes = {"max-message-mb": ("max_message_bytes", 15), "max-scene-mb": ("max_scene_bytes", 16),
                     "max-device-mb": ("max_device_bytes", 17),
                     "max-device-mb-per-client": ("max_device_bytes_per_client", 18)}
        local = os.path.join(self.folder.name, "local")
        words = [f"--{name}={value}" for name, value in limits.items()]
        words += [f"--{name}={value}" for name, (_, value) in megabytes.items()]
        with self.daemon("--local-socket", local, *words) as address:
            info = json.loads(self.ok("info", "--server", address, "--json"))
            text = self.ok("info", "--server", address)
        expected = {name.replace("-", "_"): value for name, value in limits.items()}
        expected.update({name: value << 20 for name, value in megabytes.values()})
        expected["min_ping_seconds"] = 0.1  # no option changes it
        self.assertEqual(info["limits"], expected)
        message = re.search(r"^message ServerLimits \{(.*?)^\}", PROTO.read_text(), re.MULTILINE | re.DOTALL)[1]
        self.assertEqual(set(info["limits"]), set(re.findall(r"^  \w+ (\w+) = \d+;", message, re.MULTILINE)))
        self.assertEqual(info["local_socket"], local)
        for name in (*expected, "local_socket"):
            self.assertIn(name, text)

    def test_a_socket_in_a_folder_of_the_user_that_is_named_is_used(self):
        if os.geteuid() != 0:
            self.skipTest("only root can give a folder to another user")
        folder = os.path.join(self.folder.name, "sockets")
        os.mkdir(folder)
        nobody = pwd.getpwnam("nobody")
        with self.daemon("--local-socket", os.path.join(folder, "local")) as address:
            os.chown(folder, nobody.pw_uid, -1)
            server = ["--server", address, "--backend", "cpu", "--json"]
            commands = (["detect", "--frames", self.frame0, self.frame1], ["stream", "--scene", "funnel", "--scale=0.2", "--frames=1"])
            for words in commands:
                told = json.loads(self.ok(*words, *server))
                self.assertEqual(told["transport"], "grpc")
                self.assertIn(f"belongs to user {nobody.pw_uid}", told["local_refusal"])
                for user in (nobody.pw_name, str(nobody.pw_uid)):
                    told = json.loads(self.ok(*words, *server, "--daemon-user", user))
                    self.assertEqual((told["transport"], told.get("local_refusal")), ("shared memory", None))

    def test_frames_go_to_the_endpoint_that_the_daemon_tells(self):
        with self.daemon("--endpoint", "unix:/nonexistent/socket") as address:
            words = ["stream", "--scene", "funnel", "--scale", "0.2", "--frames", "1", "--server", address]
            self.refused(1, "/nonexistent/socket", *words, "--backend", "cpu")

    def test_an_interrupt_deletes_the_scene_on_a_running_daemon(self):
        with self.daemon("--max-scenes", "1") as address:
            server = ["--server", address, "--backend", "cpu"]
            for number in (signal.SIGINT, signal.SIGTERM):
                words = [COLLIDECTL, "stream", "--scene", "funnel", "--scale", "0.2", "--frames", "1000000", *server]
                with subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as process:
                    self.assertIn("frames:", process.stderr.readline())
                    process.send_signal(number)
                    self.assertIn(f"collidectl: interrupted by signal {number.value}\n", process.stderr.read())
                self.assertEqual(process.returncode, 128 + number)
                self.ok("detect", "--frames", self.frame0, self.frame1, *server)  # there is room for its scene

    def test_an_interrupted_detect_leaves_no_scene_on_a_running_daemon(self):
        out = os.path.join(self.folder.name, "frames")
        self.ok("export", "--scene", "funnel", "--frames", "2", "--t0", "0.9", "--out", out)
        frames = [os.path.join(out, f"funnel_000{i}.ply") for i in (0, 1)]
        with self.daemon("--max-scenes", "1") as address:
            server = ["--server", address, "--backend", "cpu"]
            for milliseconds in range(0, 200, 10):
                words = [COLLIDECTL, "detect", "--frames", *frames, *server]
                with subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
                    time.sleep(milliseconds / 1000)
                    process.terminate()
                self.assertIn(process.returncode, (-signal.SIGTERM, 128 + signal.SIGTERM, 0))
                self.ok("detect", "--frames", self.frame0, self.frame1, *server)

    def test_settings_of_other_daemons_do_not_reach_its_own(self):
        config = self.put("config.toml", "no-such-option = 1\n")
        others = {"COLLIDED_LOG_FORMAT": "json", "COLLIDED_TOKENS_FILE": "/nonexistent", "COLLIDED_CONFIG": config,
                  "COLLIDED_MAX_SCENES": "abc"}
        with socket.create_server(("127.0.0.1", 0)) as taken:
            others["COLLIDED_HTTP_ADDRESS"] = f"127.0.0.1:{taken.getsockname()[1]}"
            self.ok("detect", "--frames", self.frame0, self.frame1, *ONE_CPU, **others)
        words = ["load", "--scene", "reef_knot", "--scale", "0.1", "--rate", "20", "--seconds", "0.2", "--json", *ONE_CPU]
        self.assertTrue(json.loads(self.ok(*words, **others))["comparison"])  # with the metrics that its log names

    def test_a_folder_whose_name_no_address_can_have_is_not_used(self):
        for name in ("50%25", "a,b", "a b", "a#b"):
            folder = os.path.join(self.folder.name, name)
            os.mkdir(folder)
            self.ok("info", TMPDIR=folder)

    def test_nothing_is_left_behind(self):
        with tempfile.TemporaryDirectory() as folder:
            self.ok("info", TMPDIR=folder)
            far = ["--mode", "dcd", "--position-format", "f32", "--thickness", "1e39"]
            self.refused(1, "thickness", "detect", "--frames", self.frame0, *far, *ONE_CPU, TMPDIR=folder)
            self.assertEqual(os.listdir(folder), [])

    def test_an_interrupt_stops_the_daemon_and_removes_its_folder(self):
        with tempfile.TemporaryDirectory() as folder:
            words = [COLLIDECTL, "stream", "--scene", "funnel", "--frames", "100000", *ONE_CPU]
            env = {**os.environ, "COLLIDED_DAEMON": DAEMON, "TMPDIR": folder}
            with subprocess.Popen(words, env=env, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
                while process.poll() is None and not glob.glob(folder + "/*/socket"):
                    time.sleep(0.01)
                with open(f"/proc/{process.pid}/task/{process.pid}/children", encoding="ascii") as file:
                    daemon = int(file.read().split()[0])
                time.sleep(0.3)
                process.terminate()
            self.assertEqual(process.returncode, 128 + 15)
            self.assertEqual(os.listdir(folder), [])
            deadline = time.monotonic() + 60
            while self.is_running(daemon) and time.monotonic() < deadline:
                time.sleep(0.05)
            self.assertFalse(self.is_running(daemon))

    def is_running(self, pid):
        try:
            with open(f"/proc/{pid}/stat", encoding="ascii") as file:
                return file.read().rsplit(")", 1)[1].split()[0] != "Z"
        except FileNotFoundError:
            return False


if __name__ == "__main__":
    support.main()
