#!/usr/bin/env python3
"""--version tells what was built.

usage: version_test.py REPOSITORY VERSION BUILD_TYPE CUDA PROGRAM...    (CUDA: the toolkit's version, or OFF)
"""

import pathlib
import re
import subprocess
import sys
import unittest

REPOSITORY, VERSION, BUILD_TYPE, CUDA = sys.argv[1:5]
PROGRAMS = sys.argv[5:]


def is_commit(name):
    """Of this repository; outside of one there is none to know."""
    command = ["git", "cat-file", "-e", f"{name}^{{commit}}"]
    return not subprocess.run(command, cwd=REPOSITORY, capture_output=True, check=False).returncode


class Version(unittest.TestCase):
    def test_both_programs_tell_version_commit_build_cuda_and_grpc(self):
        self.assertTrue(PROGRAMS)
        for program in PROGRAMS:
            done = subprocess.run([program, "--version"], text=True, capture_output=True, timeout=60, check=False)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            first, *facts = done.stdout.splitlines()
            self.assertEqual(first, f"{pathlib.Path(program).name} {VERSION}")
            told = re.fullmatch(r"commit: (\w+)( \(modified\))?", facts[0])
            self.assertTrue(told, facts[0])
            self.assertTrue(is_commit(told[1]) if is_commit("HEAD") else told[1] == "unknown", told[1])
            self.assertRegex(facts[1], rf"^build:  {BUILD_TYPE}, \w+ \d+\.\d+\.\d+$")
            expected = r"none, CPU cores only" if CUDA == "OFF" else rf"{re.escape(CUDA)}, architectures \d\d+.*"
            self.assertRegex(facts[2], rf"^CUDA:   {expected}$")
            self.assertRegex(facts[3], r"^gRPC:   1\.\d+\.\d+$")
            self.assertEqual(len(facts), 4)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
