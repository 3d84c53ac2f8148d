#!/usr/bin/env python3
"""Draws a result of the soak: each sample, and the low points of the tides.

usage: plot.py RESULT.json PICTURE.png
"""

import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "client" / "measure"))
from pictures.canvas import BLUE, MUTED, ORANGE, plt, save

MEASURES = {"rss": ("resident memory, MB", 1e6), "heap": ("memory that the daemon's code holds, MB", 1e6), "device_bytes": ("bytes of scenes, MB", 1e6),
            "fds": ("descriptors", 1), "threads": ("threads", 1)}


def draw(result):
    figure, places = plt.subplots(2, 2, figsize=(10, 6), sharex=True)
    minutes = [sample["second"] / 60 for sample in result["samples"]]
    low = result["low_points"]
    ends = [result["minutes"] * (i + 1) / len(low) for i in range(len(low))]
    for axes, (name, (title, unit)) in zip(places.flat, MEASURES.items()):
        axes.plot(minutes, [sample[name] / unit for sample in result["samples"]], color=BLUE, linewidth=0.4)
        axes.plot(ends, [point[name] / unit for point in low], color=ORANGE, linestyle="", marker=".", markersize=3)
        axes.set_title(title)
        axes.set_ylim(bottom=0)
        axes.grid(True)
    for axes in places[1]:
        axes.set_xlabel("minutes; orange: all clients are gone", color=MUTED)
    figure.tight_layout()
    return figure


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    save(draw(json.loads(pathlib.Path(sys.argv[1]).read_text(encoding="utf-8"))), pathlib.Path(sys.argv[2]))
