"""Counts, failures and reasons for skips, from the JUnit reports that ctest wrote."""

import collections
import pathlib
import re
import textwrap
import xml.etree.ElementTree as xml

import names

# What GoogleTest (GTEST_SKIP), scripts that exit with 77, and ctest itself say.
REASONS = (re.compile(r": Skipped\n(.+)"), re.compile(r"^skipped: (.+)", re.MULTILINE))
WIDTH = 150  # columns of a line


def reason_of(case):
    """Why a test was skipped."""
    output = case.findtext("system-out") or ""
    for reason in REASONS:
        if found := reason.search(output):
            return found[1].strip()
    return "disabled" if case.get("status") == "disabled" else "it gave no reason"


def outcome_of(case):
    """passed, failed or skipped. A test that ctest could not even start has failed."""
    if case.get("status") == "run":
        return "passed"
    skipped = case.find("skipped")
    was_skipped = skipped is not None and skipped.get("message", "").startswith("SKIP_")
    return "skipped" if was_skipped or case.get("status") == "disabled" else "failed"


class Summary:
    """Of any number of reports."""

    def __init__(self):
        self.passed, self.failed, self.skipped = 0, [], collections.defaultdict(list)

    def add(self, report, suffix=""):
        """Adds a report; one that ctest did not write adds nothing."""
        if not pathlib.Path(report).exists():
            return
        for case in xml.parse(report).getroot().findall("testcase"):
            name, outcome = names.short(case.get("name")) + suffix, outcome_of(case)
            if outcome == "passed":
                self.passed += 1
            elif outcome == "failed":
                self.failed.append(name)
            else:
                self.skipped[reason_of(case)].append(name)

    def lines(self):
        for reason, skipped in sorted(self.skipped.items(), key=lambda item: -len(item[1])):
            line = names.clipped(f"   {len(skipped)} skipped: {reason}", WIDTH * 2 // 3)
            groups = ", ".join(names.groups(skipped))
            yield from textwrap.wrap(f"{line} ({groups})", WIDTH, subsequent_indent="      ", break_long_words=False,
                                     break_on_hyphens=False)
        for name in sorted(self.failed):
            yield f"   failed: {name}"

    def counts(self):
        skipped = sum(map(len, self.skipped.values()))
        return f"== {self.passed} passed, {len(self.failed)} failed, {skipped} skipped"
