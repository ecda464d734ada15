"""DOP853: explicit Runge-Kutta of order 8 with an error estimate of orders 5 and 3 and dense output
of order 7.
"""

import math

from clearance.stepping import status, tableaus
from clearance.stepping.state import state_at
from clearance.stepping.types import STEP_SIGNATURE, compiled, pasted

A, B, C, D, E3, E5 = tableaus.A, tableaus.B, tableaus.C, tableaus.D, tableaus.E3, tableaus.E5
ORDER = 8
DEGREE = 7  # of the dense output
STAGES = 12
#: error of the fifth order over tolerance, times rtol^(3/8), in a step whose estimate can be
#: believed. Smooth steps and contacts at the tolerance have 0.15 at most, from 1e-3 to 1e-12. A
#: step over a jump of friction may have any estimate by chance, and has more.
FIFTH = 0.15
#: scratch this stepper needs per state: rows of `matrix`
ROWS = 17
OUTWEIGHED = 1e4  # squares of terms within a step over those of its ends: errors, no motion


@pasted
def stages(run, t, h, first, last):
    """Slopes k[first] to k[last - 1] from those before them; none reads the ledger, so trial states
    leave it out.
    """
    y, k, states = run.y, run.matrix, run.states
    trial = k[16]
    for s in range(first, last):
        for i in range(states):
            total = 0.0
            for j in range(s):
                total += A[s, j] * k[j, i]
            trial[i] = y[i] + h * total
        run.rhs(t + C[s] * h, trial, run.par, run.work, k[s])


@compiled(STEP_SIGNATURE)
def step(address, t, h):
    """One step from y with f = y' to y_new with f_new; the error over tolerance goes to `s.error`.
    0 if finite.

    The estimate is the product of those of orders 5 and 3 that Hairer, Norsett and Wanner (1993,
    II.10) take. Where a step hides a steep change between its stages it can be small by chance:
    that of order 5 is bounded by itself.

    `s.stiffness`: step times the largest eigenvalue felt, from the last two slopes (Hairer and
    Wanner, Solving Ordinary Differential Equations II (1996), IV.2). The method is unstable above
    about 6.1.
    """
    s = state_at(address)
    rhs = s.rhs
    y, f, par, work, y_new, f_new, k = s.y, s.f, s.par, s.work, s.y_new, s.f_new, s.matrix
    scale, size, states = s.scale, y.size, s.states
    for i in range(size):
        k[0, i] = f[i]
    stages(s, t, h, 1, STAGES)
    for i in range(size):
        total = 0.0
        for j in range(STAGES):
            total += B[j] * k[j, i]
        y_new[i] = y[i] + h * total
    rhs(t + h, y_new, par, work, f_new)
    s.evaluations += STAGES
    high = low = 0.0
    for i in range(states):
        five = E5[STAGES] * f_new[i]
        three = E3[STAGES] * f_new[i]
        for j in range(STAGES):
            five += E5[j] * k[j, i]
            three += E3[j] * k[j, i]
        weight = s.rtol * (scale[i] + max(abs(y[i]), abs(y_new[i])))
        high += (five / weight) ** 2
        low += (three / weight) ** 2
    s.error = 0.0
    if high > 0.0 or low > 0.0:
        s.error = h * high / math.sqrt((high + 0.01 * low) * states)
        fifth = h * math.sqrt(high / states) * s.rtol ** (1.0 - 5.0 / 8.0)
        s.error = max(s.error, fifth / FIFTH)
    apart = slopes = 0.0
    for i in range(states):
        unit = 1.0 / (scale[i] + abs(y_new[i]))
        apart += ((y_new[i] - k[16, i]) * unit) ** 2
        slopes += ((f_new[i] - k[STAGES - 1, i]) * unit) ** 2
    s.stiffness = h * math.sqrt(slopes / apart) if apart > 0.0 else 0.0
    finite = math.isfinite(s.error) and math.isfinite(high)
    for i in range(size):
        finite = finite and math.isfinite(y_new[i]) and math.isfinite(f_new[i])
    return status.MADE if finite else status.TOO_LONG


@compiled(STEP_SIGNATURE)
def interpolant(address, t, h):
    """Dense output of the step just made: three more evaluations.

    In a step far beyond the limit of stability, as of a body at rest on a stiff spring, each of
    them makes the errors of those before larger. Where they outweigh all else, slopes and values at
    both ends remain, a cubic.
    """
    s = state_at(address)
    y, f, y_new, f_new, dense, k = s.y, s.f, s.y_new, s.f_new, s.dense, s.matrix
    size, within, at_ends = y.size, 0.0, 0.0
    for i in range(size):
        k[STAGES, i] = f_new[i]
    stages(s, t, h, STAGES + 1, 16)
    s.evaluations += 3
    for i in range(size):
        change = y_new[i] - y[i]
        dense[0, i] = y[i]
        dense[1, i] = change
        dense[2, i] = h * f[i] - change
        dense[3, i] = 2.0 * change - h * (f[i] + f_new[i])
        for r in range(4):
            total = 0.0
            for j in range(16):
                total += D[r, j] * k[j, i]
            dense[4 + r, i] = h * total
        if i < s.states:
            unit = 1.0 / (s.scale[i] + abs(y_new[i]))
            for r in range(1, 4):
                at_ends += (dense[r, i] * unit) ** 2
            for r in range(4, 8):
                within += (dense[r, i] * unit) ** 2
    if within > OUTWEIGHED * at_ends:
        for r in range(4, 8):
            for i in range(size):
                dense[r, i] = 0.0
    return 0
