"""Parameters of models of one's own: nonlinear least squares on central differences.

Parameters whose bounds are positive are searched for in their logarithms, others over their range.
Slopes are central differences. Any function of a record that changes smoothly with its parameters
can be fitted, as a simulation does up to its error. Where a function cannot be computed on the way,
that step is refused and a shorter one tried.
"""

import math
from collections.abc import Callable, Sequence

import numpy as np
from scipy.optimize import least_squares

from clearance.identify import estimation
from clearance.identify.estimation import Estimate, in_group
from clearance.identify.own import FunctionError, Own

FINISH = 1e-8  # relative change of the cost and of the parameters at which a fit ends
MOST = 60  # steps of a fit
# differences made larger; relative change of slopes by that from which they are reduced
COARSER, UNSMOOTH = 3.0, 0.2
FAILS = ValueError, ArithmeticError, RuntimeError  # of a function: that point is refused


class Search:
    """Residuals (m,) of a model and their slopes (m, p) over coordinates: logarithms, or shares of
    a range.
    """

    def __init__(self, model: Own, trials: Sequence):
        self.model, self.trials, self.evaluations, self.refused = model, trials, 0, 0
        moves = (
            [np.any([t.rate[:, i].any() for t in trials]) for i in range(3)] if model.groups else ()
        )
        still = set(model.groups) - {g for g, m in zip(model.groups, moves, strict=True) if m}
        self.still = np.array([any(in_group(p.name, g) for g in still) for p in model.parameters])
        low, high, typical = (
            np.array([getattr(p, w) for p in model.parameters]) for w in ("low", "high", "typical")
        )
        self.log, self.low, self.range = low > 0.0, low, high - low
        self.bounds = np.array([self.coordinates(low), self.coordinates(high)])
        self.typical = self.coordinates(typical)
        sizes = model.sizes(trials)
        self.sizes = [np.broadcast_to(sizes, model.observed(t).shape).ravel() for t in trials]
        self.measured = np.concatenate(
            [model.observed(t).ravel() / s for t, s in zip(trials, self.sizes, strict=True)]
        )
        self.last: tuple = ()

    def coordinates(self, values: np.ndarray) -> np.ndarray:
        """Of parameters (p,)."""
        return np.where(
            self.log, np.log(np.where(self.log, values, 1.0)), (values - self.low) / self.range
        )

    def values(self, x: np.ndarray) -> np.ndarray:
        """Parameters at coordinates (p,)."""
        return np.where(self.log, np.exp(np.where(self.log, x, 0.0)), self.low + x * self.range)

    def by_values(self, x: np.ndarray) -> np.ndarray:
        """Slopes of the parameters by the coordinates (p,)."""
        return np.where(self.log, self.values(x), self.range)

    def predicted(self, x: np.ndarray) -> np.ndarray:
        """Prediction at coordinates, over the sizes of the measured columns."""
        self.evaluations += 1
        values = self.values(x)
        parts = (
            self.model.predicted(values, t).ravel() / s
            for t, s in zip(self.trials, self.sizes, strict=True)
        )
        return np.concatenate(list(parts))

    def residuals(self, x: np.ndarray) -> np.ndarray:
        """Predicted less measured; nan where the function fails, which refuses the step."""
        if not (self.last and np.array_equal(self.last[0], x)):
            try:
                residuals = self.predicted(x) - self.measured
            except FAILS as error:
                if isinstance(error, FunctionError) and not isinstance(error.__cause__, FAILS):
                    raise  # a mistake in the function, not a point without a value
                self.refused += 1
                residuals = np.full_like(self.measured, math.nan)
            self.last = x.copy(), residuals
        return self.last[1]

    def slopes(self, x: np.ndarray, coarser: float = 1.0) -> np.ndarray:
        """Central differences within the bounds, so on one side at a bound."""
        columns, h = [], coarser * self.model.difference
        for k in range(x.size):
            if self.still[k]:
                columns.append(np.zeros_like(self.measured))
                continue
            ends = []
            for way in (h, -h):
                moved = x.copy()
                moved[k] = np.clip(x[k] + way, *self.bounds[:, k])
                ends.append((moved[k], self.predicted(moved)))
            columns.append((ends[0][1] - ends[1][1]) / (ends[0][0] - ends[1][0]))
        return np.stack(columns, axis=1)


def estimate(
    model: Own, trials: Sequence, *, starts: int, seed: int, progress: Callable
) -> Estimate:
    """Parameters of a model of one's own.

    Raises ValueError where its function fails at the first start.
    """
    search, random = Search(model, trials), np.random.default_rng(seed)
    if not np.isfinite(search.predicted(search.typical)).all():  # its errors are the user's to see
        values = ", ".join(
            f"{p.name}={v:.4g}"
            for p, v in zip(model.parameters, search.values(search.typical), strict=True)
        )
        raise ValueError(
            f"model {model.name}: its values are not finite at {values}, the first start"
        )
    begins = [search.typical, *(random.uniform(*search.bounds) for _ in range(starts - 1))]
    solved = [_solved(search, begin, k, starts, progress) for k, begin in enumerate(begins)]
    solved = [f for f in solved if f is not None]
    costs = np.array([f[0].cost for f in solved])
    best, history = solved[int(costs.argmin())]
    x, slopes = best.x, search.slopes(best.x)
    names, values = [p.name for p in model.parameters], search.values(best.x)
    covariance, wide, noise = estimation.spread(slopes, float(best.cost), search.measured.size)
    sizes = np.linalg.norm(slopes, axis=0)
    still = estimation.still_axes(model, names, sizes)
    doubts = list(estimation.bound_doubts(model, values, sizes, still))
    doubts += _unsmooth(search, x, slopes, names)
    if best.status == 0:
        doubts.append(f"the fit was still improving after {MOST} steps")
    by = search.by_values(x)
    ends = (search.values(np.clip(e, *search.bounds)) for e in (x - wide, x + wide))
    facts = {
        "noise": noise,
        "evaluations": search.evaluations,
        "refused": search.refused,
        "converged": best.status > 0,
        "still": still,
    }
    table = {
        "cost": costs,
        "evaluations": np.array([f[0].nfev for f in solved]),
        "values": np.array([search.values(f[0].x) for f in solved]),
    }
    if not model.predicts and not model.lag:
        facts |= _delay(search, best, slopes, values, names, by)
    history = np.array(history)
    return Estimate(
        values, *ends, covariance * np.outer(by, by), history, table, facts, tuple(doubts)
    )


def _solved(search: Search, begin: np.ndarray, start: int, starts: int, progress: Callable):
    """The least cost from coordinates and its history; None where the function fails there."""
    history = []

    def slopes(x):
        history.append(0.5 * float(np.sum(search.residuals(x) ** 2)))
        error = math.sqrt(2.0 * history[-1]) / (np.linalg.norm(search.measured) or 1.0)
        progress(
            f"start {start + 1} of {starts}, {search.evaluations} evaluations, NRMSE {error:.3g}"
        )
        return search.slopes(x)

    if not np.isfinite(search.residuals(begin)).all():
        return None
    free = ~search.still

    def complete(moving):
        x = begin.copy()
        x[free] = moving
        return x

    solution = least_squares(
        lambda y: search.residuals(complete(y)),
        begin[free],
        lambda y: slopes(complete(y))[:, free],
        search.bounds[:, free],
        "trf",
        FINISH,
        FINISH,
        1e-12,
        "jac",
        max_nfev=MOST,
    )
    solution.x = complete(solution.x)
    return solution, history


def _unsmooth(search: Search, x: np.ndarray, slopes: np.ndarray, names: Sequence[str]) -> list[str]:
    """Parameters in which larger differences give other slopes."""
    coarse = search.slopes(x, COARSER)
    sizes = np.maximum(np.linalg.norm(slopes, axis=0), 1e-300)
    change = np.linalg.norm(coarse - slopes, axis=0) / sizes
    return [
        f"{n}: the model is not smooth in it (slopes change by {c:.0%} with the step of their "
        f"differences): its "
        "interval means little; a larger difference=..., or a model with less error"
        for n, c in zip(names, change, strict=True)
        if c > UNSMOOTH
    ]


def _delay(search: Search, best, slopes, values, names, by) -> dict:
    """A shift in time between torque and rate, to first order; see `estimation.shifted`."""
    rises, first = [], 0
    torque = search.residuals(best.x) + search.measured
    for trial in search.trials:
        rows = search.model.observed(trial).shape
        part = torque[first : first + rows[0] * rows[1]].reshape(rows)
        rises.append(np.gradient(part, trial.step, axis=0).ravel())
        first += part.size
    shift = estimation.shifted(slopes, np.concatenate(rises), -search.residuals(best.x))
    return estimation.delay_facts(shift[0], shift[1], shift[2] * by, values, names)
