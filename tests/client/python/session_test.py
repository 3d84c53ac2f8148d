#!/usr/bin/env python3
"""Frames and their contacts, over every transport."""

import asyncio
import concurrent.futures
import inspect
import linecache
import math
import os
import threading
import traceback
import warnings
from unittest import mock

from support import (BODY, DAEMON, FLOOR, ONE, STREAMS, TIP, TRANSPORTS, Case, assert_same, body_turned, lowered, main, meshes, np,
                     skip_if_forks_hang, turning)

import collided
from collided.frames.updates import Update
from collided.transport.local_frames import LocalFrames
from collided.transport.region import Region, RegionLayout
from collided.v1 import frame_pb2, local_pb2


class Sessions(Case):
    def test_frames_have_the_contact_that_was_built_in_over_every_transport(self):
        for transport in TRANSPORTS:
            with self.subTest(transport):
                session = self.session(transport=transport)
                self.assertEqual(session.is_local, transport == "shared_memory")
                for depth in (1.25, 2, 3.5):
                    self.expect_hit(session.step({"tip": lowered(depth)}, start={"tip": TIP}), depth)
                self.assertEqual(len(session.step({"tip": TIP}, start={"tip": TIP})), 0)
                session.close()

    def test_a_scene_begins_at_its_vertices_and_goes_on_where_it_was(self):
        session = self.session()
        np.testing.assert_array_equal(session.positions["tip"], TIP)
        self.assertEqual(len(session.step({"tip": lowered(0.5)})), 0)
        contacts = session.step({"tip": lowered(1.5)})
        np.testing.assert_allclose(contacts.toi, [0.5], atol=1e-3)
        np.testing.assert_array_equal(session.positions["tip"], lowered(1.5))

    def test_without_vertices_the_first_frame_has_all_positions(self):
        session = self.session({"floor": ONE, "tip": ONE}, position_format="f32")
        self.assertEqual(session.positions, {})
        self.refused(collided.InvalidArgument, "mesh 'floor' has no positions", session.step, {"tip": TIP})
        self.expect_hit(session.step({"floor": FLOOR, "tip": lowered(2)}, start={"tip": TIP}), 2)

    def test_one_moving_mesh_needs_no_name(self):
        self.expect_hit(self.session().step(lowered(2)), 2)

    def test_a_window_of_frames_is_answered_in_order(self):
        for transport in STREAMS:
            session = self.session(window=4, transport=transport)
            self.assertEqual(session.window, 4)
            depths = [0, 2] * 8
            answers = list(session.run({"tip": lowered(depth)} for depth in depths))
            self.assertEqual([answer.frame_id for answer in answers], list(range(1, 17)))
            self.assertEqual([len(answer) for answer in answers], [0] + [1] * 15)

    def test_a_frame_that_is_refused_takes_none_from_the_iterator(self):
        for transport in TRANSPORTS:
            session = self.session(window=0 if transport == "calls" else 2, transport=transport)
            depths = iter([0, np.nan, 2, 0, 2])
            frames = ({"tip": lowered(depth)} for depth in depths)
            with self.assertRaises(collided.InvalidArgument) as caught:
                for _ in session.run(frames):
                    continue
            self.assertEqual(caught.exception.frame_id, 2)
            left = list(session.run(frames))
            self.assertEqual([(contacts.frame_id, len(contacts)) for contacts in left], [(3, 1), (4, 1), (5, 1)])

    def test_arrays_may_change_once_they_are_sent(self):
        for transport in STREAMS:
            session = self.session(window=2, transport=transport)
            moving = lowered(2)
            session.send({"tip": moving})
            moving[:] = 1e6
            self.expect_hit(session.receive(), 2)
            np.testing.assert_array_equal(session.positions["tip"], lowered(2))

    def test_positions_that_are_kept_stay_those_of_their_frame(self):
        for transport in STREAMS:
            for window in (1, 16):  # with and without memory for positions to stay in
                session = self.session(window=window, transport=transport, position_format="f64")
                kept = []
                for step in range(12):
                    contacts = session.step({"tip": lowered(step / 16)})
                    kept.append((contacts, session.positions["tip"]))
                for step, (contacts, positions) in enumerate(kept):
                    np.testing.assert_array_equal(positions, lowered(step / 16))
                    np.testing.assert_array_equal(contacts.answer.ends[3:], lowered(step / 16))

    def test_shared_memory_is_used_again_once_nothing_views_it(self):
        region = Region(RegionLayout(window=1, frame_bytes=4096, lasting=2, lasting_bytes=4096, output_bytes=0))
        self.addCleanup(region.close)
        first, second = region.lasting_part(4096), region.lasting_part(4096)
        view, starts = first.bytes[8:16].view("<f4").reshape(2, 1), (first.start, second.start)
        self.assertEqual(starts, (4096, 8192))
        del first
        self.assertIsNone(region.lasting_part(1))
        del view
        self.assertIsNone(region.lasting_part(4097))
        self.assertEqual(region.lasting_part(1).start, starts[0])

    def test_packets_are_what_the_protocol_says(self):
        region = Region(RegionLayout(window=1, frame_bytes=4096, lasting=0, lasting_bytes=0, output_bytes=0))
        self.addCleanup(region.close)
        many, few, indices, pose = np.ones((10, 3), "<f4"), np.ones((2, 3), "<f4"), np.array([1, 2], "<u4"), np.eye(3, 4)
        packet = LocalFrames(region).pack(300, frame_pb2.Frame(trial=True), [
            Update(0, many, start=many), Update(200, few, indices=indices), Update(2, pose=pose, start_pose=pose)])
        frame = frame_pb2.Frame(frame_id=300, trial=True)
        frame.updates.add(shared_start_positions={"offset": 0, "size": 120}, shared_positions={"offset": 128, "size": 120})
        frame.updates.add(mesh=200, sparse={"indices": indices.tobytes()}, positions=few.tobytes())
        frame.updates.add(mesh=2, rigid={"matrix": pose.tobytes(), "start_matrix": pose.tobytes()})
        self.assertEqual(local_pb2.LocalRequest.FromString(packet), local_pb2.LocalRequest(frame=frame))

    def test_any_layout_and_number_type_of_arrays_gives_the_same(self):
        forms = {"float64": lowered(2).astype(float), "big-endian": lowered(2).astype(">f4"),
                 "column-major": np.asfortranarray(lowered(2)), "list": lowered(2).tolist(),
                 "every other": np.repeat(lowered(2), 2, axis=0)[::2], "reversed": lowered(2)[::-1].copy()[::-1]}
        for transport in STREAMS:
            expected = self.session(transport=transport).step({"tip": lowered(2)})
            for name, positions in forms.items():
                with self.subTest(name, transport=transport):
                    assert_same(self, self.session(transport=transport).step({"tip": positions}), expected)

    def test_sparse_and_whole_updates_agree(self):
        for transport in STREAMS:
            whole, sparse = self.session(transport=transport), self.session(transport=transport)
            moved = TIP.copy()
            for step in range(70):  # more than the client keeps apart
                moved = moved.copy()
                moved[0, 2] = (-1) ** step
                expected = whole.step({"tip": moved})
                found = sparse.step({"tip": collided.Sparse([0], moved[:1])})
                assert_same(self, found, expected)
            np.testing.assert_array_equal(sparse.positions["tip"], whole.positions["tip"])

    def test_no_vertices_may_be_moved(self):
        for transport in STREAMS:
            session = self.session(transport=transport)
            nothing = collided.Sparse([], np.empty((0, 3)))
            self.assertEqual(len(session.step({"tip": nothing})), 0)

    def test_rigid_meshes_move_by_their_pose(self):
        down = np.eye(4)
        down[2, 3] = -2
        for transport in TRANSPORTS:
            session = self.session(meshes(motion="rigid"), transport=transport)
            self.expect_hit(session.step({"tip": collided.Rigid(down)}), 2)
            np.testing.assert_array_equal(session.positions["tip"], lowered(2))
            self.expect_hit(session.step({"tip": collided.Rigid(down[:3], start=np.eye(4))}), 2)
            session.close()

    def test_an_advance_goes_to_the_daemons_bits(self):
        for transport in STREAMS:
            session = self.session(transport=transport, min_separation=0.01)
            gone = session.step({"tip": lowered(2)}, advance=True)
            self.assertTrue(0.4 < gone.advanced < 0.5)
            expected = collided.move_along(TIP, lowered(2), gone.advanced)
            np.testing.assert_array_equal(session.positions["tip"], expected)
            again = session.step({"tip": expected}, start={"tip": expected})
            self.assertEqual(len(again), 0)
            self.assertEqual(session.step(advance=True).advanced, 1)

    def test_an_advance_per_mesh_or_vertex_goes_to_the_daemons_bits(self):
        beside, fall = TIP + np.float32([100, 0, 0]), np.float32([0, 0, -2])
        for motion in ("deformable", "rigid"):
            for mode in ("per_mesh", "per_vertex"):
                with self.subTest(motion=motion, mode=mode):
                    session = self.session({**meshes(motion=motion), "free": (beside, ONE)}, min_separation=0.01)
                    down = collided.Rigid(np.hstack([np.eye(3), fall[:, None]])) if motion == "rigid" else TIP + fall
                    gone = session.step({"tip": down, "free": beside + fall}, advance=mode)
                    tip, free = gone.fractions("tip"), gone.fractions("free")
                    self.assertTrue(0.4 < tip[0] == tip.min() == gone.advanced < 0.5)
                    self.assertEqual(free.tolist(), [1, 1, 1])
                    if motion == "rigid" or mode == "per_mesh":
                        self.assertEqual(tip.tolist(), [tip[0]] * 3)
                    self.assertAlmostEqual(gone.way, np.mean([*tip, *free]), delta=2**-20)
                    np.testing.assert_array_equal(session.positions["free"], beside + fall)
                    if motion == "deformable":
                        np.testing.assert_array_equal(session.positions["tip"], collided.move_along(TIP, TIP + fall, tip))
                    with session.scene.watch(meshes=["tip", "free"]) as watcher:
                        session.step()
                        seen = watcher.receive(timeout=30).positions
                    for name, positions in seen.items():
                        np.testing.assert_array_equal(session.positions[name], positions)
                    session.close()

    def test_an_advance_turns_rigid_meshes_to_the_daemons_bits(self):
        for form, dtype in (("f32", "<f4"), ("f64", "<f8")):
            for mode in (True, "per_mesh", "per_vertex"):
                with self.subTest(form=form, mode=mode):
                    session = self.session(turning(), position_format=form, min_separation=0.01)
                    pose, went, last = np.eye(3, 4), [], None
                    with session.scene.watch(meshes=["body"]) as watcher:
                        for angle, depth in ((0.4, 0.5), (1.3, 2), (1.9, 2)):
                            target = body_turned(angle, depth)
                            gone = session.step({"body": collided.Rigid(target)}, advance=mode)
                            went.append(gone.fractions("body")[0])
                            pose = collided.pose_along(pose, target, went[-1])
                            while last is None or last.contacts.frame_id != session.scene.track.last_applied:
                                last = watcher.receive(timeout=30)
                            expected = collided.move_rigidly(BODY.astype(dtype), pose)
                            np.testing.assert_array_equal(last.positions["body"], expected)
                            np.testing.assert_array_equal(session.positions["body"], expected)
                    self.assertTrue(0 < went[1] < 1, went)
                    session.close()

    def test_trials_leave_the_scene_and_fractions_go_on_along_them(self):
        session = self.session()
        tried = session.step({"tip": lowered(2)}, trial=True)
        self.expect_hit(tried, 2)
        np.testing.assert_array_equal(session.positions["tip"], TIP)
        self.assertEqual(len(session.step(from_last_fraction=0.25)), 0)
        np.testing.assert_array_equal(session.positions["tip"], lowered(0.5))

    def test_a_scene_of_both_modes_asks_frame_by_frame(self):
        session = self.session(mode="dcd_and_ccd", thickness=1.5)
        self.assertEqual(session.step(mode="dcd").distance.min(), 1)
        self.expect_hit(session.step({"tip": lowered(2)}), 2)

    def test_an_edit_comes_with_its_frame_and_ids_follow(self):
        for transport in TRANSPORTS:
            session = self.session(transport=transport, edit_bytes=4096)
            second = collided.Mesh(lowered(3), ONE)
            contacts = session.step({"tip": lowered(2)}, edit=collided.Edit({"second": second}))
            self.assertEqual(contacts.of_mesh("tip").elements.tolist(), [[3, 0]])
            self.assertEqual(session.scene.layout.index("second"), 2)
            gone = session.step({"second": TIP}, start={"second": TIP}, edit=collided.Edit({"floor": None}))
            self.assertEqual(len(gone), 0)
            self.refused(collided.InvalidArgument, "'floor' is not in the scene", gone.of_mesh, "floor")
            back = session.step({"tip": lowered(2)}, start={"tip": TIP},
                                edit=collided.Edit({0: collided.Mesh(FLOOR, ONE, motion="static", name="floor")}))
            self.assertEqual(len(back.between("tip", "floor")), 1)
            session.close()

    def test_an_edit_of_rules_keeps_elements_and_positions(self):
        session = self.session()
        session.step({"tip": lowered(0.5)})
        self.assertEqual(len(session.step({"tip": lowered(2)}, edit=collided.Edit(exclude=[("tip", "floor")]))), 0)
        session.step({"tip": TIP})
        self.assertEqual(len(session.step({"tip": lowered(2)}, edit=collided.Edit(include=[("floor", "tip")]))), 1)
        session.step({"tip": TIP})
        other = collided.Mesh(vertex_count=3, groups=2, collide_mask=2)
        self.assertEqual(len(session.step({"tip": lowered(2)}, edit=collided.Edit({"tip": other}))), 0)

    def test_more_vertices_begin_where_the_edit_says(self):
        session = self.session()
        longer = collided.Mesh(np.concatenate([TIP, TIP + 20]), [[0, 1, 2], [3, 4, 5]])
        moved = np.concatenate([lowered(2), TIP + 20])
        self.expect_hit(session.step({"tip": moved}, edit=collided.Edit({"tip": longer})), 2)

    def test_an_edit_may_replace_a_mesh_by_one_of_another_name(self):
        session = self.session()
        session.step()
        for names in (("tip", "other"), ("other", "tip")):
            session.step(edit=collided.Edit({names[0]: None, names[1]: collided.Mesh(TIP, ONE)}))
            self.assertEqual([mesh.name for _, mesh in session.scene.layout.present()], ["floor", names[1]])
            self.expect_hit(session.step({names[1]: lowered(2)}), 2)
            self.assertEqual([mesh.name for mesh in session.scene.refresh().spec.meshes if mesh.vertex_count],
                             ["floor", names[1]])

    def test_an_edit_after_one_that_is_refused_is_of_the_scene_as_it_is(self):
        for transport in STREAMS:
            session = self.session(window=4, transport=transport, edit_bytes=4096)
            session.step()
            session.send(edit=collided.Edit({"bad": collided.Mesh(TIP * np.nan, ONE)}))
            session.send({"tip": lowered(2)}, edit=collided.Edit({"tip": collided.Mesh(TIP, ONE)}))
            self.refused(collided.InvalidArgument, "nan", session.receive)
            self.expect_hit(session.receive(), 2)
            self.assertEqual([mesh.name for _, mesh in session.scene.layout.present()], ["floor", "tip"])

    def test_frames_override_what_the_scene_says(self):
        session = self.session()
        contacts = session.step({"tip": lowered(2)}, report="any_hit", accuracy="fast", delta=1e-3)
        self.assertEqual((len(contacts), contacts.any_contact), (0, True))
        session.step({"tip": TIP})
        first = session.step({"tip": lowered(2)}, report="earliest_only", ignore_separating=True)
        self.expect_hit(first, 2)

    def test_latest_wins_reports_what_it_skipped(self):
        session = self.session(window=8, delivery="latest_wins")
        for step in range(8):
            session.send({"tip": lowered(2 * (step % 2))})
        answers = [session.receive() for _ in range(8)]
        self.assertEqual([answer.frame_id for answer in answers], list(range(1, 9)))
        self.assertFalse(answers[-1].skipped)
        self.assertTrue(all(len(answer) == 0 for answer in answers if answer.skipped))
        np.testing.assert_array_equal(session.positions["tip"], lowered(2))

    def test_contacts_without_room_in_shared_memory_are_all_there(self):
        sheet = np.stack([*np.meshgrid(np.arange(24.0), np.arange(24.0)), np.zeros((24, 24))], axis=2).reshape(-1, 3)
        corner = (np.arange(23)[:, None] * 24 + np.arange(23)).reshape(-1, 1)
        cells = np.concatenate([corner + [0, 1, 24], corner + [1, 25, 24]], axis=1).reshape(-1, 3)
        two = {"low": (sheet, cells), "high": (sheet + [0.25, 0.25, 1], cells)}
        found = [self.session(two, transport=transport, output_bytes=room).step({"high": sheet + [0.25, 0.25, -1]})
                 for transport, room in (("grpc", 0), ("shared_memory", 0), ("shared_memory", 8192), ("shared_memory", 8 << 20))]
        self.assertGreater(len(found[0]), 500)
        for other in found[1:]:
            assert_same(self, other, found[0])

    def test_the_first_frame_may_be_refused_and_sent_again(self):
        session = self.session({"floor": ONE, "tip": ONE}, position_format="f32", window=2)
        bad = FLOOR.copy()
        bad[1, 1] = np.nan
        session.send({"floor": bad, "tip": TIP})
        error = self.refused(collided.InvalidArgument, "updates", session.receive)
        self.assertEqual(error.frame_id, 1)
        self.expect_hit(session.step({"floor": FLOOR, "tip": lowered(2)}, start={"tip": TIP}), 2)

    @skip_if_forks_hang
    def test_a_forked_process_is_refused_and_leaves_the_scene_to_its_parent(self):
        for transport in TRANSPORTS:
            scene = collided.Scene(meshes(), server=self.server)
            self.addCleanup(scene.close)
            for what in (None, scene):
                session = self.session(what, transport=transport)
                session.step()
                child = os.fork()
                if child == 0:
                    try:
                        for call in (session.step, session.send, session.receive):
                            self.refused(collided.FailedPrecondition, "belongs to another process", call)
                        session.close()
                        session.scene.close()
                    except BaseException:
                        traceback.print_exc()
                        os._exit(1)
                    os._exit(0)
                self.assertEqual(os.waitpid(child, 0)[1], 0)
                self.expect_hit(session.step({"tip": lowered(2)}), 2)
                self.assertEqual((session.reconnects, session.recreations), (0, 0))
                session.close()

    def test_a_forked_process_leaves_the_daemon_to_its_parent(self):
        daemon = collided.OwnDaemon("--backend", "cpu")
        self.addCleanup(daemon.stop)
        address = daemon.address
        child = os.fork()
        if child == 0:
            daemon.stop()
            os._exit(daemon.pid)
        self.assertEqual(os.waitpid(child, 0)[1], 0)
        self.expect_hit(self.session(server=address).step({"tip": lowered(2)}), 2)
        self.assertEqual(daemon.address, address)

    def test_a_daemon_of_its_own_ignores_the_options_of_others(self):
        daemon = collided.OwnDaemon("--backend", "cpu", program=str(DAEMON))
        self.addCleanup(daemon.stop)
        with mock.patch.dict(os.environ, {"COLLIDED_BACKEND": "none", "COLLIDED_THREADS": "many"}):
            self.expect_hit(self.session(server=daemon.address).step({"tip": lowered(2)}), 2)

    def test_another_thread_is_refused_while_one_waits(self):
        for transport in TRANSPORTS:
            session = self.session(transport=transport)
            session.step()
            read, is_inside, may_go_on = session._stream._transport.read, threading.Event(), threading.Event()

            def wait_and_read(timeout):
                is_inside.set()
                may_go_on.wait(60)
                return read(timeout)

            session._stream._transport.read = wait_and_read
            with concurrent.futures.ThreadPoolExecutor(1) as pool:
                waiting = pool.submit(session.step, {"tip": lowered(2)})
                is_inside.wait(60)
                for call in (session.step, session.send, session.receive):
                    self.refused(collided.FailedPrecondition, "another thread is in a call", call)
                may_go_on.set()
                self.expect_hit(waiting.result(60), 2)
            self.assertEqual(session.reconnects, 0)
            session.close()

    def test_times_without_an_end_are_none(self):
        for transport in TRANSPORTS:
            session = self.session(transport=transport, reconnect_seconds=math.inf)
            for timeout in (math.inf, 1e300, 10**400, np.float32(60), 60):
                self.expect_hit(session.step({"tip": lowered(2)}, start={"tip": TIP}, timeout=timeout), 2)
            session.close()

    def test_scenes_are_listed_estimated_and_deleted(self):
        with collided.Client(self.server) as client:
            self.assertTrue(client.info.version)
            estimate = client.estimate(meshes(), thickness=0.1)
            self.assertEqual((estimate.vertex_count, estimate.triangle_count), (6, 2))
            with collided.Scene(meshes(), server=client, lease_seconds=60) as scene:
                self.assertIn(scene.id, [known.scene_id for known in client.scenes()])
                self.assertEqual(scene.refresh().lease_seconds, 60)
                with scene.session() as session:
                    self.expect_hit(session.step({"tip": lowered(2)}), 2)
                with scene.session(transport="calls") as session:  # goes on where the other one was
                    self.assertEqual(len(session.step({"tip": TIP})), 1)
            self.refused(collided.NotFound, "", client.get_scene, scene.id)

    def test_a_scene_outlives_its_sessions_and_is_where_they_left_it(self):
        scene = collided.Scene(meshes(), server=self.server)
        self.addCleanup(scene.close)
        for step in range(12):
            with scene.session(transport=TRANSPORTS[step % 3]) as session:
                self.assertEqual(session.recreations, 0)
                session.send({"tip": lowered(2 * (step % 2))})
                if step % 4 == 0:
                    session.receive()
        with scene.session() as session:
            np.testing.assert_allclose(session.step({"tip": TIP}).toi, [0.5], atol=1e-3)

    def test_what_a_scene_declares_reaches_the_daemon(self):
        cloth = collided.Mesh(TIP, ONE, exclude_rings=2, exclude_rest_pairs=True, groups=3, collide_mask=5,
                              self_contacts=False, edges=[[0, 1]], points=[2], half_thickness=0.75)
        options = {"mode": "dcd_and_ccd", "accuracy": "guarded", "thickness": 0.5, "delta": 0.25, "min_separation": 0.125,
                   "rest_distance": 2.0, "kinds": ["vt"], "fields": ["elements", "toi"], "report": "all", "backend": "cpu", "device": "cpu:0",
                   "broad_phase": "lbvh", "reuse": "on", "memory_budget": 1 << 28, "expected_contacts": 9,
                   "exclude": [("cloth", "floor")], "display_name": "all", "position_format": "q16",
                   "quantization_box": collided.Box((-9, -9, -9), (9, 9, 9))}
        scene = collided.Scene({"floor": meshes()["floor"], "cloth": cloth}, server=self.server, **options)
        self.addCleanup(scene.close)
        spec, mesh = scene.refresh().spec, scene.refresh().spec.meshes[1]
        for name in ("thickness", "delta", "min_separation", "rest_distance", "display_name"):
            self.assertEqual(getattr(spec, name), options[name])
        self.assertEqual(spec.expected_contacts, 9)
        self.assertEqual((spec.memory_budget_bytes, list(spec.kinds), list(spec.fields)), (1 << 28, [1], [1, 3]))
        self.assertEqual((spec.mode, spec.accuracy, spec.report, spec.backend, spec.broad_phase_engine), (3, 3, 1, 2, 6))
        self.assertEqual((spec.reuse, spec.device), (1, "cpu:0"))
        self.assertEqual([(pair.first, pair.second) for pair in spec.excluded_meshes], [(0, 1)])
        self.assertEqual((spec.position_format, list(spec.quantization_box.upper)), (3, [9, 9, 9]))
        self.assertEqual((mesh.exclude_rings, mesh.exclude_rest_pairs, mesh.groups, mesh.collide_mask), (2, True, 3, 5))
        self.assertEqual((mesh.no_self_contacts, mesh.edge_count, mesh.point_count, mesh.triangle_count), (True, 1, 1, 1))
        self.assertEqual([mesh.half_thickness for mesh in spec.meshes], [0, 0.75])

    def test_what_is_too_thick_for_the_format_the_daemon_refuses(self):
        with self.assertRaisesRegex(collided.InvalidArgument, r"is 1\.0000000000000001e\+300; it must be from 0 to") as refused:
            collided.Session({"floor": collided.Mesh(FLOOR, ONE, half_thickness=1e300)}, server=self.server)
        self.assertEqual(refused.exception.field, "spec.meshes[0].half_thickness")


class Thick(Case):
    """The tip is one above the floor, in DCD."""

    def thick(self, floor, tip):
        return {"floor": collided.Mesh(FLOOR, ONE, half_thickness=floor), "tip": collided.Mesh(TIP, ONE, half_thickness=tip)}

    def test_meshes_touch_up_to_the_thickness_and_both_halves(self):
        for transport in TRANSPORTS:
            counts = []
            for halves in ((0, 0), (0.25, 0), (0.25, 0.25), (0, 0.5), (0.25, 0.249)):
                session = self.session(what=self.thick(*halves), mode="dcd", thickness=0.5, transport=transport)
                counts.append(len(session.step()))
            self.assertEqual(counts, [0, 0, 1, 1, 0])

    def test_an_edit_makes_a_mesh_thicker_and_thinner(self):
        session = self.session(what=self.thick(0, 0), mode="dcd", thickness=0.5)
        counts = [len(session.step())]
        for half in (0.5, 0.25, 0.75):
            edit = collided.Edit({"tip": collided.Mesh(vertex_count=3, half_thickness=half)})
            counts.append(len(session.step(edit=edit)))
            self.assertEqual(session.scene.refresh().spec.meshes[1].half_thickness, half)
        self.assertEqual(counts, [0, 1, 0, 1])
        with self.assertRaises(collided.InvalidArgument) as refused:
            session.step(edit=collided.Edit({"tip": collided.Mesh(vertex_count=3, half_thickness=1e300)}))
        self.assertEqual(refused.exception.field, "frame.edit.meshes[0].spec.half_thickness")
        self.assertEqual(len(session.step()), 1)

    def test_fast_frames_need_a_distance_for_each_pair(self):
        with self.assertRaises(collided.InvalidArgument) as refused:
            self.session(what=self.thick(0, 0), mode="dcd", accuracy="fast")
        self.assertEqual(refused.exception.field, "spec.thickness")
        session = self.session(what=self.thick(0.6, 0.6), mode="dcd", accuracy="fast")
        self.assertEqual(len(session.step()), 1)

    def test_frames_of_sets_know_it(self):
        tips = np.stack([TIP, lowered(0.5)])
        for transport in TRANSPORTS:
            what = self.thick(0.25, 0.25)
            what["floor"] = collided.Mesh.of(what["floor"], motion="static")
            with collided.SceneBatch(what, 2, server=self.server, mode="dcd", thickness=0.25,
                                     transport=transport) as batch:
                self.assertEqual(batch.step(tips).counts.tolist(), [0, 1])


class Formats(Case):
    def test_encoded_and_double_positions_find_the_same(self):
        box = collided.Box((-16, -16, -16), (16, 16, 16))
        for options in ({"position_format": "f64"}, {"position_format": "q16", "quantization_box": box}):
            for transport in TRANSPORTS:
                session = self.session(transport=transport, **options)
                contacts = session.step({"tip": lowered(2)})
                np.testing.assert_allclose(contacts.toi, [0.5], atol=1e-2)
                np.testing.assert_allclose(session.positions["tip"], lowered(2), atol=1e-3)
                session.close()

    def test_encoded_positions_may_have_any_layout(self):
        box = collided.Box((0, 0, 0), (65535e4, 65535e4, 65535e4))
        encoded = np.array([[0, 0, 0], [7, 1, 2], [3, 9, 4]], "<u2")
        session = self.session({"tip": ONE}, position_format="q16", quantization_box=box)
        for positions in (encoded, np.asfortranarray(encoded), encoded.astype(">u2"), np.repeat(encoded, 2, axis=0)[::2]):
            session.step(positions)
            np.testing.assert_array_equal(session.positions["tip"], encoded * 1e4)

    def test_where_an_advance_leaves_encoded_positions_is_known_to_the_bit(self):
        box = collided.Box((-16, -16, -16), (16, 16, 16))
        for transport in STREAMS:
            session = self.session(transport=transport, position_format="q16", quantization_box=box, min_separation=0.01)
            gone = session.step({"tip": lowered(2)}, advance=True)
            start, target = (collided.unpack_quantized(collided.pack_quantized(p, box), box) for p in (TIP, lowered(2)))
            expected = collided.move_along(start, target, gone.advanced)
            np.testing.assert_array_equal(session.positions["tip"], expected)
            session.step({"tip": collided.Sparse([1], target[1:2])})
            expected[1] = target[1]
            np.testing.assert_array_equal(session.positions["tip"], expected)
            watcher = session.scene.watch(meshes=["tip"])
            session.step()
            np.testing.assert_array_equal(watcher.receive(timeout=30).positions["tip"], expected)
            watcher.close()

    def test_what_the_client_knows_is_where_the_daemon_is(self):
        session = self.session({"tip": (TIP, ONE), "other": collided.Mesh(TIP + [3, 0, 0], ONE, motion="rigid")})
        watcher = session.scene.watch(meshes=["tip", "other"])
        last = None
        turn = np.array([[0.8, -0.6, 0, 0.1], [0.6, 0.8, 0, 0.2], [0, 0, 1, 0.3]])
        for positions, options in (({"tip": lowered(0.7)}, {}), ({"tip": collided.Sparse([2], TIP[:1])}, {}),
                                   ({"tip": lowered(1.3)}, {"trial": True}), ({}, {"from_last_fraction": 1 / 3}),
                                   ({"tip": TIP, "other": collided.Rigid(np.eye(3, 4) + [[0, 0, 0, 0.7]])}, {"advance": True}),
                                   ({"other": collided.Rigid(turn)}, {})):
            session.step(positions, **options)
            while last is None or last.contacts.frame_id != session.scene.track.last_applied:
                last = watcher.receive(timeout=30)
            for name, expected in session.positions.items():
                np.testing.assert_array_equal(last.positions[name], expected, f"{name}, {options}")
        watcher.close()

    def test_points_are_those_of_the_conventions(self):
        for mode, start in (("ccd", {"tip": TIP}), ("dcd", None)):
            session = self.session(mode=mode, thickness=0.01)
            contacts = session.step({"tip": lowered(1.005 if mode == "dcd" else 2)}, start)
            first, second = contacts.points
            np.testing.assert_allclose(np.linalg.norm(first - second, axis=1), contacts.distance, atol=1e-6)
            np.testing.assert_allclose(second, [[1, 1, 0]], atol=1e-6)

    def test_an_option_without_effect_is_warned_of_once(self):
        session = self.session(min_separation=0.01)
        with self.assertWarnsRegex(UserWarning, "min_separation .*advance=True"):
            contacts = session.step({"tip": lowered(2)})
        self.assertEqual(list(contacts.metrics.unused_options), ["spec.min_separation"])
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            session.step({"tip": TIP})
            self.assertEqual(list(session.step({"tip": lowered(0.5)}, advance=True).metrics.unused_options), [])

    def test_warnings_point_at_the_callers_line(self):
        meshes, options = {"floor": (FLOOR, ONE), "tip": (TIP, ONE)}, {"min_separation": 0.01, "server": self.server}

        def step():
            with collided.Session(meshes, **options) as session:
                session.step({"tip": lowered(2)})  # here

        def run():
            with collided.Session(meshes, **options, transport="calls") as session:
                list(session.run([{"tip": lowered(2)}]))  # here

        def detect():
            collided.detect(TIP, lowered(2), ONE, **options)  # here

        async def aio_step():
            async with collided.aio.Session(meshes, **options) as session:
                await session.step({"tip": lowered(2)})  # here

        async def aio_run():
            async with collided.aio.Session(meshes, **options) as session:
                async for _ in session.run([{"tip": lowered(2)}]):  # here
                    pass

        async def aio_detect():
            await collided.aio.detect(TIP, lowered(2), ONE, **options)  # here

        for way in (step, run, detect, aio_step, aio_run, aio_detect):
            with self.subTest(way.__name__), warnings.catch_warnings(record=True) as given:
                warnings.simplefilter("always")
                asyncio.run(way()) if inspect.iscoroutinefunction(way) else way()
                (unused,) = [warning for warning in given if "had no effect" in str(warning.message)]
                self.assertEqual(unused.filename, __file__)
                self.assertIn("# here", linecache.getline(__file__, unused.lineno))


class SmallMessages(Case):
    options = ("--max-message-mb", "1")

    def test_a_message_that_is_too_large_names_the_option(self):
        for vertices in (100_000, 300_000):  # a little more than the limit, which the daemon refuses; much more, which gRPC does
            for transport in ("grpc", "calls"):
                with self.assertRaisesRegex(collided.ResourceExhausted, "max-message-mb"):
                    with collided.Session({"large": (np.zeros((vertices, 3), "<f4"), ONE)}, server=self.server,
                                          transport=transport) as session:
                        session.step()


if __name__ == "__main__":
    main()
