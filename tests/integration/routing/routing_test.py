#!/usr/bin/env python3
"""Several daemons behind HAProxy: where scenes go, and what happens to their streams when a daemon dies or stops.

Arguments: DAEMON COLLIDECTL REPOSITORY (those of the Python package's tests) ROUTED_SESSION.
"""

import pathlib
import subprocess
import sys
import threading
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "client" / "python"))
from support import DAEMON, TIP, lowered, main, meshes, np  # noqa: E402

from fleet import Fleet, wait_for  # noqa: E402
from load import WINDOW, Load  # noqa: E402

import collided  # noqa: E402

ROOMY = ("--max-scenes", "1000", "--max-scenes-per-client", "1000")
PATIENT = (*ROOMY, "--grace-seconds", "600")  # a stop ends when all have left, not by time


def megabytes(count):
    return ["--max-device-mb", str(count)]


class Case(unittest.TestCase):
    def fleet(self, *arguments, **options):
        fleet = Fleet(str(DAEMON), *arguments, **options)
        self.addCleanup(fleet.close)
        return fleet

    def place(self, fleet, count):
        """Scenes, one after the other."""
        scenes = [collided.Scene(meshes(), server=fleet.address) for _ in range(count)]
        for scene in scenes:
            self.addCleanup(scene.close)
        return scenes

    def load(self, fleet, count):
        """Sessions that stream, a while after they began."""
        loads = []
        for _ in range(count):
            loads.append(Load(fleet.address))
            self.addCleanup(loads[-1].finish)
        self.go_on(loads, 20)
        return loads

    def go_on(self, loads, count):
        """Until each has answered so many frames more."""
        wanted = [load.answered + count for load in loads]
        wait_for(lambda: all(load.failure or load.answered >= goal for load, goal in zip(loads, wanted)), "frames")
        for load in loads:
            if load.failure:
                raise load.failure

    def tell(self, what, loads):
        print(f"{what}: {sum(load.answered for load in loads)} frames answered, "
              f"{sum(load.session.recreations for load in loads)} scenes created again, "
              f"{sum(load.session.resent for load in loads)} frames sent again, "
              f"longest wait {max(load.longest_wait for load in loads):.2f} s", file=sys.stderr)


class Placing(Case):
    def test_scenes_spread_evenly_over_equal_daemons(self):
        fleet = self.fleet(*ROOMY)
        scenes = self.place(fleet, 9)
        self.assertEqual(fleet.scenes(), [3, 3, 3])
        for scene in scenes:
            name = scene.id.partition(".")[0]
            member = next(member for member in fleet.members if member.name == name)
            self.assertEqual(scene.message.endpoint, member.address)
            self.assertEqual(scene.refresh().scene_id, scene.id)  # by the proxy, to the daemon that has it

    def test_scenes_go_where_memory_is_free(self):
        fleet = self.fleet(*ROOMY, own={0: megabytes(1024), 1: megabytes(1024), 2: megabytes(256)})
        wait_for(lambda: fleet.weights() == [100, 100, 25], f"weights, which are {fleet.weights()}")
        self.place(fleet, 9)
        self.assertEqual(fleet.scenes(), [4, 4, 1])

    def test_frames_that_pass_the_proxy_reach_their_scenes(self):
        fleet = self.fleet(*ROOMY, advertise=False)
        sessions = [collided.Session(scene, transport="grpc") for scene in self.place(fleet, 6)]
        for session in sessions:
            self.addCleanup(session.close)
            for _ in range(5):
                np.testing.assert_allclose(session.step({"tip": lowered(2)}, start={"tip": TIP}).toi, [0.5], atol=1e-3)
        # One more of each puts the meshes where they begin.
        self.assertEqual([member.metric("collided_frames_total") for member in fleet.members], [12, 12, 12])
        fleet.members[0].kill()
        for session in sessions:
            np.testing.assert_allclose(session.step({"tip": lowered(2)}, start={"tip": TIP}).toi, [0.5], atol=1e-3)
        self.assertEqual([session.recreations for session in sessions].count(1), 2)


class Losing(Case):
    def test_a_daemon_that_is_killed_loses_at_most_a_window_of_each_stream(self):
        fleet = self.fleet(*ROOMY)
        loads = self.load(fleet, 6)
        lost = [load for load in loads if load.daemon == "collided-0"]
        self.assertEqual(len(lost), 2)
        fleet.members[0].kill()
        self.go_on(loads, 50)
        self.tell("killed", loads)
        for load in loads:
            was_lost = load in lost
            self.assertEqual((load.session.reconnects, load.session.recreations), (was_lost, was_lost))
            self.assertLessEqual(load.session.resent, WINDOW if was_lost else 0)
            self.assertNotEqual(load.daemon, "collided-0")

    def test_a_daemon_that_drains_loses_nothing(self):
        fleet = self.fleet(*PATIENT)
        loads = self.load(fleet, 6)
        leaving = [load for load in loads if load.daemon == "collided-1"]
        self.assertEqual(len(leaving), 2)
        self.assertEqual(fleet.members[1].drain(), 0)
        self.go_on(loads, 20)
        self.tell("drained", loads)
        for load in loads:
            self.assertEqual((load.session.reconnects, load.session.resent), (0, 0))
            self.assertEqual(load.session.recreations, load in leaving)

    def test_all_daemons_restart_one_after_the_other(self):
        fleet = self.fleet(*PATIENT)
        loads = self.load(fleet, 6)
        for member in fleet.members:
            self.assertEqual(member.drain(), 0)
            member.start()
            wait_for(lambda: fleet.states("place")[member.name] == "UP", f"{member.name} in HAProxy")
            self.go_on(loads, 10)
        self.tell("all restarted", loads)
        for load in loads:
            self.assertEqual((load.session.reconnects, load.session.resent), (0, 0))
            self.assertGreaterEqual(load.session.recreations, 1)


class CppSession:
    """A session of the C++ client under load, in a process of its own."""

    def __init__(self, address):
        self._process = subprocess.Popen([sys.argv[4], address], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.lines = []
        self._reader = threading.Thread(target=lambda: self.lines.extend(iter(self._process.stdout.readline, "")))
        self._reader.start()

    @property
    def daemon(self):
        return self.lines[-1].partition(".")[0]

    def go_on(self, lines):
        """Until it has answered ten times as many frames more."""
        goal = len(self.lines) + lines
        wait_for(lambda: len(self.lines) >= goal or self._process.poll() is not None, "frames")

    def finish(self):
        """The exit code, and how it went."""
        self._process.stdin.close()
        self._reader.join()
        code = self._process.wait()
        self._process.stdout.close()
        return code, self.lines[-1] if self.lines else ""


class FromCpp(Case):
    def test_sessions_go_on_after_a_kill_and_leave_a_daemon_that_drains(self):
        fleet = self.fleet(*PATIENT)
        sessions = [CppSession(fleet.address) for _ in range(3)]
        try:
            for session in sessions:
                session.go_on(2)
            killed, drained, _ = first = [session.daemon for session in sessions]
            self.assertEqual(len(set(first)), 3)
            members = {member.name: member for member in fleet.members}
            members[killed].kill()
            for session in sessions:
                session.go_on(3)
            members[killed].start()
            leaving = [session.daemon == drained for session in sessions]
            self.assertEqual(members[drained].drain(), 0)
            for session in sessions:
                session.go_on(2)
        finally:
            ends = [session.finish() for session in sessions]
        for was_killed, left, (code, said) in zip((True, False, False), leaving, ends):
            self.assertEqual(code, 0, said)
            print(f"from C++: {said.strip()}", file=sys.stderr)
            self.assertRegex(said, f"reconnects {int(was_killed)} recreations {was_killed + left}$")


class ByConnection(Case):
    def test_a_host_is_served_by_one_daemon_and_goes_to_another_one(self):
        fleet = self.fleet(*ROOMY, "--grace-seconds", "0.5", advertise=False, by_connection=True)
        loads = self.load(fleet, 3)
        first = {load.daemon for load in loads}
        self.assertEqual(len(first), 1)
        next(member for member in fleet.members if {member.name} == first).kill()
        self.go_on(loads, 20)
        second = {load.daemon for load in loads}
        self.assertEqual(len(second), 1)
        self.assertNotEqual(first, second)
        self.assertEqual(next(member for member in fleet.members if {member.name} == second).drain(), 0)
        self.go_on(loads, 20)
        self.tell("by connection", loads)
        for load in loads:
            self.assertEqual(load.session.recreations, 2)
            self.assertLessEqual(load.session.resent, 2 * WINDOW)


if __name__ == "__main__":
    main()
