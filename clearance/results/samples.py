"""Samples of a run as they come: in memory, those of a long run in a file of their own that has no
name, and that ends with them.
"""

import tempfile
import weakref
from collections.abc import Iterator
from typing import IO

import numpy as np

ROOM = 1_000_000  # numbers that are held in memory


class Samples:
    """Times and rows of outputs, read column by column.

    width: numbers in a row.
    """

    def __init__(self, width: int):
        self.width, self.count = width, 0
        self.held: list[tuple[np.ndarray, np.ndarray]] = []  # times and rows, behind those stored
        self.stored: list[int] = []  # number of rows of each block of the file
        self.file: IO[bytes] | None = None
        self.refused = False  # there is no room for a file

    @classmethod
    def of(cls, times: np.ndarray, rows: np.ndarray) -> "Samples":
        """Samples that are there already."""
        samples = cls(rows.shape[1])
        samples.held, samples.count = [(times, rows)], len(times)
        return samples

    def append(self, times: np.ndarray, rows: np.ndarray) -> None:
        """Take in more of them."""
        self.held.append((times, rows))
        self.count += len(times)
        numbers = sum(len(t) for t, _ in self.held) * self.width
        if not self.refused and (self.file is not None or numbers > ROOM):
            try:
                self._store()
            except OSError:
                self.refused = True

    def _store(self) -> None:
        """Write what is held behind what is stored. A block has its times, then each column."""
        if self.file is None:
            self.file = tempfile.TemporaryFile()  # noqa: SIM115 - closed where nobody refers to it
            weakref.finalize(self, self.file.close)
        self.file.seek(self._place(sum(self.stored)))
        while self.held:
            times, rows = self.held[0]
            self.file.write(times.tobytes())
            self.file.write(np.ascontiguousarray(rows.T).data)
            self.file.flush()
            self.stored.append(len(times))
            del self.held[0]

    def _place(self, rows: int) -> int:
        """Byte behind so many rows."""
        return 8 * rows * (1 + self.width)

    @property
    def times(self) -> np.ndarray:
        """Times of all samples [s]."""
        return self._all(0)

    def column(self, number: int) -> np.ndarray:
        """All samples of an output."""
        return self._all(1 + number)

    def _all(self, line: int) -> np.ndarray:
        """A line of every block: its times, or a column."""
        if len(self.held) > 1:
            parts = zip(*self.held, strict=True)
            self.held = [tuple(np.concatenate(part) for part in parts)]
        behind = [times if line == 0 else rows[:, line - 1] for times, rows in self.held]
        if not self.stored and behind:
            return behind[0]
        values, at = np.empty(self.count), 0
        for rows in self.stored:
            self._read(self._place(at) + 8 * line * rows, values[at : at + rows])
            at += rows
        values[at:] = behind[0] if behind else ()
        return values

    def _read(self, place: int, values: np.ndarray) -> None:
        self.file.seek(place)
        self.file.readinto(values.data)

    def blocks(self) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Times and rows, piece by piece."""
        at = 0
        for rows in self.stored:
            block = np.empty((1 + self.width, rows))
            self._read(self._place(at), block.reshape(-1))
            yield block[0], block[1:].T
            at += rows
        yield from self.held
