#!/usr/bin/env python3
"""Tests of start_flights.py and of the errors that random_starts.py measures."""

import math
import sys
import tempfile
import unittest
from pathlib import Path

import debian_python  # noqa: F401 (first: it may start another Python)

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
import naive_ate  # noqa: E402
import random_starts  # noqa: E402
import start_flights  # noqa: E402


class ClosedFlights(unittest.TestCase):
    def test_a_lap_ends_where_it_begins_with_the_same_velocity(self):
        for flight in filter(start_flights.Flight.is_closed, start_flights.FLIGHTS):
            step = 1e-3
            for lap_end in (start_flights.LAP_S, 2 * start_flights.LAP_S):
                before, at = flight.poses(lap_end - step), flight.poses(lap_end)
                first, second = flight.poses(0), flight.poses(step)
                self.assertLess(np.linalg.norm(np.subtract(at[0], first[0])), 1e-6, flight.name)
                change = np.subtract(at[0], before[0]) - np.subtract(second[0], first[0])
                self.assertLess(np.linalg.norm(change) / step, 0.02, flight.name)
                turned = start_flights.attitude(*at[1:]) @ start_flights.attitude(*first[1:])
                self.assertAlmostEqual(abs(turned), 1, 6, flight.name)

    def test_the_body_looks_along_its_heading_with_x_up(self):
        R = naive_ate.rotation(start_flights.attitude(0.7, 0, 0))
        np.testing.assert_allclose(R[:, 0], [0, 0, 1], atol=1e-9)
        np.testing.assert_allclose(R[:, 2], [math.cos(0.7), math.sin(0.7), 0], atol=1e-9)

    def test_written_poses_are_read_as_a_trajectory_with_margins(self):
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "poses.csv"
            start_flights.write_poses(start_flights.gentle_round, file)
            stamps, p, _ = naive_ate.read_trajectory(file)
        self.assertAlmostEqual(1e-9 * (stamps[-1] - stamps[0]), start_flights.LAP_S + 2 * start_flights.MARGIN_S)
        self.assertTrue(np.isfinite(p).all())

    def test_takes_that_are_there_are_not_simulated_again(self):
        flight = start_flights.FLIGHTS[0]
        with tempfile.TemporaryDirectory() as cache:
            for i in (1, 2):
                folder = Path(cache) / f"{flight.name}-{i}"
                folder.mkdir()
                (folder / "simulation.txt").touch()
            takes = start_flights.make_takes(flight, cache, "no program", 2)
            self.assertEqual([take.name for take in takes], [f"{flight.name}-1", f"{flight.name}-2"])
            self.assertTrue(all((take / "simulation.txt").exists() for take in takes))
            with self.assertRaises(OSError):
                start_flights.make_takes(flight, cache, "no program", 3)

    def test_the_flight_from_rest_is_at_rest(self):
        self.assertEqual(start_flights.rest_then_round(0), start_flights.rest_then_round(8.9))


class Errors(unittest.TestCase):
    def measure(self, turn, tilt, shift):
        """A straight motion whose estimate is turned about z, tilted about x, and off by `shift` at its end."""
        c, s = math.cos(turn / 2), math.sin(turn / 2)
        a, b = math.cos(tilt / 2), math.sin(tilt / 2)
        q = np.array([c * a, c * b, s * b, s * a])  # wxyz of turn * tilt
        R = naive_ate.rotation(np.array([c, 0, 0, s]))
        truth = (list(range(0, 6_000_000_000, 50_000_000)), None, None)
        p = np.array([[1e-9 * t, 0, 0] for t in truth[0]])
        truth = (truth[0], p, np.tile([1.0, 0, 0, 0], (len(p), 1)))
        start = random_starts.Start(Path("x"), 0, "moving", init_s=0.3)
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "trajectory.tum"
            with open(file, "w", encoding="utf-8") as stream:
                for i, t in enumerate(truth[0]):
                    at = R @ p[i] + [3, 4, 5] + (np.array(shift) if i == len(p) - 1 else 0)
                    stream.write(f"{1e-9 * t:.9f} {at[0]} {at[1]} {at[2]} {q[1]} {q[2]} {q[3]} {q[0]}\n")
            random_starts.measure_errors(file, truth, start)
        return start

    def test_heading_and_place_of_the_first_pose_do_not_count(self):
        start = self.measure(1.2, 0, (0, 0, 0))
        self.assertAlmostEqual(start.off_m, 0, 6)
        self.assertAlmostEqual(start.off_deg, 0, 3)

    def test_its_tilt_counts(self):
        start = self.measure(-0.4, math.radians(3), (0, 0, 0))
        self.assertAlmostEqual(start.tilt_deg, 3, 3)
        self.assertAlmostEqual(start.off_deg, 3, 3)

    def test_what_is_off_by_more_than_half_a_metre_is_wrong(self):
        self.assertFalse(self.measure(0, 0, (0.3, 0, 0.3)).is_wrong())
        self.assertTrue(self.measure(0, 0, (0.4, 0, 0.4)).is_wrong())
        self.assertTrue(self.measure(0, math.radians(11), (0, 0, 0)).is_wrong())

    def test_a_start_without_a_pose_is_late(self):
        start = random_starts.Start(Path("x"), 0, "rest")
        self.assertTrue(start.is_late())
        start.init_s = 0.5
        self.assertFalse(start.is_late())


if __name__ == "__main__":
    unittest.main()
