#!/usr/bin/env python3
"""The frames of a scene as an observer sees them."""

import threading

from support import ONE, TIP, Case, lowered, main, np

import collided
from collided.connection.mesh_elements import read_elements
from collided.v1 import collision_service_pb2 as api


class Watching(Case):
    def watch(self, session, **options):
        watcher = session.scene.watch(**options)
        self.addCleanup(watcher.close)
        return watcher

    def shown(self, watcher, sent):
        """A frame that was sent after the watch began. One that was answered before may be shown after that, too."""
        while (frame := watcher.receive(timeout=30)).contacts.wire_id < sent.wire_id:
            continue
        return frame

    def test_frames_contacts_and_positions(self):
        for form in ("f32", "f64"):
            session = self.session(position_format=form)
            session.step()
            watcher = self.watch(session, max_contacts_per_kind=8, meshes=["tip", 0])
            self.assertEqual(watcher.scene.scene_id, session.scene.id)
            sent = session.step({"tip": lowered(2)})
            frame = self.shown(watcher, sent)
            self.assertEqual(frame.contacts.stencils.tolist(), sent.stencils.tolist())
            self.assertEqual(frame.contacts.of_mesh("tip").toi.tolist(), sent.toi.tolist())
            self.assertEqual((frame.skipped_frames, frame.omitted_contacts, frame.vertex_stride), (0, 0, 1))
            np.testing.assert_array_equal(frame.positions["tip"], lowered(2))
            self.assertEqual(frame.positions["tip"].dtype, session.positions["tip"].dtype)
            self.assertEqual(list(frame.positions), ["tip", "floor"])
            self.refused(collided.FailedPrecondition, "watched", getattr, frame.contacts, "points")
            self.assertIsNone(watcher.receive(timeout=0.05))

    def test_what_is_left_out_is_counted(self):
        session = self.session()
        session.step()
        watcher = self.watch(session, frame_interval=2)
        for depth in (0, 2, 0, 2):
            session.step({"tip": lowered(depth)})
        frames = [watcher.receive(timeout=30) for _ in range(2)]
        self.assertEqual(sum(frame.skipped_frames + 1 for frame in frames) <= 4, True)
        self.assertGreaterEqual(max(frame.omitted_contacts for frame in frames), 1)

    def test_edits_are_followed(self):
        session = self.session(edit_bytes=4096)
        session.step()
        watcher = self.watch(session, max_contacts_per_kind=8)
        sent = session.step({"tip": lowered(2)}, edit=collided.Edit({"far": collided.Mesh(TIP + 50, ONE)}))
        frame = self.shown(watcher, sent)
        self.assertEqual((frame.edit_count, len(frame.contacts.of_mesh("far")), len(frame.contacts.of_mesh("tip"))), (1, 0, 1))

    def test_a_watched_mesh_that_is_removed_has_no_positions(self):
        session = self.session()
        session.step()
        watcher = self.watch(session, meshes=["tip"])
        for edit in ({"far": collided.Mesh(TIP + 50, ONE)}, {"tip": None}):  # of which the watcher sees the first one late
            sent = session.step(edit=collided.Edit(edit))
        frame = self.shown(watcher, sent)
        self.assertEqual((frame.edit_count, list(frame.positions), len(frame.positions["tip"])), (2, ["tip"], 0))

    def test_what_meshes_are_made_of_is_told_as_edits_leave_it(self):
        hair = collided.Mesh(triangles=ONE, edges=[[2, 3], [3, 4]], points=[5], vertices=np.eye(6, 3))
        session = self.session({"tip": collided.Mesh(TIP, ONE), "hair": hair}, edit_bytes=4096)
        client, scene = session.scene.client, session.scene
        mesh = client.get_mesh(scene.id, 1)
        self.assertEqual((mesh.vertex_count, mesh.edit_count), (6, 0))
        self.assertEqual(mesh.elements.tolist(), [[0, 1, 2], [2, 3, 3], [3, 4, 4], [5, 5, 5]])
        self.assertEqual([mesh.triangles.tolist(), mesh.edges.tolist(), mesh.points.tolist()],
                         [[[0, 1, 2]], [[2, 3], [3, 4]], [5]])
        session.step(edit=collided.Edit({"hair": None}))
        mesh = client.get_mesh(scene.id, 1)
        self.assertEqual((mesh.elements.shape, mesh.vertex_count, mesh.edit_count), ((0, 3), 0, 1))
        for bad in (2, -1, 1.5, True, 2**32):
            self.assertIn("mesh", self.refused(collided.InvalidArgument, "mesh", client.get_mesh, scene.id, bad).field)
        self.refused(collided.NotFound, "", client.get_mesh, "none", 0)

    def test_a_mesh_of_several_pages_is_read_whole(self):
        triangles = np.arange(120_000)[:, None] + [0, 1, 2]
        with collided.Scene(collided.Mesh(triangles=triangles, vertex_count=120_002), server=self.server,
                            position_format="f32") as scene:
            np.testing.assert_array_equal(scene.client.get_mesh(scene.id, 0).triangles, triangles)

    def test_a_mesh_that_is_edited_between_two_pages_is_read_again(self):
        triangles = np.arange(90_000)[:, None] + [0, 1, 2]
        strip = collided.Mesh(triangles=triangles, vertices=np.arange(90_002)[:, None] * [1, 0, 0], self_contacts=False)
        session = self.session({"strip": strip}, transport="grpc")
        session.step()
        asked = []

        def page_from(element):
            asked.append(element)
            page = session.scene.client.call("GetMesh", api.GetMeshRequest(scene_id=session.scene.id, first_element=element))
            if len(asked) == 1:
                session.step(edit=collided.Edit({"strip": collided.Mesh(triangles=ONE, vertex_count=90_002, self_contacts=False)}))
            return page

        mesh = read_elements(page_from)
        self.assertEqual((mesh.elements.tolist(), mesh.edit_count, len(asked)), (ONE.tolist(), 1, 3))

    def test_wire_ids_tell_which_frame_of_the_session_is_shown(self):
        session = self.session(edit_bytes=4096)
        session.step()
        watcher = self.watch(session)
        edited = session.step({"tip": lowered(2)}, edit=collided.Edit({"far": collided.Mesh(TIP + 50, ONE)}))
        self.assertEqual((self.shown(watcher, edited).contacts.wire_id, edited.frame_id), (edited.wire_id, 2))
        moved = session.step({"tip": lowered(3)})
        self.assertEqual((watcher.receive(timeout=30).contacts.frame_id, moved.frame_id), (moved.wire_id, 3))

    def test_it_ends_with_the_scene_or_when_it_is_told(self):
        for end in (lambda session, watcher: session.close(), lambda session, watcher: watcher.close()):
            session = self.session()
            session.step()
            watcher = self.watch(session)
            seen = []
            thread = threading.Thread(target=lambda: seen.extend(watcher))
            thread.start()
            session.step({"tip": lowered(2)})
            end(session, watcher)
            thread.join(30)
            self.assertFalse(thread.is_alive())
            self.assertLessEqual(len(seen), 2)  # as of shown()

    def test_it_does_not_end_silently_when_its_connection_breaks(self):
        session = self.session()
        session.step()
        watcher = self.watch(session)
        watcher._messages._call.cancel()
        self.refused(collided.Cancelled, "", list, watcher)

    def test_bad_requests_are_refused(self):
        session = self.session()
        self.refused(collided.InvalidArgument, "mesh 'wall'", session.scene.watch, meshes=["wall"])
        self.refused(collided.InvalidArgument, "", session.scene.watch, max_contacts_per_kind=9000)
        self.refused(collided.NotFound, "", collided.Watcher, session.scene.client, "no scene")
        self.refused(collided.InvalidArgument, "max_frames_per_second", session.scene.watch, max_frames_per_second=-1.0)


if __name__ == "__main__":
    main()
