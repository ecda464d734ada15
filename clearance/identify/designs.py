"""`cl.optimize`: dimensions from requirements, with prices of the limits, a check, a map, a folder.

The margin of a limit is the stated error of its metric, of the integration. For a share of machines
the quantile of that share times the deviation of the metric over the tolerances, linearised, comes
to it. Both are those of the optimum, which is sought again until they stay. Two goals: the
front of designs where neither gets better without the other, by limits of the second one at equal
distances.

Source: Miettinen, Nonlinear Multiobjective Optimization (1999), section 3.2.
"""

import math
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from itertools import chain, islice
from pathlib import Path
from statistics import NormalDist

import numpy as np

from clearance.accuracy.by_differences import Impossible
from clearance.files.locks import locked
from clearance.files.texts import listed
from clearance.identify.free import Bounds, Journal, Progress, all_bounded, saved
from clearance.identify.optimum import (
    KEPT,
    LAST,
    LOSS,
    Aim,
    Design,
    Goal,
    Limit,
    Point,
    Solved,
    parts_of_limit,
    with_losses,
)
from clearance.metrics.metrics import Metric
from clearance.results.result import Result
from clearance.run.progress_bar import watched
from clearance.scene.catalogue import AnyCase, load_case
from clearance.scene.parameter import varied
from clearance.scene.scene import Scene
from clearance.simulation import simulate
from clearance.sweeping.chance import limits_of, scatter
from clearance.sweeping.index import Sweep
from clearance.sweeping.points import grid, zipped
from clearance.sweeping.scatter import Distribution, Estimate, probability
from clearance.sweeping.sweep import sweep
from clearance.values import checks
from clearance.values.accessors import Celled, accessor
from clearance.values.units import behind, shown, written
from clearance.version import VERSION

STARTS = 4
LOOKED_WITHOUT = 64  # points that the best starts are taken from, without slopes
FRONT = 20  # designs of a front
ROUNDS = 6  # of margins, at most
NOISE = 1e-4  # of a limit, that no search misses by the noise of values
STAYS = (1e-6, 2e-3)  # of a limit and of its margin, by which this may still change
APART = 1e-2  # of the width of the bounds, between distinct optima
FLAT = 1e-6  # of the goal, by which a ridge between optima is higher
ALONG = 11  # values of a parameter on the map
CHECKED = 1024  # runs of the check, at most
DOCUMENT, JOURNAL = "optimum.json", "starts.json"


@dataclass(frozen=True, eq=False)
class Optimum(Celled):
    """The best design and what it depends on.

    goals: what was sought, one or two; limits: with their margins at the optimum; best, ends: of
    the search, and of all its starts; errors: stated of the metrics of limits, by text of the
    limit; front: designs between two goals; share: of machines that are to keep the limits; check:
    those that keep each in a scatter; `doubts`: what is not exact, in sentences.
    """

    design: Design
    goals: tuple[Goal, ...]
    limits: tuple[Limit, ...]
    best: Solved
    ends: tuple[Solved, ...]
    errors: Mapping[str, float]
    front: tuple[Solved, ...]
    share: float
    check: Mapping[str, Estimate]
    doubts: tuple[str, ...]

    @cached_property
    def point(self) -> Point:
        """The optimum."""
        return self.design.point(self.best.x)

    @property
    def values(self) -> dict[str, float]:
        """Parameters of the optimum by name, in SI."""
        return self.design.values(self.best.x)

    @property
    def scene(self) -> Scene:
        """The scene with these."""
        return self.design.scene_of(self.best.x)

    @property
    def metrics(self) -> dict[str, float]:
        """Goals and metrics of limits at the optimum."""
        return {n: self.point.values[n] for n in self.design.wanted}

    @cached_property
    def aim(self) -> Aim:
        """The first goal under the limits."""
        return Aim(self.design, self.goals[0], self.limits)

    @cached_property
    def prices(self) -> dict[str, float]:
        """Units of the goal that a unit of each active limit costs, and a step in the coordinate of
        each parameter beyond its bound would gain; empty without slopes.
        """
        with suppress(Impossible):
            return {} if self.design.without else self.aim.prices(self.point)[0]
        return {}

    @property
    def others(self) -> list[Solved]:
        """Other optima that starts ended in."""
        # without margins, which move all of them
        apart = [self.ends[0]]
        for end in self.ends:
            good = end.shortfall <= KEPT and end.smooth
            if good and all(self._ridge(end, other) for other in apart):
                apart.append(end)
        return apart[1:]

    def _ridge(self, first: Solved, second: Solved) -> bool:
        """True for ends that are far apart with worse designs between them: no flat valley."""
        sign, bare = self.goals[0].sign, [replace(i, margin=0.0) for i in self.limits]
        if self.design.distance(first.x, second.x) < APART:
            return False
        middle = Aim(self.design, self.goals[0], bare).judged(0.5 * (first.x + second.x))
        worse = max(sign * first.goal, sign * second.goal)
        return middle.shortfall > KEPT or sign * middle.goal > worse + FLAT * abs(worse)

    @cached_property
    def words(self) -> list[str]:
        """Prices of limits and bounds, a sentence each."""
        about, goal = self.design.known, self.goals[0]
        units = behind(about[goal.name].units)
        lines = []
        for limit in self.aim.active(self.point):
            step = 10.0 ** math.floor(math.log10(limit.size / 10.0))
            of = _amount(step, about[limit.name].units)
            way = "more" if limit.sign > 0 else "less"
            price = self.prices.get(limit.text)
            cost = "" if price is None else f": {of} {way} costs {price * step:.3g}{units}"
            lines.append(f"{limit.text} is active{cost}")
        for k, way in self.design.at_bounds(self.point).items():
            free, end = self.design.free[k], "upper" if way > 0 else "lower"
            step = 0.01 if free.positive else 0.01 * abs(free.value(1.0)) / free.size
            price, further = self.prices.get(free.name), "more" if way > 0 else "less"
            gain = "" if not price else f": 1 % {further} gains {price * step:.3g}{units}"
            lines.append(f"{free.name} is at its {end} bound{gain}")
        return lines

    def document(self) -> dict:
        """All of it as plain data."""
        about = self.design.known
        return {
            "goals": [g.text for g in self.goals],
            "parameters": {
                p.name: {"value": self.values[p.name], "bounds": [p.low, p.high], "units": p.units}
                for p in self.design.free
            },
            "metrics": {n: {"value": v, "units": about[n].units} for n, v in self.metrics.items()},
            "limits": [self._of(i) for i in self.limits],
            "words": self.words,
            "optima": [self._row(e) for e in (self.best, *self.others)],
            "front": [self._row(e) for e in self.front],
            "tolerances": dict(self.design.tolerances),
            "share": self.share,
            "starts": [self._row(e) for e in self.ends],
            "evaluations": self.design.evaluations,
            "doubts": list(self.doubts),
            "version": VERSION,
        }

    def _of(self, limit: Limit) -> dict:
        """A limit as plain data."""
        row = {
            "limit": limit.text,
            "value": self.point.values[limit.name],
            "margin": limit.margin,
            "error": self.errors.get(limit.text) or None,
            "active": limit in self.aim.active(self.point),
            "price": self.prices.get(limit.text, 0.0 if self.prices else None),
        }
        if limit.text in self.check:
            row["kept"] = vars(self.check[limit.text])
        return row

    def _row(self, end: Solved) -> dict:
        point = self.design.point(end.x)
        metrics = {n: point.values.get(n, math.nan) for n in self.design.wanted}
        return {"parameters": self.design.values(end.x), "metrics": metrics, "smooth": end.smooth}

    def mapped(self, folder: str | Path, along: int = ALONG, workers: int | None = None) -> Sweep:
        """A sweep of the first two parameters between their bounds, the others at the optimum.

        Raises ValueError for one of the case beside a number of the scene.
        """
        chosen = self.design.free[:2]
        places = {
            p.name: [p.value(float(x)) for x in np.linspace(*self.design.ends[k], along)]
            for k, p in enumerate(chosen)
        }
        case = case_of(self.scene, places)
        options, settle = self.design.options, self.design.settle
        points = grid(**places)
        return sweep(case, points, folder, channels=[], settle=settle, workers=workers, **options)

    def plot(self, output: str | Path | None = None, swept: Sweep | None = None):
        """Picture: the map around the optimum with its limits, and the front of two goals."""
        return accessor("plot_optimum")(self, output, swept)

    def report(self, output: str | Path, swept: Sweep | None = None) -> Path:
        """Write a page that needs nothing else."""
        return accessor("report_optimum")(self, output, swept)

    def simulated(self, path: str | Path | None = None) -> Result:
        """The run of the optimum."""
        return simulate(self.scene, path=path, settle=self.design.settle, **self.design.options)

    def save(self, folder: str | Path) -> Path:
        """Write `optimum.json` and the run of the optimum, `run.h5`, into a folder."""
        return saved(self, folder, DOCUMENT)

    def __repr__(self) -> str:
        values = ", ".join(f"{n}={v:.4g}" for n, v in self.values.items())
        return f"<{self.goals[0].text} of {self.design.scene.name}: {values}>"


def _amount(value: float, units: str) -> str:
    """A number with its unit, lengths in micrometres."""
    return written(value, "um") if units == "m" else f"{value:g}{behind(units)}"


def case_of(scene: Scene, names: Iterable[str]) -> Scene:
    """A scene whose sweeps have these parameters. Raises ValueError for some of the case beside
    numbers of the scene.
    """
    numbers = ["/" in n for n in names]
    if scene.case is None or not any(numbers):
        return scene
    if not all(numbers):
        raise ValueError("a sweep has parameters of the case or numbers of the scene, not both")
    return Scene.from_json(scene.to_json())


def metric_of(swept: Sweep, name: str, design: Design) -> np.ndarray:
    """A metric over the points of a sweep, also a mean loss."""
    if name in swept.metrics:
        return np.asarray(swept.metrics[name], float)
    values = np.full(len(swept), math.nan)
    for i in np.flatnonzero(swept.done):
        scene = load_case(design.scene, **swept.definition.points[i])
        row = {n: Metric(float(v[i]), "J", "") for n, v in swept.metrics.items()}
        values[i] = with_losses(row, scene)[name].value
    return values


@watched
def optimize(
    scene: AnyCase,
    parameters: Bounds,
    *,
    minimize: str | Sequence[str] = (),
    maximize: str | Sequence[str] = (),
    limits: str | Sequence[str] = (),
    turns: float | None = None,
    until: float | None = None,
    settle: float | None = None,
    samples_per_turn: int | None = None,
    start: str | Path | None = None,
    tolerance: Mapping[str, float | str] | None = None,
    share: float | str = 0.99,
    starts: int = STARTS,
    seed: int = 0,
    designs: int = FRONT,
    folder: str | Path | None = None,
    progress: Callable[[float], None] | bool | None = None,
) -> Optimum:
    """Parameters of a scene that give the least or largest value of a metric under limits.

    parameters: bounds by name, (low, high) in SI or "20um:100um": of the case ("clearance") or
        numbers of the scene ("bodies/slider/mass"). minimize, maximize: one metric, or two in all
        for a front of so many `designs`. Names are those of the metrics of `clearance run --json`,
        also as paths ("joints/B/gap_min"), and of mean losses (identify/optimum.py). limits:
        "joints/B/film_thickness_ratio_min > 3", "drive_crank_torque_max < 2Nm".
    turns (2), until, samples_per_turn, start: of the runs, as of `simulate`; settle: turns left
        out of the metrics. tolerance: standard deviations of parameters; limits then hold
        for a share of machines.
    starts: of the search; seed: of these. folder: of the result; an interrupted search goes on
        there. progress: called with the share that is done.
    Raises ValueError for names and bounds that do not fit the scene, and where no design keeps the
    limits, with the one that is missed most.

    Example:

        >>> feeder = cl.load_case("six_bar_feeder")
        >>> best = cl.optimize(feeder, {"clearance": "20um:100um"}, minimize="loss_mean", starts=1)
        >>> list(best.values)
        ['clearance']
    """
    scene = load_case(scene)
    goals = [Goal.of(g) for g in listed(minimize) or ()]
    goals += [Goal(g.name, -g.sign) for g in map(Goal.of, listed(maximize) or ())]
    if len(goals) not in (1, 2):
        raise ValueError(f"optimize needs one or two goals, got {len(goals)}")
    checks.whole("optimize: starts", starts, 1)
    checks.whole("optimize: designs", designs, 3)
    share = checks.inner_fraction("share", checks.share("share", share))
    if tolerance and not limits:
        raise ValueError("optimize: a tolerance widens limits, and there is none: give a limit")
    free = all_bounded(scene, parameters)
    options = {"turns": turns, "until": until, "start": start, "samples_per_turn": samples_per_turn}
    if turns is None and until is None:
        until = scene.case.until if scene.case else 2.0
        options |= {"turns": 2.0} if scene.turn else {"until": until}
    options = {n: v for n, v in options.items() if v is not None}
    design = _Swept(scene, free, options, settle, _tolerances(scene, tolerance or {}))
    goals = tuple(Goal(design.name_of(g.name), g.sign) for g in goals)
    wanted = _limits(design, listed(limits) or ())
    design.progress = Progress(progress)
    search = _Search(design, goals, wanted, share, starts, seed, designs)
    if folder is None:
        with tempfile.TemporaryDirectory() as aside:
            return search.result(None, Path(aside) / "check")
    path = Path(folder)
    with locked(path, "optimize"):
        result = search.result(path / JOURNAL, path / "check")
        result.save(path)
    return result


class _Swept(Design):
    """A design whose first points run in the lanes of a sweep where it has no slopes."""

    def __init__(self, *about):
        super().__init__(*about)
        if self.without:
            self.looked = LOOKED_WITHOUT

    def look(self, places: np.ndarray) -> list[dict[str, float]]:
        rows = [self.values(x) for x in places]
        columns = {p.name: [row[p.name] for row in rows] for p in self.free}
        if not self.without or len({"/" in n for n in columns}) > 1:
            return super().look(places)
        with tempfile.TemporaryDirectory() as folder:
            case, points = case_of(self.scene, columns), zipped(**columns)
            swept = sweep(case, points, folder, channels=[], settle=self.settle, **self.options)
            table = {n: metric_of(swept, n, self).tolist() for n in self.wanted}
        return [dict(zip(table, row, strict=True)) for row in zip(*table.values(), strict=True)]


def _tolerances(scene: Scene, tolerance: Mapping[str, float | str]) -> dict[str, float]:
    """Standard deviations in SI. Raises ValueError."""
    sizes = {}
    for name, size in tolerance.items():
        try:
            sizes[name] = varied(scene, name, size).size
        except ValueError as error:
            raise ValueError(f"tolerance of {name}: {error}") from None
    case_of(scene, sizes)
    return sizes


def _limits(design: Design, texts: Sequence[str]) -> list[Limit]:
    """Limits from their words. Raises ValueError."""
    units = {n: m.units for n, m in design.known.items()}
    limits = []
    for text in texts:
        name, sign, value = parts_of_limit(text)
        ((column, number),) = limits_of({design.name_of(name): value}, units).items()
        limits.append(Limit(column, sign, number))
    return limits


@dataclass
class _Search:
    """The search: starts, margins, front, check; its ends stand in a journal."""

    design: _Swept
    goals: tuple[Goal, ...]
    limits: Sequence[Limit]
    share: float
    starts: int
    seed: int
    designs: int
    errors: dict[str, float] = field(default_factory=dict)
    doubts: list[str] = field(default_factory=list)

    def result(self, journal: Path | None, aside: Path) -> Optimum:
        """All of it. journal: of this search; aside: folder of the check."""
        design, aim = self.design, Aim(self.design, self.goals[0], self.limits)
        design.want([i.name for i in (*self.goals, *self.limits)])
        self.journal = Journal(journal, Solved, self._about())
        ends = [self._kept(partial(aim.solved, x)) for x in aim.starts(self.starts, self.seed)]
        ends.sort(key=aim.merit)
        self._feasible(aim, ends[0])
        best, aim = self._with_margins(aim, ends[0].x)
        front = self._front(aim, best) if len(self.goals) == 2 else ()
        if design.without:
            self.doubts.append(f"searched without slopes: {design.without.partition('. ')[0]}")
            if design.tolerances:
                self.doubts.append("limits have no margin for tolerances, which are slopes")
        elif not best.smooth:
            self.doubts.append("slopes do not show a least value there: a kink, or more iterations")
        check = self._check(best, aim.limits, aside) if design.tolerances else {}
        ends, doubts = (aim.limits, best, tuple(ends)), tuple(dict.fromkeys(self.doubts))
        shares = self.share, check
        return Optimum(design, self.goals, *ends, self.errors, tuple(front), *shares, doubts)

    def _missed(self, aim: Aim, end: Solved) -> Limit | None:
        """The limit that a design misses most; None where it keeps all by their stated errors.

        A margin has half an error to spare.
        """
        values = self.design.point(end.x).values

        def room(i: Limit) -> float:
            spare = 0.5 * self.errors.get(i.text, 0.0) if i.margin > 0.0 else 0.0
            return (i.room(values[i.name]) + spare) / i.size + KEPT

        worst = min(aim.limits, key=room, default=None)
        return worst if worst and room(worst) < 0.0 else None

    def _feasible(self, aim: Aim, end: Solved) -> None:
        """Raises ValueError for a design that has no run or misses a limit."""
        point = self.design.point(end.x)
        if point.reason:
            raise ValueError(f"optimize: no design has a run: {point.reason}")
        worst = self._missed(aim, end)
        if worst is None:
            return
        units = self.design.known[worst.name].units
        margin = f" with a margin of {shown(worst.margin, units)}" if worst.margin else ""
        numbers = self.design.values(end.x)
        values = ", ".join(
            f"{p.name} = {shown(numbers[p.name], p.units)}" for p in self.design.free
        )
        raise ValueError(
            f"optimize: no design between the bounds keeps {worst.text}{behind(units)}{margin}: "
            f"the nearest has {shown(point.values[worst.name], units)}, at {values}"
        )

    def _kept(self, make: Callable[[], Solved]) -> Solved:
        """The next end of the search, from the journal where it is there."""
        end = self.journal.end(make)
        total = 1 + self.starts + (self.designs - 2 if len(self.goals) == 2 else 0)
        self.design.progress(min(self.journal.done / total, 1.0))
        return end

    def _with_margins(self, aim: Aim, x: np.ndarray) -> tuple[Solved, Aim]:
        """The best design near one whose limits have the margins of its own."""
        best = aim.judged(x)
        if not aim.limits:
            return aim.solved(x, LAST), aim
        for _ in range(ROUNDS):
            point = self.design.point(best.x)
            margins, (of_limit, of_margin) = self._margins(point), STAYS
            stays = (
                abs(margins[i.text] - i.margin) <= max(of_limit * i.size, of_margin * i.margin)
                and i.margin >= self.errors[i.text]
                for i in aim.limits
            )
            if self._missed(aim, best) is None and all(stays):
                break
            # what the last search missed, for values of neighbouring designs have some noise
            missing = (max(-i.room(point.values[i.name]), 0.0) for i in aim.limits)
            pairs = zip(aim.limits, missing, strict=True)
            limits = [replace(i, margin=margins[i.text] + 2.0 * m) for i, m in pairs]
            aim = Aim(self.design, aim.goal, limits)
            best = aim.solved(best.x, LAST)
            if best.shortfall > NOISE:
                break
        self._feasible(aim, best)
        return best, aim

    def _margins(self, point: Point) -> dict[str, float]:
        """Stated errors, and quantiles of the tolerances, by text of the limit."""
        design, spread = self.design, 0.0
        errors: Mapping = {}
        if not design.without:
            errors = simulate(point.scene, settle=design.settle, **design.options).errors
        if design.without:
            self.doubts.append("without slopes limits have no stated errors")
        elif not errors:
            self.doubts.append(f"no stated errors: {errors.reason}")
        margins = {}
        for limit in self.limits:
            stated = _stated(errors, limit.name, point.values[limit.name])
            if stated is None and errors:
                self.doubts.append(f"{limit.name} has no stated error")
            self.errors[limit.text] = stated or 0.0
            if design.tolerances and not design.without:
                quantile = NormalDist().inv_cdf(self.share)
                spread = max(quantile, 0.0) * point.deviations[limit.name]
            # a little more, for the error is another at the new optimum
            margins[limit.text] = 1.5 * (stated or 0.0) + spread
        return margins

    def _front(self, aim: Aim, best: Solved) -> list[Solved]:
        """Designs from the best for the first goal to that for the second."""
        design, (first, second) = self.design, self.goals
        other = Aim(design, second, self.limits)
        starts = chain([best.x], other.starts(self.starts, self.seed))
        last = min((other.solved(x) for x in islice(starts, 2)), key=other.merit)
        last, _ = self._with_margins(other, last.x)
        begin, end = (design.point(s.x).values[second.name] for s in (best, last))
        front, x = [best], best.x
        for level in np.linspace(begin, end, self.designs)[1:-1]:
            bound = Limit(second.name, -second.sign, float(level))
            solved = self._kept(partial(Aim(design, first, [*aim.limits, bound]).solved, x))
            if solved.shortfall <= KEPT:
                front.append(solved)
                x = solved.x
        goal = design.point(last.x).values[first.name]
        return [*front, replace(last, goal=goal)]

    def _check(self, best: Solved, limits: Sequence[Limit], folder: Path) -> dict[str, Estimate]:
        """Shares of machines that keep each limit, by a scatter around the optimum."""
        design, scene = self.design, self.design.scene_of(best.x)
        spread = {
            n: Distribution("normal", (varied(scene, n, s).value, s))
            for n, s in design.tolerances.items()
        }
        swept = scatter(
            case_of(scene, spread),
            spread,
            folder,
            points=CHECKED,
            seed=self.seed,
            settle=design.settle,
            **design.options,
        )
        shares = {}
        for limit in limits:
            values = metric_of(swept.sweep, limit.name, design)[: 2 * swept.n]
            values = values[np.isfinite(values)]
            shares[limit.text] = probability(limit.sign * (values - limit.value) >= 0.0)
        return shares

    def _about(self) -> tuple:
        """All that the ends depend on."""
        design = self.design
        runs = design.scene.to_json(), design.settle, design.options, design.free, design.tolerances
        return runs, self.goals, self.limits, self.seed, self.starts, self.designs, self.share


def _stated(errors, name: str, value: float) -> float | None:
    """Stated error of a metric, of the integration alone; None where there is none."""
    if name in errors:
        return errors[name].stated
    for end in ("dissipated_per_turn", "dissipated_power"):
        if (of := name.replace(LOSS, end)) != name and of in errors:
            return errors[of].relative * abs(value)
    return None
