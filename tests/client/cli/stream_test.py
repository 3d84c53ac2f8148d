"""collidectl stream: what the scenes that it plays can declare.

Usage: stream_test.py COLLIDECTL DAEMON"""

import json

import support
from support import ONE_CPU

BALL = ["--scene", "cloth_ball", "--scale", "0.1", "--frames", "4", "--t0", "0.4", *ONE_CPU]


class Stream(support.CollidectlTest):
    def played(self, *words):
        return json.loads(self.ok("stream", *words, "--json"))

    def test_a_rigid_mesh_sends_poses(self):
        plain, rigid = self.played(*BALL), self.played(*BALL, "--rigid", "ball")
        ball = (plain["bytes_in"] - rigid["bytes_in"] + 3 * 96) / 3  # a frame
        self.assertTrue(0 < ball < plain["bytes_in"] / 4, (plain["bytes_in"], rigid["bytes_in"]))
        self.assertEqual(ball % 12, 0)
        self.assertGreaterEqual(rigid["contact_count"], plain["contact_count"] * 0.9)

    def test_a_mesh_that_bends_is_not_rigid(self):
        self.refused(1, "mesh cloth does not move as a rigid body", "stream", *BALL, "--rigid", "cloth")
        self.refused(2, "--rigid: the scene has no mesh 'bell'; there are cloth, ball", "stream", *BALL, "--rigid", "bell")

    def test_excluded_meshes_do_not_touch(self):
        every = self.played(*BALL, "--thickness", "0.05")
        pair = ["--exclude-meshes", "ball", "cloth"]
        apart = self.played(*BALL, "--thickness", "0.05", *pair)
        self.assertTrue(0 < apart["contact_count"] < every["contact_count"], (apart, every))
        nothing = self.played(*BALL, "--thickness", "0.05", *pair, "--exclude-meshes", "cloth", "cloth",
                              "--exclude-meshes", "ball", "ball")
        self.assertIs(nothing["any_contact"], False)
        self.refused(2, "--exclude-meshes: the scene has no mesh 'x'", "stream", *BALL, "--exclude-meshes", "x", "ball")
        self.refused(2, "--exclude-meshes", "stream", *BALL, "--exclude-meshes", "ball")
        estimate = ["estimate", "--scene", "cloth_ball", "--scale", "0.1", *ONE_CPU, "--json"]
        self.assertGreater(json.loads(self.ok(*estimate, *pair))["memory_bytes"], 0)
        self.refused(2, "has no mesh 'x'", *estimate, "--exclude-meshes", "x", "x")

    def test_a_thicker_mesh_touches_more(self):
        dcd = [*BALL, "--mode", "dcd", "--thickness", "0.01"]
        counts = [self.played(*dcd, *more)["contact_count"]
                  for more in ([], ["--half-thickness", "ball=0.02"], ["--half-thickness", "ball=0.02", "--half-thickness", "cloth=0.005"])]
        self.assertEqual(counts, sorted(set(counts)))
        self.assertEqual(counts[2], self.played(*BALL, "--mode", "dcd", "--thickness", "0.01", "--half-thickness", "cloth=0.005",
                                                "--half-thickness", "ball=0.02")["contact_count"])
        self.refused(2, "--half-thickness: the scene has no mesh 'bell'; there are cloth, ball", "stream", *dcd, "--half-thickness", "bell=1")
        estimate = ["estimate", "--scene", "cloth_ball", "--scale", "0.1", *ONE_CPU, "--json", "--half-thickness", "ball=0.02"]
        self.assertEqual(json.loads(self.ok(*estimate))["scene"]["half_thickness"], {"ball": 0.02})

    def test_encoded_positions(self):
        plain, encoded = self.played(*BALL), self.played(*BALL, "--position-format", "q16")
        self.assertEqual(encoded["scene"]["position_format"], "q16")
        self.assertEqual(2 * encoded["bytes_in"], plain["bytes_in"])
        self.assertGreaterEqual(encoded["contact_count"], plain["contact_count"])

    def test_an_advance_stops_before_contact(self):
        short = self.played(*BALL, "--advance", "--min-separation", "1e-3")
        self.assertEqual(short["scene"]["min_separation"], 1e-3)
        self.assertTrue(0 <= short["least_advanced"] <= 1, short)
        self.assertNotIn("least_advanced", self.played(*BALL))


if __name__ == "__main__":
    support.main()
