#!/usr/bin/env python3
"""The highest rate and the most streams of a daemon under a bound on p99, and what happens past them, by `collidectl load`.

usage: overload_bench.py DAEMON COLLIDECTL [--backend auto|cpu|cuda] [--scene NAME] [--scale F] [--streams N] [--p99 TIME]
                         [--seconds S] [--out FILE] [--date DATE] [--commit COMMIT]

First the highest rate of N streams that holds the bound; then parts and multiples of it, both with lossless delivery
and with latest-wins: frames a second that are due, answered and skipped, latency from when a frame was due, and service
time from when it was sent. Then ever more streams at 30 frames a second each, until the bound breaks. The daemon is its
own, a new one for each measurement.
"""

import sys

from measured_daemon import daemon, parser_of, report, result_of, started

FRACTIONS = (0.25, 0.5, 0.75, 0.9, 1, 1.1, 1.25, 1.5, 2, 3)
DELIVERIES = ("lossless", "latest-wins")
EACH_RATE = 30  # frames a second of a stream
MOST_STREAMS = 4096
WARM_UP = 60  # frames


def load(arguments, *options):
    with daemon(arguments.daemon, arguments.backend) as address:
        return result_of(started([arguments.collidectl, "load", "--scene", arguments.scene, "--scale", str(arguments.scale),
                                  "--server", address, "--backend", arguments.backend, "--json", *map(str, options)]),
                         may_refuse=True)


def at_rate(arguments, streams, each, *options):
    result = load(arguments, "--clients", streams, "--rate", each, "--seconds", arguments.seconds + WARM_UP / each,
                  "--warm-up", WARM_UP, "--drain-seconds", 1, *options)
    frames, seconds = result["frames"], result["throughput"]["seconds"]
    return {"streams": streams, "due_per_second": streams * each,
            "answered_per_second": result["throughput"]["frames_per_second"],
            "skipped_per_second": frames["skipped"] / seconds, "refused": frames["refused"],
            **{f"{kind}_{name}_ms": result[f"{kind}_ms"][name] for kind in ("latency", "service") for name in ("p50", "p99")}}


def rates(arguments, highest):
    for delivery in DELIVERIES:
        for fraction in FRACTIONS:
            run = at_rate(arguments, arguments.streams, fraction * highest / arguments.streams, "--delivery", delivery)
            print(delivery, fraction, run, file=sys.stderr)
            yield {"delivery": delivery, "fraction": fraction, **run}


def crowds(arguments, bound_ms):
    """Up to the first one that breaks the bound."""
    streams = 1
    while streams <= MOST_STREAMS:
        run = at_rate(arguments, streams, EACH_RATE)
        print(run, file=sys.stderr)
        yield run
        if run["latency_p99_ms"] > bound_ms:
            return
        streams *= 2


def measure(arguments):
    found = load(arguments, "--clients", arguments.streams, "--find-max", "--p99", arguments.p99, "--trial-seconds", arguments.seconds)
    highest, bound = found["find_max"]["frames_per_second"], found["find_max"]["p99_ms"]
    print("highest", highest, file=sys.stderr)
    scene = found["input"]["scene"]
    return {"format": "collided overload 1", "date": arguments.date, "commit": arguments.commit, "device": scene["device"],
            "scene": arguments.scene, "triangles": scene["triangles"], "streams": arguments.streams, "p99_ms": bound,
            "seconds": arguments.seconds, "highest_per_second": highest, "rates": list(rates(arguments, highest)),
            "rate_of_each": EACH_RATE, "crowds": list(crowds(arguments, bound))}


def main():
    parser = parser_of(__doc__)
    parser.add_argument("--backend", choices=("auto", "cpu", "cuda"), default="auto")
    parser.add_argument("--scene", default="reef_knot")
    parser.add_argument("--scale", type=float, default=1, help="of the scene: triangles grow with its square")
    parser.add_argument("--streams", type=int, default=8)
    parser.add_argument("--p99", default="20ms", help="bound of the latency's 99th percentile")
    parser.add_argument("--seconds", type=float, default=2, help="of each measurement")
    arguments = parser.parse_args()
    report(measure(arguments), arguments.out)


if __name__ == "__main__":
    main()
