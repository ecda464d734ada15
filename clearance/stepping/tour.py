"""The compiled walk through given times: outputs of a mechanism whose motion is prescribed, without
any integration.
"""

import math

from clearance.stepping.types import (
    INTEGERS,
    MATRIX,
    VECTOR,
    compiled,
    float64,
    inline,
    int64,
    kernel_at,
)

#: what need not be explained: of a way by speeds, over the mechanism's size; of a speed's change by
#: accelerations, over the speed
WAY, CHANGE = 0.05, 0.5


@inline
def put(source, i, target, k):
    """Copy a row without making an array."""
    for j in range(source.shape[1]):
        target[k, j] = source[i, j]


@inline
def jumped(pair, places, step, size):
    """True where a position is not where its speed takes it, or a speed not where its acceleration
    does.

    Beside twice what is explained a position may move by a share WAY of the size [m], a speed by
    CHANGE of itself.
    """
    for j in range(0, places.size, 3):
        at = places[j]
        speed = places[j + 1]
        rate = places[j + 2]
        before, now = pair[0, speed], pair[1, speed]
        fast = max(abs(before), abs(now))
        gain = max(abs(pair[0, rate]), abs(pair[1, rate]))
        if abs(pair[1, at] - pair[0, at]) > 2.0 * step * fast + WAY * size:
            return True
        if abs(now - before) > 2.0 * step * gain + CHANGE * fast:
            return True
    return False


@compiled(
    int64(
        int64,
        int64,
        int64,
        VECTOR,
        VECTOR,
        VECTOR,
        VECTOR,
        float64,
        INTEGERS,
        float64,
        MATRIX,
        MATRIX,
    ),
    arrays=True,
)
def tour(observe, commit, commits, times, y, par, work, longest, places, size, pair, rows):
    """Fill a row for each time; returns how many are good: the next has values that are not finite,
    or a jump.

    observe, commit: addresses of the kernels; commits: how many values an accepted place leaves for
    the next (0: none, commit is not called). Between two times the mechanism is followed in
    stretches of at most `longest` [s], so that what is solved by iteration stays on its branch.
    places: columns of positions, speeds and accelerations, in turn. They must not jump from one
    place to the next, as they do where a loop changes its branch; size: of the mechanism [m]; pair:
    two rows for these places.
    """
    look, keep = kernel_at(observe), kernel_at(commit)
    followed = commits > 0 or places.size > 0
    for i in range(times.size):
        way = times[i] - times[i - 1] if i > 0 else 0.0
        stretches = max(int(math.ceil(way / longest)), 1) if followed else 1
        for k in range(1, stretches + 1):
            last = k == stretches
            time = times[i] if last else times[i - 1] + way * k / stretches
            look(time, y, par, work, pair[1])
            for value in pair[1]:
                if not math.isfinite(value):
                    put(pair, 1, rows, i)
                    return i
            if i > 0 and jumped(pair, places, way / stretches, size):
                put(pair, 1, rows, i)
                return i
            put(pair, 1, pair, 0)
            if commits > 0:
                keep(time, y, par, work, work)
        put(pair, 1, rows, i)
    return times.size
