#!/usr/bin/env python3
"""What collidectl view does when scenes end, daemons die and it is interrupted, and its demos."""

import pathlib
import signal

from viewer_support import ViewerCase, main

import collided
from support import Supervised
from web_client import Closed

FRAMES = ("v 0 0 0\nv 4 0 0\nv 0 4 0\nv 1 1 1\nv 1.5 1 3\nv 1 1.5 3\nf 1 2 3\nf 4 5 6\n",
          "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 1 1 -1\nv 1.5 1 1\nv 1 1.5 1\nf 1 2 3\nf 4 5 6\n")


class Ends(ViewerCase):
    def test_the_end_of_a_named_scene_is_shown(self):
        session = self.session()
        session.step()
        viewer = self.view_session(session)
        socket, _ = self.look_at(session, viewer=viewer)
        session.close()
        ended = socket.until("status", lambda status: status["state"] == "ended")
        self.assertIn("has ended", ended["message"])
        self.assertEqual(self.open(viewer).until("status")["state"], "ended")

    def test_without_a_name_the_next_scene_is_shown(self):
        daemon = Supervised()
        self.addCleanup(daemon.close)
        viewer = self.view("--server", daemon.address)
        socket = self.open(viewer)
        self.assertEqual(socket.until("status")["state"], "waiting")
        seen = []
        for _ in range(2):
            session = self.session(server=daemon.address)
            session.step()
            scene = socket.until("scene")
            self.assertEqual(scene["scene_id"], session.scene.id)
            session.step()
            self.assertEqual(socket.until("frame")["epoch"], scene["epoch"])
            seen.append(scene["epoch"])
            session.close()
            socket.until("status", lambda status: status["state"] == "waiting")
        self.assertLess(*seen)

    def test_a_daemon_that_dies_is_waited_for(self):
        daemon = Supervised()
        self.addCleanup(daemon.close)
        first = self.session(server=daemon.address)
        first.step()
        socket = self.open(self.view("--server", daemon.address))
        socket.until("scene")
        daemon.kill()
        self.assertTrue(socket.until("status", lambda status: status["state"] == "waiting")["message"])
        first.step()  # makes the scene anew
        socket.until("scene")
        self.assertEqual(socket.until("status")["state"], "live")
        first.step()
        socket.until("frame")

    def test_an_interrupt_ends_it_and_its_connections(self):
        session = self.session()
        session.step()
        viewer = self.view_session(session)
        socket, _ = self.look_at(session, viewer=viewer)
        self.assertEqual(viewer.interrupt(), 128 + signal.SIGINT)
        with self.assertRaises((Closed, ConnectionResetError)):
            while True:
                socket.receive()


class Demos(ViewerCase):
    def test_files_are_played_to_and_fro_with_a_daemon_of_its_own(self):
        files = []
        for number, text in enumerate(FRAMES):
            files.append(pathlib.Path(self.local.name) / f"fram\udcff{number}.obj")  # no UTF-8, as names of files may be
            files[-1].write_text(text)
        viewer = self.view("--play", *map(str, files), "--rate", "50", "--backend", "cpu", "--threads", "1")
        socket = self.open(viewer)
        scene = socket.until("scene")
        self.assertIn("fram?0", scene["name"])
        self.assertEqual(scene["triangles"], (0, 1, 2, 3, 4, 5))
        heights = set()
        while len(heights) < 2:
            frame = socket.until("frame", lambda frame: frame["frame"] > 1)
            self.assertEqual(frame["vertex_triangle"], (3, 0, 1, 2))
            self.assertEqual(frame["contact_count"], 1)
            heights.add(round(frame["positions"][11] + frame["origin"][2], 6))
        self.assertEqual(heights, {1, -1})
        self.assertEqual(viewer.interrupt(), 128 + signal.SIGINT)

    def test_a_demo_leaves_no_scene_behind(self):
        viewer = self.view("--scene", "reef_knot", "--scale", "0.2", "--server", self.server)
        frame = self.open(viewer).until("frame", lambda frame: frame["frame"] > 2)
        self.assertGreater(frame["total_ms"], 0)
        self.assertEqual(viewer.interrupt(), 128 + signal.SIGINT)
        with collided.Client(self.server) as client:
            self.assertEqual(client.scenes(), [])


if __name__ == "__main__":
    main()
