#!/usr/bin/env python3
"""Tests the program that writes and checks HAProxy's configuration. Usage: entrance_writer_test.py"""

import os
import pathlib
import subprocess
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from ops_daemon import Folder  # noqa: E402: without gRPC for Python the test ends as skipped here
from entrance import WRITER  # noqa: E402: without HAProxy, here


class Check(unittest.TestCase):
    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)
        self.folder.certificates()
        self.pem = self.folder.put("both.pem", (self.folder.read("server.pem") + self.folder.read("server.key")).decode())

    def write(self, *options):
        path = self.folder.path("haproxy.cfg")
        done = subprocess.run([WRITER, *options, "--output", path], capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stdout), (0, ""), done.stderr)
        return path

    def check(self, path, **environment):
        done = subprocess.run([WRITER, "--check", path], capture_output=True, text=True, check=False,
                              env=os.environ | environment)
        return done.returncode, done.stdout

    def good(self):
        return self.write("--daemon", "a=unix:/tmp/socket,127.0.0.1:9464", "--certificate", self.pem, "--user", "", "--group", "")

    def test_what_the_program_writes_is_good(self):
        path = self.good()
        self.assertEqual(self.check(path), (0, f"{path} is good\n"))

    def test_an_edited_limit_and_a_broken_line_are_told(self):
        path = self.good()
        text = pathlib.Path(path).read_text()
        for old, new, said in (("HEADER_BYTES 6144", "HEADER_BYTES 61440", "-  presetenv HEADER_BYTES 61440"),
                               ("http-reuse safe", "http-reuse sometimes", "sometimes")):
            with self.subTest(new):
                self.assertIn(old, text)
                pathlib.Path(path).write_text(text.replace(old, new))
                code, told = self.check(path)
                self.assertEqual(code, 1)
                self.assertIn(said, told)

    def test_an_old_haproxy_is_told(self):
        path = self.good()
        program = pathlib.Path(self.folder.path("haproxy"))
        program.write_text("#!/bin/sh\necho 'HAProxy version 2.4.30'\n")
        program.chmod(0o755)
        code, told = self.check(path, PATH=f"{self.folder.name}:{os.environ['PATH']}")
        self.assertEqual((code, told), (1, "HAProxy is version 2.4; these limits need 2.6\n"))

    def test_a_key_that_all_can_read_is_told(self):
        path = self.good()
        os.chmod(self.pem, 0o644)
        self.assertEqual(self.check(path),
                         (1, f"{self.pem} has secrets, and every user of this host can read it\n"))

    def test_files_that_cannot_be_are_told_in_a_line(self):
        daemon = ("--daemon", "a=unix:/s,127.0.0.1:1", "--plain-text")
        missing = self.folder.path("missing")
        for options in ((*daemon, "--run", missing), (*daemon, "--output", f"{missing}/cfg"), ("--check", missing)):
            with self.subTest(options[-2]):
                done = subprocess.run([WRITER, *options], capture_output=True, text=True, check=False)
                self.assertEqual((done.returncode, done.stdout), (1, ""))
                self.assertRegex(done.stderr, rf"^entrance: .*'{missing}.*'\n$")

    def test_options_that_make_no_entrance_are_refused(self):
        daemon = ("--daemon", "a=unix:/s,127.0.0.1:1")
        for options, said in (((), "--daemon is missing"), (daemon, "one of --certificate and --plain-text is needed"),
                              (("--daemon", "a=b"), "'a=b' is not NAME=ADDRESS,HTTP_ADDRESS"),
                              ((*daemon, *daemon, "--plain-text"), "two daemons have one name"),
                              ((*daemon, "--plain-text", "--client-ca", "x"), "--client-ca needs --certificate"),
                              ((*daemon, "--plain-text", "--client-tokens", "x"), "need --client-ca")):
            with self.subTest(said):
                done = subprocess.run([WRITER, *options], capture_output=True, text=True, check=False)
                self.assertEqual(done.returncode, 2)
                self.assertIn(said, done.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
