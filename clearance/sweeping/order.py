"""Order of the points: the longest first, so that no long run is left to the end alone.

The time of a run is estimated from its neighbours. Points far apart are tried first. Each time the
number of finished runs has doubled, the rest is sorted by the time of the nearest finished point.
"""

from collections import deque
from itertools import islice

import numpy as np

from clearance.sweeping.points import Points

FIRST = 8  # finished runs needed for a first guess
MOST = 2048  # finished points that a guess looks at
PAIRS = 1_000_000  # of points that are compared at a time


class Queue:
    """Points that wait to be run."""

    def __init__(self, points: Points, pending: list[int]):
        self.positions = _places(points)
        self.waiting = deque(shuffled(pending))
        self.wall: dict[int, float] = {}
        self.next_guess = FIRST

    def __len__(self) -> int:
        return len(self.waiting)

    def take(self) -> int:
        return self.waiting.popleft()

    def ahead(self, count: int) -> list[int]:
        """The next points, which stay here."""
        return list(islice(self.waiting, count))

    def put_back(self, index: int) -> None:
        self.waiting.append(index)

    def learn(self, index: int, wall: float) -> None:
        """A run has taken so long [s]."""
        self.wall[index] = wall
        if len(self.wall) >= self.next_guess and len(self.waiting) > 2:
            self.next_guess *= 2
            self._sort()

    def _sort(self) -> None:
        # by hand: the import of a tree of neighbours takes as long as many runs
        done, rest = np.array(list(self.wall)[-MOST:]), np.array(self.waiting)
        cost, guess = np.array([self.wall[i] for i in done]), np.empty(len(rest))
        pairs = len(rest) * len(done)
        for part in np.array_split(np.arange(len(rest)), max(pairs // PAIRS, 1)):
            apart = self.positions[rest[part], None] - self.positions[done]
            guess[part] = cost[(apart**2).sum(axis=2).argmin(axis=1)]
        self.waiting = deque(rest[np.argsort(-guess, kind="stable")].tolist())


def _places(points: Points) -> np.ndarray:
    """Points in a unit cube: numbers by their rank, texts apart from each other."""
    columns = [np.zeros(len(points))]
    for values in points.columns.values():
        distinct = sorted(set(values), key=lambda v: (isinstance(v, str), v))
        rank = {v: i for i, v in enumerate(distinct)}
        scale = (
            1.0 if any(isinstance(v, str) for v in distinct) else 1.0 / max(len(distinct) - 1, 1)
        )
        columns.append(np.array([rank[v] * scale for v in values]))
    return np.stack(columns, axis=1)


def shuffled(pending: list[int]) -> list[int]:
    """Early points lie far apart along every axis; always in the same order."""
    return np.random.default_rng(0).permutation(pending).tolist()
