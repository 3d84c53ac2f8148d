#!/usr/bin/env python3
"""The package in an event loop."""

import asyncio
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
