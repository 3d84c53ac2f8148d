#!/usr/bin/env python3
"""Many streams of small scenes over several devices of a daemon, beside the same on one of them, by `collidectl load`.

usage: placement_bench.py DAEMON COLLIDECTL [--devices ID ...] [--streams N] [--scene NAME] [--scale F] [--seconds S] [--turns N]
                          [--out FILE] [--date DATE] [--commit COMMIT]

Every stream keeps two frames in flight (closed loop). The daemon, which places the scenes, is its own, a new one for each
measurement: with the first device, with the first two, four and so on, and with all, in turns. `speedup` is frames a second
over those of one device, of the medians over the turns.
"""

import statistics
import sys

from measured_daemon import daemon, parser_of, report, result_of, started

WARM_UP = 100  # frames, in which a scene compares engines


def load(arguments, devices):
    backend = devices[0].partition(":")[0]
    with daemon(arguments.daemon, backend, "--device", ",".join(devices)) as address:
        return result_of(started([arguments.collidectl, "load", "--scene", arguments.scene, "--scale", str(arguments.scale),
                                  "--server", address, "--backend", backend, "--clients", str(arguments.streams),
                                  "--closed-loop", "--warm-up", str(WARM_UP), "--seconds", str(arguments.seconds), "--json"]))


def counts(devices):
    """1, 2, 4, ... and all."""
    return sorted({2**i for i in range(devices.bit_length()) if 2**i <= devices} | {devices})


def measure(arguments):
    found = {count: [] for count in counts(len(arguments.devices))}
    for turn in range(arguments.turns):
        for count, results in found.items():
            results.append(load(arguments, arguments.devices[:count]))
            print(turn, count, results[-1]["throughput"]["frames_per_second"], file=sys.stderr)
    rates = {count: [result["throughput"]["frames_per_second"] for result in results] for count, results in found.items()}
    one, scene = statistics.median(rates[1]), found[1][0]["input"]["scene"]
    return {"format": "collided placement 1", "date": arguments.date, "commit": arguments.commit,
            "device": scene["device"], "devices": arguments.devices, "streams": arguments.streams, "scene": arguments.scene,
            "triangles": scene["triangles"], "seconds": arguments.seconds,
            "runs": [{"devices": count, "frames_per_second": rates[count], "speedup": statistics.median(rates[count]) / one,
                      "p99_ms": [result["service_ms"]["p99"] for result in results]} for count, results in found.items()]}


def main():
    parser = parser_of(__doc__)
    parser.add_argument("--devices", nargs="+", default=["cuda:0", "cuda:1"], metavar="ID")
    parser.add_argument("--streams", type=int, default=400)
    parser.add_argument("--scene", default="reef_knot")
    parser.add_argument("--scale", type=float, default=0.15, help="triangles grow with its square")
    parser.add_argument("--seconds", type=float, default=10)
    parser.add_argument("--turns", type=int, default=2)
    arguments = parser.parse_args()
    report(measure(arguments), arguments.out)


if __name__ == "__main__":
    main()
