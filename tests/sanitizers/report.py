"""What compute-sanitizer prints."""

import collections
import re

_SUMMARY = re.compile(r"(?:ERROR|RACECHECK) SUMMARY: (\d+) (?:error|hazard)")
_WHERE = re.compile(r"^=+\s+at (?:0x[0-9a-f]+ in )?(.+?)(?:\+0x[0-9a-f]+)?(?: in .*)?$", re.MULTILINE)
_TESTS = re.compile(r"\[  (PASSED|SKIPPED|FAILED)  \] (\d+) test")
_NAME_LENGTH = 160  # of a kernel's name, which is of templates


def read(text):
    """reports: how many there are, None without a summary; kernels: how many of each; tests: how many passed and failed."""
    summaries = [int(count) for count in _SUMMARY.findall(text)]
    kernels = collections.Counter(where.removeprefix("void ")[:_NAME_LENGTH] for where in _WHERE.findall(text))
    return {"tests": {verdict.lower(): int(count) for verdict, count in _TESTS.findall(text)},
            "reports": sum(summaries) if summaries else None, "kernels": dict(kernels)}


def is_clean(result, known=None):
    """Whether tests ran and passed, and nothing was reported but of the kernels that `known` matches."""
    tests, kernels = result["tests"], result["kernels"]
    if result["reports"] is None or not tests.get("passed") or tests.get("failed"):
        return False
    return all(known is not None and known.search(kernel) for kernel in kernels) and (bool(kernels) or not result["reports"])
