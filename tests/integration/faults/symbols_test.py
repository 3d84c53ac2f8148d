#!/usr/bin/env python3
"""Whether all that the daemon's libraries call outside themselves is a failpoint, or explained, in failpoints.txt.

usage: symbols_test.py NM FAILPOINTS PROGRAM LIBRARY...
"""

import pathlib
import re
import subprocess
import sys

ALWAYS = re.compile(r"^_?_?cuda|^_Zn[wa]m|^_ZNSt6thread15_M_start")


def undefined(nm, file):
    lines = subprocess.run([nm, "-u", file], capture_output=True, text=True, check=True).stdout.splitlines()
    return {fields[1].split("@")[0] for fields in map(str.split, lines) if len(fields) == 2}


def libc_symbols(nm, program):
    """What the C library that the program is linked with exports."""
    loaded = subprocess.run(["ldd", program], capture_output=True, text=True, check=True).stdout
    libc = re.search(r"\S*/libc\.so\.6", loaded).group()
    lines = subprocess.run([nm, "-D", "--defined-only", libc], capture_output=True, text=True, check=True).stdout
    return {line.split()[-1].split("@")[0] for line in lines.splitlines()}


def main():
    nm, failpoints, program, *libraries = sys.argv[1:]
    known = {line.split()[0] for line in pathlib.Path(failpoints).read_text().splitlines()
             if line and not line.startswith("#")}
    libc = libc_symbols(nm, program)
    used = set().union(*(undefined(nm, library) for library in libraries))
    used = {symbol for symbol in used if symbol in libc or ALWAYS.match(symbol)}
    missing = sorted(used - known)
    wrapped = sorted(s for s in undefined(nm, program) if "__wrap_" in s or "collided_failpoint" in s)
    symbols = subprocess.run([nm, program], capture_output=True, text=True, check=True).stdout
    print(f"{len(used)} symbols used, {len(missing)} neither a failpoint nor explained: {' '.join(missing)}")
    if wrapped or "__wrap_" in symbols or "collided_failpoint" in symbols:
        print(f"{program} has failpoints, which only collided_faulty may have")
        return 1
    return 1 if missing or len(used) < 50 else 0


if __name__ == "__main__":
    sys.exit(main())
