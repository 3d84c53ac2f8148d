"""How far each step of a simulation went: a panel for each simulation, a line for each format of positions."""

from .canvas import BLUE, MUTED, ORANGE, plt
from .results import POSITION_FORMATS

COLOURS = dict(zip(POSITION_FORMATS, (BLUE, ORANGE)))
WIDTH, ROW_HEIGHT = 10, 1.6  # inches


def pictures(simulations):
    """Name to figure; nothing without results."""
    return {"advance": draw(simulations)} if simulations else {}


def draw(simulations):
    names = list(dict.fromkeys(one.name for one in simulations))
    figure, rows = plt.subplots(len(names), 1, figsize=(WIDTH, ROW_HEIGHT * len(names)), sharex=True, squeeze=False)
    for axes, name in zip(rows[:, 0], names):
        draw_row(axes, name, [one for one in simulations if one.name == name])
    rows[-1, 0].set_xlabel("step")
    rows[0, 0].legend(loc="lower right", ncols=len(POSITION_FORMATS))
    figure.tight_layout()
    return figure


def draw_row(axes, name, runs):
    crossings = sum(run.crossings for run in runs)
    axes.set_title(f"{name}: {crossings} pairs of triangles met")
    for run in runs:
        axes.plot(range(1, len(run.advanced) + 1), run.advanced, color=COLOURS[run.position_format], linewidth=0.8,
                  label=run.position_format)
    axes.set_ylim(0, 1.05)
    axes.set_ylabel("advanced", color=MUTED)
    axes.grid(axis="y")
