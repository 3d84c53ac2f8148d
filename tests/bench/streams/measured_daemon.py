"""A daemon of a measurement's own, and `collidectl load` against it."""

import contextlib
import json
import pathlib
import subprocess
import sys
import tempfile
import time

START_SECONDS = 30
MOST = 8192  # scenes and streams: no measurement is to meet a limit
LIMITS = ("--max-scenes", "--max-scenes-per-client", "--max-streams", "--max-streams-per-client")


@contextlib.contextmanager
def daemon(program, backend, *more):
    """Its address. more: arguments."""
    with tempfile.TemporaryDirectory() as folder:
        address = f"unix:{folder}/socket"
        process = subprocess.Popen([program, "--address", address, "--backend", backend, "--log-level", "error",
                                    *more, *(word for limit in LIMITS for word in (limit, str(MOST)))])
        try:
            wait_until_up(process, address)
            yield address
        finally:
            process.terminate()
            process.wait(START_SECONDS)


def wait_until_up(process, address):
    deadline = time.monotonic() + START_SECONDS
    while not pathlib.Path(address.removeprefix("unix:")).exists():
        if process.poll() is not None or time.monotonic() > deadline:
            sys.exit("the daemon does not start")
        time.sleep(0.05)


def started(command):
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def result_of(process):
    out, errors = process.communicate()
    if process.returncode != 0:
        sys.exit(f"{' '.join(process.args)}: {errors}")
    return json.loads(out)
