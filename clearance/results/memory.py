"""A run in memory: taken piece by piece, read as a record."""

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from clearance.results.extremes import Extreme, Extremes
from clearance.results.integrals import Integrals
from clearance.results.record import Record
from clearance.results.samples import Samples

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
        status, solver, warnings, facts, ranges = self.ended
        return MemoryRecord(
            self.channels,
            self.samples,
            self.contacts(),
            self.attributes | {"status": status},
            solver,
            warnings,
            facts,
            ranges and ranges.extremes,
            ranges and ranges.integrals,
        )


class MemoryRecord(Record):
    """A run in memory; reads like a `Result`."""

    def __init__(
        self,
        channels: list,
        samples: Samples,
        events: dict,
        attributes: dict,
        solver: dict,
        warnings: list[str],
        facts: dict,
        extremes: Extremes | None,
        integrals: Integrals | None = None,
    ):
        self.events, self.attributes, self.solver, self.warnings = (
            events,
            attributes,
            solver,
            warnings,
        )
        self._samples_taken, self._facts = samples, facts
        self.located, self.integrals = extremes, integrals
        self._channels_by_path, self._groups = places_of(tuple(channels))

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
