"""The keys of collidectl's JSON: those of client/JSON.md in every command, with their types and units.

Usage: json_test.py COLLIDECTL DAEMON"""

import json
import os
import re
import signal
import subprocess
import time

import json_keys
import support
from support import COLLIDECTL, DAEMON, ONE_CPU

SMALL = ["--scene", "reef_knot", "--scale", "0.1"]
IN_PARTS = ["--part-devices", "cpu:0,cpu:0"]
COMMANDS = {
    "scenes": [],
    "info": ONE_CPU,
    "estimate": [*SMALL, "--rate", "30", "--network", "1", "--measure", "--steps", "2", *ONE_CPU],
    "bench": [*SMALL, "--steps", "2", "--warm-up", "0", *ONE_CPU],
    "load": [*SMALL, "--rate", "20", "--seconds", "0.5", *ONE_CPU],
}


class JsonKeys(json_keys.KeyChecks, support.CollidectlTest):
    rare = {"local_refusal", "vtp", "ply", "failure"}  # only some machines or failures show them

    def read(self, command, *words):
        value = json.loads(self.ok(command, *words, "--json"))
        self.check(value, command)
        return value

    def test_keys_of_every_command_are_documented(self):
        help = self.ok("--help")
        commands = re.findall(r"^  (\w+) ", help[help.index("Subcommands"):], re.M)
        others = {"batch", "detect", "merge", "stream", "replay", "render", "watch", "tradeoff"}  # below
        for command in commands:
            if "--json" in self.ok(command, "--help"):
                self.assertIn(command, others | set(COMMANDS), "a test of its JSON is missing")
        for command, words in COMMANDS.items():
            value = self.read(command, *words)
            if command == "info" and not value["unusable_devices"]:
                type(self).rare = self.rare | {"reason"}
        self.read("bench", *SMALL, "--steps", "2", "--warm-up", "0", *ONE_CPU, *IN_PARTS)

    def test_keys_of_frames(self):
        frames = [self.frame0, self.frame1]
        recording, picture = (os.path.join(self.folder.name, name) for name in ("r.rec", "p.png"))
        self.read("detect", "--frames", *frames, *ONE_CPU, "--advance", "--out", os.path.join(self.folder.name, "c.csv"))
        self.read("detect", "--frames", *frames, *ONE_CPU, "--report", "any")
        self.read("detect", "--frames", *frames, *ONE_CPU, *IN_PARTS)
        self.read("stream", *SMALL, "--frames", "1", "--mode", "dcd", "--half-thickness", "ribbon_a=0.01", *ONE_CPU)
        self.read("detect", *frames, self.put("repeated.obj", support.FRAME0 + "f 1 1 2\n"), *ONE_CPU)
        self.read("detect", self.put("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"), *ONE_CPU)
        self.read("detect", *frames, "--thickness", "1", "--kept", *ONE_CPU)
        shell, core = (self.put(name, support.cube(*where)) for name, where in (("shell.obj", (0, 9)), ("core.obj", (1, 1, 1))))
        self.read("detect", "--solid", shell, core, *ONE_CPU)
        results = os.path.join(self.folder.name, "results")
        self.read("batch", self.put("pairs.csv", "a.obj,b.obj\n"), *ONE_CPU, "--out", results)
        self.read("merge", results, "--out", os.path.join(self.folder.name, "pairs"))
        self.read("stream", *frames, *ONE_CPU, "--record", recording)
        self.read("stream", *SMALL, "--frames", "2", "--advance", *ONE_CPU)
        self.read("detect", "--frames", *frames, *ONE_CPU, "--advance", "--advance-mode", "per-vertex", "--limits")
        self.read("stream", *SMALL, "--frames", "2", "--advance", "--advance-mode", "per-mesh", *ONE_CPU)
        self.read("replay", recording, *ONE_CPU)
        self.read("render", "--frames", *frames, *ONE_CPU, "--crossings", "--width", "16", "--height", "16", "--out", picture)

    def test_keys_of_a_watch(self):
        socket, log, ready = (os.path.join(self.folder.name, name) for name in ("socket", "log", "up"))
        words = [DAEMON, "--address", "unix:" + socket, *ONE_CPU, "--ready-file", ready]
        with open(log, "w", encoding="utf-8") as file, subprocess.Popen(words, stderr=file, stdout=file) as daemon:
            try:
                while daemon.poll() is None and not os.path.exists(ready):
                    time.sleep(0.01)
                self.watch("unix:" + socket, log)
            finally:
                daemon.terminate()

    def watch(self, server, log):
        words = [COLLIDECTL, "stream", *SMALL, "--frames", "1000000", "--server", server]
        with subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as stream:
            try:
                scene = None
                while scene is None and stream.poll() is None:
                    with open(log, encoding="utf-8") as file:
                        scene = re.search(r"scene created.*?\b([0-9a-f]{32})\b", file.read())
                    time.sleep(0.01)
                for line in self.ok("watch", "--json", "--server", server).splitlines():
                    self.check(json.loads(line), "watch")
                for line in self.ok("watch", scene[1], "--frames", "2", "--json", "--server", server).splitlines():
                    self.check(json.loads(line), "watch")
            finally:
                stream.send_signal(signal.SIGINT)

    def test_keys_of_measurements(self):
        out = os.path.join(self.folder.name, "tradeoff")
        self.read("tradeoff", "--scene", "flamenco", "--scale", "0.1", "--t0", "0.5", "--repeats", "1", "--deltas", "0",
                  *ONE_CPU, "--out", out)
        self.read("load", *SMALL, "--find-max", "--p99", "100ms", "--trial-seconds", "0.1", *ONE_CPU)

    def test_refusals_of_a_load_have_keys_too(self):
        with self.daemon("--max-frames-per-second", "10") as server:
            value = self.read("load", *SMALL, "--rate", "60", "--seconds", "0.7", "--server", server)
        self.assertTrue(value["refused"])

    @classmethod
    def tearDownClass(cls):
        """The page lists nothing that no command prints, but for what is rare."""
        end_to_end = {"bare_ms", "transports", "engine_ms", "overhead_ms", "overhead_to_bare_tcp", "overhead_to_held_tcp",
                      "decode_ms", "encode_ms"}  # which takes long: end_to_end_test.py reads them
        left = set(cls.KEYS) - cls.seen - cls.rare - end_to_end
        if left:
            raise AssertionError(f"no command printed {sorted(left)}")


if __name__ == "__main__":
    support.main()
