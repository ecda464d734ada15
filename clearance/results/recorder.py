"""Output of a run, piece by piece: made continuous, watched, and stored in a file or in memory.

A `Recorder` takes the pieces and hands them to one sink. A `Memory` holds them, reads as a
`MemoryRecord` in the end, and as a `ShortFile` writes its file in one piece. A `Stream` writes
pieces as they come (layout in result.py). Ranges and the energy ledger are those of all channels,
whichever a sink keeps. A `LedgerWatch` judges the energy ledger stretch by stretch.

Samples of a long run in memory go into a file of their own that has no name, and that ends with
them.
"""

import math
import tempfile
import weakref
from collections.abc import Callable, Iterator, Mapping
from functools import cache, cached_property, lru_cache
from typing import IO

import numpy as np

from clearance.elements.regimes import Regime
from clearance.results.extremes import JOINT_EXTREMES, Extremes, Integrals
from clearance.results.record import Record
from clearance.values.later import Later, Postponed

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
        self.file.seek(self._byte(sum(self.stored)))
        while self.held:
            times, rows = self.held[0]
            self.file.write(times.tobytes())
            self.file.write(np.ascontiguousarray(rows.T).data)
            self.file.flush()
            self.stored.append(len(times))
            del self.held[0]

    def _byte(self, rows: int) -> int:
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
            self._read(self._byte(at) + 8 * line * rows, values[at : at + rows])
            at += rows
        values[at:] = behind[0] if behind else ()
        return values

    def _read(self, offset: int, values: np.ndarray) -> None:
        self.file.seek(offset)
        self.file.readinto(values.data)

    def blocks(self) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Times and rows, piece by piece."""
        at = 0
        for rows in self.stored:
            block = np.empty((1 + self.width, rows))
            self._read(self._byte(at), block.reshape(-1))
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


class Ranges(Postponed):
    """Smallest and largest samples of all channels, (channels,), located extremes and integrals
    over time where steps were made.

    make: makes low, high, extremes and integrals, where somebody looks at one of them.
    """

    @property
    def extremes(self) -> Extremes | None:
        return self._content[2]

    @property
    def integrals(self) -> Integrals | None:
        return self._content[3]

    def of(self, channel: int) -> tuple[float, float]:
        """Smallest and largest sample of a channel."""
        low, high, *_ = self._content
        return low[channel], high[channel]


class Memory:
    """A sink that keeps a run in memory: `record` once it has ended. logs: steps too."""

    ended: tuple | None = None  # status, facts of the solver, warnings, facts of groups, ranges

    def __init__(self, channels: list, attributes: Mapping, logs: bool = False):
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
        status, solver, self.warnings, self._facts, ranges = memory.ended
        self.solver = dict(solver)
        self.events, self.attributes = memory.contacts(), {**memory.attributes, "status": status}
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
    def _cuts(self) -> dict[tuple, list]:
        """Parts cut, by begin and end."""
        return {}

    def extreme(self, name, begin=0.0, end=math.inf):
        """As of any record; what lies between two times is looked up once for all quantities."""
        located, between = self.located, (begin, end)
        if located is not None and name in located:
            if between not in self._cuts:
                self._cuts[between] = self._cut(located, begin, end)
            if not self._cuts[between] and (outermost := located.of(name, begin, end)):
                return outermost
        return super().extreme(name, begin, end)

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

    def start(self, time: float, energies: np.ndarray) -> None:
        """Take in the first row of all."""
        self.last = energies[:3]
        self.low, self.high = np.minimum(self.low, self.last), np.maximum(self.high, self.last)
        self.largest = max(self.largest, abs(float(energies[3])))
        self._begin(time, energies[3])

    def take(self, times: np.ndarray, energies: np.ndarray) -> None:
        """Append those of the rows that are finite."""
        finite = np.isfinite(energies).all(axis=1)
        self.add(times[finite], energies[finite])

    def add(self, times: np.ndarray, energies: np.ndarray) -> None:
        """Append rows of (kinetic energy, put in, taken out, residual) [J].

        Every stretch in which enough energy has been turned over is judged.
        """
        if not len(energies):
            return
        if self.last is None:
            self.start(times[0], energies[0])
        work, residual = energies[:, :3], energies[:, 3]
        self.low = np.minimum(self.low, work.min(axis=0))
        self.high = np.maximum(self.high, work.max(axis=0))
        self.largest = max(self.largest, float(np.abs(residual).max()))
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


class Summary:
    """Ranges and sums of samples, and the energy turned over: for summaries without reading the
    record.

    kinetic: channel of the kinetic energy; work: channels of what is put in and taken out.
    """

    def __init__(self, width: int, kinetic: int | None, work: list[int]):
        self.low, self.high = np.full(width, np.inf), np.full(width, -np.inf)
        self.totals, self.rows, self.turned_over = np.zeros(width), 0, 0.0
        self._kinetic, self._work = kinetic, work

    def add(self, rows: np.ndarray, last: np.ndarray | None) -> None:
        """Take in rows; last: the row before them, where there is one."""
        self.low = np.minimum(self.low, rows.min(axis=0))
        self.high = np.maximum(self.high, rows.max(axis=0))
        self.totals, self.rows = self.totals + rows.sum(axis=0), self.rows + len(rows)
        if self._kinetic is not None:
            before = [] if last is None else [last[self._kinetic]]
            energies = np.concatenate([before, rows[:, self._kinetic]])
            self.turned_over += float(np.abs(np.diff(energies)).sum())

    def energy_scale(self) -> float:
        """The energy turned over so far: total variation of the kinetic energy, or what went in or
        was taken out.
        """
        return max([self.turned_over, *(float(self.high[i] - self.low[i]) for i in self._work)])


class Recorder:
    """Takes a run's output as it comes and hands it to a sink.

    The ledger starts at zero and is watched; ranges and totals are stored. stepped: the run makes
    steps, and the ledger is judged at their ends, for samples between them carry the error of the
    interpolation. Without steps there are only samples, and angles are made continuous from one to
    the next. floor: energy [J] below which the ledger means nothing. place: of each channel by its
    path, where the caller has it.

    The first piece of samples, and that of steps, wait until somebody reads their sums. A short run
    has no second one, and few read them.
    """

    def __init__(
        self,
        channels: list,
        sink,
        stepped: bool = False,
        floor: float = 0.0,
        index: dict[str, int] | None = None,
    ):
        self.channels, self.sink, self.stepped, self.floor = channels, sink, stepped, floor
        self.index = index or {c.path: i for i, c in enumerate(channels)}
        self.balance, self.kinetic = (
            self.index.get("energy/residual"),
            self.index.get("energy/kinetic"),
        )
        self.last: tuple[float, np.ndarray] | None = None
        self.zero = 0.0
        self.facts: dict[str, dict] = {}  # attributes of groups
        self.work = [
            self.index[p] for p in ("energy/input", "energy/dissipated") if p in self.index
        ]
        self.energies = [] if self.balance is None else [self.kinetic, *self.work, self.balance]
        # what summary and ledger have not taken in: rows; energies of the first, those of steps
        self._first_rows: np.ndarray | None = None
        self._waiting: list[tuple] = []

    @cached_property
    def _summary(self) -> Summary:
        return Summary(len(self.channels), self.kinetic, self.work)

    @property
    def summary(self) -> Summary:
        """Ranges and sums of the samples so far."""
        if self._first_rows is not None:
            rows, self._first_rows = self._first_rows, None
            self._summary.add(rows, None)
        return self._summary

    @cached_property
    def _ledger(self) -> LedgerWatch | None:
        return None if self.balance is None else LedgerWatch(self.floor)

    @property
    def ledger(self) -> LedgerWatch | None:
        """Watches the energy, where the run has a ledger."""
        waiting, self._waiting = self._waiting, []
        for take, *piece in waiting:
            take(self._ledger, *piece)
        return self._ledger

    @cached_property
    def angles(self) -> list[tuple[int, int]]:
        """Places of angles that are made continuous, and of their rates."""
        angles = ((i, c.path) for i, c in enumerate(self.channels) if c.wrapped)
        return [(i, self.index[path.replace("theta", "omega")]) for i, path in angles]

    def samples(self, times: np.ndarray, rows: np.ndarray) -> None:
        """Append output rows."""
        if not times.size:
            return
        rows = rows.copy()
        if not self.stepped:
            self._unwrap(times, rows)
        if self.balance is not None:
            if self.last is None:
                self.zero = rows[0, self.balance]
            rows[:, self.balance] -= self.zero
        self.sink.rows(times, rows)  # first: what it refuses is not part of the summary
        if self.last is None:
            self._first_rows = rows
        else:
            self.summary.add(rows, self.last[1])
        if self.energies and self.last is None:
            self._waiting.append((LedgerWatch.start, times[0], rows[0, self.energies]))
        if self.energies and not self.stepped:
            self.ledger.add(times, rows[:, self.energies])
        self.last = (times[-1], rows[-1].copy())

    def _unwrap(self, times: np.ndarray, rows: np.ndarray) -> None:
        at, table = times, rows
        if self.last is not None:
            at, table = np.append(self.last[0], times), np.vstack([self.last[1], rows])
        for angle, speed in self.angles:
            values, speeds = table[:, angle], table[:, speed]
            expected = np.diff(at) * 0.5 * (speeds[1:] + speeds[:-1])
            turns = np.round((np.diff(values) - expected) / (2.0 * np.pi))
            turned = np.concatenate([[0.0], np.cumsum(turns)]) * 2.0 * np.pi
            rows[:, angle] = (values - turned)[-len(times) :]

    def impacts(self, names: list[str], rows: np.ndarray, kind: str = "contact") -> None:
        """Append finished contacts: rows of (joint, time, impact speed, force, penetration,
        duration, separation).
        """
        if not len(rows):
            return
        self.sink.impacts([names[int(j)] for j in rows[:, 0]], rows, kind)

    def steps(self, log: np.ndarray) -> None:
        """Append steps: rows of (time at the end, step, error over tolerance, energies where there
        is a ledger), and what more is logged of them.
        """
        first = len(SOLVER_COLUMNS)
        self.sink.steps(log[:, :first])
        if self.energies and len(log):
            energies = log[:, first : first + len(self.energies)].copy()
            energies[:, -1] -= self.zero
            if len(self._waiting) == 1:
                self._waiting.append((LedgerWatch.take, log[:, 0].copy(), energies))
            else:
                self.ledger.take(log[:, 0], energies)

    def flush(self) -> None:
        self.sink.flush()

    def add_facts(self, group: str, **facts) -> None:
        """Attributes of a group, such as what a joint's film table errs by."""
        self.facts.setdefault(group, {}).update(facts)

    def know_regime(self, joint, regime: Regime) -> None:
        """Diagnostics of a lubricated joint as attributes of its group, with means of its film."""
        group = f"joints/{joint.name}"
        self.add_facts(group, **{n: value for n, value in vars(regime).items() if value < math.inf})
        means = {f"{group}/membership_{s}": f"share_{s}" for s in ("full_film", "mixed", "dry")}
        means[f"{group}/asperity_share"] = "mean_asperity_share"
        sums = self.summary
        self.add_facts(
            group,
            **{
                n: sums.totals[self.index[p]] / sums.rows
                for p, n in means.items()
                if p in self.index and sums.rows
            },
        )

    def residual_share(self, below: float = 0.0) -> float:
        """Largest share of the energy turned over in some stretch of the run that its residual
        moved by. A bound of it may stand for a share that is certainly not above `below`.
        """
        if len(self._waiting) == 2 and (bound := self._bound(below)) <= below:
            return float(bound)
        return max(self.ledger.worst, self.ledger.share()) if self.energies else 0.0

    def _bound(self, enough: float) -> float:
        """A bound of the residual share of the first pieces: a stretch turns over the range of the
        kinetic energy at least. enough: a bound as low as this needs no look at that.
        """
        (_, _, start), (_, _, energies) = self._waiting
        residual, kinetic = energies[:, -1], energies[:, 0]
        moved = max(residual.max(), start[-1]) - min(residual.min(), start[-1])
        scale = self.floor
        if not moved <= enough * scale:
            scale = max(scale, kinetic.max() - kinetic.min())
        return moved / scale if scale > 0.0 else math.inf

    def close(
        self,
        status: str,
        warnings: list[str],
        solver: Mapping,
        late: Callable[["Recorder"], tuple[Extremes | None, Integrals | None]] | None = None,
    ) -> None:
        """Finish: what is known of each group, then the status; the sink then gives the record its
        place.

        late: adds facts, and makes extremes and integrals, where somebody looks at them.
        """

        @cache
        def located() -> tuple[Extremes | None, Integrals | None]:
            extremes, integrals = late(self) if late else (None, None)
            if self.last is not None:
                for name, fact in JOINT_EXTREMES.items():
                    self._know_extremes(extremes, name, fact)
                self.add_facts("energy", turned_over=self.summary.energy_scale())
                if self.ledger is not None:
                    self.add_facts("energy", largest_residual=self.ledger.largest)
            return extremes, integrals

        def facts() -> dict[str, dict]:
            located()
            return self.facts

        ranges = None
        if self.last is not None:
            ranges = Ranges(lambda: (self.summary.low, self.summary.high, *located()))
        sink, self.sink = self.sink, None  # which holds this one from now on, for what is late
        sink.close(status, solver, warnings, Later(facts), ranges)

    def _know_extremes(self, extremes: Extremes | None, quantity: str, fact: str) -> None:
        """Extremes of the entire run as attributes of the joints, with their times."""
        for name in extremes.columns if extremes else ():
            group, _, its = name.rpartition("/")
            if its == quantity and f"{group}/force_x" in self.index and (at := extremes.of(name)):
                self.add_facts(group, **{fact: at.value, f"{fact}_time": at.time})
