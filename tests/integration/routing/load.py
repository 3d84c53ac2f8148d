"""Sessions under load: each streams frames whose contacts are known, until it is told to stop."""

import threading
import time

import numpy as np
from support import TIP, lowered, meshes

import collided

DEPTH = 4
WINDOW = 3


class Load:
    """One session and its thread. The tip goes down and up again; a frame that is lost or comes twice changes the contacts
    of the next one."""

    def __init__(self, server, **options):
        self.session = collided.Session(meshes(), server=server, window=WINDOW, transport="grpc", **options)
        self.answered = 0
        self.longest_wait = 0.0  # seconds between two answers
        self.failure = None
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    @property
    def daemon(self):
        """Its name, which begins the scene's id."""
        return self.session.scene.id.partition(".")[0]

    def _frames(self):
        down = True
        while not self._over.is_set():
            yield {"tip": lowered(DEPTH) if down else TIP}
            down = not down

    def _run(self):
        try:
            last = time.monotonic()
            for contacts in self.session.run(self._frames()):
                self.answered += 1
                now = time.monotonic()
                self.longest_wait = max(self.longest_wait, now - last)
                last = now
                self._check(contacts)
        except Exception as failure:  # for the test
            self.failure = failure

    def _check(self, contacts):
        expected = 1 / DEPTH if self.answered % 2 else 1 - 1 / DEPTH
        if contacts.frame_id != self.answered or contacts.elements.tolist() != [[3, 0]] or \
                not np.allclose(contacts.toi, [expected], atol=1e-3):
            raise AssertionError(f"frame {self.answered}: {contacts}, {contacts.toi}, expected t = {expected}")

    def finish(self):
        self._over.set()
        self._thread.join()
        self.session.close()
