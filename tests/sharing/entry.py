"""One entry of the catalogue: honest clients alone, then beside the attack, and newcomers during and after it."""

import dataclasses
import json
import pathlib
import subprocess
import sys
import threading

import collided

from honest import Clients, visit

TIMES, MORE_MS = 3, 100  # what a frame may take beside an attack: so many times as long as alone, and so much more
RECOVERY_SECONDS = 2  # that a newcomer may take after an attack which the way to the daemon does not withstand
ATTACK = str(pathlib.Path(__file__).with_name("attack.py"))
END_SECONDS = 20


class Assault:
    """Attacks in a process of their own, which are under way once this is made."""

    def __init__(self, target, names):
        self.process = subprocess.Popen([sys.executable, ATTACK, json.dumps(dataclasses.asdict(target)), *names],
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        if self.process.stdout.readline() != "on\n":
            raise RuntimeError(f"{names} did not begin")

    def end(self):
        """What became of each attack's tries."""
        try:
            out, _ = self.process.communicate("", timeout=END_SECONDS)
            return json.loads(out)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
            return {}


class Newcomer(threading.Thread):
    def __init__(self, *arguments):
        super().__init__(daemon=True)
        self.arguments, self.seconds, self.fault = arguments, None, None
        self.start()

    def run(self):
        try:
            self.seconds = round(visit(*self.arguments), 3)
        except Exception as error:  # noqa: BLE001: whatever it is, it kept the newcomer out
            self.fault = f"{type(error).__name__}: {error}"


class Stage:
    """Holds a way to a daemon, its honest clients, and their right answers. `is_timed`: a slow answer is a fault."""

    def __init__(self, way, tokens, answers, seconds, patience, is_timed=True):
        self.way, self.tokens, self.answers = way, tokens, answers
        self.seconds, self.patience, self.is_timed = seconds, patience, is_timed
        self.clients = Clients(way.server, tokens, answers)

    def has_clients(self):
        """Whether all honest clients are there; those of a failed entry are replaced, if the daemon still takes some."""
        if not self.clients.faults():
            return True
        self.clients.close()
        try:
            self.clients = Clients(self.way.server, self.tokens, self.answers)
        except collided.Error:
            return False
        return True

    def newcomer(self):
        return Newcomer(self.way.server, "token-of-newcomer", self.answers, self.patience)

    def play(self, target, names, is_withstood=True):
        """Returns the entry's figures; `faults` says why it is not as promised. `is_withstood` says that honest clients must be
        served during the attacks, and not only after them."""
        alone = self.clients.measure(self.seconds)
        assault = Assault(target, names)
        try:
            during = self.newcomer()
            beside = self.clients.measure(self.seconds, during.is_alive)
        finally:
            told = assault.end()
        after = self.newcomer()
        after.join(self.patience + 5)
        bound = TIMES * alone["p99_ms"] + MORE_MS
        entry = {"attacks": names, "peak_mb": self.way.peak_mb(), "alone": alone, "beside": beside, "bound_ms": round(bound, 1),
                 "newcomer_seconds": {"during": during.seconds, "after": after.seconds}, "attackers_saw": told}
        entry["faults"] = list(self.faults(entry, names, is_withstood, during, after))
        return entry

    def faults(self, entry, names, is_withstood, during, after):
        for name, process in self.way.processes.items():
            if process.poll() is not None:
                yield f"{name} ended with {process.returncode}"
        if self.way.max_mb and sum(entry["peak_mb"].values()) > self.way.max_mb:
            yield f"{entry['peak_mb']} MB of memory; {self.way.max_mb} would be fair"
        if is_withstood:
            yield from self.faults_beside(entry, during)
        elif self.is_timed and (after.seconds or 0) > RECOVERY_SECONDS:
            yield f"a newcomer after the attack took {after.seconds} s; {RECOVERY_SECONDS} would be fair"
        if after.seconds is None:
            yield f"a newcomer after the attack: {after.fault or 'was kept waiting'}"
        for name in names:
            told = entry["attackers_saw"].get(name)
            if not told or not told["did"] or told["bug"]:
                yield f"{name} was no attack: {told}"

    def faults_beside(self, entry, during):
        if self.is_timed and entry["beside"]["p99_ms"] > entry["bound_ms"]:
            yield f"p99 is {entry['beside']['p99_ms']} ms beside the attack; {entry['bound_ms']} would be fair"
        yield from (f"an honest client: {fault}" for fault in self.clients.faults())
        if during.seconds is None:
            yield f"a newcomer during the attack: {during.fault or 'was kept waiting'}"
