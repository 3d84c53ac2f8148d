"""A daemon of this process's own, on a Unix socket with shared memory."""

from __future__ import annotations

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import threading
import time
import weakref

import collided.leftovers as leftovers
from collided.errors import FailedPrecondition, Unavailable
from collided.programs import find_program, where_to_get_it

_COMPILE_SECONDS = 1800.0  # a GPU's driver may have to compile the kernels
_READY_SECONDS, _STOP_SECONDS, _EXIT_SECONDS, _POLL_SECONDS = 60.0, 10.0, 0.1, 0.01
_SAID_LINES = 3  # of a daemon that does not start
# Ends the daemon when this process is gone, however it ended: then the pipe to standard input is closed. Not by
# PR_SET_PDEATHSIG, which goes by the thread that started the daemon.
_GUARD = ('exec 3<&0; "$@" </dev/null & daemon=$!; { cat >/dev/null; kill $daemon; } <&3 2>/dev/null & '
          "wait $daemon; code=$?; kill $! 2>/dev/null; exit $code")


def find_daemon() -> str:
    """The program: $COLLIDED_DAEMON, or one that a wheel brought along, or `collided` on PATH. Raises FailedPrecondition if there
    is none."""
    named = os.environ.get("COLLIDED_DAEMON")
    found = shutil.which(named) if named else find_program("collided")
    if found is None:
        raise FailedPrecondition(f"COLLIDED_DAEMON is {named!r}, which is not a program" if named else
                                 where_to_get_it("collided"))
    return found


def _environment() -> dict[str, str]:
    """Without the options of other daemons, such as COLLIDED_THREADS."""
    return {name: value for name, value in os.environ.items() if not name.startswith("COLLIDED_")}


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
        self._unless_removed: weakref.finalize | None = None
        self._starter = 0  # the process that started it
        self._folder = ""

    @property
    def address(self) -> str:
        """Raises Unavailable if the daemon does not become ready."""
        with self._lock:
            self._leave_to_parent()
            if self._process is None or self._process.poll() is not None:
                self._remove()
                self._start()
            return f"unix:{self._folder}/socket"

    @property
    def pid(self) -> int:
        """Of the process group that the daemon runs in; 0 if none runs."""
        return 0 if self._process is None else self._process.pid

    def stop(self) -> None:
        """Ends it; a later `address` starts another one."""
        with self._lock:
            self._leave_to_parent()
            if self._process is None:
                return
            assert self._process.stdin is not None
            self._process.stdin.close()
            try:
                self._process.wait(_STOP_SECONDS)
            except subprocess.TimeoutExpired:
                _kill(self._process)
                self._process.wait()
            self._remove()

    def _leave_to_parent(self) -> None:
        """In a forked process: the daemon is not its own."""
        if self._process is not None and self._starter != os.getpid():
            self._process, self._folder = None, ""

    def _start(self) -> None:
        if sys.platform != "linux":
            raise FailedPrecondition(where_to_get_it("collided"))
        program = self._program or find_daemon()
        is_long = len(tempfile.gettempdir()) > 80  # the path of a socket has at most 107 bytes
        self._folder = tempfile.mkdtemp(prefix="collided-", dir="/tmp" if is_long else None)
        ready = pathlib.Path(self._folder, "ready")
        log = pathlib.Path(self._folder, "log")
        command = [program, "--address", f"unix:{self._folder}/socket", "--local-socket", f"{self._folder}/local",
                   "--ready-file", str(ready), "--log-level", "warning", "--max-message-mb", "2047",
                   # Its only client may use everything.
                   "--max-scenes-per-client", "1000000", "--max-streams-per-client", "1000000",
                   "--max-device-mb-per-client", "16777216", "--max-frame-seconds", "1000000",
                   "--max-frames-per-second", "1000000000", *self._options]
        self._starter = os.getpid()
        with log.open("wb") as out:
            self._process = subprocess.Popen(["/bin/sh", "-c", _GUARD, "sh", *command], stdin=subprocess.PIPE,
                                             stdout=out, stderr=out, env=_environment(), start_new_session=True)
        _running[self._process] = self._folder
        leftovers.after_all(_end_all)
        self._unless_removed = weakref.finalize(self, _let_go, self._process)
        self._unless_removed.atexit = False
        start = time.monotonic()
        while not ready.exists():
            if self._process.poll() is not None or _is_late(start, log):
                said = _last_lines(log)
                self._process.kill()
                self._remove()
                raise Unavailable(f"daemon {program} did not become ready{': ' + said if said else ''}")
            time.sleep(_POLL_SECONDS)

    def _remove(self) -> None:
        if self._process is not None:
            _let_go(self._process)
            self._process.wait()
        if self._unless_removed is not None:
            self._unless_removed.detach()
        self._process = None
        if self._folder:
            shutil.rmtree(self._folder, ignore_errors=True)
        self._folder = ""


def _is_late(start: float, log: pathlib.Path) -> bool:
    """A daemon that says that kernels are being compiled has more time."""
    took = time.monotonic() - start
    if took <= _READY_SECONDS:
        return False
    return took > _COMPILE_SECONDS or "compiling the kernels" not in log.read_text(errors="replace")


def _last_lines(log: pathlib.Path) -> str:
    """The end of a daemon's log as one line, as collidectl has it. The advice to run it with --help is left out: nobody
    typed its command line."""
    lines = log.read_text(errors="replace").splitlines()
    return "; ".join([line for line in lines if line and not line.startswith("Run with --help")][-_SAID_LINES:])


_running: dict[subprocess.Popen[bytes], str] = {}  # daemons of this process, and their folders


def _let_go(process: subprocess.Popen[bytes]) -> None:
    """Has the daemon end, and waits for nothing."""
    folder = _running.pop(process, "")
    if process.stdin is not None and not process.stdin.closed:
        process.stdin.close()
    if folder:
        shutil.rmtree(folder, ignore_errors=True)


def _end_all() -> None:
    """At the end of the process, when nothing uses them any more. Those that take longer than the rest have nothing to lose."""
    processes = list(_running)
    for process in processes:
        _let_go(process)
    deadline = time.monotonic() + _EXIT_SECONDS
    for process in processes:
        try:
            process.wait(max(0.0, deadline - time.monotonic()))
        except subprocess.TimeoutExpired:
            _kill(process)


def _kill(process: subprocess.Popen[bytes]) -> None:
    """Kills the whole group: the shell that guards the daemon, and the daemon."""
    if sys.platform == "linux":
        os.killpg(process.pid, 9)


if sys.platform != "win32":  # where no process forks
    os.register_at_fork(after_in_child=_running.clear)
_shared: OwnDaemon | None = None
_shared_lock = threading.Lock()


def shared_daemon() -> OwnDaemon:
    """The one that everything in this process uses where no server is named."""
    global _shared
    with _shared_lock:
        if _shared is None:
            _shared = OwnDaemon()
        return _shared
