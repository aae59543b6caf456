"""Pad paths, interpolation and exports of the proof's sessions."""
import math
import unittest

from proof import scoring, session


class Interpolation(unittest.TestCase):
    def setUp(self):
        self.trial = session.Trial("a1-12", {0: 12.0}, ramp=1.1, hold=1.7, rest=0.5)
        self.keys = self.trial.keys(2.5)

    def test_a_cubic_of_time_is_met_within_every_phase(self):
        cubic = lambda t: 1.0 - 2.0 * t + 0.7 * t * t - 0.3 * t ** 3
        for frame in range(200):
            t = self.trial.duration * frame / 199
            found = sum(w * cubic(self.keys[k]) for k, w in session.in_time(self.trial, self.keys, t))
            self.assertAlmostEqual(found, cubic(t), places=9)

    def test_no_phase_borrows_from_another(self):
        for t in (0.3, 1.3, 3.0, 4.3):
            begin, end = next(p for p in self.trial.phases() if t <= p[1])
            for k, _ in session.in_time(self.trial, self.keys, t):
                self.assertTrue(begin - 1e-9 <= self.keys[k] <= end + 1e-9)

    def test_keys_ascend_and_hold_every_kink(self):
        self.assertEqual(self.keys, sorted(set(self.keys)))
        for _, end in self.trial.phases():
            self.assertTrue(any(abs(key - end) < 1e-9 for key in self.keys))

    def test_pads_go_in_stay_and_come_back(self):
        self.assertEqual(self.trial.share(0.0), 0.0)
        self.assertEqual(self.trial.share(1.1), 1.0)
        self.assertEqual(self.trial.share(2.8), 1.0)
        self.assertAlmostEqual(self.trial.share(3.35), 0.5)
        self.assertEqual(self.trial.share(4.4), 0.0)


class Export(unittest.TestCase):
    def test_what_is_written_is_read_back_with_its_gaps(self):
        places = {"M01": [(1.0, 2.0, 3.0), None], "A1": [(0.5, 0.0, -1.25), (4.0, 5.0, 6.0)]}
        words = session.nexus_csv(50.0, "phantom", 2, {"A1": [(0.1, 0.2, 0.3), (0.4, 0.5, 0.6)]}, places)
        import tempfile
        with tempfile.NamedTemporaryFile("w", suffix=".csv") as out:
            out.write(words)
            out.flush()
            read = scoring.trajectories(out.name)
        self.assertEqual(read, {"M01": [[1.0, 2.0, 3.0], None], "A1": [[0.5, 0.0, -1.25], [4.0, 5.0, 6.0]]})
        self.assertTrue(words.startswith("Devices\n50\n,,A1 - Force,,\n"))


class Rotation(unittest.TestCase):
    def test_a_quarter_turn_about_z(self):
        rows = session.rotation_matrix([0.0, 0.0, 90.0])
        turned = [sum(r * v for r, v in zip(row, (1.0, 0.0, 0.0))) for row in rows]
        for found, wanted in zip(turned, (0.0, 1.0, 0.0)):
            self.assertAlmostEqual(found, wanted)

    def test_it_keeps_lengths_and_its_axis(self):
        axis = [2.0, -3.0, 1.0]
        rows = session.rotation_matrix(axis)
        for k, row in enumerate(rows):
            self.assertAlmostEqual(sum(r * r for r in row), 1.0)
            self.assertAlmostEqual(sum(r * v for r, v in zip(row, axis)), axis[k])
        self.assertAlmostEqual(rows[0][0] + rows[1][1] + rows[2][2], 1.0 + 2.0 * math.cos(math.radians(math.sqrt(14.0))))


if __name__ == "__main__":
    unittest.main()
