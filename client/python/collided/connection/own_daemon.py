"""A daemon of this process's own, on a Unix socket with shared memory."""

from __future__ import annotations

import contextlib
import os
import re
import selectors
import shutil
import subprocess
import sys
import threading
import time
import weakref

import collided.leftovers as leftovers
from collided.errors import FailedPrecondition, Unavailable
from collided.programs import find_program, where_to_get_it

_COMPILE_SECONDS = 1800.0  # a GPU's driver may have to compile the kernels
_READY_SECONDS, _STOP_SECONDS, _EXIT_SECONDS = 60.0, 10.0, 0.1
_SAID_LINES = 3  # of a daemon that does not start


def find_daemon() -> str:
    """The program: $COLLIDED_DAEMON, or one that a wheel brought along, or `collided` on PATH. Raises FailedPrecondition if there
    is none."""
    named = os.environ.get("COLLIDED_DAEMON")
    found = shutil.which(named) if named else find_program("collided")
    if found is None:
        raise FailedPrecondition(f"COLLIDED_DAEMON is {named!r}, which is not a program" if named else
                                 where_to_get_it("collided"))
    return found


class OwnDaemon:
    """Runs until it is stopped, or this process ends. `address` starts it, and starts it again if it has ended.

    Its options are those that are given, and no variables of the environment, such as COLLIDED_THREADS.
    """

    def __init__(self, *options: str, program: str | None = None) -> None:
        """options: more of the daemon's, such as "--backend", "cpu". program: None: as find_daemon() finds it."""
        self._options = options
        self._program = program
        self._lock = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._address = ""

    @property
    def address(self) -> str:
        """Raises Unavailable if the daemon does not become ready."""
        with self._lock:
            if self.pid == 0 or self._process is None or self._process.poll() is not None:
                _end(self._process)
                self._start()
            return self._address

    @property
    def pid(self) -> int:
        """The process group that the daemon runs in; 0 if none runs, and in a forked process, whose parent has the daemon."""
        return self._process.pid if self._process is not None and self._process in _running else 0

    def stop(self) -> None:
        """Ends it; a later `address` starts another one."""
        with self._lock:
            _end(self._process)

    def _start(self) -> None:
        if sys.platform != "linux":
            raise FailedPrecondition(where_to_get_it("collided"))
        program = self._program or find_daemon()
        self._process = subprocess.Popen([program, "--private", *self._options], bufsize=0, stdin=subprocess.PIPE,
                                         stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True)
        _running.add(self._process)
        leftovers.after_all(_end_all)
        weakref.finalize(self, _let_go, self._process).atexit = False
        try:
            self._address = _wait_until_ready(self._process, program)
        except BaseException:
            _end(self._process, seconds=0)
            raise


def _wait_until_ready(process: subprocess.Popen[bytes], program: str) -> str:
    """Returns the daemon's address. Its log is not read any further: the daemon waits for no reader."""
    assert process.stdout is not None
    start, said, patience = time.monotonic(), "", _READY_SECONDS
    with selectors.DefaultSelector() as output:
        output.register(process.stdout, selectors.EVENT_READ)
        while not (ready := re.search("^ready ([^,\n]+).*\n", said, re.MULTILINE)):
            is_late = not output.select(max(0.0, start + patience - time.monotonic()))
            more = b"" if is_late else process.stdout.read(1 << 16)
            if not more:
                raise _failure(program, said)
            said += more.decode(errors="replace")
            if "compiling the kernels" in said:
                patience = _COMPILE_SECONDS
    return ready[1]


def _failure(program: str, said: str) -> Exception:
    """Returns an error with the last lines of the daemon's log. It leaves out the advice to run the daemon with --help, since
    nobody typed its command line."""
    if re.search("not expected: .*--private", said):
        return FailedPrecondition(f"a private daemon must be of release 0.2.0 or later, and {program} is older")
    last = [line for line in said.splitlines() if line and not line.startswith("Run with --help")][-_SAID_LINES:]
    return Unavailable(": ".join([f"daemon {program} did not become ready", *filter(None, ["; ".join(last)])]))


_running: set[subprocess.Popen[bytes]] = set()  # daemons of this process, which are none of its forked ones


def _let_go(process: subprocess.Popen[bytes]) -> None:
    """Has the daemon end, and waits for nothing. In a forked process: has it wait for the parent's end alone."""
    _running.discard(process)
    for pipe in filter(None, (process.stdin, process.stdout)):
        pipe.close()


def _end(process: subprocess.Popen[bytes] | None, seconds: float = _STOP_SECONDS) -> None:
    """Returns once the daemon and its folder are gone. It is killed, with its process group, if it takes longer than that."""
    if process is None or process not in _running:
        return
    _running.discard(process)
    with contextlib.suppress(subprocess.TimeoutExpired, ProcessLookupError):
        try:
            process.communicate(timeout=seconds)
        except subprocess.TimeoutExpired:
            if sys.platform == "linux":
                os.killpg(process.pid, 9)
            process.communicate(timeout=_STOP_SECONDS)


def _end_all() -> None:
    """At the end of the process, when nothing uses them any more. Those that take longer than the rest have nothing to lose."""
    for process in _running.copy():
        _end(process, _EXIT_SECONDS)


def _let_all_go() -> None:
    for process in _running.copy():
        _let_go(process)


if sys.platform != "win32":  # where no process forks
    os.register_at_fork(after_in_child=_let_all_go)
_shared: OwnDaemon | None = None
_shared_lock = threading.Lock()


def shared_daemon() -> OwnDaemon:
    """The one that everything in this process uses where no server is named."""
    global _shared
    with _shared_lock:
        if _shared is None:
            _shared = OwnDaemon()
        return _shared
