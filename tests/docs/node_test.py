#!/usr/bin/env python3
"""The Node example of proto/README.md against a real daemon, with gRPC's own client for Node.

usage: node_test.py DAEMON REPOSITORY

Skipped without Node or its packages: tests/run installs them (npm install --prefix build/tools).
"""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

DAEMON, REPOSITORY = sys.argv[1], pathlib.Path(sys.argv[2]).resolve()
MODULES = REPOSITORY / "build" / "tools" / "node_modules"
NODE = shutil.which("node")
if not NODE:
    print("skipped: Node is not installed")
    sys.exit(77)
if not all((MODULES / "@grpc" / name).is_dir() for name in ("grpc-js", "proto-loader")):
    print("skipped: @grpc/grpc-js is not installed (npm install --no-save --prefix build/tools "
          "@grpc/grpc-js @grpc/proto-loader)")
    sys.exit(77)

sys.path.insert(0, str(REPOSITORY / "tests" / "interop"))
from daemon import Daemon  # noqa: E402
from markdown import Page  # noqa: E402
from run_page import README_SOCKET  # noqa: E402


class Node(unittest.TestCase):
    def test_the_example_prints_what_the_page_says(self):
        daemon = Daemon(DAEMON)
        self.addCleanup(daemon.kill)
        page = Page(REPOSITORY / "proto" / "README.md")
        (program,) = page.blocks("js")
        self.assertIn(README_SOCKET, program)
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "proto").symlink_to(REPOSITORY / "proto")
            example = pathlib.Path(folder) / "example.js"
            example.write_text(program.replace(README_SOCKET, daemon.address))
            done = subprocess.run([NODE, example], cwd=folder, text=True, capture_output=True, timeout=60,
                                  env={**os.environ, "NODE_PATH": str(MODULES)})
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual(done.stdout, "CONTACT_KIND_VERTEX_TRIANGLE: 3 and 0, t = 0.500000000\n")
        self.assertIn(f"It prints `{done.stdout.strip()}`", page.text)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
