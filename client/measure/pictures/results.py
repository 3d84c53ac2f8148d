"""Result files, read and checked."""

import dataclasses
import json
import math

TRADEOFF_FORMAT = "collided tradeoff 1"
ADVANCE_FORMAT = "collided advance 1"
STREAMS_FORMAT = "collided streams 1"
OVERLOAD_FORMAT = "collided overload 1"
FORMATS = (TRADEOFF_FORMAT, ADVANCE_FORMAT, STREAMS_FORMAT, OVERLOAD_FORMAT)
DELIVERIES = ("lossless", "latest-wins")
LEVELS = ("fast", "guarded", "certified", "exact")
POSITION_FORMATS = ("f32", "f64", "q16")


class BadResult(Exception):
    """Names the file and what is wrong with it."""


@dataclasses.dataclass
class Run:
    """One level, delta and position format of a tradeoff."""
    level: str
    position_format: str
    delta: float | None  # none for a level without; 0: the daemon's own choice
    narrow_ms: float
    missed: int
    false: int
    late: int
    gap: dict  # how early times of impact are, as fractions of the step: median, p99, worst; 0 for times that are late


@dataclasses.dataclass
class Tradeoff:
    name: str
    device: str
    triangles: int
    runs: list[Run]


@dataclasses.dataclass
class Simulation:
    """How far each step of a simulation went."""
    name: str
    position_format: str
    crossings: int
    advanced: list[float]


@dataclasses.dataclass
class Curve:
    """One scene's throughput and latency against its number of streams."""
    label: str
    streams: list[float]
    frames_per_second: list[float]
    p50_ms: list[float]
    p99_ms: list[float]


@dataclasses.dataclass
class Overload:
    """Rates below and past the highest one within the bound on p99, with one delivery."""
    delivery: str
    device: str
    bound_ms: float
    fractions: list[float]  # frames due, as parts of the highest rate
    answered: list[float]  # likewise
    latency_p99_ms: list[float]  # from when a frame was due
    service_p99_ms: list[float]  # from when it was sent


@dataclasses.dataclass
class Results:
    tradeoffs: list[Tradeoff]
    simulations: list[Simulation]
    curves: list[Curve]
    overloads: list[Overload]
    runs: list[dict]  # of `collidectl bench` and `collided_bench --compare-engines`, each with its device


def finite(value):
    """`value`, if it is a finite number."""
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise ValueError(f"{value!r} is not a finite number")
    return value


def number(value):
    """`value`, if it is a finite number of at least 0."""
    if finite(value) < 0:
        raise ValueError(f"{value!r} is less than 0")
    return value


def known(word, words):
    if word not in words:
        raise ValueError(f"{word!r} is not one of {', '.join(words)}")
    return word


def tradeoff_run(run):
    contacts = run["contacts"]
    gap = contacts["toi_gap"] or dict.fromkeys(("median", "p99", "worst"), 0.0)
    return Run(level=known(run["level"], LEVELS), position_format=known(run["position_format"], POSITION_FORMATS),
               delta=None if run["delta"] is None else number(run["delta"]),
               narrow_ms=number(run["median_ms"]["narrow"]), missed=number(contacts["sum"]["missed"]),
               false=number(contacts["sum"]["false"]), late=number(contacts["sum"]["late"]),
               gap={part: max(0.0, finite(gap[part])) for part in ("median", "p99", "worst")})


def tradeoff(result):
    runs = [tradeoff_run(run) for run in result["runs"]]
    if not runs:
        raise ValueError("it has no runs")
    return Tradeoff(str(result["name"]), str(result["device"]), number(result["triangles"]), runs)


def simulation(run):
    return Simulation(str(run["simulation"]), known(run["scalar"], POSITION_FORMATS), number(run["crossings"]),
                      [number(fraction) for fraction in run["advanced"]])


def curve(result, scene):
    runs = [run for run in result["runs"] if run["scene"] == scene]
    columns = {name: [number(run[name]) for run in runs] for name in ("streams", "frames_per_second", "p50_ms", "p99_ms")}
    return Curve(f"{scene}: {number(runs[0]['triangles']):,} triangles", **columns)


def overload(result, delivery):
    runs = [run for run in result["rates"] if run["delivery"] == delivery]
    highest = number(result["highest_per_second"])
    columns = {name: [number(run[name]) for run in runs] for name in ("latency_p99_ms", "service_p99_ms")}
    return Overload(known(delivery, DELIVERIES), str(result["device"]), number(result["p99_ms"]),
                    fractions=[number(run["fraction"]) for run in runs],
                    answered=[number(run["answered_per_second"]) / highest for run in runs], **columns)


def step_run(run, device):
    """The run with its device, checked: not all runs have stages, times and memory."""
    for name in ("scene", "engine"):
        if not isinstance(run[name], str):
            raise ValueError(f"{name} is {run[name]!r}, not a name")
    number(run["triangles"])
    number(run["counts"]["tests"])
    for ms in [*run.get("stage_ms", {}).values(), *run.get("step_ms", {}).values(), run.get("device_bytes", 0)]:
        number(ms)
    return {"device": device, **run}


def parse(text, path):
    try:
        return json.loads(text)
    except json.JSONDecodeError as error:
        raise BadResult(f"{path}: is not JSON: {error}") from None


def add_file(path, results):
    with open(path, encoding="utf-8") as file:
        result = parse(file.read(), path)
    if not isinstance(result, dict) or not {"runs", "rates"} & result.keys():
        raise BadResult(f"{path}: is not a measurement result: it has no 'runs'")
    try:
        if "format" not in result:
            results.runs += [step_run(run, result["device"]) for run in result["runs"]]
        elif known(result["format"], FORMATS) == TRADEOFF_FORMAT:
            results.tradeoffs.append(tradeoff(result))
        elif result["format"] == ADVANCE_FORMAT:
            results.simulations += map(simulation, result["runs"])
        elif result["format"] == OVERLOAD_FORMAT:
            results.overloads += [overload(result, delivery) for delivery in dict.fromkeys(run["delivery"] for run in result["rates"])]
        else:
            results.curves += [curve(result, scene) for scene in dict.fromkeys(run["scene"] for run in result["runs"])]
    except KeyError as missing:
        raise BadResult(f"{path}: is not a measurement result: {missing} is missing") from None
    except (AttributeError, TypeError, ValueError) as error:
        raise BadResult(f"{path}: is not a measurement result: {error}") from None


def read_results(paths):
    """Throws BadResult, and OSError for a file that cannot be read."""
    results = Results([], [], [], [], [])
    for path in paths:
        add_file(path, results)
    if len(devices := sorted({run["device"] for run in results.runs})) > 1:
        raise BadResult(f"one picture shows one device; the results are of {' and '.join(devices)}")
    return results
