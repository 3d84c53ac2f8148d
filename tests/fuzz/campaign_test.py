#!/usr/bin/env python3
"""campaign.py on fuzzers that are not any: what they say is counted, findings are told, runs in one folder add up."""

import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

CAMPAIGN = pathlib.Path(__file__).resolve().parent / "campaign.py"
GOOD = """#!/bin/sh
echo "#12 INITED cov: 5 ft: 7 corp: 3/9b"
echo "#90 NEW    cov: 8 ft: 11 corp: 4/12b"
echo "stat::number_of_executed_units: 100"
for option; do last2=$last; last=$option; done
touch "$last2/learnt$$"
"""
BAD = """#!/bin/sh
for option; do case $option in -artifact_prefix=*) prefix=${option#*=} ;; esac; done
touch "${prefix}crash-1" "${prefix}slow-unit-2"
sleep 1
exit 77
"""


class CampaignTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def fuzzer(self, name, text):
        file = self.folder / "bin" / f"fuzz_{name}"
        file.parent.mkdir(exist_ok=True)
        file.write_text(text)
        file.chmod(0o755)
        (self.folder / "seeds" / name).mkdir(parents=True)

    def run_all(self, *options):
        command = [sys.executable, CAMPAIGN, "--binaries", self.folder / "bin", "--seeds", self.folder / "seeds", "--out",
                   self.folder / "out", "--commit", "abc", *options]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        return done.returncode, json.loads((self.folder / "out/result.json").read_text())["targets"]

    def test_counts_what_workers_did(self):
        self.fuzzer("good", GOOD)
        code, targets = self.run_all("--workers", "3", "--seconds", "5")
        self.assertEqual(code, 0)
        good = targets["good"]
        self.assertEqual((good["executions"], good["edges"], good["features"], good["corpus"], good["findings"]), (300, 8, 11, 3, []))

    def test_adds_up_over_runs(self):
        self.fuzzer("good", GOOD)
        self.run_all("--seconds", "5")
        _, targets = self.run_all("--seconds", "5")
        self.assertEqual((targets["good"]["executions"], targets["good"]["edges"]), (200, 8))

    def test_tells_findings_and_ends_with_1(self):
        self.fuzzer("bad", BAD)
        code, targets = self.run_all("--seconds", "3")
        self.assertEqual(code, 1)
        self.assertEqual(targets["bad"]["findings"], ["bad-crash-1"])
        self.assertGreater(len(targets["bad"]["ended_badly"]), 1, "it is started again for the time that is left")


if __name__ == "__main__":
    unittest.main()
