#!/usr/bin/env python3
"""A C++ program of a page of client/.

usage: page_example.py PAGE REPOSITORY OUTPUT NUMBER OF_HOW_MANY
"""

import pathlib
import sys

from markdown import Page

page, repository, output = sys.argv[1], *map(pathlib.Path, sys.argv[2:4])
number, count = map(int, sys.argv[4:])
programs = Page(repository / "client" / page).blocks("cpp")
assert len(programs) == count, f"{page} has {len(programs)} programs, not {count}"
output.write_text(programs[number - 1])
