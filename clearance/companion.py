"""Companions of a run: the same motion at another tolerance, in memory, from which the errors of
its numbers follow.

A run at tolerance r has a companion at 10 r. With M of the run and M' of the companion, the stated
error of a metric is

    e(M) = 2 max(|M - M'|, g |M|),
    g = geometric mean of |M - M'| / |M| over the extremes, or over the means,

and of a channel three times the largest difference at a sample over its range, of the trajectory
over the clearance. The difference of two runs is nearly the error of the looser one. The difference
of one scalar may be small by chance, for which g and the factor of 2 make up. The factor of 3 is
for pairs whose methods differ and err alike.

A film table is wrong by up to a known share of its force. Where there are tables, one more
companion has all of their forces larger by that share, a hundredth at least. The change of a
metric, scaled back, is its error of the table.

Validity: until trajectories part. Stated beside true errors: tests/benchmarks/errors.py.
"""

import logging
import math
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from clearance.elements.clearance_joint import ClearanceJoint
from clearance.errors import AUTO, TRAJECTORY, Error, Errors, ExtremeErrors, geometric_mean
from clearance.film.tabulated import Tabulated
from clearance.groups import error_groups
from clearance.mechanism.build import Mechanism
from clearance.metrics import Metric, Window, metrics, offsets
from clearance.observers import ChangesAgain
from clearance.options import Output
from clearance.recording import MemoryRecord, MemorySink
from clearance.results import Record, Result
from clearance.run import Run
from clearance.tracing.callback import Callback

LOG = logging.getLogger("clearance")
LOOSER = 10.0  # tolerance of a companion over that of its run
LOOSEST = 0.1  # tolerance of a run, at most
SAFETY = 2.0  # stated error of a number over the larger of difference and spread
THROUGHOUT = 3.0  # stated error of a trajectory or a channel over the largest difference
STRONGER = 0.01  # share by which a companion's film forces are larger than those of the tables
LARGEST = 20_000_000  # largest count of numbers of a run that is compared: they are held in memory
DEAR = 'a second run costs as much again, --error state (error="state") makes it'
MEMORY = "a film with a memory is first order in the step, whatever the tolerance"
ROOM = 2**22  # bytes that stated errors may add to a file
ROUNDING = 1e-9  # of the size of a channel: ranges below it are those of a constant
#: ends of the names of metrics that count, or are errors themselves: their relative errors have no
#: common size
COUNTS = (
    "period",
    "period_error",
    "settling_ratio",
    "impacts_per_turn",
    "impacts_per_second",
    "contact_fraction",
)

EXTREME, MEAN, COUNT = "extreme", "mean", "count"

#: metrics of a record by name
Summed = Callable[[Record], dict[str, Metric]]


class Parted(RuntimeError):
    """A companion did not come to its end; the message states why."""


def reason_without(run: Run, error: str | None, output: Output | None = None) -> str:
    """Reason for which the numbers of a run get no stated error; "" where they do.

    error: None, "auto" (where a second run is cheap) or "state" (also where it is dear).
    """
    mechanism, numbers = run.mechanism, run.span.samples * len(run.mechanism.layout.channels)
    checkpoints = output is not None and output.checkpoint is not None
    if error is None:
        return "none was requested"
    if any(j.impacts for j in mechanism.scene.clearance_joints):
        return "neighbouring trajectories may part at impacts"
    if mechanism.layout.remembering:
        return MEMORY
    if error == AUTO and any(isinstance(s, Callback) for s in mechanism.sources.values()):
        return f"its films are solved as the run goes: {DEAR}"
    if error == AUTO and checkpoints:
        return f"a run with checkpoints is a long one: {DEAR}"
    if checkpoints and output.channels is not None:
        return "a run with checkpoints keeps all that is compared in its file: leave out channels"
    if numbers > LARGEST:
        return f"the run has {numbers:.2g} numbers, and at most {LARGEST:.0g} are compared"
    return ""


@dataclass(frozen=True)
class Start:
    """Start of a run: its mechanism, its state, the work vector of its kernels, and how often its
    numbers had been changed.
    """

    mechanism: Mechanism
    y: np.ndarray
    work: np.ndarray
    changes: int

    @classmethod
    def of(cls, run: Run) -> "Start":
        """Of a run that has not begun."""
        state = run.state
        return cls(run.mechanism, state.y.copy(), state.work.copy(), len(run.changes))


def companion(run: Run, start: Start, rtol: float, times: float = 0.0) -> MemoryRecord:
    """The motion of a run from the same start at another tolerance. Changes of numbers during the
    run are made here at the same times.

    times: by how many times their errors film tables are stronger. Raises Parted where it fails.
    """
    mechanism = strengthened(start.mechanism, times)
    other = Run(mechanism, run.span, replace(run.solver, rtol=rtol))
    # nothing is integrated: other steps show how well extremes are located
    if not run.mechanism.size:
        other.state.longest_step /= math.sqrt(2.0)
    other.state.y[:], other.state.work[:] = start.y, start.work
    if changes := run.changes[start.changes :]:

        def strengthen(other: Run) -> None:
            other.take_mechanism(strengthened(other.mechanism, times))

        other.observers.append(ChangesAgain(changes, strengthen))
    record, failure = other.remembered(run.attributes())
    if failure is not None:
        raise Parted(f"the companion at rtol {rtol:g} failed {failure}")
    return record


def beside(run: Run, start: Start) -> tuple[float, MemoryRecord]:
    """A companion at ten times the tolerance, or where there is none at a tenth, and its tolerance.

    Raises Parted.
    """
    looser, tighter = LOOSER * run.solver.rtol, run.solver.rtol / LOOSER
    if looser > LOOSEST:
        return tighter, companion(run, start, tighter)
    try:
        return looser, companion(run, start, looser)
    except Parted:
        return tighter, companion(run, start, tighter)


def tables(mechanism: Mechanism) -> dict[ClearanceJoint, Tabulated]:
    """Film tables of a mechanism by joint."""
    return {j: s for j, s in mechanism.sources.items() if isinstance(s, Tabulated)}


def stronger(mechanism: Mechanism) -> float:
    """Times of their own errors by which film tables are made stronger; 0 without a table."""
    largest = max((t.error for t in tables(mechanism).values()), default=0.0)
    return max(STRONGER / largest, 1.0) if largest > 0.0 else 0.0


def strengthened(mechanism: Mechanism, times: float) -> Mechanism:
    """The mechanism with forces of its film tables that are larger by so many times their errors.

    Tables that several joints share are made stronger once.
    """
    if times == 0.0:
        return mechanism
    par = mechanism.par.copy()
    for joint, table in tables(mechanism).items():
        begin = int(par[mechanism.layout.parameters[f"{joint.key}/film/start"]])
        par[begin : begin + table.numbers.size] = table.stronger(1.0 + times * table.error)
    return replace(mechanism, par=par)


@dataclass(frozen=True)
class Pair:
    """A run, its companion, and where there are film tables one with stronger films, at the
    companion's tolerance.

    rtol: of the first two. times: how many times their own errors the tables of the third are
        stronger.
    """

    run: Record
    other: Record
    rtol: tuple[float, float]
    film: Record | None = None
    times: float = 1.0


def paired(run: Run, start: Start, main: Record) -> Pair:
    """A run that has come to its end beside its companions. Raises Parted where one fails."""
    rtol, other = beside(run, start)
    if not (times := stronger(start.mechanism)):
        return Pair(main, other, (run.solver.rtol, rtol))
    return Pair(main, other, (run.solver.rtol, rtol), companion(run, start, rtol, times), times)


def stated(
    pair: Pair, summed: Summed, settle: float | None, size: float | None, apart: float = 1.0
) -> Errors:
    """Errors of a run's numbers from a pair.

    summed: its metrics; settle: turns left out of them; size: of the mechanism [m], None where
        nothing is integrated;
    apart: what their difference is over that of a run and its companion at ten times the tolerance.
    """
    window = Window.of(pair.run, settle)
    begin, end = (0.0, math.inf) if window is None else window.bounds(pair.run)
    numbers = _numbers(pair, summed, begin, end)
    g = {kind: spread(n for n in numbers.values() if n.kind == kind) for kind in (EXTREME, MEAN)}
    rows = {}
    for name, n in numbers.items():
        difference = max(abs(n.value - n.other), g.get(n.kind, 0.0) * abs(n.value))
        off = abs(n.film - n.other) / pair.times
        rows[name] = Error(n.value, SAFETY / apart * difference, n.units, film=off)
    if size is not None:
        film = 0.0 if pair.film is None else distance(pair.other, pair.film, size) / pair.times
        rows[TRAJECTORY] = Error(
            0.0, THROUGHOUT / apart * distance(pair.run, pair.other, size), film=film
        )
    along = {
        path: THROUGHOUT / apart * share for path, share in channels(pair.run, pair.other).items()
    }
    stretches = extremes(pair, g[EXTREME], SAFETY / apart)
    return Errors(rows, along, "", pair.rtol, g[EXTREME], begin, end, stretches)


@dataclass(frozen=True)
class Number:
    """A number of a run, of its companion and of that with stronger films; kind: EXTREME, MEAN or
    COUNT.
    """

    value: float
    other: float
    film: float
    units: str
    kind: str


def _numbers(pair: Pair, summed: Summed, begin: float, end: float) -> dict[str, Number]:
    """Metrics and located extremes by name, those that are finite."""
    film = pair.other if pair.film is None else pair.film
    mine, others, films = (summed(record) for record in (pair.run, pair.other, film))
    numbers = {}
    for name, m in mine.items():
        if name in others and name in films:
            numbers[name] = Number(
                m.value, others[name].value, films[name].value, m.units, _kind(name)
            )
    located = pair.run.located
    for name, units in zip(located.names, located.units, strict=True):
        three = [record.located.of(name, begin, end) for record in (pair.run, pair.other, film)]
        if all(three):
            numbers[name] = Number(*(extreme.value for extreme in three), units, EXTREME)
    return {name: n for name, n in numbers.items() if np.isfinite([n.value, n.other, n.film]).all()}


def _kind(metric: str) -> str:
    """Kind of a metric by its name."""
    if metric.endswith(COUNTS):
        return COUNT
    return EXTREME if metric.endswith(("_max", "_min")) else MEAN


def spread(numbers: Iterable[Number]) -> float:
    """Geometric mean of the relative differences of numbers; those that agree to the last digit
    left out.
    """
    shares = [
        abs(n.value - n.other) / abs(n.value) for n in numbers if n.value not in (0.0, n.other)
    ]
    return geometric_mean(shares)


def extremes(pair: Pair, g: float, safety: float) -> ExtremeErrors:
    """Stated errors of the located extremes, stretch by stretch."""
    value = pair.run.located.values
    other = _fitted(pair.other.located.values, len(value))
    film = other if pair.film is None else _fitted(pair.film.located.values, len(value))
    with np.errstate(invalid="ignore"):  # stretches that were not reached hold infinite values
        bound = safety * np.maximum(np.abs(value - other), g * np.abs(value))
        off = np.abs(film - other) / pair.times
    return ExtremeErrors(
        np.where(np.isfinite(bound), bound, 0.0), np.where(np.isfinite(off), off, 0.0)
    )


def _fitted(values: np.ndarray, count: int) -> np.ndarray:
    """So many stretches of another run, whose last may not be there: its length may differ."""
    missing = np.full((max(count - len(values), 0), values.shape[1]), np.inf)
    return np.concatenate([values, missing])[:count]


def channels(one: Record, other: Record) -> dict[str, float]:
    """Largest difference at a sample over the range, of each channel."""
    columns = {}
    for path in paths(other):  # in memory: nothing but channels
        if path == "energy/residual":  # an error itself
            continue
        a, b = one.values(path), other.values(path)
        size = max(float(np.ptp(a)), ROUNDING * float(np.abs(a).max()))
        columns[path] = float(np.abs(a - b).max()) / size if size > 0.0 else 0.0
    return columns


def paths(record: Record, group: str = "") -> Iterator[str]:
    """Paths of the channels along time."""
    for name in record.names(group):
        path = f"{group}/{name}".strip("/")
        if record.names(path):
            yield from paths(record, path)
        elif name != "time":
            yield path


def distance(one: Record, other: Record, size: float) -> float:
    """Largest difference of trajectories: of offsets over the clearance, where there is none of
    angles [rad] and places over the size of the mechanism.
    """
    clear = [(path, c) for path, c in offsets(one) if path in one]
    units = {"x": size, "y": size, "theta": 1.0}
    sizes = clear or [(f"bodies/{b}/{c}", s) for b in one.names("bodies") for c, s in units.items()]
    return max(float(np.abs(one.values(p) - other.values(p)).max()) / s for p, s in sizes)


class Statement:
    """Stated errors of a run that writes a file: what it puts out is remembered, compared, and
    added to the file. A run with checkpoints, which may have been killed on its way, is read from
    its file.

    pair: puts companions beside the record (default: the run from the same start).
    """

    def __init__(
        self,
        run: Run,
        settle: float | None = None,
        checkpoints: bool = False,
        pair: Callable[[Record], Pair] | None = None,
    ):
        self.run, self.settle = run, settle
        self.pair = pair or partial(paired, run, Start.of(run))
        memory = MemorySink(run.mechanism.layout.channels, run.attributes())
        self.memory = None if checkpoints else memory

    def remembering(self, sink):
        """A sink that also keeps what it is given here."""
        return sink if self.memory is None else Remembering(sink, self.memory)

    def add(self, sink) -> None:
        """Add the stated errors to the record of a sink that has ended; where there are none, a
        warning states why.
        """
        summed, size = partial(metrics, settle=self.settle), size_of(self.run.mechanism)
        try:
            with self._record(sink) as record:
                errors = stated(self.pair(record), summed, self.settle, size)
        except Parted as reason:
            errors = Errors(reason=str(reason))
        except KeyboardInterrupt as request:
            request.add_note(f"{sink.left}, without stated errors")
            raise
        add_errors(errors, sink)

    def _record(self, sink) -> AbstractContextManager[Record]:
        return Result(sink.path) if self.memory is None else nullcontext(self.memory.record)


def add_errors(errors: Errors, sink) -> None:
    """Add stated errors to a run that has ended; a warning where there is no room for them."""
    if not sink.has_room(ROOM):
        LOG.warning("%s has no stated errors: there is no room for them", sink.path)
        return
    sink.add(error_groups(errors))


def size_of(mechanism: Mechanism) -> float | None:
    """Size of a mechanism [m]; None where nothing is integrated."""
    return mechanism.start.size if mechanism.size else None


class Remembering:
    """A sink that keeps in memory what it hands on."""

    def __init__(self, sink, memory: MemorySink):
        self.sink, self.memory = sink, memory

    def __getattr__(self, name: str):
        return getattr(self.sink, name)

    def rows(self, times: np.ndarray, rows: np.ndarray) -> None:
        self.sink.rows(times, rows)
        self.memory.rows(times, rows)

    def impacts(self, joints: list[str], rows: np.ndarray, kind: str) -> None:
        self.sink.impacts(joints, rows, kind)
        self.memory.impacts(joints, rows, kind)

    def close(self, *summary) -> None:
        self.sink.close(*summary)
        self.memory.close(*summary)
