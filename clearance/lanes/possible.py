"""Points of a sweep without impossible values.

A clearance of zero at the edge of a map makes the scenes of some points impossible. Such points run
the ordinary way, which gives the reason. All others are as in a sweep without them.
"""

from collections.abc import Callable

import numpy as np

from clearance.values.algebra import Arrays


def possible(prepared: Callable[[dict], object], columns: Arrays) -> np.ndarray:
    """True for the points without an impossible value; it does not depend on their order.

    The values of each parameter are tried from both ends inwards, until one is possible. A value is
    impossible where its first, middle and last point are. Where this leaves less than half of the
    points, all are False. prepared: makes the scene of a point and all that it needs to run.
    """
    names = sorted(columns)
    order = np.lexsort([columns[name] for name in names])
    good = np.ones(len(order), dtype=bool)
    for name in names:
        for step in (1, -1):
            for value in np.unique(columns[name][good])[::step]:
                there = order[good[order] & (columns[name][order] == value)]
                trials = dict.fromkeys(there[[len(there) // 2, 0, -1]].tolist())
                if any(_works(prepared, columns, index) for index in trials):
                    break
                good[there] = False
                if 2 * good.sum() < good.size:
                    return np.zeros_like(good)
    return good


def _works(prepared: Callable, columns: Arrays, index: int) -> bool:
    try:
        prepared({name: column[index].item() for name, column in columns.items()})
    except Exception:  # noqa: BLE001 - the ordinary way gives the reason
        return False
    return True
