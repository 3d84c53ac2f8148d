#!/usr/bin/env python3
"""The Blender add-on as a user has it: made into a zip, installed by Blender, used on scenes that inside/ makes.

usage: blender_test.py headless|window DAEMON REPOSITORY
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

try:
    import setuptools  # noqa: F401
except ImportError as missing:
    print(f"skipped: {missing} (Debian: python3-setuptools)")
    sys.exit(77)

WHICH, DAEMON, REPOSITORY = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3])
INSIDE = pathlib.Path(__file__).resolve().parent / "inside"
NEEDED = {"blender": "blender"}
if WHICH == "window":
    NEEDED |= {"Xvfb": "xvfb"}
sys.path.insert(0, str(REPOSITORY / "tests" / "interop"))
from daemon import Daemon  # noqa: E402


def skip_without_programs():
    for program, package in NEEDED.items():
        if shutil.which(program) is None:
            print(f"skipped: {program} is not installed (Debian: {package})")
            sys.exit(77)


def skip_without_its_blender():
    """The add-on is for Blender 3.4 to 3.6, and says so in others."""
    version = subprocess.run(["blender", "--version"], capture_output=True, text=True, timeout=60).stdout.splitlines()[0]
    if re.match(r"Blender 3\.[456]\b", version) is None:
        print(f"skipped: this is {version}, and the add-on is for Blender 3.4 to 3.6")
        sys.exit(77)


def display(out):
    """Starts a virtual display on a free number. Returns it and its name."""
    read, write = os.pipe()
    screen = subprocess.Popen(["Xvfb", "-displayfd", str(write), "-screen", "0", "640x480x24"], pass_fds=[write],
                              stdout=out, stderr=out)
    os.close(write)
    with os.fdopen(read) as number:
        name = number.readline().strip()
    return screen, f":{name}"


def run(folder, server, *options, **environment):
    """Blender with a user's folder of its own, in which the add-on is installed."""
    archive = pathlib.Path(folder, "add_on.zip")
    subprocess.run([sys.executable, REPOSITORY / "client" / "blender" / "make_zip", archive], check=True)
    clean = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "COLLIDED_SERVER")}
    # Debian's Blender looks for its Python's packages where PATH has a python3.
    clean["PATH"] = f"{pathlib.Path(sys.executable).parent}:{clean['PATH']}"
    return subprocess.run(
        ["blender", *options, "--factory-startup", "--python-exit-code", "1", "--python", INSIDE / f"{WHICH}.py", "--",
         archive, server, DAEMON], timeout=200,
        env={**clean, "BLENDER_USER_SCRIPTS": f"{folder}/scripts", "HOME": folder, "PYTHONDONTWRITEBYTECODE": "1", **environment})


def main():
    skip_without_programs()
    skip_without_its_blender()
    screen = None
    daemon = Daemon(DAEMON)
    try:
        with tempfile.TemporaryDirectory() as folder:
            if WHICH == "headless":
                return run(folder, daemon.address, "--background").returncode
            with open(f"{folder}/display", "wb") as out:
                screen, name = display(out)
            return run(folder, daemon.address, "--enable-event-simulate", "--no-window-focus", DISPLAY=name).returncode
    finally:
        daemon.kill()
        if screen is not None:
            screen.terminate()
            screen.wait()


if __name__ == "__main__":
    sys.exit(main())
