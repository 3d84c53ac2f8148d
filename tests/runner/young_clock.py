"""A machine that seems to have booted seconds ago: a Linux time namespace."""

import os
import subprocess
import time

AGE = 5  # seconds


def offsets():
    """Seconds that the clocks of this machine are ahead already, by name: namespaces count from the first of them."""
    try:
        with open("/proc/self/timens_offsets", encoding="ascii") as table:
            return {name: int(seconds) for name, seconds, _ in map(str.split, table)}
    except FileNotFoundError:
        return {}


def command():
    """The command prefix that runs a command with clocks of AGE seconds; in a user namespace unless root."""
    words = ["unshare", "--time", "--fork"]
    if os.geteuid() != 0:
        words.append("--map-current-user")
    ahead = offsets()
    for name, clock in (("monotonic", time.CLOCK_MONOTONIC), ("boottime", time.CLOCK_BOOTTIME)):
        words += [f"--{name}", str(AGE - int(time.clock_gettime(clock)) + ahead.get(name, 0))]
    return words


def obstacle():
    """Why that cannot be done here, or None."""
    try:
        tried = subprocess.run([*command(), "true"], capture_output=True, text=True, timeout=30)
    except FileNotFoundError:
        return "unshare (util-linux) is not installed"
    said = tried.stderr.strip().splitlines()
    return None if tried.returncode == 0 else said[0] if said else f"unshare exited with {tried.returncode}"
