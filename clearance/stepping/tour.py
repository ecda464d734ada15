"""The compiled walk through given times: outputs of a mechanism whose motion is prescribed, without any integration."""

import math

from clearance.stepping.types import MATRIX, VECTOR, compiled, float64, int64, kernel_at


@compiled(int64(int64, int64, int64, VECTOR, VECTOR, VECTOR, VECTOR, float64, MATRIX))
def tour(observe, commit, commits, times, y, par, work, longest, rows):
    """Fill a row for each time; returns how many have only finite values, those after the first other one are left.

    observe, commit: addresses of the kernels; commits: how many values an accepted place leaves for the next (0: none,
    commit is not called). Between two times the mechanism is followed in stretches of at most `longest` [s], so that
    what is solved by iteration stays on its branch.
    """
    look, keep = kernel_at(observe), kernel_at(commit)
    for i in range(times.size):
        if commits > 0 and i > 0:
            stretches = int(math.ceil(abs(times[i] - times[i - 1]) / longest))
            for k in range(1, stretches):
                keep(times[i - 1] + (times[i] - times[i - 1]) * k / stretches, y, par, work, work)
        look(times[i], y, par, work, rows[i])
        for value in rows[i]:
            if not math.isfinite(value):
                return i
        if commits > 0:
            keep(times[i], y, par, work, work)
    return times.size
