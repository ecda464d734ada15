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
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.optimize import Bounds, NonlinearConstraint, minimize, nnls

from clearance.accuracy.by_differences import (
    LOOSER,
    WIDTH,
    Impossible,
    Steps,
    method_beside,
    reason_without,
    recorded,
)
from clearance.identify.free import Beside, Free, Varying
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
NEAR = 0.25  # of the width of the bounds, between starts
HELD = 64  # points in memory
_LIMIT = re.compile(r"\s*([^<>=\s]+)\s*([<>])=?\s*(\S.*?)\s*$")


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
            self.run = design.run_of(self.scene)
            self._begin()
        except (Impossible, ValueError, ArithmeticError) as reason:
            self.reason = str(reason)

    def _begin(self) -> None:
        design, around = self.design, _Around(self.design, self.x, {}, self.design.summed)
        if design.without:
            metrics = design.summed(self.run, recorded(self.run))
        else:
            self.steps = Steps(around, self.run, LOOSER, method_beside(self.run))
            metrics = design.summed(self.run, self.steps.record)
        self.metrics = with_losses(metrics, self.scene)
        self.values = {n: m.value for n, m in self.metrics.items()}
        design.evaluations += 1
        missing = [n for n in design.wanted if not math.isfinite(self.values.get(n, math.nan))]
        if missing and design.checked:
            raise ValueError(f"its run has no {missing[0]}")

    def _along(self, number: Free | Varied) -> np.ndarray:
        """Slopes of metrics by the coordinate of a parameter, or by its value."""
        ends = self.steps.around(number, (-1, 1))
        fixed = isinstance(number, Varied)
        d = WIDTH * number.size if fixed else self.design.width
        pairs = []
        for offset in (-1, 1):
            around = _Around(self.design, self.x, {})
            of = with_losses(ends[offset], around.scene_at(number, offset))
            pairs.append(np.array([of[n].value for n in self.design.wanted]))
        return (pairs[1] - pairs[0]) / (2.0 * d)

    @cached_property
    def slopes(self) -> dict[str, np.ndarray]:
        """Slopes of metrics by the coordinates. Raises Impossible."""
        table = np.stack([self._along(p) for p in self.design.free], axis=1)
        return dict(zip(self.design.wanted, table, strict=True))

    @cached_property
    def deviations(self) -> dict[str, float]:
        """Standard deviations of metrics over the tolerances, linearised."""
        squares = np.zeros(len(self.design.wanted))
        for name, size in self.design.tolerances.items():
            k = next((k for k, p in enumerate(self.design.free) if p.name == name), None)
            if k is None:
                at = abs(varied(self.scene, name, size).value)
                slope = self._along(varied(self.scene, name, max(at, size)))
            else:
                free = self.design.free[k]
                by = free.slope(float(self.x[k]))
                slope = np.array([self.slopes[n][k] for n in self.design.wanted]) / by
            squares += (slope * size) ** 2
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

    def merit(self, sign: int) -> tuple[float, float]:
        """Smaller is better: limits first."""
        return (0.0 if self.shortfall <= KEPT else self.shortfall), sign * self.goal


class Design(Varying):
    """A scene with free parameters, a goal and limits.

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
        self.evaluations, self.checked = 0, False
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
        self.wanted, self.checked = list(dict.fromkeys(names)), True
        self._points.clear()

    def prepared(self, scene: Scene, **options) -> Run:
        """A run, with the ledger that losses come from."""
        shared = {n: self.options[n] for n in SHARED if n in self.options}
        return prepare(scene, **shared | options)

    def run_of(self, scene: Scene) -> Run:
        """The run of a scene that has not begun."""
        return self.prepared(scene, **self.options)

    def summed(self, run: Run, record: MemoryRecord) -> dict[str, Metric]:
        """Metrics of a run."""
        ideal = None
        if not self.checked or any("_deviation" in n for n in self.wanted):
            ideal = ideal_motion(run.mechanism.scene, run.span, record.scene)
        return of_point(record, self.settle, ideal)

    def point(self, x: np.ndarray) -> Point:
        """A point, remembered."""
        x = np.clip(np.asarray(x, float), *self.ends.T)
        if (key := x.tobytes()) not in self._points:
            if len(self._points) >= HELD:
                self._points.pop(next(iter(self._points)))
            self._points[key] = Point(self, x)
        return self._points[key]

    # --- the search
    def solved(
        self, x: np.ndarray, goal: Goal, limits: Sequence[Limit], finish: float = FINISH
    ) -> Solved:
        """The best design from a start."""
        problem = _Scaled(self, goal, tuple(limits), self.point(x))
        best = self.judged(np.asarray(x, float), goal, limits)
        if not self.without:
            best = min(
                (best, self.judged(problem.by_slopes(x, finish), goal, limits)),
                key=lambda s: s.merit(goal.sign),
            )
        if not best.smooth:
            other = self.judged(problem.without_slopes(best.x), goal, limits)
            best = min((best, other), key=lambda s: s.merit(goal.sign))
        return best

    def judged(self, x: np.ndarray, goal: Goal, limits: Sequence[Limit]) -> Solved:
        """A point as the end of a search."""
        point = self.point(x)
        if point.reason:
            return Solved(point.x, goal.sign * math.inf, math.inf, False)
        short, smooth = shortfall(point.values, limits), False
        if not self.without and short <= KEPT:
            try:
                _, rest = self.prices(point, goal, limits)
                smooth = rest < STILL
            except Impossible:
                smooth = False
        return Solved(point.x, point.values[goal.name], short, smooth)

    def active(self, point: Point, limits: Sequence[Limit]) -> list[Limit]:
        """Limits without room."""
        return [i for i in limits if i.room(point.values[i.name]) < EDGE * i.size]

    def at_bounds(self, point: Point) -> dict[int, int]:
        """Parameters at a bound by their place: -1 at the lower, 1 at the upper one."""
        (low, high), edge = self.ends.T, EDGE * np.ptp(self.ends, axis=1)
        at = {int(k): -1 for k in np.flatnonzero(point.x < low + edge)}
        return at | {int(k): 1 for k in np.flatnonzero(point.x > high - edge)}

    def prices(
        self, point: Point, goal: Goal, limits: Sequence[Limit]
    ) -> tuple[dict[str, float], float]:
        """Prices of a unit of each active limit and of a coordinate at its bound, in units of the
        goal. Rest of the slopes that they do not balance, over the goal. Raises Impossible.
        """
        active, bounds = self.active(point, limits), self.at_bounds(point)
        columns = [i.sign * point.slopes[i.name] for i in active]
        columns += [-way * np.eye(len(self.free))[k] for k, way in bounds.items()]
        names = [i.text for i in active] + [self.free[k].name for k in bounds]
        slope, size = goal.sign * point.slopes[goal.name], abs(point.values[goal.name]) or 1.0
        if not columns:
            return {}, float(np.linalg.norm(slope)) / size
        table = np.stack(columns, axis=1)
        sizes = np.maximum(np.linalg.norm(table, axis=0), 1e-300)
        shares, rest = nnls(table / sizes, slope)
        return dict(zip(names, (shares / sizes).tolist(), strict=True)), float(rest) / size

    def look(self, places: np.ndarray) -> list[dict[str, float]]:
        """Metrics at coordinates (points, parameters); empty where there is no run."""
        return [self.point(x).values for x in places]

    def starts(
        self, count: int, seed: int, goal: Goal, limits: Sequence[Limit], looked: int
    ) -> Iterator[np.ndarray]:
        """Starts: the scene, then the best of Sobol' points between the bounds, those that are near
        a better one last.
        """
        yield self.inside
        if count < 2:
            return
        ends, places = [], self.spread(max(looked, count - 1), seed)
        for x, values in zip(places, self.look(places), strict=True):
            if all(math.isfinite(values.get(n, math.nan)) for n in self.wanted):
                ends.append(Solved(x, values[goal.name], shortfall(values, limits), False))
        ends.sort(key=lambda s: s.merit(goal.sign))
        apart: list[np.ndarray] = []
        for x in (s.x for s in ends):
            if all(np.max(np.abs(x - a) / np.ptp(self.ends, axis=1)) > NEAR for a in apart):
                apart.append(x)
        near = [s.x for s in ends if not any(s.x is a for a in apart)]
        yield from [*apart, *near][: count - 1]


class _Scaled:
    """Goal and limits over their sizes, as functions of the coordinates."""

    def __init__(self, design: Design, goal: Goal, limits: tuple[Limit, ...], start: Point):
        self.design, self.goal, self.limits = design, goal, limits
        self.size = abs(start.values.get(goal.name, 0.0)) or 1.0

    def cost(self, x: np.ndarray) -> float:
        """The scaled goal."""
        point = self.design.point(x)
        return FAILED if point.reason else self.goal.sign * point.values[self.goal.name] / self.size

    def cost_slope(self, x: np.ndarray) -> np.ndarray:
        """Its slopes; 0 where there are none, which ends a search."""
        slopes = self._slopes(x)
        if slopes is None:
            return np.zeros(len(x))
        return self.goal.sign * slopes[self.goal.name] / self.size

    def rooms(self, x: np.ndarray) -> np.ndarray:
        """Room of each limit over its size."""
        point = self.design.point(x)
        if point.reason:
            return np.full(len(self.limits), -FAILED)
        return np.array([i.room(point.values[i.name]) / i.size for i in self.limits])

    def room_slopes(self, x: np.ndarray) -> np.ndarray:
        """Slopes of the rooms, (limits, coordinates)."""
        slopes = self._slopes(x)
        if slopes is None:
            return np.zeros((len(self.limits), len(x)))
        return np.array([i.sign * slopes[i.name] / i.size for i in self.limits])

    def _slopes(self, x: np.ndarray) -> dict[str, np.ndarray] | None:
        point = self.design.point(x)
        try:
            return None if point.reason else point.slopes
        except Impossible:
            return None

    def by_slopes(self, x: np.ndarray, finish: float) -> np.ndarray:
        """The end of sequential quadratic programming."""
        rooms = {"type": "ineq", "fun": self.rooms, "jac": self.room_slopes}
        solution = minimize(
            self.cost,
            x,
            jac=self.cost_slope,
            bounds=self.design.ends,
            method="SLSQP",
            constraints=[rooms] if self.limits else [],
            options={"ftol": finish, "maxiter": MOST if finish == FINISH else MOST_LAST},
        )
        return solution.x

    def without_slopes(self, x: np.ndarray) -> np.ndarray:
        """The end of a search in a trust region with quadratic models of values alone."""
        low, width = self.design.ends[:, 0], np.ptp(self.design.ends, axis=1)
        inside = NonlinearConstraint(lambda y: self.rooms(low + y * width), 0.0, math.inf)
        first, last = RADIUS
        solution = minimize(
            lambda y: self.cost(low + y * width),
            (x - low) / width,
            bounds=Bounds(np.zeros(len(x)), np.ones(len(x))),
            method="COBYQA",
            constraints=[inside] if self.limits else [],
            options={
                "initial_tr_radius": first,
                "final_tr_radius": last,
                "maxfev": MOST_WITHOUT * len(x),
            },
        )
        return low + solution.x * width


def shortfall(values: Mapping[str, float], limits: Sequence[Limit]) -> float:
    """Of the worst limit over its size; 0 where all hold."""
    return max((0.0, *(-i.room(values[i.name]) / i.size for i in limits)))


def with_margins(limits: Sequence[Limit], margins: Mapping[str, float]) -> list[Limit]:
    """Limits with margins by their texts."""
    return [replace(i, margin=margins.get(i.text, 0.0)) for i in limits]
