#!/usr/bin/env python3
"""The tests that deploy/SECURITY.md names exist, and each threat has one.

usage: security_test.py REPOSITORY
"""

import pathlib
import re
import sys
import unittest

from markdown import Page

REPOSITORY = pathlib.Path(sys.argv[1]).resolve()
PAGE = Page(REPOSITORY / "deploy" / "SECURITY.md")


def mistakes(cell):
    """What is wrong with a list of files and their tests: `FILE`: `TEST`, `TEST`; `FILE`: `TEST`."""
    found = []
    for part in cell.split(";"):
        file, *tests = re.findall(r"`([^`]+)`", part) or [""]
        path = REPOSITORY / file
        if not file.startswith("tests/") or not path.is_file():
            found.append(f"no such file: {file}")
            continue
        if not tests:
            found.append(f"no test of {file}")
        text = path.read_text()
        for test in tests:
            if not re.search(rf"^\s*(?:def {re.escape(test)}\(|TEST(?:_F|_P)?\(\w+,\s*{re.escape(test)}\))", text, re.MULTILINE):
                found.append(f"{file} has no {test}")
    return found


class Security(unittest.TestCase):
    def test_every_threat_is_met_and_shown_by_tests_that_exist(self):
        header, *rows = PAGE.table(after="## Threats")
        self.assertEqual(header, ["threat", "met with", "shown by"])
        self.assertGreater(len(rows), 15)
        for threat, met, shown in rows:
            self.assertTrue(met, threat)
            self.assertEqual(mistakes(shown), [], threat)

    def test_what_meets_a_vulnerability_of_grpc_is_shown(self):
        header, *rows = PAGE.table(after="## Known vulnerabilities of gRPC")
        self.assertEqual(header[-1], "shown by")
        for name, _, _, behind, shown in rows:
            self.assertRegex(name, r"^CVE-\d{4}-\d+$")
            if behind != "yes":
                self.assertEqual(mistakes(shown), [], name)

    def test_every_file_named_exists(self):
        for path in re.findall(r"`((?:tests|deploy|server|client)/[\w./-]+)`", PAGE.text):
            self.assertTrue((REPOSITORY / path).exists(), path)

    def test_names_that_are_not_there_are_found(self):
        here = "tests/docs/security_test.py"
        self.assertEqual(mistakes(f"`{here}`: `test_names_that_are_not_there_are_found`"), [])
        self.assertEqual(mistakes(f"`{here}`: `test_nothing`"), [f"{here} has no test_nothing"])
        self.assertEqual(mistakes("`tests/nowhere.py`: `test_nothing`"), ["no such file: tests/nowhere.py"])
        self.assertEqual(mistakes(f"`{here}`"), [f"no test of {here}"])
        self.assertEqual(mistakes("by nothing"), ["no such file: "])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
