#!/usr/bin/env python3
"""The units as installed: systemd finds no mistake in them, and they stay as closed as deploy/README.md says.

usage: units_test.py CMAKE REPOSITORY BUILD
"""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
import unittest

CMAKE = sys.argv[1]
REPOSITORY, BUILD = (pathlib.Path(argument).resolve() for argument in sys.argv[2:4])
ANALYZE = shutil.which("systemd-analyze")
SYSTEM = pathlib.Path("/lib/systemd/system")


def run(*command, **environment):
    done = subprocess.run([str(word) for word in command], text=True, timeout=120, check=False, env=environment or None,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    return done.returncode, done.stdout


class Units(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        """A root with what this build installs, and systemd's own units and the programs that units name."""
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.root = pathlib.Path(folder.name)
        code, said = run(CMAKE, "--install", BUILD, "--prefix", "/usr", "--component", "daemon", DESTDIR=folder.name)
        assert code == 0, said
        cls.units = sorted(path.name for path in (cls.root / "usr/lib/systemd/system").iterdir())
        shutil.copytree(SYSTEM, cls.root / "usr/lib/systemd/system", symlinks=True, dirs_exist_ok=True)
        (cls.root / "lib").symlink_to("usr/lib")
        for program in ("bin/kill", "usr/bin/nvidia-smi", "usr/bin/nvidia-modprobe"):
            (cls.root / program).parent.mkdir(exist_ok=True)
            shutil.copy("/bin/true", cls.root / program)

    def test_systemd_finds_no_mistake(self):
        instances = [name.replace("@.", "@0.") for name in self.units]
        self.assertIn("collided.service", instances)
        self.assertEqual(run(ANALYZE, "verify", "--man=no", f"--root={self.root}", *instances), (0, ""))

    def test_exposure_is_what_the_page_says(self):
        page = (REPOSITORY / "deploy" / "README.md").read_text()
        (limit,) = re.findall(r"`systemd-analyze security`[^.]*?(\d\.\d)", page)
        for name in self.units:
            if name == "collided-nvidia.service":  # it makes device files, and ends
                continue
            threshold = round(float(limit) * 10)
            code, said = run(ANALYZE, "security", "--offline=true", "--no-pager", f"--threshold={threshold}",
                             f"--root={self.root}", name)
            self.assertEqual(code, 0, said)

    def test_the_configuration_is_sound_and_documented(self):
        config = self.root / "etc/collided/collided.toml"
        self.assertIn("max-scenes = 64 ", config.read_text())
        code, said = run(self.root / "usr/bin/collided", "--config", config, "--check")
        self.assertEqual(code, 0, said)

    def test_the_installed_entrance_is_for_the_installed_configuration(self):
        options = tomllib.loads((self.root / "etc/collided/collided.toml").read_text())
        socket, = (address for address in options["address"] if address.startswith("unix:"))
        folder = self.root / "usr/share/collided/entrance"
        code, said = run(folder / "entrance", "--plain-text", "--daemon", f"one={socket},{options['http-address']}")
        self.assertEqual(code, 0, said)
        self.assertIn(f"server one {socket.replace('unix:', 'unix@')} ", said)
        self.assertIn(f"lua-load {folder}/free_memory.lua\n", said)

    def test_an_edited_configuration_survives_a_second_install(self):
        config = self.root / "etc/collided/collided.toml"
        before = config.read_text()
        self.addCleanup(config.write_text, before)
        config.write_text("max-scenes = 3\n")
        code, said = run(CMAKE, "--install", BUILD, "--prefix", "/usr", "--component", "daemon", DESTDIR=str(self.root))
        self.assertEqual(code, 0, said)
        self.assertEqual(config.read_text(), "max-scenes = 3\n")

    def test_another_prefix_is_named_by_its_units(self):
        with tempfile.TemporaryDirectory() as folder:
            code, said = run(CMAKE, "--install", BUILD, "--prefix", "/opt/c", "--component", "daemon", DESTDIR=folder)
            self.assertEqual(code, 0, said)
            unit = pathlib.Path(folder, "opt/c/lib/systemd/system/collided.service").read_text()
            self.assertIn("ExecStart=/opt/c/bin/collided --config /opt/c/etc/collided/collided.toml\n", unit)
            self.assertTrue(pathlib.Path(folder, "opt/c/etc/collided/collided.toml").exists())


if __name__ == "__main__":
    if not ANALYZE or not SYSTEM.is_dir():
        print("skipped: systemd-analyze is not installed (Debian: systemd)")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1], verbosity=2)
