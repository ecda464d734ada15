"""The energy ledger of a run, watched stretch by stretch."""

import numpy as np


class LedgerWatch:
    """Watches the energy residual stretch by stretch, so that a jump shows however long the run is.

    A stretch is long enough to turn over the range of the kinetic energy. In motions that hardly
    have any (a journal sinking in oil) a hundredth of the energy put in and taken out is enough.
    The least is `floor` [J], a thousand tolerances of the run. `worst` is the largest share of it
    that the residual moved by, `largest` the largest residual [J]. `since` is when the residual of
    the first stretch that lost the share `limit` had moved by so much. It stores sums and no
    rows, for a stretch may have millions.
    """

    limit = 0.05
    portion = 0.01  # of all energy put in or taken out so far that a stretch turns over at least

    def __init__(self, floor: float = 0.0):
        self.floor = floor
        self.worst, self.largest, self.since = 0.0, 0.0, None
        self.low, self.high = np.full(3, np.inf), np.full(3, -np.inf)  # kinetic, put in, taken out
        self.last: np.ndarray | None = None  # energies of the last row
        # of the stretch under way: its begin, the residual there, the energy turned over since, by
        # how much the residual moved at most, and when by the share `limit`
        self.begin = self.level = self.turned_over = self.moved = self.passed = 0.0

    def add(self, times: np.ndarray, energies: np.ndarray) -> None:
        """Append rows of (kinetic energy, put in, taken out, residual) [J].

        Every stretch in which enough energy has been turned over is judged.
        """
        if not len(energies):
            return
        work, residual = energies[:, :3], energies[:, 3]
        self.low = np.minimum(self.low, work.min(axis=0))
        self.high = np.maximum(self.high, work.max(axis=0))
        self.largest = max(self.largest, float(np.abs(residual).max()))
        if self.last is None:
            self.last = work[0]
            self._begin(times[0], residual[0])
        most, total, begin, base = self._most(), self._totals(work), 0, 0.0
        while total[-1] - base >= most > 0.0:
            enough = max(int(np.searchsorted(total, base + most)), begin)
            end = min(enough + 1, len(total))
            self._look(times[begin:end], residual[begin:end], most)
            self.worst = max(self.worst, self._share(float(total[end - 1]) - base))
            self._begin(times[end - 1], residual[end - 1])
            begin, base = end, float(total[end - 1])
        self._look(times[begin:], residual[begin:], most)
        self.turned_over = float(total[-1]) - base

    def _most(self) -> float:
        """Energy that a stretch turns over."""
        span = self.high - self.low
        return max(float(span[0]), self.portion * float(span[1:].max(initial=0.0)), self.floor)

    def _totals(self, work: np.ndarray) -> np.ndarray:
        """Energy turned over up to each row since the begin of the stretch under way."""
        steps = np.abs(np.diff(work, axis=0, prepend=self.last[None])).sum(axis=1)
        self.last = work[-1].copy()
        return np.cumsum(np.append(self.turned_over, steps))[1:]

    def _begin(self, time: float, residual: float) -> None:
        """Begin a stretch."""
        self.begin, self.level, self.moved = float(time), float(residual), 0.0

    def _look(self, times: np.ndarray, residual: np.ndarray, most: float) -> None:
        """Note by how much the residual moved in the stretch under way."""
        moved = np.abs(residual - self.level)
        if self.moved <= self.limit * most < moved.max(initial=0.0):
            self.passed = float(times[np.argmax(moved > self.limit * most)])
        self.moved = float(moved.max(initial=self.moved))

    def _share(self, scale: float) -> float:
        """Share of an energy that the residual of the stretch under way moved by."""
        if self.since is None and self.moved > self.limit * scale:
            self.since = self.passed
        return self.moved / scale

    def share(self) -> float:
        """Share of the stretch under way, against at least what a stretch turns over."""
        scale = max(self.turned_over, self._most()) if self.last is not None else 0.0
        return self._share(scale) if scale > 0.0 else 0.0
