#!/usr/bin/env python3
"""The package for Go against a real daemon: its own tests, gofmt, vet, its example and the programs of its page.

usage: go_test.py DAEMON REPOSITORY BUILD_FOLDER
"""

import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest
import zipfile

from go_workspace import PACKAGE, Missing, Workspace

REPOSITORY, BUILD = (pathlib.Path(argument).resolve() for argument in sys.argv[2:4])
DAEMON = str(pathlib.Path(sys.argv[1]).resolve())
try:
    WORKSPACE = Workspace(REPOSITORY, BUILD)
except Missing as missing:
    print(f"skipped: {missing}")
    sys.exit(77)

sys.path += [str(REPOSITORY / "tests" / folder) for folder in ("interop", "docs")]
from daemon import Daemon  # noqa: E402
from markdown import Page  # noqa: E402
from run_page import README_SOCKET  # noqa: E402

PACKAGES = [PACKAGE, f"{PACKAGE}/internal/features", f"{PACKAGE}/test", f"{PACKAGE}/examples/first_contact"]
FIRST_CONTACT = b"vertex 3, triangle 0, t = 0.500000000\n"


class Go(unittest.TestCase):
    def test_its_own_tests_pass(self):
        WORKSPACE.run("test", "-count=1", "-timeout=150s", f"{PACKAGE}/internal/features", f"{PACKAGE}/test", COLLIDED_DAEMON=DAEMON)

    def test_it_is_formatted_and_nothing_is_suspicious(self):
        gofmt = shutil.which("gofmt")
        folders = [REPOSITORY / folder for folder in ("client/go", "tests/interop", "tests/client")]
        unformatted = subprocess.run([gofmt, "-l", *folders], text=True, capture_output=True, timeout=60, check=True)
        self.assertEqual(unformatted.stdout, "")
        WORKSPACE.run("vet", *PACKAGES)

    def test_its_types_hold_on_other_systems(self):
        try:
            said = WORKSPACE.run("run", REPOSITORY / "tests" / "client" / "go" / "systems.go", *PACKAGES).decode()
        except AssertionError as error:
            if 'cannot find package "golang.org/x/sys/windows"' in str(error):
                self.skipTest("Debian's gRPC for Go needs golang.org/x/sys/windows, which Debian leaves out")
            raise
        self.assertRegex(said, r"\Adarwin: (\d\d) files\nwindows: \1 files\n\Z")

    def test_go_takes_the_module_by_its_path(self):
        """The test fetches it from a folder that is laid out as a module proxy."""
        version, path = "v0.0.1", PACKAGE
        with tempfile.TemporaryDirectory() as folder:
            place = pathlib.Path(folder, "proxy", path, "@v")
            place.mkdir(parents=True)
            place.joinpath(f"{version}.info").write_text(f'{{"Version": "{version}"}}')
            shutil.copy(REPOSITORY / "client" / "go" / "go.mod", place / f"{version}.mod")
            with zipfile.ZipFile(place / f"{version}.zip", "w") as archive:
                for file in (file for file in sorted((REPOSITORY / "client" / "go").rglob("*")) if file.is_file()):
                    archive.write(file, f"{path}@{version}/{file.relative_to(REPOSITORY / 'client' / 'go')}")
            said = WORKSPACE.run("mod", "download", "-modcacherw", "-json", f"{path}@{version}", GO111MODULE="on", GONOSUMDB="*",
                                 GOPROXY=pathlib.Path(folder, "proxy").as_uri(), GOMODCACHE=f"{folder}/cache", PWD=folder)
            self.assertTrue(pathlib.Path(json.loads(said)["Dir"], "client.go").is_file())

    def test_the_example_starts_a_daemon_or_takes_one(self):
        example = f"{PACKAGE}/examples/first_contact"
        self.assertEqual(WORKSPACE.run("run", example, COLLIDED_DAEMON=DAEMON), FIRST_CONTACT)
        daemon = Daemon(DAEMON)
        self.addCleanup(daemon.kill)
        self.assertEqual(WORKSPACE.run("run", example, daemon.address), FIRST_CONTACT)

    def test_the_programs_of_the_page_print_what_they_say(self):
        daemon = Daemon(DAEMON)
        self.addCleanup(daemon.kill)
        page = Page(REPOSITORY / "client" / "go" / "README.md")
        programs, outputs = page.blocks("go"), page.blocks("text")
        self.assertEqual(len(programs), len(outputs))
        for program, output in zip(programs, outputs):
            with tempfile.TemporaryDirectory() as folder:
                file = pathlib.Path(folder) / "main.go"
                file.write_text(program.replace(README_SOCKET, daemon.address))
                self.assertEqual(WORKSPACE.run("run", file).decode(), output)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
