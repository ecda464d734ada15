"""Smallest and largest values of a run: of its samples, and of the ends of all steps between them."""

import math

import numpy as np

STRETCHES = 100  # of a run that have extremes of their own, at most
ROUNDING = 1e-9  # share of a stretch that rounding may move its ends by


class Extremes:
    """Extremes of columns, stretch by stretch of a run, so that those of its first turns can be left out later.

    columns: how many; until: length of the run [s]; turn: of a turn [s], None where nothing turns. A stretch is a turn,
    several in runs of more than a hundred, a hundredth of a run without turns. lowest, highest: (stretches, columns).
    """

    def __init__(self, columns: int, until: float = math.inf, turn: float | None = None):
        self.length = until / STRETCHES if turn is None else min(turn * math.ceil(until / turn / STRETCHES), until)
        count = 1 if math.isinf(until) else max(math.ceil(until / self.length * (1.0 - ROUNDING)), 1)
        self.lowest, self.highest = np.full((count, columns), np.inf), np.full((count, columns), -np.inf)

    def add(self, times: np.ndarray, rows: np.ndarray) -> None:
        """Take in rows (n, columns) at growing times (n,) [s]."""
        at = np.minimum((times / self.length).astype(int), len(self.lowest) - 1)
        for i in range(at[0], at[-1] + 1) if at.size else ():
            mine = rows[np.searchsorted(at, i) : np.searchsorted(at, i + 1)]
            if len(mine):
                np.minimum(self.lowest[i], mine.min(axis=0), out=self.lowest[i])
                np.maximum(self.highest[i], mine.max(axis=0), out=self.highest[i])


def whole(length: float, count: int, begin: float, end: float) -> slice:
    """Which of `count` stretches, each `length` long, lie whole between two times [s]."""
    if math.isinf(length):
        return slice(0, count if begin <= 0.0 and math.isinf(end) else 0)
    first = math.ceil(max(begin, 0.0) / length * (1.0 - ROUNDING))
    last = count if math.isinf(end) else math.floor(end / length * (1.0 + ROUNDING))
    return slice(first, max(first, min(last, count)))
