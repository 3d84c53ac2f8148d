"""collidectl estimate: what a scene would cost, and that nothing is made.

Usage: estimate_test.py COLLIDECTL DAEMON"""

import json

import support
from support import ONE_CPU


class Estimate(support.CollidectlTest):
    def told(self, *words):
        return json.loads(self.ok("estimate", *words, "--json", *ONE_CPU))

    def test_a_mesh_file(self):
        told = self.told(self.frame0)
        scene = told["scene"]
        self.assertEqual((scene["vertices"], scene["triangles"], scene["device"]), (6, 2, "CPU, 1 threads"))
        self.assertNotIn("edges", scene)
        self.assertEqual((told["first_frame_bytes"], told["frame_bytes"]), (6 * 12, 6 * 12))
        self.assertEqual(told["memory_bytes"], sum(told["part_bytes"].values()))
        self.assertLess(told["memory_bytes"], 256 << 10)
        self.assertEqual(told["contact_bytes"]["triangle_triangle"], 0)
        self.assertEqual(told["stages"][0], "upload")

    def test_options_count(self):
        certified = self.told(self.frame0)
        doubles = self.told(self.frame0, "--position-format", "f64")
        self.assertEqual(doubles["frame_bytes"], 2 * certified["frame_bytes"])
        candidates = self.told(self.frame0, "--accuracy", "candidates")
        self.assertLess(candidates["memory_bytes"], certified["memory_bytes"])
        self.assertLess(len(candidates["stages"]), len(certified["stages"]))
        pairs = self.told(self.frame0, "--mode", "dcd", "--kinds", "tt")
        self.assertEqual(pairs["contact_bytes"]["vertex_triangle"], 0)
        self.assertGreater(pairs["contact_bytes"]["triangle_triangle"], 0)
        self.assertIn("last_good", pairs["part_bytes"])

    def test_a_scene_is_told_as_it_is_then_made(self):
        scene = ["--scene", "funnel", "--scale", "0.1"]
        told = self.told(*scene)
        made = json.loads(self.ok("stream", *scene, "--frames", "1", "--json", *ONE_CPU))["scene"]
        del made["edges"]
        self.assertEqual(told["scene"], made)
        self.assertGreater(self.told("--scene", "funnel", "--scale", "0.2")["memory_bytes"], told["memory_bytes"])

    def test_the_report_for_people_names_what_there_is(self):
        text = self.ok("estimate", self.frame0, *ONE_CPU)
        for name in ("memory_bytes", "first_frame_bytes", "contact_bytes", "stages", "records"):
            self.assertIn(name, text)

    def test_what_cannot_be_made_is_refused(self):
        with self.daemon("--max-vertices", "5") as address:
            self.refused(1, "max_vertices", "estimate", self.frame0, "--server", address)
            self.refused(1, "is not known", "estimate", "--scene", "nothing", "--server", address)
        self.refused(1, "none.obj", "estimate", "none.obj", *ONE_CPU)


if __name__ == "__main__":
    support.main()
