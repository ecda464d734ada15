"""The verdict on the fit of a mechanism: intervals, correlations, profiles, checks.

    C = s^2 tau (J^T J)^-1        s^2: of the residuals, 1 where the errors are known
    interval  x +- t sd           in the logarithm of positive parameters, t of 95 %

tau is the autocorrelation time of the residuals, in values, where they are not independent: n
values are worth n / tau facts. Where an interval is wider than WIDE or two parameters are
correlated by more than CORRELATED, the interval is that of the profile likelihood: the least cost
with the parameter held grows by t^2 s^2 tau / 2. Parameters of wide intervals correlated by more
than TOGETHER are inseparable where the cost stays half of the way to their bounds. The product that
the records see is stated in their place.

Source: Seber and Wild, Nonlinear Regression (2003), sections 2.1 and 5.2; Venzon and Moolgavkar,
Applied Statistics 37 (1988) 87, for profiles.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, compress
from typing import NamedTuple

import numpy as np
from scipy.special import chdtrc, fdtrc, ndtr

from clearance.identify.doubts import WINDOW, correlation
from clearance.identify.estimation import spread
from clearance.identify.free import Free
from clearance.identify.run_errors import SHARE, RunError
from clearance.identify.scene_fit import MOST_LEADING, Problem, Solved
from clearance.metrics.statistics import student

WIDE = 0.5  # half of an interval over its value, from which the profile is taken
CORRELATED, TOGETHER = 0.95, 0.999
EDGE = 1e-6  # of the width of the bounds: at its bound
HALFWAY = 0.5  # to the bounds: place where inseparable parameters cost no more
STRAIGHT = 0.25  # least growth of the cost over that of a parabola, or its inverse, of an interval
CLOSE = 0.02  # of t, to which the end of a profile is looked for
TRIES = 8  # points of one side of a profile, at most
# minima: deviations between them; growth of 2 cost over s^2 below which one has above 5 %
APART, SIGNIFICANT = 3.0, 5.9
LARGE = 100.0  # logarithm of a factor beyond which nothing is stated
DOUBTFUL = 0.01  # probability of a test from which on it is stated
# values at an end of a record over those next to it, and their share of all, where a sensor clips
PILED, CLIPPED = 5.0, 0.02
EXACT = RunError()  # of runs without one


class Interval(NamedTuple):
    """A parameter with its 95 % interval, in SI; kind: "linear", "profile", "at its bound" or
    "inseparable", whose ends are nan.
    """

    name: str
    value: float
    low: float
    high: float
    deviation: float
    units: str
    kind: str

    @classmethod
    def of(
        cls, free: Free, x: float, ends: Iterable[float], deviation: float, kind: str
    ) -> "Interval":
        """From a coordinate, the ends and the deviation of it."""
        size = free.slope(x) * deviation
        return cls(free.name, free.value(x), *map(free.value, ends), size, free.units, kind)


@dataclass(frozen=True)
class Verdict:
    """All about a fit; arrays follow `names`, parameters first.

    noise: deviation of a residual over its sigma; facts: independent values that the records are
    worth; products: of inseparable parameters; tests: probabilities by name; minima: other sets
    of parameters, each with the growth of 2 cost over s^2; chances: probabilities of all minima by
    their likelihoods, that of the best first.
    """

    names: list[str]
    intervals: list[Interval]
    covariance: np.ndarray
    correlation: np.ndarray
    noise: float
    samples: int
    facts: float
    products: list[str]
    tests: dict[str, float]
    minima: list[tuple[dict[str, float], float]]
    doubts: list[str]

    @property
    def chances(self) -> list[float]:
        return chances([growth for _, growth in self.minima])


def verdict(
    problem: Problem, best: Solved, ends: Sequence[Solved], error: RunError = EXACT
) -> Verdict:
    """The verdict on a least cost; ends: of all starts; error: of the runs."""
    residuals, slopes = problem.residuals(best.x), problem.jacobian(best.x)
    samples, stated = residuals.size, problem.stated
    tau = dependence([residuals[rows] for rows in problem.rows])
    fits = stated and chi_square(problem, best, tau) > DOUBTFUL
    cost = 0.5 * problem.freedom
    covariance, _, noise = spread(slopes, cost if fits else max(best.cost, cost * stated), samples)
    more = tau * (1.0 + error.shift**2)
    judge = Judge(problem, best, covariance * more, noise**2 * more, error.covers)
    products, hidden = judge.products(slopes)
    intervals = [judge.interval(k, k in hidden) for k in range(len(problem.free))]
    tests = {} if error.covers else dict(_tests(problem, best, residuals, slopes, tau))
    minima = list(judge.minima(ends))
    doubts = [*problem.remarks]
    doubts += _doubts(problem, intervals, ends, best, tau, tests, minima, error)
    return Verdict(
        problem.names,
        intervals,
        judge.covariance,
        judge.correlated,
        noise,
        samples,
        samples / tau,
        products,
        tests,
        minima,
        doubts,
    )


def dependence(residuals: Sequence[np.ndarray]) -> float:
    """Autocorrelation time of residuals, in values; 1 where it does not differ from that of noise.

    The deviation of the estimate for noise is sqrt(2 (2 M + 1) / n) with M lags (Sokal).
    """
    count, tau = sum(map(len, residuals)), correlation(residuals)
    return tau if tau > 1.0 + 2.0 * math.sqrt(2.0 * (2.0 * WINDOW + 1.0) / count) else 1.0


@dataclass(frozen=True)
class Judge:
    """Intervals of parameters at a least cost.

    rough: residuals are mostly the error of the runs, by which the cost jumps: no profile is taken.
    """

    problem: Problem
    best: Solved
    covariance: np.ndarray
    variance: float
    rough: bool = False

    @cached_property
    def quantile(self) -> float:
        return student(self.problem.freedom)

    @cached_property
    def sd(self) -> np.ndarray:
        """Standard deviations of the coordinates."""
        return np.sqrt(np.diag(self.covariance))

    @cached_property
    def correlated(self) -> np.ndarray:
        """Correlations of the coordinates."""
        return self.covariance / np.outer(self.sd, self.sd)

    def growth(self, end: Solved) -> float:
        """Of 2 cost over s^2, from the least one."""
        return 2.0 * (end.cost - self.best.cost) / self.variance

    def products(self, slopes: np.ndarray) -> tuple[list[str], set[int]]:
        """Products of inseparable parameters, and these.

        Slopes of some are parallel: all of these enter as one. Others are only correlated.
        """
        lines, hidden = [], set()
        wide = [k for k in range(len(self.problem.free)) if self._wide(k)]
        seen = _alone(slopes, wide)
        seen = seen / np.maximum(np.linalg.norm(seen, axis=0), 1e-300)
        groups = [(*compress(wide, row),) for row in np.abs(seen.T @ seen) > TOGETHER]
        groups += [p for p in combinations(wide, 2) if abs(self.correlated[p]) > TOGETHER]
        for group in map(list, dict.fromkeys(g for g in groups if len(g) > 1)):
            new = not hidden.issuperset(group)
            if new and (line := self._product(_alone(slopes, group), group)):
                lines.append(line)
                hidden |= {*group}
        return lines, hidden

    def _wide(self, k: int) -> bool:
        """True where half of the linear interval of a parameter, over its value, is above WIDE."""
        free, x, wide = self.problem.free[k], float(self.best.x[k]), self.quantile * self.sd[k]
        if free.positive:
            return math.expm1(min(wide, LARGE)) > WIDE
        return free.size * wide > WIDE * abs(free.value(x))

    def _product(self, columns: np.ndarray, group: Sequence[int]) -> str:
        """The product of parameters with these columns, in words; "" where the records allow all
        that their bounds do, where the parameters have ends between these, and for no product.
        """
        order = np.argsort(np.linalg.norm(columns, axis=0))
        free, columns = [self.problem.free[group[k]] for k in order], columns[:, order]
        norm = max(float(np.linalg.norm(columns[:, 0])), 1e-150)
        powers = np.array([float(f"{n:.3g}") for n in columns[:, 0] @ columns / norm**2])
        total = float(powers @ self.best.x[group][order])
        half = self.quantile * math.sqrt(self.variance) / norm
        low, high = np.sort(powers * self.problem.bounds[:, group][:, order], axis=0).sum(axis=1)
        if total - half < low and total + half > high:
            return ""
        ends = self._valley(group[0])
        bent = max(abs(powers @ (e.x - self.best.x)[group][order]) for e in ends) / HALFWAY**2
        if bent > WIDE or any(self.growth(end) > self.quantile**2 for end in ends):
            return ""
        half = max(half, bent)
        if all(p.positive for p in free):
            terms = (f"{p.name}^{n:g}" for p, n in zip(free, powers, strict=True))
            enter = " * ".join(term.removesuffix("^1") for term in terms)
            size = f"{math.exp(total):.4g} within a factor of {math.exp(half):.4g}"
        else:
            terms = (f"{n:+g} {p.name}" for p, n in zip(free, powers, strict=True))
            enter = " ".join(terms).removeprefix("+1 ")
            size = f"{total:.4g} +- {half:.2g} of their coordinates"
        *names, last = (p.name for p in free)
        return f"{', '.join(names)} and {last} cannot be told apart: they enter as {enter}, {size}"

    def _valley(self, k: int) -> list[Solved]:
        """Least costs with a parameter half as far as others make up for it between bounds."""
        x, line = self.best.x, self.covariance[:, k] / self.covariance[k, k]
        limits = np.where(line > 0.0, self.problem.bounds, self.problem.bounds[::-1])
        reach = np.abs(limits - x) / np.maximum(np.abs(line), 1e-300)
        ends = (
            x + way * HALFWAY * r.min() * line for way, r in zip((-1.0, 1.0), reach, strict=True)
        )
        return [self.problem.solved(e, {k: float(e[k])}, most=MOST_LEADING) for e in ends]

    def interval(self, k: int, hidden: bool) -> Interval:
        """The interval of a parameter."""
        free, x, sd = self.problem.free[k], float(self.best.x[k]), float(self.sd[k])
        if hidden:
            return Interval.of(free, x, (math.nan, math.nan), math.nan, "inseparable")
        low, high = self.problem.bounds[:, k]
        edge = EDGE * (high - low)
        ends, kind = (x - self.quantile * sd, x + self.quantile * sd), "linear"
        others = np.delete(np.abs(self.correlated[k, : len(self.problem.free)]), k)
        if x - low < edge:
            ends, kind = (x, self.end(k, 1)), "at its bound"
        elif high - x < edge:
            ends, kind = (self.end(k, -1), x), "at its bound"
        elif self.rough:
            ends = np.clip(ends, low, high).tolist()
        elif self._wide(k) or (others > CORRELATED).any() or not self.straight(k):
            ends, kind = (self.end(k, -1), self.end(k, 1)), "profile"
        return Interval.of(free, x, ends, sd, kind)

    def straight(self, k: int) -> bool:
        """True where the cost grows as the slopes have it, at both ends of a linear interval."""
        step = self.quantile * self.covariance[:, k] / self.sd[k]
        ends = (np.clip(self.best.x + way * step, *self.problem.bounds) for way in (-1.0, 1.0))
        growths = (self.growth(self.problem.priced(e)) for e in ends)
        return all(STRAIGHT < g / self.quantile**2 < 1.0 / STRAIGHT for g in growths)

    def end(self, k: int, way: int) -> float:
        """End of the profile's interval of a coordinate; its bound where it does not end before."""
        limit = float(self.problem.bounds[int(way > 0), k])
        x, begin = float(self.best.x[k]), self.best.x
        inside, beyond, at = 0.0, math.inf, self.quantile * float(self.sd[k])
        reached = 0.0
        for _ in range(TRIES):
            at = min(at, abs(limit - x))
            solved = self.problem.solved(begin, {k: x + way * at}, most=MOST_LEADING)
            reached = math.sqrt(max(self.growth(solved), 0.0))
            if abs(reached - self.quantile) < CLOSE * self.quantile:
                break
            if reached < self.quantile:
                if at >= abs(limit - x):
                    break
                inside, begin = at, solved.x
            else:
                beyond = at
            guess = at * self.quantile / reached if reached > 0.0 else 2.0 * at
            at = min(max(guess, 0.5 * (inside + at)), 2.0 * at)
            if math.isfinite(beyond) and not inside < at < beyond:
                at = 0.5 * (inside + beyond)
        return x + way * at

    def minima(self, ends: Sequence[Solved]) -> Iterator[tuple[dict[str, float], float]]:
        """Other minima that the records do not refuse, each with the growth of its cost."""
        seen, count = [self.best.x], len(self.problem.free)
        wide = np.maximum(APART * self.sd[:count], 0.01)
        for end in sorted(ends, key=lambda e: e.cost):
            near = any((np.abs((end.x - x)[:count]) <= wide).all() for x in seen)
            if end.converged and self.growth(end) < SIGNIFICANT and not near:
                seen.append(end.x)
                yield self.problem.values(end.x), self.growth(end)


def _alone(slopes: np.ndarray, group: Sequence[int]) -> np.ndarray:
    """Columns of parameters without the part that all others make up for."""
    columns, others = slopes[:, group], np.delete(slopes, group, axis=1)
    return columns - others @ np.linalg.lstsq(others, columns, rcond=None)[0]


def clipped(values: np.ndarray) -> float:
    """Share of values that are the largest or the least, where these stand out from their next."""
    counts = np.unique(values, return_counts=True)[1]
    return (
        sum(int(c[0]) for c in (counts, counts[::-1]) if c[0] > PILED * c[1:2].sum()) / values.size
    )


def chances(growths: Sequence[float]) -> list[float]:
    """Probabilities of minima with these growths of 2 cost over s^2, that of the least first."""
    ratios = np.exp(-0.5 * np.array([0.0, *growths]))
    return (ratios / ratios.sum()).tolist()


def _tests(
    problem: Problem,
    best: Solved,
    residuals: np.ndarray,
    slopes: np.ndarray,
    tau: float,
) -> Iterator[tuple[str, float]]:
    """Probabilities of residuals as these, where the model is right."""
    if problem.stated:
        yield "chi-square", chi_square(problem, best, tau)
    thinned = (residuals[rows][:: math.ceil(tau)] for rows in problem.rows)
    yield "runs of residuals", min(map(runs_test, thinned))
    if residuals.size > 3 * len(best.x):
        yield "held-out third", held_out(residuals, slopes, problem.rows, tau)


def chi_square(problem: Problem, best: Solved, tau: float) -> float:
    """Probability of residuals as large, where their deviations are those that were stated."""
    return float(chdtrc(problem.freedom / tau, 2.0 * best.cost / tau))


def held_out(
    residuals: np.ndarray, slopes: np.ndarray, records: Sequence[slice], tau: float
) -> float:
    """Probability of errors as large in the last third of each record, from a fit to the rest.

    F = (R - R1) / n2 / (R1 / (n1 - p))        R, R1: sums of squares after fits to all, to the rest

    The fits are linear in the parameters, about the least cost; n1, n2: values of rest and third.
    F is of Fisher's distribution (Chow, Econometrica 28 (1960) 591).
    """
    rest = np.ones(residuals.size, bool)
    for rows in records:
        rest[rows.start + 2 * (rows.stop - rows.start) // 3 : rows.stop] = False
    sums = [_unfitted(residuals[part], slopes[part]) for part in (slice(None), rest)]
    thirds, freedom = np.count_nonzero(~rest), max(np.count_nonzero(rest) - slopes.shape[1], 1)
    ratio = (sums[0] - sums[1]) / thirds / max(sums[1] / freedom, 1e-300)
    return float(fdtrc(thirds / tau, max(freedom / tau, 1.0), max(ratio, 0.0)))


def _unfitted(residuals: np.ndarray, slopes: np.ndarray) -> float:
    """Sum of squares that parameters leave of residuals, where these are linear in them."""
    change, *_ = np.linalg.lstsq(slopes, residuals, rcond=None)
    return float(np.sum((residuals - slopes @ change) ** 2))


def runs_test(residuals: np.ndarray) -> float:
    """Probability of as few changes of sign, or fewer, where residuals are independent."""
    signs = residuals > np.median(residuals)
    above = int(signs.sum())
    below = signs.size - above
    if min(above, below) < 2:
        return 1.0
    runs = 1 + int(np.count_nonzero(signs[1:] != signs[:-1]))
    product = 2.0 * above * below
    mean = product / signs.size + 1.0
    variance = product * (product - signs.size) / (signs.size**2 * (signs.size - 1.0))
    return float(ndtr((runs - mean) / math.sqrt(variance)))


def _doubts(
    problem: Problem,
    intervals: Sequence[Interval],
    ends: Sequence[Solved],
    best: Solved,
    tau: float,
    tests: Mapping[str, float],
    minima: Sequence,
    error: RunError,
) -> Iterator[str]:
    """Sentences that a reader must see."""
    for curve in problem.curves:
        if (share := clipped(curve.measured.values)) > CLIPPED:
            yield (
                f"{curve.label}: {share:.0%} of the values are its largest or least: does the "
                "sensor clip? Leave these rows out"
            )
    low, high = problem.bounds
    edges = np.minimum(best.x - low, high - best.x) < EDGE * (high - low)
    pairs = zip(intervals, problem.free, strict=True)
    unseen = [i.name for i, p in pairs if max(i.low - p.low, p.high - i.high) < EDGE * p.size]
    for name in compress(problem.names, edges):
        if name not in unseen:
            yield f"{name} ends at a bound: its interval is that inside of the bounds"
    for name in unseen:
        yield f"the records do not determine {name} between its bounds"
    if error.shift > SHARE:
        wider = math.hypot(1.0, error.shift)
        yield f"the error of the runs makes all intervals wider, by a factor of {wider:.2g}"
    if error.covers:
        yield "the residuals are no larger than the error of the runs: nothing tests the model"
    if not best.converged:
        yield "the fit was still improving when it was ended"
    if tau > 1.0:
        yield (
            f"the residuals are autocorrelated: {problem.size} values are worth "
            f"{problem.size / tau:.0f} independent ones, and the intervals are for these; "
            "either their noise is, or the model lacks something"
        )
    doubtful = {name: p for name, p in tests.items() if p < DOUBTFUL}
    for name, probability in doubtful.items():
        yield f"the model does not fit: {name} has a probability of {probability:.2g}"
    if "chi-square" in doubtful:
        yield (
            "the intervals are for residuals as large as these; more starts may lead to a better "
            "minimum"
        )
    _, *others = chances([growth for _, growth in minima])
    for (values, _), chance in zip(minima, others, strict=True):
        text = ", ".join(f"{n} = {v:.4g}" for n, v in values.items())
        yield (
            f"another minimum has a probability of {chance:.0%} beside that above, whose intervals "
            f"do not contain it: {text}"
        )
    failed = sum(not math.isfinite(e.cost) for e in ends)
    if failed:
        yield f"{failed} of {len(ends)} starts had no run"
