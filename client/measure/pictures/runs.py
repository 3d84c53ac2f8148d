"""Which runs of `collidectl bench` and `collided_bench --compare-engines` a picture or a table shows."""

from .stage_groups import GROUPS, grouped

ENGINES = ["octree", "top-down", "bottom-up", "uniform-grid", "two-level-grid", "lbvh", "vss", "all-pairs"]
TRANSFERS = ("upload", "download")  # not part of a step
STEP_GROUPS = [group for group in GROUPS if group not in TRANSFERS]
SCALE_VALUES = [("time of a step [ms]", lambda run: run["step_ms"]["median"]),
                ("memory [MiB]", lambda run: run["device_bytes"] / 2**20),
                ("pair tests", lambda run: run["counts"]["tests"])]


def in_order(values, known=()):
    """Each value once: those of `known` first, then in order of appearance."""
    found = list(dict.fromkeys(values))
    return [v for v in known if v in found] + [v for v in found if v not in known]


def grouped_stages(run):
    groups = grouped(run["stage_ms"], concurrent_kinds=run.get("backend") == "cuda")
    return {group: groups[group] for group in STEP_GROUPS}


def smallest_size(runs):
    """The runs of each scene at its smallest size, that is, unrefined."""
    smallest = {}
    for run in runs:
        smallest[run["scene"]] = min(run["triangles"], smallest.get(run["scene"], run["triangles"]))
    return [run for run in runs if run["triangles"] == smallest[run["scene"]]]


def first_of_each(runs, *keys):
    out = {}
    for run in runs:
        out.setdefault(tuple(run[key] for key in keys), run)
    return out


def stage_runs(runs):
    """Scene to its run with the octree."""
    octree = [run for run in smallest_size(runs) if run["engine"] == "octree" and "stage_ms" in run]
    return {run["scene"]: run for run in first_of_each(octree, "scene").values()}


def test_runs(runs):
    """Scene and engine to their run."""
    return first_of_each(smallest_size(runs), "scene", "engine")


def scale_series(runs):
    """Scene and engine to their runs by size, where there are several sizes."""
    series = {}
    measured = [run for run in runs if "step_ms" in run and "device_bytes" in run]
    for run in first_of_each(measured, "scene", "engine", "triangles").values():
        series.setdefault((run["scene"], run["engine"]), []).append(run)
    return {key: sorted(of, key=lambda run: run["triangles"]) for key, of in series.items() if len(of) > 1}
