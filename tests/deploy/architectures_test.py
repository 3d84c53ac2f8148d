#!/usr/bin/env python3
"""Which architectures COLLIDED_CUDA_ARCHITECTURES stands for, and what it refuses. Needs no nvcc.

usage: architectures_test.py CMAKE REPOSITORY
"""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

CMAKE, REPOSITORY = sys.argv[1], pathlib.Path(sys.argv[2]).resolve()
SCRIPT = (f'include("{REPOSITORY}/deploy/cuda/architectures.cmake")\ncollided_set_cuda_architectures()\n'
          'message("[${CMAKE_CUDA_ARCHITECTURES}]")\n')


def chosen(*settings):
    """Exit code and output of a configuration on a machine without a GPU."""
    with tempfile.TemporaryDirectory() as folder:
        script = pathlib.Path(folder, "script.cmake")
        script.write_text(SCRIPT, encoding="utf-8")
        done = subprocess.run([CMAKE, *(f"-D{setting}" for setting in settings), "-P", script], text=True, timeout=60, check=False,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env={**os.environ, "PATH": folder})
    return done.returncode, " ".join(done.stdout.split())


class Architectures(unittest.TestCase):
    def test_a_release_is_for_turing_to_blackwell(self):
        self.assertEqual(chosen("COLLIDED_CUDA_ARCHITECTURES=release"), (0, "[75;80-real;90-real;100-real;120]"))

    def test_a_list_is_taken_as_it_is_and_before_cmakes(self):
        self.assertEqual(chosen("COLLIDED_CUDA_ARCHITECTURES=80-real;90a", "CMAKE_CUDA_ARCHITECTURES=75"), (0, "[80-real;90a]"))

    def test_without_it_cmakes_list_holds_or_90(self):
        self.assertEqual(chosen("COLLIDED_CUDA_ARCHITECTURES=", "CMAKE_CUDA_ARCHITECTURES=89"), (0, "[89]"))
        self.assertEqual(chosen("COLLIDED_CUDA_ARCHITECTURES="), (0, "[90]"))

    def test_native_needs_a_gpu(self):
        code, said = chosen("COLLIDED_CUDA_ARCHITECTURES=native")
        self.assertNotEqual(code, 0)
        self.assertIn("no GPU on this machine", said)

    def test_what_names_no_architecture_is_refused(self):
        for value in ("all", "native;90", "sm_90", "90b", "9.0"):
            code, said = chosen(f"COLLIDED_CUDA_ARCHITECTURES={value}")
            self.assertNotEqual(code, 0, value)
            self.assertIn(f"'{value}' is no list of CUDA architectures", said)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
