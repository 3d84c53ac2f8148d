#!/usr/bin/env python3
"""The C++ program of client/STEPPING.md.

usage: stepping_example.py REPOSITORY OUTPUT
"""

import pathlib
import sys

from markdown import Page

repository, output = map(pathlib.Path, sys.argv[1:])
(program,) = Page(repository / "client" / "STEPPING.md").blocks("cpp")
output.write_text(program)
