"""Completions: a shell loads the scripts and is asked.

Usage: completion_test.py bash|fish|zsh COLLIDECTL DAEMON SHARE"""

import os
import shutil
import subprocess
import sys
import tempfile
import unittest

import help as help_text
from terminal import Terminal

SHELL, COLLIDECTL, DAEMON, SHARE = sys.argv[1:5]
PROGRAMS = {"collidectl": COLLIDECTL, "collided": DAEMON}
BASH = f"{SHARE}/bash-completion/completions/"
ZSH = f"{SHARE}/zsh/site-functions/_"
FISH = f"{SHARE}/fish/vendor_completions.d/"

# Asked with the words of each line, separated by tabs; the last one is to be completed.
ASK_BASH = r"""
source "$1"
while IFS= read -r line; do
  mapfile -t -d $'\t' COMP_WORDS <<< "$line"
  COMP_WORDS[-1]=${COMP_WORDS[-1]%$'\n'}
  COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
  COMPREPLY=()
  "_${COMP_WORDS[0]}"
  printf '%s\t' "${COMPREPLY[@]}"
  echo
done
"""


def bash(queries, cwd=None):
    """What bash offers for each query, which is a list of words."""
    program = queries[0][0]
    lines = "".join("\t".join(query) + "\n" for query in queries)
    done = subprocess.run(["bash", "--norc", "-c", ASK_BASH, "bash", BASH + program], input=lines, text=True,
                          capture_output=True, timeout=120, cwd=cwd)
    assert done.returncode == 0 and not done.stderr, done.stderr
    return [[word for word in line.split("\t") if word] for line in done.stdout.splitlines()]


def fish(query, cwd=None):
    script = FISH + query.split()[0] + ".fish"
    done = subprocess.run(["fish", "--no-config", "-c", "source $argv[1]; complete -C $argv[2]", script, query],
                          text=True, capture_output=True, timeout=120, cwd=cwd)
    assert done.returncode == 0 and not done.stderr, done.stderr
    return [line.split("\t")[0] for line in done.stdout.splitlines()]


def cases():
    """(program, command or None, its options with their choices), from --help."""
    for program, path in PROGRAMS.items():
        yield program, None, help_text.options(path)
        for command in help_text.commands(path):
            yield program, command, help_text.options(path, command)


class WithFiles(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        for name in ("frame 1.ply", "frame 2.ply"):
            with open(os.path.join(self.folder, name), "w", encoding="ascii"):
                pass
        os.mkdir(os.path.join(self.folder, "folder"))


class Bash(WithFiles):
    def ask(self, *words):
        return bash([["collidectl", *words]], self.folder)[0]

    def test_every_option_and_choice_of_help_is_offered(self):
        count = 0
        for program, command, options in cases():
            words = [program, *([command] if command else [])]
            names, *choices = bash([[*words, "-"], *([*words, name, ""] for name in options)])
            self.assertEqual(sorted(names), sorted(options))
            for name, offered in zip(options, choices):
                if options[name]:
                    self.assertEqual(sorted(offered), sorted(options[name]), [*words, name])
                count += 1
        self.assertGreater(count, 250)

    def test_commands(self):
        self.assertEqual(self.ask(""), help_text.commands(COLLIDECTL))
        self.assertEqual(self.ask("str"), ["stream"])
        self.assertEqual(self.ask("completion", ""), ["bash", "zsh", "fish"])

    def test_names_of_scenes(self):
        listed = [line.split()[0] for line in help_text.run(COLLIDECTL, "scenes").splitlines()]
        for command in ("stream", "estimate", "export", "load", "bench"):
            self.assertLessEqual(set(listed), set(self.ask(command, "--scene", "")), command)
        self.assertIn("multiscale_knots_2", self.ask("stream", "--scene", "mult"))

    def test_words_after_an_equals_sign(self):
        for split in (["--accuracy", "=", "gu"], ["--accuracy=gu"]):
            self.assertEqual([word.removeprefix("--accuracy=") for word in self.ask("detect", *split)], ["guarded"])
        self.assertIn("exact", self.ask("detect", "--accuracy", "="))

    def test_lists_go_on_after_a_comma(self):
        self.assertEqual(self.ask("detect", "--kinds", "vt,e"), ["vt,ee", "vt,et"])
        self.assertEqual(self.ask("bench", "--engine", "octree,lb"), ["octree,lbvh"])
        self.assertEqual(self.ask("stream", "--accuracy", "fast,"), [])

    def test_files_and_folders(self):
        files, folders = ["folder", "frame 1.ply", "frame 2.ply"], ["folder"]
        for words in (["detect"], ["detect", "frame 1.ply"], ["detect", "--json"], ["detect", "--out"],
                      ["load", "--frames", "frame 1.ply", "frame 1.ply"], ["replay"]):
            self.assertEqual(sorted(self.ask(*words, "f")), files, words)
        self.assertEqual(self.ask("export", "--out", ""), folders)
        self.assertEqual(sorted(bash([["collided", "--config", "fr"]], self.folder)[0]), files[1:])

    def test_words_that_only_the_user_knows_are_left_alone(self):
        for words in (["stream", "--thickness"], ["info", "--server"], ["stream", "--exclude-meshes", "ball"]):
            self.assertEqual(self.ask(*words, ""), [], words)
        self.assertEqual(self.ask("nonsense", "-"), [])

    def test_a_switch_takes_no_word(self):
        self.assertEqual(self.ask("stream", "--json", "--accuracy", "ex"), ["exact"])
        self.assertIn("--json", self.ask("info", ""))

    def test_at_a_prompt(self):
        with Terminal(["bash", "--norc", "--noprofile", "-i"], os.environ, self.folder) as shell:
            shell.type(f"source {BASH}collidectl && source {BASH}collided && echo rea''dy\n")
            shell.wait_for("ready")
            for typed, shown in (("collidectl det", "ect "), ("collidectl detect --accuracy=gu", "arded "),
                                 ("collidectl detect --kinds ee,t", "t"), ("collided --log-format j", "son ")):
                shell.type(typed + "\t#")
                shell.wait_for(typed + shown)
                shell.type("\x15")  # clears the line

    def test_collidectl_prints_the_scripts_that_are_installed(self):
        for shell, path in (("bash", BASH + "collidectl"), ("zsh", ZSH + "collidectl"), ("fish", FISH + "collidectl.fish")):
            with open(path, encoding="utf-8") as file:
                self.assertEqual(help_text.run(COLLIDECTL, "completion", shell), file.read())


class Fish(WithFiles):
    def test_every_option_and_choice_of_help_is_offered(self):
        for program, command, options in cases():
            words = f"{program} {command or ''}".strip()
            long_names = [name for name in options if name.startswith("--")]
            self.assertEqual(sorted(word.split("=")[0] for word in fish(f"{words} --")), sorted(long_names))
        levels = help_text.options(COLLIDECTL, "detect")["--accuracy"]
        self.assertEqual(sorted(fish("collidectl detect --accuracy ")), sorted(levels))

    def test_commands_lists_files_and_folders(self):
        self.assertEqual(sorted(fish("collidectl ")), sorted(help_text.commands(COLLIDECTL)))
        self.assertIn("vt,tt", fish("collidectl detect --kinds vt,"))
        self.assertEqual(fish("collidectl export --out ", self.folder), ["folder/"])
        self.assertIn("frame 1.ply", [word.replace("\\", "") for word in fish("collidectl detect fra", self.folder)])
        self.assertEqual(fish("collidectl stream --scene cloth"), ["cloth_ball"])


class Zsh(WithFiles):
    def setUp(self):
        super().setUp()
        self.env = {**os.environ, "ZDOTDIR": self.folder}

    def at_a_prompt(self, set_up):
        with Terminal(["zsh", "-f", "-i"], self.env, self.folder) as shell:
            shell.type(f"unsetopt zle_bracketed_paste; PS1='$ '; autoload -Uz compinit; {set_up} && echo rea''dy\n")
            shell.wait_for("ready")
            for typed, shown in (("collidectl det", "ect "), ("collidectl detect --accuracy=gu", "arded "),
                                 ("collidectl detect --min-sep", "aration"), ("collidectl bench --engine octree,lb", "vh"),
                                 ("collidectl stream --scene fla", "menco "), ("collided --log-format j", "son "),
                                 ("collidectl export --out fo", "lder/")):
                shell.type(typed + "\t")
                shell.wait_for(shown)
                shell.type("\x15")

    def test_at_a_prompt_installed(self):
        self.at_a_prompt(f"fpath=({SHARE}/zsh/site-functions $fpath); compinit -u -D")

    def test_at_a_prompt_sourced(self):
        self.at_a_prompt(f"compinit -u -D; source {ZSH}collidectl; source {ZSH}collided")

    def test_every_option_of_help_is_there(self):
        for program, command, options in cases():
            with open(ZSH + program, encoding="utf-8") as file:
                _, _, body = file.read().partition(f"\n_{program}{'_' + command if command else ''}() {{\n")
            body = body.partition("\n}\n")[0]
            for name in options:
                self.assertRegex(body, rf"[)*']{name}(=)?\[", (program, command))


if __name__ == "__main__":
    if not shutil.which(SHELL):
        print(f"skipped: {SHELL} is not installed (Debian: {SHELL})")
        sys.exit(77)
    unittest.main(argv=[sys.argv[0], SHELL.capitalize()], verbosity=2)
