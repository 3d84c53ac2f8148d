#!/usr/bin/env python3
"""deploy/container without a container engine: packages against the programs' libraries, the health check against daemons, and
the Containerfile against what it says. Usage: container_test.py DAEMON COLLIDECTL REPOSITORY"""

import os
import pathlib
import platform
import re
import signal
import subprocess
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from ops_daemon import DaemonCase  # noqa: E402

PROGRAM, COLLIDECTL = sys.argv[1:3]
REPOSITORY = pathlib.Path(sys.argv[3]).resolve()
CONTAINER = REPOSITORY / "deploy" / "container"
TEXT = re.sub(r"^#.*\n", "", (CONTAINER / "Containerfile").read_text(), flags=re.MULTILINE)
ENTRANCE = ["haproxy", "python3"]
OF_EVERY_IMAGE = {"libc6", "libgcc-s1", "libstdc++6", "libasan8", "libubsan1", "libtsan2"}  # the last three of sanitizers


def run(*command):
    return subprocess.run(command, capture_output=True, text=True, timeout=60)


def libraries(program):
    """Paths of those that it is linked with itself."""
    needed = re.findall(r"NEEDED\s+(\S+)", run("objdump", "-p", program).stdout)
    paths = dict(re.findall(r"(\S+) => (\S+)", run("ldd", program).stdout))
    return {os.path.realpath(paths[name]) for name in needed if name in paths}


def package_of(path):
    """The /usr merge may have moved what dpkg knows by its old path."""
    for known in (path, path.removeprefix("/usr")):
        found = run("dpkg-query", "-S", known)
        if found.returncode == 0:
            return found.stdout.partition(":")[0]
    raise LookupError(path)


class Packages(unittest.TestCase):
    @unittest.skipUnless(platform.freedesktop_os_release().get("VERSION_CODENAME") == "bookworm", "images are of Debian 12")
    def test_the_image_has_what_the_programs_and_the_entrance_need_and_nothing_else(self):
        needed = {package_of(path) for program in (PROGRAM, COLLIDECTL) for path in libraries(program)} - OF_EVERY_IMAGE
        listed = run(CONTAINER / "runtime-packages", "--list").stdout.split()
        self.assertEqual(sorted(needed) + ENTRANCE, listed)


class Health(DaemonCase):
    program = PROGRAM

    def is_ready(self, address):
        host, _, port = address.rpartition(":")
        return run(CONTAINER / "is-ready", port, host).returncode == 0

    def test_follows_readyz(self):
        daemon = self.start("--grace-seconds", "600")
        self.assertTrue(self.is_ready(daemon.http_address))
        over, _ = self.hold(daemon)
        daemon.signal(signal.SIGTERM)
        daemon.wait_for(lambda: daemon.http("/readyz")[0] == 503, "draining")
        self.assertFalse(self.is_ready(daemon.http_address))
        over.set()
        daemon.process.wait(60)
        self.assertFalse(self.is_ready(daemon.http_address))  # nobody answers

    def test_bad_usage_is_told(self):
        for arguments in ((), ("http",)):
            done = run(CONTAINER / "is-ready", *arguments)
            self.assertEqual(done.returncode, 2)
            self.assertIn("usage", done.stderr)


class Containerfile(unittest.TestCase):
    def test_what_is_copied_is_there_and_can_be_run(self):
        copied = re.search(r"^COPY (deploy/.*) \S+$", TEXT, re.MULTILINE)[1].split()
        for name in [*copied, *re.findall(r"^RUN (deploy/\S+)", TEXT, re.MULTILINE)]:
            self.assertTrue(os.access(REPOSITORY / name, os.X_OK), name)
            if name.startswith("deploy/container/"):
                self.assertEqual(run("bash", "-n", REPOSITORY / name).returncode, 0)

    def test_it_runs_as_the_user_of_the_kubernetes_pods(self):
        user = re.search(r"^USER (\d+):(\d+)$", TEXT, re.MULTILINE)
        stateful = (REPOSITORY / "deploy" / "kubernetes" / "base" / "statefulset.yaml").read_text()
        self.assertEqual(re.findall(r"runAs(?:User|Group): (\d+)", stateful), list(user.groups()))
        self.assertLess(TEXT.rindex("RUN "), user.start())  # nothing is installed as that user

    def test_the_daemon_accepts_its_options_and_listens_on_its_ports(self):
        options = dict(re.findall(r"(COLLIDED_\w+)=(\S+)", re.search(r"^ENV (.*)$", TEXT, re.MULTILINE)[1]))
        done = subprocess.run([PROGRAM, "--check"], env={**os.environ, **options}, capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)
        exposed = re.search(r"^EXPOSE (.*)$", TEXT, re.MULTILINE)[1].split()
        listening = [options[f"COLLIDED_{name}"].rpartition(":")[2] for name in ("ADDRESS", "HTTP_ADDRESS")]
        self.assertEqual(exposed, listening)
        self.assertIn(f'"is-ready", "{exposed[1]}"', TEXT)

    def test_images_are_debian_12(self):
        self.assertEqual(re.findall(r"^FROM (\S+)", TEXT, re.MULTILINE), ["${BUILDER}", "debian:bookworm-slim"])
        self.assertIn("ARG BUILDER=debian:bookworm-slim\n", TEXT)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
