"""Steps of the engine: time by stage, tests by engine, and what grows with the number of triangles."""

import numpy

from .canvas import COLOURS, plt
from .runs import ENGINES, SCALE_VALUES, grouped_stages, in_order, scale_series, stage_runs, test_runs


def pictures(runs):
    """Name to figure, for each picture with data."""
    out = {}
    if stages := stage_runs(runs):
        out["stages"] = draw_stages(stages, f"{runs[0]['device']}, engine octree")
    if tests := test_runs(runs):
        out["tests"] = draw_tests(tests, runs[0]["device"])
    if series := scale_series(runs):
        out["scale"] = draw_scale(series, runs[0]["device"])
    return out


def draw_stages(runs, title):
    bars = [grouped_stages(run) for run in runs.values()]
    where, left = numpy.arange(len(bars)), numpy.zeros(len(bars))
    figure, axes = plt.subplots(figsize=(10, 1.6 + 0.42 * len(bars)))
    for group, colour in zip(bars[0], COLOURS):
        widths = numpy.array([bar[group] for bar in bars])
        if widths.any():
            axes.barh(where, widths, left=left, color=colour, label=group, height=0.7)
        left += widths
    axes.set_yticks(where, [f"{scene}\n{run['triangles']:,} triangles" for scene, run in runs.items()], fontsize=9)
    axes.invert_yaxis()
    for y, total in zip(where, left):
        axes.annotate(f"{total:.3g}", (total, y), xytext=(4, 0), textcoords="offset points", va="center", fontsize=9)
    axes.set_xlabel("time of a step by stage [ms], medians")
    axes.margins(x=0.08)
    axes.legend(ncols=4, loc="lower left", bbox_to_anchor=(0, 1))
    return finish(figure, title)


def draw_tests(runs, title):
    scenes = in_order(scene for scene, _ in runs)
    engines = in_order((engine for _, engine in runs), ENGINES)
    where, width = numpy.arange(len(scenes)), 0.8 / len(engines)
    figure, axes = plt.subplots(figsize=(max(8, 1.1 * len(scenes) + 2), 5))
    for k, engine in enumerate(engines):
        heights = [runs[scene, engine]["counts"]["tests"] if (scene, engine) in runs else numpy.nan for scene in scenes]
        axes.bar(where + (k - (len(engines) - 1) / 2) * width, heights, width, label=engine,
                 color=COLOURS[k % len(COLOURS)])
    axes.set_yscale("log")
    fewest = min(run["counts"]["tests"] for run in runs.values())
    axes.set_ylim(bottom=10 ** numpy.floor(numpy.log10(max(fewest, 1)) - 0.3))  # the shortest bar can still be seen
    axes.set_ylabel("pair tests of a step")
    axes.set_xticks(where, scenes, rotation=30, ha="right")
    axes.legend(ncols=3, loc="lower left", bbox_to_anchor=(0, 1))
    return finish(figure, title)


def draw_scale(series, title):
    scenes, engines = in_order(s for s, _ in series), in_order((e for _, e in series), ENGINES)
    figure, panels = plt.subplots(1, len(SCALE_VALUES), figsize=(14, 4.8))
    for axes, (label, value) in zip(panels, SCALE_VALUES):
        for (scene, engine), runs in series.items():  # colour stands for the engine, line and marker for the scene
            k = scenes.index(scene)
            axes.loglog([run["triangles"] for run in runs], [value(run) for run in runs],
                        color=COLOURS[engines.index(engine) % len(COLOURS)], marker="os^Dv"[k % 5],
                        linestyle=["-", "--", ":", "-."][k % 4], label=f"{scene}, {engine}")
        axes.set_xlabel("triangles")
        axes.set_ylabel(label)
        axes.grid(True)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, ncols=min(4, len(labels)), loc="upper center", bbox_to_anchor=(0.5, 0))
    return finish(figure, title)


def finish(figure, title):
    figure.suptitle(title, fontsize=12)
    figure.tight_layout()
    return figure
