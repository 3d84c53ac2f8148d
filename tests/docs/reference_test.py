#!/usr/bin/env python3
"""The reference is made without a warning, and has every public name, with its documentation.

usage: reference_test.py REPOSITORY
"""

import html
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

REPOSITORY = pathlib.Path(sys.argv[1]).resolve()
NEEDED = ("client/cpp", "client/in_process", "client/go", "client/python", "client/reference", "proto", "CMakeLists.txt")
BUILT = shutil.ignore_patterns("node_modules", "__pycache__", "*.gif", "*.png")


def make(repository, out):
    return subprocess.run([sys.executable, "-B", repository / "client/reference/make", "--out", out], text=True,
                          capture_output=True, timeout=220)


def names(pattern, *paths):
    """What the pattern finds in files, in order."""
    return [name for path in sorted(paths) for name in re.findall(pattern, path.read_text(encoding="utf-8"), re.MULTILINE)]


class Reference(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.out = pathlib.Path(folder.name, "reference")
        done = make(REPOSITORY, cls.out)
        if done.returncode == 2:
            print(f"skipped: {done.stderr.strip().removeprefix('reference: ')}")
            sys.exit(77)
        assert done.returncode == 0, done.stdout + done.stderr

    def page(self, name):
        return (self.out / name).read_text(encoding="utf-8")

    def test_every_public_name_of_python_has_an_entry(self):
        page, package = self.page("python.html"), REPOSITORY / "client/python/collided"
        for module, file in (("collided", "__init__.py"), ("collided.gpu", "gpu/__init__.py")):
            listed = re.search(r"__all__ = \[([^]]*)\]", (package / file).read_text())[1]
            public = re.findall(r'"(\w+)"', listed)
            self.assertGreater(len(public), 4)
            for name in public:
                self.assertIn(f'id="{module}.{name}"', page)
        for name in names(r"^(?:async def|class) ([a-z]\w*|[A-Z]\w*)", package / "aio.py"):
            self.assertIn(f'id="collided.aio.{name}"', page)
        for name in names(r"^    def ([a-z]\w*)\(self", package / "session.py"):
            self.assertIn(f'id="collided.Session.{name}"', page)

    def test_every_message_and_call_of_the_protocol_has_one(self):
        count = 0
        for file in (REPOSITORY / "proto/collided/v1").glob("*.proto"):
            page = self.page(f"{file.stem}.html")
            for name in names(r"^(?:message|enum|service) (\w+)", file):
                self.assertIn(f'id="collided-v1-{name.lower()}"', page)
                count += 1
            for name in names(r"^ *rpc (\w+)|^ +[\w. ]+ (\w+) = \d+", file):
                self.assertIn(f'<span class="pre">{"".join(name)}</span>', page, file.name)
        self.assertGreater(count, 60)

    def test_every_public_class_and_function_of_cpp_has_one(self):
        library = REPOSITORY / "client/cpp"
        headers = [path for path in [*library.glob("*.hpp"), library / "batch/scene_set.hpp"]
                   if path.name != "frame_stream_state.hpp"]
        classes = names(r"^(?:class|struct) (\w+)(?: : .*)? {", *headers)
        self.assertGreater(len(classes), 15)
        listed = self.page("cpp/annotated.html")
        for name in classes:
            self.assertIn(f">{name}</a>", listed)
        functions = names(r"^(?!using|class|struct)[\w:<>&\[\]]+(?: [\w:<>&]+)* (\w+)\(", *headers)
        self.assertGreater(len(functions), 8)
        listed = self.page("cpp/namespacecollided_1_1client.html")
        for name in functions:
            self.assertRegex(listed, rf">{name}\b", name)

    @unittest.skipUnless(shutil.which("go"), "go is not installed (Debian: golang-go)")
    def test_every_public_type_and_function_of_go_has_one(self):
        page = html.unescape(self.page("go.html"))
        files = (REPOSITORY / "client/go").glob("*.go")
        for name in names(r"^(?:type|func) ([A-Z]\w*)", *files):
            self.assertRegex(page, rf"\n(?:type|func) {name}\b")

    def test_links_between_the_pages_exist(self):
        for page in self.out.glob("*.html"):
            for link in re.findall(r'href="([^"#:?]+)(?:[?#][^"]*)?"', self.page(page.name)):
                self.assertTrue((self.out / link).exists(), (page.name, link))

    def test_it_replaces_an_earlier_reference_and_nothing_else(self):
        with tempfile.TemporaryDirectory() as folder:
            mine = pathlib.Path(folder, "mine")
            mine.write_text("mine")
            done = make(REPOSITORY, folder)
            self.assertEqual(done.returncode, 1)
            self.assertIn("is neither empty nor an earlier reference", done.stderr)
            self.assertEqual(mine.read_text(), "mine")


class Undocumented(unittest.TestCase):
    """What lacks its documentation is named, and there are no pages."""

    def refused(self, file, before, after, *complaints):
        with tempfile.TemporaryDirectory() as folder:
            tree = pathlib.Path(folder, "tree")
            for part in NEEDED:
                copy = shutil.copy if (REPOSITORY / part).is_file() else lambda a, b: shutil.copytree(a, b, ignore=BUILT)
                (tree / part).parent.mkdir(parents=True, exist_ok=True)
                copy(REPOSITORY / part, tree / part)
            text = (tree / file).read_text()
            self.assertIn(before, text)
            (tree / file).write_text(text.replace(before, after, 1))
            done = make(tree, tree / "out")
            self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
            for complaint in complaints:
                self.assertIn(complaint, done.stderr)
            self.assertFalse((tree / "out").exists())

    def test_a_field_of_the_protocol(self):
        self.refused("proto/collided/v1/scene.proto", "\nenum Backend {",
                     "\nmessage Bare {\n  uint32 x = 1;\n}\nenum Backend {", "collided.v1.Bare.x", "no comment")

    def test_a_method_in_python(self):
        self.refused("client/python/collided/watch.py", "\n    def ", "\n    def bare(self) -> None:\n        pass\n\n    def ",
                     "bare has no docstring")

    def test_a_class_and_a_function_in_cpp(self):
        self.refused("client/cpp/watcher.hpp", "/// One thread reads; any may cancel.\n",
                     "class Bare {\n public:\n  /// One.\n  int one();\n};\nvoid bare();\n\n/// One.\n",
                     "Compound collided::client::Bare is not documented", "Member bare() (function)")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
