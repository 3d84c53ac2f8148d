"""A daemon for the tests of this folder."""

import pathlib
import subprocess
import tempfile
import time


class Daemon:
    """Serves on its own Unix socket after construction."""

    def __init__(self, program, *options):
        self.folder = tempfile.TemporaryDirectory()
        self.address = f"unix:{self.folder.name}/socket"
        ready = pathlib.Path(self.folder.name) / "ready"
        self.process = subprocess.Popen(
            [program, "--address", self.address, "--ready-file", ready, "--log-level", "error", *options])
        deadline = time.monotonic() + 30
        while not ready.exists():
            if self.process.poll() is not None or time.monotonic() > deadline:
                self.kill()
                raise RuntimeError("the daemon did not become ready")
            time.sleep(0.02)

    def stop(self):
        self.process.terminate()
        code = self.process.wait(60)
        assert code == 0, f"the daemon ended with {code}"

    def kill(self):
        """In any state, even if it has already ended."""
        self.process.kill()
        self.process.wait()
        self.folder.cleanup()
