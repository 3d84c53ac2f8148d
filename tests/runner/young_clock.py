"""A machine that seems to have booted seconds ago: a time namespace of Linux."""

import os
import subprocess
import time

AGE = 5  # seconds


def command():
    """The words that run what follows them with clocks of AGE seconds. Who is not root does it in a user namespace."""
    words = ["unshare", "--time", "--fork"]
    if os.geteuid() != 0:
        words.append("--map-current-user")
    for name, clock in (("--monotonic", time.CLOCK_MONOTONIC), ("--boottime", time.CLOCK_BOOTTIME)):
        words += [name, str(AGE - int(time.clock_gettime(clock)))]
    return words


def obstacle():
    """Why that cannot be done here, or None."""
    try:
        tried = subprocess.run([*command(), "true"], capture_output=True, text=True, timeout=30)
    except FileNotFoundError:
        return "unshare (util-linux) is not installed"
    said = tried.stderr.strip().splitlines()
    return None if tried.returncode == 0 else said[0] if said else f"unshare exited with {tried.returncode}"
