"""Python of a page, run as a new user would run it, against the test's own daemon."""

import os
import subprocess
import sys
import tempfile

README_SOCKET = "unix:/run/collided/socket"


def run_python(program, address, stubs):
    """What a page's program prints; its only change is the daemon's address."""
    assert README_SOCKET in program, program
    return run_with_package(program.replace(README_SOCKET, address), address, stubs)


def run_with_package(program, address, package, timeout=60):
    """What a program prints that finds the daemon by itself."""
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run([sys.executable, "-c", program], cwd=folder, text=True, capture_output=True, timeout=timeout,
                              env={**os.environ, "PYTHONPATH": str(package), "COLLIDED_SERVER": address})
    assert done.returncode == 0, done.stderr
    return done.stdout
