"""What --help shows, read independently of what makes pages and completions."""

import re
import subprocess

OPTION = re.compile(r"^ {2,4}((?:-\w,)?--[a-z0-9-]+)(?: (.*))?$")
CHOICES = re.compile(r":\{([^}]*)\}")
COMMAND = re.compile(r"^  ([a-z][a-z0-9-]*)(?:\s{2,}|$)")


def run(*words):
    return subprocess.run(words, capture_output=True, text=True, check=True, timeout=60).stdout


def commands(program):
    """The names after "Subcommands:"."""
    _, _, after = run(program, "--help").partition("Subcommands:\n")
    return [match[1] for line in after.splitlines() if (match := COMMAND.match(line))]


def options(program, command=None):
    """{"--name": its choices, if it has any}, and "-h"."""
    found = {}
    for line in run(program, *([command] if command else []), "--help").splitlines():
        if match := OPTION.match(line):
            choices = CHOICES.search(match[2] or "")
            for name in match[1].split(","):
                found[name] = choices[1].split(",") if choices else []
    return found
