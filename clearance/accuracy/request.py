"""Requests for an error: the cheapest run whose stated errors are as small as requested, or why
there is none.

The ladder of tolerances begins with a pair at ten times the error and at the error. While a stated
error e is larger than the requested one, eps, the tolerance falls to r max(1e-3, 0.5 eps / e). The
run before is the companion of the next. Where the tolerances are k apart, its difference is that of
a companion at 10 r times 9 / (k - 1).
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from functools import partial

from clearance.accuracy.at_start import standing
from clearance.accuracy.companion import (
    LARGEST,
    LONGER,
    LOOSER,
    LOOSEST,
    MEMORY,
    CompanionFailed,
    Pair,
    Start,
    Summed,
    companion,
    film_factor,
    size_of,
    stated,
    step_alike,
    tables,
)
from clearance.metrics.metrics import metrics
from clearance.results.errors import TRAJECTORY, Error, Errors, share
from clearance.results.recorder import Memory, MemoryRecord
from clearance.run.interrupts import DeferredSignals
from clearance.run.recording import attributes_of, record_run
from clearance.run.run import Run
from clearance.values import checks
from clearance.values.spelling import alike

ALL, INTEGRATION = "all", "integration"
FIRST = 1e-3  # tolerance of the first run of a ladder, at most
TIGHTEST = 1e-13  # of the last, at least
# by which a tolerance falls at once, at most; while trajectories are apart
LARGEST_STEP, LOST_STEP = 1e-3, 1e-2
AIM = 0.5  # of the requested error, that the next tolerance aims at
# an error that falls by less than this over so many decades of the tolerance has a floor
FLOOR, DECADES = 3.0, 2.0
# tolerance from which on floors are looked for, and trajectories that are still apart will stay so
LOST = 1e-10
PARTED = 0.1  # of the clearance: trajectories this far apart have nothing to do with each other
#: patterns of the numbers that a run prints, and of those in their place at dry points of sweeps
PRINTED = ("joint_*_force_max", "joint_*_gap_min", "drive_*_torque_m??", "drive_*_force_m??")
PRINTED += ("joint_*_force_peak_mean", "drive_*_peak_mean")


@dataclass(frozen=True)
class Request:
    """Largest relative errors by name: of a metric or a located extreme, of the "trajectory" (over
    the clearance), of "all" numbers that a run prints. "integration" is all of them with the errors
    of film tables left aside.
    """

    asked: Mapping[str, float]

    @classmethod
    def of(cls, error: float | str | Mapping[str, float]) -> "Request":
        """From 1e-3, "1e-3", "5%", "joint_B_force_max=1e-4,trajectory=1e-5" or a mapping.

        Raises ValueError.
        """
        if isinstance(error, str):
            parts = [part.rpartition("=") for part in error.split(",")]
            names = [name.strip() or ALL for name, _, _ in parts]
            if twice := next((n for n in names if names.count(n) > 1), None):
                raise ValueError(
                    f"error: {error!r} requests twice {'all numbers' if twice == ALL else twice}"
                )
            error = {n: text for n, (_, _, text) in zip(names, parts, strict=True)}
        if not isinstance(error, Mapping):
            error = {ALL: error}
        if not error:
            raise ValueError("error: give a number, or numbers by name")
        asked = {str(n): checks.share(_field(str(n)), e) for n, e in error.items()}
        if large := next((n for n, e in asked.items() if e >= 1.0), None):
            raise ValueError(
                f"{_field(large)} must be less than 1, relative to its value; got {asked[large]:g}"
            )
        return cls(asked)

    def wanted(self, errors: Errors) -> Iterator[tuple[str, float, Error, bool]]:
        """Names, largest relative errors, stated errors, and whether film tables count.

        Raises ValueError for a name that the run does not have.
        """
        for name, eps in self.asked.items():
            if name in (ALL, INTEGRATION):
                yield from ((n, eps, errors[n], name == ALL) for n in printed(errors))
            else:
                self.check(errors)
                yield name, eps, errors[name], True

    def over(self, errors: Errors) -> tuple[tuple[float, str], tuple[float, str]]:
        """The worst of stated over requested errors with its name, and that of film tables."""
        worst, table = (0.0, ""), (0.0, "")
        for name, eps, error, with_film in self.wanted(errors):
            worst = max(worst, (relative(error.stated, error, name) / eps, name), key=_first)
            if with_film:
                table = max(table, (relative(error.film, error, name) / eps, name), key=_first)
        return worst, table

    def check(self, names: Iterable[str]) -> None:
        """Raises ValueError for a name that is not among those of a run."""
        for name in self.asked:
            if alike(name, names) not in names and name not in (ALL, INTEGRATION):
                raise ValueError(f"error: the run has no {name!r}{checks.meant(name, names)}")

    def of_name(self, name: str) -> float:
        """The error that is requested of a number."""
        others = self.asked.get(ALL, self.asked.get(INTEGRATION, math.inf))
        return self.asked.get(name, others)

    @property
    def films(self) -> bool:
        """True where the errors of film tables count."""
        return any(name != INTEGRATION for name in self.asked)

    def __str__(self) -> str:
        return ", ".join(f"{e:g}" if n == ALL else f"{n} {e:g}" for n, e in self.asked.items())


def _field(name: str) -> str:
    """The error of a name, in the words of a message."""
    return "error" if name == ALL else f"error of {name}"


def printed(errors: Mapping[str, Error]) -> list[str]:
    """Names of the numbers that a run prints; of a drive's efforts the larger."""
    names = [n for n in errors if any(fnmatchcase(n, pattern) for pattern in PRINTED)]
    return [
        n
        for n in names
        if abs(errors[n].value) >= max(abs(errors[m].value) for m in names if m[:-3] == n[:-3])
    ]


def names(run: Run, summed: Summed) -> set[str]:
    """Names that a request may have of a run that has not begun; summed: metrics of a record."""
    return {*summed(standing(run)), *run.extremes.names, TRAJECTORY}


@dataclass(frozen=True)
class Attempt:
    """A run of the ladder in memory, and why it ended early, None where it did not."""

    run: Run
    memory: Memory
    failure: str | None

    @property
    def record(self) -> MemoryRecord:
        return self.memory.record


@dataclass(frozen=True)
class Outcome:
    """Outcome of a request: the run, its errors beside the requested ones, and the reason where
    these were not reached.
    """

    attempt: Attempt
    errors: Errors
    cannot: str


class ToleranceSearch:
    """Runs at falling tolerances until the stated errors are small enough.

    run: made and not begun, at any tolerance; settle: turns left out of the metrics; summed:
        metrics of a record;
    progress: called with the done share of each run. best: the last run with stated errors. runs:
        their tolerances.
    Raises ValueError for a run that is too large to be held in memory.
    """

    def __init__(
        self,
        run: Run,
        request: Request,
        settle: float | None = None,
        summed: Summed | None = None,
        progress: Callable[[float], None] | None = None,
    ):
        if (numbers := run.span.samples * len(run.mechanism.layout.channels)) > LARGEST:
            raise ValueError(
                f"error: the run has {numbers:.2g} numbers, and at most {LARGEST:.0g} are compared"
            )
        self.run, self.request, self.settle, self.progress = run, request, settle, progress
        self.summed = summed or partial(metrics, settle=settle)
        self.start, self.best = Start.of(run), None
        self.film: tuple[MemoryRecord, MemoryRecord, float] | None = None
        self.film_rtol = math.inf
        self.runs: list[float] = []
        self.reached = ""  # the worst of the stated errors of the last run, in words
        # tolerances, and the worst of stated over requested errors
        self.past: list[tuple[float, float]] = []

    def climb(self) -> Outcome:
        """The answer."""
        if self.run.mechanism.layout.remembering:
            return self._unstated(self._attempt(self.run.solver.rtol), MEMORY)
        rtol = max(min(*self.request.asked.values(), FIRST), TIGHTEST)
        loose = self._companion(min(LOOSER * rtol, LOOSEST))
        while True:
            tight = self._attempt(rtol)
            if tight.failure is not None:
                return self._unstated(tight, f"the run at rtol {rtol:g} failed {tight.failure}")
            try:
                errors = self._errors(tight, rtol, loose)
            except CompanionFailed as reason:
                return self._unstated(tight, str(reason))
            verdict = self._verdict(errors, rtol)
            if verdict is not None:
                errors, verdict = self._closer(errors, verdict, rtol, loose)
            if verdict:  # a film is blamed by its part at the run's tolerance alone
                errors, verdict = self._closer(errors, verdict, rtol, (rtol, tight.record))
            cannot = verdict or ""
            self.best = Outcome(
                tight, replace(errors, asked=dict(self.request.asked), cannot=cannot), cannot
            )
            if verdict is not None:
                return self.best
            loose = rtol, tight.record
            rtol = max(rtol * self._fall(errors), TIGHTEST)

    def _fall(self, errors: Errors) -> float:
        """Share of the tolerance to go on at; parted trajectories give none."""
        if errors.trajectory > PARTED:
            return LOST_STEP
        return max(LARGEST_STEP, AIM / self.past[-1][1])

    def _companion(self, rtol: float) -> tuple[float, MemoryRecord] | None:
        """The first companion, and the one with stronger films; a tighter one where it fails, None
        where that does.
        """
        for tolerance in (rtol, rtol / LOOSER**2):
            try:
                self.runs.append(tolerance)
                second = companion(self.run, self.start, tolerance)
                if self.request.films and (times := self._film_factor()):
                    strong = companion(self.run, self.start, tolerance, times)
                    self.film, self.film_rtol = (second, strong, times), tolerance
                return tolerance, second
            except CompanionFailed:
                self.film = None
        return None

    def _film_factor(self) -> float:
        return film_factor(tables(self.run.mechanism).values())

    def _closer(
        self,
        errors: Errors,
        verdict: str | None,
        rtol: float,
        loose: tuple[float, MemoryRecord] | None,
    ) -> tuple[Errors, str | None]:
        """Errors and verdict with the films' part of another companion, if it is closer."""
        if not self._films_again(loose):
            return errors, verdict
        self.past.pop()
        errors = self._with_films(errors)
        return errors, self._verdict(errors, rtol)

    def _films_again(self, loose: tuple[float, MemoryRecord] | None) -> bool:
        """Make the films' part again, at the tolerance of the last companion; False where it stays.

        The difference that stronger films make drowns in the errors of two runs at a tolerance far
        above it.
        """
        if self.film is None or loose is None or loose[0] >= self.film_rtol:
            return False
        times = self._film_factor()
        try:
            self.film = loose[1], companion(self.run, self.start, loose[0], times), times
        except CompanionFailed:  # the part of the first companion stands
            return False
        self.film_rtol = loose[0]
        return True

    def _attempt(self, rtol: float) -> Attempt:
        run = Run(self.run.mechanism, self.run.span, replace(self.run.solver, rtol=rtol))
        run.state.y[:], run.state.work[:] = self.start.y, self.start.work
        self.runs.append(rtol)
        run.started, run.options = self.run.started, self.run.options
        output = Memory(run.mechanism.layout.channels, attributes_of(run), logs=True)
        with DeferredSignals() as held:
            failure = record_run(run, output, self.progress, check=held.check)
        return Attempt(run, output, failure)

    def _errors(
        self, tight: Attempt, rtol: float, loose: tuple[float, MemoryRecord] | None
    ) -> Errors:
        if loose is None:
            loose = rtol / LOOSER, companion(self.run, self.start, rtol / LOOSER)
        if step_alike(tight.record, loose[1]):
            loose = loose[0], companion(self.run, self.start, loose[0], longer=LONGER)
        pair, size = Pair(tight.record, loose[1], (rtol, loose[0])), size_of(self.run.mechanism)
        errors = stated(pair, self.summed, self.settle, size)
        apart = loose[0] / rtol
        # runs that have parted give nothing for tighter ones
        if apart > 1.0 and not errors.trajectory > PARTED:
            errors = stated(pair, self.summed, self.settle, size, (apart - 1.0) / (LOOSER - 1.0))
        return errors if self.film is None else self._with_films(errors)

    def _with_films(self, errors: Errors) -> Errors:
        """The errors with the parts of film tables, which are those of the first companion or of
        the last.
        """
        plain, strong, times = self.film
        pair = Pair(plain, plain, errors.rtol, strong, times)
        stronger = stated(pair, self.summed, self.settle, size_of(self.run.mechanism))
        rows = {
            n: replace(e, film=stronger.rows[n].film if n in stronger.rows else 0.0)
            for n, e in errors.rows.items()
        }
        return replace(
            errors, rows=rows, extremes=replace(errors.extremes, film=stronger.extremes.film)
        )

    def _verdict(self, errors: Errors, rtol: float) -> str | None:
        """None: go on; "": reached; else why it cannot be."""
        (worst, name), (part, table) = self.request.over(errors)
        self.past.append((rtol, worst))
        self.reached = (
            f"{worst * self.request.of_name(name):.1e} of {name} at rtol {rtol:g}" if name else ""
        )
        if part > 1.0 and worst <= part:
            return f"the film table alone makes {part * self.request.of_name(table):.1e} of {table}"
        if worst <= 1.0:
            return ""
        if errors.trajectory > PARTED:
            apart = (
                f"trajectories part, two runs are {errors.trajectory:.2g} of the clearance "
                "apart: see cl.statistics"
            )
            return apart if rtol <= LOST else None
        if self._stuck:
            return f"the error of {name} does not fall with the tolerance any more"
        return (
            f"{name} would need a tolerance below {TIGHTEST:g}: rounding"
            if rtol <= TIGHTEST
            else None
        )

    @property
    def _stuck(self) -> bool:
        """The worst error fell by less than FLOOR over DECADES of the tolerance."""
        rtol, worst = self.past[-1]
        before = [w for r, w in self.past if r >= rtol * 10.0**DECADES * (1.0 - 1e-9)]
        return rtol <= LOST and bool(before) and worst > before[-1] / FLOOR

    def _unstated(self, attempt: Attempt, reason: str) -> Outcome:
        """A run whose errors cannot be stated, and why."""
        return Outcome(attempt, Errors(reason=reason), reason)


def relative(part: float, error: Error, name: str) -> float:
    """A part of an error over the value; those of a trajectory are relative already."""
    return part if name == TRAJECTORY else share(part, error.value)


def _first(pair: tuple) -> float:
    return pair[0]
