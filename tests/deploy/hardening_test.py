#!/usr/bin/env python3
"""What linker and compiler add against mistakes is in the programs that are installed, as deploy/SECURITY.md says.

usage: hardening_test.py CXX PROGRAM...
"""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

CXX = sys.argv[1]
PROGRAMS = sys.argv[2:]
HARDENED = ("-O1", "-pie", "-fPIE", "-Wl,-z,relro,-z,now,-z,noexecstack", "-fstack-protector-strong",
            "-U_FORTIFY_SOURCE", "-D_FORTIFY_SOURCE=2")
# What each takes away, and what is then missing.
WEAKER = {"position-independent": ("-no-pie", "-fno-pie"), "read-only relocations": ("-Wl,-z,norelro",), "bound at start": ("-Wl,-z,lazy",),
          "stack not executable": ("-Wl,-z,execstack",), "no search path": ("-Wl,-rpath,/tmp/libraries",),
          "stack protector": ("-fno-stack-protector",), "bounds of copies": ("-U_FORTIFY_SOURCE",)}
# Copies from outside into an array on the stack, of a size that only run time knows.
COPIES = """#include <cstdlib>
#include <cstring>
int main(int count, char** words) {
  char word[8];
  memcpy(word, words[0], static_cast<size_t>(count));
  return atoi(word);
}"""


def missing(program):
    """Names of the properties that an ELF program does not have."""
    read = subprocess.run(["readelf", "-hldW", "--dyn-syms", program], capture_output=True, text=True, check=True).stdout
    stack = re.search(r"^\s*GNU_STACK\s.*?\s([RWE ]+)\s+0x\w+$", read, re.MULTILINE)
    segments = re.findall(r"^\s*LOAD\s+(?:0x\w+\s+){5}([RWE ]+?)\s+0x", read, re.MULTILINE)
    found = {"position-independent": re.search(r"Type:\s+DYN", read) and re.search(r"Flags:.*\bPIE\b", read),
             "read-only relocations": re.search(r"^\s*GNU_RELRO\s", read, re.MULTILINE),
             "bound at start": re.search(r"\bBIND_NOW\b|Flags:.*\bNOW\b", read),
             "stack not executable": stack and "E" not in stack[1],
             "nothing both written and executed": segments and not any("W" in s and "E" in s for s in segments),
             "stack protector": re.search(r"\bUND __stack_chk_fail\b", read),
             "bounds of copies": re.search(r"\bUND __(mem|str|v?s?n?printf)\w*_chk\b", read),
             "no search path": not re.search(r"\((RPATH|RUNPATH)\)", read)}
    return [name for name, has in found.items() if not has]


class Programs(unittest.TestCase):
    def test_the_installed_ones_have_all(self):
        self.assertTrue(PROGRAMS)
        for program in PROGRAMS:
            self.assertEqual(missing(program), [], program)


class Checker(unittest.TestCase):
    def build(self, *options, text=""):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        source, program = pathlib.Path(folder.name, "a.cpp"), pathlib.Path(folder.name, "a")
        source.write_text(f"{COPIES}\n{text}\n")
        subprocess.run([CXX, source, "-o", program, *HARDENED, *options], check=True, capture_output=True)
        return program

    def test_misses_nothing_in_a_hardened_program(self):
        self.assertEqual(missing(self.build()), [])

    def test_names_each_property_that_is_taken_away(self):
        for name, options in WEAKER.items():
            self.assertEqual(missing(self.build(*options)), [name])

    def test_names_memory_that_is_both_written_and_executed(self):
        section = r'asm(".section .both,\"awx\",@progbits\n.byte 0\n.text");'
        self.assertEqual(missing(self.build(text=section)), ["nothing both written and executed"])


if __name__ == "__main__":
    if not shutil.which("readelf"):
        print("skipped: readelf is not installed (Debian: binutils)")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1], verbosity=2)
