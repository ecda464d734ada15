"""Rodas5P: linearly implicit (Rosenbrock), order 5(4), stiffly accurate, dense output of order 4.

No Newton iteration.

Every stage solves one linear system with the same matrix, so no step is lost because an iteration
diverges: the cheapest way to loose tolerances in thin films. As in radau.py the systems are halved
by q' = u, and the ledger is integrated afterwards, at three points of the dense output.
Source: G. Steinebach, Construction of Rosenbrock-Wanner method Rodas5P, BIT Numer. Math. 63, 27
(2023).
"""

import math

from clearance.stepping import status, tableaus
from clearance.stepping.linear import factor, rate_matrix, solve
from clearance.stepping.state import state_at
from clearance.stepping.types import STEP_SIGNATURE, compiled, inline

A, C, NODES = tableaus.RODAS_A, tableaus.RODAS_C, tableaus.RODAS_NODES
D, H, GAMMA = tableaus.RODAS_D, tableaus.RODAS_H, tableaus.RODAS_GAMMA
LEDGER_NODES, LEDGER_WEIGHTS, LEDGER_BASIS = (
    tableaus.RADAU5.c,
    tableaus.RADAU5.a,
    tableaus.RADAU5.basis,
)
STAGES = 8
ORDER = 5
DEGREE = 4  # of the dense output
DIFFERENCE = 1e-4  # of the step: increment of the derivative by time

# rows of `matrix` after the stages
TRIAL, RATE_OF_TIME, SLOPE, PIVOTS, LU = 8, 9, 10, 11, 12
ROWS = LU


@inline
def factorise(vector, m, g, p, n):
    """LU of the matrix of the rates."""
    rate_matrix(m[LU : LU + n - p], vector, g, p, n)
    factor(m[LU : LU + n - p], m[PIVOTS], n - p)


@inline
def solved(vector, m, s, g, p, n):
    """Row s of m becomes the solution of (g - J) x = row s."""
    right = m[s]
    for i in range(p, n):
        row, total = i * n, right[i]
        for j in range(p):
            total += vector[row + j] * right[j] / g
        m[SLOPE, i - p] = total
    solve(m[LU : LU + n - p], m[PIVOTS], m[SLOPE], n - p)
    for i in range(p, n):
        right[i] = m[SLOPE, i - p]
    for i in range(p):
        right[i] = (right[i] + right[p + i]) / g


@inline
def stages(run, t, h):
    """All stages; the last is the error estimate, the trial state and the last stage make the new
    state.
    """
    y, f, m, n = run.y, run.f, run.matrix, run.states
    g, trial = 1.0 / (GAMMA * h), m[TRIAL]
    for i in range(y.size):
        trial[i] = y[i]
        m[SLOPE, i] = f[i]
    for s in range(STAGES):
        if s > 0:
            for i in range(n):
                total = y[i]
                for j in range(s):
                    total += A[s, j] * m[j, i]
                trial[i] = total
            run.rhs(t + NODES[s] * h, trial, run.par, run.work, m[SLOPE])
        for i in range(n):
            total = 0.0
            for j in range(s):
                total += C[s, j] * m[j, i]
            m[s, i] = m[SLOPE, i] + total / h + h * D[s] * m[RATE_OF_TIME, i]
        solved(run.jacobian_rows, m, s, g, run.coordinates, n)


@inline
def dense_output(y, y_new, dense, m, n):
    """Rows of the nested form."""
    for i in range(n):
        first = second = third = 0.0
        for j in range(STAGES):
            first += H[0, j] * m[j, i]
            second += H[1, j] * m[j, i]
            third += H[2, j] * m[j, i]
        dense[0, i] = y[i]
        dense[1, i] = y_new[i] - y[i]
        dense[2, i] = first
        dense[3, i] = second + third
        dense[4, i] = -third
        dense[5, i] = dense[6, i] = dense[7, i] = 0.0


@inline
def ledger(run, t, h):
    """The energy integrals and their dense output, from the powers at three places of the dense
    output of the rest.
    """
    y, y_new, dense, m, n = run.y, run.y_new, run.dense, run.matrix, run.states
    trial = m[TRIAL]
    for s in range(3):
        x = LEDGER_NODES[s]
        for i in range(n):
            trial[i] = y[i] + x * (
                dense[1, i]
                + (1.0 - x) * (dense[2, i] + x * (dense[3, i] + (1.0 - x) * dense[4, i]))
            )
        for i in range(n, y.size):
            trial[i] = y[i]
        run.rhs(t + x * h, trial, run.par, run.work, m[s])
    for i in range(n, y.size):
        dense[0, i] = y[i]
        for r in range(1, dense.shape[0]):
            dense[r, i] = 0.0
        for s in range(3):
            total = 0.0
            for j in range(3):
                total += LEDGER_WEIGHTS[s, j] * m[j, i]
            for r in range(3):
                dense[1 + r, i] += LEDGER_BASIS[r, s] * h * total
        y_new[i] = y[i] + dense[1, i]


@compiled(STEP_SIGNATURE)
def step(address, t, h):
    """One step from y with f = y' to y_new with f_new; error over tolerance in `s.error`. 0 if
    finite.
    """
    s = state_at(address)
    rhs = s.rhs
    y, f, par, work, y_new, f_new = s.y, s.f, s.par, s.work, s.y_new, s.f_new
    dense, scale, vector, m = s.dense, s.scale, s.jacobian_rows, s.matrix
    size, n, p = y.size, s.states, s.coordinates
    if s.jacobian_state != 1:
        s.jacobian(t, y, par, work, vector)
        s.jacobians += 1
        later = DIFFERENCE * h
        rhs(t + later, y, par, work, m[RATE_OF_TIME])
        for i in range(n):
            m[RATE_OF_TIME, i] = (m[RATE_OF_TIME, i] - f[i]) / later
        s.jacobian_state = 1
    factorise(vector, m, 1.0 / (GAMMA * h), p, n)
    stages(s, t, h)
    s.factorisations += 1
    s.evaluations += STAGES + 1
    total = 0.0
    for i in range(n):
        y_new[i] = m[TRIAL, i] + m[STAGES - 1, i]
        total += (m[STAGES - 1, i] / (s.rtol * (scale[i] + max(abs(y[i]), abs(y_new[i]))))) ** 2
    s.error = math.sqrt(total / n)
    if not math.isfinite(s.error):
        return status.NO_NUMBERS
    if s.error > 1.0:
        return status.MADE
    s.jacobian_state = 0
    for i in range(n, size):
        y_new[i] = y[i]
    dense_output(y, y_new, dense, m, n)
    if size > n and s.evaluate_ledger > 0:
        ledger(s, t, h)
        s.evaluations += 3
    rhs(t + h, y_new, par, work, f_new)
    for i in range(size):
        if not math.isfinite(y_new[i]) or not math.isfinite(f_new[i]):
            return status.NO_NUMBERS
    return status.MADE


@compiled(STEP_SIGNATURE)
def interpolant(address, t, h):
    """The step has made its dense output, order 4, already."""
    return 0
