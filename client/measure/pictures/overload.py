"""A daemon below and past its highest rate: throughput and latency against the frames that are due."""

from .canvas import COLOURS, MUTED, plt

WIDTH, HEIGHT = 10, 4  # inches


def pictures(overloads):
    """Name to figure; nothing without results."""
    return {"overload": draw(overloads)} if overloads else {}


def draw(overloads):
    figure, (rate, latency) = plt.subplots(1, 2, figsize=(WIDTH, HEIGHT))
    for overload, colour in zip(overloads, COLOURS):
        label = f"{overload.delivery}, {overload.device}"
        rate.plot(overload.fractions, overload.answered, color=colour, marker="o", markersize=4, label=label)
        latency.plot(overload.fractions, overload.latency_p99_ms, color=colour, marker="o", markersize=4)
        latency.plot(overload.fractions, overload.service_p99_ms, color=colour, linestyle=":", linewidth=1)
        latency.axhline(overload.bound_ms, color=MUTED, linewidth=1)
    rate.set_title("answered, as parts of the highest rate")
    latency.set_title("p99 in ms: from when due; dotted: from when sent")
    latency.set_yscale("log")
    for axes in (rate, latency):
        axes.set_xlabel("frames due, as parts of the highest rate within the bound", color=MUTED)
        axes.grid(True)
    rate.legend()
    figure.tight_layout()
    return figure
