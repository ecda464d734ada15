"""Coefficients of the steppers: the conditions that make them what they are."""

import numpy as np
import pytest

from clearance.stepping import tableaus as t


@pytest.mark.parametrize("k", [t.RADAU5, t.RADAU9], ids=["radau5", "radau9"])
class TestRadau:
    def test_collocation(self, k):
        """C(s): A c^(q-1) = c^q / q for q = 1 .. s; 1e-14 (rounding)."""
        for q in range(1, k.c.size + 1):
            np.testing.assert_allclose(k.a @ k.c ** (q - 1), k.c**q / q, atol=1e-14)

    def test_quadrature(self, k, validated):
        """B(2s - 1): the weights, the last row, integrate polynomials up to degree 2s - 2."""
        for q in range(1, 2 * k.c.size):
            actual = k.a[-1] @ k.c ** (q - 1)
            validated(
                f"quadrature of Radau IIA with {k.c.size} stages",
                actual,
                1.0 / q,
                1e-13,
                source="order condition 1 / q",
                kind="exact",
            )

    def test_eigenbasis(self, k):
        """ti inv(A) t is block diagonal: the real eigenvalue, then a 2x2 rotation for each pair."""
        blocks = k.ti @ np.linalg.inv(k.a) @ k.t
        expected = np.zeros_like(blocks)
        expected[0, 0] = k.real
        for i, z in enumerate(k.pairs):
            j = 1 + 2 * i
            expected[j : j + 2, j : j + 2] = [[z.real, -z.imag], [z.imag, z.real]]
        np.testing.assert_allclose(blocks, expected, atol=1e-11)

    def test_dense_output_and_end_slope(self, k):
        """Both are exact for polynomials through 0 of degree s."""
        s = k.c.size
        for q in range(1, s + 1):
            rows = k.basis @ k.c**q
            for theta in (0.2, 0.7, 1.0, 1.6):
                assert t.nested(theta, s) @ rows == pytest.approx(theta**q, abs=1e-11)
            assert k.end @ k.c**q == pytest.approx(q, rel=1e-11)


def test_published_radau5(validated):
    """Eigenvalues of the inverse stage matrix (Hairer and Wanner 1996, IV.8), 10 printed digits."""
    pair, source = t.RADAU5.pairs[0], "Hairer and Wanner 1996, IV.8"
    actual, printed = (
        (t.RADAU5.real, pair.real, abs(pair.imag)),
        (3.6378342527, 2.6810828736, 3.0504301993),
    )
    validated("eigenvalues of Radau5's inverse stage matrix", actual, printed, 1e-10, source=source)


def test_dop853_quadrature(validated):
    """The weights integrate polynomials up to degree 7 exactly, the nodes are the row sums."""
    for q in range(1, 9):
        actual = t.B @ t.C[:12] ** (q - 1)
        validated(
            "quadrature of DOP853",
            actual,
            1.0 / q,
            1e-12,
            source="order condition 1 / q",
            kind="exact",
        )
    np.testing.assert_allclose(t.A.sum(axis=1), t.C, atol=1e-14)


def rodas(q: int) -> tuple[float, np.ndarray]:
    """Solution of y' = t^(q-1), y(0) = 0, in one step of size 1 by Rodas5P's formulas, and rows of
    its dense output.
    """
    stages = []
    for s in range(8):
        slope = (q - 1) * 0.0 ** (q - 2) if q > 2 else float(q == 2)  # df/dt at t = 0
        right = t.RODAS_NODES[s] ** (q - 1) + t.RODAS_C[s, :s] @ stages[:s] + t.RODAS_D[s] * slope
        stages.append(t.RODAS_GAMMA * right)
    values = np.array(stages)
    return t.RODAS_A[7] @ values + values[7], t.RODAS_H @ values


@pytest.mark.parametrize("q", range(1, 6))
def test_rodas5p_quadrature(q, validated):
    """Order 5 on y' = t^(q-1); the dense output is of order 4; 1e-13."""
    end, rows = rodas(q)
    options = {"source": "order condition 1 / q", "kind": "exact", "relative": False}
    validated("quadrature of Rodas5P", end, 1.0 / q, 1e-12, **options)
    if q < 5:
        for theta in (0.25, 0.6):
            value = theta * (end + (1.0 - theta) * (rows[0] + theta * (rows[1] + theta * rows[2])))
            assert value == pytest.approx(theta**q / q, abs=1e-12)
