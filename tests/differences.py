"""Slopes by central differences, which exact derivatives are compared with."""

from collections.abc import Callable

import numpy as np


def slopes(function: Callable, place, steps) -> np.ndarray:
    """d(function)/d(argument), the arguments along the last axis: (f(x + h) - f(x - h)) / 2 h.

    function: of the numbers of a place, to a number or an array; steps: h, one or one an argument.
    """
    place = np.asarray(place, dtype=float)
    columns = []
    for step in np.diag(np.broadcast_to(np.asarray(steps, dtype=float), place.shape)):
        ahead, behind = (np.array(function(*(place + way * step))) for way in (1.0, -1.0))
        columns.append((ahead - behind) / (2.0 * step.sum()))
    return np.stack(columns, axis=-1)


def answer(mechanism, role: str, y: np.ndarray, size: int | None = None, t: float = 0.0):
    """Numbers that a compiled kernel of a mechanism gives in a state."""
    out = np.zeros(size or len(mechanism.y0))
    mechanism.kernel(role)(t, y, mechanism.par, np.append(mechanism.work0, 0.0), out)
    return out


def jacobian_and_differences(mechanism, y: np.ndarray, t: float = 0.0):
    """The compiled derivative, its columns by the sizes of the states, and by differences of 1e-5
    of them.
    """
    n, scale = mechanism.size, mechanism.scale
    actual = answer(mechanism, "jacobian", y, n * n, t).reshape(n, n) * scale
    rest = y[n:]

    def rates(*shares):
        return answer(mechanism, "rhs", np.append(y[:n] + shares * scale[:n], rest), t=t)[:n]

    return actual, slopes(rates, np.zeros(n), 1e-5)
