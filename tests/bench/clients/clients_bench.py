#!/usr/bin/env python3
"""What a frame takes in Python and in C++: blocks of frames of both, in turn, so that other load affects both alike.

usage: clients_bench.py DAEMON CLIENT_FRAMES [--blocks N] [--frames N] [--side N] [--scenes few all] [--json]

Each frame brings the positions of a sheet of SIDE * SIDE vertices (296: 1 MB). `ratio` is Python's median time of a frame
over that of C++, `beyond engine` the same without the time that the daemon's engine takes. "session" is C++'s Session, which
like Python's keeps what it takes to go on after a lost daemon; "stream" is its FrameStream, which borrows positions and keeps
nothing. Rows "few" have triangles in 4 cells, so that there is little but the way there and back; rows "all" have them
everywhere, as scenes do. Rows "calls" are Python's calls for single frames beside C++ over gRPC.
"""

import argparse
import json
import statistics
import subprocess
import time

import numpy as np

import collided
from collided.connection.own_daemon import OwnDaemon

TRANSPORTS = {"grpc": "grpc", "calls": "grpc", "shared_memory": "shared_memory"}  # of Python, and of C++


def triangles(side, cells):
    corner = (np.arange(cells)[:, None] * side + np.arange(cells)).reshape(-1, 1)
    return np.concatenate([corner + [0, 1, side], corner + [1, side + 1, side]], axis=1).reshape(-1, 3)


def sheet(side, height):
    y, x = np.mgrid[:side, :side]
    return np.stack([x, y, np.full((side, side), height)], axis=2).reshape(-1, 3).astype("<f4")


class Python:
    """Frames of a Session."""

    def __init__(self, server, transport, side, cells):
        self.session = collided.Session(collided.Mesh(triangles=triangles(side, cells), vertex_count=side * side),
                                        server=server, transport=transport, position_format="f32", fields=())
        self.sheets = [sheet(side, height) for height in (0, 0.25)]
        self.sent = 0

    def frames(self, count):
        """Microseconds of each frame, and of the engine."""
        out = []
        for _ in range(count):
            begin = time.perf_counter()
            self.sent += 1
            contacts = self.session.step(self.sheets[self.sent % 2])
            out.append((1e6 * (time.perf_counter() - begin), 1e3 * contacts.metrics.engine_milliseconds))
            del contacts  # here, as in C++, which frees them after it took the time
        return out

    def close(self):
        self.session.close()


class Cpp:
    """Frames of collided_client_frames, as a "stream" or a "session"."""

    def __init__(self, program, server, transport, kind, side, cells):
        self.process = subprocess.Popen([program, server, transport, kind, str(side), str(cells)], text=True,
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE)

    def frames(self, count):
        self.process.stdin.write(f"{count}\n")
        self.process.stdin.flush()
        numbers = [float(word) for word in self.process.stdout.readline().split()]
        return list(zip(numbers[::2], numbers[1::2]))

    def close(self):
        self.process.communicate()


def compare(arguments, server, transport, cells):
    """Medians over all blocks, in microseconds."""
    lanes = {"python": Python(server, transport, arguments.side, cells)}
    for kind in ("session", "stream"):
        lanes[kind] = Cpp(arguments.client_frames, server, TRANSPORTS[transport], kind, arguments.side, cells)
    times = {name: [] for name in lanes}
    for lane in lanes.values():
        lane.frames(arguments.frames)  # warm
    for _ in range(arguments.blocks):
        for name, lane in lanes.items():
            times[name] += lane.frames(arguments.frames)
    for lane in lanes.values():
        lane.close()
    frame = {name: statistics.median(total for total, _ in own) for name, own in times.items()}
    beyond = {name: statistics.median(total - engine for total, engine in own) for name, own in times.items()}
    ratios = {f"ratio_to_{kind}": frame["python"] / frame[kind] for kind in ("session", "stream")}
    ratios_beyond = {f"ratio_to_{kind}_beyond_engine": beyond["python"] / beyond[kind] for kind in ("session", "stream")}
    return {"transport": transport, **{f"{name}_us": time for name, time in frame.items()}, **ratios,
            **{f"{name}_beyond_us": time for name, time in beyond.items()}, **ratios_beyond}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("daemon")
    parser.add_argument("client_frames")
    parser.add_argument("--blocks", type=int, default=20)
    parser.add_argument("--frames", type=int, default=25)
    parser.add_argument("--side", type=int, default=296)
    parser.add_argument("--scenes", nargs="+", default=["few", "all"], choices=["few", "all"])
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    rows = []
    daemon = OwnDaemon(program=arguments.daemon)
    scenes = {"few": 4, "all": arguments.side - 1}
    for scene, cells in ((name, cells) for name, cells in scenes.items() if name in arguments.scenes):
        rows += [{"scene": scene, **compare(arguments, daemon.address, transport, cells)} for transport in TRANSPORTS]
    daemon.stop()
    if arguments.json:
        print(json.dumps({"side": arguments.side, "rows": rows}))
        return
    print("scene transport       Python session stream   ratios      | beyond the engine: Python session stream   ratios")
    for row in rows:
        print(f"{row['scene']:5} {row['transport']:13} {row['python_us']:8.0f} {row['session_us']:7.0f} {row['stream_us']:6.0f}"
              f" {row['ratio_to_session']:7.2f} {row['ratio_to_stream']:5.2f} | {row['python_beyond_us']:25.0f}"
              f" {row['session_beyond_us']:7.0f} {row['stream_beyond_us']:6.0f} {row['ratio_to_session_beyond_engine']:7.2f}"
              f" {row['ratio_to_stream_beyond_engine']:5.2f}")


if __name__ == "__main__":
    main()
