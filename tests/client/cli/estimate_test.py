"""collidectl estimate: what a scene would cost, that nothing is made, and how many devices a workload needs.

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
            self.refused(2, "is not known", "estimate", "--scene", "nothing", "--server", address)
        self.refused(1, "none.obj", "estimate", "none.obj", *ONE_CPU)


class Workloads(support.CollidectlTest):
    SIZE = ["--triangles", "1000", "--vertices", "600"]

    def told(self, *words):
        return json.loads(self.ok("estimate", *words, "--json", *ONE_CPU))

    def test_a_size_is_enough(self):
        told = self.told("--triangles", "1000")
        self.assertEqual((told["scene"]["triangles"], told["scene"]["vertices"]), (1000, 502))
        self.assertAlmostEqual(told["bytes_per_triangle"], told["memory_bytes"] / 1000)
        self.assertEqual(self.told(*self.SIZE)["frame_bytes"], 600 * 12)
        self.assertEqual(self.told(*self.SIZE, "--position-format", "q16")["frame_bytes"], 600 * 6)

    def test_memory_time_and_network_each_need_devices(self):
        told = self.told(*self.SIZE, "--scenes", "100", "--rate", "50", "--step-ms", "2", "--gpu-memory", "1",
                         "--network", "0.1", "--contacts", "10")
        self.assertEqual(told["usable_bytes"], 900_000_000)
        self.assertEqual(told["network"]["bytes_out"], 10 * told["contact_bytes"]["vertex_triangle"])
        self.assertAlmostEqual(told["network"]["gigabits_in_per_second"], 100 * 50 * 600 * 12 * 8e-9)
        fit = told["scenes_per_device"]
        self.assertEqual(fit["memory"], 900_000_000 // told["memory_bytes"])
        self.assertEqual(fit["time"], 7)  # 0.7 s of 0.1 s each
        self.assertEqual(fit["network"], int(0.7 * 0.1 / (50 * 600 * 12 * 8e-9)))
        self.assertEqual(told["devices_needed"], {name: -(-100 // scenes) for name, scenes in fit.items()})
        self.assertEqual((told["device_count"], told["bound_by"]), (15, "time"))
        self.assertEqual(self.told(*self.SIZE, "--rate", "50", "--step-ms", "2", "--utilisation", "1")["scenes_per_device"]["time"], 10)

    def test_what_is_not_known_is_left_out_and_told(self):
        told = self.told(*self.SIZE, "--scenes", "100")
        self.assertEqual(list(told["devices_needed"]), ["memory"])
        self.assertNotIn("bytes_out", told["network"])
        notes = " ".join(told["assumptions"])
        for note in ("time is left out", "network is left out", "contacts are left out"):
            self.assertIn(note, notes)
        self.assertIn("or more, bound by memory", self.ok("estimate", *self.SIZE, *ONE_CPU))
        local = self.told(*self.SIZE, "--rate", "9", "--transport", "shared-memory")
        self.assertIn("frames over shared-memory take no network", local["assumptions"])

    def test_a_scene_that_is_too_much_for_a_device_is_told(self):
        told = self.told(*self.SIZE, "--rate", "1000", "--step-ms", "2")
        self.assertIsNone(told["device_count"])
        self.assertIn("one scene alone needs more time", self.ok("estimate", *self.SIZE, "--rate", "1000", "--step-ms", "2", *ONE_CPU))

    def test_frames_are_measured_on_the_daemon(self):
        with self.daemon() as server:
            words = ["estimate", self.frame0, self.frame1, "--measure", "--steps", "3", "--rate", "1", "--json", "--server", server]
            told = json.loads(self.ok(*words))
            self.assertEqual(json.loads(self.ok("info", "--server", server, "--json"))["limits"]["max_scenes"], 64)
        measured = told["measured"]
        self.assertEqual((measured["steps"], measured["contacts_per_frame"]), (3, 1))
        self.assertGreaterEqual(measured["device_bytes"], told["memory_bytes"])
        self.assertEqual(told["workload"]["step_ms"], measured["engine_ms"])
        self.assertEqual(told["network"]["bytes_out"], told["contact_bytes"]["vertex_triangle"])
        self.assertIn("time", told["devices_needed"])

    def test_limits_that_are_too_low_are_told(self):
        with self.daemon("--max-scenes", "5") as server:
            told = json.loads(self.ok("estimate", *self.SIZE, "--scenes", "9", "--json", "--server", server))
        self.assertIn("the daemon's max-scenes allows 5; a device's scenes need 9", told["warnings"])

    def test_bad_values_are_refused(self):
        size = ["estimate", *self.SIZE]
        self.refused(2, "--scenes", *size, "--scenes", "0")
        for option in ("--rate", "--step-ms", "--gpu-memory", "--network", "--utilisation"):
            for value in ("nan", "inf", "0", "-1", "1e300", "x"):
                self.refused(2, option, *size, f"{option}={value}")
        self.refused(2, "--utilisation", *size, "--utilisation", "1.1")
        self.refused(2, "--triangles", "estimate", "--triangles", "4294967296")
        self.refused(1, "max_triangles", "estimate", "--triangles", "4294967295", "--vertices", "3", *ONE_CPU)
        self.refused(2, "--network is of --transport grpc alone", *size, "--network", "1", "--transport", "device-memory")
        self.refused(2, "--measure needs positions", *size, "--measure")
        self.refused(2, "--step-ms excludes --measure", *size, "--measure", "--step-ms", "1")
        self.refused(2, "two frames, FRAME0 FRAME1; 1 was given", "estimate", self.frame0, "--measure")
        self.refused(2, "one frame, FRAME; 2 were given", "estimate", self.frame0, self.frame1, "--measure", "--mode", "dcd")


if __name__ == "__main__":
    support.main()
