#!/usr/bin/env python3
"""The checker finds one bad import at a time in a temporary tree."""

import pathlib
import tempfile
import unittest

import check_python

GOOD = {
    "session.py": "import numpy\nfrom collided.transport.base import Transport\n",
    "errors.py": "import grpc\n",
    "contacts/tables.py": "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from collided.session import Session\n",
    "frames/wire.py": "from collided.frames.updates import Update\nfrom collided.v1 import frame_pb2\nimport collections.abc\n",
}
BAD = [
    ("meshes/bad.py", "from collided.layout import Layout"),
    ("frames/bad.py", "import grpc"),
    ("contacts/bad.py", "def late():\n    from collided.session import Session"),
    ("connection/bad.py", "import collided"),
    ("transport/bad.py", "from . import base"),
    ("bad.py", "import pandas"),
    ("gpu/bad.py", "import cupy"),
]


class Checker(unittest.TestCase):
    def check(self, files):
        with tempfile.TemporaryDirectory() as root:
            for name, text in files.items():
                path = pathlib.Path(root, check_python.PACKAGE, name)
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(text)
            return check_python.bad_imports(root)

    def test_good_imports_are_not_complained_about(self):
        self.assertEqual(self.check(GOOD), ([], len(GOOD)))

    def test_each_bad_import_is(self):
        for name, line in BAD:
            with self.subTest(name):
                found, _ = self.check({**GOOD, name: line + "\n"})
                self.assertEqual(len(found), 1, found)
                self.assertIn(name, found[0])


if __name__ == "__main__":
    unittest.main()
