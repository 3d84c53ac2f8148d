"""collidectl watch: lines and JSON of a scene that someone else plays, and how it ends.

Usage: watch_test.py COLLIDECTL DAEMON"""

import json
import os
import re
import signal
import subprocess
import time

import support
from support import COLLIDECTL, DAEMON

LINE = re.compile(r"frame (\d+): (\d+) contacts \(\d+ vt, \d+ ee, \d+ tt\), earliest \S+, \S+ ms, (\d+) skipped\n")


class WatchTest(support.CollidectlTest):
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

    def play(self):
        """The process that plays a scene, and the scene's id."""
        stream = self.start(COLLIDECTL, "stream", "--scene", "reef_knot", "--scale", "0.2", "--frames", "1000000",
                            *self.server)
        while stream.poll() is None:
            with open(self.log, encoding="utf-8") as file:
                created = re.search(r"scene created.*?\b([0-9a-f]{32})\b", file.read())
            if created:
                return stream, created[1]
            time.sleep(0.01)
        self.fail(stream.stderr.read())

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
        self.assertEqual(watch.returncode, 1)
        self.assertIn("NOT_FOUND", errors)

    def test_an_interrupt_ends_it(self):
        watch = self.start(COLLIDECTL, "watch", self.play()[1], *self.server)
        self.assertTrue(LINE.fullmatch(watch.stdout.readline()))
        watch.send_signal(signal.SIGINT)
        _, errors = watch.communicate(timeout=60)
        self.assertEqual(watch.returncode, 128 + signal.SIGINT, errors)

    def test_what_cannot_be_watched_is_refused(self):
        self.refused(2, "--server", "watch", "0123")
        self.refused(2, "scene", "watch", *self.server)
        self.refused(1, "scene_id", "watch", "none", *self.server)
        self.refused(1, "max_frames_per_second", "watch", self.play()[1], "--rate", "-1", *self.server)


if __name__ == "__main__":
    support.main()
