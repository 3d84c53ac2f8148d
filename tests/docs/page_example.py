#!/usr/bin/env python3
"""The C++ program of a page of client/ that has one.

usage: page_example.py PAGE REPOSITORY OUTPUT
"""

import pathlib
import sys

from markdown import Page

page, repository, output = sys.argv[1], *map(pathlib.Path, sys.argv[2:])
(program,) = Page(repository / "client" / page).blocks("cpp")
output.write_text(program)
