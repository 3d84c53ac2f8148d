#!/usr/bin/env python3
"""What frames take in two builds, their programs in turns, so that other load on the machine affects both alike.

usage: builds_bench.py BEFORE AFTER [--backend cuda|cpu] [--rows WORD ...] [--turns N] [--out FILE] [--date DATE]
                       [--commits BEFORE AFTER]

BEFORE and AFTER are build trees, or folders with collided_bench, collided and collidectl. Rows are named by what they measure;
--rows picks those whose names contain a word. Times are milliseconds, the medians of all turns; `ratio` is after / before.
Rows "engine" are whole frames in the engine, without the way to the daemon and back; rows "first frame" are the second
scene of a daemon, from the frame's arrival to its answer; rows "streams" are frames a second of all streams together.
Real frames come from COLLIDED_DATA.
"""

import argparse
import json
import pathlib
import statistics
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "streams"))
import streams_bench  # noqa: E402: beside this folder

CLOTH, FUNNEL = "cloth_ball_92_93", "cloth_funnel_227_228"
ENGINE_ROWS = {
    f"engine, auto, {CLOTH}": ["--scene", CLOTH],
    f"engine, auto, {FUNNEL}": ["--scene", FUNNEL],
    "engine, auto, nbody": ["--scene", "nbody"],
    "engine, auto, flamenco": ["--scene", "flamenco"],
    "engine, auto, one_cell": ["--scene", "one_cell"],
    "engine, auto, reef_knot of 500 triangles": ["--scene", "reef_knot", "--scale", "0.15"],
    "engine, auto, cloth_ball of 894 triangles": ["--scene", "cloth_ball", "--scale", "0.1"],
    f"engine, EXACT, {CLOTH}": ["--scene", CLOTH, "--accuracy", "exact"],
    f"engine, EXACT, {FUNNEL}": ["--scene", FUNNEL, "--accuracy", "exact"],
    f"engine, F64, {CLOTH}": ["--scene", CLOTH, "--scalar", "f64"],
    "engine, F64, nbody": ["--scene", "nbody", "--scalar", "f64"],
    "engine, octree, cloth_ball of 1,002,260 triangles": ["--scene", "cloth_ball", "--scale", "3.302", "--engine", "octree"],
}
LEVELS = {"certified": "ALL", "certified earliest": "EARLIEST_ONLY", "certified any": "ANY_HIT"}
STREAMS = (1, 4, 16, 48)


FOLDERS = (".", "bin", "tests/bench", "server", "client/cli")


def program(build, name):
    for folder in FOLDERS:
        if (build / folder / name).is_file():
            return str(build / folder / name)
    sys.exit(f"builds_bench.py: there is no {name} in {build}")


def run(build, name, *options):
    done = subprocess.run([program(build, name), *options], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"builds_bench.py: {program(build, name)} {' '.join(options)}: {done.stderr.strip()}")
    return json.loads(done.stdout)


def engine_time(build, arguments, options):
    found = run(build, "collided_bench", "--backend", arguments.backend, "--steps", str(arguments.steps), "--warm-up",
                str(arguments.warm_up), "--in-slot", *options)
    return found["scenes"][0]["total_ms"]


def level_times(build, arguments):
    """Milliseconds of all stages, by report."""
    found = run(build, "collided_bench", "--backend", arguments.backend, "--scene", arguments.levels_scene, "--steps",
                str(arguments.steps), "--compare-levels")
    return {LEVELS[level["level"]]: level["total_ms"] for level in found["scenes"][0]["levels"] if level["level"] in LEVELS}


def first_frame(build, arguments):
    """Of the daemon's second scene: nothing is loaded or begun for the first time."""
    frames = [str(file) for file in arguments.frames]
    with streams_bench.daemon(program(build, "collided"), arguments.backend) as address:
        for _ in range(2):
            found = run(arguments.after, "collidectl", "detect", "--frames", *frames, "--server", address, "--json")
    return found["total_ms"]


def stream_rate(build, arguments, streams):
    with streams_bench.daemon(program(build, "collided"), arguments.backend) as address:
        found = run(arguments.after, "collidectl", "load", "--scene", "reef_knot", "--scale", "0.15", "--server", address,
                    "--clients", str(streams), "--closed-loop", "--seconds", str(arguments.seconds), "--json")
    return found["throughput"]["frames_per_second"]


def rows_of(arguments):
    """Each row's name and measure(build), which gives a number, or one for each of several rows."""
    rows = {name: lambda build, o=options: engine_time(build, arguments, o) for name, options in ENGINE_ROWS.items()}
    rows[f"reports, {arguments.levels_scene}"] = lambda build: level_times(build, arguments)
    if arguments.frames:
        rows["first frame"] = lambda build: first_frame(build, arguments)
    for streams in STREAMS:
        rows[f"streams, {streams} of 500 triangles"] = lambda build, n=streams: stream_rate(build, arguments, n)
    return {name: measure for name, measure in rows.items() if any(word in name for word in arguments.rows)}


def by_name(name, number):
    return {f"{name}, {part}": value for part, value in number.items()} if isinstance(number, dict) else {name: number}


def measured(name, measure, arguments):
    times = {}
    for _ in range(arguments.turns):
        for when in ("before", "after"):
            for row, number in by_name(name, measure(getattr(arguments, when))).items():
                times.setdefault(row, {}).setdefault(when, []).append(number)
    rows = []
    for row, both in times.items():
        before, after = (statistics.median(both[when]) for when in ("before", "after"))
        rows.append({"row": row, "before": before, "after": after, "ratio": after / before})
        print(f"{row}: {before:.4g} -> {after:.4g} ({after / before:.2f})", file=sys.stderr)
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before", type=pathlib.Path)
    parser.add_argument("after", type=pathlib.Path)
    parser.add_argument("--backend", default="cuda", choices=["cuda", "cpu"])
    parser.add_argument("--rows", nargs="+", default=[""], metavar="WORD", help="rows whose names contain one of them")
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("--steps", type=int, default=60)
    parser.add_argument("--warm-up", type=int, default=40)
    parser.add_argument("--seconds", type=float, default=2, help="of each load")
    parser.add_argument("--levels-scene", default=CLOTH)
    parser.add_argument("--frames", nargs=2, type=pathlib.Path, metavar="MESH", help="both ends of a first frame")
    parser.add_argument("--commits", nargs=2, default=["", ""], metavar=("BEFORE", "AFTER"))
    parser.add_argument("--device", default="")
    parser.add_argument("--date", default="")
    parser.add_argument("--out", type=pathlib.Path)
    arguments = parser.parse_args()
    result = {"date": arguments.date, "commit": arguments.commits[1], "commit_before": arguments.commits[0],
              "device": arguments.device, "backend": arguments.backend, "turns": arguments.turns, "rows": []}
    for name, measure in rows_of(arguments).items():
        result["rows"] += measured(name, measure, arguments)
        if arguments.out:  # what was measured so far is worth keeping
            arguments.out.write_text(json.dumps(result, indent=1) + "\n")
    if not arguments.out:
        print(json.dumps(result, indent=1))


if __name__ == "__main__":
    main()
