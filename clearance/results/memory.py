"""A run in memory: taken piece by piece, read as a record.

Samples of a long run go into a file of their own that has no name, and that ends with them.
"""

import math
import tempfile
import weakref
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import IO

import numpy as np

from clearance.results.extremes import Extreme, Extremes, Integrals
from clearance.results.record import Record

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


EVENT_COLUMNS = {
    "time": ("s", "start of the contact"),
    "impact_speed": ("m/s", "penetration rate at the start"),
    "peak_force": ("N", "largest normal contact force"),
    "peak_penetration": ("m", "largest penetration"),
    "duration": ("s", "duration of the contact"),
    "separation_speed": ("m/s", "speed of separation at the end"),
}
CONTACT_KINDS = ("contact", "open_contact")
SOLVER_COLUMNS = {
    "time": ("s", "end of the step"),
    "step": ("s", "step size"),
    "error_estimate": ("1", "estimated local error over tolerance"),
}


@dataclass(frozen=True)
class Ranges:
    """Smallest and largest samples of all channels, (channels,), located extremes and integrals
    over time where steps were made.
    """

    low: np.ndarray
    high: np.ndarray
    extremes: Extremes | None
    integrals: Integrals | None = None

    def of(self, channel: int) -> tuple[float, float]:
        """Smallest and largest sample of a channel."""
        return self.low[channel], self.high[channel]


class Memory:
    """A sink that keeps a run in memory: `record` once it has ended. logs: steps too."""

    ended: tuple | None = None  # status, facts of the solver, warnings, facts of groups, ranges

    def __init__(self, channels: list, attributes: dict, logs: bool = False):
        self.channels, self.attributes, self.logs = channels, attributes, logs
        self.pieces: list[tuple] = []
        self.samples = Samples(len(channels))

    def rows(self, times: np.ndarray, rows: np.ndarray) -> None:
        self._take("rows", times.copy(), rows)

    def impacts(self, joints: list[str], rows: np.ndarray, kind: str) -> None:
        self._take("impacts", joints, np.array(rows), kind)  # the run's own rows are used again

    def steps(self, log: np.ndarray) -> None:
        if self.logs:
            self._take("steps", np.array(log))

    def _take(self, kind: str, *piece) -> None:
        if kind == "rows":
            self.samples.append(*piece)
        else:
            self.pieces.append((kind, *piece))

    def flush(self) -> None:
        """Nothing waits to be written."""

    def close(self, *ended) -> None:
        """The end of the run: status, solver, warnings, facts, ranges."""
        self.ended = ended

    def hand_on(self, sink) -> None:
        """Give all pieces to another sink."""
        for times, rows in self.samples.blocks():
            sink.rows(times, rows)
        for kind, *piece in self.pieces:
            getattr(sink, kind)(*piece)

    def replay(self, sink) -> None:
        """Give a run that has ended to another sink."""
        self.hand_on(sink)
        sink.close(*self.ended)

    def _of(self, kind: str) -> list[list]:
        return [piece for name, *piece in self.pieces if name == kind]

    def contacts(self) -> dict[str, np.ndarray]:
        """Columns of the contacts."""
        taken = self._of("impacts")
        rows = np.concatenate([np.zeros((0, 1 + len(EVENT_COLUMNS))), *(r for _, r, _ in taken)])
        table = {n: rows[:, i] for i, n in enumerate(EVENT_COLUMNS, 1)}
        table["joint"] = np.array([j for joints, *_ in taken for j in joints], dtype=str)
        table["kind"] = np.array([k for joints, _, k in taken for _ in joints], dtype=str)
        return table

    def step_log(self) -> np.ndarray:
        """Rows of the steps."""
        taken = (log for (log,) in self._of("steps"))
        return np.concatenate([np.zeros((0, len(SOLVER_COLUMNS))), *taken])

    @cached_property
    def record(self) -> "MemoryRecord":
        """The run, once it has ended."""
        return MemoryRecord(self)


class MemoryRecord(Record):
    """A run in memory that has ended; reads like a `Result`."""

    def __init__(self, memory: Memory):
        status, self.solver, self.warnings, self._facts, ranges = memory.ended
        self.events, self.attributes = memory.contacts(), memory.attributes | {"status": status}
        self._samples_taken = memory.samples
        self.located, self.integrals = ranges and ranges.extremes, ranges and ranges.integrals
        self._channels_by_path, self._groups = places_of(tuple(memory.channels))

    def names(self, group: str) -> tuple[str, ...]:
        return self._groups.get(group, ())

    def values(self, path: str) -> np.ndarray:
        if path == "time":
            return self._times
        if path not in self._channels_by_path:
            raise self._without(path)
        return self._samples_taken.column(self._channels_by_path[path][0])

    @cached_property
    def _times(self) -> np.ndarray:
        return self._samples_taken.times

    @property
    def _samples(self) -> int:
        return self._samples_taken.count

    @cached_property
    def _between_times(self) -> dict[tuple, tuple]:
        """Parts cut, outermost extremes and their times, by begin and end."""
        return {}

    def extreme(self, name, begin=0.0, end=math.inf):
        """As of any record; what lies between two times is looked up once for all quantities."""
        if self.located is None or name not in self.located:
            return super().extreme(name, begin, end)
        if (begin, end) not in self._between_times:
            outermost = self.located.outermost(begin, end)
            self._between_times[begin, end] = self._cut(self.located, begin, end), *outermost
        cut, values, times = self._between_times[begin, end]
        column = self.located.columns[name]
        if cut or not math.isfinite(values[column]):
            return super().extreme(name, begin, end)
        return Extreme(float(values[column]), float(times[column]))

    def facts(self, group: str) -> dict:
        return self._facts.get(group, {})

    def units(self, path: str) -> str:
        return "s" if path == "time" else self._channels_by_path[path][1].units


@lru_cache(maxsize=16)
def places_of(channels: tuple) -> tuple[dict[str, tuple], dict[str, tuple[str, ...]]]:
    """Places and channels by their paths; names in each group. All records share them."""
    by_path = {c.path: (i, c) for i, c in enumerate(channels)}
    groups: dict[str, dict[str, None]] = {"": {"time": None}}
    for path in by_path:
        group, _, name = path.rpartition("/")
        groups.setdefault(group, {})[name] = None
        while group:
            parent, _, name = group.rpartition("/")
            groups.setdefault(parent, {})[name] = None
            group = parent
    return by_path, {group: tuple(names) for group, names in groups.items()}
