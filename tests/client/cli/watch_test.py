"""collidectl watch: lines and JSON of a scene that someone else plays, and how it ends.

Usage: watch_test.py COLLIDECTL DAEMON"""

import contextlib
import fcntl
import json
import os
import pty
import re
import select
import signal
import struct
import subprocess
import termios
import time

import support
from support import COLLIDECTL, DAEMON

LINE = re.compile(r"frame (\d+): (\d+) contacts \(\d+ vt, \d+ ee, \d+ tt\), earliest \S+, \S+ ms, (\d+) skipped\n")


class Watched(support.CollidectlTest):
    """A daemon, and scenes that others play."""

    def setUp(self):
        super().setUp()
        self.socket, self.log, ready = (os.path.join(self.folder.name, name) for name in ("s", "log", "ready"))
        words = [DAEMON, "--address", "unix:" + self.socket, "--backend", "cpu", "--threads", "1"]
        with open(self.log, "w", encoding="utf-8") as log:
            self.daemon_process = self.start(*words, "--ready-file", ready, stdout=log, stderr=log)
        while self.daemon_process.poll() is None and not os.path.exists(ready):
            time.sleep(0.01)
        self.server = ["--server", "unix:" + self.socket]

    def start(self, *words, stdout=subprocess.PIPE, stderr=subprocess.PIPE):
        process = subprocess.Popen(words, stdout=stdout, stderr=stderr, text=True)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        for pipe in (process.stdout, process.stderr):
            if pipe:
                self.addCleanup(pipe.close)
        return process

    def created(self):
        """Ids of the scenes that were created so far."""
        with open(self.log, encoding="utf-8") as file:
            return re.findall(r"scene created.*?\b([0-9a-f]{32})\b", file.read())

    def play(self, *options):
        """The process that plays a scene, and the scene's id."""
        before = len(self.created())
        stream = self.start(COLLIDECTL, "stream", "--scene", "reef_knot", "--scale", "0.2", "--frames", "1000000",
                            *self.server, *options)
        while stream.poll() is None:
            if len(self.created()) > before:
                return stream, self.created()[-1]
            time.sleep(0.01)
        self.fail(stream.stderr.read())


class Lists(Watched):
    def test_without_a_scene_those_of_the_daemon_are_listed(self):
        done = support.ctl("watch", *self.server)
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", "the daemon has no scene that can be watched\n"))
        scenes = sorted(self.play()[1] for _ in range(2))
        for words in ([], ["--list"]):
            lines = self.ok("watch", *words, *self.server).splitlines()
            self.assertEqual([line.split()[0] for line in lines], scenes)
            self.assertRegex(lines[0], r"^[0-9a-f]{32}  reef_knot, \d+ mesh(es)?, [0-9,]+ triangles, frame \d+$")
        listed = [json.loads(line) for line in self.ok("watch", "--json", *self.server).splitlines()]
        self.assertEqual([(scene["id"], scene["name"]) for scene in listed], [(scene, "reef_knot") for scene in scenes])
        self.ok("watch", listed[0]["id"], "--frames", "1", *self.server)


class Lines(Watched):
    def test_each_frame_is_a_line(self):
        scene = self.play()[1]
        lines = self.ok("watch", scene, "--frames", "5", *self.server).splitlines(keepends=True)
        self.assertEqual(len(lines), 5)
        frames = [[int(number) for number in LINE.fullmatch(line).groups()] for line in lines]
        for (before, _, _), (frame, _, skipped) in zip(frames, frames[1:]):
            self.assertEqual(frame, before + skipped + 1)

    def test_json_has_a_frame_in_each_line(self):
        scene = self.play()[1]
        printed = self.ok("watch", scene, "--frames", "3", "--interval", "4", "--json", *self.server)
        frames = [json.loads(line) for line in printed.splitlines()]
        self.assertEqual(len(frames), 3)
        for frame in frames:
            self.assertGreaterEqual(frame["skipped_frames"], 3)
            self.assertGreater(frame["total_ms"], 0)
            self.assertIn("contacts_vertex_triangle", frame["counts"])
            self.assertIn("earliest_toi", frame)

    def test_it_ends_with_the_scene(self):
        stream, scene = self.play()
        watch = self.start(COLLIDECTL, "watch", scene, *self.server)
        self.assertTrue(LINE.fullmatch(watch.stdout.readline()))
        stream.send_signal(signal.SIGINT)  # deletes the scene
        _, errors = watch.communicate(timeout=60)
        self.assertEqual((watch.returncode, errors), (0, ""))

    def test_an_interrupt_ends_it(self):
        watch = self.start(COLLIDECTL, "watch", self.play()[1], *self.server)
        self.assertTrue(LINE.fullmatch(watch.stdout.readline()))
        watch.send_signal(signal.SIGINT)
        _, errors = watch.communicate(timeout=60)
        self.assertEqual(watch.returncode, 128 + signal.SIGINT, errors)

    def test_what_cannot_be_watched_is_refused(self):
        self.refused(2, "--server", "watch", "0123")
        self.refused(2, "--record needs SCENE", "watch", "--record", "x.rec", "--mesh", self.frame0, *self.server)
        self.refused(2, "--list takes no SCENE", "watch", "0123", "--list", *self.server)
        self.refused(1, "scene_id", "watch", "none", *self.server)
        self.refused(2, "the id has a character that is not visible ASCII", "watch", b"\xff", *self.server)
        self.refused(2, "the id has a character that is not visible ASCII", "view", b"\xff", *self.server)
        for frames in ("-1", "18446744073709551616"):
            self.refused(2, "--frames", "watch", "0123", f"--frames={frames}", *self.server)
        self.refused(1, "max_frames_per_second", "watch", self.play()[1], "--rate", "-1", *self.server)

    def test_a_table_is_for_terminals(self):
        self.refused(2, "--table needs a terminal", "watch", "0123", "--table", *self.server)
        self.refused(2, "one of --table, --plain and --json", "watch", "0123", "--plain", "--json", *self.server)


class Terminal:
    """A pseudo-terminal of which a process is the only one in the foreground."""

    def __init__(self, *words, term="xterm-256color", rows=40, columns=100):
        self.master, self.slave = pty.openpty()
        self.resize(rows, columns)
        self.before = termios.tcgetattr(self.slave)
        self.text = b""
        env = {**os.environ, "TERM": term, "LANG": "C.UTF-8", "LC_ALL": "C.UTF-8"}
        self.process = subprocess.Popen(words, stdin=self.slave, stdout=self.slave, stderr=self.slave, env=env,
                                        start_new_session=True, preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0))

    def resize(self, rows, columns):
        fcntl.ioctl(self.master, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))

    def read(self):
        """Reads some more of what the process shows; False if it shows nothing for a while."""
        if not select.select([self.master], [], [], 0.2)[0]:
            return False
        self.text += os.read(self.master, 65536)
        return True

    def wait_for(self, word, after=0):
        """Where the word is shown, after a place in the text."""
        deadline = time.monotonic() + 120
        while word not in self.text[after:]:
            if time.monotonic() > deadline:
                raise AssertionError(f"{word!r} is not shown: {self.text[after:]!r}")
            self.read()
        return self.text.index(word, after)

    def type(self, keys):
        os.write(self.master, keys)

    def end(self):
        """The exit code, after everything is read."""
        deadline = time.monotonic() + 120
        while (self.process.poll() is None or self.read()) and time.monotonic() < deadline:
            self.read()
        return self.process.returncode

    def close(self):
        self.process.kill()
        self.process.wait()
        os.close(self.master)
        os.close(self.slave)


ENTERED, LEFT = b"\x1b[?1049h", b"\x1b[?1049l"


class Table(Watched):
    """On a terminal."""

    @contextlib.contextmanager
    def watching(self, *options, **terminal):
        stream, scene = self.play()
        shown = Terminal(COLLIDECTL, "watch", scene, *self.server, *options, **terminal)
        try:
            yield shown, stream
        finally:
            shown.close()

    def assert_given_back(self, shown):
        """The screen and the terminal's settings; the last table stays."""
        left = shown.text.rindex(LEFT)
        self.assertIn(b"frames/s", shown.text[left:])
        self.assertIn(b"\x1b[?25h", shown.text, "the cursor is shown")
        self.assertGreater(shown.text.rindex(b"\x1b[?25h"), shown.text.rindex(b"\x1b[?25l"))
        self.assertEqual(termios.tcgetattr(shown.slave), shown.before)

    def test_a_table_follows_the_frames_until_an_interrupt(self):
        with self.watching() as (shown, _):
            shown.wait_for(b"median", shown.wait_for(ENTERED))
            for word in (b"frames/s", b"total", b"contacts", b"device_bytes", "▁".encode()):
                shown.wait_for(word)
            shown.type(b"\x03")  # Ctrl-C
            self.assertEqual(shown.end(), 128 + signal.SIGINT)
            self.assert_given_back(shown)

    def test_the_table_fits_when_the_window_changes(self):
        with self.watching() as (shown, _):
            at = shown.wait_for(b"device_bytes")
            shown.resize(10, 60)
            shown.wait_for(b"larger", at)
            at = len(shown.text)
            shown.resize(60, 100)
            shown.wait_for(b"device_bytes", at)
            shown.type(b"q")
            self.assertEqual(shown.end(), 0)
            self.assert_given_back(shown)

    def test_two_interrupts_at_once_give_the_terminal_back_too(self):
        with self.watching() as (shown, _):
            shown.wait_for(b"median")
            for _ in range(2):
                shown.process.send_signal(signal.SIGTERM)
            self.assertEqual(shown.end(), 128 + signal.SIGTERM)
            self.assertGreater(shown.text.rindex(LEFT), shown.text.rindex(ENTERED))
            self.assertEqual(termios.tcgetattr(shown.slave), shown.before)

    def test_a_table_ends_with_the_scene_and_with_the_frames(self):
        with self.watching() as (shown, stream):
            shown.wait_for(b"median")
            stream.send_signal(signal.SIGINT)  # deletes the scene
            self.assertEqual(shown.end(), 0)
            self.assert_given_back(shown)
        with self.watching("--frames", "3") as (shown, _):
            self.assertEqual(shown.end(), 0)
            self.assertIn(b"last 3 frames", shown.text)

    def test_lines_on_a_terminal(self):
        for options, terminal in ((["--plain"], {}), ([], {"term": "dumb"})):
            with self.watching("--frames", "2", *options, **terminal) as (shown, _):
                self.assertEqual(shown.end(), 0)
                self.assertNotIn(ENTERED, shown.text)
                self.assertEqual(len(LINE.findall(shown.text.decode().replace("\r", ""))), 2)


class Record(Watched):
    """What a watch records, and what a replay of it finds."""

    def setUp(self):
        super().setUp()
        self.recording = os.path.join(self.folder.name, "live.rec")
        self.ok("export", "--scene", "reef_knot", "--scale", "0.2", "--frames", "1", "--out", self.folder.name)
        self.mesh = ["--mesh", os.path.join(self.folder.name, "reef_knot_0000.ply")]

    def recorded(self, frames, *options):
        """What was seen live, and in the replay, by frame."""
        scene = self.play("--t0", "0.5", "--dt", "0.00001", "--thickness", "0.02", *options)[1]
        words = ["watch", scene, "--record", self.recording, *self.mesh, "--frames", str(frames), "--json", *self.server]
        done = support.ctl(*words)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(f"recorded {frames} frames in {self.recording}\n", done.stderr)
        live = [json.loads(line) for line in done.stdout.splitlines()]
        replayed = json.loads(self.ok("replay", self.recording, *support.ONE_CPU, "--json"))["per_frame"]
        self.assertEqual([frame["frame"] for frame in live], [frame["frame"] for frame in replayed])
        return live, replayed, done.stderr

    def compare(self, live, replayed):
        names = ("contact_count", "contacts_digest", "earliest_toi")
        self.assertEqual([live.get(name) for name in names], [replayed.get(name) for name in names])
        self.assertGreater(live["contact_count"], 0)

    def test_a_replay_finds_what_was_seen(self):
        for format in ("f32", "f64"):
            live, replayed, errors = self.recorded(30, "--position-format", format)
            gaps = sum(frame["skipped_frames"] > 0 for frame in live[1:])
            self.assertEqual(f"in {gaps} gaps" in errors, gaps > 0, errors)
            followers = [(a, b) for a, b in list(zip(live, replayed))[1:] if a["skipped_frames"] == 0]
            self.assertGreater(len(followers), 0)
            for pair in followers:
                self.compare(*pair)

    def test_frames_without_motion_are_the_same_after_a_gap_too(self):
        live, replayed, errors = self.recorded(10, "--mode", "dcd")
        for pair in zip(live, replayed):
            self.compare(*pair)
        self.assertNotIn("stands still", errors)

    def test_an_interrupt_leaves_a_whole_recording(self):
        scene = self.play()[1]
        watch = self.start(COLLIDECTL, "watch", scene, "--record", self.recording, *self.mesh, *self.server)
        self.assertTrue(LINE.fullmatch(watch.stdout.readline()))
        watch.send_signal(signal.SIGINT)
        self.assertIn("recorded ", watch.communicate(timeout=60)[1])
        self.assertEqual(watch.returncode, 128 + signal.SIGINT)
        self.assertGreaterEqual(json.loads(self.ok("replay", self.recording, *support.ONE_CPU, "--json"))["frames"], 1)

    def test_the_end_of_the_scene_leaves_a_whole_recording(self):
        stream, scene = self.play()
        watch = self.start(COLLIDECTL, "watch", scene, "--record", self.recording, *self.mesh, "--json", *self.server)
        self.assertIn("frame", json.loads(watch.stdout.readline()))
        stream.send_signal(signal.SIGINT)  # deletes the scene
        self.assertIn("recorded ", watch.communicate(timeout=60)[1])
        self.assertEqual(watch.returncode, 0)
        self.assertGreaterEqual(json.loads(self.ok("replay", self.recording, *support.ONE_CPU, "--json"))["frames"], 1)

    def test_what_cannot_be_recorded_is_refused(self):
        scene = self.play()[1]
        record = ["watch", scene, "--record", self.recording]
        self.refused(2, "--record requires --mesh", *record, *self.server)
        self.refused(2, "--mesh requires --record", "watch", scene, *self.mesh, *self.server)
        self.refused(2, "--record needs every frame", *record, *self.mesh, "--interval", "2", *self.server)
        self.refused(1, "--record: the mesh files have 6 vertices", *record, "--mesh", self.frame0, *self.server)
        self.refused(2, "standard output (-) is none", "watch", scene, "--record", "-", *self.mesh, *self.server)


if __name__ == "__main__":
    support.main()
