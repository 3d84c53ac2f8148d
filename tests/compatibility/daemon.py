"""A daemon with a local socket, on two threads of the CPU, as all recordings and replays have it."""

import pathlib
import subprocess
import tempfile
import time


class Daemon:
    def __init__(self, program):
        self._folder = tempfile.TemporaryDirectory()
        folder = pathlib.Path(self._folder.name)
        self.address, self.local = f"unix:{folder}/socket", f"{folder}/local"
        self._process = subprocess.Popen([program, "--address", self.address, "--local-socket", self.local, "--device", "cpu:0",
                                          "--threads", "2", "--ready-file", folder / "ready", "--log-level", "error"])
        deadline = time.monotonic() + 30
        while not (folder / "ready").exists():
            if self._process.poll() is not None or time.monotonic() > deadline:
                self.close()
                raise RuntimeError("the daemon did not become ready")
            time.sleep(0.02)

    def close(self):
        self._process.kill()
        self._process.wait()
        self._folder.cleanup()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()
