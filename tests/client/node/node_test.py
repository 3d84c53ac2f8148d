#!/usr/bin/env python3
"""The package for Node against a real daemon: its own tests, its examples as a user of the packed package runs them.

usage: node_test.py DAEMON REPOSITORY BUILD_FOLDER
"""

import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import node_package

REPOSITORY, BUILD = (pathlib.Path(argument).resolve() for argument in sys.argv[2:4])
DAEMON = str(pathlib.Path(sys.argv[1]).resolve())
try:
    PACKAGE = node_package.built(REPOSITORY, BUILD)
except node_package.Missing as missing:
    print(f"skipped: {missing}")
    sys.exit(77)

sys.path += [str(REPOSITORY / "tests" / folder) for folder in ("interop", "docs")]
from daemon import Daemon  # noqa: E402
from markdown import Page  # noqa: E402
from run_page import README_SOCKET  # noqa: E402

FIRST_CONTACT = "vertex 3, triangle 0, t = 0.500000000\n"


class Package(unittest.TestCase):
    def test_its_own_tests_pass(self):
        tests = sorted(str(file) for file in (PACKAGE / "dist" / "test").glob("*.test.js"))
        self.assertTrue(tests)
        node_package.run([node_package.node(), "--test", *tests], PACKAGE, COLLIDED_DAEMON=DAEMON)

    def test_the_lock_file_names_no_registry(self):
        self.assertNotIn('"resolved"', (REPOSITORY / "client" / "node" / "package-lock.json").read_text())


class Packed(unittest.TestCase):
    """What npm packs, unpacked as npm installs it."""

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        npm = shutil.which("npm")
        if not npm:
            raise unittest.SkipTest("npm is not installed")
        node_package.run([npm, "pack", "--silent", "--ignore-scripts", "--pack-destination", cls.folder], PACKAGE)
        (packed,) = cls.folder.glob("*.tgz")
        modules = cls.folder / "node_modules"
        modules.mkdir()
        for installed in (PACKAGE / "node_modules").iterdir():
            (modules / installed.name).symlink_to(installed)
        subprocess.run(["tar", "-xzf", packed, "-C", modules], check=True)
        (modules / "package").rename(modules / "collided")

    def run_node(self, *words):
        return node_package.run([node_package.node(), *map(str, words)], self.folder, COLLIDED_DAEMON=DAEMON)

    def test_it_has_what_it_needs_and_no_more(self):
        top = {path.name for path in (self.folder / "node_modules" / "collided").iterdir()}
        self.assertEqual(top, {"README.md", "dist", "examples", "package.json"})
        self.assertEqual([path.name for path in (self.folder / "node_modules" / "collided" / "dist").iterdir()], ["src"])

    def test_it_can_be_published(self):
        """Users install compiled code, which needs neither protoc nor a compiler of TypeScript."""
        package = json.loads((self.folder / "node_modules" / "collided" / "package.json").read_text())
        self.assertNotIn("private", package)
        self.assertNotIn("install", " ".join(package["scripts"]))
        self.assertTrue((self.folder / "node_modules" / "collided" / package["exports"]["."]["default"]).is_file())

    def test_the_example_starts_a_daemon_or_takes_one(self):
        example = self.folder / "example.mjs"
        shutil.copy(self.folder / "node_modules" / "collided" / "examples" / "first_contact.js", example)
        self.assertEqual(self.run_node(example), FIRST_CONTACT)
        daemon = Daemon(DAEMON)
        self.addCleanup(daemon.kill)
        self.assertEqual(self.run_node(example, daemon.address), FIRST_CONTACT)

    def test_the_programs_of_the_page_print_what_they_say(self):
        daemon = Daemon(DAEMON)
        self.addCleanup(daemon.kill)
        page = Page(REPOSITORY / "client" / "node" / "README.md")
        programs, outputs = page.blocks("js"), page.blocks("text")
        self.assertEqual(len(programs), len(outputs))
        for number, (program, output) in enumerate(zip(programs, outputs)):
            file = self.folder / f"page{number}.mjs"
            file.write_text(program.replace(README_SOCKET, daemon.address))
            self.assertEqual(self.run_node(file), output)

    def test_types_are_there_for_users(self):
        (self.folder / "user.mts").write_text(
            'import { DetectionMode, connect } from "collided";\n'
            'const client = await connect("unix:/none");\n'
            'const scene = await client.createScene({ mode: DetectionMode.CCD, meshes: [] });\n'
            "const id: bigint = scene.lastFrameId;\n"
            "// @ts-expect-error\n"
            "await client.createScene({ mode: DetectionMode.CCD, meshes: [], thicknes: id });\n")
        compiler = PACKAGE / "node_modules" / "typescript" / "bin" / "tsc"
        self.run_node(compiler, "--noEmit", "--strict", "--skipLibCheck", "--types", "node", "--module", "nodenext", "--target", "es2022", "user.mts")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
