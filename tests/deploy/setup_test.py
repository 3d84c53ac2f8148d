#!/usr/bin/env python3
"""deploy/packages upgrades nothing that it need not, and says what it installs; apt-get plans on a made-up system.

usage: setup_test.py REPOSITORY
"""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

REPOSITORY = pathlib.Path(sys.argv[1]).resolve()


def entry(name, version, depends="", installed=False):
    lines = [f"Package: {name}", f"Version: {version}", "Architecture: all", "Maintainer: a <a@b>", "Description: a"]
    lines += [f"Depends: {depends}"] if depends else []
    lines += ["Status: install ok installed"] if installed else [f"Filename: {name}_{version}.deb", "Size: 1", f"SHA256: {'0' * 64}"]
    return "\n".join(lines) + "\n\n"


class Setup(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        for name in ("sources", "lists/partial", "cache/archives/partial", "dpkg/updates", "dpkg/info", "parts"):
            (self.root / name).mkdir(parents=True)
        (self.root / "sources.list").write_text(f"deb [trusted=yes] file:{self.root}/sources ./\n")
        (self.root / "apt.conf").write_text(f"""
            Dir::Etc::SourceList "{self.root}/sources.list"; Dir::Etc::SourceParts "{self.root}/parts";
            Dir::Etc::PreferencesParts "{self.root}/parts"; Dir::State::Lists "{self.root}/lists";
            Dir::State::Status "{self.root}/dpkg/status"; Dir::State::Extended_States "{self.root}/extended";
            Dir::Cache "{self.root}/cache"; APT::Sandbox::User "root"; APT::Get::List-Cleanup "false";
        """)
        self.environment = os.environ | {"APT_CONFIG": str(self.root / "apt.conf"), "DPKG_ADMINDIR": str(self.root / "dpkg")}

    def plan(self, installed, available, *packages):
        """Returns the lines that report the missing ones of `packages`."""
        (self.root / "dpkg/status").write_text("".join(entry(*one, installed=True) for one in installed))
        (self.root / "sources/Packages").write_text("".join(entry(*one) for one in available))
        script = f"source deploy/packages; COLLIDED_PACKAGES=({' '.join(packages)}); apt-get update -qq; collided_show_plan"
        done = subprocess.run(["bash", "-euo", "pipefail", "-c", script], cwd=REPOSITORY, env=self.environment, text=True,
                              capture_output=True, timeout=60, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout.splitlines()

    def test_what_is_installed_stays_where_the_sources_have_its_version(self):
        installed = [("libthing0", "1.0"), ("thing", "1.0", "libthing0 (= 1.0)")]
        available = [row for version in ("1.0", "1.1") for row in (
            ("libthing0", version), ("thing", version, f"libthing0 (= {version})"), ("libthing-dev", version, f"libthing0 (= {version})"))]
        self.assertEqual(self.plan(installed, available, "libthing-dev"), ["packages: installing 1 that are missing: libthing-dev 1.0"])

    def test_what_only_a_dependency_would_upgrade_stays_too(self):
        available = [row for version in ("1.0", "1.1") for row in (("libthing0", version), ("libthing-dev", version, f"libthing0 (= {version})"))]
        self.assertEqual(self.plan([("libthing0", "1.0")], [*available, ("tool-dev", "7", "libthing-dev")], "tool-dev"),
                         ["packages: installing 1 that are missing: tool-dev 7",
                          "packages: installing 1 that they depend on: libthing-dev 1.0"])

    def test_what_is_installed_and_named_is_not_upgraded(self):
        self.assertEqual(self.plan([("tool", "1.0")], [("tool", "1.1"), ("other", "3")], "tool", "other"),
                         ["packages: installing 1 that are missing: other 3"])
        self.assertEqual(self.plan([("tool", "1.0")], [("tool", "1.1")], "tool"), ["packages: nothing is missing"])

    def test_an_upgrade_that_is_needed_is_reported(self):
        self.assertEqual(self.plan([("libthing0", "0.9")], [("libthing0", "1.1"), ("libthing-dev", "1.1", "libthing0 (= 1.1)")], "libthing-dev"),
                         ["packages: upgrading libthing0 0.9 -> 1.1: a missing package depends on it",
                          "packages: installing 1 that are missing: libthing-dev 1.1"])


if __name__ == "__main__":
    if not shutil.which("apt-get"):
        print("skipped: apt-get is not installed")
        sys.exit(77)
    sys.argv = sys.argv[:1]
    unittest.main()
