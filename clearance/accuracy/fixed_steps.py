"""Runs on the steps of another run.

The steps of a run depend on its numbers by its error control, and jump as a number changes. On
given steps a run is a smooth map of its numbers, whose differences are free of that.
"""

import math
from collections.abc import Sequence

import numpy as np

from clearance.machine.store import address
from clearance.run.observers import Observer
from clearance.run.run import Run
from clearance.stepping import status

ALLOWANCE = 4.0  # of the error of a step, over that of the run whose steps these are


class Refused(RuntimeError):
    """A given step cannot be made: its error is too large, or its equations have no solution."""


class Ends(Observer):
    """Ends of the steps of a run [s]."""

    def __init__(self):
        self.times: list[float] = []

    def steps(self, log):
        """Keep them."""
        self.times += log[:, 0].tolist()


class Replay(Run):
    """A run on steps that end at given times.

    run: one that has not begun, with a method whose steps do not iterate: its start is taken; ends:
        times of the other run, of which `until` is the length [s]. They are stretched to the length
        of this one. Advancing raises Refused.
    """

    def __init__(self, run: Run, ends: Sequence[float], until: float):
        super().__init__(run.mechanism, run.span, run.solver)
        state, self.counts = self.state, np.zeros(1, dtype=np.int64)
        state.y[:], state.work[:] = run.state.y, run.state.work
        state.rtol, state.longest_step = ALLOWANCE * run.solver.rtol, math.inf
        self.ends = np.asarray(ends) * (run.span.until / until)
        self.ends[-1] = run.span.until

    def advance(self, until: float = math.inf) -> int:
        """Steps until a buffer is full, or all. A status code."""
        state = self.state
        from clearance.stepping.along import LOOP, along

        refused, loop = state.rejected, address(self.loop.run, LOOP)
        code = along(loop, state.address, self.ends, self.counts)
        count = int(self.counts[0])
        if state.rejected > refused:
            raise Refused(f"step {count} to t = {self.ends[count]:.9g} s")
        self._hand_over()
        if code in (status.RUNNING, status.DONE):
            return status.DONE if count == len(self.ends) else status.RUNNING
        return code


def halved(ends: Sequence[float]) -> np.ndarray:
    """Ends of steps of half the length."""
    ends = np.asarray(ends)
    return np.sort(np.concatenate([ends, 0.5 * (ends + np.concatenate([[0.0], ends[:-1]]))]))
