#!/usr/bin/env python3
"""deploy/slurm on a real Slurm: an array, one of whose tasks is killed, submitted again and goes on, gives the bytes of one run.

Usage: slurm_test.py DAEMON COLLIDECTL REPOSITORY"""

import csv
import os
import pathlib
import signal
import subprocess
import sys
import unittest

from cluster import Cluster, wait_for

DAEMON, COLLIDECTL = sys.argv[1:3]
SCRIPT = pathlib.Path(sys.argv[3]).resolve() / "deploy" / "slurm" / "detect.sbatch"
SHARDS, PAIRS = 3, 600  # a killed task has most of its 200 pairs still to do
OPTIONS = ["--backend", "cpu", "--thickness", "0.01"]
MESH = "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 1 1 {}\nv 1.5 1 3\nv 1 1.5 3\nf 1 2 3\nf 4 5 6\n"


class Arrays(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cluster = Cluster()
        cls.addClassCleanup(cls.cluster.stop)
        cls.cluster.start()

    def setUp(self):
        self.folder = self.cluster.folder / self.id().rpartition(".")[2]
        self.data, self.results = self.folder / "data", self.folder / "results"
        self.data.mkdir(parents=True)

    def frames(self, count):
        """Vertices that pass through a triangle, at another time in each pair."""
        for number in range(count):
            (self.data / f"f{number}.obj").write_text(MESH.format(1 + number / 64 if number % 2 == 0 else -1))

    def submit(self, *words, shards=SHARDS, array=None):
        return self.cluster.submit(*words, f"--array={array or f'1-{shards}'}", SCRIPT, self.data, self.results, *OPTIONS,
                                   SHARDS=str(shards), COLLIDECTL=COLLIDECTL, COLLIDED_DAEMON=DAEMON)

    def ctl(self, *words):
        return subprocess.run([COLLIDECTL, *words], env={**os.environ, "COLLIDED_DAEMON": DAEMON}, capture_output=True, text=True,
                              timeout=120)

    def merged(self, results):
        table = self.folder / "table.csv"
        done = self.ctl("merge", results, "--out", table)
        self.assertEqual(done.returncode, 0, done.stderr)
        return table.read_bytes()

    def part(self, shard):
        return self.results / f"shard-{shard:04}-of-{SHARDS:04}.part"

    def process_of(self, shard):
        """The task's collidectl, once some of its pairs are done; nothing if it has ended."""
        words = [b"--out", os.fsencode(self.results), b"--shard", b"%d/%d" % (shard, SHARDS)]
        for process in pathlib.Path("/proc").glob("[0-9]*"):
            try:
                command = (process / "cmdline").read_bytes().split(b"\0")
            except OSError:  # it has just ended
                continue
            if all(word in command for word in words):
                return int(process.name)
        return None

    def kill_in_the_middle(self, shard):
        """Submits the array and kills one task's collidectl with -9; the job's number."""
        for attempt in range(5):
            self.results = self.folder / f"results{attempt}"
            job = self.submit()
            finished = self.part(shard).with_suffix(".results")
            wait_for(lambda: finished.exists() or self.part(shard).exists() and self.part(shard).stat().st_size > 2000, "a task at work")
            process = self.process_of(shard)
            if process and not finished.exists():
                os.kill(process, signal.SIGKILL)
                return job
            self.cluster.wait(job)  # it was faster than this test
        raise AssertionError("no task was seen at work")

    def test_a_task_that_was_killed_goes_on_and_the_bytes_are_those_of_one_run(self):
        self.frames(PAIRS + 1)
        job = self.kill_in_the_middle(2)
        states = self.cluster.wait(job)
        self.assertEqual(states, {"1": ("COMPLETED", "0:0"), "2": ("FAILED", "0:9"), "3": ("COMPLETED", "0:0")})
        self.assertTrue(self.part(2).exists())
        unfinished = self.ctl("merge", self.results, "--out", self.folder / "table.csv")
        self.assertEqual(unfinished.returncode, 1)
        self.assertIn("1 of 3 shards are not finished or not there: 2", unfinished.stderr)
        again = self.submit(array="2")
        self.assertEqual(self.cluster.wait(again), {"2": ("COMPLETED", "0:0")})
        log = (self.cluster.folder / f"collided-{again}-2.log").read_text()
        self.assertRegex(log, r"shard 2/3: pairs 200, done before [1-9]\d*, failed 0")
        one = self.ctl("batch", self.data, "--out", self.folder / "one", *OPTIONS)
        self.assertEqual(one.returncode, 0, one.stderr)
        table = self.merged(self.results)
        self.assertEqual(table, self.merged(self.folder / "one"))
        self.assertEqual(table.count(b"\n"), PAIRS + 1)

    def test_a_broken_pair_fails_its_task_alone_and_is_in_the_table(self):
        self.frames(5)
        (self.data / "f1.obj").write_text("v 0 0 nan\n")
        job = self.submit("--hold", shards=2)
        merge = self.cluster.submit(f"--dependency=afterany:{job}", "--wrap",
                                    f"{COLLIDECTL} merge {self.results} --out {self.folder / 'table.csv'}")
        self.cluster.call("scontrol", "release", job)
        self.assertEqual(self.cluster.wait(merge), {merge: ("FAILED", "3:0")})
        self.assertEqual(self.cluster.tasks(job), {"1": ("FAILED", "3:0"), "2": ("FAILED", "3:0")})
        rows = list(csv.DictReader((self.folder / "table.csv").read_text().splitlines()))
        self.assertEqual([row["status"] for row in rows], ["failed", "failed", "done", "done"])
        self.assertIn("is not finite", rows[0]["error"])

    def test_a_task_without_a_data_set_says_what_it_needs(self):
        job = self.cluster.submit("--array=1", SCRIPT)
        self.assertEqual(self.cluster.wait(job), {"1": ("FAILED", "2:0")})
        self.assertIn("usage: [SHARDS=N] sbatch", (self.cluster.folder / f"collided-{job}-1.log").read_text())


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
