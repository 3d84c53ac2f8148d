#!/usr/bin/env python3
"""Tests what the soak calls growth."""

import random
import unittest

from judge import slope, verdict


def tides(rss, **others):
    same = {"heap": 2e6, "fds": 20, "threads": 12, "device_bytes": 0}
    return [{"rss": value, **same, **{name: values[i] for name, values in others.items()}} for i, value in enumerate(rss)]


class Judge(unittest.TestCase):
    def setUp(self):
        self.rng = random.Random(1)

    def noisy(self, count, growth):
        return [50e6 + growth * i + self.rng.gauss(0, 2e5) for i in range(count)]

    def test_slope_of_a_line(self):
        grows, error = slope([3.0, 5.0, 7.0, 9.0])
        self.assertAlmostEqual(grows, 2.0)
        self.assertAlmostEqual(error, 0.0)

    def test_noise_is_no_growth(self):
        for _ in range(100):
            self.assertEqual(verdict(tides(self.noisy(60, 0)))[1], [])

    def test_growth_in_noise_is_found(self):
        self.assertIn("rss grows", verdict(tides(self.noisy(60, 300e3)))[1][0])
        self.assertIn("rss grows", verdict(tides(self.noisy(600, 80e3)))[1][0])
        self.assertIn("heap grows", verdict(tides(self.noisy(60, 0), heap=self.noisy(60, 50e3)))[1][0])

    def test_what_is_freed_and_not_returned_is_no_growth(self):
        for _ in range(100):
            steps = [41e6 + self.rng.choice((0, 8e6)) for _ in range(24)]
            self.assertEqual(verdict(tides(steps))[1], [])
        self.assertEqual(verdict(tides([41e6] * 16 + [49e6] * 8))[1], [])

    def test_growth_while_it_warms_up_is_none(self):
        self.assertEqual(verdict(tides([1e6 * min(i, 19) for i in range(60)]))[1], [])

    def test_a_descriptor_in_two_tides_is_found(self):
        found = verdict(tides([50e6] * 9, fds=[20 + i // 2 for i in range(9)]))[1]
        self.assertEqual(len(found), 1)
        self.assertTrue(found[0].startswith("fds"))

    def test_a_descriptor_in_ten_tides_is_found(self):
        found = verdict(tides([50e6] * 300, fds=[20 + i // 10 + i % 2 for i in range(300)]))[1]
        self.assertEqual(len(found), 1)
        self.assertTrue(found[0].startswith("fds"))

    def test_a_pool_that_changes_is_no_growth(self):
        for threads in ([12] * 8 + [14], [12] * 5 + [14] * 4, [12] * 6 + [13] * 3, [14, 12, 13] * 3):
            self.assertEqual(verdict(tides([50e6] * 9, threads=threads, fds=[20, 21] * 4 + [20]))[1], [])

    def test_a_pool_that_is_suddenly_far_larger_is_found(self):
        for many in ([12] * 6 + [40] * 3, [12] * 8 + [40], [12] * 8 + [16]):
            found = verdict(tides([50e6] * 9, threads=many))[1]
            self.assertIn("threads go much higher", found[-1])

    def test_one_byte_of_a_scene_is_found(self):
        found = verdict(tides([50e6] * 9, device_bytes=[0] * 8 + [1]))[1]
        self.assertEqual(len(found), 1)
        self.assertTrue(found[0].startswith("device_bytes"))

    def test_too_few_tides_tell_nothing(self):
        self.assertIn("too few", verdict(tides([50e6] * 8))[1][0])


if __name__ == "__main__":
    unittest.main()
