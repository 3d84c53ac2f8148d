#!/usr/bin/env python3
"""Prints lines and branches that ran, by folder, from gcovr's JSON summary. usage: by_folder.py FILE"""

import collections
import json
import pathlib
import sys

COUNTS = ("line_covered", "line_total", "branch_covered", "branch_total")


def by_folder(files):
    """{folder: counts}, with `all` last."""
    folders = collections.defaultdict(lambda: [0] * len(COUNTS))
    for file in files:
        for folder in (str(pathlib.PurePosixPath(file["filename"]).parent), "~all"):
            folders[folder] = [sum(pair) for pair in zip(folders[folder], (file[count] for count in COUNTS))]
    return {folder.lstrip("~"): counts for folder, counts in sorted(folders.items())}


def share(covered, total):
    return f"{100 * covered / total:5.1f} % of {total:6}" if total else "               -"


def main(path):
    files = json.loads(pathlib.Path(path).read_text())["files"]
    for folder, (lines, all_lines, branches, all_branches) in by_folder(files).items():
        print(f"{folder:32} lines {share(lines, all_lines)}   branches {share(branches, all_branches)}")


if __name__ == "__main__":
    main(sys.argv[1])
