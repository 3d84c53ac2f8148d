#!/usr/bin/env python3
"""tests/run's progress, summary and second stage, on a folder of tests made for it and with the real ctest.

usage: runner_test.py CTEST
"""

import io
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import run
import summary

CTEST = pathlib.Path(sys.argv[1])
HERE = pathlib.Path(__file__).parent
MANY = "".join(f"add_test(many.{i} true)\n" for i in range(60))
MIXED = """
add_test(a.good true)
add_test(b.bad sh -c "echo the output of a failure; exit 3")
add_test(c.return_code sh -c "echo skipped: no promtool; exit 77")
set_tests_properties(c.return_code PROPERTIES SKIP_RETURN_CODE 77)
add_test(e.missing /no/such/program)
add_test(f.disabled true)
set_tests_properties(f.disabled PROPERTIES DISABLED TRUE)
""" + "".join(f"""
add_test(d.gpu{i} sh -c "echo 'x.cpp:3: Skipped'; echo 'no GPU here'; echo; echo '[  SKIPPED ] a'")
set_tests_properties(d.gpu{i} PROPERTIES SKIP_REGULAR_EXPRESSION "SKIPPED")
""" for i in range(5))
CLOCK = f"""
add_test(clock {sys.executable} -c "import time; print(time.monotonic())")
set_tests_properties(clock PROPERTIES LABELS unit)
add_test(daemon true)
set_tests_properties(daemon PROPERTIES LABELS integration-any-clock)
add_test(other true)
set_tests_properties(other PROPERTIES LABELS integration)
add_test(no_clock true)
set_tests_properties(no_clock PROPERTIES LABELS unit-no-clock)
"""


class Runner(unittest.TestCase):
    def run_on(self, tests, *arguments):
        """The exit code and what was printed for a folder of tests."""
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.build = pathlib.Path(folder.name).resolve()
        (self.build / "CTestTestfile.cmake").write_text(tests)
        done = subprocess.run(
            [sys.executable, HERE / "run.py", self.build, "preset x", *arguments], text=True, timeout=60,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env={**os.environ, "PATH": f"{CTEST.parent}:{os.environ['PATH']}"})
        return done.returncode, done.stdout

    def test_failures_come_with_their_output_and_skips_with_one_line_a_reason(self):
        code, printed = self.run_on(MIXED)
        self.assertEqual(code, 1)
        lines = printed.splitlines()
        at = next(i for i, line in enumerate(lines) if line.startswith("FAILED b.bad: Failed"))
        self.assertEqual(lines[at + 1], "the output of a failure")
        for line in ("   5 skipped: no GPU here (d: 5 cases)",
                     "   1 skipped: no promtool (c.return_code)", "   1 skipped: disabled (f.disabled)",
                     "   failed: b.bad", "   failed: e.missing"):
            self.assertEqual(lines.count(line), 1, printed)
        self.assertEqual(lines[-2:], ["== 1 passed, 2 failed, 7 skipped", "== FAILED"])
        for name in ("a.good", "d.gpu3", "Start "):
            self.assertNotIn(name, printed)

    def test_the_log_has_everything_and_the_report_is_there(self):
        _, printed = self.run_on(MIXED)
        for file in ("test-log.txt", "test-report.xml"):
            self.assertIn(str(self.build / file), printed)
            self.assertIn("a.good", (self.build / file).read_text())

    def test_without_a_terminal_few_lines_tell_the_progress(self):
        code, printed = self.run_on(MANY)
        self.assertEqual(code, 0)
        told = [line for line in printed.splitlines() if " % (" in line]
        self.assertEqual(len(told), 20, printed)
        self.assertTrue(told[-1].startswith("100 % (60 of 60), 0 failed, 0 skipped"), printed)
        self.assertIn("== 60 passed, 0 failed, 0 skipped\n== OK", printed)

    def test_other_arguments_are_ctests(self):
        code, printed = self.run_on(MANY, "-R", r"many\.1$")
        self.assertEqual(code, 0)
        self.assertIn("== 1 passed, 0 failed, 0 skipped\n== OK", printed)
        code, printed = self.run_on(MANY, "-N")
        self.assertEqual(code, 0)
        self.assertIn("Test #60: many.59", printed)
        code, printed = self.run_on(MANY, "-R", "none of them")
        self.assertNotEqual(code, 0)
        self.assertTrue(printed.endswith("== FAILED\n"), printed)

    def test_what_knows_a_clock_runs_once_more_on_a_young_one(self):
        _, printed = self.run_on(CLOCK)
        if reason := run.young_clock()[1]:
            self.assertIn(f"   skipped: the tests that know a clock, on one of 5 s: {reason}\n", printed)
            return
        self.assertIn("== 6 passed, 0 failed, 0 skipped", printed)
        young = (self.build / "test-report-young.xml").read_text()
        self.assertLess(float(young.split("<system-out>")[1].split("<")[0]), run.AGE + 60)
        self.assertEqual([name in young for name in ('"daemon"', '"other"', '"no_clock"')], [True, False, False])


class Terminal(io.StringIO):
    def isatty(self):
        return True


class Parts(unittest.TestCase):
    def test_on_a_terminal_one_line_moves(self):
        out = Terminal()
        shown = run.Progress(out, width=60)
        for i in range(1, 101):
            shown.line(f"{i}/100 Test #{i}: a.test_with_a_rather_long_name_{i} .....   Passed    0.01 sec")
        shown.show("")
        self.assertNotIn("\n", out.getvalue())
        moves = out.getvalue().split("\r\033[K")
        self.assertLessEqual(max(map(len, moves)), 60)
        self.assertIn("100 % (100 of 100), 0 failed, 0 skipped", moves[-2])

    def told(self, cases):
        """The lines for a report of tests that were skipped: (name, output)."""
        with tempfile.TemporaryDirectory() as folder:
            report = pathlib.Path(folder) / "report.xml"
            report.write_text("<testsuite>" + "".join(
                f'<testcase name="{name}" status="notrun"><skipped message="SKIP_RETURN_CODE=77"/>'
                f"<system-out>{output}</system-out></testcase>" for name, output in cases) + "</testsuite>")
            return list(summary.lines(summary.results(report)))

    def test_a_skip_without_a_reason_says_so(self):
        self.assertEqual(self.told([("a", "")])[0], "   1 skipped: it gave no reason (a)")

    def test_a_reason_names_every_group_in_lines_that_fit_a_screen(self):
        value = "  # GetParam() = (" + 30 * "4-byte object &lt;00-00 00-00&gt;, " + ")"
        cases = [f"All/Suite{suite}WithALongName.Test/case{i}{value}" for suite in range(20) for i in range(suite + 1)]
        lines = self.told([*((case, "skipped: no GPU") for case in cases), (cases[0], "skipped: " + 300 * "x")])
        self.assertEqual(lines[0], "   210 skipped: no GPU (All/Suite19WithALongName: 20 cases, All/Suite18WithALongName: "
                                   "19 cases, All/Suite17WithALongName: 18 cases,")
        self.assertTrue(lines[1].startswith("      All/Suite16WithALongName: 17 cases, "), lines[1])
        for suite in range(20):  # every group is named, however many there are
            self.assertEqual("\n".join(lines).count(f"All/Suite{suite}WithALongName"), 2 if suite == 0 else 1)
        self.assertTrue(lines[-2].startswith("   1 skipped: xxx"))
        self.assertLessEqual(max(map(len, lines)), 150)

    def test_a_lone_case_is_named_among_suites(self):
        self.assertEqual(summary.groups(["a.one", "b/S.two/x", "b/S.two/y", "c.d.three [clock of 5 s]"]),
                         ["b/S: 2 cases", "a.one", "c.d.three [clock of 5 s]"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
