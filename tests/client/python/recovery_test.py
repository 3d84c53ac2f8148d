#!/usr/bin/env python3
"""Connections and daemons that are lost in the middle of a stream: answers are those of an unbroken run, to the bit."""

import concurrent.futures
import contextlib
import pathlib
import signal
import socket
import tempfile
import threading
import time
import unittest
from unittest import mock

from support import (DAEMON, FLOOR, ONE, STREAMS, TIP, TRANSPORTS, Case, Daemon, Supervised, assert_same, body_turned, lowered, main, meshes,
                     np, turning)

import collided
from collided.connection import own_daemon

FAR = TIP + np.float32([0, 0, 20])


def sheet(cells, height):
    """A square of so many cells each way, at a height that waves, and its triangles."""
    y, x = np.mgrid[:cells + 1, :cells + 1] / cells
    vertices = np.stack([x, y, height + 0.02 * np.sin(9 * x) * np.cos(7 * y)], axis=2).reshape(-1, 3)
    corner = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).reshape(-1, 1)
    triangles = np.concatenate([corner + [0, 1, cells + 1], corner + [1, cells + 2, cells + 1]], axis=1).reshape(-1, 3)
    return vertices, triangles


def scene(**cloth):
    ground, triangles = sheet(9, 0)
    cloth_at, cells = sheet(8, 0.06)
    ball = np.array([[0.4, 0.4, 0.2], [0.6, 0.4, 0.2], [0.5, 0.6, 0.1]])
    return {"ground": collided.Mesh(ground, triangles, motion="static"), "ball": collided.Mesh(ball, ONE, motion="rigid"),
            "cloth": collided.Mesh(cloth_at, cells, **cloth)}


def pose(step):
    return np.hstack([np.eye(3), [[0.01 * step], [0], [-0.01 * step]]])


def frames(count):
    """Whole and sparse updates, poses, advances, trials, fractions, edits: all that a new scene has to be told."""
    start = sheet(8, 0.06)[0]
    extra = collided.Mesh(np.array([[2, 2, 2], [3, 2, 2], [2, 3, 2.0]]), ONE)
    for step in range(1, count + 1):
        height = 0.04 * np.sin(0.9 * step)
        match step % 8:
            case 1:
                yield {"cloth": start - [0, 0, 0.05 + height], "ball": collided.Rigid(pose(step))}, {}
            case 2:
                yield {"cloth": collided.Sparse(np.arange(0, 81, 3), (start + [0, 0, height])[::3])}, {}
            case 3:
                yield {"cloth": start + [0, 0, height]}, {"trial": True}
            case 4:
                yield {}, {"from_last_fraction": 0.375}
            case 5:
                yield {"cloth": start - [0, 0, height]}, {"edit": collided.Edit({"extra": extra}, exclude=[("extra", "ball")])}
            case 6:
                yield {"cloth": start + [0, 0, 0.03 + height]}, {"edit": collided.Edit({"extra": None})}
            case 7:
                yield {"cloth": start + [0, 0, 0.1]}, {"report": "earliest_only"}
            case _:
                yield {"cloth": start + [0, 0, 0.03]}, {"advance": step > 8, "limits": step > 8, "accuracy": "certified"}


def play(session, count, disturb=lambda sent: None):
    """All contacts, with the window full; `disturb` may do harm between two frames."""
    answers = []
    for sent, (positions, options) in enumerate(frames(count), 1):
        while session.in_flight >= session.window:
            answers.append(session.receive())
        session.send(positions, **options)
        disturb(sent)
    while session.in_flight:
        answers.append(session.receive())
    return answers


class Killed(unittest.TestCase):
    COUNT = 25

    def setUp(self):
        self.daemon = Supervised("--grace-seconds", "0.1")
        self.addCleanup(self.daemon.close)

    def session(self, **options):
        session = collided.Session(scene(), **{"server": self.daemon.address, "position_format": "f64", "edit_bytes": 8192,
                                               "window": 3, **options})
        self.addCleanup(session.close)
        return session

    def expect_the_unbroken_run(self, answers, expected):
        self.assertEqual([answer.frame_id for answer in answers], list(range(1, self.COUNT + 1)))
        for answer, other in zip(answers, expected):
            assert_same(self, answer, other)

    def test_a_daemon_that_is_killed_is_found_again_wherever_it_was(self):
        for transport in STREAMS:
            expected = play(self.session(transport=transport), self.COUNT)
            self.assertGreater(sum(map(len, expected)), 100)
            for at in (3, 9, 14) if transport == "grpc" else range(2, 11):
                with self.subTest(transport=transport, killed_at=at):
                    session = self.session(transport=transport)
                    answers = play(session, self.COUNT, lambda sent: self.daemon.kill() if sent == at else None)
                    self.assertEqual((session.reconnects, session.recreations), (1, 1))
                    self.expect_the_unbroken_run(answers, expected)
                    session.close()

    def test_where_each_mesh_and_vertex_went_is_known_to_a_new_scene(self):
        fall = np.float32([0, 0, -2])
        stone, free = TIP + np.float32([1, 0, 0]), TIP + np.float32([100, 0, 0])

        def run(mode, is_lost):
            made = {**meshes(), "stone": collided.Mesh(stone, ONE, motion="rigid"), "free": collided.Mesh(free, ONE)}
            session = collided.Session(made, server=self.daemon.address, min_separation=0.01)
            self.addCleanup(session.close)
            down = collided.Rigid(np.hstack([np.eye(3), fall[:, None]]))
            answers = [session.step({"tip": TIP + fall, "stone": down, "free": free + fall}, advance=mode)]
            if is_lost:
                self.daemon.kill()
            answers += [session.step(from_last_fraction=0.5), session.step({"tip": TIP + 2 * fall, "free": free})]
            self.assertEqual(session.recreations, int(is_lost))
            return answers, session.positions

        for mode in ("per_mesh", "per_vertex"):
            (answers, positions), (expected, wanted) = run(mode, True), run(mode, False)
            self.assertTrue(answers[0].advanced < 1 == answers[0].fractions("free").min())
            for answer, other in zip(answers, expected):
                assert_same(self, answer, other)
            for name in wanted:
                np.testing.assert_array_equal(positions[name], wanted[name])

    def test_where_a_mesh_that_turns_went_is_known_to_a_new_scene(self):
        def run(mode, is_lost):
            session = collided.Session(turning(), server=self.daemon.address, min_separation=0.01)
            self.addCleanup(session.close)
            answers = []
            for step, (angle, depth) in enumerate(((1.1, 2), (1.6, 2.2), (0.2, 0.3))):
                if is_lost and step:
                    self.daemon.kill()
                answers.append(session.step({"body": collided.Rigid(body_turned(angle, depth))}, advance=mode))
            self.assertEqual(session.recreations, 2 * is_lost)
            return answers, session.positions["body"]

        for mode in (True, "per_mesh", "per_vertex"):
            (answers, positions), (expected, wanted) = run(mode, True), run(mode, False)
            self.assertTrue(0 < answers[0].advanced < 1)
            for answer, other in zip(answers, expected, strict=True):
                assert_same(self, answer, other)
                self.assertEqual(answer.advanced, other.advanced)
            np.testing.assert_array_equal(positions, wanted)

    def test_rest_pairs_stay_those_of_the_beginning(self):
        def run(kill_at):
            meshes = scene(exclude_rest_pairs=True)
            session = collided.Session(meshes, server=self.daemon.address, mode="dcd", thickness=0.13, rest_distance=0.13)
            answers = []
            for step in range(6):
                if step == kill_at:
                    self.daemon.kill()
                moved = meshes["cloth"].vertices * [1 - 0.1 * step, 1, 1]
                answers.append(session.step({"cloth": moved}).of_mesh("cloth"))
            self.assertEqual(session.recreations, int(kill_at >= 0))
            session.close()
            return answers

        expected = run(-1)
        self.assertGreater(len(expected[-1]), len(expected[0]))
        for answer, other in zip(run(3), expected):
            assert_same(self, answer, other)

    def test_before_the_first_frame_and_with_nothing_in_flight_nothing_is_noticed(self):
        session = self.session()
        self.daemon.kill()
        (positions, options), *_ = frames(1)
        session.step(positions, **options)
        self.daemon.kill()
        session.step(positions, **options)
        self.assertEqual(session.recreations, 2)

    def test_calls_survive_it_too(self):
        expected = play(self.session(transport="calls", window=0), 9)
        session = self.session(transport="calls", window=0)
        answers = play(session, 9, lambda sent: self.daemon.kill() if sent == 4 else None)
        self.assertEqual(session.recreations, 1)
        for answer, other in zip(answers, expected):
            assert_same(self, answer, other)

    def test_a_daemon_that_stops_and_starts_is_the_same(self):
        session = self.session(transport="grpc")
        first = self.daemon.process

        def stop(sent):
            if sent == 9:
                first.terminate()
                first.wait()

        answers = play(session, self.COUNT, stop)
        self.assertEqual(session.recreations, 1)
        self.expect_the_unbroken_run(answers, play(self.session(transport="grpc"), self.COUNT))


def bystander(rise=0):
    return collided.Mesh(FAR + np.float32([0, 0, rise]), ONE)


class Edited(unittest.TestCase):
    """Daemons that are lost right after an edit."""

    def setUp(self):
        self.daemon = Supervised("--grace-seconds", "0.1")
        self.addCleanup(self.daemon.close)

    def session(self, what, **options):
        session = collided.Session(what, server=self.daemon.address, **options)
        self.addCleanup(session.close)
        return session

    def lose(self, session, is_lost=True):
        """Kills the daemon, whose next step has to be in a new scene."""
        if is_lost:
            before = session.recreations
            self.daemon.kill()
            session.step()
            self.assertEqual(session.recreations, before + 1)

    def test_rest_pairs_are_those_of_the_edit(self):
        near = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0], [1, 1, .1], [1.25, 1, 9], [1, 1.25, 9]], "<f4")
        far, below = near.copy(), near.copy()
        far[3:, 2] += 3
        below[3:, 2] -= 1

        def strip(positions, elements=((0, 1, 2), (3, 4, 5))):
            return collided.Mesh(positions, elements, exclude_rest_pairs=True)

        def play(is_lost, end, elements):
            session = self.session({"strip": strip(near)}, rest_distance=0.5)
            session.step()
            session.step(far)
            session.step(end, edit=collided.Edit({"strip": strip(far, elements)}))
            self.lose(session, is_lost)
            return [len(session.step(positions)) for positions in (below, far)]

        for end in (None, far, near):
            for elements in (((0, 1, 2), (3, 4, 5)), ()):
                with self.subTest(moves=end is near, elements=len(elements)):
                    self.assertEqual(play(True, end, elements), play(False, end, elements))

    def test_rest_pairs_are_those_of_an_edit_that_makes_a_mesh_thicker(self):
        near = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0], [1, 1, .1], [1.25, 1, 9], [1, 1.25, 9]], "<f4")
        far, below = near + np.float32([[0, 0, 3 * (i > 2)] for i in range(6)]), near - np.float32([[0, 0, i > 2] for i in range(6)])

        def play(is_lost, half):
            strip = collided.Mesh(near, [[0, 1, 2], [3, 4, 5]], exclude_rest_pairs=True)
            session = self.session({"strip": strip})
            session.step()
            session.step(far)
            thick = collided.Mesh(vertex_count=6, exclude_rest_pairs=True, half_thickness=half)
            session.step(near, edit=collided.Edit({"strip": thick}))
            self.lose(session, is_lost)
            return [len(session.step(positions)) for positions in (below, far)]

        self.assertGreater(play(False, 0)[0], 0)
        self.assertEqual(play(False, 0.3)[0], 0)
        for half in (0, 0.3):
            self.assertEqual(play(True, half), play(False, half))

    def test_a_static_mesh_that_was_replaced(self):
        for transport in STREAMS:
            session = self.session(meshes(), transport=transport, edit_bytes=4096)
            session.step({"tip": lowered(0.5)})
            lower = collided.Mesh(FLOOR - np.float32([0, 0, 0.5]), ONE, motion="static")
            session.step({"floor": lower.vertices}, edit=collided.Edit({"floor": lower}))
            self.lose(session)
            np.testing.assert_allclose(session.step({"tip": lowered(2)}).toi, [2 / 3], atol=1e-3)

    def test_the_format_of_positions_stays(self):
        for edited, positions in (({"tip": None}, None), ({"third": collided.Mesh(FAR.astype(float), ONE)}, None),
                                  ({"third": collided.Mesh(triangles=ONE)}, {"third": FAR})):
            session = self.session({**meshes(), "other": bystander(30)}, edit_bytes=4096)
            session.step({"tip": lowered(0.5)})
            form = session.scene.refresh().spec.position_format
            session.step(positions, edit=collided.Edit(edited))
            self.lose(session)
            self.assertEqual(session.scene.refresh().spec.position_format, form)

    def test_a_rest_distance_that_no_mesh_uses_any_more(self):
        for edit in ({"tip": None}, {"tip": collided.Mesh(TIP, ONE)}):
            session = self.session({**meshes(exclude_rest_pairs=True), "other": bystander()}, rest_distance=0.05, edit_bytes=4096)
            session.step()
            session.step(edit=collided.Edit(edit))
            self.lose(session)
            spec = session.scene.refresh().spec
            self.assertEqual((spec.rest_distance, [mesh.exclude_rest_pairs for mesh in spec.meshes if mesh.vertex_count]),
                             (0.05, [False] * (3 - (edit["tip"] is None))))
            again = collided.Mesh(FAR + np.float32(30), ONE, exclude_rest_pairs=True)
            contacts = session.step({"other": FAR}, edit=collided.Edit({"again": again}))
            self.assertEqual(len(contacts), 0)
            self.lose(session)
            self.assertEqual(session.positions["again"].tolist(), again.vertices.tolist())


class Draining(unittest.TestCase):
    def test_a_daemon_that_stops_answers_until_its_end_where_no_other_one_takes_the_scene(self):
        daemon = Supervised("--grace-seconds", "600")
        self.addCleanup(daemon.close)
        for transport in STREAMS:
            session = collided.Session(meshes(), server=daemon.address, transport=transport)
            self.addCleanup(session.close)
            stopping = daemon.process
            stopping.terminate()
            while session.draining_seconds is None:
                session.step({"tip": lowered(2)}, start={"tip": TIP})
            for _ in range(20):
                np.testing.assert_allclose(session.step({"tip": lowered(2)}, start={"tip": TIP}).toi, [0.5], atol=1e-3)
            self.assertEqual((session.reconnects, session.recreations), (0, 0))
            stopping.terminate()  # the grace ends at once
            stopping.wait()
            np.testing.assert_allclose(session.step({"tip": lowered(2)}, start={"tip": TIP}).toi, [0.5], atol=1e-3)
            self.assertEqual(session.recreations, 1)


def break_connection(session):
    """As a network that fails would."""
    if session.is_local:
        session._stream._transport._socket.shutdown(socket.SHUT_RDWR)
    else:
        session._stream._transport._messages._call.cancel()


class Broken(Case):
    def test_a_connection_that_breaks_is_resumed_without_a_new_scene(self):
        for transport in STREAMS:
            session = self.session(transport=transport)
            self.expect_hit(session.step({"tip": lowered(2)}), 2)
            break_connection(session)
            np.testing.assert_allclose(session.step({"tip": TIP}).toi, [0.5], atol=1e-3)
            self.assertEqual((session.reconnects, session.recreations), (1, 0))

    def test_answers_that_were_lost_are_asked_for_again(self):
        for transport in STREAMS:
            session = self.session(transport=transport)
            session.send({"tip": lowered(2)})
            session.send({"tip": TIP})
            for _ in range(2):  # both are applied, and their answers lost
                session._stream._transport.read(None)
            break_connection(session)
            self.expect_hit(session.receive(), 2)
            np.testing.assert_allclose(session.receive().toi, [0.5], atol=1e-3)
            self.assertEqual((session.reconnects, session.recreations), (1, 1))

    def test_a_frame_on_the_last_way_does_not_trust_a_resumed_scene_to_have_it(self):
        for transport in STREAMS:
            unbroken, session = self.session(transport=transport), self.session(transport=transport)
            for each in (unbroken, session):
                self.expect_hit(each.step({"tip": lowered(2)}), 2)
            break_connection(session)
            on = {"from_last_fraction": 0.25}
            assert_same(self, session.step({"tip": lowered(2)}, **on), unbroken.step({"tip": lowered(2)}, **on))
            self.assertEqual((session.reconnects, session.recreations), (1, 1))

    def test_calls_of_other_threads_survive_it(self):
        with collided.Client(self.server) as client, concurrent.futures.ThreadPoolExecutor(1) as pool:
            session = self.session(server=client, transport="grpc")
            is_over = threading.Event()

            def list_scenes():
                while not is_over.is_set():
                    client.scenes()

            other = pool.submit(list_scenes)
            for _ in range(20):
                client.reconnect()
                session.step()
            is_over.set()
            other.result(60)

    def test_a_new_scene_that_is_gone_before_its_stream_opens_is_created_once_more(self):
        session = self.session()
        self.expect_hit(session.step({"tip": lowered(2)}), 2)
        scene, create = session.scene, session.scene.create_again

        def create_and_lose():
            scene.create_again = create
            create()
            scene.client.delete_scene(scene.id)

        scene.create_again = create_and_lose
        break_connection(session)
        scene.client.delete_scene(scene.id)
        self.expect_hit(session.step({"tip": lowered(2)}, start={"tip": TIP}), 2)
        self.assertEqual(session.recreations, 1)

    def test_a_scene_that_another_stream_takes_over_is_left_to_it(self):
        session = self.session()
        self.expect_hit(session.step({"tip": lowered(2)}), 2)
        self.refused(collided.FailedPrecondition, "stream", collided.Session, session.scene)
        other = self.session(session.scene, take_over=True)
        for _ in range(2):
            self.refused(collided.Aborted, "", session.step, {"tip": TIP})
        self.expect_hit(other.step({"tip": lowered(2)}, start={"tip": TIP}), 2)

    def test_a_scene_that_was_deleted_stays_deleted(self):
        session = self.session()
        session.scene.client.delete_scene(session.scene.id)
        for _ in range(2):
            self.refused(collided.NotFound, "", session.step, {"tip": lowered(2)})


class Calls(Case):
    def test_a_frame_whose_answer_is_too_large_leaves_the_scene_where_it_was(self):
        many = np.concatenate([TIP + np.float32([100 * i, 0, 0]) for i in range(160)])
        together = np.tile(TIP, (160, 1))
        cloud = {"cloud": collided.Mesh(many, np.arange(480).reshape(-1, 3))}
        session = self.session(cloud, transport="calls", mode="dcd", thickness=0.1)
        session.step()
        error = self.refused(collided.ResourceExhausted, r"frame \d was applied, .* begins where the scene was before", session.step,
                             together)
        self.assertEqual((error.frame_id, session.in_flight), (2, 0))
        for moved, meets in ((together[:3], True), (many[3:6], False)):  # all other vertices are where they were
            self.assertEqual(session.step(collided.Sparse([3, 4, 5], moved)).any_contact, meets)
            np.testing.assert_array_equal(session.positions["cloud"][6:], many[6:])


class Idle(Case):
    options = ("--max-idle-seconds", "0.3")

    def test_a_stream_that_was_idle_for_too_long_is_opened_again(self):
        session = self.session(transport="grpc")
        self.expect_hit(session.step({"tip": lowered(2)}), 2)
        time.sleep(1)
        self.expect_hit(session.step({"tip": lowered(2)}, start={"tip": TIP}), 2)
        self.assertGreaterEqual(session.reconnects, 1)
        self.assertEqual(session.recreations, 0)

    def test_a_scene_whose_lease_ended_is_created_again(self):
        for transport, pause in (("calls", 0.8), ("grpc", 1.3)):  # no stream keeps it; its stream was idle for too long
            session = self.session(transport=transport, lease_seconds=0.2)
            self.expect_hit(session.step({"tip": lowered(2)}), 2)
            time.sleep(pause)
            np.testing.assert_allclose(session.step({"tip": TIP}).toi, [0.5], atol=1e-3)
            self.assertGreaterEqual(session.recreations, 1)


class Stopped(unittest.TestCase):
    def test_a_daemon_that_hangs_is_told_from_a_slow_one_by_the_caller(self):
        for transport in TRANSPORTS:
            daemon = Supervised()
            self.addCleanup(daemon.close)
            session = collided.Session(meshes(), server=daemon.address, transport=transport)
            session.step({"tip": TIP})
            daemon.freeze()
            with self.assertRaises(TimeoutError):
                session.step({"tip": lowered(2)}, timeout=0.2)
            self.assertEqual(session.in_flight, 1)
            with self.assertRaisesRegex(collided.DeadlineExceeded, "frame 2 was not answered within 0.1 s"):
                session.receive(timeout=0.1)
            daemon.process.send_signal(signal.SIGCONT)
            np.testing.assert_allclose(session.receive(timeout=30).toi, [0.5], atol=1e-3)
            self.assertEqual(session.reconnects, 0)
            session.close()

    def test_a_call_that_is_not_answered_by_its_deadline_may_be_received_later(self):
        daemon = Supervised()
        self.addCleanup(daemon.close)
        session = collided.Session(meshes(), server=daemon.address, transport="calls", deadline=0.5)
        self.addCleanup(session.close)
        session.step()
        daemon.freeze()
        with self.assertRaises(collided.DeadlineExceeded):
            session.step({"tip": lowered(2)})
        self.assertEqual(session.in_flight, 1)
        daemon.process.send_signal(signal.SIGCONT)
        np.testing.assert_allclose(session.receive().toi, [0.5], atol=1e-3)
        np.testing.assert_allclose(session.step({"tip": TIP}).toi, [0.5], atol=1e-3)

    def test_timeouts_hold_while_a_daemon_is_gone_and_no_frame_is_lost(self):
        daemon = Supervised()
        self.addCleanup(daemon.close)
        for transport in TRANSPORTS:
            with self.subTest(transport):
                session = collided.Session(meshes(), server=daemon.address, transport=transport)
                session.step()
                begun = time.monotonic()
                with daemon.gone():
                    for call in (lambda: session.step({"tip": lowered(2)}, timeout=0.2), *3 * [lambda: session.receive(0.2)]):
                        with self.assertRaises(collided.DeadlineExceeded):
                            call()
                        self.assertEqual(session.in_flight, 1)
                    self.assertLess(time.monotonic() - begun, 4)
                deadline = time.monotonic() + 30
                while session.in_flight and time.monotonic() < deadline:
                    with contextlib.suppress(collided.DeadlineExceeded):  # so short that connecting takes several of them
                        self.assertEqual(len(session.receive(timeout=0.001)), 1)
                self.assertEqual((session.in_flight, session.recreations), (0, 1))
                session.close()

    def test_an_absence_that_was_waited_for_is_told_however_short_the_timeouts_are(self):
        daemon = Supervised()
        self.addCleanup(daemon.close)
        session = collided.Session(meshes(), server=daemon.address, reconnect_seconds=0.5)
        session.step()
        with daemon.gone():
            session.send({"tip": lowered(2)})
            begun = time.monotonic()
            with self.assertRaises(collided.Unavailable):
                while True:
                    with contextlib.suppress(collided.DeadlineExceeded):
                        session.receive(timeout=0.05)
            self.assertTrue(0.4 < time.monotonic() - begun < 4)
        np.testing.assert_allclose(session.receive().toi, [0.5], atol=1e-3)
        session.close()

    def test_who_does_not_wait_is_told_and_loses_no_frame(self):
        daemon = Daemon(str(DAEMON))
        self.addCleanup(daemon.kill)
        session = collided.Session(meshes(), server=daemon.address, reconnect_seconds=0)
        session.send({"tip": lowered(2)})
        daemon.process.kill()
        daemon.process.wait()
        with self.assertRaises(collided.Unavailable):
            for _ in range(3):
                session.receive()
                session.send({"tip": TIP})


class Starting(Case):
    """The daemon of a process's own."""

    def start(self, said):
        """Starts one that says so, and is ready after more than the usual time."""
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        script = pathlib.Path(folder.name, "daemon")
        script.write_text(f'#!/bin/sh\necho "[warning] {said}"\nsleep 1\nexec {DAEMON} "$@"\n', encoding="ascii")
        script.chmod(0o700)
        daemon = own_daemon.OwnDaemon(program=str(script))
        self.addCleanup(daemon.stop)
        with mock.patch.object(own_daemon, "_READY_SECONDS", 0.5):
            return daemon.address

    def test_one_whose_kernels_are_compiled_has_more_time_than_others(self):
        with contextlib.closing(collided.Client(self.start("compiling the kernels for cuda:0 (a GPU)"))) as client:
            self.assertTrue(client.info.version)
        with self.assertRaisesRegex(collided.Unavailable, "did not become ready: .*waiting"):
            self.start("waiting for something")
        with self.assertRaisesRegex(collided.FailedPrecondition, "must be of release 0.2.0 or later, and .*daemon is older"):
            self.start('The following argument was not expected: --private"; exit 2; "')


if __name__ == "__main__":
    main()
