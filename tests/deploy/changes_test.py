#!/usr/bin/env python3
"""Changes of the working tree are lines that a reader takes in at once, and deploy/changes/assemble moves them into CHANGELOG.md.

usage: changes_test.py REPOSITORY
"""

import pathlib
import subprocess
import sys
import tempfile
import unittest

REPOSITORY = pathlib.Path(sys.argv[1]).resolve()
ASSEMBLE = REPOSITORY / "deploy/changes/assemble"
BEFORE = "# Changelog\n\n## 0.2.0 (unreleased)\n\n### Faster\n\n- Old.\n\n## 0.1.0 (2026-01-01)\n\nThe first.\n"


def assemble(root, *words):
    """The exit code, and what was said."""
    done = subprocess.run([sys.executable, ASSEMBLE, *words, "--root", root], text=True, capture_output=True, check=False, timeout=30)
    return done.returncode, done.stderr.strip()


class Repository(unittest.TestCase):
    def test_its_changes_are_fit(self):
        self.assertEqual(assemble(REPOSITORY, "--check"), (0, ""))

    def test_its_newest_section_is_short(self):
        newest = (REPOSITORY / "CHANGELOG.md").read_text(encoding="utf-8").split("\n## ")[1]
        self.assertLess(len(newest.split()), 1000)  # four minutes
        for line in newest.splitlines():
            self.assertLessEqual(len(line), 182, line)  # "- " and what a change may have


class Assembled(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        self.changes = self.root / "deploy/changes"
        self.changes.mkdir(parents=True)
        (self.root / "CHANGELOG.md").write_text(BEFORE)

    def add(self, name, text):
        (self.changes / name).write_text(text)

    def changelog(self):
        return (self.root / "CHANGELOG.md").read_text()

    def test_lines_end_up_in_their_sections_and_their_files_go(self):
        self.add("faster-b.md", "Frames take less.\n")
        self.add("breaking-a.md", "`--x` is gone.\n")
        self.assertEqual(assemble(self.root, "0.2.0", "2026-12-01"), (0, ""))
        self.assertEqual(self.changelog(), BEFORE.replace("unreleased", "2026-12-01").replace(
            "### Faster\n\n- Old.\n", "### Breaking\n\n- `--x` is gone.\n\n### Faster\n\n- Old.\n- Frames take less.\n"))
        self.assertEqual(list(self.changes.iterdir()), [])

    def test_a_new_version_comes_first(self):
        self.add("safer-a.md", "Safe.\n")
        self.assertEqual(assemble(self.root, "0.2.01"), (0, ""))
        self.assertEqual(self.changelog(), BEFORE.replace("## 0.2.0 ", "## 0.2.01 (unreleased)\n\n### Safer\n\n- Safe.\n\n## 0.2.0 "))

    def test_nothing_of_the_section_is_lost(self):
        with_more = BEFORE.replace("- Old.\n", "- Old.\n\nA paragraph.\n")
        (self.root / "CHANGELOG.md").write_text(with_more)
        self.add("faster-b.md", "Frames take less.\n")
        code, said = assemble(self.root, "0.2.0")
        self.assertEqual((code, self.changelog()), (1, with_more))
        self.assertIn("0.2.0 has something besides changes", said)

    def test_what_is_no_change_is_named(self):
        for name, text, part in (("other-a.md", "A.\n", "the name is not"), ("faster.md", "A.\n", "the name is not"),
                                 ("faster-a.md", "- A.\n", "not one line"), ("faster-a.md", "A.\nB.\n", "not one line"),
                                 ("faster-a.md", "a\n", "not one line"), ("faster-a.md", 180 * "A" + ".\n", "181 characters; the limit is 180")):
            self.add(name, text)
            for words in (["--check"], ["0.2.0"]):
                code, said = assemble(self.root, *words)
                self.assertEqual(code, 1)
                self.assertTrue(said.startswith(f"deploy/changes/{name}: ") and part in said, said)
            self.assertEqual(self.changelog(), BEFORE)
            (self.changes / name).unlink()


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
