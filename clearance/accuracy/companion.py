"""Companions of a run: the same motion at another tolerance, in memory, from which the errors of
its numbers follow.

A run at tolerance r has a companion at 10 r. With M of the run and M' of the companion, the stated
error of a metric is

    e(M) = 2 max(|M - M'|, g |M|),
    g = geometric mean of |M - M'| / |M| over the extremes, or over the means,

of an extreme the largest of all stretches that may have it. That of a channel is three times the
largest difference at a sample over its range, of the trajectory over the clearance. The
difference of two runs is nearly the error of the looser one. The difference of one scalar may be
small by chance, for which g and the factor of 2 make up. The factor of 3 is for pairs whose methods
differ and err alike.

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

from clearance.elements.joint import ClearanceJoint
from clearance.film.lookup import Tabulated
from clearance.machine.callback import Callback
from clearance.mechanism.build import Mechanism
from clearance.metrics.metrics import Metrics, Window, metrics, offsets
from clearance.results.errors import AUTO, TRAJECTORY, Error, Errors, ExtremeErrors, geometric_mean
from clearance.results.extremes import sign_of
from clearance.results.record import Record
from clearance.results.recorder import MemoryRecord
from clearance.results.result import Result
from clearance.results.tables import error_groups
from clearance.run.observers import ChangesAgain
from clearance.run.options import Output
from clearance.run.recording import attributes_of, remember_run
from clearance.run.run import Run

LOG = logging.getLogger("clearance")
LOOSER = 10.0  # tolerance of a companion over that of its run
LONGER = math.sqrt(2.0)  # longest step of a companion where no tolerance shortens those of its run
ALIKE = 0.1  # share by which the steps of two runs differ that are too much alike to be compared
LOOSEST = 0.1  # tolerance of a run, at most
SAFETY = 2.0  # stated error of a number over the larger of difference and spread
THROUGHOUT = 3.0  # stated error of a trajectory or a channel over the largest difference
STRONGER = 0.01  # share by which a companion's film forces are larger than those of the tables
LARGEST = 20_000_000  # largest count of numbers of a run that is compared: they are held in memory
DEAR = 'a second run costs as much again, --error state (error="state") makes it'
IMPACTS_PART = (
    "neighbouring trajectories may part at impacts; --error 1e-3 states them of the cheapest run "
    "that has it, --steady 1e-6 of the periodic motion"
)
MEMORY = "a film with a memory is first order in the step, whatever the tolerance"
TOGETHER = 2**17  # samples of channels that are compared at once
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

#: numbers of runs by name: those of the runs, of their companions, and of the companions with
#: stronger films; the last axis, where there is one, goes over the runs
Numbers = dict[str, np.ndarray]
#: metrics of a record by name
Summed = Callable[[Record], Metrics]


class CompanionFailed(RuntimeError):
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
        return IMPACTS_PART
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


def companion(
    run: Run, start: Start, rtol: float, times: float = 0.0, longer: float = 1.0
) -> MemoryRecord:
    """The motion of a run from the same start at another tolerance. Changes of numbers during the
    run are made here at the same times.

    times: by how many times their errors film tables are stronger. longer: longest step over that
    of the run. Raises CompanionFailed where it fails.
    """
    mechanism = strengthened(start.mechanism, times)
    second = Run(mechanism, run.span, replace(run.solver, rtol=rtol))
    second.warned = False  # they are those of the run
    # nothing is integrated: other steps show how well extremes are located
    second.state.longest_step *= longer if run.mechanism.size else 1.0 / LONGER
    second.state.y[:], second.state.work[:] = start.y, start.work
    if changes := run.changes[start.changes :]:

        def strengthen(second: Run) -> None:
            second.take_mechanism(strengthened(second.mechanism, times))

        second.observers.append(ChangesAgain(changes, strengthen))
    return recorded(second, rtol, attributes_of(run))


def recorded(run: Run, rtol: float, attributes: dict | None = None) -> MemoryRecord:
    """The record of a companion. Raises CompanionFailed where its run ends early."""
    record, failure = remember_run(run, attributes)
    if failure is not None:
        raise CompanionFailed(f"the companion at rtol {rtol:g} failed {failure}")
    return record


def companion_rtol(rtol: float) -> float:
    """Tolerance of the companion of a run: ten times its own, or a tenth where that is too much."""
    return LOOSER * rtol if LOOSER * rtol <= LOOSEST else rtol / LOOSER


def beside(run: Run, start: Start) -> tuple[float, MemoryRecord]:
    """A companion at ten times the tolerance, or where there is none at a tenth, and its tolerance.

    Raises CompanionFailed.
    """
    rtol, tighter = companion_rtol(run.solver.rtol), run.solver.rtol / LOOSER
    try:
        return rtol, companion(run, start, rtol)
    except CompanionFailed:
        if rtol == tighter:
            raise
        return tighter, companion(run, start, tighter)


def step_alike(first: Record, second: Record) -> bool:
    """True for runs of about as many steps: hardly any was shortened by the tolerance, and their
    difference shows too little of their errors.
    """
    steps = float(first.solver["steps"])
    return abs(float(second.solver["steps"]) - steps) <= ALIKE * steps


def tables(mechanism: Mechanism) -> dict[ClearanceJoint, Tabulated]:
    """Film tables of a mechanism by joint."""
    return {j: s for j, s in mechanism.sources.items() if isinstance(s, Tabulated)}


def film_factor(sources: Iterable[Tabulated]) -> float:
    """Times of their own errors by which film tables are made stronger; 0 without a table."""
    largest = max((t.error for t in sources), default=0.0)
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
    """A run that has ended beside its companions. Raises CompanionFailed where one fails."""
    rtol, second = beside(run, start)
    longer = LONGER if step_alike(main, second) else 1.0
    if longer > 1.0:
        second = companion(run, start, rtol, longer=longer)
    second.scene = main.scene  # read once
    if not (times := film_factor(tables(start.mechanism).values())):
        return Pair(main, second, (run.solver.rtol, rtol))
    film = companion(run, start, rtol, times, longer)
    film.scene = main.scene
    return Pair(main, second, (run.solver.rtol, rtol), film, times)


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
    numbers, units = _numbers(pair, summed, begin, end)
    g, rows = spreads(numbers), {}
    for name, (by, film) in differences(numbers, g, pair.times).items():
        value = float(numbers[name][0])
        rows[name] = Error(value, SAFETY / apart * float(by), units[name], film=float(film))
    if size is not None:
        film = 0.0 if pair.film is None else distance(pair.other, pair.film, size) / pair.times
        rows[TRAJECTORY] = Error(
            0.0, THROUGHOUT / apart * distance(pair.run, pair.other, size), film=film
        )
    along = {
        path: THROUGHOUT / apart * share for path, share in channels(pair.run, pair.other).items()
    }
    common = float(g[EXTREME])
    stretches = extremes(pair, common, SAFETY / apart)
    for name, bound in _of_rivals(pair.run, stretches, begin, end).items():
        if name in rows and bound > rows[name].stated:
            rows[name] = replace(rows[name], stated=bound)
    return Errors(rows, along, "", pair.rtol, common, begin, end, stretches)


def _numbers(
    pair: Pair, summed: Summed, begin: float, end: float
) -> tuple[Numbers, dict[str, str]]:
    """Metrics and located extremes by name, those that are finite, and their units."""
    records = pair.run, pair.other, pair.other if pair.film is None else pair.film
    parts = [summed(record) for record in records]
    values = {n: [p[n].value for p in parts] for n in parts[0] if all(n in p for p in parts)}
    units = {name: metric.units for name, metric in parts[0].items()}
    located, outer = pair.run.located, [_outermost(record, begin, end) for record in records]
    values |= {n: [row[n] for row in outer] for n in located.names}
    units |= dict(zip(located.names, located.units, strict=True))
    return {n: np.array(v) for n, v in values.items() if np.isfinite(v).all()}, units


def _outermost(record: Record, begin: float, end: float) -> dict[str, float]:
    """Extremes as the run prints them; infinite where none was located."""
    names, values = record.located.names, record.located.outermost(begin, end)[0]
    return {
        name: record.extreme(name, begin, end).value if math.isfinite(value) else math.inf
        for name, value in zip(names, values.tolist(), strict=True)
    }


def kind_of(name: str) -> str:
    """Kind of a number by its name: EXTREME, MEAN or COUNT."""
    if name.endswith(COUNTS):
        return COUNT
    return EXTREME if name.endswith(("_max", "_min")) else MEAN


def spreads(numbers: Numbers) -> dict[str, np.ndarray]:
    """Geometric means of the relative differences of the extremes and of the means; those that
    agree to the last digit, or are not finite, left out.
    """
    shares: dict[str, list] = {EXTREME: [], MEAN: [], COUNT: []}
    with np.errstate(divide="ignore", invalid="ignore"):
        for name, (value, second, film) in numbers.items():
            share = np.abs(value - second) / np.abs(value)
            shares[kind_of(name)].append(np.where(np.isfinite(film), share, np.nan))
    return {kind: geometric_mean(shares[kind]) for kind in (EXTREME, MEAN)}


def differences(
    numbers: Numbers, g: dict[str, np.ndarray], times: float | np.ndarray
) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Of each number max(|M - M'|, g |M|), and its change by the films.

    g: of `spreads`; times: by how many times their errors films are stronger.
    """
    errors = {}
    with np.errstate(invalid="ignore"):
        for name, (value, second, film) in numbers.items():
            common = g.get(kind_of(name), 0.0) * np.abs(value)
            errors[name] = np.maximum(np.abs(value - second), common), np.abs(film - second) / times
    return errors


def extremes(pair: Pair, g: float, safety: float) -> ExtremeErrors:
    """Stated errors of the located extremes, stretch by stretch."""
    value = pair.run.located.values
    second = _fitted(pair.other.located.values, len(value))
    film = second if pair.film is None else _fitted(pair.film.located.values, len(value))
    with np.errstate(invalid="ignore"):  # stretches that were not reached hold infinite values
        bound = safety * np.maximum(np.abs(value - second), g * np.abs(value))
        off = np.abs(film - second) / pair.times
    return ExtremeErrors(
        np.where(np.isfinite(bound), bound, 0.0), np.where(np.isfinite(off), off, 0.0)
    )


def _of_rivals(run: Record, errors: ExtremeErrors, begin: float, end: float) -> dict[str, float]:
    """Largest stated error of the stretches between two times whose extreme may be the outermost.

    Two runs may err alike in one stretch by chance, seldom in all that repeat it.
    """
    part = run.located.whole(begin, end)
    values, bounds = run.located.values[part], errors.stated[part]
    signs = np.array([*map(sign_of, run.located.names)])
    reached = np.where(np.isfinite(values), signs * values, -np.inf)
    if not len(reached):
        return {}
    rivals = reached + THROUGHOUT * bounds >= reached.max(axis=0)
    largest = np.where(rivals, bounds, 0.0).max(axis=0)
    return dict(zip(run.located.names, largest.tolist(), strict=True))


def _fitted(values: np.ndarray, count: int) -> np.ndarray:
    """So many stretches of another run, whose last may not be there: its length may differ."""
    missing = np.full((max(count - len(values), 0), values.shape[1]), np.inf)
    return np.concatenate([values, missing])[:count]


def channels(first: Record, second: Record) -> dict[str, float]:
    """Largest difference at a sample over the range, of each channel."""
    columns: dict[str, float] = {}
    # in memory: nothing but channels; the residual is an error itself
    names = [path for path in paths(second) if path != "energy/residual"]
    several = max(TOGETHER // first.time.size, 1)
    for begin in range(0, len(names), several):
        some = names[begin : begin + several]
        a, b = (np.stack([record.values(path) for path in some]) for record in (first, second))
        low, high = a.min(axis=1), a.max(axis=1)
        size = np.maximum(high - low, ROUNDING * np.maximum(-low, high))
        apart = np.abs(a - b).max(axis=1) / np.where(size > 0.0, size, np.inf)
        columns |= dict(zip(some, apart.tolist(), strict=True))
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
    """Stated errors of a run that writes a file: what its sink remembers is compared, and the
    errors are added to the file. A run with checkpoints, which may have been killed on its way, is
    read from its file.

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
        self.checkpoints = checkpoints

    def add(self, sink) -> None:
        """Add the stated errors to the record of a sink that has ended; where there are none, a
        warning states why.
        """
        summed, size = partial(metrics, settle=self.settle), size_of(self.run.mechanism)
        try:
            with self._record(sink) as record:
                errors = stated(self.pair(record), summed, self.settle, size)
        except CompanionFailed as reason:
            errors = Errors(reason=str(reason))
        except KeyboardInterrupt as request:
            request.add_note(f"{sink.remains}, without stated errors")
            raise
        add_errors(errors, sink)

    def _record(self, sink) -> AbstractContextManager[Record]:
        return Result(sink.path) if self.checkpoints else nullcontext(sink.record)


def add_errors(errors: Errors, sink) -> None:
    """Add stated errors to a run that has ended; a warning where there is no room for them."""
    if not sink.has_room(ROOM):
        LOG.warning("%s has no stated errors: there is no room for them", sink.path)
        return
    sink.add(error_groups(errors))


def size_of(mechanism: Mechanism) -> float | None:
    """Size of a mechanism [m]; None where nothing is integrated."""
    return mechanism.start.size if mechanism.size else None
