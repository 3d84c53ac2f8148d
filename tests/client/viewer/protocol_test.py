#!/usr/bin/env python3
"""What the page of collidectl view is sent: scenes, frames and contacts, as the daemon has them, at the page's pace."""

import numpy as np
from viewer_support import ViewerCase, main

import collided
from support import FLOOR, ONE, TIP, lowered

QUIET_SECONDS = 0.3  # in which a message that must not come would have come


def grid(side):
    """`side` x `side` vertices of a bowl."""
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(side), np.arange(side)))
    at = np.arange(side * side).reshape(side, side)
    a, b, c, d = (part.ravel() for part in (at[:-1, :-1], at[:-1, 1:], at[1:, :-1], at[1:, 1:]))
    triangles = np.concatenate([np.stack([a, b, d], 1), np.stack([a, d, c], 1)])
    return np.stack([x, y, (x - side / 2) ** 2 / side + (y - side / 2) ** 2 / side], 1).astype("<f4"), triangles.astype("<u4")


def area(positions, triangles):
    a, b, c = (positions[triangles[:, i]] for i in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2


class Messages(ViewerCase):
    def test_a_scene_is_shown_as_it_is(self):
        session = self.session()
        session.step()
        _, scene = self.look_at(session)
        self.assertEqual(scene["scene_id"], session.scene.id)
        self.assertEqual([(mesh["name"], mesh["first"], mesh["vertices"], mesh["triangles"]) for mesh in scene["meshes"]],
                         [("floor", 0, 3, 1), ("tip", 3, 3, 1)])
        self.assertEqual(scene["triangles"], (0, 1, 2, 3, 4, 5))
        self.assertEqual((scene["vertex_stride"], scene["scene"]["triangles"]), (1, 2))

    def test_a_frame_has_the_positions_and_contacts_that_its_sender_got(self):
        for form in ("f32", "f64"):
            session = self.session(position_format=form)
            session.step()
            socket, scene = self.look_at(session)
            for depth in (2, 4):
                sent = session.step({"tip": lowered(depth)}, start={"tip": TIP})
                last = self.last_frame(session)
                frame = socket.until("frame", lambda frame: frame["frame"] == last)
                self.assertEqual(frame["epoch"], scene["epoch"])
                self.assertEqual(frame["vertex_triangle"], (3, 0, 1, 2))
                self.assertEqual((frame["edge_edge"], frame["triangle_triangle"], frame["edge_triangle"]), ((), (), ()))
                self.assertEqual((frame["contact_count"], frame["earliest_toi"]), (1, sent.earliest_toi))
                self.assertEqual(frame["counts"]["contacts_vertex_triangle"], 1)
                self.assertGreater(sum(frame["stage_ms"].values()), 0)
                shown = np.array(frame["positions"]).reshape(-1, 3) + frame["origin"]
                np.testing.assert_allclose(shown, np.concatenate([FLOOR, lowered(depth)]), atol=1e-6)

    def test_far_from_the_origin_positions_keep_their_digits(self):
        far = np.array([1e9, -1e9, 0])
        session = self.session({"floor": collided.Mesh(FLOOR + far, ONE)}, position_format="f64")
        session.step()
        socket, _ = self.look_at(session)
        session.step({"floor": FLOOR + far + 0.125})
        frame = socket.until("frame")
        shown = np.array(frame["positions"]).reshape(-1, 3)
        np.testing.assert_allclose(shown - shown[0], FLOOR - FLOOR[0], atol=1e-6)

    def test_loose_elements_are_shown(self):
        hair = collided.Mesh(np.array([[0, 0, 1], [1, 0, 1], [0, 0, 3]], "<f4"), edges=[[0, 1]], points=[2])
        session = self.session({"floor": collided.Mesh(FLOOR, ONE), "hair": hair})
        session.step()
        _, scene = self.look_at(session)
        self.assertEqual((scene["triangles"], scene["edges"], scene["points"]), ((0, 1, 2), (3, 4), (5,)))

    def test_triangles_that_cross_are_named_by_their_corners(self):
        session = self.session({"floor": collided.Mesh(FLOOR, ONE), "tip": collided.Mesh(lowered(2), ONE)}, mode="dcd",
                               kinds=["tt"])
        session.step()
        socket, _ = self.look_at(session)
        session.step({"tip": lowered(2)})
        frame = socket.until("frame")
        self.assertEqual(frame["triangle_triangle"], (0, 1, 2, 3, 4, 5))

    def test_edges_through_triangles_are_named_by_their_ends_and_its_corners(self):
        session = self.session({"floor": collided.Mesh(FLOOR, ONE), "tip": collided.Mesh(lowered(2), ONE)}, mode="dcd",
                               kinds=["et"])
        session.step()
        socket, _ = self.look_at(session)
        found = session.step({"tip": lowered(2)})
        frame = socket.until("frame")
        self.assertEqual([edge.tolist() for edge in found.elements], [[3, 0], [4, 0]])
        self.assertEqual(frame["edge_triangle"], (3, 4, 0, 1, 2, 3, 5, 0, 1, 2))
        self.assertEqual(frame["counts"]["contacts_edge_triangle"], 2)

    def test_an_edit_is_a_new_scene(self):
        session = self.session()
        session.step()
        socket, first = self.look_at(session)
        two = collided.Mesh(np.concatenate([TIP, TIP + [9, 9, 0]]).astype("<f4"), [[0, 1, 2], [3, 4, 5]])
        session.step(edit=collided.Edit({"tip": two}))
        second = socket.until("scene", lambda scene: len(scene["triangles"]) > 6)
        self.assertGreater(second["epoch"], first["epoch"])
        self.assertEqual(second["triangles"], (0, 1, 2, 3, 4, 5, 6, 7, 8))
        session.step()
        frame = socket.until("frame", lambda frame: frame["epoch"] == second["epoch"])
        self.assertEqual(len(frame["positions"]), 27)

    def test_what_is_too_large_is_thinned_and_stays_whole(self):
        positions, triangles = grid(500)  # 3 MB, more than a watch's message holds
        session = self.session({"grid": collided.Mesh(positions, triangles, self_contacts=False)})
        session.step()
        socket, scene = self.look_at(session)
        session.step()
        self.assertEqual(scene["vertex_stride"], 2)
        self.assertEqual(scene["meshes"][0]["vertices"], 125000)
        shown = np.array(socket.until("frame")["positions"]).reshape(-1, 3)
        thinned = area(shown, np.array(scene["triangles"]).reshape(-1, 3))
        self.assertAlmostEqual(thinned / area(positions, triangles), 1, delta=0.01)


class Pace(ViewerCase):
    def test_a_frame_comes_once_it_is_asked_for_and_is_the_latest(self):
        session = self.session()
        session.step()
        viewer = self.view_session(session, "--rate", "1000")
        socket, _ = self.look_at(session, viewer=viewer)
        session.step()
        while socket.receive()["kind"] != "frame":
            pass
        for _ in range(20):
            session.step()
        last = self.last_frame(session)
        with self.assertRaises(TimeoutError):
            socket.receive(QUIET_SECONDS)
        self.open(viewer).until("frame", lambda frame: frame["frame"] == last)
        socket.ask()
        self.assertEqual(socket.until("frame")["frame"], last)

    def test_one_that_reads_nothing_holds_up_nobody_and_takes_no_memory(self):
        session = self.session({"heavy": collided.Mesh(np.zeros((90000, 3), "<f4"), ONE)})  # 1 MB a frame, and no work
        session.step()
        viewer = self.view_session(session, "--rate", "1000")
        reader, _ = self.look_at(session, viewer=viewer)
        silent = [self.open(viewer) for _ in range(8)]
        for socket in silent:
            for _ in range(1000):  # as if each frame had been shown
                socket.ask()
        session.step()
        reader.until("frame")
        before = viewer.resident_bytes()
        for _ in range(40):
            session.step()
        last = self.last_frame(session)
        reader.until("frame", lambda frame: frame["frame"] == last)
        self.assertLess(viewer.resident_bytes() - before, 24 << 20)

    def test_all_who_look_see_the_same(self):
        session = self.session()
        session.step()
        viewer = self.view_session(session)
        sockets = [self.look_at(session, viewer=viewer)[0] for _ in range(5)]
        sent = session.step({"tip": lowered(2)})
        last = self.last_frame(session)
        for socket in sockets:
            frame = socket.until("frame", lambda frame: frame["frame"] == last)
            self.assertEqual(frame["contact_count"], len(sent))


if __name__ == "__main__":
    main()
