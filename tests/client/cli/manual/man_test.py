"""Man pages: complete, and without a warning from man and mandoc.

Usage: man_test.py COLLIDECTL DAEMON SHARE REPOSITORY"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tomllib
import unittest

import help as help_text

COLLIDECTL, DAEMON = sys.argv[1:3]
MAN = pathlib.Path(sys.argv[3]) / "man"
REPOSITORY = pathlib.Path(sys.argv[4])
PAGES = sorted(MAN.glob("man*/*"))


def text_of(page):
    """The page's text without its macros."""
    text = re.sub(r"\\f[BIR]|\\&", "", page.read_text(encoding="utf-8"))
    return text.replace("\\-", "-").replace("\\(aq", "'").replace("\\e", "\\")


def needs(tool, package):
    return unittest.skipUnless(shutil.which(tool), f"{tool} is not installed (Debian: {package})")


class ManPages(unittest.TestCase):
    def test_every_command_and_the_daemon_have_one(self):
        names = ["collidectl.1", *(f"collidectl-{command}.1" for command in help_text.commands(COLLIDECTL))]
        self.assertEqual(sorted(page.name for page in PAGES), sorted([*names, "collided.8", "collided.toml.5"]))

    def test_every_option_and_choice_of_help_is_in_the_page(self):
        pages = [(MAN / "man1/collidectl.1", COLLIDECTL, None), (MAN / "man8/collided.8", DAEMON, None)]
        pages += [(MAN / f"man1/collidectl-{command}.1", COLLIDECTL, command) for command in help_text.commands(COLLIDECTL)]
        for page, program, command in pages:
            entries = dict(re.findall(r"(?<=\n)\.TP\n(.*)\n((?:(?!\.).*\n)+)", text_of(page)))
            by_name = {name.split("[")[0]: text for tag, text in entries.items() for name in re.split(r", | ", tag)}
            for name, choices in help_text.options(program, command).items():
                self.assertIn(name, by_name, page.name)
                self.assertIn(", ".join(choices), by_name[name].replace("\n", " "), (page.name, name))

    def test_the_page_of_the_file_has_every_key_of_the_example(self):
        keys = re.findall(r"\n\.TP\n(\S+) = ", text_of(MAN / "man5/collided.toml.5"))
        example = tomllib.loads((REPOSITORY / "deploy/collided.toml").read_text(encoding="utf-8"))
        self.assertEqual(sorted(keys), sorted(example))

    def test_exit_codes_and_examples_have_their_sections(self):
        for page in MAN.glob("man1/*"):
            self.assertRegex(text_of(page), r'\.SH "EXIT STATUS"\n0 done, 1 failure', page.name)
        load = text_of(MAN / "man1/collidectl-load.1")
        self.assertIn(".SH EXAMPLES", load)
        self.assertIn("\ncollidectl load --scene reef_knot --clients 8 --find-max --p99 5ms\n", load)

    def test_only_builds_write_them(self):
        self.assertNotIn("manual", help_text.commands(COLLIDECTL))
        done = subprocess.run([COLLIDECTL, "manual", "/dev/null/share", "--date", "2026-11-23"], capture_output=True,
                              text=True, timeout=60)
        self.assertEqual((done.returncode, done.stderr),
                         (1, "collidectl: /dev/null/share/man/man1/collidectl.1 cannot be written\n"))

    @needs("mandoc", "mandoc")
    def test_mandoc_finds_nothing(self):
        done = subprocess.run(["mandoc", "-Tlint", *PAGES], capture_output=True, text=True, timeout=60)
        self.assertEqual(done.stdout + done.stderr, "")

    @needs("lexgrog", "man-db")
    def test_man_warns_of_nothing_and_knows_what_each_page_is(self):
        env = {**os.environ, "LC_ALL": "C.UTF-8", "MANPAGER": "cat", "MANWIDTH": "80"}
        for page in PAGES:
            done = subprocess.run(["/usr/bin/man", "--warnings", "-E", "UTF-8", "-l", page], capture_output=True,
                                  text=True, env=env, timeout=60)
            self.assertEqual((done.returncode, done.stderr), (0, ""), page.name)
            name = page.name.rpartition(".")[0]
            known = help_text.run("lexgrog", page)
            self.assertRegex(known, rf'"{re.escape(name)} - \S.*\S"', page.name)


if __name__ == "__main__":
    result = unittest.main(argv=sys.argv[:1], verbosity=2, exit=False).result
    if result.wasSuccessful() and result.skipped:
        print(*(f"skipped: {reason}" for _, reason in result.skipped), sep="\n")
        sys.exit(77)
    sys.exit(not result.wasSuccessful())
