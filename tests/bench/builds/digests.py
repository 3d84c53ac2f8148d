"""Digests of the contacts that a daemon finds in frames of some scenes, for builds to be compared."""

import contextlib
import hashlib
import pathlib
import subprocess
import sys
import tempfile
import time

PATIENCE = 1800
SCENES = {  # with how much finer or coarser than they come
    "cloth_ball, ccd": (1, ["--scene", "cloth_ball"]),
    "cloth_ball, ccd, exact": (0.5, ["--scene", "cloth_ball", "--accuracy", "exact"]),
    "funnel, dcd": (1, ["--scene", "funnel", "--mode", "dcd", "--thickness", "0.01", "--kinds", "vt,ee,tt"]),
    "nbody, octree, f64": (1, ["--scene", "nbody", "--engine", "octree", "--position-format", "f64"]),
    "reef_knot, lbvh": (1, ["--scene", "reef_knot", "--engine", "lbvh"]),
}


@contextlib.contextmanager
def started(command, env=None, folder="/tmp", known_as=None, announcement=None):
    """A daemon that is ready: its address, the seconds that took, those until its log had an announcement, and its log. Its files lie
    in `folder`, which a command with another root knows by another name."""
    with tempfile.TemporaryDirectory(dir=folder) as own:
        inside = f"{known_as or folder}/{pathlib.Path(own).name}"
        ready, log = pathlib.Path(own, "ready"), pathlib.Path(own, "log")
        begin = time.monotonic()
        with log.open("wb") as out, subprocess.Popen([*command, "--address", f"unix:{inside}/socket", "--ready-file", f"{inside}/ready"],
                                                     stdout=out, stderr=out, env=env) as process:
            try:
                said = None
                while not ready.exists():
                    if announcement and said is None and announcement in log.read_text():
                        said = time.monotonic() - begin
                    if process.poll() is not None or time.monotonic() - begin > PATIENCE:
                        sys.exit(f"the daemon is not ready: {log.read_text()}")
                    time.sleep(0.01)
                yield f"unix:{own}/socket", time.monotonic() - begin, said, log.read_text()
            finally:
                process.terminate()


def digest(collidectl, address, *words):
    """Of the contacts of some frames, and the seconds that took."""
    with tempfile.TemporaryDirectory() as folder:
        contacts = pathlib.Path(folder, "contacts.csv")
        begin = time.monotonic()
        subprocess.run([collidectl, "stream", "--server", address, "--out", contacts, *words], check=True, stdout=subprocess.DEVNULL,
                       timeout=PATIENCE)
        seconds = time.monotonic() - begin
        lines = contacts.read_bytes()
    return {"contacts": lines.count(b"\n") - 1, "sha256": hashlib.sha256(lines).hexdigest()}, seconds


def digests(collidectl, address, *words, frames=20, scale=1):
    """Of all scenes, times `scale`."""
    return {name: digest(collidectl, address, *scene, "--scale", str(factor * scale), "--frames", str(frames), "--dt", "0.05", *words)[0]
            for name, (factor, scene) in SCENES.items()}
