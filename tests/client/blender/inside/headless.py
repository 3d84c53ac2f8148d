"""Runs all cases in Blender without a window."""

import faulthandler
import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import support  # noqa: E402

faulthandler.dump_traceback_later(200, exit=True)  # where it hangs, before ctest ends it
support.install()
suite = unittest.defaultTestLoader.loadTestsFromNames(["detect_cases", "marks_cases", "range_cases"])
done = unittest.TextTestRunner(stream=sys.stdout, verbosity=2).run(suite)
if not done.wasSuccessful() or not done.testsRun:
    raise SystemExit(1)
