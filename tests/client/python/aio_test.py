#!/usr/bin/env python3
"""The package in an event loop."""

import asyncio
import contextlib
import signal
import unittest

from support import ONE, STREAMS, TIP, Case, Supervised, assert_same, lowered, main, meshes, np

import collided
import collided.aio


class Aio(Case):
    def run_in_loop(self, coroutine):
        return asyncio.run(asyncio.wait_for(coroutine, 60))

    def test_steps_streams_and_errors_are_those_of_the_package(self):
        async def play(transport):
            async with collided.aio.Session(meshes(), server=self.server, transport=transport, window=3) as session:
                self.expect_hit(await session.step({"tip": lowered(2)}), 2)
                np.testing.assert_array_equal(session.positions["tip"], lowered(2))
                with self.assertRaisesRegex(collided.InvalidArgument, "mesh 'tap'"):
                    await session.step({"tap": TIP})
                with self.assertRaises(collided.InvalidArgument):
                    await session.step({"tip": TIP * np.nan})
                depths = [0, 2] * 6
                answers = [contacts async for contacts in session.run({"tip": lowered(depth)} for depth in depths)]
                self.assertEqual([len(contacts) for contacts in answers], [1] * 12)
                self.assertEqual((session.sync.reconnects, session.sync.in_flight), (0, 0))
                with self.assertRaises(collided.FailedPrecondition):
                    await session.receive()

        for transport in STREAMS:
            self.run_in_loop(play(transport))

    def test_frames_may_be_made_asynchronously(self):
        async def frames():
            for depth in (0, 2, 0):
                await asyncio.sleep(0)
                yield {"tip": lowered(depth)}

        async def play():
            async with collided.aio.Session(meshes(), server=self.server) as session:
                return [contacts async for contacts in session.run(frames())]

        expected = list(self.session().run({"tip": lowered(depth)} for depth in (0, 2, 0)))
        for ours, other in zip(self.run_in_loop(play()), expected, strict=True):
            assert_same(self, ours, other)

    def test_many_sessions_share_the_loop(self):
        async def one(depth):
            async with collided.aio.Session(meshes(), server=self.server) as session:
                for _ in range(5):
                    contacts = await session.step({"tip": lowered(depth)}, {"tip": TIP})
                return contacts

        async def all_of_them():
            return await asyncio.gather(*(one(depth) for depth in (2, 3, 4, 5)))

        for depth, contacts in zip((2, 3, 4, 5), self.run_in_loop(all_of_them())):
            self.expect_hit(contacts, depth)

    def test_one_question(self):
        contacts = self.run_in_loop(collided.aio.detect(TIP, lowered(2), ONE, server=self.server))
        self.assertEqual(len(contacts), 0)
        near = self.run_in_loop(collided.aio.proximity(TIP, ONE, thickness=1, server=self.server))
        self.assertEqual(len(near), 0)

    def test_watchers(self):
        async def play():
            async with collided.aio.Session(meshes(), server=self.server) as session:
                async with collided.aio.Watcher(session.sync.scene.client, session.sync.scene.id,
                                                max_contacts_per_kind=9, meshes=["tip"]) as watcher:
                    frames = aiter(watcher)
                    await session.step({"tip": lowered(2)})
                    frame = await anext(frames)
                    while not len(frame.contacts):  # where the scene was put at the beginning
                        frame = await anext(frames)
                    return frame

        frame = self.run_in_loop(play())
        self.assertEqual(frame.contacts.elements.tolist(), [[3, 0]])
        np.testing.assert_array_equal(frame.positions["tip"], lowered(2))


class Cancelled(unittest.TestCase):
    def test_a_call_that_is_cancelled_loses_no_frame(self):
        async def play(daemon, transport):
            async with collided.aio.Session(meshes(), server=daemon.address, transport=transport) as session:
                await session.step({"tip": TIP})
                daemon.freeze()
                with self.assertRaises(TimeoutError):
                    async with asyncio.timeout(0.1):
                        await session.step({"tip": lowered(2)})
                with self.assertRaises(TimeoutError):
                    async with asyncio.timeout(0.05):
                        await session.receive()
                with self.assertRaises(collided.FailedPrecondition):
                    await session.step({"tip": TIP})
                daemon.process.send_signal(signal.SIGCONT)
                np.testing.assert_allclose((await session.receive()).toi, [0.5], atol=1e-3)
                self.assertEqual(len(await session.step({"tip": TIP})), 1)

        for transport in STREAMS:
            daemon = Supervised()
            self.addCleanup(daemon.close)
            asyncio.run(asyncio.wait_for(play(daemon, transport), 60))

    def test_receives_that_are_cancelled_together_keep_their_order(self):
        async def play(daemon):
            async with collided.aio.Session(meshes(), server=daemon.address, window=4) as session:
                await session.step({"tip": TIP})
                daemon.freeze()
                for _ in range(3):
                    await session.send({"tip": TIP})
                receives = [asyncio.create_task(session.receive()) for _ in range(3)]
                await asyncio.sleep(0.05)
                for receive in receives[:2]:
                    receive.cancel()
                await asyncio.wait(receives[:2])
                daemon.process.send_signal(signal.SIGCONT)
                answers = [await session.receive(), await session.receive(), await receives[2]]
                self.assertEqual([contacts.frame_id for contacts in answers], [2, 3, 4])

        daemon = Supervised()
        self.addCleanup(daemon.close)
        asyncio.run(asyncio.wait_for(play(daemon), 60))

    def test_a_frame_that_is_refused_takes_none_from_the_iterator(self):
        async def play(daemon):
            async with collided.aio.Session(meshes(), server=daemon.address, window=2) as session:
                frames = ({"tip": lowered(depth)} for depth in (0, np.nan, 2, 0))
                with self.assertRaises(collided.InvalidArgument):
                    async for _ in session.run(frames):
                        continue
                self.assertEqual([contacts.frame_id async for contacts in session.run(frames)], [3, 4])

        daemon = Supervised()
        self.addCleanup(daemon.close)
        asyncio.run(asyncio.wait_for(play(daemon), 60))

    def test_a_watched_frame_is_not_lost(self):
        async def play(daemon):
            async with collided.aio.Session(meshes(), server=daemon.address) as session:
                await session.step()
                async with collided.aio.Watcher(session.sync.scene.client, session.sync.scene.id) as watcher:
                    frames = aiter(watcher)
                    with self.assertRaises(TimeoutError):
                        async with asyncio.timeout(0.2):
                            while True:  # the first frame may be shown
                                await anext(frames)
                    sent = await session.step({"tip": TIP})
                    await asyncio.sleep(0.1)
                    await session.step({"tip": TIP})
                    self.assertEqual((await anext(frames)).contacts.wire_id, sent.wire_id)

        daemon = Supervised()
        self.addCleanup(daemon.close)
        asyncio.run(asyncio.wait_for(play(daemon), 60))

    def test_a_session_that_nobody_waits_for_leaves_no_scene(self):
        async def play(daemon):
            for seconds in (0, 0.001, 0.002, 0.004, 0.008):
                with contextlib.suppress(TimeoutError):
                    async with asyncio.timeout(seconds):
                        async with collided.aio.Session(meshes(), server=daemon.address):
                            await asyncio.sleep(60)
            async with asyncio.timeout(30):
                while await asyncio.to_thread(client.scenes):
                    await asyncio.sleep(0.05)

        daemon = Supervised()
        self.addCleanup(daemon.close)
        with collided.Client(daemon.address) as client:
            asyncio.run(asyncio.wait_for(play(daemon), 60))

    def test_a_session_is_closed_whatever_it_waits_for(self):
        async def play(daemon, transport):
            async with collided.aio.Session(meshes(), server=daemon.address, transport=transport, deadline=0.5) as session:
                await session.step({"tip": TIP})
                daemon.freeze()
                with self.assertRaises(TimeoutError):
                    async with asyncio.timeout(0.1):
                        await session.step({"tip": lowered(2)})

        for transport in STREAMS:
            daemon = Supervised()
            self.addCleanup(daemon.close)
            asyncio.run(asyncio.wait_for(play(daemon, transport), 60))


if __name__ == "__main__":
    main()
