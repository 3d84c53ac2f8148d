"""Throughput and latency against the number of streams: a line for each scene."""

from .canvas import COLOURS, MUTED, plt

WIDTH, HEIGHT = 10, 4  # inches


def pictures(curves):
    """Name to figure; nothing without results."""
    return {"streams": draw(curves)} if curves else {}


def draw(curves):
    figure, (rate, latency) = plt.subplots(1, 2, figsize=(WIDTH, HEIGHT))
    for curve, colour in zip(curves, COLOURS):
        rate.plot(curve.streams, curve.frames_per_second, color=colour, marker="o", markersize=4, label=curve.label)
        latency.plot(curve.streams, curve.p99_ms, color=colour, marker="o", markersize=4)
        latency.plot(curve.streams, curve.p50_ms, color=colour, linestyle=":", linewidth=1)
    for axes, title in ((rate, "frames a second, all streams"), (latency, "ms a frame: 99th percentile, median dotted")):
        axes.set_title(title)
        axes.set_xscale("log", base=2)
        axes.set_yscale("log")
        axes.set_xticks(sorted({count for curve in curves for count in curve.streams}))
        axes.xaxis.set_major_formatter("{x:.0f}")
        axes.set_xlabel("streams, two frames in flight each", color=MUTED)
        axes.grid(True)
    rate.legend()
    figure.tight_layout()
    return figure
