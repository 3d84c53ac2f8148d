#!/usr/bin/env python3
"""Some attacks of the catalogue at once, in a process of their own, until standard input ends.

usage: attack.py TARGET_AS_JSON NAME...

Prints "on" once each has done something, and at the end, as JSON, what became of each one's tries.
"""

import dataclasses
import json
import os
import sys
import threading
import time

from attacks.catalogue import ATTACKS, Target, Told

BEGIN_SECONDS = 20
END_SECONDS = 6
REFUSED_PAUSE = 0.01


def load():
    from attacks import calls, http2, http2_windows, local, scenes, self_check, work  # noqa: F401


def seen_by(target, attack):
    return dataclasses.replace(target, source=target.source or attack.source)


def keep_on(attack, target, told, over):
    import collided
    import grpc
    while not over.is_set():
        try:
            attack.round(target, told, over)
        except (OSError, grpc.RpcError, collided.Error) as error:  # what a daemon may do to it
            told.of(error)
            over.wait(REFUSED_PAUSE)
        except Exception as error:  # noqa: BLE001: a mistake of the attack's own
            told.bug = repr(error)
            return


def main():
    load()
    os.nice(5)  # in life it would have cores of its own
    target, attacks = Target(**json.loads(sys.argv[1])), [ATTACKS[name] for name in sys.argv[2:]]
    over, told = threading.Event(), {attack.name: Told() for attack in attacks}
    threads = [threading.Thread(target=keep_on, args=(attack, seen_by(target, attack), told[attack.name], over))
               for attack in attacks]
    deadline = time.monotonic() + BEGIN_SECONDS
    for attack, thread in zip(attacks, threads):
        thread.daemon = True
        thread.start()
        # Each gets what it begins with before the next: those that take all of a client's turns or places come last.
        while not told[attack.name] and time.monotonic() < deadline:
            time.sleep(0.01)
    print("on", flush=True)
    sys.stdin.read()
    over.set()
    deadline = time.monotonic() + END_SECONDS
    for thread in threads:
        thread.join(max(0, deadline - time.monotonic()))
    print(json.dumps({name: {"did": one, "met": one.met, "bug": one.bug} for name, one in told.items()}), flush=True)
    os._exit(0)  # calls that hang hold nobody up


if __name__ == "__main__":
    main()
