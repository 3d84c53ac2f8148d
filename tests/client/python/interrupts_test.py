#!/usr/bin/env python3
"""Sessions stay usable wherever an interrupt, such as Ctrl-C, comes."""

import gc
import linecache
import os
import signal
import sys

from support import TIP, TRANSPORTS, Case, lowered, main, meshes, np

import collided

PACKAGE = os.path.dirname(collided.__file__)


def interrupted_at(count, call):
    """Whether KeyboardInterrupt came at the count-th line that the call runs of the package."""
    def trace(frame, event, _):
        nonlocal count
        if not frame.f_code.co_filename.startswith(PACKAGE):
            return None
        # Where `with` ends a signal never comes, and a lock would stay taken.
        is_with = linecache.getline(frame.f_code.co_filename, frame.f_lineno).lstrip().startswith("with ")
        count -= event == "line" and not is_with
        if count <= 0 and event == "line" and not is_with:
            raise KeyboardInterrupt  # which ends the tracing, too
        return trace

    gc.disable()  # finalizers run lines of the package, too, and Python ignores what they raise
    sys.settrace(trace)
    try:
        call()
    except KeyboardInterrupt:
        return True
    finally:
        sys.settrace(None)
        gc.enable()
    return False


class Interrupted(Case):
    def expect_to_go_on(self, session):
        """From wherever an interrupted step to lowered(2) has left it, back to where that began."""
        if session.in_flight:
            self.assertEqual(session.in_flight, 1)
            self.expect_hit(session.receive(), 2)
        is_below = session.positions["tip"][0, 2] < 0
        np.testing.assert_array_equal(session.positions["tip"], lowered(2) if is_below else TIP)
        self.assertEqual(session.step({"tip": TIP}).toi.round(2).tolist(), [0.5] if is_below else [])

    def test_at_any_line(self):
        for transport in TRANSPORTS:
            session = self.session(transport=transport)
            session.step()
            line = 1
            while interrupted_at(line, lambda: session.step({"tip": lowered(2)})):
                self.expect_to_go_on(session)
                line += 1
            self.assertGreater(line, 50)
            session.close()

    def test_at_any_line_of_making_good_an_interrupt(self):
        for transport in TRANSPORTS:
            session = self.session(transport=transport)
            session.step()
            line, again = 60, 1

            def go_on():
                return session.receive() if session.in_flight else session.step({"tip": lowered(2)}, start={"tip": TIP})

            while True:
                self.assertTrue(interrupted_at(line, lambda: session.step({"tip": lowered(2)})))
                if not interrupted_at(again, go_on):
                    break
                self.expect_to_go_on(session)
                line, again = 30 + (line + 7) % 60, again + 3
            self.assertGreater(again, 100)
            session.close()

    def test_in_a_first_frame(self):
        for transport in TRANSPORTS:
            for line in range(1, 200, 9):
                session = self.session(transport=transport)
                interrupted_at(line, lambda: session.step({"tip": lowered(2)}))
                self.expect_to_go_on(session)
                session.close()

    def test_by_a_signal(self):
        def interrupt(*_):
            signal.setitimer(signal.ITIMER_REAL, 0)
            raise KeyboardInterrupt

        def step_until_interrupted(session, seconds):
            signal.setitimer(signal.ITIMER_REAL, seconds, 1.0)  # again, where it came while a finalizer ran
            while session:
                session.step({"tip": TIP})

        handler = signal.signal(signal.SIGALRM, interrupt)
        self.addCleanup(signal.signal, signal.SIGALRM, handler)
        for transport in TRANSPORTS:
            session = self.session(transport=transport)
            for count in range(60):
                with self.assertRaises(KeyboardInterrupt):
                    step_until_interrupted(session, 0.0004 + 0.00013 * (count % 17))
                while session.in_flight:
                    self.assertEqual(len(session.receive(timeout=60)), 0)
                self.expect_hit(session.step({"tip": lowered(2)}, timeout=60), 2)
                self.expect_to_go_on(session)
            session.close()

    def test_a_scene_is_free_once_its_interrupted_session_is_closed(self):
        scene = collided.Scene(meshes(), server=self.server)
        self.addCleanup(scene.close)
        for line in range(20, 100, 5):
            with scene.session(transport=TRANSPORTS[line % 3]) as session:
                interrupted_at(line, lambda: session.step({"tip": lowered(2)}))
            with scene.session() as session:
                self.expect_to_go_on(session)

    def test_the_steps_of_a_set(self):
        for transport in TRANSPORTS:
            batch = collided.SceneBatch(meshes(), 2, server=self.server, transport=transport)
            self.addCleanup(batch.close)
            below = np.stack([lowered(2)] * 2)
            batch.step(below)
            for line in range(40, 120, 3):
                interrupted_at(line, lambda: batch.step(below))
                self.assertEqual(len(batch.step(below, start=below + [0, 0, 2]).all), 2)


if __name__ == "__main__":
    main()
