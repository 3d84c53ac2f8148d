"""What the package's tests share: the daemon, its supervisor, and a scene whose contact is known.

The scene: a floor at z = 0, and above its inside a tip, which stands on its corner 0 (scene-wide vertex 3) at height 1.
Moved down by `depth`, the corner meets the floor at t = 1 / depth, and nothing else meets.

Tests get these arguments: DAEMON COLLIDECTL REPOSITORY.
"""

import contextlib
import faulthandler
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

try:
    import grpc
    import numpy as np
except ImportError as missing:
    print(f"skipped: {missing} (Debian: python3-grpcio, python3-numpy)")
    sys.exit(77)

DAEMON, COLLIDECTL, REPOSITORY = (pathlib.Path(argument) for argument in sys.argv[1:4])
sys.path.insert(0, str(REPOSITORY / "tests" / "interop"))
import collided  # noqa: E402
from collided.columns import COLUMNS  # noqa: E402
from daemon import Daemon  # noqa: E402

FLOOR = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0]], "<f4")
TIP = np.array([[1, 1, 1], [1.25, 1, 9], [1, 1.25, 9]], "<f4")
ONE = np.array([[0, 1, 2]], "<u4")
# Python's switches, by which a warning is an error. protobuf 3.21, which Debian 13 has, makes two of its own on Python 3.13.
STRICT = ("-W", "error", "-W", "ignore:Type google:DeprecationWarning", "-W", "ignore:datetime.datetime.utcfromtimestamp:DeprecationWarning")
# Debian 13's grpcio waits in os.fork() for its threads, which end with the stream (github.com/grpc/grpc/issues/31885).
skip_if_forks_hang = unittest.skipIf(grpc.__version__.startswith("1.51.") and sys.version_info >= (3, 13),
                                     "os.fork() beside a stream never returns with grpcio 1.51 on Python 3.13; PyPI's grpcio is well")
STREAMS = ("grpc", "shared_memory")
TRANSPORTS = (*STREAMS, "calls")


def lowered(depth):
    return TIP - np.array([0, 0, depth], "<f4")


def turned(axis, angle, translation=(0, 0, 0)):
    """The pose that turns by `angle`, in radians, about an axis through the origin, and then moves."""
    x, y, z = np.asarray(axis) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    rotation = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return np.hstack([rotation, np.reshape(translation, (3, 1))])


BODY = np.array([[0.9, 0.9, 1], [1.4, 1, 1.1], [1, 1.3, 1.2], [1.1, 1, 1.6]])  # above the floor's inside
SIDES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]], "<u4")


def body_turned(angle, depth):
    """The pose that turns the body about itself and moves it down."""
    middle = BODY.mean(axis=0)
    rotation = turned((1, 2, 2), angle)[:, :3]
    return np.hstack([rotation, (middle - rotation @ middle - [0, 0, depth])[:, None]])


def turning():
    """The floor, static, and a rigid body."""
    return {"floor": collided.Mesh(FLOOR, ONE, motion="static"), "body": collided.Mesh(BODY, SIDES, motion="rigid")}


def meshes(**tip):
    """The floor, static, and the tip, where they begin."""
    return {"floor": collided.Mesh(FLOOR, ONE, motion="static"), "tip": collided.Mesh(TIP, ONE, **tip)}


class Supervised:
    """A daemon that is started again, at the same place, whenever it ends."""

    def __init__(self, *options):
        self.folder = tempfile.TemporaryDirectory()
        self.address = f"unix:{self.folder.name}/socket"
        self._command = [DAEMON, "--address", self.address, "--local-socket", f"{self.folder.name}/local", "--log-level",
                         "error", "--ready-file", f"{self.folder.name}/ready", *options]
        self._stopping = threading.Event()
        self.process = None
        self._start_supervised()

    def _start_supervised(self):
        self._start()
        self._thread = threading.Thread(target=self._supervise, daemon=True)
        self._thread.start()

    def _start(self):
        ready = pathlib.Path(self.folder.name) / "ready"
        ready.unlink(missing_ok=True)
        self.process = subprocess.Popen(self._command)
        deadline = time.monotonic() + 30
        while not ready.exists() and time.monotonic() < deadline:
            time.sleep(0.01)

    def _supervise(self):
        while not self._stopping.wait(0.01):
            if self.process.poll() is not None:
                self._start()

    def kill(self):
        """As kill -9 would, in the middle of whatever it does."""
        process = self.process  # the supervisor may have started another one before wait()
        process.send_signal(signal.SIGKILL)
        process.wait()

    @contextlib.contextmanager
    def gone(self):
        """Nobody is there meanwhile."""
        self._stopping.set()
        self._thread.join()
        self.kill()
        yield
        self._stopping.clear()
        self._start_supervised()

    def freeze(self):
        """Stops it in the middle of whatever it does, until it is sent SIGCONT."""
        self.process.send_signal(signal.SIGSTOP)
        while pathlib.Path(f"/proc/{self.process.pid}/stat").read_text().rpartition(") ")[2][0] != "T":
            time.sleep(0.001)

    def close(self):
        self._stopping.set()
        self._thread.join()
        self.process.kill()
        self.process.wait()
        self.folder.cleanup()


class Case(unittest.TestCase):
    """Tests with a daemon of their class, which serves shared memory, too."""

    options = ()

    @classmethod
    def setUpClass(cls):
        cls.local = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.local.cleanup)
        cls.daemon = Daemon(str(DAEMON), "--local-socket", f"{cls.local.name}/local", *cls.options)
        cls.addClassCleanup(cls.daemon.kill)
        cls.server = cls.daemon.address

    def session(self, what=None, **options):
        """A session on the floor and the tip, or on other meshes."""
        if not isinstance(what, collided.Scene):
            options = {"server": self.server, **options}
        session = collided.Session(meshes() if what is None else what, **options)
        self.addCleanup(session.close)
        return session

    def expect_hit(self, contacts, depth):
        self.assertEqual(contacts.elements.tolist(), [[3, 0]])
        self.assertEqual(contacts.stencils.tolist(), [[3, 0, 1, 2]])
        np.testing.assert_allclose(contacts.toi, [1 / depth], atol=1e-3)
        self.assertEqual(contacts.earliest_toi, contacts.toi[0])

    def refused(self, kind, pattern, call, *arguments, **options):
        """The error that a call is refused with."""
        with self.assertRaisesRegex(kind, pattern) as caught:
            call(*arguments, **options)
        return caught.exception


def assert_same_columns(test, first, second):
    """Two lists of contacts have the same columns, to the bit."""
    for name in ("kinds", *COLUMNS):
        if name == "kinds" or first.has_column(name) or second.has_column(name):
            test.assertEqual(getattr(first, name).tobytes(), getattr(second, name).tobytes(), name)


def assert_same(test, first, second):
    """Two frames have the same contacts, to the bit."""
    assert_same_columns(test, first, second)
    test.assertEqual(first.limits.records.tobytes(), second.limits.records.tobytes(), "limits")
    test.assertEqual((first.earliest_toi, first.any_contact, first.advanced, first.way),
                     (second.earliest_toi, second.any_contact, second.advanced, second.way))
    for name in ("ids", "fractions"):
        test.assertEqual(getattr(first.shortened, name).tobytes(), getattr(second.shortened, name).tobytes(), f"shortened.{name}")


def main(seconds=200):
    faulthandler.dump_traceback_later(seconds, exit=True)  # where it hangs, before ctest ends it
    os.environ.pop("COLLIDED_SERVER", None)
    os.environ["COLLIDED_DAEMON"] = str(DAEMON)
    unittest.main(argv=sys.argv[:1], verbosity=2)
