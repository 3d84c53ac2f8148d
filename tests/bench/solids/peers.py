#!/usr/bin/env python3
"""Compares what collided tells of solids with libigl, trimesh, FCL and NVIDIA Warp: wrong answers, and time.

usage: peers.py [--server ADDRESS | --daemon PROGRAM] [--triangles N] [--rounds N] [--seconds N] [--date DATE] [--commit COMMIT]

The others come from PyPI: libigl, trimesh, rtree, embreex, python-fcl, warp-lang. What is not installed is skipped. The result is JSON, to
standard output. Exact arithmetic of the script's own (exact_solid.py) is the judge, of small meshes that touch, or nearly do
(peer_cases.py), and of two bumpy balls of about N triangles each. An answer is wrong where

- `inside`: a vertex that is on no triangle is said to be inside and is not, or the other way round;
- `on_surface`: a vertex on a triangle is said to be inside (not counted with the others: libraries leave this open);
- `depth`: of the vertices that are inside, the depth is off by more than 1e-9 of it, or the vertex is said to be outside;
  `depth_at_1e-5` is the same with a tolerance for single precision;
- `state`: a pair is said to be in another state. Of a library that knows "apart" and "not apart" no more is asked;
- `deepest`: the depth of a pair is not that of its deepest vertex, by more than 1e-9 of it.

Times are of all vertices of both balls against the other ball, on one thread: of rounds in which all take turns, the median. `with_build`
begins with arrays, and makes the scene or the tree. `again` asks the same meshes again; collided builds its hierarchy in each frame all the same.
`cpu` is the time of the processor, of this process and the daemon's: on a shared machine the one to compare.
"""

import argparse
import contextlib
import importlib.metadata
import json
import math
import os
import statistics
import sys
import time

for _name in ("IGL_NUM_THREADS", "OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):  # before what reads them is imported
    os.environ[_name] = "1"

import numpy as np  # noqa: E402

import collided  # noqa: E402
from collided.connection.own_daemon import OwnDaemon  # noqa: E402
from exact_solid import ExactSolid  # noqa: E402
from peer_cases import small_cases, two_balls  # noqa: E402
from peer_lanes import LANES, Answer  # noqa: E402

_STATES = {collided.PairState.TOUCHING: "touching", collided.PairState.OVERLAPPING: "overlapping",
           collided.PairState.FIRST_INSIDE: "first inside", collided.PairState.SECOND_INSIDE: "second inside"}
_DEPTH, _SINGLE_DEPTH = 1e-9, 1e-5  # relative


class Collided:
    """A scene of both meshes. Frames answer depths of the vertices inside, and the pair's state if `asks_state`."""

    library, keeps_tree, one_in = "collided", True, 1

    def __init__(self, server, asks_state):
        self.server, self.asks_state = server, asks_state
        self.name = "vertex-solid contacts" + (" and states of pairs" if asks_state else "")
        self.answers = ("inside", "depth", *(("state", "deepest") if asks_state else ()))

    def build(self, first, second, one_in=1):
        meshes = {"first": collided.Mesh(*first, solid=True, self_contacts=False), "second": self._second(second)}
        fields = ["elements", "distance"] + (["pair_states"] if self.asks_state else [])
        session = collided.Session(meshes, server=self.server, mode="dcd", kinds=["vs"], position_format="f64", reuse="off", fields=fields)
        return session, first, second

    @staticmethod
    def _second(shape):
        if len(shape.triangles):
            return collided.Mesh(*shape, solid=True, self_contacts=False)
        return collided.Mesh(shape.vertices, points=np.arange(len(shape.vertices)))

    def ask(self, built):
        session, first, second = built
        contacts = session.step({"first": first.vertices, "second": second.vertices})
        counts = len(first.vertices), len(second.vertices)
        depths = np.full(sum(counts), np.nan)
        depths[contacts.elements[:, 0]] = -contacts.distance
        of_first, of_second = np.split(depths, [counts[0]])
        answer = Answer([~np.isnan(of_second), ~np.isnan(of_first)], [of_second, of_first])
        if self.asks_state:
            pair = contacts.pairs.between("first", "second")
            answer.state, answer.deepest = (_STATES[pair.state], pair.depth) if pair else ("apart", 0.0)
        return answer

    @staticmethod
    def close(built):
        built[0].close()


class Truth:
    """Places of the vertices of each mesh in the other one."""

    def __init__(self, case):
        pairs = [(case.first, case.second), (case.second, case.first)][:2 if len(case.second.triangles) else 1]
        self.places = [[exact.place(point) for point in points.vertices]
                       for exact, points in ((ExactSolid(*solid), points) for solid, points in pairs)]
        depths = [place.squared_distance for places in self.places for place in places if place.is_inside]
        self.deepest = max(depths, default=None)
        self.state = case.state if case.state != "by vertices" else "overlapping" if depths else "apart"


class Score:
    """Counts wrong answers."""

    def __init__(self, answers):
        names = [name for kind in answers for name in
                 {"inside": ("inside", "on_surface"), "depth": ("depth", "depth_at_1e-5")}.get(kind, (kind,))]
        self.counts = {name: {"wrong": 0, "of": 0} for name in names}

    def count(self, name, is_right):
        self.counts[name]["of"] += 1
        self.counts[name]["wrong"] += not is_right

    def judge(self, truth, answer, one_in=1):
        """Returns how many answers were wrong that are counted without tolerance for single precision."""
        before = self.wrong()
        for places, inside, depths in zip(truth.places, answer.inside, answer.depths):
            for place, is_inside, depth in zip(places[::one_in], inside, depths, strict=True):
                self._judge_vertex(place, bool(is_inside), float(depth))
        if "state" in self.counts and truth.state and answer.state is not None:
            expected = truth.state if answer.state != "not apart" else "apart" if truth.state == "apart" else "not apart"
            self.count("state", answer.state == expected)
        if "deepest" in self.counts and truth.deepest and answer.deepest is not None:
            self.count("deepest", _is_near(answer.deepest, truth.deepest, _DEPTH))
        return self.wrong() - before

    def _judge_vertex(self, place, is_inside, depth):
        if place.is_on:
            self.count("on_surface", not is_inside)
            return
        self.count("inside", is_inside == place.is_inside)
        if place.is_inside:
            for name, tolerance in (("depth", _DEPTH), ("depth_at_1e-5", _SINGLE_DEPTH)):
                self.count(name, is_inside and _is_near(depth, place.squared_distance, tolerance))

    def wrong(self):
        return sum(count["wrong"] for name, count in self.counts.items() if name != "depth_at_1e-5")


def _is_near(depth, squared, tolerance):
    exact = math.sqrt(squared)
    return abs(depth - exact) <= tolerance * exact


class Clock:
    """Milliseconds on the wall, and of the processor: of this process and of the daemon's, where it is our own."""

    def __init__(self, daemon):
        self.daemon = daemon

    def cpu(self):
        seconds = time.process_time()
        if self.daemon is not None:
            seconds += time.clock_gettime(~self.daemon.pid << 3 | 2)  # as clock_getcpuclockid() has it
        return seconds

    def time(self, work):
        wall, cpu = time.perf_counter(), self.cpu()
        out = work()
        return out, {"wall_ms": 1e3 * (time.perf_counter() - wall), "cpu_ms": 1e3 * (self.cpu() - cpu)}


def judge_small_cases(lane, cases):
    score, wrong = Score(lane.answers), {}
    for case, truth in cases:
        built = lane.build(case.first, case.second)
        name = case.name.partition(", a corner")[0]
        wrong[name] = wrong.get(name, 0) + score.judge(truth, lane.ask(built))
        lane.close(built)
    return {**score.counts, "wrong_by_case": {name: count for name, count in wrong.items() if count}}


def time_balls(lanes, case, clock, rounds, seconds):
    """Returns the last answer and the times of each lane. A lane that has taken `seconds` of the processor takes part no more."""
    answers, times = {}, {lane: {"with_build": [], "again": []} for lane in lanes}
    for _ in range(rounds):
        for lane in lanes:
            if sum(row["cpu_ms"] for rows in times[lane].values() for row in rows) > 1e3 * seconds:
                continue
            (built, answers[lane]), row = clock.time(lambda: (built := lane.build(case.first, case.second, lane.one_in), lane.ask(built)))
            times[lane]["with_build"].append(row)
            if lane.keeps_tree:
                times[lane]["again"].append(clock.time(lambda: lane.ask(built))[1])
            lane.close(built)
            print(lane.library, lane.name, row, file=sys.stderr)
    medians = {lane: {name: {key: statistics.median(row[key] for row in rows) for key in ("wall_ms", "cpu_ms")} | {"rounds": len(rows)}
                      for name, rows in of.items() if rows} for lane, of in times.items()}
    return answers, medians


def compare(arguments, server, clock):
    lanes, skipped = [Collided(server, False), Collided(server, True)], []
    for lane in LANES:
        if not lane.is_installed():
            skipped.append({"library": lane.library, "name": lane.name, "skipped": "not installed"})
            print(f"{lane.library} {lane.name}: skipped: not installed", file=sys.stderr)
        else:
            lanes.append(lane())
    cases = [(case, Truth(case)) for case in small_cases()]
    rows = {lane: {"library": lane.library, "name": lane.name, **judge_small_cases(lane, cases)} for lane in lanes}
    balls = two_balls(arguments.triangles)
    answers, times = time_balls(lanes, balls, clock, arguments.rounds, arguments.seconds)
    truth = Truth(balls)
    for lane in lanes:
        score = Score(lane.answers)
        score.judge(truth, answers[lane], lane.one_in)
        rows[lane]["balls"] = {"one_in": lane.one_in, **score.counts, **times[lane]}
    return {"cases": len(cases), "triangles": 2 * len(balls.first.triangles), "vertices": 2 * len(balls.first.vertices),
            "inside": sum(place.is_inside for places in truth.places for place in places), "lanes": [*rows.values(), *skipped]}


def versions():
    """Returns those of the libraries, and of what trimesh uses if it is there."""
    found = {}
    for library in (*dict.fromkeys(lane.library for lane in LANES), "embreex", "rtree", "numpy"):
        with contextlib.suppress(importlib.metadata.PackageNotFoundError):
            found[library] = importlib.metadata.version(library)
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--server", help="a daemon's address; default: one of this process's own, with one thread")
    parser.add_argument("--daemon", help="the program to start; default: $COLLIDED_DAEMON, or collided on PATH")
    parser.add_argument("--triangles", type=int, default=100000, help="of each ball, about (%(default)s)")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--seconds", type=float, default=60, help="of the processor, after which a lane's rounds end (%(default)s)")
    parser.add_argument("--date", default="")
    parser.add_argument("--commit", default="")
    arguments = parser.parse_args()
    daemon = None if arguments.server else OwnDaemon("--backend", "cpu", "--threads", "1", program=arguments.daemon)
    with contextlib.redirect_stdout(sys.stderr):  # where Warp reports what it compiles
        found = compare(arguments, arguments.server or daemon.address, Clock(daemon))
    if daemon is not None:
        daemon.stop()
    print(json.dumps({"format": "collided solids peers 1", "date": arguments.date, "commit": arguments.commit, "device": "CPU, 1 thread",
                      "versions": versions(), **found}, indent=1))


if __name__ == "__main__":
    main()
