"""A real HAProxy with the configuration that deploy/entrance writes, before a test's daemons.

Without HAProxy, a test that imports this ends as skipped.
"""

import os
import pathlib
import random
import re
import shutil
import socket
import subprocess
import sys
import tempfile
import time

from ops_daemon import http  # without gRPC for Python the test ends as skipped here

HAPROXY = shutil.which("haproxy", path=f"{os.environ.get('PATH', '')}:/usr/sbin")
if not HAPROXY:
    print("skipped: haproxy is not installed (Debian: haproxy)")
    sys.exit(77)

WRITER = pathlib.Path(__file__).resolve().parents[3] / "deploy" / "entrance" / "entrance"
PATIENCE = 60
PORT, HTTP_PORT = 50551, 9465


def wait_for(condition, what):
    deadline = time.monotonic() + PATIENCE
    while not condition():
        if time.monotonic() > deadline:
            raise TimeoutError(what)
        time.sleep(0.01)


def loopback_net():
    """Returns the first three numbers of loopback addresses that nobody else uses, so that fixed ports are free there."""
    return f"127.{random.randint(1, 254)}.{random.randint(0, 255)}"


class HaProxy:
    """HAProxy with one configuration, whose text names `control` as its admin socket."""

    def __init__(self, folder, text):
        self.folder, self.control = folder, folder / "admin.sock"
        self.config = folder / "haproxy.cfg"
        self.config.write_text(text)
        with open(folder / "haproxy.log", "wb") as log:
            self.process = subprocess.Popen([HAPROXY, "-db", "-f", str(self.config)], stdout=log, stderr=log)
        wait_for(lambda: self.control.exists() or self.process.poll() is not None, "start of HAProxy")
        if self.process.poll() is not None:
            raise RuntimeError(self.log())

    def log(self):
        return (self.folder / "haproxy.log").read_text()

    def ask(self, command):
        """Returns the answer to a command of the runtime API."""
        with socket.socket(socket.AF_UNIX) as control:
            control.settimeout(PATIENCE)
            control.connect(str(self.control))
            control.sendall(command.encode() + b"\n")
            answer = b""
            while part := control.recv(65536):
                answer += part
        return answer.decode()

    def states(self, backend):
        """Returns the state of each server of a backend: UP, DOWN, NOLB."""
        rows = [line.split(",") for line in self.ask(f"show stat {backend} 4 -1").splitlines() if line]
        status = rows[0].index("status")
        return {row[1]: row[status].split()[0] for row in rows[1:]}

    def close(self):
        self.process.kill()
        self.process.wait()


def written(*options):
    """Returns the configuration that these options make."""
    return subprocess.run([WRITER, *options], check=True, capture_output=True, text=True, timeout=PATIENCE).stdout


class Entrance(HaProxy):
    """Serves `daemons`, each NAME=ADDRESS,HTTP_ADDRESS.

    options: further options of the writer. limits: values that replace those of its `presetenv` lines. edits: replacements of
    other text of the configuration.
    """

    def __init__(self, daemons, *options, host=None, limits=None, edits=None, user="", group=""):
        self._folder = tempfile.TemporaryDirectory()
        folder = pathlib.Path(self._folder.name)
        if user:
            folder.chmod(0o711)  # it finds its socket there
        self.host = host or f"{loopback_net()}.9"
        self.address, self.http_address = f"{self.host}:{PORT}", f"{self.host}:{HTTP_PORT}"
        words = [word for daemon in daemons for word in ("--daemon", daemon)]
        text = written(*words, *options, "--listen", self.address, "--http", self.http_address, "--user", user, "--group", group,
                       "--calls-socket", str(folder / "calls.sock"), "--admin-socket", str(folder / "admin.sock"))
        for name, value in (limits or {}).items():
            text, count = re.subn(rf"(presetenv {name}) \d+\b", rf"\1 {value}", text)
            assert count == 1, name
        for old, new in (edits or {}).items():
            assert old in text, old
            text = text.replace(old, new)
        super().__init__(folder, text)

    def http(self, path):
        return http(self.http_address, path)

    def close(self):
        super().close()
        self._folder.cleanup()
