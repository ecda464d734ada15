"""Parameters of a mechanism from its records, by least squares on the dense output of its runs.

    r_i = (y_i - g Y(x_i + s, a; p) - o) / sigma        p: parameters; s, o, g, a: of a record

Y is a channel of the run, between its samples by cubics, as a sensor has it that is mounted at an
angle a; sigma the error of a value. Positive
parameters are searched for in their logarithms, within their bounds, by a trust region (scipy)
with the slopes of runs that make the same steps (`accuracy.by_differences.Steps`). Shift s, offset
o, gain g and angle a of a record are fitted beside them where that is requested. Records of x and y
of one place have one angle. Where sigma is not known it
is that of the residuals. Several starts: Sobol' points between the bounds; the best of them are
followed to the end.

Validity: trajectories that go on with their parameters. Where contact starts with a touch they part
after a few impacts: a record that goes on after that is fitted up to the place, and refused where
that is at its start.

Source: Nocedal and Wright, Numerical Optimization (2006), chapter 10; Seber and Wild, Nonlinear
Regression (2003), chapters 2 and 5.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from clearance.accuracy.by_differences import (
    WIDTH,
    Impossible,
    Steps,
    method_beside,
    reason_without,
    recorded,
)
from clearance.accuracy.fixed_steps import Refused
from clearance.identify.estimation import least
from clearance.identify.free import NO_RUN, Beside, Free, Varying
from clearance.identify.measured import Measured, parts_of
from clearance.metrics.sensor import crossed, filtered, turned
from clearance.results.record import cubic
from clearance.results.recorder import MemoryRecord
from clearance.run.run import Run
from clearance.scene.scene import Scene
from clearance.values import checks

RTOL, LEADING_RTOL = 1e-7, 1e-5  # of the runs, and of those of starts
RTOL_APART = 1e-12  # of runs that make steps of their own
APART = 1e-7  # of their differences, over the size of the parameter
FEWEST = 5  # values of a record before its horizon, over the number of coordinates
PARTED = 0.05  # change of slopes with the width of their differences, from which runs have parted
# relative changes of the cost at which the first parts of records, a start, an end and the best end
# are left
LEADING, STARTING, FINISH, LAST = 1e-3, 1e-4, 1e-6, 1e-8
NO_STEP = 0.2  # the same of a start, over the number of residuals: the square of a deviation
REFUSED = 4.0  # costs over the least, from which an end is no rival
WEAK = 1e-6  # of singular values of slopes: directions that the linear step leaves
NEAR = 0.02  # of the bounds: starts that end so near to each other may have one end
MOST, MOST_LEADING = 100, 12  # evaluations of one start, and of a first part
LOOKED = 32  # points between the bounds at which the cost is looked at
SETTLE = 2.0  # turns before a record, where nothing else is requested
SAMPLES = 720  # of a turn, at least; between them by cubics
# of a record where nothing turns, by which it may be shifted; before its start a run has its first
ROOM = 0.1  # values
LENGTH = 2000  # samples of a record where nothing turns, at least
ROUNDING = 1e-9  # of a number of samples
PLACES = 256  # of a shift that is looked for over one turn
FIRST, EARLY = 0.1, 0.05  # of records, and of a turn: first parts that lead to all of them
GROWTH = 1.5  # of these parts
ROUNDS = 3  # of weights from residuals, where several records have unknown errors
BOTH, BESIDE = (-1, 1), (0, 1)  # places of runs that slopes are taken from, and those of a search
SHIFT, OFFSET, GAIN, MOUNTING = NUISANCES = ("shift", "offset", "gain", "mounting")
STILL = dict.fromkeys(NUISANCES, 0.0) | {GAIN: 1.0}  # they change nothing
NUDGE = 1e-4  # of a nuisance for slopes, at most [s, 1, rad]


@dataclass(frozen=True)
class Curve:
    """A record beside a channel.

    channel: path, such as "bodies/slider/ax"; sigma: standard deviation of a value's error, None
    where it is not known; nuisances: of NUISANCES, those that are fitted; lowpass: order and corner
    [Hz] of the Butterworth filter that the sensor has; changes: parameters that hold for this
    record alone, such as its speed.
    """

    measured: Measured
    channel: str
    sigma: float | None = None
    nuisances: tuple[str, ...] = ()
    lowpass: tuple[int, float] | None = None
    changes: Mapping[str, object] = field(default_factory=dict)

    @property
    def label(self) -> str:
        """The file and its column."""
        return f"{self.measured.path.name}, {self.measured.column}"


class NotFollowed(ValueError):
    """No trajectory follows the records: neighbouring ones part before, or no start led to one."""


class _Apart:
    """Runs of a point and of those beside it that make steps of their own, as `Steps` gives them.

    Contact starts with a touch, whose time moves with a parameter: no step can be given.
    """

    def __init__(self, beside: Beside, run: Run):
        self.beside, self.span = beside, run.span
        self.record = recorded(run)

    def around(self, number: Free, offsets: Sequence[int]) -> dict[int, MemoryRecord]:
        """Records by offset, in widths. Raises Impossible."""
        options = {"until": self.span.until, "samples": self.span.samples, "rtol": RTOL_APART}
        scenes = {n: self.beside.scene_at(number, n) for n in offsets}
        return {n: recorded(self.beside.prepared(s, **options)) for n, s in scenes.items()}


@dataclass(frozen=True)
class _Group:
    """Curves of one run.

    method: of runs with steps of another; shares: ends of given steps, over the length of the run.
    """

    changes: Mapping[str, object]
    curves: tuple[int, ...]
    method: str = "auto"
    shares: np.ndarray | None = None


class Problem(Varying):
    """Residuals of records and their slopes.

    scene: of the runs; free: its fitted parameters; curves: records; settle: turns [s where nothing
        turns] of a run before its records begin. reason: why the last point that was refused was.
    Coordinates are those of the parameters, then the nuisances of each curve. Raises ValueError for
    a scene that cannot be fitted, and for records in another unit.
    """

    def __init__(
        self,
        scene: Scene,
        free: Sequence[Free],
        curves: Sequence[Curve],
        settle: float | None = None,
    ):
        super().__init__(scene, free)
        if not self.free or not curves:
            raise ValueError("fit needs at least one parameter and one record")
        self.turn = scene.turn
        self.turns = [self.scene_of(self.inside, c.changes).turn for c in curves]
        self.settle = (SETTLE if self.turn else 0.0) if settle is None else settle
        self.curves = list(curves)
        changes = [c.changes for c in self.curves]
        self.groups = [
            _Group(here, tuple(i for i, c in enumerate(changes) if c == here))
            for n, here in enumerate(changes)
            if here not in changes[:n]
        ]
        self.sigma = [c.sigma or float(np.std(c.measured.values)) or 1.0 for c in self.curves]
        self.scales = list(self.sigma)  # of the offsets
        self.nuisances: list[tuple[int, str]] = []
        self.column: dict[tuple[int, str], int] = {}  # of a curve and its nuisance, among x
        columns: dict[tuple, int] = {}
        for i, name in [(i, n) for i, c in enumerate(self.curves) for n in c.nuisances]:
            about = self.curves[i]  # one sensor has x and y of one file and channel
            key = (about.measured.path, about.channel[:-1]) if name == MOUNTING else (i, name)
            if key not in columns:
                columns[key] = len(self.free) + len(columns)
                self.nuisances.append((i, name))
            self.column[i, name] = columns[key]
        if self.size < len(self.names) + (not self.stated):
            numbers = f"{len(self.names)} numbers{' and their noise' * (not self.stated)}"
            raise ValueError(f"fit: {self.size} values do not determine {numbers}")
        self._last: tuple[np.ndarray, list, dict] | None = None  # a point, its runs and slopes
        self.reason = ""
        self.remarks: list[str] = []  # about the stretch that is fitted
        self.touching = any(j.impacts for j in scene.joints)
        self.rtol, self.density = RTOL_APART if self.touching else RTOL, 1
        self.groups = [self._checked(g) for g in self.groups]

    def _checked(self, group: _Group) -> _Group:
        """The group with its method. Raises ValueError for what cannot be fitted."""
        run = self.run_of(self.middle, group)
        if not self.touching and (reason := reason_without(run)):
            raise ValueError(f"fit: {reason}")
        units = {c.path: c.units for c in run.mechanism.layout.channels}
        for curve in (self.curves[i] for i in group.curves):
            if curve.measured.along == "angle" and not self.turn:
                reason = "it runs along an angle, and no drive of the scene turns evenly"
                raise ValueError(f"{curve.label}: {reason}")
            path = curve.channel if curve.channel in units else f"{curve.channel}_x"
            if path not in units:
                checks.known("fit: the scene has no channel", curve.channel, units)
            if MOUNTING in curve.nuisances and (across := crossed(path)[0]) not in units:
                raise ValueError(f"fit: mounting of {path}: the scene has no channel {across}")
            if curve.measured.units not in ("?", units[path]):
                reason = f"is in {curve.measured.units}, {curve.channel} in {units[path]}"
                raise ValueError(f"{curve.label} {reason}")
        return group if self.touching else replace(group, method=method_beside(run))

    # --- coordinates
    @property
    def names(self) -> list[str]:
        """Names of all coordinates."""
        of_curves = [f"{n} of record {i + 1}" for i, n in self.nuisances]
        return [*(p.name for p in self.free), *of_curves]

    @cached_property
    def bounds(self) -> np.ndarray:
        """Lower and upper ones of the coordinates."""
        limits = {OFFSET: (-math.inf, math.inf), GAIN: (0.1, 10.0), MOUNTING: (-math.pi, math.pi)}
        of_sensors = [limits.get(n) or self._shifts(i) for i, n in self.nuisances]
        return np.array([*self.ends, *of_sensors]).T

    def _shifts(self, i: int) -> tuple[float, float]:
        """Earliest and latest shift of a record [s]."""
        turn = self.turns[i]
        late = turn or ROOM * self.curves[i].measured.x[-1]
        early = min(self.settle, 1.0) * turn if turn else self.settle
        return -(early or late), late

    @cached_property
    def middle(self) -> np.ndarray:
        """The first start."""
        return np.append(self.inside, self._still())

    def _still(self) -> list[float]:
        """Nuisances that change nothing."""
        return [STILL[n] for _, n in self.nuisances]

    # --- runs
    def run_of(self, x: np.ndarray, group: _Group) -> Run:
        """The run of a point that has not begun."""
        scene = self.scene_of(x, group.changes)
        unit, lengths, spacings = scene.turn or 1.0, [], []
        for curve in (self.curves[i] for i in group.curves):
            places = curve.measured.x / (1.0 if curve.measured.along == "angle" else unit)
            room = 1.0 if scene.turn else ROOM * places[-1]
            lengths.append(places[-1] + room * (SHIFT in curve.nuisances))
            target = (1.0 / SAMPLES if scene.turn else places[-1] / LENGTH) / self.density
            spacing = float(np.median(np.diff(places)))
            spacing *= max(math.floor(target / spacing + ROUNDING), 1)
            spacings.append(spacing / math.ceil(spacing / target - ROUNDING))
        samples = math.ceil((self.settle + max(lengths)) / min(spacings) - ROUNDING)
        until = samples * min(spacings) * unit
        options = {"until": until, "samples": samples + 1, "rtol": self.rtol}
        return self.prepared(scene, method=group.method, **options)

    @property
    def width(self) -> float:
        """Of the differences."""
        return APART if self.touching else WIDTH

    def _steps(self, x: np.ndarray, group: _Group) -> Steps | _Apart:
        run, beside = self.run_of(x, group), Beside(self, x, group.changes)
        if self.touching:
            return _Apart(beside, run)
        return Steps(beside, run, self.rtol, run.method.text, first=run, shares=group.shares)

    def with_runs(self, rtol: float, density: int = 1) -> "Problem":
        """The same with runs to another tolerance, and samples so many times as dense."""
        problem = copy(self)
        problem._last, problem.rtol, problem.density = None, rtol, self.density * density
        return problem

    def along(self, x: np.ndarray) -> "Problem":
        """The same with all runs on the steps of those at x: its cost has no jumps."""
        if self.touching:
            return self
        problem, groups = copy(self), zip(self.groups, self._at(x), strict=True)
        problem.groups = [replace(g, shares=s.ends / s.span.until) for g, s in groups]
        return problem

    def loose(self) -> "Problem":
        """The same with coarser runs, for starts; itself where contact starts with a touch."""
        return self if self.touching else self.with_runs(LEADING_RTOL)

    # --- residuals
    def _at(self, x: np.ndarray) -> list[Steps]:
        """Runs of a point, one for each group."""
        if self._last is None or not np.array_equal(self._last[0], x):
            p, before = len(self.free), self._last
            same = before is not None and np.array_equal(before[0][:p], x[:p])
            steps = before[1] if same else [self._steps(x, g) for g in self.groups]
            self._last = x.copy(), steps, {}
        return self._last[1]

    def computed(
        self, record: MemoryRecord, curve: int, shift: float, angle: float = 0.0
    ) -> np.ndarray:
        """The channel of a run where a curve has its values; shift [s], of a sensor at an angle."""
        about = self.curves[curve]
        values = about.measured.x
        if about.measured.along == "angle":
            times = record.time_at(values + self.settle)
        else:
            times = values + self.settle * (record.turn or 1.0)
        return self.sensed(record, curve, times + shift, angle)

    def sensed(
        self, record: MemoryRecord, curve: int, times: np.ndarray, angle: float = 0.0
    ) -> np.ndarray:
        """The channel of a run at times [s], of a sensor at an angle [rad], through its filter."""
        about = self.curves[curve]
        series = filtered(record.time, turned(record, about.channel, angle), about.lowpass)
        return cubic(record.time, series, np.clip(times, record.time[0], record.time[-1]))

    def modelled(self, record: MemoryRecord, curve: int, x: np.ndarray) -> np.ndarray:
        """The values that a curve would have, with its nuisances."""
        fitted = self.curves[curve].nuisances
        sensor = STILL | {n: float(x[self.column[curve, n]]) for n in fitted}
        values = self.computed(record, curve, sensor[SHIFT], sensor[MOUNTING])
        return sensor[GAIN] * values + sensor[OFFSET] * self.scales[curve]

    def residuals(self, x: np.ndarray) -> np.ndarray:
        """Modelled less measured values over sigma; nan where a run fails, which refuses a step.

        Raises Refused where one cannot make the steps that were given.
        """
        try:
            steps = self._at(x)
        except NO_RUN as reason:
            self.reason = str(reason)
            return np.full(self.size, math.nan)
        errors = np.empty(self.size)
        for group, step in zip(self.groups, steps, strict=True):
            for i in group.curves:
                difference = self.modelled(step.record, i, x) - self.curves[i].measured.values
                errors[self.rows[i]] = difference / self.sigma[i]
        return errors

    @property
    def size(self) -> int:
        """Number of residuals."""
        return sum(len(c.measured.values) for c in self.curves)

    def in_turns(self, i: int) -> np.ndarray:
        """Places of the values of a record [turns]."""
        about = self.curves[i].measured
        return about.x / (1.0 if about.along == "angle" else self.turns[i])

    @property
    def stated(self) -> bool:
        """True where the errors of all records are stated."""
        return all(c.sigma is not None for c in self.curves)

    @property
    def freedom(self) -> int:
        """Number of residuals that coordinates leave free."""
        return max(self.size - len(self.middle), 1)

    @cached_property
    def rows(self) -> list[slice]:
        """Rows of the curves among the residuals."""
        return parts_of(len(c.measured.values) for c in self.curves)

    def before_horizon(self, x: np.ndarray) -> "Problem":
        """The same up to where runs beside a point part, which its `remarks` name; itself where
        they do not.

        Slopes from differences of twice the width are others there. Raises ValueError where a
        record has hardly a value before.
        """
        if not self.touching:
            return self
        narrow, wide = self.jacobian(x), self.jacobian(x, (-2, 2))
        p = len(self.free)
        sizes = np.linalg.norm(narrow[:, :p], axis=0)
        counts, remarks = [], []
        for curve, rows in zip(self.curves, self.rows, strict=True):
            change = np.cumsum((wide - narrow)[rows, :p] ** 2, axis=0)
            late = np.flatnonzero((change > (PARTED * sizes) ** 2).any(axis=1))
            counts.append(int(late[0]) if late.size else rows.stop - rows.start)
            if not late.size:
                continue
            unit = "turns" if curve.measured.along == "angle" else "s"
            end = f"{curve.measured.x[late[0]]:.4g} {unit}"
            reason = f"{curve.label}: contacts start with a touch, and neighbouring trajectories"
            if counts[-1] < FEWEST * len(x):
                raise NotFollowed(
                    f"fit: {reason} part at {end} of the record: what follows says nothing about a "
                    f"parameter; let the record begin with the motion (settle=0)"
                )
            remarks.append(f"{reason} part: it is fitted up to {end}")
        if not remarks:
            return self
        part = self.cut(counts)
        part.remarks = remarks
        return part

    def jacobian(self, x: np.ndarray, places: tuple[int, int] = BOTH) -> np.ndarray:
        """Slopes of the residuals (m, p) between places, in widths; the run itself stands at 0.

        Raises Impossible where a run beside fails.
        """
        self._at(x)
        slopes = self._last[2]
        if places not in slopes:
            slopes[places] = self._slopes(x, places)
        sigma = np.repeat(self.sigma, [len(c.measured.values) for c in self.curves])
        return slopes[places] / sigma[:, None]

    def _slopes(self, x: np.ndarray, places: tuple[int, int]) -> np.ndarray:
        """Slopes of modelled values (m, p)."""
        slopes = np.zeros((self.size, len(x)))
        wide = (places[1] - places[0]) * self.width
        for group, steps in zip(self.groups, self._at(x), strict=True):
            for k in range(len(self.free)):
                ends = {0: steps.record} | steps.around(self.free[k], [n for n in places if n])
                for i in group.curves:
                    low, high = (self.modelled(ends[n], i, x) for n in places)
                    slopes[self.rows[i], k] = (high - low) / wide
            step = min(0.25 * float(np.diff(steps.record.time[:2])[0]), NUDGE)
            for (i, _), column in self.column.items():
                if i in group.curves:
                    moves = step * np.eye(len(x))[column]
                    low, high = (self.modelled(steps.record, i, x + m) for m in (-moves, moves))
                    slopes[self.rows[i], column] = (high - low) / (2.0 * step)
        return slopes

    # --- solutions
    def shifted(self, x: np.ndarray) -> np.ndarray:
        """The point with the shifts of least cost, looked for over one turn; over all of their
        bounds, where nothing turns. The point itself where it has no run.
        """
        try:
            steps = self._at(x)
        except NO_RUN as reason:
            self.reason = str(reason)
            return x
        x = x.copy()
        for group, step in zip(self.groups, steps, strict=True):
            for i in (i for i in group.curves if (i, SHIFT) in self.column):
                at, values = self.column[i, SHIFT], self.curves[i].measured.values
                low, high = self.bounds[:, at]
                if turn := step.record.turn:
                    low = -min(self.settle, 0.5) * turn
                    high = low + turn
                places = np.linspace(low, high, PLACES, endpoint=False)
                costs = [np.var(self.computed(step.record, i, p) - values) for p in places]
                x[at] = places[int(np.argmin(costs))]
        return x

    def solved(
        self,
        x: np.ndarray,
        held: Mapping[int, float] | None = None,
        finish: float = FINISH,
        most: int = MOST,
    ) -> "Solved":
        """The least cost from a start; held: coordinates that stay at values; most: evaluations.

        The last steps of a search go along the steps of its first run, and a linear one behind them
        brings its rounding. Where a run cannot make these, the search ends as one before.
        """
        held, places = held or {}, BESIDE if finish > LAST else BOTH
        begin = np.clip(x, *self.bounds)
        begin[[*held]] = [*held.values()]
        moving = np.array([k for k in range(len(x)) if k not in held], int)
        start = self.priced(begin)
        if not start.converged or not moving.size:
            return start
        search = self if finish > LAST else self.along(begin)
        try:
            solution = least(
                search.residuals,
                lambda y: search.jacobian(y, places),
                begin,
                moving,
                self.bounds,
                (finish, finish, most),
            )
        except Refused:
            return self.solved(x, held, FINISH, most)
        except Impossible as reason:
            self.reason = str(reason)
            return Solved(begin, math.inf, False)
        y, cost = solution.x, float(solution.cost)
        if search is not self:
            inside = solution.active_mask == 0
            step = np.linalg.lstsq(solution.jac[:, inside], -solution.fun, rcond=WEAK)[0]
            y[moving[inside]] += step
            y = np.clip(y, *self.bounds)
            cost = self.priced(y).cost
        return Solved(y, cost, solution.status > 0)

    def priced(self, x: np.ndarray) -> "Solved":
        """A point with its cost, as an end; it has not converged where there is no run."""
        errors = self.residuals(x)
        cost = 0.5 * float(errors @ errors)
        return Solved(x, cost if math.isfinite(cost) else math.inf, math.isfinite(cost))

    def weighed(self, x: np.ndarray) -> bool:
        """Take unknown errors of curves from their residuals; True where they changed much."""
        unknown = [i for i, c in enumerate(self.curves) if c.sigma is None]
        residuals, changed = self.residuals(x), False
        for i in unknown:
            rms = float(np.sqrt(np.mean(residuals[self.rows[i]] ** 2))) or 1.0
            changed |= len(self.curves) > 1 and not 0.99 < rms < 1.01
            self.sigma[i] *= rms
        return changed

    def starts(self, count: int, seed: int) -> Iterator[np.ndarray]:
        """Starts: the first, then those of least cost of the first parts of the records."""
        yield self.middle
        yield from self.first(next(self._shares(), 1.0)).lowest(count - 1, seed)

    def lowest(self, count: int, seed: int) -> Iterator[np.ndarray]:
        """The best of Sobol' points between the bounds."""
        points = self.spread(max(LOOKED, count), seed) if count else ()
        looked = [self.priced(self.shifted(np.append(p, self._still()))) for p in points]
        yield from self.apart(e.x for e in sorted(looked, key=lambda e: e.cost))[:count]

    def followed(self, x: np.ndarray, report: Callable[[float], None]) -> "Solved":
        """The least cost from a start, whose shifts are looked for first, and at its end.

        Where contact starts with a touch, or nothing turns evenly, the first parts of the records
        lead to all of them: later parts have many minima. report: called with the share that is
        done.
        """
        x, shares = self.shifted(x), [*self._shares()]
        for k, share in enumerate(shares):
            report(k / (1 + len(shares)))
            before = self.first(share).solved(x, finish=LEADING, most=MOST_LEADING)
            x = before.x if math.isfinite(before.cost) else x
        finish = FINISH if self.touching else max(STARTING, NO_STEP / self.size)
        end = self.solved(x, finish=finish)
        if any(n == SHIFT for _, n in self.nuisances) and math.isfinite(end.cost):
            x = self.shifted(end.x)
            if self.priced(x).cost < end.cost:
                end = self.solved(x, finish=finish)
        return end

    def _shares(self) -> Iterator[float]:
        """Shares of the records that lead to all of them; none where all have one minimum."""
        if self.turn and not self.touching:
            return
        share = FIRST
        if self.turn:
            turns = (self.in_turns(i)[-1] for i in range(len(self.curves)))
            share = min(FIRST, EARLY / max(turns))
        while share < 1.0:
            yield share
            share *= GROWTH

    def finished(self, ends: Sequence["Solved"]) -> list["Solved"]:
        """Ends of starts in the order of their costs, followed to the end.

        One beside a better one shares its end. One that costs far more than the best stays.
        """
        ranked = sorted(ends, key=lambda e: e.cost)
        likely = [e for e in ranked if math.isfinite(e.cost) and e.cost <= REFUSED * ranked[0].cost]
        minima: list[tuple[Solved, np.ndarray]] = []
        result = []
        for end in likely:
            same = next((m for m, slopes in minima if self._beside(m, slopes, end.x)), None)
            if same is None:
                same = self.solved(end.x, finish=FINISH if minima else LAST)
                minima += [(same, self.jacobian(same.x))] if math.isfinite(same.cost) else []
            result.append(same)
        return [*result, *ranked[len(likely) :]]

    def _beside(self, minimum: "Solved", slopes: np.ndarray, x: np.ndarray) -> bool:
        """True where residuals are another by less than one deviation, and coordinates by a share
        of their bounds.
        """
        low, high = self.bounds
        growth = float(np.sum((slopes @ (x - minimum.x)) ** 2))
        near = np.abs(x - minimum.x) <= NEAR * (high - low)
        return growth <= 2.0 * minimum.cost / self.size and bool(near.all())

    def first(self, share: float) -> "Problem":
        """The same with the first share of each record."""
        lengths = (len(c.measured.x) for c in self.curves)
        return self.cut([max(math.floor(share * n + ROUNDING), 2) for n in lengths])

    def cut(self, counts: Sequence[int]) -> "Problem":
        """The same with so many values of each record."""
        part = copy(self)
        part.curves, part._last = [], None
        part.__dict__.pop("rows", None)
        for curve, n in zip(self.curves, counts, strict=True):
            about = curve.measured
            record = replace(about, x=about.x[:n], values=about.values[:n])
            part.curves.append(replace(curve, measured=record))
        return part


@dataclass(frozen=True)
class Solved:
    """A least cost: its coordinates, half the sum of squares, convergence."""

    x: np.ndarray
    cost: float
    converged: bool
