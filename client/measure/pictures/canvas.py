"""Shared by all pictures: matplotlib without a display, fonts, colours, and files that depend only on the data."""

import matplotlib

matplotlib.use("Agg")
matplotlib.rcParams.update({
    "font.family": "DejaVu Sans",
    "font.size": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "axes.titlelocation": "left",
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "svg.fonttype": "none",  # text stays text
    "svg.hashsalt": "collided",  # else ids are random
})

import matplotlib.pyplot as plt  # noqa: E402

# Okabe and Ito's palette, which people of every colour vision can tell apart.
BLUE, ORANGE, GREEN, VERMILION, SKY, PURPLE, YELLOW = ("#0072B2", "#E69F00", "#009E73", "#D55E00", "#56B4E9", "#CC79A7",
                                                       "#F0E442")
COLOURS = [BLUE, ORANGE, GREEN, VERMILION, SKY, PURPLE, YELLOW, "#666666", "#000000"]
MUTED = "#61686f"


def save(figure, path):
    """Writes PNG or SVG, by the file's ending, and prints the file's name."""
    metadata = {"Date": None} if path.suffix == ".svg" else {"Software": None}
    figure.savefig(path, dpi=150, facecolor="white", bbox_inches="tight", metadata=metadata)
    plt.close(figure)
    print(path)
