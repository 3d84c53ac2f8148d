"""collidectl interrupted in its own terminal, as a person would: what it reports and leaves behind.

Usage: interrupt_test.py COLLIDECTL DAEMON"""

import fcntl
import json
import os
import pty
import select
import signal
import subprocess
import tempfile
import termios
import time

import support
from support import COLLIDECTL, DAEMON, ONE_CPU


class Terminal:
    """collidectl with a terminal as its standard error and input, and a pipe as its standard output."""

    def __init__(self, folder, *words):
        self.master, slave = pty.openpty()
        env = {**os.environ, "COLLIDED_DAEMON": DAEMON, "TMPDIR": folder}
        self.process = subprocess.Popen([COLLIDECTL, *words], env=env, stdin=slave, stdout=subprocess.PIPE,
                                        stderr=slave, text=True, start_new_session=True,
                                        preexec_fn=self.take_terminal)
        os.close(slave)
        self.shown = ""

    @staticmethod
    def take_terminal():
        """Its control-C goes to the whole process group in front."""
        fcntl.ioctl(0, termios.TIOCSCTTY, 0)

    def read_some(self):
        """False at its end."""
        if not select.select([self.master], [], [], 60)[0]:
            raise AssertionError("nothing was shown for 60 s: " + self.shown)
        try:
            some = os.read(self.master, 4096).decode()
        except OSError:
            some = ""
        self.shown += some
        return some != ""

    def wait_for(self, part):
        while part not in self.shown and self.read_some():
            pass
        if part not in self.shown:
            raise AssertionError(f"{part} was not shown, but {self.shown}")

    def press_control_c(self):
        os.write(self.master, b"\x03")

    def end(self):
        """What was printed on standard output, once it has ended."""
        printed = self.process.stdout.read()
        while self.read_some():
            pass
        self.process.wait(timeout=60)
        self.process.stdout.close()
        os.close(self.master)
        return printed


class Interrupt(support.CollidectlTest):
    def interrupted(self, begun, *words):
        """What was printed. Nothing is left behind, and only collidectl's own output is shown."""
        with tempfile.TemporaryDirectory() as folder:
            terminal = Terminal(folder, *words, *ONE_CPU)
            terminal.wait_for(begun)
            daemon = self.child_of(terminal.process.pid)
            terminal.press_control_c()
            printed = terminal.end()
            self.assertEqual(terminal.process.returncode, 128 + signal.SIGINT, terminal.shown)
            self.assertEqual(os.listdir(folder), [])
        self.assertFalse(os.path.exists(f"/proc/{daemon}"))
        lines = terminal.shown.replace("^C", "").splitlines()
        self.assertEqual(lines[-1], "collidectl: interrupted by signal 2", terminal.shown)
        others = [part for line in lines[:-1] for part in line.split("\r") if part and " of " not in part]
        self.assertEqual(others, [], "neither the daemon nor a half line is shown")
        return printed

    @staticmethod
    def child_of(pid):
        with open(f"/proc/{pid}/task/{pid}/children", encoding="ascii") as file:
            return int(file.read().split()[0])

    def test_a_stream_tells_the_frames_so_far(self):
        endless = ["stream", "--scene", "funnel", "--scale", "0.2", "--frames", "1000000"]
        summary = json.loads(self.interrupted("frames: ", *endless, "--json"))
        self.assertGreater(summary["frames"], 0)
        self.assertLess(summary["frames"], 1000000)
        self.assertGreater(summary["median"]["step_ms"], 0)
        self.assertRegex(self.interrupted("frames: ", *endless), r"\nframes +[0-9,]+\n")

    def test_a_bench_tells_the_steps_so_far(self):
        endless = ["bench", "--scene", "funnel", "--scale", "0.2", "--steps", "1000000", "--warm-up", "0"]
        out = os.path.join(self.folder.name, "bench.json")
        printed = json.loads(self.interrupted("steps: ", *endless, "--json", "--out", out))
        self.assertGreater(printed["runs"][0]["steps"], 0)
        with open(out, encoding="ascii") as file:
            self.assertEqual(json.load(file), printed)

    def test_a_tradeoff_without_a_result_writes_none(self):
        out = os.path.join(self.folder.name, "out")
        words = ["tradeoff", "--scene", "funnel", "--scale", "0.2", "--repeats", "100000", "--out", out]
        self.assertEqual(self.interrupted("frames with f32 positions: ", *words), "")
        self.assertEqual(os.listdir(out), [])

    def test_an_export_keeps_the_files_so_far(self):
        out = os.path.join(self.folder.name, "frames")
        words = [COLLIDECTL, "export", "--scene", "funnel", "--frames", "1000000", "--dt", "0", "--out", out]
        with subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as process:
            while not os.path.exists(os.path.join(out, "funnel_0001.ply")):
                time.sleep(0.01)
            process.send_signal(signal.SIGINT)
            self.assertIn("collidectl: interrupted by signal 2\n", process.stderr.read())
        self.assertEqual(process.returncode, 128 + signal.SIGINT)
        sizes = {os.path.getsize(os.path.join(out, name)) for name in os.listdir(out)}
        self.assertEqual(len(sizes), 1, "no file is cut")


if __name__ == "__main__":
    support.main()
