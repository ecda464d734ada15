"""Band systems of the film solvers, against the dense solution."""

import numpy as np
import pytest

from clearance.film.banded import (
    Factors,
    backward,
    factorise,
    factorise_lu,
    substitute,
    substitute_lu,
)
from tests.seeds import few_of


def symmetric(rng, count, reach, inner):
    """A positive definite matrix (count + inner square) with a band and a border, its parts, and a
    right-hand side.
    """
    dense = rng.normal(size=(count + inner, count + inner))
    near = np.abs(np.subtract.outer(np.arange(count), np.arange(count))) <= reach
    dense[:count, :count] *= near
    dense = dense + dense.T + 4.0 * (count + inner) * np.eye(count + inner)
    band = np.zeros((count, reach + 1))
    for i in range(count):
        row = dense[i, i : min(i + reach + 1, count)]
        band[i, : row.size] = row
    parts = Factors(band, dense[:count, count:].copy(), dense[count:, count:].copy())
    return dense, parts, rng.normal(size=count + inner)


@pytest.mark.parametrize("seed", few_of(range(10), 2))
def test_cholesky(seed):
    """With a border, and with the right-hand side as the border: 1e-12."""
    rng = np.random.default_rng(seed)
    count, reach, inner = (int(rng.integers(*ends)) for ends in ((6, 40), (1, 6), (1, 5)))
    dense, parts, right = symmetric(rng, count, reach, inner)
    alone = Factors(parts.band.copy(), np.zeros((count + reach, 1)), np.ones((1, 1)))
    alone.border[:count, 0] = right[:count]
    x = np.zeros(count + reach + inner)
    x[:count], x[count + reach :] = right[:count], right[count:]
    factorise(parts)
    substitute(parts, x)
    np.testing.assert_allclose(
        np.delete(x, range(count, count + reach)),
        np.linalg.solve(dense, right),
        rtol=1e-12,
        atol=1e-14,
    )
    factorise(alone)
    y = alone.border[:, 0].copy()
    backward(alone._replace(corner=np.ones((0, 0))), y)
    wanted = np.linalg.solve(dense[:count, :count], right[:count])
    np.testing.assert_allclose(y[:count], wanted, rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("seed", few_of(range(10), 2))
def test_lu(seed):
    """Several right-hand sides: 1e-12."""
    rng = np.random.default_rng(seed)
    count, w = int(rng.integers(6, 40)), int(rng.integers(1, 6))
    matrix = np.zeros((count, 2 * w + 1))
    dense = rng.normal(size=(count, count)) + 4.0 * count * np.eye(count)
    for i in range(count):
        for j in range(count):
            if abs(i - j) <= w:
                matrix[i, w + j - i] = dense[i, j]
            else:
                dense[i, j] = 0.0
    right = rng.normal(size=(count, 3))
    wanted = np.linalg.solve(dense, right)
    factorise_lu(matrix)
    substitute_lu(matrix, right)
    np.testing.assert_allclose(right, wanted, rtol=1e-12, atol=1e-14)
