"""simulate.py makes the committed frames, byte for byte. Usage: cloth_drape_test.py FOLDER"""

import importlib.util
import pathlib
import subprocess
import sys
import tempfile
import unittest

FOLDER = pathlib.Path(sys.argv[1])


class ClothDrape(unittest.TestCase):
    def test_the_frames_are_made_anew(self):
        with tempfile.TemporaryDirectory() as made:
            subprocess.run([sys.executable, FOLDER / "simulate.py", made], check=True)
            for name in ("before.ply", "after.ply"):
                same = (pathlib.Path(made) / name).read_bytes() == (FOLDER / "frames" / name).read_bytes()
                self.assertTrue(same, name)


if __name__ == "__main__":
    if not importlib.util.find_spec("numpy"):
        print("skipped: no module numpy (Debian: python3-numpy)")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1])
