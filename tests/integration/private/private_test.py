#!/usr/bin/env python3
"""A private daemon: it serves its parent alone, ends with it, and leaves nothing behind, whoever is killed.

usage: private_test.py DAEMON
"""

import contextlib
import fcntl
import os
import pathlib
import pty
import signal
import socket
import subprocess
import sys
import tempfile
import termios
import time
import unittest

PROGRAM = sys.argv[1]
SECONDS = 30  # a busy machine starts it in one
OPTIONS = ("--private", "--backend", "cpu", "--threads", "1")


class Private:
    """One that is starting, with its temporary folder in another one."""

    def __init__(self, folder, *options, stdin=subprocess.PIPE, before=None, **environment):
        self.process = subprocess.Popen([PROGRAM, *OPTIONS, *options], stdin=stdin, stdout=subprocess.PIPE,
                                        stderr=subprocess.STDOUT, text=True, preexec_fn=before,
                                        env={**os.environ, "TMPDIR": str(folder), **environment})
        self.said = ""

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.stdin:
            self.process.stdin.close()
        self.process.kill()
        self.process.wait()
        self.process.stdout.close()

    def ready(self):
        """Returns its addresses once it serves."""
        for line in self.process.stdout:
            self.said += line
            if line.startswith("ready "):
                return line.split()[1].split(",")
        raise AssertionError(self.said)

    def folder(self):
        return pathlib.Path(self.ready()[0].removeprefix("unix:")).parent

    def leave(self):
        """Ends as a parent does. Returns the exit code."""
        self.process.stdin.close()
        return self.end()

    def end(self):
        """Returns the exit code once neither it nor its tidy process is there."""
        self.said += self.process.stdout.read()
        return self.process.wait(SECONDS)


def children(pid):
    return [int(word) for word in pathlib.Path(f"/proc/{pid}/task/{pid}/children").read_text(encoding="ascii").split()]


def connect(address):
    with socket.socket(socket.AF_UNIX) as client:
        client.connect(address.removeprefix("unix:"))


def wait_for(condition):
    deadline = time.monotonic() + SECONDS
    while not condition() and time.monotonic() < deadline:
        time.sleep(0.01)
    return condition()


def is_running(pid):
    with contextlib.suppress(FileNotFoundError, ProcessLookupError):
        return pathlib.Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(") ")[2][0] != "Z"
    return False


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(dir="/tmp")
        self.addCleanup(folder.cleanup)
        self.place = pathlib.Path(folder.name)

    def start(self, *options, **more):
        daemon = Private(self.place, *options, **more)
        self.addCleanup(daemon.__exit__)
        return daemon

    def expect_nothing_left(self):
        self.assertEqual(list(self.place.iterdir()), [])

    def refused(self, message, *options, **more):
        daemon = self.start(*options, **more)
        self.assertEqual(daemon.end(), 2)
        self.assertIn(message, daemon.said)
        self.expect_nothing_left()


class Serves(Case):
    def test_on_sockets_in_a_folder_of_its_user_alone(self):
        daemon = self.start()
        folder = daemon.folder()
        self.assertEqual(folder.parent, self.place)
        self.assertEqual(folder.stat().st_mode & 0o7777, 0o700)
        self.assertTrue((folder / "local").is_socket())
        connect(str(folder / "socket"))
        self.assertEqual(daemon.said.splitlines()[:-1], [])  # its log begins at warnings
        (tidy,) = children(daemon.process.pid)
        self.assertEqual(pathlib.Path(f"/proc/{tidy}/comm").read_text(encoding="ascii"), "collided-tidy\n")
        self.assertEqual(daemon.leave(), 0)
        self.assertTrue(wait_for(lambda: not is_running(tidy)))
        self.expect_nothing_left()

    def test_no_longer_than_the_process_that_would_see_its_parent_go(self):
        daemon = self.start()
        folder = daemon.folder()
        (tidy,) = children(daemon.process.pid)
        os.kill(tidy, signal.SIGKILL)
        self.assertEqual(daemon.end(), 0)
        self.assertEqual(list(folder.iterdir()), [])
        folder.rmdir()

    def test_on_addresses_that_are_named_as_well(self):
        daemon = self.start("--address", "127.0.0.1:0", "--address", f"unix:{self.place}/mine", "--local-socket", f"{self.place}/shared")
        own, tcp, named = daemon.ready()
        self.assertRegex(tcp, r"^127\.0\.0\.1:\d+$")
        self.assertEqual(named, f"unix:{self.place}/mine")
        for address in (own, named):
            connect(address)
        self.assertTrue((self.place / "shared").is_socket())
        self.assertFalse(pathlib.Path(own.removeprefix("unix:")).with_name("local").exists())
        self.assertEqual(daemon.leave(), 0)

    def test_two_at_once(self):
        first, second = self.start(), self.start()
        places = [first.folder(), second.folder()]
        self.assertNotEqual(*places)
        self.assertEqual(first.leave(), 0)
        self.assertEqual(list(self.place.iterdir()), places[1:])
        connect(str(places[1] / "socket"))
        self.assertEqual(second.leave(), 0)
        self.expect_nothing_left()

    def test_without_variables_of_others(self):
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
            manager.bind(f"{self.place}/notify")
            daemon = self.start(COLLIDED_CONFIG="/none", COLLIDED_LOG_FORMAT="nonsense", COLLIDED_MAX_SCENES="many",
                                COLLIDED_ADDRESS="127.0.0.1:1", COLLIDED_LOCAL_SOCKET="/none", NOTIFY_SOCKET=f"{self.place}/notify")
            self.assertEqual(len(daemon.ready()), 1)
            self.assertEqual(daemon.leave(), 0)
            with self.assertRaises(BlockingIOError):
                manager.recv(1, socket.MSG_DONTWAIT)

    def test_a_reload_changes_no_address(self):
        file = self.place / "config.toml"
        file.write_text('log-level = "info"\n', encoding="ascii")
        daemon = self.start("--config", file)
        daemon.ready()
        daemon.process.send_signal(signal.SIGHUP)
        for line in daemon.process.stdout:
            if "configuration read again" in line:
                break
            daemon.said += line
        self.assertEqual(daemon.leave(), 0)
        self.assertNotIn("only after a restart", daemon.said)
        file.unlink()
        self.expect_nothing_left()

    def test_a_parent_that_reads_no_more(self):
        daemon = self.start("--log-level", "trace")
        address = daemon.ready()[0]
        daemon.process.stdout.close()
        for _ in range(10):
            connect(address)
        daemon.process.stdin.close()
        self.assertEqual(daemon.process.wait(SECONDS), 0)

    def test_where_the_temporary_folder_is_of_no_use(self):
        for place in ("/proc", "/nonexistent", "relative", f"{self.place}/{'long' * 20}", f"{self.place}/a,b", f"{self.place}/50%25"):
            with contextlib.suppress(OSError):
                if place.startswith("/tmp"):
                    os.mkdir(place)
            with self.subTest(place), Private(place) as daemon:
                folder = daemon.folder()
                self.assertEqual(folder.parent, pathlib.Path("/tmp"))
                self.assertEqual(daemon.leave(), 0)
                self.assertFalse(folder.exists())


class Refused(Case):
    def test_options_that_cannot_be(self):
        self.refused("--max-scenes", "--max-scenes", "0")
        self.refused("--nonsense", "--nonsense")
        self.refused("needs --tokens-file", "--tls-certificate", "/none", "--tls-key", "/none", "--tls-client-ca", "/none")
        self.refused("private was given a disallowed flag override", "--private=false")
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:
            file.write("private = true\n")
            file.flush()
            self.refused("private is not an option", "--config", file.name)

    def test_a_standard_input_that_never_closes(self):
        message = "collided: --private needs a pipe, a socket or a terminal as standard input"
        self.refused(message, before=lambda: os.close(0))
        self.refused(message, stdin=subprocess.DEVNULL)
        with open(__file__, encoding="utf-8") as file:
            self.refused(message, stdin=file)

    def test_a_place_where_no_folder_can_be_made(self):
        script = 'mount --bind /tmp /tmp && mount -o remount,ro,bind /tmp || exit 77; exec "$0" "$@"'
        done = subprocess.run(["unshare", "--mount", "sh", "-c", script, PROGRAM, *OPTIONS], input="", capture_output=True, text=True,
                              env={**os.environ, "TMPDIR": str(self.place)}, timeout=SECONDS)
        if done.returncode == 77 or "unshare" in done.stderr:
            self.skipTest(f"nothing can be mounted here: {done.stderr}")
        self.assertEqual(done.returncode, 1)
        self.assertIn("collided: no folder for sockets can be made in $TMPDIR or /tmp: Read-only file system", done.stderr)

    def test_nothing_is_made_for_a_check(self):
        daemon = self.start("--check")
        self.assertEqual(daemon.end(), 0)
        self.assertIn("the configuration is valid", daemon.said)
        self.expect_nothing_left()


class Ends(Case):
    def test_at_once_if_its_parent_has_gone_before(self):
        here, there = socket.socketpair()
        here.close()
        with there:
            self.assertEqual(self.start(stdin=there).end(), 0)
        self.expect_nothing_left()

    def test_with_a_socket_as_with_a_pipe(self):
        here, there = socket.socketpair()
        with here, there:
            daemon = self.start(stdin=there)
            daemon.ready()
            there.close()
            here.shutdown(socket.SHUT_WR)
            self.assertEqual(daemon.end(), 0)
        self.expect_nothing_left()

    def test_at_a_terminal_by_an_interrupt_and_with_it(self):
        def take_terminal():
            os.setsid()
            fcntl.ioctl(0, termios.TIOCSCTTY, 0)

        for is_interrupted in (True, False):
            master, slave = pty.openpty()
            daemon = self.start(stdin=slave, before=take_terminal)
            os.close(slave)
            daemon.ready()
            if is_interrupted:
                os.write(master, b"\x03")
                self.assertEqual(daemon.end(), 0)
            os.close(master)
            self.assertEqual(daemon.end(), 0)
            self.expect_nothing_left()

    def test_with_a_parent_that_is_killed(self):
        program = ("import os, subprocess, sys\n"
                   "daemon = subprocess.Popen(sys.argv[1:], stdin=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True)\n"
                   "assert daemon.stdout.readline().startswith(b'ready ')\n"
                   "print(daemon.pid, flush=True)\n"
                   "os.kill(os.getpid(), 9)\n")
        parent = subprocess.run([sys.executable, "-c", program, PROGRAM, *OPTIONS], capture_output=True, text=True,
                                env={**os.environ, "TMPDIR": str(self.place)}, timeout=SECONDS)
        self.assertEqual(parent.returncode, -signal.SIGKILL, parent.stderr)
        self.assertTrue(wait_for(lambda: not list(self.place.iterdir())))
        self.assertTrue(wait_for(lambda: not is_running(int(parent.stdout))))

    def test_by_signals_and_leaves_nothing(self):
        for number, code in ((signal.SIGTERM, 0), (signal.SIGINT, 0), (signal.SIGKILL, -signal.SIGKILL)):
            with self.subTest(number=number):
                daemon = self.start()
                daemon.ready()
                daemon.process.send_signal(number)
                self.assertEqual(daemon.end(), code)
                self.expect_nothing_left()

    def test_by_signals_to_its_whole_group(self):
        """The tidy process is not in the group. The daemon is not in the parent's, which the terminal interrupts."""
        daemon = self.start()
        daemon.ready()
        self.assertEqual(os.getpgid(daemon.process.pid), daemon.process.pid)
        os.killpg(daemon.process.pid, signal.SIGKILL)
        self.assertEqual(daemon.end(), -signal.SIGKILL)
        self.expect_nothing_left()

    def test_from_the_first_instant(self):
        for number in (signal.SIGKILL, signal.SIGTERM):
            for milliseconds in range(0, 60, 4):
                with self.subTest(number=number, milliseconds=milliseconds):
                    daemon = self.start()
                    time.sleep(milliseconds / 1000)
                    daemon.process.send_signal(number)
                    self.assertIn(daemon.end(), (0, -number))
                    self.expect_nothing_left()

    def test_one_that_hangs_is_killed(self):
        daemon = self.start("--grace-seconds", "0")
        daemon.ready()
        daemon.process.send_signal(signal.SIGSTOP)
        self.assertEqual(daemon.leave(), -signal.SIGKILL)
        self.expect_nothing_left()


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
