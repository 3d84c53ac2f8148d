#!/usr/bin/env python3
"""Throughput and latency of a daemon against the number of streams, by `collidectl load`.

usage: streams_bench.py DAEMON COLLIDECTL [--backend auto|cpu|cuda] [--scenes small|medium|large ...] [--streams N ...]
                        [--seconds S] [--scale F] [--out FILE] [--date DATE] [--commit COMMIT]

Each scene alone with 1 to 64 streams that keep two frames in flight (closed loop): frames a second of all streams, and
the median and the 99th percentile of a frame, in ms. `mixed` is 32 streams of the small scene at 30 frames a second
each, alone and beside a stream of the large one that keeps its window full. The daemon is its own, a new one for each
measurement. The first frames of each stream, in which a scene compares engines, are not counted.
"""

import sys

from measured_daemon import daemon, parser_of, report, result_of, started

SCENES = {"small": ("reef_knot", 0.15), "medium": ("reef_knot", 1.0), "large": ("cloth_ball", 1.04)}
LIGHT_STREAMS, LIGHT_RATE = 32, 30
WARM_UP, LIGHT_WARM_UP = 100, 30  # frames


def load_command(arguments, address, scene, *options):
    name, scale = SCENES[scene]
    return [arguments.collidectl, "load", "--scene", name, "--scale", str(scale * arguments.scale), "--server", address,
            "--backend", arguments.backend, "--json", *map(str, options)]


def figures(result):
    return {"triangles": result["input"]["scene"]["triangles"],
            "frames_per_second": result["throughput"]["frames_per_second"],
            "p50_ms": result["service_ms"]["p50"], "p99_ms": result["service_ms"]["p99"],
            "latency_p99_ms": result["latency_ms"]["p99"], "device": result["input"]["scene"]["device"]}


def alone(arguments, scene, streams):
    with daemon(arguments.daemon, arguments.backend) as address:
        return figures(result_of(started(load_command(arguments, address, scene, "--clients", streams, "--closed-loop",
                                                      "--warm-up", WARM_UP, "--seconds", arguments.seconds))))


def light(arguments, with_heavy):
    """Of the light streams, beside the heavy one or not."""
    with daemon(arguments.daemon, arguments.backend) as address:
        seconds = arguments.seconds + 1.5 * LIGHT_WARM_UP / LIGHT_RATE
        heavy = started(load_command(arguments, address, "large", "--closed-loop", "--seconds",
                                     seconds + 2)) if with_heavy else None
        found = figures(result_of(started(load_command(arguments, address, "small", "--clients", LIGHT_STREAMS, "--rate",
                                                       LIGHT_RATE, "--warm-up", LIGHT_WARM_UP, "--seconds",
                                                       seconds))))
        if heavy:
            found["heavy_frames_per_second"] = figures(result_of(heavy))["frames_per_second"]
        return found


def measure(arguments):
    runs = []
    for scene in arguments.scenes:
        for streams in arguments.streams:
            runs.append({"scene": scene, "streams": streams, **alone(arguments, scene, streams)})
            print(runs[-1], file=sys.stderr)
    mixed = {"streams": LIGHT_STREAMS, "rate": LIGHT_RATE, "alone": light(arguments, False),
             "beside_heavy": light(arguments, True)}
    print(mixed, file=sys.stderr)
    device = runs[0]["device"]
    for run in [*runs, mixed["alone"], mixed["beside_heavy"]]:
        run.pop("device")
    return {"format": "collided streams 1", "date": arguments.date, "commit": arguments.commit, "device": device,
            "seconds": arguments.seconds, "runs": runs, "mixed": mixed}


def main():
    parser = parser_of(__doc__)
    parser.add_argument("--backend", choices=("auto", "cpu", "cuda"), default="auto")
    parser.add_argument("--scenes", choices=SCENES, nargs="+", default=list(SCENES))
    parser.add_argument("--streams", type=int, nargs="+", default=[1, 2, 4, 8, 16, 32, 48, 64])
    parser.add_argument("--seconds", type=float, default=3)
    parser.add_argument("--scale", type=float, default=1, help="of the scenes: triangles grow with its square")
    arguments = parser.parse_args()
    report(measure(arguments), arguments.out)


if __name__ == "__main__":
    main()
