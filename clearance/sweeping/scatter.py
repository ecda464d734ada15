"""Scatter: the spread of metrics under parameters that vary by chance, and the share of each
parameter in it.

Runs at scrambled Sobol' points, in a sweep directory. There are two independent samples A and B of
n points each. For every parameter there are the points of A with that one of B (Saltelli, Comput.
Phys. Commun. 145 (2002) 280, and 181 (2010) 259). A and B give quantiles and probabilities, all
together first and total Sobol' indices. Intervals are those of independent points (95 %); Sobol'
points lie more evenly, so that they are on the safe side.
"""

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import numpy as np

from clearance.files.locks import replace_file
from clearance.files.texts import check_kinds, signed, signed_document, text_of
from clearance.metrics.statistics import CONFIDENCE
from clearance.sweeping.index import Sweep, open_sweep
from clearance.sweeping.points import OUTER_COMMA, Points
from clearance.values import checks
from clearance.values.even_points import sobol
from clearance.values.fit_class import FitClass
from clearance.values.units import unit_in, written

QUANTILES = (0.01, 0.05, 0.5, 0.95, 0.99)
RESAMPLED = 200  # bootstrap samples of the intervals of indices
LARGE = 2**20  # numbers of them that are held at a time
FORMAT_VERSION = 1
ROUNDING = 1e-12  # share of its natural size within which a metric does not vary
SMALLEST = 1e-13  # deviation from ideal joints [m] that is rounding in any mechanism
#: distributions by name: what their numbers are called
DISTRIBUTIONS = {
    "normal": ("mean", "deviation"),
    "truncated": ("mean", "deviation", "low", "high"),
    "lognormal": ("median", "factor"),
    "uniform": ("low", "high"),
    "triangular": ("low", "mode", "high"),
}
#: numbers of distributions without the unit of their parameter
PURE = ("factor",)
_CALL = re.compile(r"\s*(\w+)\s*\((.*)\)\s*$")


@dataclass(frozen=True)
class Distribution:
    """The distribution of a parameter: normal(mean, deviation), truncated(mean, deviation, low,
    high), uniform(low, high), triangular(low, mode, high), or lognormal(median, factor), whose
    logarithm is normal: 68 % of it lie within a factor of the median.

    Raises ValueError naming what is wrong.
    """

    kind: str
    numbers: tuple[float, ...]
    unit: str = field(default="", compare=False)  # in which words show it, where it is not SI

    def __post_init__(self):
        checks.known("unknown distribution", self.kind, DISTRIBUTIONS)
        names = DISTRIBUTIONS[self.kind]
        if len(self.numbers) != len(names):
            raise ValueError(
                f"{self.kind} has the numbers {', '.join(names)}; got {len(self.numbers)}"
            )
        numbers = {
            n: checks.finite(f"{self.kind}: {n}", v)
            for n, v in zip(names, self.numbers, strict=True)
        }
        if numbers.get("deviation", 1.0) <= 0.0:
            raise ValueError(
                f"{self.kind}: the deviation must be positive, got {numbers['deviation']!r}"
            )
        if numbers.get("factor", 2.0) <= 1.0 or numbers.get("median", 1.0) <= 0.0:
            raise ValueError(
                f"{self.kind}: the median must be positive and the factor above 1, got {self}"
            )
        if not numbers.get("low", 0.0) < numbers.get("high", 1.0):
            raise ValueError(f"{self.kind}: low must be below high, got {self}")
        if "mode" in numbers and not numbers["low"] <= numbers["mode"] <= numbers["high"]:
            raise ValueError(f"{self.kind}: the mode must lie between low and high, got {self}")

    def __str__(self) -> str:
        pairs = zip(DISTRIBUTIONS[self.kind], self.numbers, strict=False)
        words = (written(float(v), "" if n in PURE else self.unit, 6) for n, v in pairs)
        return f"{self.kind}({', '.join(words)})"

    def at(self, share: np.ndarray) -> np.ndarray:
        """Values that a share of all stays below: the inverse of the cumulative distribution."""
        first, second, *rest = self.numbers
        share = np.asarray(share, float)
        if self.kind == "uniform":
            return share * (second - first) + first
        if self.kind == "triangular":
            (high,) = rest
            size, c = high - first, (second - first) / (high - first)
            rising = np.sqrt(c * share)
            return np.where(share < c, rising, 1 - np.sqrt((1 - c) * (1 - share))) * size + first
        if self.kind == "truncated":
            from scipy.stats import truncnorm

            low, high = ((end - first) / second for end in rest)
            return np.asarray(truncnorm.ppf(share, low, high, first, second), float)
        from scipy.special import ndtri

        if self.kind == "normal":
            return ndtri(share) * second + first
        return np.exp(math.log(second) * ndtri(share)) * first


def from_words(text: str, number: Callable[[str], float] = float) -> Distribution | None:
    """A distribution in words, such as "normal(100um, 5um)"; None for other words.

    number: takes a number with its unit to SI. Raises ValueError for numbers that do not suit it.
    """
    match = _CALL.match(text)
    if match is None or match[1] not in DISTRIBUTIONS:
        return None
    names, words = DISTRIBUTIONS[match[1]], [w.strip() for w in OUTER_COMMA.split(match[2])]
    if len(words) != len(names):
        raise ValueError(f"{match[1]} has the numbers {', '.join(names)}; got {text!r}")
    pairs = zip(names, words, strict=True)
    numbers = tuple(float(w) if n in PURE else number(w) for n, w in pairs)
    return Distribution(match[1], numbers, unit_in(match[2]))


def of_fit(fit: FitClass) -> Distribution:
    """Radial clearances of a fit: normal between its limits, see `FitClass.deviation`."""
    numbers = fit.mean, fit.deviation, fit.smallest, fit.largest
    return Distribution("truncated", numbers, "um")


def design(spread: Mapping[str, Distribution], points: int, seed: int = 0) -> tuple[Points, int]:
    """At most so many points, and the number n of those in each sample, a power of two. The points
    are A, B, then A with one of B.

    Raises ValueError for too few points.
    """
    if not spread:
        raise ValueError(
            "scatter: give at least one distribution, such as clearance=normal(100um,5um)"
        )
    each = points // (len(spread) + 2)
    if each < 8:
        least = 8 * (len(spread) + 2)
        raise ValueError(f"points: at least {least} for {len(spread)} parameters, got {points}")
    n = 2 ** int(math.log2(each))
    (random,) = np.random.default_rng(seed).spawn(1)
    shares = np.clip(sobol(n, 2 * len(spread), random), 1e-12, 1.0 - 1e-12)
    first, second = np.split(shares, 2, axis=1)
    rows = [first, second]
    for j in range(len(spread)):
        mixed = first.copy()
        mixed[:, j] = second[:, j]
        rows.append(mixed)
    table = np.concatenate(rows)
    columns = {n: tuple(law.at(table[:, j]).tolist()) for j, (n, law) in enumerate(spread.items())}
    units = {name: law.unit for name, law in spread.items() if law.unit}
    return Points(columns, ((("run",), len(table)),), sampled=True, units=units), n


@dataclass(frozen=True)
class Estimate:
    """A number and its 95 % interval."""

    value: float
    low: float
    high: float


def quantile(values: np.ndarray, share: float) -> Estimate:
    """A quantile of independent values; its interval from the order of the values alone, infinite
    beyond the last.
    """
    ranked, count = np.sort(values), len(values)
    below, above = _ranks(count, share)
    low = float(ranked[below]) if below >= 0 else -math.inf
    high = float(ranked[above]) if above < count else math.inf
    return Estimate(float(np.quantile(ranked, share)), low, high)


@cache
def _ranks(count: int, share: float) -> tuple[int, int]:
    """Places in the order of independent values between which a quantile lies."""
    k, tail = np.arange(count), 0.5 * (1.0 - CONFIDENCE)
    steps = np.log((count - k) / (k + 1.0) * (share / (1.0 - share)))
    # probability of so many values below it, or fewer: bdtr, without its import
    below = np.cumsum(np.exp(count * math.log1p(-share) + np.append(0.0, np.cumsum(steps))))
    lower, upper = np.searchsorted(below, (tail, 1.0 - tail)).tolist()
    return lower - 1, upper


def probability(beyond: np.ndarray) -> Estimate:
    """Probability of an event from whether it came about in independent trials (Clopper and
    Pearson's interval).
    """
    from scipy.special import betaincinv

    count, trials, tail = int(np.sum(beyond)), len(beyond), 0.5 * (1.0 - CONFIDENCE)
    low = betaincinv(count, trials - count + 1, tail) if count else 0.0
    high = betaincinv(count + 1, trials - count, 1.0 - tail) if count < trials else 1.0
    return Estimate(count / trials, float(low), float(high))


@dataclass(frozen=True)
class Indices:
    """Sobol' indices of one parameter: of its variation alone (first), and with all interactions
    (total).
    """

    first: Estimate
    total: Estimate

    @property
    def doubtful(self) -> bool:
        """True where the first is printed above the total, which no exact index is."""
        return round(self.first.value, 2) > round(self.total.value, 2)


def indices(values: np.ndarray, names: list[str], seed: int = 0) -> dict[str, Indices]:
    """Sobol' indices of each parameter, from values at the points of `design`, (points,), rows of
    NaN left out.

    First order: mean of f_B (f_AB - f_A); total: half the mean of (f_A - f_AB)^2; both over the
    variance (Saltelli et al. 2010, table 2 b and f). Intervals come from the bootstrap. Empty where
    the values do not vary, or fewer than eight rows are complete.
    """
    rows = values.reshape(len(names) + 2, -1)
    rows = rows[:, np.isfinite(rows).all(axis=0)]
    if rows.shape[1] < 8 or not np.ptp(rows[:2]) > 0.0:
        return {}
    rows = rows - rows[:2].mean()
    random, count = np.random.default_rng(seed), rows.shape[1]
    each = max(LARGE // rows.size, 1)
    parts = (min(each, RESAMPLED - k) for k in range(0, RESAMPLED, each))
    again = [_indices(rows[:, random.integers(0, count, (part, count))]) for part in parts]
    tail = 0.5 * (1.0 - CONFIDENCE)
    low, high = np.quantile(np.concatenate(again, axis=-1), [tail, 1.0 - tail], axis=-1)
    estimates = np.stack([_indices(rows), low, high], axis=-1)
    return {
        n: Indices(*(Estimate(*map(float, part[j])) for part in estimates))
        for j, n in enumerate(names)
    }


def _indices(rows: np.ndarray) -> np.ndarray:
    """First and total indices, (2, parameters, ...), from values at A, B and the mixed samples
    along the last axis.
    """
    (a, b), mixed = rows[:2], rows[2:]
    first, total = (b * (mixed - a)).mean(axis=-1), 0.5 * ((a - mixed) ** 2).mean(axis=-1)
    return np.array([first, total]) / rows[:2].var(axis=(0, -1))


class Scatter:
    """Runs at random points: `sweep`, their sweep; `spread`, the distributions by parameter;
    `limits` of metrics.

    Numbers of a metric that stays finite: `values` (2 n,), `quantile`, `beyond` a limit, `indices`
    by parameter.
    """

    def __init__(
        self, swept: Sweep, spread: dict[str, Distribution], n: int, limits: dict[str, float]
    ):
        self.sweep, self.spread, self.n, self.limits = swept, spread, n, limits

    def __repr__(self) -> str:
        return f"<scatter of {', '.join(self.spread)}: {self.sweep!r}>"

    @property
    def folder(self) -> Path:
        """The directory."""
        return self.sweep.folder

    @property
    def metrics(self) -> list[str]:
        """Metrics that vary, those with a limit first."""
        varying = [n for n in self.sweep.metrics if self._varies(n)]
        return [*(n for n in self.limits), *(n for n in varying if n not in self.limits)]

    def values(self, metric: str) -> np.ndarray:
        """Finite values at the points of A and B. Raises ValueError for a metric that there is
        not.
        """
        checks.known("no metric", metric, self.sweep.metrics)
        values = self.sweep.metrics[metric][: 2 * self.n]
        return values[np.isfinite(values)]

    def _varies(self, metric: str) -> bool:
        """False where the values of a metric differ by rounding alone."""
        values = self.values(metric)
        return values.size > 1 and bool(np.ptp(values) > self._rounding(metric))

    def _rounding(self, metric: str) -> float:
        """Differences of a metric up to which they are rounding.

        A deviation from ideal joints is a difference of larger numbers in its units.
        """
        if metric.endswith("_position_deviation_max"):
            return SMALLEST
        alike = [metric]
        if "_deviation" in metric:
            units = self._units(metric)
            alike = [n for n in self.sweep.metrics if self._units(n) == units]
        return ROUNDING * max(np.abs(self.values(n)).max(initial=0.0) for n in alike)

    def _units(self, metric: str) -> str:
        return self.sweep.known.get(metric, ("?",))[0]

    def quantile(self, metric: str, share: float) -> Estimate:
        """A quantile with its interval."""
        return quantile(self.values(metric), share)

    def beyond(self, metric: str, limit: float | None = None) -> Estimate:
        """Probability that a metric exceeds a limit (of minima, falls below it); default: its own
        limit.
        """
        limit, values = self.limits[metric] if limit is None else limit, self.values(metric)
        return probability(values < limit if is_least(metric) else values > limit)

    def indices(self, metric: str) -> dict[str, Indices]:
        """First and total Sobol' indices of each parameter; empty where the metric hardly has
        finite values, or varies by rounding alone.
        """
        if not self._varies(metric):
            return {}
        return indices(self.sweep.metrics[metric], list(self.spread))

    def summary(self, metric: str) -> dict:
        """All of it as plain data."""
        values = self.values(metric)
        summary = {
            "units": self._units(metric),
            "points": len(values),
            "mean": float(values.mean()),
            "deviation": float(values.std(ddof=1)),
            "quantiles": {f"{share:g}": vars(quantile(values, share)) for share in QUANTILES},
            "indices": {
                n: {"first": vars(i.first), "total": vars(i.total), "doubtful": i.doubtful}
                for n, i in self.indices(metric).items()
            },
        }
        if metric in self.limits:
            summary |= {"limit": self.limits[metric], "beyond": vars(self.beyond(metric))}
        return summary


def is_least(metric: str) -> bool:
    """True for a metric that is a smallest value, whose limit is one below."""
    return "_min" in metric


def write(result: Scatter, folder: Path) -> None:
    """Keep distributions, limits and the number of points in each sample beside the sweep, as
    `scatter.json`.
    """
    spread = {
        name: {"kind": law.kind, "numbers": law.numbers} for name, law in result.spread.items()
    }
    document = {
        "format_version": FORMAT_VERSION,
        "spread": spread,
        "n": result.n,
        "limits": result.limits,
    }
    replace_file(folder / "scatter.json", signed(document, indent=1))


def open_scatter(folder: str | Path) -> Scatter:
    """A scatter from its directory. Raises FileNotFoundError where there is none, ValueError for a
    damaged one.
    """
    path = Path(folder) / "scatter.json"
    if not path.exists():
        raise FileNotFoundError(f"no scatter in {folder}: it has no scatter.json")
    document = signed_document(text_of(path), path)
    try:
        check_kinds(document, {"spread": dict, "n": int, "limits": dict})
        spread = {n: _distribution(law) for n, law in document["spread"].items()}
    except ValueError as error:
        raise ValueError(f"{path} holds no scatter: {error}") from None
    return Scatter(open_sweep(folder), spread, document["n"], document["limits"])


def _distribution(law: object) -> Distribution:
    """The distribution that `write` described."""
    check_kinds(law, {"kind": str, "numbers": list})
    return Distribution(law["kind"], tuple(law["numbers"]))
