"""Harm that no daemon can bear: the check must notice it."""

import os
import signal

from attacks.catalogue import SELF_CHECK, attack


@attack(SELF_CHECK)
def stopped_daemon(target, told, over):
    """The daemon is stopped with SIGSTOP."""
    os.kill(target.pid, signal.SIGSTOP)
    told["stopped"] += 1
    over.wait()
    os.kill(target.pid, signal.SIGCONT)
