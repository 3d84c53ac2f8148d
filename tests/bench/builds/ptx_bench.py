#!/usr/bin/env python3
"""Starts a daemon on a GPU with its code, and with its PTX alone: seconds until it is ready, and whether contacts are the same.

usage: ptx_bench.py DAEMON PTX_DAEMON COLLIDECTL [--out FILE] [--date DATE] [--commit COMMIT]

DAEMON has code for the GPU; PTX_DAEMON was built with PTX alone, such as COLLIDED_CUDA_ARCHITECTURES=90-virtual. (With
CUDA_FORCE_PTX_JIT=1 the driver compiles at each start, and does not use its cache.) Three starts: with code; by `collidectl` with
PTX and an empty cache, which waits for a daemon of its own; and with PTX and the cache of the start before. The seconds of a daemon
end with the ready file; `first_scene` is a scene of one frame after that. Exits with 1 if any digest of contacts differs, or
if a start with PTX was not announced in the log before the kernels were there.
"""

import argparse
import contextlib
import hashlib
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

PATIENCE = 1800
SCENES = {
    "cloth_ball, ccd": ["--scene", "cloth_ball"],
    "cloth_ball, ccd, exact": ["--scene", "cloth_ball", "--accuracy", "exact", "--scale", "0.5"],
    "funnel, dcd": ["--scene", "funnel", "--mode", "dcd", "--thickness", "0.01", "--kinds", "vt,ee,tt"],
    "nbody, octree, f64": ["--scene", "nbody", "--engine", "octree", "--position-format", "f64"],
    "reef_knot, lbvh": ["--scene", "reef_knot", "--engine", "lbvh"],
}
ANNOUNCED = "compiling the kernels"


def environment(cache):
    """Of a process that finds nothing compiled but what is in `cache`."""
    return {**os.environ, "CUDA_CACHE_PATH": str(cache)}


@contextlib.contextmanager
def started(daemon, env):
    """A daemon that is ready: its address, the seconds that took, those until it announced a compilation, and its log."""
    with tempfile.TemporaryDirectory() as folder:
        ready, log, socket = (pathlib.Path(folder, name) for name in ("ready", "log", "socket"))
        begin = time.monotonic()
        with log.open("wb") as out, subprocess.Popen([daemon, "--backend", "cuda", "--address", f"unix:{socket}", "--ready-file", ready],
                                                     stdout=out, stderr=out, env=env) as process:
            try:
                said = None
                while not ready.exists():
                    if said is None and ANNOUNCED in log.read_text():
                        said = time.monotonic() - begin
                    if process.poll() is not None or time.monotonic() - begin > PATIENCE:
                        sys.exit(f"ptx_bench.py: the daemon is not ready: {log.read_text()}")
                    time.sleep(0.01)
                yield f"unix:{socket}", time.monotonic() - begin, said, log.read_text()
            finally:
                process.terminate()


def digest(collidectl, address, words):
    """Of the contacts of some frames, and the seconds that took."""
    with tempfile.TemporaryDirectory() as folder:
        contacts = pathlib.Path(folder, "contacts.csv")
        begin = time.monotonic()
        subprocess.run([collidectl, "stream", "--server", address, "--backend", "cuda", "--out", contacts, *words], check=True,
                       stdout=subprocess.DEVNULL, timeout=PATIENCE)
        seconds = time.monotonic() - begin
        lines = contacts.read_bytes()
    return {"contacts": lines.count(b"\n") - 1, "sha256": hashlib.sha256(lines).hexdigest()}, seconds


def measure(daemon, arguments, env):
    with started(daemon, env) as (address, seconds, said, log):
        _, first = digest(arguments.collidectl, address, ["--scene", "funnel", "--scale", "0.2", "--frames", "1"])
        digests = {name: digest(arguments.collidectl, address, [*words, "--frames", "20", "--dt", "0.05"])[0] for name, words in SCENES.items()}
    announced = [line for line in log.splitlines() if ANNOUNCED in line]
    return {"ready_seconds": round(seconds, 2), "announced_seconds": said and round(said, 2), "first_scene_seconds": round(first, 2), "announced": announced, "digests": digests}


def own_daemon(arguments, env):
    """collidectl starts one, and waits."""
    begin = time.monotonic()
    done = subprocess.run([arguments.collidectl, "stream", "--scene", "funnel", "--scale", "0.2", "--frames", "1", "--backend", "cuda"],
                          capture_output=True, text=True, timeout=PATIENCE, env={**env, "COLLIDED_DAEMON": arguments.ptx_daemon})
    return {"seconds": round(time.monotonic() - begin, 2), "exit_code": done.returncode, "said": done.stderr.strip()}


def write(report, arguments):
    if arguments.out:
        pathlib.Path(arguments.out).write_text(json.dumps(report, indent=1) + "\n", encoding="utf-8")


def put(report, arguments, way, result):
    """Writes what is known so far: a start that compiles takes minutes."""
    report[way] = result
    print(f"{way}: {json.dumps(result, indent=1)}", flush=True)
    write(report, arguments)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("daemon")
    parser.add_argument("ptx_daemon")
    parser.add_argument("collidectl")
    for option in ("--out", "--date", "--commit"):
        parser.add_argument(option, default="")
    arguments = parser.parse_args()
    version = subprocess.run([arguments.ptx_daemon, "--version"], check=True, capture_output=True, text=True).stdout
    report = {"date": arguments.date, "commit": arguments.commit, "version": version.splitlines()}
    with tempfile.TemporaryDirectory() as cache:
        put(report, arguments, "code", measure(arguments.daemon, arguments, environment(cache)))
        put(report, arguments, "collidectl, ptx, empty cache", own_daemon(arguments, environment(cache)))
        report["cache_bytes"] = sum(file.stat().st_size for file in pathlib.Path(cache).rglob("*") if file.is_file())
        put(report, arguments, "ptx, cached", measure(arguments.ptx_daemon, arguments, environment(cache)))
    code, ptx = report["code"], report["ptx, cached"]
    report["same_contacts"] = code["digests"] == ptx["digests"]
    # A line that comes when the kernels are there is no announcement. collidectl gives up after a minute without one.
    report["was_announced"] = not code["announced"] and ptx["announced_seconds"] is not None and ptx["announced_seconds"] < 5
    write(report, arguments)
    return 0 if report["same_contacts"] and report["was_announced"] and report["collidectl, ptx, empty cache"]["exit_code"] == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
