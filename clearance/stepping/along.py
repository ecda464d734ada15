"""The compiled loop on steps whose ends are given."""

import math

from clearance.machine.store import caller, types
from clearance.stepping import status
from clearance.stepping.state import state_at
from clearance.stepping.types import INTEGERS, VECTOR, compiled, int64

LOOP = types.FunctionType(int64(int64, int64))
loop_at = caller(LOOP)


@compiled(int64(int64, int64, VECTOR, INTEGERS), arrays=True)
def along(loop, address, ends, count):
    """Make the steps that end at given times [s] until a buffer is full, or all; a status code.

    loop: address of the compiled loop; address: of the run's state; count: one number, the steps so
    far. A step that is refused, or that the loop does not make, is the last.
    """
    s = state_at(address)
    run = loop_at(loop)
    code = status.RUNNING
    while code == status.RUNNING and count[0] < ends.size:
        steps, refused = s.steps, s.rejected
        s.end, s.step_size = ends[count[0]], math.inf
        code = run(address, 1)
        if s.rejected > refused or s.steps == steps:
            return code
        count[0] += 1
    return code
