#!/usr/bin/env python3
"""Tests what is read of compute-sanitizer's output."""

import re
import unittest

import report

CLEAN = """========= COMPUTE-SANITIZER
Running main() from gtest_main.cc
[==========] 36 tests from 4 test suites ran. (1000 ms total)
[  PASSED  ] 36 tests.
========= ERROR SUMMARY: 0 errors
"""
READS = """========= Uninitialized __global__ memory read of size 4 bytes
=========     at void collided::run<collided::KeepEarliest<float>>(T1)+0x12a0 in step.cuh:40
=========     by thread (0,0,0) in block (1,0,0)
========= Uninitialized __global__ memory read of size 4 bytes
=========     at void collided::run<collided::KeepEarliest<float>>(T1)+0x12b0 in step.cuh:41
=========     by thread (1,0,0) in block (1,0,0)
[  PASSED  ] 2 tests.
========= ERROR SUMMARY: 2 errors
"""
RACES = "[  PASSED  ] 3 tests.\n========= RACECHECK SUMMARY: 0 hazards displayed (0 errors, 0 warnings)\n"


class Report(unittest.TestCase):
    def test_a_clean_run(self):
        found = report.read(CLEAN)
        self.assertEqual(found, {"tests": {"passed": 36}, "reports": 0, "kernels": {}})
        self.assertTrue(report.is_clean(found))
        self.assertTrue(report.is_clean(report.read(RACES)))

    def test_reports_are_counted_by_kernel(self):
        found = report.read(READS)
        self.assertEqual(found["reports"], 2)
        self.assertEqual(found["kernels"], {"collided::run<collided::KeepEarliest<float>>(T1)": 2})

    def test_only_known_kernels_may_be_reported(self):
        found = report.read(READS)
        self.assertFalse(report.is_clean(found))
        self.assertFalse(report.is_clean(found, re.compile("answer_kernel")))
        self.assertTrue(report.is_clean(found, re.compile("KeepEarliest")))

    def test_what_did_not_run_is_not_clean(self):
        for text in ("", "[  PASSED  ] 1 test.\n", "========= ERROR SUMMARY: 0 errors\n", CLEAN.replace("36 tests.", "0 tests."),
                     CLEAN + "[  FAILED  ] 1 test, listed below:\n", CLEAN.replace("0 errors", "5 errors")):
            self.assertFalse(report.is_clean(report.read(text)), text)


if __name__ == "__main__":
    unittest.main()
