"""What the tests of the viewer share: collidectl view on a scene of the Python package's tests.

Tests get these arguments: DAEMON COLLIDECTL REPOSITORY.
"""

import pathlib
import select
import signal
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(sys.argv[3]) / "tests" / "client" / "python"))
import collided  # noqa: E402
from support import COLLIDECTL, Case, main  # noqa: E402, F401
from web_client import WebSocket  # noqa: E402

PAGE = "<!doctype html><title>page</title>"
START_SECONDS = 60


class Viewer:
    """A running `collidectl view`; `url` is the page's address."""

    def __init__(self, *words, page=None):
        self.folder = tempfile.TemporaryDirectory()
        text = pathlib.Path(self.folder.name) / "page.html"
        text.write_text(PAGE)
        self.errors = open(pathlib.Path(self.folder.name) / "errors", "w+")
        self.process = subprocess.Popen([str(COLLIDECTL), "view", *words, "--page", page or str(text)], text=True,
                                        stdout=subprocess.PIPE, stderr=self.errors)
        readable, _, _ = select.select([self.process.stdout], [], [], START_SECONDS)
        self.url = self.process.stdout.readline().strip() if readable else ""
        if not self.url:
            said = self.said()
            self.close()
            raise AssertionError(f"collidectl view printed no address: {said}")

    def said(self):
        """What it wrote to standard error."""
        self.errors.seek(0)
        return self.errors.read()

    def interrupt(self):
        """The exit code."""
        self.process.send_signal(signal.SIGINT)
        return self.process.wait(60)

    def resident_bytes(self):
        status = pathlib.Path(f"/proc/{self.process.pid}/status").read_text()
        return 1024 * int(status.partition("VmRSS:")[2].split()[0])

    def close(self):
        self.process.kill()
        self.process.wait()
        self.process.stdout.close()
        self.errors.close()
        self.folder.cleanup()


class ViewerCase(Case):
    def view(self, *words, **options):
        viewer = Viewer(*words, **options)
        self.addCleanup(viewer.close)
        return viewer

    def view_session(self, session, *words, **options):
        return self.view(session.scene.id, "--server", self.server, *words, **options)

    def open(self, viewer, **headers):
        socket = WebSocket(viewer.url, **headers)
        self.addCleanup(socket.close)
        return socket

    def look_at(self, session, *words, viewer=None):
        """A page that has the scene, and sees each frame that is sent from now on, and the scene's message."""
        socket = self.open(viewer or self.view_session(session, *words))
        return socket, socket.until("scene")

    def last_frame(self, session):
        """Its id on the daemon, where a session's first step may take two frames."""
        with collided.Client(self.server) as client:
            return client.get_scene(session.scene.id).last_frame_id

    def run_view(self, *words):
        """Standard error and exit code of a view that must end by itself."""
        done = subprocess.run([str(COLLIDECTL), "view", *words], capture_output=True, text=True, timeout=60)
        return done.stderr, done.returncode
