#!/usr/bin/env python3
"""deploy/README.md against the daemon: its tables of limits and metrics, its files and its exit codes.

usage: deploy_test.py DAEMON REPOSITORY
"""

import pathlib
import re
import subprocess
import sys
import tempfile
import unittest
import urllib.request

from markdown import Page

DAEMON, REPOSITORY = sys.argv[1], pathlib.Path(sys.argv[2]).resolve()
README = Page(REPOSITORY / "deploy" / "README.md")
HELP = subprocess.run([DAEMON, "--help"], text=True, capture_output=True, check=True, timeout=60).stdout
# Name and default of every option: UINT=64, or UINT [64] in newer releases of CLI11.
OPTIONS = dict(re.findall(r"^\s+--([\w-]+) \w+.*?(?:=| \[)([^\s\]]+)", HELP, re.MULTILINE))


def names_in(cell):
    return re.findall(r"`([\w-]+)(?:\{[^`]*)?`", cell)


def number_of(text):
    """64 M or 16,384; None where the text is no number."""
    found = re.fullmatch(r"([\d,.]+)( M)?", text.strip())
    return float(found[1].replace(",", "")) * (1e6 if found[2] else 1) if found else None


class Limits(unittest.TestCase):
    def setUp(self):
        self.header, *self.rows = README.table(after="## Limits")

    def test_every_limit_is_in_the_table_with_what_it_defends_against(self):
        self.assertEqual((self.header[0], self.header[-1]), ("option", "defends against"))
        told = {name: row for row in self.rows for name in names_in(row[0])}
        for name in told:
            self.assertIn(name, OPTIONS)
            self.assertTrue(told[name][-1], f"{name} defends against nothing")
        self.assertEqual({name for name in OPTIONS if name.startswith("max-")} - set(told), set(), "not in the table")

    def test_defaults_are_the_daemons(self):
        # The list in the cell's order: "64 M, 128 M" is for two options.
        for row in self.rows:
            for name, default in zip(names_in(row[0]), row[1].split(", ")):
                if (told := number_of(default)) is not None:
                    self.assertEqual(told, float(OPTIONS[name]), name)


class Metrics(unittest.TestCase):
    def serve(self):
        """The metrics address of the test's own daemon."""
        daemon = subprocess.Popen([DAEMON, "--address", "127.0.0.1:0", "--http-address", "127.0.0.1:0"], text=True,
                                  stderr=subprocess.PIPE)
        self.addCleanup(daemon.stderr.close)
        self.addCleanup(daemon.wait)
        self.addCleanup(daemon.kill)
        return next(filter(None, (re.search(r"metrics and health on (\S+)", line) for line in daemon.stderr)))[1]

    def test_every_metric_is_in_the_table_with_its_kind(self):
        text = urllib.request.urlopen(f"http://{self.serve()}/metrics", timeout=30).read().decode()
        served = dict(re.findall(r"^# TYPE (\S+) (\S+)$", text, re.MULTILINE))
        rows = README.table(after="| metric | kind |")[1:]
        told = {name: row[1] for row in rows for name in names_in(row[0])}
        labelled = {name for row in rows for name in names_in(row[0]) if f"`{name}{{" in row[0]}
        self.assertEqual({name: told.get(name) for name in served}, served)
        self.assertLessEqual(set(told) - set(served), labelled)  # a label's first value makes the metric


class Files(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def put(self, name, text):
        (self.folder / name).write_text(text)
        (self.folder / name).chmod(0o600)
        return self.folder / name

    def check(self, *options):
        """--check: its exit code and what it says."""
        done = subprocess.run([DAEMON, *options, "--check"], text=True, capture_output=True, timeout=60)
        return done.returncode, done.stdout + done.stderr

    def test_the_tokens_file_is_sound(self):
        (tokens,) = README.blocks("toml")
        code, said = self.check("--tokens-file", self.put("tokens.toml", tokens))
        self.assertEqual((code, said.splitlines()[-1]), (0, "collided: the configuration is valid"))

    def test_exit_codes_are_as_the_table_says(self):
        told = {int(row[0]) for row in README.table(after="| exit code |")[1:]}
        self.assertEqual(told, {0, 1, 2})
        self.assertEqual(self.check()[0], 0)
        self.assertEqual(self.check("--no-such-option")[0], 2)
        self.assertEqual(self.check("--address", "0.0.0.0:0")[0], 2)
        missing = subprocess.run([DAEMON, "--address", f"unix:{self.folder}/no/folder/socket"], capture_output=True, timeout=60)
        self.assertEqual(missing.returncode, 1)

    def test_the_folders_scripts_have_help(self):
        for script in ("quickstart", "packages", "bundle", "release", "sbom"):
            done = subprocess.run([REPOSITORY / "deploy" / script, "--help"], text=True, capture_output=True, timeout=60)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn(f"usage: deploy/{script}", done.stdout)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
