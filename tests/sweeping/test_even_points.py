"""Sobol' points and Latin hypercubes beside those of scipy."""

import numpy as np
import pytest
from scipy.stats import qmc

from clearance.values.even_points import MOST, latin, sobol

SEEDS = np.random.default_rng(0).integers(0, 2**31, 3).tolist()


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("dimensions", [1, 2, 7, 40, MOST])
@pytest.mark.parametrize("exponent", [0, 1, 5, 11])
def test_sobol_points_are_those_of_scipy(exponent, dimensions, seed):
    """The same bits for a seed: integers over 2^30."""
    actual = sobol(2**exponent, dimensions, *np.random.default_rng(seed).spawn(1))
    expected = qmc.Sobol(dimensions, rng=seed).random_base2(exponent)
    np.testing.assert_array_equal(actual, expected)


def test_more_dimensions():
    """Beyond the stored direction numbers scipy makes them: as even, one in each half."""
    points = sobol(2, MOST + 3, np.random.default_rng(0))
    assert ((points < 0.5).sum(axis=0) == 1).all()


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(("count", "dimensions"), [(1, 1), (8, 3), (100, 12)])
def test_latin_hypercubes_are_those_of_scipy(count, dimensions, seed):
    """The same bits for a seed."""
    actual = latin(count, dimensions, *np.random.default_rng(seed).spawn(1))
    expected = qmc.LatinHypercube(dimensions, rng=seed).random(count)
    np.testing.assert_array_equal(actual, expected)
