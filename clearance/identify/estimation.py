"""Estimation of the parameters of friction models.

Nonlinear least squares (trust region, bounds, static torque not below the kinetic one) in
the logarithms of the parameters, from exact slopes. Axes that no trial couples are fitted
each for itself; starts are compared on a part of the samples, the best are followed on all. After
each pass over the samples the residuals r and slopes J are reduced to a triangle. It has the same
J^T J, J^T r and r^T r. The steps of scipy are therefore those with all rows, at no cost. A model
that is linear in its parameters takes one linear step.
Functions of one's own have central differences in place of exact slopes: any that changes smoothly
with its parameters can be fitted, as a simulation does up to its error. Where a function cannot be
computed on the way, that step is refused and a shorter one tried.
"""

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares, lsq_linear

from clearance.identify.measured import parts_of
from clearance.identify.models import LuGre, Model
from clearance.identify.own import FunctionError
from clearance.identify.trials import Trial
from clearance.metrics.statistics import student

# relative change of the cost at which a start is judged, and the best one is finished
LOOK, FINISH = 1e-3, 1e-9
FINISH_NETWORK = 1e-5  # the same of networks, whose weights make up for each other
FINISH_FUNCTION, MOST_FUNCTION = 1e-8, 60  # that of functions, and their steps
# differences made larger; relative change of slopes by that from which they are reduced
COARSER, UNSMOOTH = 3.0, 0.2
FLAT = 1e-12  # gradient of the cost at which it ends
EXACT = 1e-14  # of the cost of a linear model
FAILS = ValueError, ArithmeticError, RuntimeError  # of a function: that point is refused
MOST_LOOKS, MOST = 25, 300  # passes over the samples of a start, and of the finish
# samples of a trial that starts are judged by, at least; one in so many of them, at most
FEW, MOST_THINNED = 1000, 10
FOLLOWED = 3  # starts that are followed on all samples
# starts agree within this NRMSE; reduced where fewer than this share of them do
NEAR, ENOUGH = 0.005, 0.2
HUGE = 1e100  # N m, whose square is a number
MOST_STARTS = 10_000
STARTS = 20  # of a nonlinear fit, where the call gives no other
# of singular values of slopes whose columns have the norm 1, after their products were taken
ROUNDING = 1e-8
TINY = 1e-12  # of a value, below which its relative change is not compared
BLIND = 1e-12  # share of a parameter in the cost's curvature below which the samples do not see it


@dataclass(frozen=True, eq=False)
class Estimate:
    """Result of an estimation: values (p,), low and high (p,) of 95 % intervals, covariance (p, p).

    history: cost over the iterations (of those on a part of the samples, in proportion); starts:
        columns of the table of starts; facts, warnings. A model without intervals leaves low, high
        and covariance empty.
    """

    values: np.ndarray
    low: np.ndarray
    high: np.ndarray
    covariance: np.ndarray
    history: np.ndarray
    starts: dict[str, np.ndarray]
    facts: dict = field(default_factory=dict)
    doubts: tuple[str, ...] = ()


def axes_of(trial) -> np.ndarray:
    return np.flatnonzero(trial.measured)


# --- what estimations share
def triangle(slopes: np.ndarray, residuals: np.ndarray) -> np.ndarray:
    """(p + 1, p + 1): of the same products among columns as slopes (m, p) and residuals (m,) beside
    them.
    """
    p = slopes.shape[1]
    products = np.empty((p + 1, p + 1))
    products[:p, :p] = slopes.T @ slopes
    products[p, :p] = products[:p, p] = slopes.T @ residuals
    products[p, p] = residuals @ residuals
    sizes = np.sqrt(np.diag(products))
    scale = np.where(sizes > 0.0, sizes, 1.0)
    powers, directions = np.linalg.eigh(products / np.outer(scale, scale))
    # columns of zeros stay that
    return np.sqrt(np.maximum(powers, 0.0))[:, None] * directions.T * sizes


def spread(slopes: np.ndarray, cost: float, samples: int) -> tuple[np.ndarray, np.ndarray, float]:
    """Covariance (p, p), half widths (p,) of 95 % intervals, and standard deviation of a sample's
    error.

    slopes (m, p) at the least cost, half the sum of squares, of so many samples. Directions that
    the samples do not see come out very wide, not infinite.
    """
    freedom = max(samples - slopes.shape[1], 1)
    variance = 2.0 * cost / freedom
    sizes = np.linalg.norm(slopes, axis=0)
    sizes[sizes == 0.0] = 1e-12
    _, singular, rows = np.linalg.svd(slopes / sizes, full_matrices=False)
    inverse = rows.T / np.maximum(singular, ROUNDING)
    covariance = variance * (inverse @ inverse.T) / np.outer(sizes, sizes)
    wide = student(freedom) * np.sqrt(np.diag(covariance))
    return covariance, wide, math.sqrt(variance)


def least(
    errors: Callable,
    slopes: Callable,
    begin: np.ndarray,
    free: np.ndarray,
    bounds: np.ndarray,
    ends: tuple[float, float, int],
):
    """The least sum of squares from coordinates of which the free ones move between bounds (2, p).

    ends: relative change, gradient and number of evaluations at which the search ends. The result
    is that of scipy, with all coordinates.
    """

    def complete(moving: np.ndarray) -> np.ndarray:
        y = begin.copy()
        y[free] = moving
        return y

    change, gradient, most = ends
    solution = least_squares(
        lambda moving: errors(complete(moving)),
        begin[free],
        lambda moving: slopes(complete(moving))[:, free],
        bounds[:, free],
        x_scale="jac",
        ftol=change,
        xtol=change,
        gtol=gradient,
        max_nfev=most,
    )
    solution.x = complete(solution.x)
    return solution


def still_axes(model: Model, names: list[str], sizes: np.ndarray) -> list[str]:
    """Axes (spin, tilt ...) that never move: samples (slopes of these sizes) see none of their
    numbers.
    """
    seen = [n for n, size in zip(names, sizes, strict=True) if size > BLIND * sizes.max()]
    return [g for g in dict.fromkeys(model.groups) if not any(in_group(n, g) for n in seen)]


def in_group(name: str, group: str) -> bool:
    """True for a parameter of an axis, such as spin_static of spin."""
    return name.startswith(f"{group}_")


def bound_doubts(
    model: Model, values: np.ndarray, sizes: np.ndarray, still: Sequence[str]
) -> tuple[str, ...]:
    """Axes that never move; parameters that samples (slopes of these sizes) do not see, or that end
    at a bound.
    """
    doubts = [f"{group}: no trial moves it, its parameters are not fitted" for group in still]
    by_name = dict(zip((p.name for p in model.parameters), values, strict=True))
    for p, value, size in zip(model.parameters, values, sizes, strict=True):
        if any(in_group(p.name, group) for group in still):
            continue
        lower = p.name.replace("_static", "_kinetic")
        if size <= BLIND * sizes.max():
            doubts.append(f"{p.name}: the trials do not determine it")
        elif not p.low * (1.0 + 1e-3) < value < p.high * (1.0 - 1e-3) and p.low >= 0.0:
            doubts.append(f"{p.name}: ends at a bound, {value:.4g} {p.units}")
        elif lower != p.name and value < by_name.get(lower, 0.0) * (1.0 + 1e-3):
            doubts.append(f"{p.name}: ends at {lower}, below which it cannot go")
    return tuple(doubts)


# --- nonlinear models
class Search:
    """Coordinates of a nonlinear fit: logarithms of parameters whose bounds are positive, others as
    they are.

    `natural` ones are those. `searched` ones have for a kinetic torque its place between its lower
    bound (0) and the static torque (1), in the logarithm. A box of them holds all values with
    static >= kinetic and keeps all bounds.
    """

    def __init__(self, model: Model):
        self.model, parameters = model, model.parameters
        names = [p.name for p in parameters]
        self.log = np.array([p.low > 0.0 and not model.linear for p in parameters])
        ends = np.array([(p.low, p.high, p.typical) for p in parameters]).T
        self.low, self.high, self.typical = np.log(ends, where=self.log, out=ends)
        kinetic = [n for n in names if n.endswith("_kinetic")] if isinstance(model, LuGre) else []
        self.pairs = [
            (names.index(n), names.index(n.replace("_kinetic", "_static"))) for n in kinetic
        ]
        self.bounds = np.array([self.low, self.high])
        for k, s in self.pairs:
            self.bounds[:, k] = 0.0, 1.0
            self.bounds[0, s] = max(self.low[s], self.low[k])
            if self.bounds[0, s] >= self.high[s]:
                raise ValueError(
                    f"bounds of {names[k]} and {names[s]} leave no static torque above the kinetic "
                    f"one"
                )

    def values(self, x: np.ndarray) -> np.ndarray:
        """Parameters at natural coordinates (p,)."""
        return np.where(self.log, np.exp(np.where(self.log, x, 0.0)), x)

    def slopes(self, x: np.ndarray) -> np.ndarray:
        """Slopes of the parameters by the natural coordinates (p,)."""
        return np.where(self.log, self.values(x), 1.0)

    def natural(self, y: np.ndarray) -> np.ndarray:
        """Natural coordinates at searched ones."""
        x = y.copy()
        for k, s in self.pairs:
            x[k] = self.low[k] + y[k] * (min(self.high[k], y[s]) - self.low[k])
        return x

    def searched(self, x: np.ndarray) -> np.ndarray:
        """Searched coordinates at natural ones, moved to where static >= kinetic."""
        y = np.clip(x, self.bounds[0], self.bounds[1])
        for k, s in self.pairs:
            room = min(self.high[k], y[s]) - self.low[k]
            y[k] = min(max((x[k] - self.low[k]) / room, 0.0), 1.0) if room > 0.0 else 1.0
        return y

    def chained(self, slopes: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Slopes (m, p) by natural coordinates, as such by searched ones."""
        chain = slopes.copy()
        for k, s in self.pairs:
            chain[:, k] = slopes[:, k] * (min(self.high[k], y[s]) - self.low[k])
            chain[:, s] = slopes[:, s] + (y[k] * slopes[:, k] if y[s] < self.high[k] else 0.0)
        return chain


def _thinned(trial: Trial) -> Trial:
    """Every so many samples of a trial."""
    every = min(max(trial.samples // FEW, 1), MOST_THINNED)
    columns = {n: getattr(trial, n) for n in ("time", "rate", "torque", "turned")}
    thinned = {n: v if v is None else np.ascontiguousarray(v[::every]) for n, v in columns.items()}
    return replace(trial, **thinned)


class Passes:
    """Residuals of axes (a list of them a trial) and slopes by natural coordinates, as triangles;
    counts its passes.
    """

    look, most_looks, most = LOOK, MOST_LOOKS, MOST
    refused = 0

    def __init__(self, search: Search, trials: Sequence, axes: Sequence[np.ndarray]):
        self.search, self.trials, self.axes = search, trials, axes
        self.model = model = search.model
        self.rows = parts_of(t.samples * a.size for t, a in zip(trials, axes, strict=True))
        self.measured = np.concatenate(
            [t.torque[:, a].ravel() for t, a in zip(trials, axes, strict=True)]
        )
        self.torque = np.empty(self.measured.size)
        self.slopes = np.empty((self.measured.size, len(model.parameters)))
        rows, wanted = model.roughness
        self.smooth = np.column_stack([rows, -wanted]) * np.linalg.norm(self.measured)
        self.evaluations, self.last = 0, None
        self.finish = FINISH_NETWORK if getattr(model, "network", 0) else FINISH

    def reduced(self, x: np.ndarray) -> np.ndarray:
        """Slopes and residuals at natural coordinates x: the samples' triangle, below it the
        smoothing.
        """
        if self.last is not None and np.array_equal(self.last[0], x):
            return self.last[1]
        values = self.search.values(x)
        for trial, axes, rows in zip(self.trials, self.axes, self.rows, strict=True):
            torque, slopes = self.model.sensitivity(values, trial)
            self.torque[rows] = torque[:, axes].ravel()
            self.slopes[rows] = slopes[:, axes].reshape(-1, values.size)
            if not abs(self.torque[rows]).max() < HUGE:
                text = ", ".join(
                    f"{p.name} {v:.4g}" for p, v in zip(self.model.parameters, values, strict=True)
                )
                raise ValueError(
                    f"trial {trial.name!r}: the modelled torque is beyond all numbers at {text}"
                )
        self.evaluations += 1
        compressed = triangle(self.slopes[:, : values.size], self.torque - self.measured)
        compressed[:, :-1] *= self.search.slopes(x)
        compressed = np.vstack(
            [compressed, np.column_stack([self.smooth[:, :-1], self.smooth @ np.append(x, 1.0)])]
        )
        self.last = x.copy(), compressed
        return compressed

    def cost(self, x: np.ndarray) -> float:
        """Half the sum of squares at natural coordinates, without slopes."""
        values, pairs = self.search.values(x), zip(self.trials, self.axes, strict=True)
        rows = [(self.model.torque(values, t) - t.torque)[:, a] for t, a in pairs]
        return 0.5 * sum(np.sum(e**2) for e in (*rows, self.smooth @ np.append(x, 1.0)))

    def cost_of_samples(self, x: np.ndarray) -> float:
        """Half the sum of squares of the samples alone."""
        errors = self.errors(x)[: x.size + 1]
        return 0.5 * float(errors @ errors)

    def errors(self, x: np.ndarray) -> np.ndarray:
        """Numbers whose squares a fit makes small, at natural coordinates."""
        return self.reduced(x)[:, -1]

    def jacobian(self, x: np.ndarray) -> np.ndarray:
        """Its slopes."""
        return self.reduced(x)[:, :-1]

    def seen(self, x: np.ndarray) -> np.ndarray:
        """Sizes of the slopes of the samples alone (p,)."""
        return np.linalg.norm(self.reduced(x)[: x.size + 1, :-1], axis=0)

    def of_samples(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, list]:
        """Slopes by the values (m, p), and the prediction (m,), of all samples; rows of trials."""
        self.reduced(x)
        return self.slopes[:, : x.size], self.torque, self.rows

    def solved(self, begin: np.ndarray, free: np.ndarray, change: float, most: int) -> "Solved":
        """The least cost from searched coordinates, of which the free ones move."""
        history, before, search = [], self.evaluations, self.search

        def jacobian(y):
            x = search.natural(y)
            history.append(0.5 * float(np.sum(self.errors(x) ** 2)))
            self.tell(history[-1])
            return search.chained(self.jacobian(x), y)

        if self.model.linear:
            slopes, rest = self.jacobian(begin)[:, free], self.errors(begin)
            wanted = slopes @ begin[free] - rest
            solution = lsq_linear(slopes, wanted, search.bounds[:, free], method="bvls", tol=EXACT)
            end = begin.copy()
            end[free] = solution.x
            cost = self.cost(end)
            return Solved(end, cost, [cost], 1, solution.success)
        if not np.isfinite(self.errors(search.natural(begin))).all():
            return Solved(begin, math.inf, [math.inf], self.evaluations - before, True)
        solution = least(
            lambda y: self.errors(search.natural(y)),
            jacobian,
            begin,
            free,
            search.bounds,
            (change, FLAT, most),
        )
        cost, passes = float(solution.cost), self.evaluations - before
        return Solved(solution.x, cost, history, passes, solution.status > 0)

    def tell(self, cost: float) -> None:
        """Nothing: passes are fast."""

    def doubts(self, x: np.ndarray) -> list[str]:
        """Warnings about the slopes: none, they are exact."""
        return []


class Differences(Passes):
    """The same of a function of a record, over the sizes of its columns, and slopes by central
    differences.
    """

    look = finish = FINISH_FUNCTION
    most_looks = most = MOST_FUNCTION

    def __init__(self, search: Search, trials: Sequence, report: Callable):
        self.search, self.trials, self.report = search, trials, report
        self.model = model = search.model
        sizes = model.sizes(trials)
        observed = [model.observed(t) for t in trials]
        self.rows = parts_of(o.size for o in observed)
        self.sizes = [np.broadcast_to(sizes, o.shape).ravel() for o in observed]
        self.measured = np.concatenate([o.ravel() for o in observed]) / np.concatenate(self.sizes)
        self.evaluations, self.last = 0, None

    def predicted(self, x: np.ndarray) -> np.ndarray:
        """Prediction at natural coordinates, over the sizes of the measured columns."""
        self.evaluations += 1
        values = self.search.values(x)
        pairs = zip(self.trials, self.sizes, strict=True)
        return np.concatenate([self.model.predicted(values, t).ravel() / s for t, s in pairs])

    def errors(self, x: np.ndarray) -> np.ndarray:
        """Predicted less measured; nan where the function fails, which refuses the step."""
        if self.last is None or not np.array_equal(self.last[0], x):
            try:
                errors = self.predicted(x) - self.measured
            except FAILS as error:
                if isinstance(error, FunctionError) and not isinstance(error.__cause__, FAILS):
                    raise  # a mistake in the function, not a point without a value
                self.refused += 1
                errors = np.full_like(self.measured, math.nan)
            self.last = x.copy(), errors
        return self.last[1]

    def cost(self, x: np.ndarray) -> float:
        """Half the sum of squares at natural coordinates."""
        errors = self.errors(x)
        return 0.5 * float(errors @ errors) if np.isfinite(errors).all() else math.inf

    cost_of_samples = cost

    def jacobian(self, x: np.ndarray, coarser: float = 1.0) -> np.ndarray:
        """Central differences within the bounds, so on one side at a bound."""
        columns, search = [], self.search
        steps = (
            coarser * self.model.difference * np.where(search.log, 1.0, search.high - search.low)
        )
        for k, step in enumerate(steps):
            ends = []
            for way in (step, -step):
                moved = x.copy()
                moved[k] = np.clip(x[k] + way, search.low[k], search.high[k])
                ends.append((moved[k], self.predicted(moved)))
            columns.append((ends[0][1] - ends[1][1]) / (ends[0][0] - ends[1][0]))
        return np.stack(columns, axis=1)

    def of_samples(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, list]:
        """Slopes by the values, and the prediction; rows of trials."""
        return self.slopes / self.search.slopes(x), self.errors(x) + self.measured, self.rows

    def seen(self, x: np.ndarray) -> np.ndarray:
        """Sizes of the slopes (p,)."""
        self.slopes = self.jacobian(x)
        return np.linalg.norm(self.slopes, axis=0)

    def tell(self, cost: float) -> None:
        """Evaluations and error so far."""
        error = math.sqrt(2.0 * cost) / (np.linalg.norm(self.measured) or 1.0)
        self.report(f"{self.evaluations} evaluations, NRMSE {error:.3g}")

    def doubts(self, x: np.ndarray) -> list[str]:
        """Parameters in which larger differences give other slopes than those of `seen`."""
        sizes = np.maximum(np.linalg.norm(self.slopes, axis=0), 1e-300)
        change = np.linalg.norm(self.jacobian(x, COARSER) - self.slopes, axis=0) / sizes
        return [
            f"{p.name}: the model is not smooth in it (slopes change by {c:.0%} with the step of "
            f"their differences): its interval means little; a larger difference=..., or a model "
            f"with less error"
            for p, c in zip(self.model.parameters, change, strict=True)
            if c > UNSMOOTH
        ]


def _delay(passes: Passes, x: np.ndarray, names: Sequence[str]) -> dict:
    """Time [s] by which the measured torque comes after its rate and its error, as facts of a fit,
    with the parameter that it moves most.

    It is that of least squares at natural coordinates x: of the errors on the slopes by the
    parameters and on the rate of change of the torque [1/s].
    """
    slopes, torque, parts = passes.of_samples(x)
    rises = [
        np.gradient(torque[rows].reshape(t.samples, -1), t.step, axis=0).ravel()
        for t, rows in zip(passes.trials, parts, strict=True)
    ]
    late = np.column_stack([slopes, -np.concatenate(rises)])
    *columns, errors = triangle(late, passes.measured - torque).T
    columns = np.array(columns).T
    sizes = np.linalg.norm(columns, axis=0)
    sizes[sizes == 0.0] = 1.0
    step = np.linalg.lstsq(columns / sizes, errors, ROUNDING)[0] / sizes
    residuals = errors - columns @ step
    covariance, *_ = spread(columns, 0.5 * float(residuals @ residuals), torque.size)
    values = np.maximum(abs(passes.search.values(x)), TINY)
    return {
        "lag": float(step[-1]),
        "lag_error": math.sqrt(covariance[-1, -1]),
        "lag_moves": names[int(np.argmax(abs(step[:-1]) / values))],
    }


class Solved(NamedTuple):
    """Searched coordinates, their cost, its history, passes over the samples, convergence."""

    point: np.ndarray
    cost: float
    history: list[float]
    evaluations: int
    converged: bool

    def then(self, further: "Solved") -> "Solved":
        """The end of a search that went on from this one."""
        history = self.history + further.history
        return further._replace(history=history, evaluations=self.evaluations + further.evaluations)


@dataclass(frozen=True, eq=False)
class Part:
    """Parameters that trials see together, and those trials' axes: a fit of its own."""

    free: np.ndarray
    trials: list
    axes: list[np.ndarray]

    def passes(self, search: Search, report: Callable) -> Passes:
        """Its residuals."""
        if search.model.exact:
            return Passes(search, self.trials, self.axes)
        return Differences(search, self.trials, report)


def parts(search: Search, trials: Sequence) -> list[Part]:
    """The fit taken apart: trials of one axis each give nothing about the parameters of other
    axes.
    """
    model, p = search.model, search.low.size
    if not model.exact:
        return [Part(np.full(p, True), list(trials), [])]
    pieces = [(trial, axis) for trial in trials for axis in axes_of(trial)]
    # beside the typical values: where two of them are equal, others may not be seen
    probe = search.typical + np.linspace(0.01, 0.02, p) * (search.high - search.typical)
    alone = (Passes(search, [t], [np.array([a])]) for t, a in pieces)
    seen = np.array([passes.seen(probe) > 0.0 for passes in alone])
    rows = np.vstack([seen, model.roughness[0] != 0.0])
    together = rows.T @ rows | np.eye(p, dtype=bool)
    for _ in range(p.bit_length()):
        together = together @ together
    first = together.argmax(axis=1)
    apart = []
    for label in dict.fromkeys(first[row.argmax()] for row in seen if row.any()):
        here = [pieces[k] for k in np.flatnonzero(seen[:, first == label].any(axis=1))]
        ours = {id(trial): trial for trial, _ in here}.values()
        axes = [np.array([a for t, a in here if t is trial]) for trial in ours]
        apart.append(Part(first == label, list(ours), axes))
    return apart


class Found(NamedTuple):
    """Ends of all starts of a part, and the norm of its measured torques."""

    ends: list[Solved]
    size: float

    @property
    def end(self) -> Solved:
        """The best of them."""
        return min(self.ends, key=lambda e: e.cost)

    @property
    def agreeing(self) -> int:
        """Number of starts that came near the least cost."""
        errors = np.sqrt(2.0 * np.array([e.cost for e in self.ends])) / self.size
        return int(np.sum(errors <= errors.min() + NEAR))


def _solve(
    search: Search, part: Part, begins: list[np.ndarray], tell: Callable, report: Callable
) -> Found:
    """The best of several starts: all on few samples, the best of those on all, and the best one to
    the end.
    """
    looks = passes = part.passes(search, report)
    exact = search.model.exact
    if len(begins) > 1 and exact:
        looks = Passes(search, [_thinned(t) for t in part.trials], part.axes)
    scale = (np.linalg.norm(passes.measured) / (np.linalg.norm(looks.measured) or 1.0)) ** 2
    ends = []
    for begin in begins:
        end = looks.solved(begin, part.free, looks.look, looks.most_looks)
        if looks is not passes:
            history = [scale * cost for cost in end.history]
            end = end._replace(cost=passes.cost(search.natural(end.point)), history=history)
        ends.append(end)
        tell()

    def follow(n: int, change: float, most: int) -> None:
        ends[n] = ends[n].then(passes.solved(ends[n].point, part.free, change, most))

    ranked = np.argsort([e.cost for e in ends], kind="stable")
    for n in ranked[:FOLLOWED] if looks is not passes else ():
        follow(n, LOOK, MOST_LOOKS)
    if exact:
        follow(int(np.argmin([e.cost for e in ends])), passes.finish, passes.most)
    return Found(ends, float(np.linalg.norm(passes.measured)) or 1.0)


def estimate(
    model: Model, trials: Sequence, *, starts: int, seed: int, progress: Callable
) -> Estimate:
    """Parameters from the torques, or from the columns that a function predicts.

    Raises ValueError where a function fails at the first start.
    """
    search, random = Search(model), np.random.default_rng(seed)
    starts = 1 if model.linear else starts
    typical = search.searched(search.typical)
    begins = [typical, *(random.uniform(*search.bounds) for _ in range(starts - 1))]
    for begin in begins:
        begin[model.centred] = typical[model.centred]
    axes = [axes_of(t) for t in trials] if model.exact else []
    complete = Part(np.full(typical.size, True), list(trials), axes)
    passes = complete.passes(search, progress)
    _check_start(passes)
    split, done = parts(search, trials), itertools.count(1)

    def tell():
        progress(next(done) / (len(split) * (starts + 1)))

    solutions, points, end = [], np.tile(typical, (starts, 1)), typical.copy()
    for part in split:
        of_part = [np.where(part.free, b, typical) for b in begins]
        solutions.append(_solve(search, part, of_part, tell, progress))
        end[part.free] = solutions[-1].end.point[part.free]
        points[:, part.free] = np.array([e.point for e in solutions[-1].ends])[:, part.free]
        tell()
    x = search.natural(end)
    values, sizes, cost = search.values(x), passes.seen(x), passes.cost_of_samples(x)
    covariance, wide, noise = spread(passes.jacobian(x), cost, passes.measured.size)
    ends = (search.values(np.clip(e, search.low, search.high)) for e in (x - wide, x + wide))
    slopes, names = search.slopes(x), [q.name for q in model.parameters]
    still = still_axes(model, names, sizes)
    doubts = bound_doubts(model, values, sizes, still) + _start_doubts(solutions, passes.most)
    no_lag = model.lag or model.linear or getattr(model, "predicts", None)
    histories = [f.end.history for f in solutions]
    longest = max(map(len, histories))
    blind = passes.cost(x) - sum(f.end.cost for f in solutions)  # of axes that no parameter moves
    table = {
        "cost": sum(np.array([e.cost for e in f.ends]) for f in solutions) + blind,
        "evaluations": sum(np.array([e.evaluations for e in f.ends]) for f in solutions),
        "values": np.array([search.values(search.natural(y)) for y in points]),
    }
    facts = {
        "noise": noise,
        "evaluations": int(table["evaluations"].sum()),
        "agreeing": min(f.agreeing for f in solutions),
        "converged": all(f.end.converged for f in solutions),
        "still": still,
        **({} if model.exact else {"refused": passes.refused}),
        **({} if no_lag else _delay(passes, x, names)),
    }
    return Estimate(
        values,
        *ends,
        covariance * np.outer(slopes, slopes),
        sum(np.pad(h, (0, longest - len(h)), "edge") for h in histories) + blind,
        table,
        facts,
        (*doubts, *passes.doubts(x)),
    )


def _check_start(passes: Passes) -> None:
    """Raises ValueError for a function without values at the first start; its errors are the
    user's to see.
    """
    model, typical = passes.model, passes.search.typical
    if model.exact:
        passes.errors(typical)
    elif not np.isfinite(passes.predicted(typical)).all():
        numbers = zip(model.parameters, passes.search.values(typical), strict=True)
        values = ", ".join(f"{p.name}={v:.4g}" for p, v in numbers)
        raise ValueError(
            f"model {model.name}: its values are not finite at {values}, the first start"
        )


def _start_doubts(solutions: Sequence[Found], most: int) -> tuple[str, ...]:
    doubts = []
    starts = len(solutions[0].ends)
    fewest = min(f.agreeing for f in solutions)
    if starts >= 5 and fewest < ENOUGH * starts:
        doubts.append(
            f"only {fewest} of {starts} starts came within an NRMSE of {NEAR:g} of the best one: a "
            f"better one may "
            "have been missed; try more starts or another seed"
        )
    if not all(f.end.converged for f in solutions):
        doubts.append(f"the fit was still improving after {most} passes over the samples")
    return tuple(doubts)
