#!/usr/bin/env python3
"""The daemon starts or says why it cannot, whatever the limits are, and SIGTERM ends it while it starts.

usage: start_test.py DAEMON
"""

import contextlib
import fcntl
import os
import pathlib
import re
import resource
import signal
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from ops_daemon import SERVICE  # noqa: E402

import grpc  # noqa: E402

PROGRAM = sys.argv[1]
SECONDS = 20  # a busy machine starts it in one
MEBIBYTE = 1 << 20
NOBODY = 65534
PIDS = pathlib.Path("/sys/fs/cgroup/pids")


class Start:
    """A daemon that is starting, on a free port."""

    def __init__(self, *options, before=lambda: None, program=()):
        self.folder = tempfile.TemporaryDirectory()
        os.chmod(self.folder.name, 0o777)
        self.ready = os.path.join(self.folder.name, "ready")
        command = [*program, PROGRAM, "--backend", "cpu", "--address", "127.0.0.1:0", "--ready-file", self.ready, *options]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, preexec_fn=before)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()
        self.process.stdout.close()
        self.folder.cleanup()

    def wait(self):
        """Returns True once it serves, and False if it has ended."""
        deadline = time.monotonic() + SECONDS
        while not os.path.exists(self.ready):
            if self.process.poll() is not None:
                return False
            if time.monotonic() > deadline:
                raise TimeoutError("it neither serves nor ends")
            time.sleep(0.005)
        return True

    def call(self):
        """Makes a call, as a first client does."""
        address = pathlib.Path(self.ready).read_text(encoding="ascii").split()[0]
        with contextlib.closing(grpc.insecure_channel(address, [("grpc.use_local_subchannel_pool", 1)])) as channel:
            channel.unary_unary(f"/{SERVICE}/GetServerInfo")(b"", timeout=SECONDS)

    def stop(self):
        """Returns its exit code and what it said, after SIGTERM."""
        self.process.terminate()
        said, _ = self.process.communicate(timeout=SECONDS)
        return self.process.returncode, said


def limit(name, value):
    def set_limit():
        if name == resource.RLIMIT_NPROC and os.geteuid() == 0:  # which it does not bind
            os.setgroups([])
            os.setgid(NOBODY)
            os.setuid(NOBODY)
        resource.setrlimit(name, (value, value))
    return set_limit


class Limits(unittest.TestCase):
    def sweep(self, pattern, values, start):
        """Starts it under each limit: it serves, or says what it needs and has. Returns the smallest limit under which it serves."""
        served = []
        for value in values:
            with self.subTest(value=value), start(value) as daemon:
                if daemon.wait():
                    served.append(value)
                    daemon.call()
                    self.assertEqual(daemon.stop()[0], 0)
                else:
                    said, _ = daemon.process.communicate()
                    self.assertEqual(daemon.process.returncode, 1, said)
                    self.assertRegex(said, pattern)
        self.assertTrue(0 < len(served) < len(values), served)
        return served[0]

    def need(self, name, unit, pattern):
        """What it says that it needs."""
        with Start(before=limit(name, 80 * unit if unit > 1 else 5)) as daemon:
            said, _ = daemon.process.communicate(timeout=SECONDS)
        return int(re.search(pattern, said)[1])

    def test_of_address_space(self):
        pattern = r"^collided: RLIMIT_AS is \d+ MiB, but the daemon needs (\d+) MiB of address space to start"
        need = self.need(resource.RLIMIT_AS, MEBIBYTE, pattern)
        mapped = pathlib.Path(PROGRAM).stat().st_size // MEBIBYTE + 40  # with its libraries, before it can say anything
        values = sorted({mapped, 120, 180, *range(240, 341, 20), need - 10, need + 10})
        self.sweep(pattern, values, lambda value: Start(before=limit(resource.RLIMIT_AS, value * MEBIBYTE)))

    def test_of_data(self):
        pattern = r"^collided: RLIMIT_DATA is \d+ MiB, but the daemon needs (\d+) MiB of data to start"
        need = self.need(resource.RLIMIT_DATA, MEBIBYTE, pattern)
        values = sorted({10, 40, 80, 120, 200, need - 10, need + 10})
        self.sweep(pattern, values, lambda value: Start(before=limit(resource.RLIMIT_DATA, value * MEBIBYTE)))

    def test_of_the_users_processes(self):
        pattern = r"^collided: the daemon needs (\d+) threads to start, but only \d+ could be started: .*RLIMIT_NPROC, for all .*, is \d+"
        try:
            need = self.need(resource.RLIMIT_NPROC, 1, pattern)
        except PermissionError as error:
            self.skipTest(f"nobody may not run the daemon here: {error}")
        # Others' processes of the same user count as well.
        values = sorted({2, 5, *range(10, 18, 2), need // 2, need - 2, need + 4000})
        self.sweep(pattern, values, lambda value: Start(before=limit(resource.RLIMIT_NPROC, value)))

    def test_of_its_cgroup(self):
        group = PIDS / f"collided-test-{os.getpid()}"
        try:
            group.mkdir()
        except OSError as error:
            self.skipTest(f"no cgroup can be made: {error}")
        self.addCleanup(group.rmdir)
        pattern = r"^collided: the daemon needs (\d+) threads to start, but only \d+ could be started: pids\.max of its cgroup is \d+"

        def start(value):
            (group / "pids.max").write_text(str(value), encoding="ascii")
            return Start(before=lambda: (group / "cgroup.procs").write_text(str(os.getpid()), encoding="ascii"))

        with start(8) as daemon:
            need = int(re.search(pattern, daemon.process.communicate(timeout=SECONDS)[0])[1])
        self.sweep(pattern, [3, 10, 12, 14, 16, need, need + 1], start)


class Termination(unittest.TestCase):
    def test_from_the_first_instant(self):
        for milliseconds in range(0, 60, 3):
            with self.subTest(milliseconds=milliseconds), Start() as daemon:
                time.sleep(milliseconds / 1000)
                code, said = daemon.stop()
                self.assertIn(code, (0, -signal.SIGTERM), said)  # the latter before the program itself runs

    def test_while_it_waits_for_something(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        handle = os.open(folder.name, os.O_RDONLY)
        self.addCleanup(os.close, handle)
        fcntl.flock(handle, fcntl.LOCK_EX)  # which it waits for, 5 s at most, before it claims the path
        with Start("--address", f"unix:{folder.name}/socket") as daemon:
            time.sleep(1)
            self.assertIsNone(daemon.process.poll())
            began = time.monotonic()
            self.assertEqual(daemon.stop()[0], 0)
            self.assertLess(time.monotonic() - began, 2)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
