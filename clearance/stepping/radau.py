"""Radau IIA with three stages: implicit, order 5, L-stable; simplified Newton with the kernel's exact Jacobian.

Follows Hairer and Wanner, Solving Ordinary Differential Equations II (1996), section IV.8: one real and one complex
system a step, starting values from the last step's collocation polynomial, the Jacobian kept while Newton converges
fast. The ledger (energy input and dissipated) does not feed back: it is integrated by the same collocation, afterwards.
"""

import math

from clearance.stepping import tableaus
from clearance.stepping.linear import factor, solve
from clearance.stepping.types import (
    ERROR,
    EVALUATE_LEDGER,
    EVALUATIONS,
    FACTORISATIONS,
    HAS_PREDICTOR,
    JACOBIAN_STATE,
    JACOBIANS,
    LAST_H,
    LU_STATE,
    RTOL,
    STATES,
    STEP_SIGNATURE,
    compiled,
    inline,
)  # fmt: skip

A, C, E = tableaus.RADAU_A, tableaus.RADAU_C, tableaus.RADAU_E
T, TI = tableaus.RADAU_T, tableaus.RADAU_TI
REAL, COMPLEX = tableaus.RADAU_REAL, tableaus.RADAU_COMPLEX
ORDER = 4
ITERATIONS = 10

# rows of `matrix`: stages z, their derivatives, transformed w, trial, error, predictor polynomial (3), then the real LU
Z, F, W, TRIAL, CORRECTION, POLYNOMIAL, PIVOTS, LU = 0, 3, 6, 9, 10, 11, 14, 15


@inline
def _predicted(m, h, control, counts, size):
    """Stages from the last collocation polynomial, or zero."""
    ratio = h / control[LAST_H] if control[LAST_H] > 0.0 else 0.0
    for s in range(3):
        x = 1.0 + ratio * C[s]
        for i in range(size):
            if counts[HAS_PREDICTOR] == 1:
                a, b, c = m[POLYNOMIAL, i], m[POLYNOMIAL + 1, i], m[POLYNOMIAL + 2, i]
                m[Z + s, i] = x * (a + (1.0 - x) * (b + x * c)) - a
            else:
                m[Z + s, i] = 0.0


@inline
def _collocation(m, size):
    """Coefficients of y(theta) - y0 = theta (a + (1 - theta) (b + theta c)) through the stages."""
    c1, c2 = C[0], C[1]
    for i in range(size):
        a = m[Z + 2, i]
        g1 = (m[Z, i] / c1 - a) / (1.0 - c1)
        g2 = (m[Z + 1, i] / c2 - a) / (1.0 - c2)
        slope = (g2 - g1) / (c2 - c1)
        m[POLYNOMIAL, i], m[POLYNOMIAL + 1, i], m[POLYNOMIAL + 2, i] = a, g1 - c1 * slope, slope


@inline
def _factorise(vector, m, complexes, counts, h, n):
    for i in range(n):
        for j in range(n):
            m[LU + i, j] = -vector[i * n + j]
            complexes[i, j] = -vector[i * n + j]
        m[LU + i, i] += REAL / h
        complexes[i, i] += COMPLEX / h
    factor(m[LU : LU + n], m[PIVOTS], n)
    factor(complexes, complexes[n], n)
    counts[FACTORISATIONS] += 1
    counts[LU_STATE] = 1


@inline
def _newton(rhs, t, h, y, par, work, scale, control, counts, m, complexes, n):
    """Simplified Newton on the transformed stages. 0 converged, 1 not, 2 not finite; and the rate of convergence."""
    tolerance = max(2e-15 / control[RTOL], min(0.03, math.sqrt(control[RTOL])))
    right = complexes[n + 1]
    trial, correction = m[TRIAL], m[CORRECTION]
    for s in range(3):
        for i in range(n):
            m[W + s, i] = TI[s, 0] * m[Z, i] + TI[s, 1] * m[Z + 1, i] + TI[s, 2] * m[Z + 2, i]
    for i in range(n, y.size):
        trial[i] = y[i]
    old, rate = 0.0, 0.0
    for iteration in range(ITERATIONS):
        for s in range(3):
            for i in range(n):
                trial[i] = y[i] + m[Z + s, i]
            rhs(t + C[s] * h, trial, par, work, m[F + s])
        counts[EVALUATIONS] += 3
        for i in range(n):
            f0, f1, f2 = m[F, i], m[F + 1, i], m[F + 2, i]
            correction[i] = TI[0, 0] * f0 + TI[0, 1] * f1 + TI[0, 2] * f2 - REAL / h * m[W, i]
            real = TI[1, 0] * f0 + TI[1, 1] * f1 + TI[1, 2] * f2
            imaginary = TI[2, 0] * f0 + TI[2, 1] * f1 + TI[2, 2] * f2
            right[i] = complex(real, imaginary) - COMPLEX / h * complex(m[W + 1, i], m[W + 2, i])
        solve(m[LU : LU + n], m[PIVOTS], correction, n)
        solve(complexes, complexes[n], right, n)
        norm = 0.0
        for i in range(n):
            weight = control[RTOL] * (scale[i] + abs(y[i]))
            norm += (correction[i] ** 2 + right[i].real ** 2 + right[i].imag ** 2) / weight**2
        norm = math.sqrt(norm / (3 * n))
        if not math.isfinite(norm):
            return 2, 1.0
        if iteration > 0:
            rate = norm / old if old > 0.0 else 0.0
            if rate >= 1.0 or rate ** (ITERATIONS - iteration) / (1.0 - rate) * norm > tolerance:
                return 1, rate
        for i in range(n):
            m[W, i] += correction[i]
            m[W + 1, i] += right[i].real
            m[W + 2, i] += right[i].imag
            for s in range(3):
                m[Z + s, i] = T[s, 0] * m[W, i] + T[s, 1] * m[W + 1, i] + T[s, 2] * m[W + 2, i]
        if norm == 0.0 or iteration > 0 and rate / (1.0 - rate) * norm < tolerance:
            return 0, rate
        old = norm
    return 1, rate


@inline
def _error(rhs, t, h, y, f, par, work, scale, control, counts, m, n):
    """Error over tolerance; filtered a second time where the first answer would reject the step."""
    estimate, trial = m[CORRECTION], m[TRIAL]
    for attempt in range(2):
        for i in range(n):
            base = f[i] if attempt == 0 else m[F, i]
            estimate[i] = base + (E[0] * m[Z, i] + E[1] * m[Z + 1, i] + E[2] * m[Z + 2, i]) / h
        solve(m[LU : LU + n], m[PIVOTS], estimate, n)
        total = 0.0
        for i in range(n):
            weight = control[RTOL] * (scale[i] + max(abs(y[i]), abs(y[i] + m[Z + 2, i])))
            total += (estimate[i] / weight) ** 2
        norm = math.sqrt(total / n)
        if attempt == 1 or norm < 1.0 or not math.isfinite(norm):
            break
        for i in range(n):
            trial[i] = y[i] + estimate[i]
        for i in range(n, y.size):
            trial[i] = y[i]
        rhs(t, trial, par, work, m[F])
        counts[EVALUATIONS] += 1
    return norm


@inline
def _ledger(rhs, t, h, y, par, work, counts, m, n):
    """Stages of the energy integrals from the powers at the converged stages."""
    trial = m[TRIAL]
    for s in range(3):
        for i in range(n):
            trial[i] = y[i] + m[Z + s, i]
        for i in range(n, y.size):
            trial[i] = y[i]
        rhs(t + C[s] * h, trial, par, work, m[F + s])
    counts[EVALUATIONS] += 3
    for i in range(n, y.size):
        for s in range(3):
            m[Z + s, i] = h * (A[s, 0] * m[F, i] + A[s, 1] * m[F + 1, i] + A[s, 2] * m[F + 2, i])


@compiled(STEP_SIGNATURE)
def step(rhs, jacobian, t, h, y, f, par, work, y_new, f_new, dense, scale, control, counts, vector, m, complexes):
    """One step from y with f = y' to y_new with f_new; error over tolerance in control[ERROR]. 0 if it worked."""
    size, n = y.size, counts[STATES]
    for _attempt in range(2):
        fresh = counts[JACOBIAN_STATE] != 1
        if fresh:
            for i in range(n * n):
                vector[i] = 0.0
            jacobian(t, y, par, work, vector)
            counts[JACOBIANS] += 1
            counts[JACOBIAN_STATE], counts[LU_STATE] = 1, 0
        if counts[LU_STATE] != 1 or control[LAST_H] != h:
            _factorise(vector, m, complexes, counts, h, n)
        _predicted(m, h, control, counts, n)
        answer, rate = _newton(rhs, t, h, y, par, work, scale, control, counts, m, complexes, n)
        if answer == 0 or fresh:
            break
        counts[JACOBIAN_STATE] = 0
    if answer != 0:
        counts[HAS_PREDICTOR], counts[LU_STATE] = 0, 0
        return answer
    error = _error(rhs, t, h, y, f, par, work, scale, control, counts, m, n)
    control[ERROR] = error
    if error > 1.0 or not math.isfinite(error):
        counts[LU_STATE] = 0
        return 0 if math.isfinite(error) else 2
    for i in range(n, size):
        m[Z, i] = m[Z + 1, i] = m[Z + 2, i] = 0.0
    if control[EVALUATE_LEDGER] > 0.0:
        _ledger(rhs, t, h, y, par, work, counts, m, n)
    for i in range(size):
        y_new[i] = y[i] + m[Z + 2, i]
    rhs(t + h, y_new, par, work, f_new)
    counts[EVALUATIONS] += 1
    _collocation(m, size)
    counts[HAS_PREDICTOR] = 1
    control[LAST_H] = h
    if rate > 1e-3:
        counts[JACOBIAN_STATE] = 0
    for i in range(size):
        if not math.isfinite(y_new[i]) or not math.isfinite(f_new[i]):
            return 2
    return 0


@compiled(STEP_SIGNATURE)
def interpolant(
    rhs, jacobian, t, h, y, f, par, work, y_new, f_new, dense, scale, control, counts, vector, m, complexes
):
    """Dense output of the step just made: its collocation polynomial, order 3."""
    for i in range(y.size):
        dense[0, i] = y[i]
        for r in range(3):
            dense[1 + r, i] = m[POLYNOMIAL + r, i]
        for r in range(4, 8):
            dense[r, i] = 0.0
    return 0
