"""Means and quantiles of series whose values depend on those before, with intervals that hold the
truth in 95 of 100.

A series is stationary but for a transient at its start. Series of several runs of the same length
stand in the rows of one array. Intervals come from the means of batches, which are nearly
independent (Law and Kelton, Simulation Modeling and Analysis, chapter 9). Those of short series
are too narrow where values are correlated or skewed: they are widened in that proportion.
"""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

CONFIDENCE = 0.95
FEWEST = 8  # values needed for a sampling error
BATCHES = 10
MORE_BATCHES, LONG = 20, 400  # batches of series with at least so many values
#: factor on the interval by the number of values, of series with a correlation from one value to
#: the next or a skewness of at least so much. Measured on the turns of a dry slider-crank, whose
#: bursts of hard impacts last several turns (tests/benchmarks/turn_statistics.py).
CORRELATION, SKEWNESS = 0.3, 1.0
WIDENING = ((8, 3.0), (20, 2.2), (40, 1.5), (100, 1.25), (200, 1.1), (280, 1.0))
FLOOR = 0.5  # least interval over that of independent values: batches may hold full periods
TRUNCATION = 5  # values of which MSER-5 takes means
EARLY, LATE = 0.1, 0.5  # shares of a series whose means Geweke's test compares
FIRST_LOOK, GROWTH = 40, 1.25  # numbers of values at which a series that grows is judged
FEWEST_BEYOND = 5  # values that a quantile should leave on its outer side
PLAIN = 25.0  # variance between motions that are alike, over what chance makes: five times as far
DISTINCT = 0.99  # confidence with which motions are distinguished
EXACT = 1e-12  # share of a number that rounding changes
SECTION = 100  # last values of a run that are compared one by one
AWAY = 3.0  # distance to another run's section, over that of a section to itself, that parts them
NEARER = 0.7  # last distance over first one of a run that comes to another


@dataclass(frozen=True)
class Mean:
    """Mean of a series and half the width of its 95 % interval; batches: that the width comes
    from.
    """

    value: float
    half_width: float
    count: int
    batches: int

    @property
    def error(self) -> float:
        """Standard error: half the width over the quantile of Student's t."""
        return self.half_width / student(self.batches - 1)

    @property
    def share(self) -> float:
        """Half the width over the mean; 0 for a series of zeros."""
        return (
            abs(self.half_width / self.value)
            if self.value
            else math.inf
            if self.half_width
            else 0.0
        )

    def needed(self, share: float) -> int:
        """Values after which half the width is this share of the mean: it falls with the root of
        their number.
        """
        grown = self.count * (self.share / share) ** 2
        return math.ceil(max(grown, self.count)) if math.isfinite(grown) else 0

    def plain(self) -> dict[str, float]:
        """As plain data."""
        numbers = {"mean": self.value, "half_width": self.half_width, "standard_error": self.error}
        return numbers | {"count": self.count, "batches": self.batches}

    def __str__(self) -> str:
        return f"{self.value:.4g} +- {self.half_width:.2g}"


@dataclass(frozen=True)
class Quantile:
    """A value that a share of a series stays below, and its 95 % interval; nan: an end beyond all
    values.
    """

    share: float
    value: float
    low: float
    high: float

    def __str__(self) -> str:
        return f"{self.value:.4g} ({self.low:.4g} .. {self.high:.4g})"


def student(freedom: int, confidence: float = CONFIDENCE) -> float:
    """Two-sided quantile of Student's t."""
    from scipy.special import stdtrit

    return float(stdtrit(freedom, 0.5 * (1.0 + confidence)))


def mean(values: np.ndarray, widened: bool = True) -> Mean:
    """Mean of stationary series, (values,) or (runs, values), with its interval from batch means.

    half width = t_{b-1} s_b / sqrt(b), with s_b the standard deviation of the means of b batches of
    equal length. It is never less than half of that of independent values, and is widened by
    `widening`. Raises ValueError for fewer than 8 values.
    """
    rows = np.atleast_2d(np.asarray(values, float))
    count = rows.size
    if count < FEWEST:
        raise ValueError(f"the mean of a series needs at least {FEWEST} values, got {count}")
    batches = batch_means(rows).ravel()
    half = _half_width(batches)
    if widened:
        half = max(half, FLOOR * _half_width(rows.ravel())) * widening(rows)
    return Mean(float(rows.mean()), half, count, batches.size)


def batch_means(rows: np.ndarray) -> np.ndarray:
    """Means of batches of equal length, (runs, batches); what does not fill a batch is left out at
    the start.
    """
    runs, count = rows.shape
    wanted = MORE_BATCHES if rows.size >= LONG else BATCHES
    each = min(max(math.ceil(wanted / runs), 2), count)
    length = count // each
    return rows[:, count - each * length :].reshape(runs, each, length).mean(axis=2)


def standard_error(values: np.ndarray) -> float:
    """Of the mean of independent values."""
    return float(np.std(values, ddof=1)) / math.sqrt(np.size(values))


def _half_width(values: np.ndarray) -> float:
    """Half the 95 % interval of the mean of independent values."""
    return student(values.size - 1) * standard_error(values)


def widening(rows: np.ndarray) -> float:
    """Factor by which intervals of a series, (runs, values), are too narrow.

    That of `WIDENING` as far as the values are correlated or skewed, 1 for independent ones that
    are neither.
    """
    counts, factors = zip(*WIDENING, strict=True)
    largest = float(np.interp(rows.size, counts, factors))
    burst = max(correlation(rows) / CORRELATION, skewness(rows) / SKEWNESS)
    return 1.0 + (largest - 1.0) * min(max(burst, 0.0), 1.0)


def correlation(rows: np.ndarray) -> float:
    """Autocorrelation from one value to the next, (runs, values).

    The sample's, r, is too small by (1 + 4 rho) / n, for the mean is that of the same values
    (Marriott and Pope, Biometrika 41 (1954) 390).
    """
    away, count = rows - rows.mean(), rows.size
    square, product = float((away**2).sum()), float((away[:, 1:] * away[:, :-1]).sum())
    return (count * product / square + 1.0) / (count - 4.0) if square > 0.0 else 0.0


def skewness(rows: np.ndarray) -> float:
    """Third central moment over the cube of the standard deviation."""
    away = rows - rows.mean()
    spread = float((away**2).mean())
    return float((away**3).mean()) / spread**1.5 if spread > 0.0 else 0.0


def quantile(values: np.ndarray, share: float) -> Quantile:
    """Quantile of stationary series, (values,) or (runs, values), with its interval.

    The interval is between the values whose ranks bound the binomial share of n' independent ones
    (Clopper and Pearson, Biometrika 26 (1934) 404). n' is the number of values over the variance of
    the share's mean by batches, as a multiple of that of independent values. Raises ValueError for
    a share outside (0, 1).
    """
    from scipy.special import betaincinv

    if not 0.0 < share < 1.0:
        raise ValueError(f"the share of a quantile must lie between 0 and 1, got {share!r}")
    rows = np.atleast_2d(np.asarray(values, float))
    ranked = np.sort(rows, axis=None)
    value = float(np.quantile(ranked, share))
    independent = _independent(rows > value, share)
    below, tail = share * independent, 0.5 * (1.0 - CONFIDENCE)
    low = betaincinv(below, independent - below + 1.0, tail)
    high = betaincinv(below + 1.0, independent - below, 1.0 - tail)
    return Quantile(share, value, _ranked(ranked, low), _ranked(ranked, high))


def _independent(beyond: np.ndarray, share: float) -> float:
    """Number of independent values that would leave the share of those beyond as uncertain as these
    do.
    """
    batches = batch_means(beyond.astype(float)).ravel()
    each = share * (1.0 - share)
    variance = float(batches.var(ddof=1)) / batches.size
    return min(each / variance, float(beyond.size)) if variance > 0.0 else float(beyond.size)


def _ranked(ranked: np.ndarray, share: float) -> float:
    """The value of a share of the ranks; nan where it lies beyond the outermost."""
    rank = share * (ranked.size + 1.0) - 1.0
    if not 0.0 <= rank <= ranked.size - 1.0:
        return math.nan
    return float(np.interp(rank, np.arange(ranked.size), ranked))


def told(count: int, share: float) -> bool:
    """True where so many values leave some on the outer side of a quantile."""
    return round(count * min(share, 1.0 - share), 9) >= FEWEST_BEYOND


# --- the transient
def transient(series: Iterable[np.ndarray], least: int = 5) -> int:
    """Values to leave out at the start of all series, each (values,) or (runs, values).

    The largest truncation of MSER-5 (White, Cobb and Spratt, Proc. Winter Simulation Conf. (2000)
    755) of the means over the runs, at least `least`; doubled while Geweke's test sees a trend in
    what is left. Half is always left.
    """
    series = [np.atleast_2d(np.asarray(s, float)) for s in series]
    count = min(s.shape[1] for s in series)
    cut = max([least, *(mser(s.mean(axis=0)) for s in series)])
    while cut < count // 2 and not all(settled(s[:, cut:], len(series)) for s in series):
        cut *= 2
    return min(cut, count // 2)


def mser(values: np.ndarray) -> int:
    """Truncation of MSER-5: the number of first values that leaves the mean of the others the least
    standard error.
    """
    count = len(values) // TRUNCATION
    if count < 4:
        return 0
    means = np.asarray(values[: count * TRUNCATION], float).reshape(count, TRUNCATION).mean(axis=1)
    cuts = np.arange(count // 2 + 1)
    errors = [float(((means[d:] - means[d:].mean()) ** 2).sum()) / (count - d) ** 2 for d in cuts]
    return int(np.argmin(errors)) * TRUNCATION


def settled(rows: np.ndarray, series: int = 1) -> bool:
    """Geweke's test: the means of the first tenth and of the last half differ by no more than
    chance makes them.

    rows: (runs, values). series: how many are tested at once; all pass by chance in 95 of 100.
    """
    from scipy.special import ndtri

    count = rows.shape[1]
    first, last = rows[:, : max(int(EARLY * count), 1)], rows[:, -max(int(LATE * count), 2) :]
    if last.size < FEWEST:
        return True
    variance = mean(last).error ** 2
    difference = float(first.mean() - last.mean())
    error = math.sqrt(variance * (1.0 + last.size / first.size))
    level = float(ndtri(1.0 - 0.5 * (1.0 - CONFIDENCE) / series))
    return abs(difference) <= level * error + 1e-12 * abs(float(last.mean()))


# --- growing series
def looks() -> Iterator[int]:
    """Numbers of values at which a growing series is judged: 40, 50, 63, 79, ..."""
    number = float(FIRST_LOOK)
    while True:
        yield math.ceil(number)
        number *= GROWTH


# --- several motions
def motions(
    series: Iterable[np.ndarray],
    least: float = 0.0,
    finest: float = 0.0,
    turns: np.ndarray | None = None,
) -> list[list[int]]:
    """Runs that show the same motion, in groups; series: one for each quantity, (runs, values).

    Runs whose sections lie apart are different motions, see `apart`. turns: vectors of these,
    (runs, values, numbers); default: the series.

    Two groups differ where the variance between their runs exceeds that within them by more than
    chance. The test is the analysis of variance of batch means, F at 99 % over all quantities and
    cuts. Where their means differ by no more than the share `least`, the variance between must be
    PLAIN times that, which chance never is. Differences up to the share `finest` are none. Groups
    are cut at the widest step of the ordered means until none differ.
    """
    series = [np.atleast_2d(np.asarray(s, float)) for s in series]
    sections = np.stack(series, axis=-1) if turns is None else turns
    groups, todo = [], _together(sections[:, -SECTION:], finest)
    while todo:
        group = todo.pop()
        split = _split(series, group, least, finest)
        todo += split
        groups += [] if split else [group]
    return sorted(groups)


def _together(sections: np.ndarray, finest: float) -> list[list[int]]:
    """Groups of runs no two of which lie apart."""
    groups: list[list[int]] = []
    for run, section in enumerate(sections):
        near = (g for g in groups if not any(apart(section, sections[i], finest) for i in g))
        if group := next(near, None):
            group.append(run)
        else:
            groups.append([run])
    return groups


def apart(first: np.ndarray, second: np.ndarray, finest: float = 0.0) -> bool:
    """True where two runs are different motions by their sections, (values, numbers).

    A section is one point a turn: a motion that repeats itself is a few points or a curve, a
    chaotic one a cloud. The later half of a section lies as near to its earlier half as the motion
    repeats itself. Another run of the same motion comes as near. So two are different where one of
    them never comes within AWAY times that. Distances up to the share `finest` are none. Neither is
    one to a run that still comes nearer.
    """
    return _aside(first, second, finest) or _aside(second, first, finest)


def _aside(first: np.ndarray, second: np.ndarray, finest: float) -> bool:
    """As `apart`, by how one repeats itself."""
    half, size = len(first) // 2, np.abs(np.concatenate([first, second])).max(axis=0)
    early, late = first[:half], first[half:]
    repeats = [nearest(late[:, [k]], early[:, [k]]).max() for k in range(size.size)]
    unit = np.maximum(repeats, max(finest, EXACT) * size) + (size == 0.0)
    repeat = nearest(late / unit, early / unit).max()
    away = nearest(second / unit, first / unit)
    quarters = np.array([np.median(part) for part in np.array_split(away, 4)])
    comes = (np.diff(quarters) < 0.0).all() and quarters[-1] < NEARER * quarters[0]
    return bool(away.min() > max(AWAY * repeat, 1.0) and not comes)


def nearest(points: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Distance of each point to the nearest of others, (points, numbers): in the largest number."""
    return np.abs(points[:, None] - others[None]).max(axis=2).min(axis=1)


def _split(
    series: list[np.ndarray], group: list[int], least: float, finest: float
) -> list[list[int]]:
    """A group in two where some quantity distinguishes them; else none.

    The quantity that does so most clearly counts.
    """
    groups, clearest = [], 1.0
    for rows in series:
        batches = batch_means(rows[group])
        means = batches.mean(axis=1)
        order = np.argsort(means)
        steps = np.diff(means[order])
        size = abs(float(means.mean()))
        if not steps.size or steps.max() <= finest * size:
            continue
        cut = int(steps.argmax()) + 1
        clear = _clearness(batches, [order[:cut], order[cut:]], len(series) * len(steps))
        clear /= PLAIN if steps.max() <= least * size else 1.0
        if clear > clearest:
            clearest, groups = (
                clear,
                [sorted(group[i] for i in part) for part in (order[:cut], order[cut:])],
            )
    return groups


def _clearness(batches: np.ndarray, parts: list[np.ndarray], tests: int) -> float:
    """Variance between two parts over that within the runs, over its quantile: above 1 the two are
    different.
    """
    from scipy.special import fdtri

    runs, each = batches.shape
    within = float(batches.var(axis=1, ddof=1).mean())
    sizes = [p.size * each for p in parts]
    means = [float(batches[p].mean()) for p in parts]
    between = (means[0] - means[1]) ** 2 / (1.0 / sizes[0] + 1.0 / sizes[1])
    allowed = float(fdtri(1, runs * (each - 1), 1.0 - (1.0 - DISTINCT) / tests)) * within
    return between / allowed if allowed > 0.0 else math.inf
