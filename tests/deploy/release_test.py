#!/usr/bin/env python3
"""deploy/release --check lets only a fit commit pass, and names what is wrong with others.

usage: release_test.py REPOSITORY
"""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

REPOSITORY = pathlib.Path(sys.argv[1]).resolve()
NEEDED = ("CMakeLists.txt", "CHANGELOG.md", "deploy/release", "deploy/packages", "proto", "tests/proto", "client/python/pyproject.toml",
          "client/python/collided/__init__.py", "client/node/package.json", "client/node/package-lock.json")
VERSION = re.search(r"project\(collided VERSION (\S+)", (REPOSITORY / "CMakeLists.txt").read_text())[1]
RELEASES = ", ".join(f"compatible with {image.stem}" for image in sorted((REPOSITORY / "proto/releases").glob("*.binpb")))
# With root's own tests/proto/find_buf; without buf, no commit is fit.
BUF = subprocess.run([REPOSITORY / "tests/proto/find_buf"], text=True, capture_output=True, check=False).stdout.strip()


class Release(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.copy = pathlib.Path(folder.name)
        for name in NEEDED:
            (self.copy / name).parent.mkdir(parents=True, exist_ok=True)
            if (REPOSITORY / name).is_dir():
                shutil.copytree(REPOSITORY / name, self.copy / name, ignore=shutil.ignore_patterns("__pycache__"))
            else:
                shutil.copy(REPOSITORY / name, self.copy / name)
        if BUF:
            found = self.copy / "node_modules/.bin/buf"
            found.parent.mkdir(parents=True)
            found.symlink_to(BUF)
            self.edit(".gitignore", "", "node_modules\n")
        changes = (self.copy / "CHANGELOG.md").read_text()
        (self.copy / "CHANGELOG.md").write_text(re.sub("^## .*$", f"## {VERSION} (2026-01-02)", changes, count=1, flags=re.MULTILINE))
        self.git("init", "-q")
        self.commit()

    def git(self, *words):
        subprocess.run(["git", "-c", "user.name=a", "-c", "user.email=a@b", *words], cwd=self.copy, check=True, capture_output=True)

    def commit(self):
        self.git("add", ".")
        self.git("commit", "-q", "--allow-empty", "-m", "a")

    def edit(self, name, old, new):
        file = self.copy / name
        text = file.read_text() if file.exists() else ""
        self.assertIn(old, text)
        file.write_text(text.replace(old, new, 1))

    def check(self):
        """Its exit code, and the problems that it names."""
        done = subprocess.run([self.copy / "deploy/release", "--check"], text=True, capture_output=True, check=False, timeout=120)
        problems = [line.removeprefix("release: ") for line in done.stderr.splitlines()]
        if not BUF:
            self.assertIn("buf is not installed", done.stderr)
            problems = [line for line in problems if "buf is not installed" not in line]
        return done.returncode, problems[:-1], done.stdout  # the last one counts them

    def refused(self, *parts):
        code, problems, _ = self.check()
        self.assertEqual((code, len(problems)), (1, len(parts)), problems)
        for part, problem in zip(parts, problems):
            self.assertIn(part, problem)

    @unittest.skipUnless(BUF, "buf is not installed")
    def test_a_fit_commit_passes_and_says_what_it_is_compatible_with(self):
        code, _, said = self.check()
        self.assertEqual(code, 0)
        self.assertEqual(said, f"release: protocol: {RELEASES}\nrelease: {VERSION} is ready\n")

    def test_a_version_that_differs_is_named_with_its_file(self):
        self.edit("client/python/pyproject.toml", f'"{VERSION}"', '"9.9.9"')
        self.edit("client/node/package.json", f'"{VERSION}"', '"9.9.8"')
        self.commit()
        self.refused("client/python/pyproject.toml says 9.9.9", "client/node/package.json says 9.9.8")

    def test_changes_need_a_section_of_the_version(self):
        self.edit("CHANGELOG.md", f"## {VERSION} (2026-01-02)", "## Unreleased")
        self.commit()
        self.refused('CHANGELOG.md begins with "## Unreleased"')
        self.edit("CHANGELOG.md", "## Unreleased", f"## {VERSION}1")
        self.commit()
        self.refused(f'CHANGELOG.md begins with "## {VERSION}1"')

    def test_changes_must_be_assembled(self):
        (self.copy / "deploy/changes").mkdir()
        (self.copy / "deploy/changes/faster-a.md").write_text("Faster.\n")
        self.commit()
        self.refused(f"deploy/changes has entries that CHANGELOG.md lacks: deploy/changes/assemble {VERSION}")

    def test_the_tree_must_be_clean(self):
        (self.copy / "left").write_text("over")
        self.refused("not committed")

    def test_a_version_is_released_once(self):
        self.git("tag", f"v{VERSION}")
        self.commit()
        self.refused(f"the tag v{VERSION} is on another commit")

    @unittest.skipUnless(BUF, "buf is not installed")
    def test_a_protocol_that_breaks_a_releases_clients_is_refused(self):
        self.edit("proto/collided/v1/frame.proto", " frame_id = 1;", " frame_id = 1000;")
        self.commit()
        code, problems, _ = self.check()
        self.assertEqual(code, 1)
        self.assertIn("frame.proto", problems[0])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
