"""ctest's output, line by line, as progress and the output of failures."""

import re
import sys
import time

import names

RESULT = re.compile(r"^\s*(\d+)/(\d+) Test\s+#\d+: (.+?) \.{3,}(.*)$")
NOISE = re.compile(r"^\s*(Start\s+\d+: |Test project |Internal ctest changing into directory: |Connected to MAKE jobserver)")
SUMMARY = re.compile(r"^\d+% tests passed")


class Progress:
    """Feed it ctest's lines. On a terminal one line is updated; elsewhere a line is printed for every 5 %."""

    def __init__(self, out=sys.stdout, width=100):
        self.out, self.width, self.moves = out, width, out.isatty()
        self.started = time.monotonic()
        self.failed = self.skipped = self.told = 0
        self.within_failure = self.is_over = False

    def line(self, text):
        if self.is_over or SUMMARY.match(text):
            self.is_over = True  # run.py sums up itself, over all stages
        elif result := RESULT.match(text):
            self._result(*result.groups())
        elif NOISE.match(text):
            self.within_failure = False
        elif text.strip() or self.within_failure:
            self._print(text)

    def end(self):
        """Leaves the cursor at the start of an empty line."""
        if self.moves:
            self.out.write("\r\033[K")

    def _result(self, number, total, name, verdict):
        was_skipped = "***Skipped" in verdict or "***Not Run (Disabled)" in verdict
        self.within_failure = "***" in verdict and not was_skipped
        self.skipped += was_skipped
        if self.within_failure:
            self.failed += 1
            self._print(f"FAILED {names.short(name)}: {' '.join(verdict.replace('***', ' ').split())}")
        else:  # after a failure its output comes next
            self._tell(int(number), int(total), name)

    def _tell(self, number, total, name):
        state = f"{100 * number // total:3} % ({number} of {total}), {self.failed} failed, {self.skipped} skipped"
        if self.moves:
            self.out.write("\r\033[K" + f"{state}  {name}"[:self.width])
        elif 20 * number // total > self.told:
            self.told = 20 * number // total
            self.out.write(f"{state}, {time.monotonic() - self.started:.0f} s\n")
        self.out.flush()

    def _print(self, text):
        self.end()
        self.out.write(text + "\n")
        self.out.flush()
