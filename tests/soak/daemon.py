"""What a daemon holds, seen from outside, each second and at low points."""

import collections
import pathlib
import re
import threading
import time

HELD = ("scenes", "streams", "watchers", "calls_in_work", "connections", "queued_frames", "outgoing_bytes", "device_bytes")
POOL_SECONDS = 3.0  # that gRPC is given to let idle threads go
_METRIC = re.compile(r"^collided_(\w+) (\d+)(?:\.0*)?$", re.MULTILINE)
_STATUS = re.compile(r"^(VmRSS|Threads):\s+(\d+)", re.MULTILINE)


def held(daemon, names=HELD):
    """Gauges by their names; by default of what clients hold there."""
    metrics = dict(_METRIC.findall(daemon.http("/metrics")[1]))
    return {name: int(metrics[name]) for name in names}


def sample(daemon):
    """rss and heap in bytes, fds, threads and device_bytes."""
    metrics = held(daemon, ("heap_bytes", "device_bytes"))
    process = pathlib.Path("/proc", str(daemon.process.pid))
    status = dict(_STATUS.findall((process / "status").read_text()))
    return {"rss": 1024 * int(status["VmRSS"]), "heap": metrics["heap_bytes"], "fds": len(list((process / "fd").iterdir())),
            "threads": int(status["Threads"]), "device_bytes": metrics["device_bytes"]}


def threads_by_name(daemon):
    """How many threads of each name, which tells whose they are."""
    tasks = pathlib.Path("/proc", str(daemon.process.pid), "task").iterdir()
    names = []
    for task in tasks:
        try:
            names.append((task / "comm").read_text().strip())
        except OSError:  # it has ended
            pass
    return dict(sorted(collections.Counter(names).items()))


def some(values, count=600):
    """At most so many of them, evenly."""
    return values[::-(-len(values) // count) or 1]


class Sampler(threading.Thread):
    """A sample each second, until it is closed."""

    def __init__(self, daemon):
        super().__init__(daemon=True)
        self.samples, self._daemon, self._over, self._begin = [], daemon, threading.Event(), time.monotonic()
        self.start()

    def run(self):
        while not self._over.wait(1.0):
            metrics = held(self._daemon)
            self.samples.append({"second": round(time.monotonic() - self._begin, 1), **sample(self._daemon),
                                 "scenes": metrics["scenes"], "streams": metrics["streams"]})

    def close(self):
        self._over.set()
        self.join()


def wait_until_idle(daemon, first, seconds):
    """Waits until no client holds anything, then a little for descriptors and threads to be as few as at the `first` low
    point, if there was one. Returns a sample; what is held for `seconds` is told by TimeoutError, what is more is for the judge."""
    deadline = time.monotonic() + seconds
    while any((left := held(daemon)).values()):
        if time.monotonic() > deadline:
            raise TimeoutError(f"still held {seconds:.0f} s after all clients are gone: "
                               f"{ {name: value for name, value in left.items() if value} }")
        time.sleep(0.05)
    deadline = time.monotonic() + POOL_SECONDS
    while True:
        now = sample(daemon)
        if first is None or time.monotonic() > deadline or all(now[name] <= first[name] for name in ("fds", "threads")):
            return now
        time.sleep(0.05)
