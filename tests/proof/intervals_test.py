"""Intervals against values from the literature and against counting."""
import math
import unittest

from proof import intervals


class Wilson(unittest.TestCase):
    # Newcombe (1998), Statistics in Medicine 17, table I, method 3.
    def test_newcombe_s_examples(self):
        for hits, count, low, high in ((81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605), (0, 20, 0.0, 0.1611), (1, 29, 0.0061, 0.1718)):
            found = intervals.wilson(hits, count)
            self.assertAlmostEqual(found[0], low, places=4)
            self.assertAlmostEqual(found[1], high, places=4)

    def test_nothing_counted_says_nothing(self):
        self.assertEqual(intervals.wilson(0, 0), (0.0, 1.0))


class Others(unittest.TestCase):
    def test_median_and_quantiles(self):
        self.assertEqual(intervals.median([3.0, 1.0, 2.0]), 2.0)
        self.assertEqual(intervals.median([4.0, 1.0, 2.0, 3.0]), 2.5)
        self.assertEqual(intervals.quantile([0.0, 10.0], 0.25), 2.5)
        self.assertTrue(math.isnan(intervals.median([])))

    def test_the_bootstrap_of_a_mean_is_as_wide_as_its_standard_error(self):
        groups = [[float(k % 7)] for k in range(140)]
        low, high = intervals.bootstrap(groups, intervals.mean)
        standard_error = 2.0 / math.sqrt(140)  # 0 to 6 evenly: variance 4
        self.assertAlmostEqual((high - low) / (2 * 1.96 * standard_error), 1.0, delta=0.12)
        self.assertTrue(low < 3.0 < high)

    def test_cases_are_drawn_whole(self):
        # Hundred values in two groups: an interval as of two, not as of hundred.
        low, high = intervals.bootstrap([[0.0] * 50, [1.0] * 50], intervals.mean)
        self.assertEqual((low, high), (0.0, 1.0))

    def test_reliability_counts_every_statement_once(self):
        said = [(0.95, True), (0.93, False), (0.1, False), (1.0, True)]
        bins = intervals.reliability(said)
        self.assertEqual(sum(count for _, _, count in bins), 4)
        self.assertIn((0.94, 1, 2), [(round(p, 9), hits, count) for p, hits, count in bins])


if __name__ == "__main__":
    unittest.main()
