"""Radau IIA of order 9 as a stepper; see radau.py."""

from clearance.stepping import radau
from clearance.stepping.tableaus import RADAU9
from clearance.stepping.types import STEP_SIGNATURE, compiled

STAGES = RADAU9.c.size
ORDER = STAGES + 1  # of the error estimate's defect: what the step size goes by
ROWS = 4 * STAGES + radau.LU  # scratch: rows of `matrix`, beside one per state


@compiled(STEP_SIGNATURE)
def step(rhs, jacobian, t, h, y, f, par, work, y_new, f_new, dense, scale, control, counts, vector, m, complexes):
    """One step of order 9."""
    return radau.advance(
        RADAU9, rhs, jacobian, t, h, y, f, par, work, y_new, f_new, scale, control, counts, vector, m, complexes
    )


@compiled(STEP_SIGNATURE)
def interpolant(
    rhs, jacobian, t, h, y, f, par, work, y_new, f_new, dense, scale, control, counts, vector, m, complexes
):
    """Dense output: the collocation polynomial."""
    return radau.interpolate(RADAU9, y, dense, m)
