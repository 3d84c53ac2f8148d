"""Counts, failures and reasons for skips, from the JUnit reports that ctest wrote."""

import collections
import re
import textwrap
import xml.etree.ElementTree as xml

# How GoogleTest (GTEST_SKIP) and scripts that exit with 77 give the reason for a skip.
REASON = re.compile(r"(?:: Skipped\n|^skipped: )(.+)", re.MULTILINE)
WIDTH = 150  # columns of a line


def results(report, suffix=""):
    """The name of each test, and "passed", "failed" or "skipped: REASON". What ctest could not even start has failed."""
    for case in xml.parse(report).getroot().findall("testcase"):
        outcome = {"run": "passed", "disabled": "skipped: disabled"}.get(case.get("status"), "failed")
        if (skip := case.find("skipped")) is not None and skip.get("message", "").startswith("SKIP_"):
            said = REASON.search(case.findtext("system-out") or "")
            outcome = f"skipped: {said[1].strip() if said else 'it gave no reason'}"
        yield case.get("name").split("  # ")[0] + suffix, outcome  # GoogleTest adds the value of a parameter


def groups(names):
    """Suites with their numbers of cases, the largest first; a lone test by its name."""
    suites = collections.defaultdict(list)
    for name in sorted(names):
        suites[name.rpartition(".")[0]].append(name)
    return [cases[0] if len(cases) == 1 else f"{suite}: {len(cases)} cases"
            for suite, cases in sorted(suites.items(), key=lambda item: -len(item[1]))]


def lines(found):
    """One for each reason of a skip and each failure, and the counts."""
    names = collections.defaultdict(list)
    for name, outcome in found:
        names[outcome].append(name)
    passed, failed, kept = names.pop("passed", []), names.pop("failed", []), WIDTH * 2 // 3
    for reason, skipped in sorted(names.items(), key=lambda item: -len(item[1])):
        reason = reason if len(reason) <= kept else reason[:kept - 3] + "..."
        yield from textwrap.wrap(f"   {len(skipped)} {reason} ({', '.join(groups(skipped))})", WIDTH, subsequent_indent="      ",
                                 break_long_words=False, break_on_hyphens=False)
    yield from (f"   failed: {name}" for name in sorted(failed))
    yield f"== {len(passed)} passed, {len(failed)} failed, {sum(map(len, names.values()))} skipped"
