"""collidectl batch that is killed, cut off, repeated or done twice at a time, and merge of what is not whole.

Usage: resume_test.py COLLIDECTL DAEMON"""

import os
import pathlib
import resource
import shutil
import signal
import subprocess

import batch_support
from batch_support import LEVEL, ONE_CPU, support

MANY = 400  # pairs, of which a process that is to be killed has done a few


class Resume(batch_support.BatchTest):
    def whole(self, *words):
        """The table of one run without shards."""
        out = os.path.join(self.folder.name, "whole")
        done = batch_support.ctl("batch", self.data, "--out", out, *LEVEL, *ONE_CPU, *words)
        self.assertEqual(done.returncode, 0, done.stderr)
        return self.merged(folder=out)

    def start(self):
        words = [support.COLLIDECTL, "batch", self.data, "--out", self.out, *LEVEL, *ONE_CPU]
        return subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                                env={**os.environ, "COLLIDED_DAEMON": support.DAEMON})

    def begun(self):
        """A process in the middle of its work."""
        part = self.file(1, 1, "part")
        for _ in range(5):
            process = self.start()
            while process.poll() is None:
                if part.exists() and part.stat().st_size > 2000:
                    return process
            process.communicate()  # it was faster than this test
            shutil.rmtree(self.out)
        raise AssertionError("no process was seen at work")

    def test_shards_give_what_one_run_gives(self):
        self.frames("", range(8))
        with self.daemon() as server:
            for shard in (3, 1, 2):
                self.batch("--shard", f"{shard}/3", "--contacts", "--server", server)
            self.assertEqual(self.merged(), self.whole())
        self.assertEqual(sorted(os.listdir(self.out)), [self.file(shard, 3).name for shard in (1, 2, 3)])

    def test_more_shards_than_pairs(self):
        self.frames("", range(2))
        with self.daemon() as server:
            for shard in (1, 2, 3):
                self.batch("--shard", f"{shard}/3", "--server", server)
        self.assertEqual(len(self.table()), 1)

    def test_after_kill_nine_nothing_is_lost_and_nothing_done_twice(self):
        self.frames("", range(MANY + 1))
        process = self.begun()
        process.kill()
        process.communicate()
        kept = self.file(1, 1, "part").read_bytes()
        self.refused(1, "has no finished shard", "merge", self.out, "--out", os.path.join(self.folder.name, "t"))
        done = self.batch("--json", *ONE_CPU)
        before = int(done.stdout.split('"resumed_pairs":')[1].split(",")[0])
        self.assertTrue(0 < before < MANY, before)
        whole = [line for line in kept.split(b"\n") if b'"pair"' in line]
        self.assertTrue(self.file(1, 1).read_bytes().startswith(b"\n".join(kept.split(b"\n")[:2 * before])))
        self.assertIn(len(whole) - before, (0, 1))  # one may have been cut off
        self.assertEqual(self.merged(), self.whole())

    def test_an_interrupt_keeps_what_is_done(self):
        self.frames("", range(MANY + 1))
        process = self.begun()
        process.send_signal(signal.SIGTERM)
        error = process.communicate(timeout=120)[1]
        self.assertEqual(process.returncode, 128 + signal.SIGTERM, error)
        self.assertIn("interrupted by signal 15", error)
        self.assertTrue(self.file(1, 1, "part").exists())

    def test_its_daemon_may_end_and_is_started_again(self):
        self.frames("", range(MANY + 1))
        process = self.begun()
        children = pathlib.Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
        self.assertEqual(len(children), 1)
        for child in children:
            os.kill(int(child), signal.SIGKILL)
        error = process.communicate(timeout=240)[1]
        self.assertEqual(process.returncode, 0, error)
        self.assertIn("its daemon has ended; another one is started", error)
        self.assertEqual({row["status"] for row in self.table()}, {"done"})

    def test_two_at_a_time_are_refused(self):
        self.frames("", range(MANY + 1))
        process = self.begun()
        os.kill(process.pid, signal.SIGSTOP)
        try:
            self.assertIn("another process is at work on this shard", self.batch(*ONE_CPU, code=1).stderr)
        finally:
            process.kill()
            process.communicate()

    def test_a_file_that_was_cut_off_or_changed_is_found_and_done_again(self):
        self.frames("", range(4))
        with self.daemon() as server:
            self.batch("--contacts", "--server", server)
            table, good = self.merged(), self.file(1, 1).read_bytes()
            changed = bytearray(good)
            changed[len(good) // 2] ^= 1
            for bad in (b"", good[:5], good[:len(good) // 3], good[:len(good) // 2], good[:-1], bytes(changed), good + b"x", b"\0" * 9,
                        b"00000000 99999999999999999999 {}\n", b"00000000 18446744073709551615 {}\n"):
                self.file(1, 1).write_bytes(bad)
                self.refused(1, "is cut off or damaged", "merge", self.out, "--out", os.path.join(self.folder.name, "t"))
                self.batch("--contacts", "--server", server)
                self.assertEqual((self.merged(), self.file(1, 1).read_bytes()), (table, good), bad[:20])

    def test_a_full_disk_is_no_result(self):
        self.frames("", range(5))

        def limit():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (600, 600))

        with self.daemon() as server:
            words = [support.COLLIDECTL, "batch", self.data, "--out", self.out, *LEVEL, "--server", server]
            done = subprocess.run(words, preexec_fn=limit, capture_output=True, text=True, timeout=240)
            self.assertEqual(done.returncode, 1, done.stderr)
            self.assertIn("part: cannot be written: File too large", done.stderr)
            self.assertIn("no whole record", self.batch("--server", server).stderr)
        self.assertEqual(self.merged(), self.whole())

    def test_a_device_is_no_file_of_results(self):
        self.frames("", range(3))
        os.mkdir(self.out)
        for device in ("/dev/zero", "/dev/full"):
            os.symlink(device, self.file(1, 1, "part"))
            self.assertIn("is no file", self.batch(*ONE_CPU, code=1).stderr)
            self.file(1, 1, "part").unlink()

    def test_results_of_something_else_are_not_gone_on_with(self):
        self.frames("", range(3))
        with self.daemon() as server:
            self.batch("--server", server)
            self.assertIn('has results of accuracy "certified", not "exact"',
                          self.batch("--accuracy", "exact", "--server", server, code=1).stderr)
            self.frames("more", range(3))
            self.assertIn("has results of pairs 2, not 4", self.batch("--server", server, code=1).stderr)


class Merge(batch_support.BatchTest):
    def setUp(self):
        super().setUp()
        self.frames("", range(8))
        self.table_file = os.path.join(self.folder.name, "table.csv")
        with self.daemon() as server:
            for shard in range(1, 5):
                self.batch("--shard", f"{shard}/4", "--server", server)

    def not_merged(self, part, code=1, *words):
        self.refused(code, part, "merge", self.out, "--out", self.table_file, *words)
        self.assertEqual([name for name in os.listdir(self.folder.name) if name.startswith("table")], [])

    def test_missing_and_unfinished_shards_are_named(self):
        self.file(2, 4).unlink()
        self.file(3, 4).rename(self.file(3, 4, "part"))
        self.not_merged("2 of 4 shards are not finished or not there: 2-3")
        for shard in (1, 4):
            self.file(shard, 4).unlink()
        self.not_merged("has no finished shard")

    def test_shards_that_do_not_belong_together_are_refused(self):
        shutil.copy(self.file(1, 4), self.file(2, 4))
        self.not_merged("is the same shard as shard-0001-of-0004.results")
        self.file(2, 4).unlink()
        self.batch("--shard", "2/5", *ONE_CPU)
        self.not_merged("has results of shards")

    def test_results_that_miss_a_pair_or_have_one_twice_are_refused(self):
        file = self.file(1, 4)
        lines = file.read_bytes().splitlines(keepends=True)  # identity; head and row of two pairs; end
        file.write_bytes(b"".join(lines[:3] + lines[5:]))
        self.not_merged("has 1 of 2 pairs")
        file.write_bytes(b"".join(lines[:3] + lines[1:]))
        self.not_merged("has pair 1 twice")
        others = self.file(2, 4).read_bytes().splitlines(keepends=True)
        file.write_bytes(b"".join(lines[:3] + others[1:3] + lines[5:]))
        self.not_merged("has pair 2, which is not of this shard")

    def test_pipes_and_devices_are_no_results(self):
        for make in (os.mkfifo, lambda file: os.symlink("/dev/zero", file), os.mkdir):
            self.file(2, 4).unlink(missing_ok=True)
            make(self.file(2, 4))
            self.not_merged("shard-0002-of-0004.results: is no file")

    def test_folders_and_files_that_are_none(self):
        self.refused(1, "is no folder", "merge", "/nonexistent", "--out", self.table_file)
        self.refused(1, "has no results", "merge", self.data, "--out", self.table_file)
        self.not_merged("has no contacts: 'collidectl batch --contacts' keeps them", 1, "--contacts", self.frame0 + ".csv")
        self.refused(2, "are two files", "merge", self.out, "--out", self.table_file, "--contacts", self.table_file)
        self.refused(2, "--json and --out -", "merge", self.out, "--out", "-", "--json")
        self.refused(1, "cannot be written", "merge", self.out, "--out", "/nonexistent/t.csv")
        self.assertEqual(self.ok("merge", self.out, "--out", "-").encode(), self.merged())


if __name__ == "__main__":
    support.main()
