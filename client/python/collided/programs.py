"""Finds what wheels bring along; holds the scripts `collided` and `collidectl`, which run the daemon and the command line."""

from __future__ import annotations

import importlib.util
import os
import pathlib
import shutil
import sys
from typing import NoReturn

_SCRIPT_BYTES = 4096  # more than installers write
_MARK = b"collided.programs"  # in the scripts that installers write for this module


def bundled(name: str) -> str | None:
    """Returns the program that a wheel brought along: the one of `collided_cuda` if that is installed, else this package's own.
    None where neither has it."""
    return next((str(path) for folder in _folders() if os.access(path := folder / "bin" / name, os.X_OK)), None)


def bundled_library(name: str) -> str | None:
    """The same for a shared library."""
    return next((str(path) for folder in _folders() if (path := folder / "lib" / name).is_file()), None)


def find_program(name: str) -> str | None:
    """Returns the program that a wheel brought along, else the first on PATH; None if there is none.

    The scripts of this module are passed over. They would only look for the program again.
    """
    folders = os.environ.get("PATH", os.defpath).split(os.pathsep)
    return bundled(name) or next((found for folder in folders if (found := _in_folder(folder, name))), None)


def where_to_get_it(name: str) -> str:
    """Returns the advice for an error where there is no such program."""
    elsewhere = "and name the daemon's address as server='host:port' or in COLLIDED_SERVER"
    if sys.platform != "linux":
        return f"{name} runs on Linux, and this is {sys.platform}: run it in a container, in WSL or on a Linux host, {elsewhere}"
    return (f"no program {name!r} is in this package or on PATH: install a wheel that brings it along, or a Debian package; or run it in "
            f"a container or on another host, {elsewhere}")


def daemon() -> NoReturn:
    """The script `collided`."""
    _become("collided")


def command_line() -> NoReturn:
    """The script `collidectl`. It starts the daemon that Python would start, unless COLLIDED_DAEMON names another one."""
    own = bundled("collided")
    if own is not None:
        os.environ.setdefault("COLLIDED_DAEMON", own)
    _become("collidectl")


def _folders() -> list[pathlib.Path]:
    cuda = importlib.util.find_spec("collided_cuda")
    found = cuda.submodule_search_locations if cuda is not None else None
    return [*map(pathlib.Path, found or ()), pathlib.Path(__file__).parent]


def _in_folder(folder: str, name: str) -> str | None:
    found = shutil.which(name, path=folder)
    if found is None:
        return None
    try:
        with open(found, "rb") as file:
            return None if _MARK in file.read(_SCRIPT_BYTES) else found
    except OSError:  # a program may be executable and not readable
        return found


def _become(name: str) -> NoReturn:
    program = find_program(name) if sys.platform == "linux" else None
    if program is None:
        sys.exit(f"{name}: {where_to_get_it(name)}")
    os.execv(program, [program, *sys.argv[1:]])
