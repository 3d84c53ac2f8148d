#!/usr/bin/env python3
"""The shared library shows the functions of collided.h alone, and needs none of the daemon's libraries.

usage: exports_test.py LIBRARY HEADER C_COMPILER
"""

import pathlib
import re
import subprocess
import sys
import unittest

LIBRARY, HEADER, COMPILER = sys.argv[1:4]
NEVER = re.compile("grpc|proto|ssl|crypto|absl|spdlog|fmt|boost|prometheus|cares|re2")


def lines(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True, timeout=60).stdout.splitlines()


class Exports(unittest.TestCase):
    def test_symbols_are_the_functions_of_the_header(self):
        shown = {line.split()[-1].partition("@")[0] for line in lines("nm", "-D", "--defined-only", LIBRARY)}
        declared = set(re.findall(r"COLLIDED_API [^;]*?\b(collided_\w+)\(", pathlib.Path(HEADER).read_text()))
        self.assertEqual(shown - {"COLLIDED_1"}, declared)
        self.assertGreater(len(declared), 10)

    def test_libraries(self):
        needed = [line for line in lines("readelf", "-d", LIBRARY) if "NEEDED" in line]
        self.assertTrue(needed)
        self.assertFalse([line for line in needed + lines("ldd", LIBRARY) if NEVER.search(line.split("(")[0].split("=>")[0])])

    def test_soname_is_the_version_of_the_interface(self):
        version = re.search(r"COLLIDED_ABI_VERSION (\d+)", pathlib.Path(HEADER).read_text())[1]
        self.assertIn(f"[libcollided.so.{version}]", "".join(lines("readelf", "-d", LIBRARY)))

    def test_header_is_plain_c(self):
        for standard in ("c99", "c11"):
            lines(COMPILER, f"-std={standard}", "-pedantic", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", HEADER)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
