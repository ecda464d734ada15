"""The least of a metric over free parameters of a scene, under limits of metrics.

    minimise  s f(x) / F      subject to  t_i (g_i(x) - L_i) >= m_i      between bounds

f, g_i: metrics of a run (metrics/of_points.py) and mean losses; s, t_i: 1 or -1; m_i: margin of a
limit. Sequential quadratic programming (SLSQP of scipy) has the slopes of runs that make the same
steps (`accuracy.by_differences.Steps`). Where these do not show a least value, as at a kink, or
where there are none, a search without slopes goes on (COBYQA of scipy). Prices of limits are the
multipliers at the optimum: grad s f = sum of l_i grad t_i g_i, by least squares.

Mean losses [W] are the dissipated energy in a turn over its time: loss_mean of all joints and
dampers, joint_<joint>_loss_mean, and drive_<drive>_loss_mean of the only drive, which feeds all.

Validity: metrics that go on with the parameters. Where contact starts with a touch they are noisy,
and an optimum is as exact as their means over turns. Source: Nocedal and Wright, Numerical
Optimization (2006), chapters 12 and 18; Ragonneau and Zhang, COBYQA (2024).
"""

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from scipy.optimize import NonlinearConstraint, minimize, nnls

from clearance.accuracy.by_differences import (
    LOOSER,
    WIDTH,
    Impossible,
    Steps,
    method_beside,
    reason_without,
    recorded,
)
from clearance.identify.free import NO_RUN, Beside, Free, Varying
from clearance.metrics.metrics import Metric
from clearance.metrics.of_points import of_point
from clearance.results.recorder import MemoryRecord
from clearance.run.ideal_motion import ideal_motion
from clearance.run.run import Run
from clearance.scene.parameter import Varied, varied
from clearance.scene.scene import Scene
from clearance.simulation import prepare
from clearance.values import checks
from clearance.values.spelling import alike

LOSS = "loss_mean"
DISSIPATED = ("dissipated_per_turn", "dissipated_power")
FINISH, LAST = 1e-8, 1e-15  # changes of the scaled goal at which a search, and the best, ends
STILL = 1e-4  # rest of the slopes over them, up to which a point is a least value
KEPT = 1e-7  # of its size, by which a limit may be missed
EDGE = 1e-5  # of the width of the bounds: at its bound; of a limit: active
MOST, MOST_LAST = 60, 12  # iterations of a search, and of the best one
MOST_WITHOUT = 40  # evaluations a parameter of the search without slopes
RADIUS = (0.05, 1e-6)  # of that search, first and last, over the width of the bounds
FAILED = 10.0  # scaled goal, and shortfall of limits, of a point without a run
SHARED = ("start", "max_step")  # options of the runs beside a point too
HELD = 64  # points in memory
LOOKED = 16  # points that the best starts are taken from
_LIMIT = re.compile(r"\s*([A-Za-z][^<>=\s]*)\s*([<>])=?\s*(\S.*?)\s*$")


@dataclass(frozen=True)
class Goal:
    """A metric and its sign: 1 to minimise it, -1 to maximise it."""

    name: str
    sign: int = 1

    @classmethod
    def of(cls, text: str) -> "Goal":
        """From a name; a minus sign before it maximises."""
        text = text.strip()
        return cls(text.removeprefix("-").strip(), -1 if text.startswith("-") else 1)

    @property
    def text(self) -> str:
        """It in words."""
        return f"{'least' if self.sign > 0 else 'largest'} {self.name}"


@dataclass(frozen=True)
class Limit:
    """A metric that stays above (sign 1) or below (sign -1) a value in SI.

    margin: by which it does, see `m_i` above.
    """

    name: str
    sign: int
    value: float
    margin: float = 0.0

    @property
    def size(self) -> float:
        """Natural size of a shortfall."""
        return abs(self.value) or 1.0

    @property
    def text(self) -> str:
        """It in words."""
        return f"{self.name} {'>' if self.sign > 0 else '<'} {self.value:g}"

    def room(self, value: float) -> float:
        """Distance of a metric from the limit with its margin; negative outside."""
        return self.sign * (value - self.value) - self.margin


def parts_of_limit(text: str) -> tuple[str, int, str]:
    """Name, sign and value of "joints/B/gap_min > 2um". Raises ValueError."""
    match = _LIMIT.match(text)
    if match is None:
        raise ValueError(f"limit {text!r}: expected METRIC > VALUE or METRIC < VALUE")
    return match[1], 1 if match[2] == ">" else -1, match[3]


def with_losses(values: Mapping[str, Metric], scene: Scene) -> dict[str, Metric]:
    """Metrics and the mean losses that follow from them."""
    losses = {}
    for name, metric in values.items():
        for end, time in zip(DISSIPATED, (scene.turn or 1.0, 1.0), strict=True):
            if name.endswith(end):
                text = f"mean loss: {metric.text}"
                of = Metric(metric.value / time, "W", text)
                losses[name.removesuffix(end) + LOSS] = of
    if LOSS in losses and len(scene.drives) == 1:
        losses[f"drive_{scene.drives[0].name}_{LOSS}"] = losses[LOSS]
    return {**values, **losses}


class _Around(Beside):
    """A point and those beside it; also of parameters that are not free."""

    def scene_at(self, number: Free | Varied, offset: int) -> Scene:
        if isinstance(number, Varied):
            return number.scene(number.value + offset * WIDTH * number.size)
        return super().scene_at(number, offset)


class Point:
    """Metrics of a design at coordinates; reason: why there are none, "" where there are."""

    def __init__(self, design: "Design", x: np.ndarray):
        self.design, self.x, self.reason = design, x, ""
        self.values: dict[str, float] = {}
        try:
            self.scene = design.scene_of(x)
            self._begin(design.run_of(self.scene))
        except NO_RUN as reason:
            self.reason = str(reason)

    def _begin(self, run: Run) -> None:
        design = self.design
        if design.without:
            self.metrics = design.summed(run, recorded(run))
        else:
            around = _Around(design, self.x, {}, design.summed)
            self.steps = Steps(around, run, LOOSER, method_beside(run))
            self.metrics = design.summed(run, self.steps.record)
        self.values = {n: m.value for n, m in self.metrics.items()}
        design.evaluations += 1
        if missing := [n for n in design.wanted if not math.isfinite(self.values.get(n, math.nan))]:
            raise ValueError(f"its run has no {missing[0]}")

    def _along(self, number: Free | Varied, width: float) -> np.ndarray:
        """Slopes of metrics by the coordinate of a parameter, or by its value."""
        ends = self.steps.around(number, (-1, 1))
        low, high = (np.array([ends[n][m].value for m in self.design.wanted]) for n in (-1, 1))
        return (high - low) / (2.0 * width)

    @cached_property
    def slopes(self) -> dict[str, np.ndarray]:
        """Slopes of metrics by the coordinates. Raises Impossible."""
        columns = [self._along(p, self.design.width) for p in self.design.free]
        return dict(zip(self.design.wanted, np.stack(columns, axis=1), strict=True))

    @cached_property
    def deviations(self) -> dict[str, float]:
        """Standard deviations of metrics over the tolerances, linearised."""
        squares = np.zeros(len(self.design.wanted))
        for name, size in self.design.tolerances.items():
            number = varied(self.scene, name, size)
            number = replace(number, size=max(abs(number.value), size))
            squares += (self._along(number, WIDTH * number.size) * size) ** 2
        return dict(zip(self.design.wanted, np.sqrt(squares).tolist(), strict=True))


@dataclass(frozen=True)
class Solved:
    """The end of a search: coordinates, goal in its units, shortfall of the worst limit over its
    size; smooth: slopes show a least value.
    """

    x: np.ndarray
    goal: float
    shortfall: float
    smooth: bool


class Design(Varying):
    """A scene with free parameters and the metrics of its runs.

    options: of the runs (turns or until, samples_per_turn); settle: turns left out of the metrics;
    tolerances: standard deviations of parameters, by name. without: why slopes are not used, "" for
    slopes. Raises ValueError for parameters that the scene has not.
    """

    def __init__(
        self,
        scene: Scene,
        free: Sequence[Free],
        options: Mapping[str, object],
        settle: float | None = None,
        tolerances: Mapping[str, float] | None = None,
    ):
        super().__init__(scene, free)
        if not self.free:
            raise ValueError("optimize needs at least one parameter with bounds")
        self.options, self.settle = dict(options), settle
        self.tolerances = dict(tolerances or {})
        self.wanted: list[str] = []
        self.evaluations, self.looked = 0, LOOKED
        self._points: dict[bytes, Point] = {}
        self.without = reason_without(self.run_of(self.scene_of(self.inside)))
        first = self.point(self.inside)
        if first.reason:
            raise ValueError(f"optimize: the first design has no run: {first.reason}")
        self.known = first.metrics

    def name_of(self, name: str) -> str:
        """The metric of a name or path. Raises ValueError for one that there is not."""
        column = alike(name, self.known)
        checks.known("no metric", column, self.known)
        return column

    def want(self, names: Sequence[str]) -> None:
        """Metrics that points need."""
        self.wanted = list(dict.fromkeys(names))
        self._points.clear()

    def prepared(self, scene: Scene, **options) -> Run:
        """A run, with the ledger that losses come from."""
        self.progress()
        shared = {n: self.options[n] for n in SHARED if n in self.options}
        return prepare(scene, **shared | options)

    def run_of(self, scene: Scene) -> Run:
        """The run of a scene that has not begun."""
        return self.prepared(scene, **self.options)

    def summed(self, run: Run, record: MemoryRecord) -> dict[str, Metric]:
        """Metrics of a run; all of them before points need some."""
        ideal, scene = None, run.mechanism.scene
        if not self.wanted or any("_deviation" in n for n in self.wanted):
            ideal = ideal_motion(scene, run.span, record.scene)
        return with_losses(of_point(record, self.settle, ideal), scene)

    def point(self, x: np.ndarray) -> Point:
        """A point, remembered."""
        x = np.clip(np.asarray(x, float), *self.ends.T)
        if (key := x.tobytes()) not in self._points:
            if len(self._points) >= HELD:
                self._points.pop(next(iter(self._points)))
            self._points[key] = Point(self, x)
        return self._points[key]

    def at_bounds(self, point: Point) -> dict[int, int]:
        """Parameters at a bound by their place: -1 at the lower, 1 at the upper one."""
        (low, high), edge = self.ends.T, EDGE * np.ptp(self.ends, axis=1)
        at = {int(k): -1 for k in np.flatnonzero(point.x < low + edge)}
        return at | {int(k): 1 for k in np.flatnonzero(point.x > high - edge)}

    def look(self, places: np.ndarray) -> list[dict[str, float]]:
        """Metrics at coordinates (points, parameters); empty where there is no run."""
        return [self.point(x).values for x in places]


class Aim:
    """A goal of a design under limits."""

    def __init__(self, design: Design, goal: Goal, limits: Sequence[Limit]):
        self.design, self.goal, self.limits = design, goal, tuple(limits)
        self.size = 1.0  # of the goal

    def merit(self, end: Solved) -> tuple[float, float]:
        """Smaller is better: limits first."""
        return (0.0 if end.shortfall <= KEPT else end.shortfall), self.goal.sign * end.goal

    def judged(self, x: np.ndarray) -> Solved:
        """A point as the end of a search."""
        point, sign = self.design.point(x), self.goal.sign
        if point.reason:
            return Solved(point.x, sign * math.inf, math.inf, False)
        short, smooth = self.shortfall(point.values), False
        if not self.design.without and short <= KEPT:
            with suppress(Impossible):
                smooth = self.prices(point)[1] < STILL
        return Solved(point.x, point.values[self.goal.name], short, smooth)

    def shortfall(self, values: Mapping[str, float]) -> float:
        """Of the worst limit over its size; 0 where all hold."""
        return max((0.0, *(-i.room(values[i.name]) / i.size for i in self.limits)))

    def active(self, point: Point) -> list[Limit]:
        """Limits without room."""
        return [i for i in self.limits if i.room(point.values[i.name]) < EDGE * i.size]

    def prices(self, point: Point) -> tuple[dict[str, float], float]:
        """Prices of a unit of each active limit and of a coordinate at its bound, in units of the
        goal. Rest of the slopes that they do not balance, over the goal. Raises Impossible.
        """
        active, bounds, free = self.active(point), self.design.at_bounds(point), self.design.free
        columns = [i.sign * point.slopes[i.name] for i in active]
        columns += [-way * np.eye(len(free))[k] for k, way in bounds.items()]
        names = [i.text for i in active] + [free[k].name for k in bounds]
        slope = self.goal.sign * point.slopes[self.goal.name]
        size = abs(point.values[self.goal.name]) or 1.0
        if not columns:
            return {}, float(np.linalg.norm(slope)) / size
        table = np.stack(columns, axis=1)
        sizes = np.maximum(np.linalg.norm(table, axis=0), 1e-300)
        shares, rest = nnls(table / sizes, slope)
        return dict(zip(names, (shares / sizes).tolist(), strict=True)), float(rest) / size

    # --- the search
    def starts(self, count: int, seed: int) -> Iterator[np.ndarray]:
        """Starts: the scene, then the best of Sobol' points between the bounds, those that are near
        a better one last.
        """
        design = self.design
        yield design.inside
        if count < 2:
            return
        ends, places = [], design.spread(max(design.looked, count - 1), seed)
        for x, values in zip(places, design.look(places), strict=True):
            if all(math.isfinite(values.get(n, math.nan)) for n in design.wanted):
                ends.append(Solved(x, values[self.goal.name], self.shortfall(values), False))
        yield from design.apart(end.x for end in sorted(ends, key=self.merit))[: count - 1]

    def solved(self, x: np.ndarray, finish: float = FINISH) -> Solved:
        """The best design from a start."""
        self.size = abs(self.design.point(x).values.get(self.goal.name, 0.0)) or 1.0

        def better(best: Solved, search: Callable) -> Solved:
            return min((best, self.judged(search(best.x))), key=self.merit)

        best = self.judged(x)
        if not self.design.without:
            best = better(best, partial(self.by_slopes, finish=finish))
        return best if best.smooth else better(best, self.without_slopes)

    def scaled(self, x: np.ndarray) -> np.ndarray:
        """The goal, then the rooms of the limits, over their sizes."""
        point, goal = self.design.point(x), self.goal
        if point.reason:
            return np.array([FAILED, *[-FAILED] * len(self.limits)])
        rooms = (i.room(point.values[i.name]) / i.size for i in self.limits)
        return np.array([goal.sign * point.values[goal.name] / self.size, *rooms])

    def slopes(self, x: np.ndarray) -> np.ndarray:
        """Their slopes (values, coordinates); 0 where there are none, which ends a search."""
        point = self.design.point(x)
        rows = [(self.goal, self.size), *((i, i.size) for i in self.limits)]
        with suppress(Impossible):
            if not point.reason:
                return np.array([of.sign * point.slopes[of.name] / size for of, size in rows])
        return np.zeros((len(rows), len(x)))

    def by_slopes(self, x: np.ndarray, finish: float) -> np.ndarray:
        """The end of sequential quadratic programming."""
        rooms = {
            "type": "ineq",
            "fun": lambda x: self.scaled(x)[1:],
            "jac": lambda x: self.slopes(x)[1:],
        }
        solution = minimize(
            lambda x: self.scaled(x)[0],
            x,
            jac=lambda x: self.slopes(x)[0],
            bounds=self.design.ends,
            method="SLSQP",
            constraints=[rooms] if self.limits else [],
            options={"ftol": finish, "maxiter": MOST if finish == FINISH else MOST_LAST},
        )
        return solution.x

    def without_slopes(self, x: np.ndarray) -> np.ndarray:
        """The end of a search in a trust region with quadratic models of values alone."""
        low, width = self.design.ends[:, 0], np.ptp(self.design.ends, axis=1)

        def values(y: np.ndarray) -> np.ndarray:
            return self.scaled(low + y * width)

        inside = NonlinearConstraint(lambda y: values(y)[1:], 0.0, math.inf)
        first, last = RADIUS
        solution = minimize(
            lambda y: values(y)[0],
            (x - low) / width,
            bounds=[(0.0, 1.0)] * len(x),
            method="COBYQA",
            constraints=[inside] if self.limits else [],
            options={
                "initial_tr_radius": first,
                "final_tr_radius": last,
                "maxfev": MOST_WITHOUT * len(x),
            },
        )
        return low + solution.x * width
