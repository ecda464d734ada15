"""Radau IIA of order 5 as a stepper; see radau.py."""

from clearance.stepping import radau
from clearance.stepping.state import state_at
from clearance.stepping.tableaus import RADAU5
from clearance.stepping.types import STEP_SIGNATURE, compiled

STAGES, MOMENTS = RADAU5.c.size, RADAU5.moments
ORDER = STAGES + 1  # of the error estimate's defect: what the step size goes by
DEGREE = STAGES  # of the dense output
ROWS = 4 * STAGES + radau.LU  # scratch: rows of `matrix`, beside one per state


@compiled(STEP_SIGNATURE)
def step(address, t, h):
    """One step of order 5."""
    return radau.advance(RADAU5, state_at(address), t, h)


@compiled(STEP_SIGNATURE)
def interpolant(address, t, h):
    """Dense output: the collocation polynomial."""
    s = state_at(address)
    radau.judge(RADAU5, s, h)
    return radau.interpolate(RADAU5, s.y, s.dense, s.matrix)
