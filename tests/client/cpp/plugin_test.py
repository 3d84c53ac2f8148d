#!/usr/bin/env python3
"""The static client library is a part of a plug-in, which a program loads that knows nothing of it.

usage: plugin_test.py PLUGIN DAEMON REPOSITORY
"""

import ctypes
import pathlib
import re
import subprocess
import sys
import unittest

PLUGIN, DAEMON, REPOSITORY = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3])
sys.path.insert(0, str(REPOSITORY / "tests" / "interop"))
from daemon import Daemon  # noqa: E402


class Plugin(unittest.TestCase):
    def call(self, address):
        error = ctypes.create_string_buffer(1000)
        return ctypes.CDLL(PLUGIN).plugin_vertices(address.encode(), error, ctypes.c_size_t(1000)), error.value.decode()

    def test_it_works_in_a_program_that_does_not_know_it(self):
        daemon = Daemon(DAEMON)
        self.addCleanup(daemon.kill)
        self.assertEqual(self.call(daemon.address), (3, ""))

    def test_errors_stay_inside(self):
        self.assertEqual(self.call("nonsense")[0], -1)
        self.assertIn("address", self.call("nonsense")[1])

    def test_it_shows_its_own_function_and_nothing_of_ours(self):
        shown = subprocess.run(["nm", "-DC", "--defined-only", PLUGIN], check=True, capture_output=True, text=True,
                               timeout=60).stdout.splitlines()
        names = [line.split(maxsplit=2)[2] for line in shown]
        ours = re.compile(r"((vtable|typeinfo|typeinfo name|guard variable) for )?(collided|plugin_)")
        self.assertEqual([name for name in names if ours.match(name)], ["plugin_vertices"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
