#!/usr/bin/env python3
"""deploy/kubernetes/batch: each Job is rendered by kubectl, and its command is run here for every index, as its container
would, with the image's environment. Nothing here runs on a cluster. Usage: batch_job_test.py DAEMON COLLIDECTL REPOSITORY"""

import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

from rendered import Objects

DAEMON, COLLIDECTL = (pathlib.Path(path).resolve() for path in sys.argv[1:3])
REPOSITORY = pathlib.Path(sys.argv[3]).resolve()
JOBS = {name: Objects(REPOSITORY / "deploy" / "kubernetes" / "batch" / name) for name in ("cpu", "gpu")}
IMAGE = dict(re.findall(r"(COLLIDED_\w+)=(\S+)", re.search(r"^ENV (.*)$", (REPOSITORY / "deploy/container/Containerfile").read_text(),
                                                          re.MULTILINE)[1]))
MESH = "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 1 1 {}\nv 1.5 1 3\nv 1 1.5 3\nf 1 2 3\nf 4 5 6\n"
FRAMES = 20


class Rendered(unittest.TestCase):
    def test_every_shard_has_an_index(self):
        for objects in JOBS.values():
            job = objects.one("Job")["spec"]
            self.assertEqual(job["completionMode"], "Indexed")
            self.assertEqual(str(job["completions"]), objects.environment("")["SHARDS"])

    def test_pods_may_do_nothing_but_their_work(self):
        for objects in JOBS.values():
            pod, container = objects.pod["spec"], objects.container["securityContext"]
            self.assertTrue(pod["securityContext"]["runAsNonRoot"])
            self.assertFalse(pod["automountServiceAccountToken"])
            self.assertEqual(container, {"allowPrivilegeEscalation": False, "readOnlyRootFilesystem": True,
                                         "capabilities": {"drop": ["ALL"]}})
            policy = objects.one("NetworkPolicy")["spec"]
            self.assertLessEqual(policy["podSelector"]["matchLabels"].items(), objects.pod["metadata"]["labels"].items())
            self.assertFalse(policy.get("ingress") or policy.get("egress"))
            self.assertEqual(set(policy["policyTypes"]), {"Ingress", "Egress"})

    def test_what_it_writes_is_mounted(self):
        for objects in JOBS.values():
            mounts = {mount["mountPath"]: mount for mount in objects.container["volumeMounts"]}
            self.assertEqual(set(mounts), {objects.environment("")[name] for name in ("DATASET", "RESULTS")} | {"/tmp"})
            self.assertEqual({mount["name"] for mount in mounts.values()}, {volume["name"] for volume in objects.pod["spec"]["volumes"]})

    def test_options_are_collidectls(self):
        known = subprocess.run([COLLIDECTL, "batch", "--help"], capture_output=True, text=True, check=True, timeout=60).stdout
        for objects in JOBS.values():
            for word in objects.container["args"]:
                if word.startswith("--"):
                    self.assertIn(f" {word} ", known)


class Run(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.data, self.results, self.tmp = (self.folder / name for name in ("data", "results", "tmp"))
        for path in (self.data, self.results, self.tmp):
            path.mkdir()
        for number in range(FRAMES):
            (self.data / f"f{number}.obj").write_text(MESH.format(1 + number / 64 if number % 2 == 0 else -1))
        (self.data / "f7.obj").write_text("v 0 0 nan\n")

    def run_pod(self, index):
        """The container's command with the environment that it would have, and these folders in place of its volumes."""
        objects = JOBS["cpu"]
        folders = {"/data": self.data, "/results": self.results}
        environment = {**IMAGE, **{name: str(folders.get(value, value)) for name, value in objects.environment("").items()},
                       "JOB_COMPLETION_INDEX": str(index), "PATH": f"{COLLIDECTL.parent}:{DAEMON.parent}:/usr/bin:/bin",
                       "TMPDIR": str(self.tmp)}
        done = subprocess.run([*objects.container["command"], *objects.container["args"]], env=environment, capture_output=True,
                              text=True, timeout=120)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def table(self, results):
        done = subprocess.run([COLLIDECTL, "merge", results, "--out", "-"], capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 3, done.stderr)  # a pair has failed
        return done.stdout

    def test_all_indices_give_the_bytes_of_one_run(self):
        shards = JOBS["cpu"].one("Job")["spec"]["completions"]
        for index in range(shards):
            self.assertIn(f"shard {index + 1}/{shards}: ", self.run_pod(index))
        self.assertEqual(os.listdir(self.tmp), [])
        one = self.folder / "one"
        subprocess.run([COLLIDECTL, "batch", self.data, "--out", one, "--backend", "cpu"], capture_output=True, timeout=60,
                       env={**os.environ, "COLLIDED_DAEMON": str(DAEMON)})
        table = self.table(self.results)
        self.assertEqual(table, self.table(one))
        self.assertEqual((table.count(",done,"), table.count(",failed,")), (FRAMES - 3, 2))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
