#!/usr/bin/env python3
"""What the daemon says of GPUs on a machine without any: nothing that would alarm, and the reason to who asks for one.

usage: unusable_devices_test.py DAEMON COLLIDECTL BUILD    (BUILD: cuda or cpu)
"""

import contextlib
import ctypes.util
import glob
import json
import os
import subprocess
import sys
import tempfile
import time
import unittest

DAEMON, COLLIDECTL, BUILD = sys.argv[1:4]
SECONDS = 60
REASON = "this machine has no NVIDIA driver" if BUILD == "cuda" else "this build has no CUDA"


def run(*command):
    done = subprocess.run(command, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=SECONDS, check=False)
    return done.returncode, done.stdout


class Unusable(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = lambda name: os.path.join(folder.name, name)

    @contextlib.contextmanager
    def daemon(self, *options):
        """Its address, and its log once it serves."""
        command = [DAEMON, "--address", f"unix:{self.path('socket')}", "--ready-file", self.path("ready"), *options]
        with open(self.path("log"), "w", encoding="utf-8") as log, subprocess.Popen(command, stdout=log, stderr=log) as process:
            try:
                deadline = time.monotonic() + SECONDS
                while not os.path.exists(self.path("ready")):
                    self.assertIsNone(process.poll())
                    self.assertLess(time.monotonic(), deadline)
                    time.sleep(0.01)
                with open(self.path("log"), encoding="utf-8") as said:
                    yield f"unix:{self.path('socket')}", said.read()
            finally:
                process.terminate()

    def info(self, address):
        return json.loads(subprocess.run([COLLIDECTL, "info", "--json", "--server", address], check=True, capture_output=True,
                                         timeout=SECONDS).stdout)

    def test_a_machine_without_a_gpu_is_not_nagged(self):
        with self.daemon("--log-level", "info") as (address, log):
            self.assertNotRegex(log, r"Z (warn|err|crit)")
            self.assertEqual(log.count(REASON), 1 if BUILD == "cuda" else 0, log)
            told = {"cuda": {"name": "", "reason": REASON}} if BUILD == "cuda" else {}
            info = self.info(address)
            self.assertEqual(info["unusable_devices"], told)
            self.assertEqual(list(info["devices"]), ["cpu:0"])
            code, text = run(COLLIDECTL, "info", "--server", address)
            self.assertEqual((code, REASON in text), (0, BUILD == "cuda"), text)

    def test_devices_that_are_named_leave_the_others_alone(self):
        with self.daemon("--device", "cpu:0") as (address, log):
            self.assertNotIn(REASON, log)
            self.assertEqual(self.info(address)["unusable_devices"], {})

    def test_who_insists_on_cuda_is_told_why_not(self):
        for options, code, begin in ((("--backend", "cuda"), 1, "--backend is cuda, but there is no usable CUDA device: "),
                                     (("--device", "cuda:0"), 2, "--device is cuda:0, which cannot be used: ")):
            with self.subTest(options=options):
                done, said = run(DAEMON, "--address", f"unix:{self.path('socket')}", *options)
                self.assertEqual(done, code, said)
                self.assertIn(begin + REASON, said)

    def test_a_scene_on_cuda_is_told_why_not(self):
        with self.daemon() as (address, _):
            code, said = run(COLLIDECTL, "stream", "--scene", "funnel", "--scale", "0.2", "--frames", "1", "--backend", "cuda",
                             "--server", address)
            self.assertNotEqual(code, 0)
            self.assertIn(f"this daemon has no usable CUDA device: {REASON}", said)


if __name__ == "__main__":
    if BUILD == "cuda" and (glob.glob("/dev/nvidia*") or ctypes.util.find_library("cuda")):
        print("skipped: this machine has an NVIDIA driver")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1], verbosity=2)
