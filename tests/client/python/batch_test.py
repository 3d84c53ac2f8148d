#!/usr/bin/env python3
"""Sets of scenes, stepped together."""

import contextlib

from support import DAEMON, FLOOR, ONE, TIP, Case, Daemon, assert_same_columns, lowered, main, meshes, np

import collided
from collided.transport.opening import StreamOptions
from collided.set_frames import SetFrames


def falls(*depths):
    """Tips of so many worlds, which fall so deep."""
    return np.stack([lowered(depth) for depth in depths])


def stream_options(transport):
    return StreamOptions(window=1, delivery=0, transport=transport, output_bytes=0, edit_bytes=0, daemon_user=None)


class Batches(Case):
    def batch(self, count, scene=None, **options):
        made = collided.SceneBatch(scene or meshes(), count, server=self.server, **options)
        self.addCleanup(made.close)
        return made

    def test_each_world_has_the_contact_that_was_built_in(self):
        batch = self.batch(4)
        self.assertEqual(batch.count, 4)
        contacts = batch.step(falls(2, 0.5, 4, 1.25), start=falls(0, 0, 0, 0))
        self.assertEqual(list(contacts), [0, 1, 2, 3])
        np.testing.assert_array_equal(contacts.counts, [1, 0, 1, 1])
        np.testing.assert_array_equal(contacts.world_of, [0, 2, 3])
        np.testing.assert_allclose(contacts.all.toi, [1 / 2, 1 / 4, 1 / 1.25], atol=1e-3)
        np.testing.assert_array_equal(contacts[2].elements, [[3, 0]])
        np.testing.assert_array_equal(contacts[2].stencils, [[3, 0, 1, 2]])
        self.assertEqual(len(contacts[1]), 0)
        self.assertEqual(contacts.refused, {})

    def test_some_worlds_move_and_the_others_stay(self):
        batch = self.batch(3)
        batch.step(falls(0.5, 0.5, 0.5))
        contacts = batch.step(falls(1.5), worlds=[1])
        self.assertEqual(list(contacts), [1])
        np.testing.assert_allclose(contacts[1].toi, [0.5], atol=1e-3)
        np.testing.assert_array_equal(batch.step(falls(0.75, 0.5, 1.25)).counts, [0, 1, 1])

    def test_worlds_are_answered_as_scenes_of_their_own(self):
        rng = np.random.default_rng(3)
        triangles = np.arange(90, dtype="<u4").reshape(30, 3)
        start, end = rng.uniform(0, 1, (2, 5, 90, 3)).astype("<f4")
        batch = self.batch(5, collided.Mesh(triangles=triangles), position_format="f32")
        contacts = batch.step(end, start=start)
        self.assertGreater(contacts.counts.min(), 100)
        for world in range(5):
            alone = collided.detect(start[world], end[world], triangles, server=self.server)
            assert_same_columns(self, contacts[world], alone)

    def test_a_bad_world_harms_no_other(self):
        batch = self.batch(3)
        batch.step(falls(0.5, 0.5, 0.5))
        bad = falls(2, 2, 2)
        bad[1, 2, 0] = np.nan
        contacts = batch.step(bad)
        np.testing.assert_array_equal(contacts.counts, [1, 0, 1])
        self.assertEqual(list(contacts.refused), [1])
        self.assertIsInstance(contacts.refused[1], collided.InvalidArgument)
        self.assertIn("world 1, mesh 1, vertex 2, coordinate x is nan", contacts.refused[1].message)
        np.testing.assert_array_equal(batch.step(falls(2, 0.75, 2)).counts, [0, 0, 0])

    def test_bad_arguments_are_named_before_anything_is_sent(self):
        batch = self.batch(2)
        batch.step(falls(0.5, 0.5))
        refused = self.refused
        refused(collided.InvalidArgument, r"positions has shape \(1, 3, 3\); it must be \(2, 6, 3\) or \(2, 3, 3\)", batch.step,
                falls(1))
        refused(collided.InvalidArgument, r"worlds are \[1, 0\]", batch.step, falls(1, 1), worlds=[1, 0])
        refused(collided.InvalidArgument, "below 2", batch.step, falls(1), worlds=[2])
        refused(collided.InvalidArgument, "accuracy is 'no'", batch.step, falls(1, 1), accuracy="no")
        refused(collided.InvalidArgument, r"frame.mode is DCD", batch.step, falls(1, 1), mode="dcd")
        refused(collided.InvalidArgument, "count is 0", collided.SceneBatch, meshes(), 0, server=self.server)
        refused(collided.InvalidArgument, "no option of a scene", collided.SceneBatch, meshes(), 2, colour=1)
        self.assertEqual(batch.step(falls(2, 2)).counts.tolist(), [1, 1])

    def test_static_meshes_come_with_the_first_frame(self):
        bare = self.batch(2, {"floor": collided.Mesh(triangles=ONE, motion="static"), "tip": ONE}, position_format="f32")
        self.refused(collided.InvalidArgument, "static mesh 'floor' has no vertices", bare.step, falls(1, 1))
        whole = np.concatenate([np.broadcast_to(FLOOR, (2, 3, 3)), falls(0.5, 0.5)], axis=1)
        self.assertEqual(len(bare.step(whole).all), 0)
        self.assertEqual(bare.step(falls(2, 0.75)).counts.tolist(), [1, 0])

    def test_every_transport_gives_the_same_contacts(self):
        rng = np.random.default_rng(5)
        scene = collided.Mesh(triangles=np.arange(36, dtype="<u4").reshape(12, 3))
        batches = [self.batch(6, scene, position_format="f32", transport="calls"),
                   self.batch(6, scene, position_format="f32", transport="grpc"),
                   self.batch(6, scene, position_format="f32", transport="shared_memory"),
                   self.batch(6, scene, position_format="f32", transport="shared_memory", output_bytes=4096)]
        for worlds in (None, None, [0, 2, 5]):
            start, end = rng.uniform(0, 1, (2, len(worlds or range(6)), 36, 3)).astype("<f4")
            wanted, *others = (batch.step(end, start=start, worlds=worlds) for batch in batches)
            self.assertGreater(wanted.counts.min(), 10)
            for contacts in others:
                np.testing.assert_array_equal(contacts.counts, wanted.counts)
                np.testing.assert_array_equal(contacts.world_of, wanted.world_of)
                for world in wanted:
                    assert_same_columns(self, contacts[world], wanted[world])
        self.assertEqual([batch.is_local for batch in batches], [False, False, True, True])

    def test_a_bad_world_is_told_over_every_transport(self):
        for transport in ("calls", "grpc", "shared_memory"):
            batch = self.batch(300, transport=transport)
            bad = falls(*[2] * 300)
            bad[1:, 2, 0] = np.nan
            contacts = batch.step(bad)
            self.assertEqual(list(contacts.refused), list(range(1, 300)))
            self.assertIn("world 1, mesh 1, vertex 2, coordinate x is nan", contacts.refused[1].message)
            self.assertEqual(contacts.counts.tolist(), [0] * 300)

    def test_a_stream_that_has_ended_is_opened_again(self):
        for transport in ("grpc", "shared_memory"):
            batch = self.batch(2, transport=transport)
            batch.step(falls(0.5, 0.5))
            other = SetFrames(batch.client, batch.message, stream_options(transport=transport))
            other._open()  # takes the set over
            other.close()
            self.refused(collided.Aborted, "took over", batch.step, falls(2, 0.75))
            self.assertEqual(batch.step(falls(2, 0.75)).counts.tolist(), [1, 0])
            batch._frames._transport.half_close()  # the daemon ends it, as it does with those that are idle
            self.assertEqual(batch.step(falls(2, 2)).counts.tolist(), [0, 1])

    def test_a_daemon_that_is_gone_hides_no_error_of_the_callers(self):
        for raised in (KeyError, None):
            daemon = Daemon(str(DAEMON))
            self.addCleanup(daemon.kill)
            with self.assertRaises(raised) if raised else contextlib.nullcontext():
                with collided.SceneBatch(meshes(), 2, server=daemon.address) as batch:
                    batch.step(falls(2, 2))
                    daemon.process.kill()
                    daemon.process.wait()
                    if raised:
                        raise raised

    def test_the_daemon_tells_what_it_holds(self):
        batch = self.batch(6)
        with collided.Client(self.server) as client:
            scene = client.get_scene(batch.id)
        self.assertEqual((scene.worlds, scene.vertex_count), (6, len(FLOOR) + len(TIP)))


if __name__ == "__main__":
    main()
