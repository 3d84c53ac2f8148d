#!/usr/bin/env python3
"""The packages in a clean Debian root: installed, run, upgraded, replaced, removed. The steps come one after another.

usage: install_test.py PACKAGES FOLDER    (PACKAGES: the folder of packages_test.py; FOLDER: for the root)
"""

import json
import pathlib
import re
import shutil
import sys
import tempfile
import unittest

from booted import boot
from clean_root import CleanRoot, done, obstacle

PACKAGES, FOLDER = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]).resolve()
PATHS = {path.name.split("_")[0]: path for path in PACKAGES.glob("*.deb")}
CONFIG = "etc/collided/collided.toml"
# A vertex falls through a triangle: it is at z = 0 after two thirds of its way from 1 to -0.5.
FRAME = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0.2 0.2 {0}\nv 0.3 0.2 {1}\nv 0.2 0.3 {1}\nf 1 2 3\nf 4 5 6\n"
SERVE = """
install -d -o collided -g collided -m 750 /run/collided
setpriv --reuid=collided --regid=collided --init-groups {exec_start} &
for try in $(seq 600); do
  if collidectl info --server unix:/run/collided/socket >/dev/null 2>&1; then break; fi
  sleep 0.1
done
{command}
code=$?
kill -TERM $!
wait $! && exit $code
"""
PYTHON = """
import collided, numpy
floor = numpy.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], float)
drop = numpy.array([[.2, .2, 1], [.3, .2, 2], [.2, .3, 2]], float)
face = numpy.array([[0, 1, 2]], numpy.uint32)
with collided.Session({"floor": (floor, face), "drop": (drop, face)}, server="unix:/run/collided/socket") as session:
    found = list(session.run([{"floor": floor}, {"drop": drop - [0, 0, 1.5]}]))
print(round(found[-1].earliest_toi, 3))
"""


def repack(package, folder, change):
    """The package with `change(tree)` applied."""
    tree = folder / "tree"
    done("dpkg-deb", "-R", package, tree)
    change(tree)
    made = folder / "changed.deb"
    done("dpkg-deb", "--root-owner-group", "-Zgzip", "-b", tree, made)
    shutil.rmtree(tree)
    return made


def edit(file, old, new):
    text = file.read_text()
    assert old in text, (file, old)
    file.write_text(text.replace(old, new))


def facts(text):
    """What `systemctl show` said."""
    return dict(line.split("=", 1) for line in text.splitlines())


class Install(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.root = CleanRoot(FOLDER)
        cls.addClassCleanup(cls.root.remove)
        cls.daemon = next(name for name in PATHS if name in ("collided", "collided-cuda"))
        scratch = tempfile.TemporaryDirectory()
        cls.addClassCleanup(scratch.cleanup)
        cls.scratch = pathlib.Path(scratch.name)
        cls.root.put(repack(PATHS[cls.daemon], cls.scratch, cls.make_previous), "tmp/previous.deb")
        cls.root.put(PATHS[cls.daemon], "tmp/daemon.deb")
        for name in ("libcollided1", "libcollided-dev", "python3-collided"):
            cls.root.put(PATHS[name], f"tmp/{name}.deb")
        for number, heights in enumerate(((1, 2), (-0.5, 0.5))):
            cls.root.write(f"srv/{number}.obj", FRAME.format(*heights))

    @staticmethod
    def make_previous(tree):
        """An earlier build: a lower version, another default, a file that the new one no longer has."""
        edit(tree / "DEBIAN" / "control", "-1\n", "-0\n")
        edit(tree / CONFIG, "max-window = 16 ", "max-window = 15 ")
        (tree / "usr/share/doc/collided.old").write_text("old\n")

    def exec_start(self):
        unit = (self.root.folder / "usr/lib/systemd/system/collided.service").read_text()
        return re.search(r"^ExecStart=(.*)$", unit, re.MULTILINE)[1]

    def serving(self, command):
        """What `command` prints in the root while the service's own command runs there, as its own user."""
        return self.root.done("sh", "-c", SERVE.format(exec_start=self.exec_start() + " --log-level error", command=command))

    def read(self, path):
        return (self.root.folder / path).read_text()

    def test_1_the_previous_build_installs_and_serves(self):
        self.root.apt("install", "systemd", "python3")
        type(self).before = self.root.files()
        self.root.apt("install", "/tmp/previous.deb")
        self.assertIn("max-window = 15 ", self.read(CONFIG))
        said = json.loads(self.serving("collidectl detect --frames /srv/0.obj /srv/1.obj --json --server unix:/run/collided/socket"))
        self.assertAlmostEqual(said["earliest_toi"], 2 / 3, places=6)

    def test_2_the_unit_is_enabled_and_systemd_finds_no_mistake_in_it(self):
        self.assertEqual(self.root.done("systemctl", "is-enabled", "collided.service"), "enabled\n")
        self.root.done("systemd-analyze", "verify", "--man=no", "collided.service")
        self.assertRegex(self.read("etc/passwd"), r"(?m)^collided:.*:/usr/sbin/nologin$")

    def test_3_an_upgrade_keeps_the_edited_configuration(self):
        edited = self.read(CONFIG).replace("max-scenes = 64 ", "max-scenes = 63 ")
        self.root.write(CONFIG, edited)
        self.root.apt("install", "/tmp/daemon.deb")
        self.assertEqual(self.read(CONFIG), edited)
        self.assertIn("max-window = 16 ", self.read(CONFIG + ".dpkg-dist"))  # the new default, beside it
        self.assertFalse((self.root.folder / "usr/share/doc/collided.old").exists())
        said = json.loads(self.serving("collidectl info --json --server unix:/run/collided/socket"))
        self.assertEqual(said["limits"]["max_scenes"], 63)

    def test_4_the_packages_of_the_clients_work_with_it(self):
        self.root.apt("install", "/tmp/python3-collided.deb")
        self.root.write("tmp/drop.py", PYTHON)
        self.assertEqual(self.serving("python3 /tmp/drop.py"), "0.667\n")
        self.root.apt("install", "--simulate", "/tmp/libcollided1.deb", "/tmp/libcollided-dev.deb")  # their dependencies are there

    def test_5_the_service_runs_under_systemd(self):
        told = boot(self.root)
        if not told:
            self.skipTest("systemd-nspawn cannot boot a root here")
        self.assertEqual(facts(told["show"]), {
            "Type": "notify", "NRestarts": "0", "User": "collided", "ActiveState": "active",
            "StatusText": "serves on 127.0.0.1:50551, unix:/run/collided/socket"})
        self.assertAlmostEqual(json.loads(told["detect"])["earliest_toi"], 2 / 3, places=6)
        self.assertEqual(told["ready"], "ready\n")  # by HTTP
        self.assertEqual(told["modes"], "750 collided collided /run/collided\n770 collided collided /run/collided/socket\n")
        self.assertEqual(told["reload"], "0\n")
        self.assertIn("configuration read again", told["journal"])
        code, _, active = told["bad-reload"].partition("\n")
        self.assertNotEqual(code, "0")  # systemctl says so, and the daemon goes on
        self.assertEqual(active, "active\n")
        self.assertIn("max-scenes", told["journal"])
        self.assertEqual(facts(told["stuck"]), {"NRestarts": "1", "ActiveState": "active"})
        if self.daemon == "collided-cuda":
            self.assertEqual(facts(told["instance"]), {
                "ActiveState": "active", "StatusText": "serves on 127.0.0.1:50553, unix:/run/collided-3/socket"})
            self.assertEqual(told["beside-instance"], "inactive\n")
        self.assertEqual(facts(told["stop"]), {"Result": "success", "ActiveState": "inactive", "ExecMainStatus": "0"})

    def test_6_the_other_daemon_takes_its_place_and_its_configuration(self):
        other = {"collided": "collided-cuda", "collided-cuda": "collided"}[self.daemon]
        self.root.put(repack(PATHS[self.daemon], self.scratch, lambda tree: self.rename(tree, other)), "tmp/other.deb")
        edited = self.read(CONFIG)
        self.root.apt("install", "/tmp/other.deb")
        self.root.apt("purge", self.daemon)  # what is left of the first one is not the other's
        self.assertEqual(self.read(CONFIG), edited)
        self.assertEqual(self.root.done("systemctl", "is-enabled", "collided.service"), "enabled\n")
        type(self).daemon = other

    def rename(self, tree, other):
        edit(tree / "DEBIAN" / "control", f"Package: {self.daemon}\n", f"Package: {other}\n")
        for name in ("Conflicts", "Replaces"):
            edit(tree / "DEBIAN" / "control", f"{name}: {other}\n", f"{name}: {self.daemon}\n")

    def test_7_removal_leaves_the_configuration_and_purging_nothing(self):
        self.root.apt("remove", self.daemon, "python3-collided")
        left = {path for path in self.root.files() - self.before if "collided" in path and not path.endswith("dpkg-dist")}
        self.assertEqual({path for path in left if not path.startswith(("var/lib/systemd", "etc/systemd"))},
                         {"etc/collided", CONFIG})
        self.root.apt("purge", self.daemon)
        self.root.apt("autoremove", "--purge")
        self.assertEqual({path for path in self.root.files() - self.before if "collided" in path}, set())


if __name__ == "__main__":
    if why := obstacle():
        print(f"skipped: {why}")
        sys.exit(77)
    result = unittest.main(argv=sys.argv[:1], verbosity=2, failfast=True, exit=False).result
    if result.wasSuccessful() and result.skipped:
        print(f"skipped: all but one step, since {result.skipped[0][1]}")
        sys.exit(77)
    sys.exit(not result.wasSuccessful())
