"""A machine that seems to have booted seconds ago: a time namespace of Linux."""

import subprocess
import time

AGE = 5  # seconds


def command():
    """The words that run what follows them with clocks of AGE seconds."""
    offsets = [f"{name}={AGE - int(time.clock_gettime(clock))}"
               for name, clock in (("--monotonic", time.CLOCK_MONOTONIC), ("--boottime", time.CLOCK_BOOTTIME))]
    return ["unshare", "--time", "--fork", *(word for offset in offsets for word in offset.split("="))]


def obstacle():
    """Why that cannot be done here, or None."""
    try:
        tried = subprocess.run([*command(), "true"], capture_output=True, text=True, timeout=30)
    except FileNotFoundError:
        return "unshare (util-linux) is not installed"
    said = tried.stderr.strip().splitlines()
    return None if tried.returncode == 0 else said[0] if said else f"unshare exited with {tried.returncode}"
