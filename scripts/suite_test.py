#!/usr/bin/python3
"""Tests of suite.py: the figures from made-up runs, and what config/suite.yaml has to be."""

import math
import unittest
from types import SimpleNamespace

import debian_python  # noqa: F401 (first: it may start another Python)

import suite


def run(ate_m, position_nees=1.0):
    evaluation = {} if ate_m is None else {"consistency": {"position": {"nees": position_nees},
                                                            "orientation": {"nees": 2.0}}}
    return SimpleNamespace(ate=lambda: ate_m, evaluation=evaluation)


class SuiteFile(unittest.TestCase):
    def test_has_six_scenes_of_a_minute_with_seeds_of_their_own(self):
        settings, scenes = suite.read_suite(suite.ROOT / "config" / "suite.yaml")
        self.assertEqual({s.scene for s in scenes}, {"room", "office", "corridor", "clutter", "hall", "facade"})
        self.assertTrue(all(s.duration >= 60 for s in scenes))
        self.assertGreaterEqual(settings["draws"], 3)
        seeds = [s.draw_seed(draw) for s in scenes for draw in range(1, 100)]
        self.assertEqual(len(seeds), len(set(seeds)))

    def test_has_slow_fast_and_recorded_flights(self):
        _, scenes = suite.read_suite(suite.ROOT / "config" / "suite.yaml")
        flights = {s.flight for s in scenes}
        self.assertTrue({"gentle", "fast"} <= flights)
        self.assertGreaterEqual(sum(f[0].isupper() for f in flights), 2)


class Figures(unittest.TestCase):
    def setUp(self):
        self.groups = {("a", "exact", "S"): [run(0.002)], ("a", "exact", "SPR"): [run(0.001)],
                       ("a", "drawn", "S"): [run(0.004), run(0.006), run(0.008)],
                       ("a", "drawn", "SPR"): [run(0.004, 2), run(0.003, 3), run(None)]}

    def test_errors_are_medians_and_nees_means_over_runs(self):
        row = suite.figures_of(self.groups, "a", ["drawn"], ["S", "SPR"])
        self.assertAlmostEqual(row["S drawn mm"], 6)
        self.assertAlmostEqual(row["S drawn/exact"], 3)
        self.assertAlmostEqual(row["S drawn/exact, worst run"], 4)
        self.assertAlmostEqual(row["SPR drawn mm"], 4)  # the run without a result counts as infinite
        self.assertAlmostEqual(row["SPR position NEES drawn"], 2.5)
        self.assertAlmostEqual(row["SPR/S exact"], 0.5)
        self.assertAlmostEqual(row["SPR/S exact, worst run"], 0.5)
        self.assertAlmostEqual(row["SPR/S drawn"], 1)

    def test_what_is_left_of_the_calibrations_errors_is_a_mean_of_sizes(self):
        for r, offset in zip(self.groups["a", "drawn", "SPR"], (0.1, -0.3, None)):
            if offset is not None:
                r.evaluation["calibration"] = {"time_offset_ms": offset}
        row = suite.figures_of(self.groups, "a", ["drawn"], ["SPR"])
        self.assertAlmostEqual(row["SPR drawn: time offset error [ms]"], 0.2)
        self.assertAlmostEqual(row["SPR drawn: time offset error, worst run [ms]"], 0.3)
        self.assertTrue(math.isnan(row["SPR drawn: error of scale [%]"]))
        self.assertTrue(math.isnan(row["SPR drawn: calibration NEES"]))

    def test_a_run_that_failed_spoils_the_figure_of_its_scene(self):
        self.groups["a", "drawn", "S"] = [run(None) for _ in self.groups["a", "drawn", "SPR"]]
        row = suite.figures_of(self.groups, "a", ["drawn"], ["S", "SPR"])
        self.assertTrue(math.isinf(row["S drawn mm"]))
        self.assertTrue(math.isinf(row["SPR/S drawn, worst run"]))

    def test_the_worst_nees_is_the_one_farthest_from_one(self):
        table = {scene: {"S position NEES drawn": v, "S drawn mm": v} for scene, v in zip("abc", (0.1, 1, 4))}
        self.assertEqual(suite.overall(table, "S position NEES drawn"), (1, 0.1))
        self.assertEqual(suite.overall(table, "S drawn mm"), (1, 4))

    def test_ratios_compare_scene_by_scene(self):
        ratio = suite.ratio_table({"a": {"S drawn mm": 3.0, "SPR/S drawn": 1}}, {"a": {"S drawn mm": 2.0}})
        self.assertEqual(ratio, {"a": {"S drawn ATE ratio": 1.5}})


if __name__ == "__main__":
    unittest.main()
