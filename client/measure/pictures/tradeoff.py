"""Time against accuracy: a row of panels for each result of `collidectl tradeoff`. Best is bottom left."""

import math

from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, NullLocator

from .canvas import BLUE, MUTED, VERMILION, plt
from .labels import ABOVE, BELOW, LEFT, RIGHT, Labels
from .results import LEVELS, POSITION_FORMATS

# Okabe and Ito's, green and purple darker so that they can be read as text.
LEVEL_COLOURS = dict(zip(LEVELS, (VERMILION, BLUE, "#008c66", "#ad598f")))
MARKERS = dict(zip(POSITION_FORMATS, "oDs"))
FORMAT_NAMES = dict(zip(POSITION_FORMATS, ("float positions", "double positions", "encoded positions")))
ALARM, ALARM_PAPER = "#b71c1c", "#fdf0ed"
MAX_TICKS = 8
ROW_WIDTH, ROW_HEIGHT = 12, 4.8  # inches


def pictures(tradeoffs):
    """Name to figure; nothing without results."""
    return {"tradeoff": draw(tradeoffs)} if tradeoffs else {}


def draw(tradeoffs):
    figure = plt.figure(figsize=(ROW_WIDTH, ROW_HEIGHT * len(tradeoffs)))
    rows = figure.subfigures(len(tradeoffs), 1, squeeze=False)[:, 0]
    for index, (row, result) in enumerate(zip(rows, tradeoffs)):
        draw_row(row, result, f"row{index}")
    figure.legend(handles=legend_handles(tradeoffs), loc="lower left", bbox_to_anchor=(0, 1), ncols=8, columnspacing=1.2,
                  handletextpad=0.5)
    return figure


def legend_handles(tradeoffs):
    levels = [Patch(color=colour, label=level) for level, colour in LEVEL_COLOURS.items()]
    shown = {run.position_format for result in tradeoffs for run in result.runs} | set(POSITION_FORMATS[:2])
    formats = [Line2D([], [], color="black", linestyle="", marker=MARKERS[name], label=FORMAT_NAMES[name])
               for name in POSITION_FORMATS if name in shown]
    gap = Line2D([], [], color="black", linestyle="", marker="|", markersize=12, label="median, 99 %, worst")
    return [*levels, *formats, gap, Line2D([], [], linestyle="", label="numbers: delta")]


def draw_row(row, result, name):
    row.suptitle(f"{result.name}: {result.triangles:,} triangles, {result.device}", x=0.01, ha="left",
                 fontweight="bold")
    row.subplots_adjust(left=0.06, right=0.98, top=0.87, bottom=0.11, wspace=0.13, hspace=0.35)
    axes = row.subplot_mosaic([["missed", "early"], ["false", "early"]], height_ratios=[1, 1.5])
    Panel(axes["missed"], result.runs, lambda run: run.missed, f"{name}.missed").draw_missed()
    Panel(axes["false"], result.runs, lambda run: run.false, f"{name}.false").draw_false()
    Panel(axes["early"], result.runs, lambda run: run.gap["p99"], f"{name}.early").draw_early()


class Panel:
    """The runs of one result: the time of the narrow phase to the right, one value of each run upward."""

    def __init__(self, axes, runs, value, name):
        self.axes, self.runs, self.value, self.name = axes, runs, value, name
        self.series = {}  # level and position format to their runs
        for run in runs:
            self.series.setdefault((run.level, run.position_format), []).append(run)
        axes.grid(True)
        self.scale_time()

    def draw_missed(self):
        self.scale_values([run.missed for run in self.runs], lowest_decade=0)
        self.axes.axhspan(1, self.axes.get_ylim()[1], color=ALARM_PAPER, zorder=0)
        self.draw_series()
        self.axes.tick_params(labelbottom=False)
        self.axes.set(title="Missed contacts", xlabel="")

    def draw_false(self):
        self.scale_values([run.false for run in self.runs], lowest_decade=0)
        self.draw_series()
        self.label_deltas(self.labels())
        self.axes.set_title("False contacts")

    def draw_early(self):
        values = [value for run in self.runs for value in run.gap.values()]
        self.scale_values(values, min([-1, *(math.floor(math.log10(value)) for value in values if value > 0)]))
        for run in self.runs:
            median, p99, worst = (run.gap[part] for part in ("median", "p99", "worst"))
            self.axes.errorbar(run.narrow_ms, p99, [[p99 - median], [worst - p99]], color=LEVEL_COLOURS[run.level],
                               linewidth=1.2, capsize=3, fmt="none", zorder=2)
        self.draw_series()
        labels = self.labels()
        self.label_late(labels)
        self.label_deltas(labels)
        self.axes.set_title("Time of impact: how early, as a fraction of the step")

    def scale_time(self):
        times = [run.narrow_ms for run in self.runs if run.narrow_ms > 0] or [1]
        axis = self.axes.xaxis
        self.axes.set_xscale("log")
        self.axes.set_xlim(min(times) / 1.8, max(times) * 1.8)
        axis.set_major_locator(LogLocator(subs=(1, 2, 5) if max(times) < 200 * min(times) else (1,)))
        axis.set_minor_locator(NullLocator())
        axis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
        self.axes.set_xlabel("narrow phase [ms]")

    def scale_values(self, values, lowest_decade):
        """A logarithmic axis with a row for 0 below the lowest decade."""
        low = 10.0**lowest_decade
        decades = [math.ceil(math.log10(value) - 1e-9) for value in values if value > 0]
        highest_decade = max([lowest_decade + 1, *decades])
        self.axes.set_yscale("symlog", linthresh=low, linscale=0.6)
        self.axes.set_ylim(-0.5 * low, 1.6 * 10.0**highest_decade)
        self.axes.axhline(0.5 * low, color=MUTED, linewidth=0.8, linestyle="--")
        stride = math.ceil((highest_decade - lowest_decade + 1) / MAX_TICKS)
        ticks = [0, *(10.0**decade for decade in range(lowest_decade, highest_decade + 1, stride))]
        self.axes.yaxis.set_major_locator(FixedLocator(ticks))
        self.axes.yaxis.set_minor_locator(NullLocator())
        self.axes.yaxis.set_major_formatter(FuncFormatter(tick_text))

    def draw_series(self):
        """One line each, whose name is its id in an SVG file."""
        for (level, position_format), runs in reversed(self.series.items()):  # so that fast, alone, lies on top
            self.axes.plot([run.narrow_ms for run in runs], [self.value(run) for run in runs], linewidth=1.2, zorder=3,
                           color=LEVEL_COLOURS[level], marker=MARKERS[position_format], markersize=7,
                           markeredgecolor="white", gid=f"{self.name}.{level}.{position_format}")

    def point(self, run):
        return run.narrow_ms, self.value(run)

    def labels(self):
        return Labels(self.axes, [self.point(run) for run in self.runs])

    def label_late(self, labels):
        for run in self.runs:
            if run.late:
                labels.put(f"{run.late:,} late", self.point(run), (RIGHT, LEFT, ABOVE, BELOW), size=9, color=ALARM,
                           fontweight="bold")

    def label_deltas(self, labels):
        """Of the fastest series on its left and of the slowest on its right; those between have the same order."""
        joined = [runs for runs in self.series.values() if len(runs) > 1 and runs[0].delta is not None]
        if not joined:
            return
        fastest = min(joined, key=lambda runs: min(run.narrow_ms for run in runs))
        slowest = max(joined, key=lambda runs: max(run.narrow_ms for run in runs))
        for runs, places in ((fastest, (LEFT, ABOVE, BELOW)), (slowest, (ABOVE, RIGHT, BELOW))):
            for run in runs:
                labels.put(delta_text(run.delta), self.point(run), places, color=LEVEL_COLOURS[run.level])


def tick_text(value, _):
    exponent = round(math.log10(value)) if value > 0 else 0
    return f"{value:,g}" if -3 < exponent < 5 else f"$10^{{{exponent}}}$"


def delta_text(delta):
    """A delta in short form, such as "1e-6"; the daemon's own choice is "auto"."""
    if delta == 0:
        return "auto"
    mantissa, exponent = f"{delta:.5e}".split("e")
    return f"{delta:g}" if int(exponent) >= -1 else f"{float(mantissa):g}e{int(exponent)}"
