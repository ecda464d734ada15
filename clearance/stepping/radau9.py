"""Radau IIA of order 9 as a stepper; see radau.py."""

from clearance.stepping import radau
from clearance.stepping.state import state_at
from clearance.stepping.tableaus import RADAU9
from clearance.stepping.types import STEP_SIGNATURE, compiled

STAGES, MOMENTS = RADAU9.c.size, RADAU9.moments
ORDER = STAGES + 1  # of the error estimate's defect: what the step size goes by
DEGREE = STAGES  # of the dense output
ROWS = 4 * STAGES + radau.LU  # scratch: rows of `matrix`, beside one per state


@compiled(STEP_SIGNATURE)
def step(address, t, h):
    """One step of order 9."""
    return radau.advance(RADAU9, state_at(address), t, h)


@compiled(STEP_SIGNATURE)
def interpolant(address, t, h):
    """Dense output: the collocation polynomial."""
    s = state_at(address)
    radau.judge(RADAU9, s, h)
    return radau.interpolate(RADAU9, s.y, s.dense, s.matrix)
