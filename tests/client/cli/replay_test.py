"""collidectl stream --record and replay: the same contacts again, and files that are no recordings.

Usage: replay_test.py COLLIDECTL DAEMON"""

import json
import os
import signal
import subprocess

import support
from support import COLLIDECTL, DAEMON, ONE_CPU

BALL = ["--scene", "cloth_ball", "--scale", "0.1", "--frames", "4", "--t0", "0.4", "--thickness", "0.05"]
SAME = ("frames", "contact_count", "contacts_vertex_triangle", "contacts_edge_edge", "contacts_digest", "bytes_in")


class Replay(support.CollidectlTest):
    def setUp(self):
        super().setUp()
        self.recording = os.path.join(self.folder.name, "motion.rec")

    def record(self, *words):
        return json.loads(self.ok("stream", *words, *ONE_CPU, "--record", self.recording, "--json"))

    def replayed(self, *words):
        return json.loads(self.ok("replay", self.recording, *(words or ONE_CPU), "--json"))

    def put_bytes(self, data):
        path = os.path.join(self.folder.name, "bad.rec")
        with open(path, "wb") as file:
            file.write(data)
        return path

    def whole(self):
        self.record(self.frame0, self.frame1)
        with open(self.recording, "rb") as file:
            return file.read()

    def test_a_replay_finds_the_same(self):
        for words in (BALL, [*BALL, "--rigid", "ball", "--exclude-rings", "2", "--exclude-meshes", "cloth", "cloth"],
                      [*BALL, "--mode", "dcd", "--half-thickness", "ball=0.02"], [*BALL, "--position-format", "q16"], [self.frame0, self.frame1, "--accuracy", "exact"]):
            first, again = self.record(*words), self.replayed()
            self.assertEqual([first[name] for name in SAME], [again[name] for name in SAME])
            self.assertEqual(first["scene"], again["scene"])
            self.assertGreater(first["contact_count"], 0)
            counts = [[frame["contact_count"] for frame in played["per_frame"]] for played in (first, again)]
            self.assertEqual(*counts)
        with self.daemon() as address:
            self.assertEqual(self.replayed("--server", address)["contacts_digest"], first["contacts_digest"])

    def test_a_digest_tells_contacts_apart(self):
        digests = {self.record(self.frame0, self.frame1, *more)["contacts_digest"] for more in ([], ["--thickness", "0.1"])}
        self.assertEqual(len(digests), 2)
        self.assertRegex(self.ok("replay", self.recording, *ONE_CPU), r"^frame 1 of 2: 0 contacts")

    def test_loose_elements_are_recorded(self):
        frames = [self.put(f"{z}.obj", f"v 0 0 0\nv 0.5 0 {z}\nv 1 0 0\nl 1 3\np 2\n") for z in (1, 2)]
        self.assertEqual(self.record(*frames)["contacts_digest"], self.replayed()["contacts_digest"])

    def test_an_interrupted_stream_leaves_a_whole_recording(self):
        words = [COLLIDECTL, "stream", *BALL[:4], "--frames", "1000000", *ONE_CPU, "--record", self.recording]
        with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                              env={**os.environ, "COLLIDED_DAEMON": DAEMON}) as stream:
            self.assertRegex(stream.stdout.readline(), "^frame 1 of")
            stream.send_signal(signal.SIGINT)
            stream.communicate(timeout=60)
        self.assertEqual(stream.returncode, 128 + signal.SIGINT)
        self.assertGreaterEqual(self.replayed()["frames"], 1)

    def test_a_file_that_was_cut_off_is_played_up_to_there(self):
        whole = self.whole()
        for cut in (1, 2, 100):
            done = support.ctl("replay", self.put_bytes(whole[:-cut]), *ONE_CPU)
            self.assertEqual(done.returncode, 1)
            self.assertRegex(done.stderr, r"bad\.rec: frame number \d at offset \d+ is cut off")
        for size in (0, 5, len("collided recording 1\n")):
            self.refused(1, "bad.rec: ", "replay", self.put_bytes(whole[:size]), *ONE_CPU)

    def offsets(self, data):
        """Where each frame begins, then the end mark."""
        at, out = len("collided recording 1\n"), []
        while True:
            length, shift, begin = 0, 0, at
            while True:
                byte = data[at]
                length, shift, at = length | (byte & 0x7F) << shift, shift + 7, at + 1
                if byte < 0x80:
                    break
            out.append(begin)
            at += length
            if length == 0:
                return out[1:]  # the first message is the scene

    def test_every_whole_frame_before_a_cut_is_reported(self):
        first = self.record(*BALL)
        with open(self.recording, "rb") as file:
            data = file.read()
        offsets = self.offsets(data)
        self.assertEqual(len(offsets), first["frames"] + 1)
        for whole, offset in enumerate(offsets):
            for cut in {offset, min(offset + 1, len(data) - 1), max(offset, offsets[min(whole + 1, len(offsets) - 1)] - 1)}:
                bad = self.put_bytes(data[:cut])
                done = support.ctl("replay", bad, *ONE_CPU)
                self.assertEqual(done.returncode, 1)
                self.assertIn(f"bad.rec: frame number {whole + 1} at offset {offset} is cut off", done.stderr)
                self.assertEqual(done.stdout.count(f" of {whole}: "), whole, cut)
            played = support.ctl("replay", bad, *ONE_CPU, "--json")
            self.assertEqual(played.returncode, 1)
            if whole > 0:
                self.assertEqual([frame["contacts_digest"] for frame in json.loads(played.stdout)["per_frame"]],
                                 [frame["contacts_digest"] for frame in first["per_frame"]][:whole])

    def test_what_is_no_recording_is_refused(self):
        header = b"collided recording 1\n"
        self.refused(1, "bad.rec: is no recording", "replay", self.put_bytes(b"ply\nformat ascii 1.0\n" * 9))
        self.refused(1, "of another version; this collidectl reads version 1", "replay",
                     self.put_bytes(b"collided recording 2\n"))
        self.refused(1, "the scene at offset 21 has a length above the limit of 2147483647", "replay",
                     self.put_bytes(header + b"\xff" * 30))
        self.refused(1, "the scene at offset 21 is cut off: it has 2147483647 bytes; the file has 3 more", "replay",
                     self.put_bytes(header + b"\xff\xff\xff\xff\x07abc"))
        self.refused(1, "the scene at offset 22 is no message", "replay", self.put_bytes(header + b"\x03\xff\xff\xff\0"))
        self.refused(1, "meshes[0].triangles has 1 bytes; it needs a multiple of 12", "replay",
                     self.put_bytes(header + b"\x05\x5a\x03\x42\x01x\0"))
        self.refused(1, "bytes that follow the end", "replay", self.put_bytes(self.whole() + b"more"), *ONE_CPU, "--json")
        self.refused(1, "does not exist", "replay", os.path.join(self.folder.name, "none"))
        self.refused(1, "is not a file", "replay", self.folder.name)

    def test_a_recording_that_cannot_be_written(self):
        self.refused(2, "--record writes a file", "stream", self.frame0, "--record", "-")
        self.refused(1, "Is a directory", "stream", self.frame0, "--record", self.folder.name)
        done = support.ctl("stream", self.frame0, self.frame1, *ONE_CPU, "--record", "/dev/full")
        self.assertEqual(done.returncode, 1)
        self.assertIn("/dev/full: cannot be written: No space left on device", done.stderr)


if __name__ == "__main__":
    support.main()
