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
