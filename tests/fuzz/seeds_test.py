#!/usr/bin/env python3
"""The archives of seeds are as tests/fuzz/seeds makes them, from the same seeds always the same."""

import pathlib
import shutil
import subprocess
import tarfile
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
ARCHIVES = sorted((HERE / "corpus").iterdir())


def members(archive):
    """All that an archive says, in its order. Other versions of tar and xz write the same in other bytes."""
    with tarfile.open(archive) as opened:
        return [(member.name, member.type, member.mode, member.mtime, member.uid, member.gid, opened.extractfile(member).read())
                for member in opened]


def seeds(*words):
    subprocess.run([HERE / "seeds", *words], check=True, timeout=60)


class SeedsTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def test_each_target_has_an_archive_that_is_made_from_its_seeds_again(self):
        targets = {file.stem for file in (HERE / "targets").glob("*.cpp") if "\nvoid run(Input input)" in file.read_text()}
        self.assertEqual({archive.name for archive in ARCHIVES}, {f"{target}.tar.xz" for target in targets})
        seeds("unpack", self.folder, *ARCHIVES)
        for archive in ARCHIVES:
            again = self.folder / archive.name
            seeds("pack", again, self.folder / archive.name.removesuffix(".tar.xz"))
            self.assertEqual(members(again), members(archive), archive.name)
            twice = self.folder / f"twice {archive.name}"
            seeds("pack", twice, self.folder / archive.name.removesuffix(".tar.xz"))
            self.assertEqual(twice.read_bytes(), again.read_bytes(), archive.name)

    def test_a_seed_is_added_to_those_that_are_there(self):
        archive, found = self.folder / "pair_list.tar.xz", self.folder / "found --it"
        shutil.copy(HERE / "corpus/pair_list.tar.xz", archive)
        found.write_bytes(b"\0\xff")
        seeds("unpack", self.folder / "before", archive)
        seeds("add", archive, found)
        seeds("unpack", self.folder / "after", archive)
        before, after = ({file.name: file.read_bytes() for file in (self.folder / name / "pair_list").iterdir()}
                         for name in ("before", "after"))
        self.assertEqual(after, before | {"found --it": b"\0\xff"})


if __name__ == "__main__":
    unittest.main()
