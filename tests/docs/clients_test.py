#!/usr/bin/env python3
"""What client/README.md shows of each language is part of a program that other tests run.

usage: clients_test.py REPOSITORY
"""

import pathlib
import re
import sys
import unittest

REPOSITORY = pathlib.Path(sys.argv[1])
sys.path.insert(0, str(pathlib.Path(__file__).parent))
from markdown import Page  # noqa: E402

PAGE = Page(REPOSITORY / "client" / "README.md")
# tests/client runs these; tests/docs/python_test.py runs the Python.
SHOWN_FROM = {"cpp": "cpp/examples/first_contact/main.cpp", "js": "node/README.md", "go": "go/README.md"}


class Clients(unittest.TestCase):
    def test_five_lines_of_each_language_are_those_of_its_program(self):
        for language, file in SHOWN_FROM.items():
            (block,) = PAGE.blocks(language)
            program = [line.strip() for line in (REPOSITORY / "client" / file).read_text().splitlines()]
            places = [program.index(line.strip()) for line in block.splitlines()]
            self.assertEqual(places, sorted(places), file)
            self.assertEqual(len(places), 5, file)

    def test_files_that_command_lines_name_exist(self):
        found = 0
        for block in PAGE.blocks(""):
            for path in re.findall(r"(?<![\w~./-])(?:collided\.invalid/)?((?:client|deploy)/[\w/.-]+)", block):
                self.assertTrue((REPOSITORY / path).exists(), path)
                found += 1
        self.assertGreater(found, 5)

    def test_the_presets_exist(self):
        presets = (REPOSITORY / "CMakePresets.json").read_text()
        for preset in re.findall(r"--preset (\S+)", PAGE.text):
            self.assertIn(f'"name": "{preset}"', presets)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
