"""check_breaking tells a protocol that breaks its clients, and this one breaks none of a release's."""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
REPOSITORY = HERE.parents[1]
NO_BUF = 77
RELEASES = "".join(f"compatible with {image.stem}\n" for image in sorted((REPOSITORY / "proto/releases").glob("*.binpb")))


def run(*command, folder=REPOSITORY, **environment):
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False,
                          env={**os.environ, **environment})


class Breaking(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.copy = pathlib.Path(temporary.name)
        for folder in ("proto", "tests/proto"):
            shutil.copytree(REPOSITORY / folder, self.copy / folder, ignore=shutil.ignore_patterns("__pycache__"))
        for words in ("init -q", "add .", "-c user.name=a -c user.email=a@b commit -q -m a"):
            done = run("git", *words.split(), folder=self.copy)
            self.assertEqual(done.returncode, 0, done.stderr)

    def check(self, *ref):
        return run(self.copy / "tests/proto/check_breaking", *ref, folder=self.copy,
                   PATH=f"{pathlib.Path(BUF).parent}:{os.environ['PATH']}")

    def test_what_did_not_change_is_compatible(self):
        done = self.check()
        self.assertEqual((done.returncode, done.stdout), (0, RELEASES), done.stderr)
        done = self.check("HEAD")
        self.assertEqual((done.returncode, done.stdout), (0, "compatible with HEAD\n"), done.stderr)

    def test_a_field_with_another_number_is_not(self):
        file = self.copy / "proto/collided/v1/frame.proto"
        before = file.read_text()
        file.write_text(before.replace(" frame_id = 1;", " frame_id = 1000;", 1))
        self.assertNotEqual(before, file.read_text())
        for ref in ((), ("HEAD",)):
            done = self.check(*ref)
            self.assertNotIn(done.returncode, (0, NO_BUF), done.stderr)
            self.assertIn("frame.proto", done.stdout + done.stderr)

    def test_no_release_is_broken(self):
        done = run(HERE / "check_breaking")
        self.assertEqual((done.returncode, done.stdout), (0, RELEASES), done.stderr)


if __name__ == "__main__":
    found = run(HERE / "find_buf")
    if found.returncode:
        print(found.stderr, end="")
        sys.exit(found.returncode)
    BUF = found.stdout.strip()
    unittest.main()
