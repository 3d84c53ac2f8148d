"""What the measurements of this folder share: their options, a daemon of their own, `collidectl load` against it."""

import argparse
import contextlib
import json
import pathlib
import subprocess
import sys
import tempfile
import time

START_SECONDS = 30
MOST = 8192  # scenes and streams
LIMITS = ("--max-scenes", "--max-scenes-per-client", "--max-streams", "--max-streams-per-client")
# What a client may use is not what is measured.
LIFTED = (*(word for limit in LIMITS for word in (limit, str(MOST))), "--max-frames-per-second", "1000000000")


@contextlib.contextmanager
def daemon(program, backend, *more):
    """Its address. more: arguments."""
    with tempfile.TemporaryDirectory() as folder:
        address = f"unix:{folder}/socket"
        process = subprocess.Popen([program, "--address", address, "--backend", backend, "--log-level", "error",
                                    *LIFTED, *more])
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


def result_of(process, may_refuse=False):
    """What the tester printed. Refused frames cost next to nothing, so that figures with them tell nothing of the rest."""
    out, errors = process.communicate()
    if process.returncode != 0:
        sys.exit(f"{' '.join(process.args)}: {errors}")
    result = json.loads(out)
    if not may_refuse and result.get("refused"):
        sys.exit(f"{' '.join(process.args)}: the daemon refused frames: {result['refused']}")
    return result


def parser_of(description):
    """Options of every measurement, which adds its own."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("daemon")
    parser.add_argument("collidectl")
    parser.add_argument("--out", type=pathlib.Path)
    parser.add_argument("--date", default="")
    parser.add_argument("--commit", default="")
    return parser


def report(result, out):
    """To the file, or to standard output without one."""
    text = json.dumps(result, indent=1)
    if out:
        out.write_text(text + "\n")
    else:
        print(text)
