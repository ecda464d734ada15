"""Slopes by central differences, which exact derivatives are compared with."""

from collections.abc import Callable

import numpy as np


def slopes(function: Callable, point, steps) -> np.ndarray:
    """d(function)/d(argument), the arguments along the last axis: (f(x + h) - f(x - h)) / 2 h.

    function: of the numbers of a point, to a number or an array; steps: h, one or one an argument.
    """
    point = np.asarray(point, dtype=float)
    columns = []
    for step in np.diag(np.broadcast_to(np.asarray(steps, dtype=float), point.shape)):
        ahead, behind = (np.array(function(*(point + way * step).tolist())) for way in (1.0, -1.0))
        columns.append((ahead - behind) / (2.0 * step.sum()))
    return np.stack(columns, axis=-1)


def answer(mechanism, role: str, y: np.ndarray, size=None, t=0.0, work=None, kernel=None):
    """Numbers that a kernel of a mechanism gives in a state; compiled, unless given by `kernel`."""
    out, work = np.zeros(size or len(mechanism.y0)), mechanism.work0 if work is None else work
    (kernel or mechanism.kernel)(role)(t, y, mechanism.par, np.append(work, 0.0), out)
    return out


def jacobian_and_differences(mechanism, y: np.ndarray, step=1e-5, **at):
    """The derivative by its kernel, columns by the sizes of the states, and by differences of a
    share of these sizes.

    at: time, memory and kernels, as `answer` takes them.
    """
    n, scale = mechanism.size, mechanism.scale
    actual = answer(mechanism, "jacobian", y, n * n, **at).reshape(n, n) * scale

    def rates(*shares):
        moved = np.append(y[:n] + shares * scale[:n], y[n:])
        return answer(mechanism, "rhs", moved, **at)[:n]

    return actual, slopes(rates, np.zeros(n), step)
