"""Parameters by statistics of many turns, where trajectories part before a record begins.

    s = mean over turns of ln(rms), ln(range), ln(power in a band of orders)      of each channel
    Q = (s(p) - s_m)^T C^-1 (s(p) - s_m),    C = V (1 / N_m + 1 / N)

s_m are those of the record, with N_m turns. s(p) are those of runs of N turns with the noise of the
sensor. V is the covariance of a turn's numbers in a run, as large as the means of batches show.
s(p) is a quadratic through runs at Sobol' points of a box, which shrinks about the least Q. Its
slopes there give the intervals.

Validity: settled motion, a record of at least FEWEST turns, a stated noise.
Source: Wood, Nature 466 (2010) 1102, for the likelihood of statistics.
"""

import math
from collections.abc import Sequence

import numpy as np
from scipy.optimize import least_squares
from scipy.special import chdtrc

from clearance.accuracy.by_differences import recorded
from clearance.identify.estimation import spread
from clearance.identify.free import NO_RUN
from clearance.identify.scene_fit import SHIFT, Problem, Solved
from clearance.identify.verdict import DOUBTFUL, TOGETHER, Interval, Verdict
from clearance.metrics.statistics import BATCHES, student
from clearance.results.record import cubic

FEWEST = 20  # turns of a record
GAP = 2.0  # between values, over the median, from which values are missing
TURNS = 200  # of a run at each point
RTOL = 1e-6
BANDS = (1, 3, 9, 33)  # first orders of the bands of a spectrum; the last ends at half the samples
ROUNDS, SHRUNK = 4, 0.35  # boxes, and the width of one over that before, at least
DEVIATIONS = 4.0  # half the width of a box, in deviations of the parameters, at least
EDGE = 1e-9  # of half the width of a box, by which points may lie outside
LEAST = 1e-12  # power over that of all orders, below which a band is empty


def turns_of(problem: Problem) -> int:
    """Full turns of the shortest record up to a gap; 0 where nothing turns."""
    if not problem.turn:
        return 0
    turns = []
    for i in range(len(problem.curves)):
        places, count = _places(problem, i)
        gaps = np.flatnonzero(np.diff(places) * count > GAP)
        turns.append(math.floor(places[[*gaps, -1][0]] + 1.0 / count))
    return min(turns)


def reason_without(problem: Problem) -> str:
    """Reason for which there is no fit by statistics; "" where there is one."""
    if (turns := turns_of(problem)) < FEWEST:
        return f"statistics need at least {FEWEST} turns, and the record has {turns} without a gap"
    if not problem.stated:
        return "statistics need the noise of the sensor, which is in them: give noise"
    if any(n != SHIFT for _, n in problem.nuisances):
        return "offset, gain and mounting cannot be fitted to statistics"
    if len(problem.groups) > 1:
        return "statistics are fitted to records of one condition"
    return ""


class TurnStatistics:
    """Statistics of the records of a problem, and of runs at points between its bounds."""

    def __init__(self, problem: Problem, seed: int):
        self.problem, self.seed = problem, seed
        self.turns, self.evaluations = turns_of(problem), 0
        places, self.counts = zip(
            *(_places(problem, i) for i in range(len(problem.curves))), strict=True
        )
        values = (c.measured.values for c in problem.curves)
        parts = zip(places, values, self.counts, strict=True)
        rows = np.concatenate([_numbers(*part, self.turns) for part in parts], axis=1)
        self.seen = np.isfinite(rows).all(axis=0)
        self.measured = rows[:, self.seen].mean(axis=0)

    def of(self, x: np.ndarray) -> np.ndarray:
        """Numbers (TURNS, ...) of a run at coordinates. Raises Impossible."""
        problem, random = self.problem, np.random.default_rng(self.seed)
        scene = problem.scene_of(x, problem.groups[0].changes)
        length = math.ceil(problem.settle) + TURNS + 1
        samples = length * max(self.counts) + 1
        run = problem.prepared(scene, until=length * scene.turn, samples=samples, rtol=RTOL)
        record, parts = recorded(run), []
        self.evaluations += 1
        for i, (curve, count) in enumerate(zip(problem.curves, self.counts, strict=True)):
            places = np.arange(round((TURNS + 0.5) * count)) / count
            values = problem.sensed(record, i, record.time_at(places + problem.settle))
            values = values + random.normal(0.0, curve.sigma, values.size)
            parts.append(_numbers(places, values, count, TURNS))
        return np.concatenate(parts, axis=1)[:, self.seen]


def _numbers(places: np.ndarray, values: np.ndarray, count: int, turns: int) -> np.ndarray:
    """Numbers (turns, ...) of a channel; places: of its values [turns]; count: of them, a turn."""
    by_turn = cubic(places, values, np.arange(turns * count) / count).reshape(turns, count)
    power = np.abs(np.fft.rfft(by_turn, axis=1)) ** 2
    bands = np.add.reduceat(power, [b for b in BANDS if b < count // 2], axis=1)
    total = power[:, 1:].sum(axis=1)
    columns = np.column_stack([total, np.ptp(by_turn, axis=1) ** 2, bands])
    columns[:, columns.mean(axis=0) < LEAST * total.mean()] = math.nan
    return 0.5 * np.log(np.maximum(columns, 1e-300))


def by_statistics(problem: Problem, seed: int) -> tuple[Solved, Verdict]:
    """The least Q and what it is worth.

    Raises ValueError where runs fail, and where statistics do not outnumber parameters.
    """
    statistics, p = TurnStatistics(problem, seed), len(problem.free)
    if statistics.measured.size <= p:
        raise ValueError(
            f"fit: {statistics.measured.size} statistics do not determine {p} parameters"
        )
    low, high = box = problem.ends.T
    runs: list[tuple[np.ndarray, np.ndarray]] = []
    count = 2 ** math.ceil(math.log2(4 + (p + 1) * (p + 2)))
    for turn in range(ROUNDS):
        for x in problem.spread(count, seed + turn, box):
            try:
                numbers = statistics.of(x)
            except NO_RUN as reason:
                problem.reason = str(reason)
                continue
            if np.isfinite(numbers).all():
                runs.append((x, numbers))
        problem.progress((turn + 1) / ROUNDS)
        x, covariance, cost = _least(statistics, runs, box)
        half = 0.5 * (box[1] - box[0])
        wide = np.maximum(DEVIATIONS * np.sqrt(np.diag(covariance)), SHRUNK * half)
        wide = np.minimum(wide, half)
        box = np.array([np.maximum(x - wide, low), np.minimum(x + wide, high)])
    solved = Solved(np.append(x, problem.middle[p:]), cost, True)
    return solved, _verdict(problem, statistics, solved, covariance)


def _verdict(
    problem: Problem, statistics: TurnStatistics, solved: Solved, covariance: np.ndarray
) -> Verdict:
    """Intervals from the covariance, inside of the bounds."""
    count, p = statistics.measured.size, len(problem.free)
    sd = np.sqrt(np.diag(covariance))
    correlated = covariance / np.outer(sd, sd)
    x, wide = solved.x[:p], student(count - p) * sd
    ends = np.clip([x - wide, x + wide], *problem.ends.T)
    rows = zip(problem.free, x.tolist(), ends.T.tolist(), sd.tolist(), strict=True)
    intervals = [Interval.of(*row, "statistics") for row in rows]
    probability = float(chdtrc(count - p, 2.0 * solved.cost))
    doubts = [
        f"no trajectory follows the records: they are fitted by {count} statistics of "
        f"{statistics.turns} turns, with {TURNS} turns of a run at each of "
        f"{statistics.evaluations} points"
    ]
    if probability < DOUBTFUL:
        doubts.append(f"the model does not fit: chi-square has a probability of {probability:.2g}")
    if (np.abs(correlated[~np.eye(p, dtype=bool)]) > TOGETHER).any():
        doubts.append("parameters cannot be told apart by these statistics")
    names, tests = problem.names[:p], {"chi-square": probability}
    about = covariance, correlated, 1.0, count, float(count), [], tests, [], doubts
    return Verdict(names, intervals, *about)


def _least(
    statistics: TurnStatistics, runs: Sequence[tuple[np.ndarray, np.ndarray]], box: np.ndarray
) -> tuple[np.ndarray, np.ndarray, float]:
    """Least Q in a box, the covariance there, and half of Q."""
    middle, wide = box.mean(axis=0), 0.5 * np.ptp(box, axis=0)
    near = [((x - middle) / wide, rows) for x, rows in runs]
    near = [(y, rows) for y, rows in near if (np.abs(y) <= 1.0 + EDGE).all()]
    p = wide.size
    if len(near) < (p + 1) * (p + 2) // 2 + 1:
        raise ValueError(f"fit: too few runs for statistics: {statistics.problem.reason}")
    points, means = np.array([y for y, _ in near]), np.array([r.mean(axis=0) for _, r in near])
    terms = _terms(points)
    weights, *_ = np.linalg.lstsq(terms, means, rcond=None)
    gap = np.linalg.norm((means - statistics.measured) / (means.std(axis=0) + 1e-12), axis=1)
    order = np.argsort(gap)
    # of the quadratic: what runs of so many points leave, and what it does not follow
    errors, (count, size) = means - terms @ weights, terms.shape
    of_fit = (errors.T @ errors) / max(count - size, 1) * size / count
    covariance = _of_turn(near[order[0]][1]) / statistics.turns + of_fit
    root = np.linalg.inv(np.linalg.cholesky(covariance + 1e-14 * np.eye(len(covariance))))

    def residuals(y: np.ndarray) -> np.ndarray:
        return root @ (_terms(y[None])[0] @ weights - statistics.measured)

    begins, bounds = np.clip(points[order[:3]], -1.0, 1.0), (-1.0 - EDGE, 1.0 + EDGE)
    end = min((least_squares(residuals, y, bounds=bounds) for y in begins), key=lambda e: e.cost)
    freedom = max(statistics.measured.size - p, 1)
    cost = max(float(end.cost), 0.5 * freedom)  # larger residuals widen the intervals
    covariance, *_ = spread(end.jac / wide, cost, statistics.measured.size)
    return middle + wide * end.x, covariance, float(end.cost)


def _terms(y: np.ndarray) -> np.ndarray:
    """Terms of a quadratic at points (n, p)."""
    i, j = np.tril_indices(y.shape[1])
    return np.column_stack([np.ones(len(y)), y, y[:, i] * y[:, j]])


def _of_turn(rows: np.ndarray) -> np.ndarray:
    """Covariance of a turn's numbers, as large as the means of batches show."""
    plain = np.cov(rows.T)
    length = len(rows) // BATCHES
    batches = rows[: BATCHES * length].reshape(BATCHES, length, -1).mean(axis=1)
    growth = length * batches.var(axis=0, ddof=1) / np.diag(plain)
    growth = np.sqrt(np.maximum(growth, 1.0))
    return plain * np.outer(growth, growth)


def _places(problem: Problem, i: int) -> tuple[np.ndarray, int]:
    """Places of the values of a record [turns], from 0 on, and the full number of them a turn."""
    turns = problem.in_turns(i)
    return turns - turns[0], max(round(1.0 / float(np.median(np.diff(turns)))), 8)
