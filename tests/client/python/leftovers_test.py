#!/usr/bin/env python3
"""Objects that callers forget to close: their scenes are deleted, warnings name them, and no process waits at its end.

Prints how long the end of a process takes for each kind of thing that was left open.
"""

import asyncio
import gc
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import warnings
from unittest import mock

from support import ONE, STREAMS, TIP, TRANSPORTS, Case, Supervised, lowered, main, meshes, skip_if_forks_hang

import collided
from collided import leftovers, stream

END_SECONDS = 4  # far above the 0.5 s that are promised, for busy machines

# Programs end with one of these, and leave `left` open. `frozen` daemons answer nothing any more.
BEGIN = """
import asyncio, os, signal, sys, threading, time
import numpy as np, collided
from collided.connection.own_daemon import OwnDaemon
FLOOR = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0]], "f4")
TIP = np.array([[1, 1, 1], [1.25, 1, 9], [1, 1.25, 9]], "f4")
meshes = {"floor": collided.Mesh(FLOOR, [[0, 1, 2]], motion="static"), "tip": collided.Mesh(TIP, [[0, 1, 2]])}
"""
END = "print(time.monotonic(), flush=True)\n"

PROGRAMS = {
    "nothing": "pass\n",
    **{f"session over {way}, a frame in flight":
       f"left = collided.Session(meshes, transport='{way}'); left.step(); left.send(TIP)\n" for way in TRANSPORTS},
    "session in a daemon thread": "left = collided.Session(meshes)\ndef work():\n    try:\n        while True: left.step()\n"
    "    except collided.Error: pass\nthreading.Thread(target=work, daemon=True).start(); time.sleep(0.05)\n",
    "scene": "left = collided.Scene(meshes)\n",
    "many sessions": "left = [collided.Session(meshes) for _ in range(12)]\n",
    "batch": "left = collided.SceneBatch(meshes, 3); left.step(np.stack([TIP] * 3))\n",
    "watcher": "left = collided.Scene(meshes); other = left.watch(); print(other.receive(0.01))\n",
    "asyncio": "async def main():\n    global left\n    left = await collided.aio.Session(meshes).__aenter__()\n"
    "    await left.send(TIP)\nasyncio.run(main())\n",
    "asyncio that waits": "async def main():\n    global left\n    left = await collided.aio.Session(meshes).__aenter__()\n"
    "    left._thread.start(threading.Event().wait)\n    await asyncio.sleep(0.01)\nasyncio.run(main())\n",
    "an exception": "left = collided.Session(meshes); left.send(TIP)\nsys.excepthook = lambda *_: print(time.monotonic(), flush=True)\n"
    "raise ValueError\n",
}


def ended(program, **environment):
    """Runs it. Seconds that its end took, what it wrote to standard error."""
    with tempfile.TemporaryDirectory(dir="/tmp") as folder:
        done = subprocess.run([sys.executable, "-W", "always::ResourceWarning", "-c", BEGIN + program + END], text=True,
                              capture_output=True, timeout=60, env={**os.environ, "TMPDIR": folder, **environment})
        now = time.monotonic()
        if "ValueError" not in program and done.returncode:
            raise AssertionError(done.stderr)
        left = [path.name for path in pathlib.Path(folder).iterdir()]
        assert not left, f"the process has left {left}"
        return now - float(done.stdout.split()[-1]), done.stderr


class End(Case):
    def expect_end(self, what, program, **environment):
        seconds, errors = ended(program, **environment)
        print(f"{seconds:6.3f} s for the end of a process with {what}", flush=True)
        self.assertLess(seconds, END_SECONDS)
        self.assertNotIn("Traceback", errors)
        return errors

    def test_a_process_ends_at_once_and_leaves_no_scene(self):
        for what, program in PROGRAMS.items():
            with self.subTest(what), collided.Client(self.server) as client:
                errors = self.expect_end(what, program, COLLIDED_SERVER=self.server)
                self.assertEqual(client.scenes(), [])
                if what != "nothing":
                    self.assertRegex(errors, r"ResourceWarning: unclosed [.\w]*(Session|Scene|SceneBatch|Watcher) of scene \S+ at unix:")

    def test_so_does_one_with_a_daemon_of_its_own(self):
        environment = {name: value for name, value in os.environ.items() if name != "COLLIDED_SERVER"}
        for what, program in PROGRAMS.items():
            if "session" not in what and what != "nothing":
                continue
            with self.subTest(what):
                self.expect_end(f"its own daemon, {what}", program, **environment)

    def test_a_daemon_that_hangs_keeps_none(self):
        freeze = "os.killpg(collided.connection.own_daemon.shared_daemon().pid, signal.SIGSTOP)\n"
        for way in STREAMS:
            program = f"left = collided.Session(meshes, transport='{way}'); left.step()\n{freeze}left.send(TIP)\n"
            self.expect_end(f"a frozen daemon, {way}", program)

    def test_a_daemon_that_is_gone_keeps_none(self):
        kill = "os.killpg(collided.connection.own_daemon.shared_daemon().pid, signal.SIGKILL)\n"
        self.expect_end("a daemon that was killed", f"left = collided.Session(meshes); left.step()\n{kill}")

    def test_a_daemon_of_ones_own_that_is_let_go(self):
        self.expect_end("daemons that were let go", "left = [OwnDaemon() for _ in range(2)]\n"
                        "for each in left: each.address\ndel left[0], each\n")

    def test_processes_of_multiprocessing_leave_no_scene(self):
        program = ("import multiprocessing\ndef work():\n    global left\n    left = collided.Session(meshes); left.step()\n"
                   "if __name__ == '__main__':\n    for way in ('fork', 'spawn'):\n"
                   "        process = multiprocessing.get_context(way).Process(target=work)\n"
                   "        process.start(); process.join()\n        assert process.exitcode == 0, process.exitcode\n")
        with tempfile.TemporaryDirectory() as folder, collided.Client(self.server) as client:
            file = pathlib.Path(folder, "program.py")
            file.write_text(BEGIN + program)
            subprocess.run([sys.executable, file], check=True, timeout=60, env={**os.environ, "COLLIDED_SERVER": self.server})
            self.assertEqual(client.scenes(), [])


class Forgotten(Case):
    """Objects are closed as soon as nothing refers to them, without the cycle collector."""

    def setUp(self):
        gc.collect()
        gc.disable()
        self.addCleanup(gc.enable)
        self.client = collided.Client(self.server)
        self.addCleanup(self.client.close)
        warnings.simplefilter("ignore", ResourceWarning)
        self.addCleanup(warnings.resetwarnings)

    def expect_no_scene(self, seconds=10):
        deadline = time.monotonic() + seconds
        while self.client.scenes() and time.monotonic() < deadline:
            time.sleep(0.01)
        self.assertEqual(self.client.scenes(), [])

    def test_a_thousand_sessions_leave_no_scene(self):
        threads = threading.active_count()
        for i in range(1000):  # the daemon has room for 64 scenes
            session = collided.Session(meshes(), server=self.client, transport=TRANSPORTS[i % 3])
            self.expect_hit(session.step({"tip": lowered(2)}), 2)
            if i % 4 == 0:
                session.send({"tip": lowered(3)})
        del session
        self.expect_no_scene()
        self.assertLess(threading.active_count(), threads + 20)

    def test_sessions_with_connections_of_their_own_leave_none(self):
        def sockets():
            links = pathlib.Path("/proc/self/fd").iterdir()
            return sum(os.readlink(link).startswith("socket") for link in links if link.is_symlink())

        before = sockets()
        for _ in range(100):
            collided.Session(meshes(), server=self.server).step({"tip": lowered(2)})
            collided.Client(self.server).info
        self.expect_no_scene()
        deadline = time.monotonic() + 10
        while sockets() > before + 10 and time.monotonic() < deadline:
            time.sleep(0.01)
        self.assertLess(sockets(), before + 10)

    def test_other_kinds_leave_none(self):
        for _ in range(70):
            collided.Scene(meshes(), server=self.client).session().step()
            collided.SceneBatch(meshes(), 2, server=self.client).step([TIP, TIP])
        self.expect_no_scene()

    def test_watchers_leave_no_thread(self):
        with collided.Scene(meshes(), server=self.client) as scene:
            for _ in range(5):
                self.assertIsNone(scene.watch().receive(0.01))
            deadline = time.monotonic() + 10
            while any(t.name == "collided-reader" for t in threading.enumerate()) and time.monotonic() < deadline:
                time.sleep(0.01)
            self.assertNotIn("collided-reader", [thread.name for thread in threading.enumerate()])

    def test_sessions_of_asyncio_leave_none(self):
        async def forget(wait):
            session = await collided.aio.Session(meshes(), server=self.client).__aenter__()
            self.expect_hit(await session.step({"tip": lowered(2)}), 2)
            await session.send({"tip": lowered(3)})
            if wait:
                task = asyncio.create_task(session.receive())
                await asyncio.sleep(0)
                task.cancel()

        for wait in (False, True):
            for _ in range(35):
                asyncio.run(forget(wait))
                gc.collect()  # a task and its exception refer to each other
        self.expect_no_scene()
        deadline = time.monotonic() + 10
        while any(thread.name == "collided-aio" for thread in threading.enumerate()) and time.monotonic() < deadline:
            time.sleep(0.01)
        self.assertNotIn("collided-aio", [thread.name for thread in threading.enumerate()])

    def test_what_cannot_be_made_leaves_no_scene(self):
        for wrong in ({"window": 10**6}, {"daemon_user": "x", "transport": "shared_memory"}, {"transport": "none"}):
            with self.assertRaises((collided.Error, TypeError)):
                collided.Session(meshes(), server=self.client, **wrong)
        twice = {"tip": collided.Mesh(TIP, [[0, 1, 2], [1, 1, 2]])}
        for make in (collided.Session, collided.Scene, lambda *a, **o: collided.SceneBatch(a[0], 2, **o)):
            with self.assertRaises(collided.InvalidArgument):
                make(twice, server=self.client)
        self.expect_no_scene()

    def test_an_interrupt_while_one_is_made_leaves_none(self):
        with mock.patch.object(stream, "open_transport", side_effect=KeyboardInterrupt), self.assertRaises(KeyboardInterrupt):
            collided.Session(meshes(), server=self.client)
        self.expect_no_scene()

    def test_what_is_closed_is_not_warned_of(self):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            for way in TRANSPORTS:
                with collided.Session(meshes(), server=self.client, transport=way) as session:
                    session.step()
                del session
            with collided.Scene(meshes(), server=self.client) as scene, scene.watch(), scene.session() as session:
                session.step()
            del scene, session
            with collided.SceneBatch(meshes(), 2, server=self.client):
                pass

            async def used():
                async with collided.aio.Session(meshes(), server=self.client) as session:
                    await session.step()

            asyncio.run(used())
            gc.collect()
        self.assertEqual([str(warning.message) for warning in caught if "unclosed" in str(warning.message)
                          and "collided" in str(warning.filename) + str(warning.message)], [])

    def test_a_warning_names_the_session_and_the_line(self):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            session = collided.Session(meshes(), server=self.client, display_name="two triangles")
            name = session.scene.id
            del session
        (warning,) = [warning for warning in caught if issubclass(warning.category, ResourceWarning)]
        self.assertEqual(str(warning.message), f"unclosed Session of scene 'two triangles', {name} at {self.server}; "
                                               "use 'with' or close()")
        self.assertEqual(warning.filename, __file__)

    def test_contacts_outlive_a_session_that_is_let_go(self):
        for way in STREAMS:
            contacts = collided.Session(meshes(), server=self.client, transport=way).step({"tip": lowered(2)})
            self.expect_no_scene()
            self.expect_hit(contacts, 2)
            self.assertAlmostEqual(contacts.points[0][0][2], 0, places=3)


class ClosedInACall(Case):
    def test_another_thread_may_close_a_session_in_a_call(self):
        """As the end of a process does. What the call then raises is that the session is closed."""
        for way in TRANSPORTS:
            for pause in range(12):
                session = collided.Session(meshes(), server=self.server, transport=way)
                caught = []

                def work(session=session, caught=caught):
                    try:
                        while True:
                            session.step({"tip": lowered(2)}, timeout=60)
                    except BaseException as error:
                        caught.append(error)

                thread = threading.Thread(target=work)
                thread.start()
                time.sleep(0.0007 * pause)
                session.close()
                thread.join(20)
                self.assertFalse(thread.is_alive())
                self.assertIsInstance(caught[0], collided.FailedPrecondition, caught)
                self.assertRegex(str(caught[0]), "the session is closed")


class Forked(Case):
    @skip_if_forks_hang
    def test_a_forked_process_leaves_its_parents_sessions_alone(self):
        for way in TRANSPORTS:
            session = self.session(transport=way)
            session.step({"tip": lowered(2)})
            sessions = [session]
            child = os.fork()
            if not child:
                try:
                    sessions.clear()
                    del session
                    gc.collect()
                    leftovers._at_exit()  # as sys.exit() would
                finally:
                    os._exit(0)
            deadline = time.monotonic() + 20
            while os.waitpid(child, os.WNOHANG)[0] == 0:
                if time.monotonic() > deadline:
                    os.kill(child, signal.SIGKILL)
                    self.fail("the child hangs")
                time.sleep(0.01)
            self.expect_hit(session.step({"tip": TIP}, start={"tip": lowered(2)}), 2)
            with collided.Client(self.server) as client:
                self.assertEqual([scene.scene_id for scene in client.scenes()], [session.scene.id])
            session.close()


class Lost(unittest.TestCase):
    def test_a_session_whose_daemon_is_gone_or_hangs_is_let_go_at_once(self):
        daemon = Supervised()
        self.addCleanup(daemon.close)
        for harm in (daemon.kill, daemon.freeze):
            for way in TRANSPORTS:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")
                    session = collided.Session(meshes(), server=daemon.address, transport=way)
                    session.step()
                    harm()
                    begin = time.monotonic()
                    del session
                    self.assertLess(time.monotonic() - begin, 1)
                if harm == daemon.freeze:
                    daemon.process.send_signal(signal.SIGCONT)


class Repr(Case):
    def test_it_is_one_line_however_large_things_are(self):
        many = collided.Mesh(TIP.repeat(500, axis=0), ONE.repeat(900, axis=0), name="many")
        self.assertEqual(repr(many), "<Mesh 'many': 1,500 vertices, 900 triangles, deformable>")
        session = self.session({f"tip {i}": collided.Mesh(TIP, ONE) for i in range(40)})
        contacts = session.step({"tip 1": lowered(2)})
        with session.scene.watch() as watcher:
            things = [session, session.scene, session.scene.client, contacts, watcher,
                      session.scene.client.get_mesh(session.scene.id, 0),
                      collided.Edit({"many": many, "gone": None}), collided.Sparse(range(999), TIP.repeat(333, axis=0)),
                      collided.Rigid([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]), collided.aio.Session({})]
            for thing in things:
                self.assertNotIn("\n", repr(thing))
                self.assertLess(len(repr(thing)), 250, repr(thing))

    def test_it_says_what_is_closed(self):
        batch = collided.SceneBatch((TIP, ONE), 2, server=self.server)
        session = self.session({"tip": collided.Mesh(TIP, ONE)})
        scene, watcher = session.scene, session.scene.watch()
        things = [watcher, session, scene, batch]
        for thing in things:
            self.assertNotIn("closed", repr(thing))
        for thing in things:
            thing.close()
            self.assertRegex(repr(thing), ": closed>$")

        async def closed():
            async with collided.aio.Session((TIP, ONE), server=self.server) as over_asyncio:
                self.assertNotIn("closed", repr(over_asyncio))
            return repr(over_asyncio)

        self.assertRegex(asyncio.run(closed()), "^<aio Session .*: closed>$")


if __name__ == "__main__":
    main(230)
