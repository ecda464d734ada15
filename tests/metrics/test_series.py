"""Means, quantiles and transients of correlated series, against processes whose errors are
known.
"""

import itertools
import math

import numpy as np
import pytest

from clearance.metrics import statistics

SEEDS = 400


def correlated(rho: float, count: int, runs: int = SEEDS, seed: int = 1) -> np.ndarray:
    """First-order autoregressive processes of variance 1, stationary from the start, (runs,
    count).
    """
    rng = np.random.default_rng(seed)
    noise = rng.normal(size=(runs, count)) * math.sqrt(1.0 - rho**2)
    x = np.empty((runs, count))
    x[:, 0] = rng.normal(size=runs)
    for i in range(1, count):
        x[:, i] = rho * x[:, i - 1] + noise[:, i]
    return x


def variance_of_mean(rho: float, count: int) -> float:
    """Of a first-order process of variance 1: sum over all pairs, in closed form."""
    rest = 2.0 * rho * (1.0 - rho**count) / (count * (1.0 - rho) ** 2)
    return ((1.0 + rho) / (1.0 - rho) - rest) / count


class TestMean:
    @pytest.mark.parametrize(("rho", "count"), [(0.0, 400), (0.5, 400), (0.9, 4000)])
    def test_intervals_hold_the_mean(self, rho, count):
        """95 of 100: two standard deviations of 400 seeds are 2.2 %; batches are a little
        correlated still.
        """
        actual = [statistics.mean(x, widened=False) for x in correlated(rho, count)]
        share = np.mean([abs(m.value) <= m.half_width for m in actual])
        assert 0.92 < share < 0.98

    @pytest.mark.parametrize(("rho", "count"), [(0.5, 400), (0.9, 4000)])
    def test_the_variance_of_the_mean(self, rho, count):
        """Closed form; the mean of 400 variances of 20 batches scatters by sqrt(2 / 19 / 400) = 1.6
        %.

        What batches have in common makes them up to 10 % too small for batches of ten correlation
        times.
        """
        actual = np.mean(
            [statistics.mean(x, widened=False).error ** 2 for x in correlated(rho, count)]
        )
        assert actual == pytest.approx(variance_of_mean(rho, count), rel=0.12)
        scatter = np.var(correlated(rho, count).mean(axis=1), ddof=1)
        # sqrt(2 / 400) = 7 %, three times
        assert scatter == pytest.approx(variance_of_mean(rho, count), rel=0.25)

    def test_several_runs_are_one_long_one(self):
        """Four runs of 100 turns show as much as one of 400, within the scatter of 5 % of the means
        of 100 widths.
        """
        x = correlated(0.5, 400, 100)
        one = [statistics.mean(row).half_width for row in x]
        four = [
            statistics.mean(row).half_width
            for row in correlated(0.5, 100, 400).reshape(100, 4, 100)
        ]
        assert np.mean(four) == pytest.approx(np.mean(one), rel=0.1)

    def test_constants_and_recurrences(self):
        """A series that repeats itself has an error that falls with its length, not with the root
        of it.
        """
        assert statistics.mean([2.0] * 9) == statistics.Mean(2.0, 0.0, 9, 9)
        short, long = (statistics.mean(np.tile([1.0, 3.0], n), widened=False) for n in (200, 800))
        assert (short.value, long.value) == (2.0, 2.0)
        assert long.half_width == short.half_width == 0.0  # batches of complete periods
        # half of that of independent values: the standard deviation is 1
        floor = 0.5 * statistics.student(399) / math.sqrt(399.0)
        assert statistics.mean(np.tile([1.0, 3.0], 200)).half_width == pytest.approx(floor)

    @pytest.mark.parametrize("count", [20, 40, 100, 280])
    @pytest.mark.parametrize("rho", [0.0, 0.3, 0.6])
    def test_short_series(self, rho, count):
        """1000 series: 92 to 98 of 100, as is required of those of turns; two standard deviations
        are 1.4 %.
        """
        actual = [statistics.mean(x) for x in correlated(rho, count, 1000)]
        assert 0.92 <= np.mean([abs(m.value) <= m.half_width for m in actual]) <= 0.98 + 0.014

    @pytest.mark.parametrize("count", [40, 100, 280])
    def test_bursts(self, count):
        """1000 series of a surrogate of impacts: a correlation of 0.23 from one value to the next,
        a skewness of 2, the mean 1. 92 to 98 of 100 hold it.
        """
        rng = np.random.default_rng(2)
        fresh = rng.exponential(size=(1000, count + 50))
        again = rng.random(size=fresh.shape) < 0.45
        x = fresh.copy()
        for i in range(1, x.shape[1]):
            x[:, i] = np.where(again[:, i], 0.5 * (x[:, i - 1] + fresh[:, i]), fresh[:, i])
        actual = [statistics.mean(row) for row in x[:, 50:]]
        assert 0.92 <= np.mean([abs(m.value - 1.0) <= m.half_width for m in actual]) <= 0.98

    def test_widened_where_short(self):
        """As far as values are correlated or skewed: fully those that are both, not at all where
        neighbours lie on two sides of the mean.
        """
        burst = np.repeat([[0.0, 0.0, 0.0, 0.0, 1.0]], 4, axis=1)
        assert statistics.widening(np.sort(burst)) == statistics.widening(burst) == 2.2
        assert statistics.widening(np.tile([[1.0, -1.0]], 10)) == 1.0
        assert statistics.widening(np.sort(np.tile([[1.0, 0.0]], 500))) == 1.0  # long enough
        assert statistics.widening(np.zeros((1, 20))) == 1.0

    def test_correlation(self):
        """Of 4000 short series, whose sample value would be -0.05 and 0.35: within 0.02."""
        for rho in (0.0, 0.5):
            actual = [statistics.correlation(x[None]) for x in correlated(rho, 20, 4000)]
            assert np.mean(actual) == pytest.approx(rho, abs=0.02)

    def test_needed(self):
        """The width falls with the root of the number of values."""
        actual = statistics.Mean(2.0, 0.2, 100, 10)
        assert actual.share == pytest.approx(0.1)
        assert actual.needed(0.05) == 400
        assert actual.needed(0.2) == 100

    def test_too_few(self):
        """Three values have no interval."""
        with pytest.raises(ValueError, match="at least 8 values, got 3"):
            statistics.mean([1.0, 2.0, 3.0])


class TestQuantile:
    @pytest.mark.parametrize(("share", "rho"), [(0.9, 0.0), (0.9, 0.5), (0.99, 0.5)])
    def test_intervals_hold_the_quantile(self, share, rho):
        """Normal values: 95 of 100, two standard deviations of 400 seeds are 2.2 %; ranks make
        intervals wider.
        """
        from scipy.special import ndtri

        actual = [statistics.quantile(x, share) for x in correlated(rho, 1000)]
        held = np.mean([q.low <= ndtri(share) and not ndtri(share) > q.high for q in actual])
        assert 0.91 < held <= 0.99

    def test_an_end_that_cannot_be_told(self):
        """One in a hundred of 50 values: nothing bounds it from above."""
        actual = statistics.quantile(np.arange(50.0), 0.99)
        assert math.isnan(actual.high)
        assert actual.low < actual.value <= 49.0
        assert not statistics.told(50, 0.99)
        assert statistics.told(50, 0.9)
        with pytest.raises(ValueError, match="between 0 and 1"):
            statistics.quantile(np.arange(50.0), 1.0)


class TestTransient:
    def test_a_decay_is_left_out(self):
        """exp(-i / 20) of 30 standard deviations: below one of the mean after 20 log(30 sqrt(n))
        values.
        """
        x = correlated(0.0, 500, 20) + 30.0 * np.exp(-np.arange(500) / 20.0)
        cuts = [statistics.transient([row]) for row in x]
        assert min(cuts) >= 50
        assert max(cuts) <= 250
        # 6 standard errors
        assert max(abs(row[cut:].mean()) for row, cut in zip(x, cuts, strict=True)) < 0.3

    def test_nothing_is_left_out_of_a_stationary_one(self):
        """At most a quarter in 9 of 10, and always 5."""
        cuts = [statistics.transient([row]) for row in correlated(0.5, 300, 100)]
        assert min(cuts) == 5
        assert np.quantile(cuts, 0.9) <= 75

    def test_a_trend_is_seen(self):
        """A trend is not settled; a constant is."""
        assert not statistics.settled(correlated(0.0, 200, 1) + np.linspace(0.0, 5.0, 200))
        assert statistics.settled(np.full((1, 50), 3.0))


class TestMotions:
    @pytest.mark.slow
    def test_one_motion_is_not_taken_apart(self):
        """Of 100 sets of four runs of one process and five quantities at most 3 %; 1 % expected."""
        x = correlated(0.5, 100, 2000).reshape(100, 5, 4, 100)
        apart = sum(len(statistics.motions(list(sets))) > 1 for sets in x)
        assert apart <= 3

    def test_several_are_told_apart(self):
        """Motions that differ by more than chance are separate."""
        x = correlated(0.5, 100, 4) + np.array([[0.0], [3.0], [0.0], [3.0]])
        assert statistics.motions([correlated(0.0, 100, 4), x]) == [[0, 2], [1, 3]]
        assert statistics.motions([10.0 + 0.01 * x], finest=0.05) == [[0, 1, 2, 3]]
        # a share below `least`: five times as far as chance goes, or not
        assert statistics.motions([10.0 + 0.01 * x], least=0.05) == [[0, 2], [1, 3]]
        near = correlated(0.5, 100, 4) + np.array([[0.0], [0.7], [0.0], [0.7]])
        assert statistics.motions([10.0 + 0.01 * near], least=0.05) == [[0, 1, 2, 3]]

    def test_constants(self):
        """Periodic motions: the same in all runs, or not."""
        assert statistics.motions([np.full((3, 50), 2.0)]) == [[0, 1, 2]]
        assert statistics.motions([np.repeat([[2.0], [2.0], [5.0]], 50, axis=1)]) == [[0, 1], [2]]


def orbit(rng, noise: float, turns: int = 60) -> np.ndarray:
    """A motion of one to six turns and three numbers, from any of its turns on, (turns, 3)."""
    points = rng.uniform(0.5, 1.5, (rng.integers(1, 7), 3))
    places = points[(rng.integers(6) + np.arange(turns)) % len(points)]
    return places * (1.0 + noise * rng.normal(size=places.shape))


def again(rng, motion: np.ndarray, noise: float) -> np.ndarray:
    """The same orbit, later by some turns, with other noise; a start-up dies out at its start."""
    decay = 1e-3 * rng.uniform(0.2, 0.8) ** np.arange(len(motion))[:, None]
    moved = np.roll(motion, rng.integers(6), axis=0)
    return moved * (1.0 + decay + noise * rng.normal(size=motion.shape))


def cloud(rng, turns: int = 60) -> np.ndarray:
    """Turns of Henon's map, which is chaotic, from any place on its attractor, (turns, 2)."""
    x, y, points = *rng.uniform(-0.1, 0.1, 2), []
    for _ in range(100 + turns):
        x, y = 1.0 - 1.4 * x * x + y, 0.3 * x
        points.append((x + 5.0, y + 5.0))
    return np.array(points[-turns:])


class TestSections:
    """Runs are compared turn by turn; FINEST as in the statistics of runs."""

    FINEST = 1e-4

    def test_orbits_that_differ(self):
        """Of 300 pairs, by 1e-3 in one of three numbers at least, none is one motion, with a
        scatter of up to 3 % of that.
        """
        rng = np.random.default_rng(5)
        for _ in range(300):
            apart, motion = 10.0 ** rng.uniform(-3.0, -1.0), orbit(rng, 0.0)
            noise = apart * 10.0 ** rng.uniform(-3.0, -1.5)
            moved = 1.0 + apart * np.eye(3)[rng.integers(3)]
            one, other = again(rng, motion, noise), again(rng, motion * moved, noise)
            runs = np.array([one, other])
            assert statistics.motions([runs[..., 0]], 0.2, self.FINEST, runs) == [[0], [1]]

    @pytest.mark.slow
    def test_orbits_that_are_the_same(self):
        """Of 300 groups of four, with a scatter of up to 3 %, all are one motion."""
        rng = np.random.default_rng(6)
        for _ in range(300):
            noise, motion = 10.0 ** rng.uniform(-6.0, -1.5), orbit(rng, 0.0)
            runs = np.array([again(rng, motion, noise) for _ in range(4)])
            assert statistics.motions([runs[..., 0]], 0.2, self.FINEST, runs) == [[0, 1, 2, 3]]

    def test_chaos_beside_chaos_and_orbits(self):
        """Of 200 pairs of the same chaos all are one motion; one that repeats itself is another,
        also inside the cloud of the chaos, in 19 of 20: some clouds seem to come nearer.
        """
        rng, parted = np.random.default_rng(7), 0
        for _ in range(200):
            one, other = cloud(rng), cloud(rng)
            assert not statistics.apart(one, other, self.FINEST)
            still = np.tile(one[:1] + 0.3 * (other[:1] - one[:1]), (60, 1))
            still *= 1.0 + 1e-5 * rng.normal(size=still.shape)
            parted += statistics.apart(still, other, self.FINEST)
        assert parted >= 190

    def test_a_run_that_still_comes_nearer_is_no_other(self):
        """By a tenth or more in ten turns; one that stays 1e-2 away is another."""
        rng = np.random.default_rng(8)
        for _ in range(100):
            motion = orbit(rng, 0.0)
            away = 0.1 * rng.uniform(0.9, 0.98) ** np.arange(60)[:, None]
            comes, stays = motion * (1.0 + away), 1.01 * motion
            assert not statistics.apart(motion, comes, self.FINEST)
            assert statistics.apart(motion, stays, self.FINEST)


def test_looks():
    """The series of lengths at which statistics are looked at."""
    assert list(itertools.islice(statistics.looks(), 5)) == [40, 50, 63, 79, 98]
