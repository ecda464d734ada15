"""The compiled walk through given times: outputs of a mechanism whose motion is prescribed, without any integration."""

import math

from clearance.stepping.types import INTEGERS, MATRIX, VECTOR, compiled, float64, inline, int64, kernel_at

#: change of a speed, over the speed, that its acceleration need not explain
JUMP = 0.5


@inline
def jumped(rows, i, places, step, slack):
    """Whether a position is not where its speed takes it, or a speed not where its acceleration does.

    Beside twice the way explained a position may move by `slack` [m], a speed by a share JUMP of itself.
    """
    for j in range(0, places.size, 3):
        at, speed, rate = places[j], places[j + 1], places[j + 2]
        before, now = rows[i - 1, speed], rows[i, speed]
        fast, gain = max(abs(before), abs(now)), max(abs(rows[i - 1, rate]), abs(rows[i, rate]))
        if abs(rows[i, at] - rows[i - 1, at]) > 2.0 * step * fast + slack:
            return True
        if abs(now - before) > 2.0 * step * gain + JUMP * fast:
            return True
    return False


@compiled(int64(int64, int64, int64, VECTOR, VECTOR, VECTOR, VECTOR, float64, INTEGERS, float64, MATRIX))
def tour(observe, commit, commits, times, y, par, work, longest, places, slack, rows):
    """Fill a row for each time; returns how many are good: the next has values that are not finite, or a jump.

    observe, commit: addresses of the kernels; commits: how many values an accepted place leaves for the next (0: none,
    commit is not called). Between two times the mechanism is followed in stretches of at most `longest` [s], so that
    what is solved by iteration stays on its branch. places: columns of positions, speeds and accelerations, in turn;
    between times no further apart than three stretches they must not jump, as they do where a loop changes its branch.
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
        step = times[i] - times[i - 1] if i > 0 else math.inf
        if step <= 3.0 * longest and jumped(rows, i, places, step, slack):
            return i
        if commits > 0:
            keep(times[i], y, par, work, work)
    return times.size
