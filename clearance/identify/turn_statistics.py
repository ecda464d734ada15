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
from collections.abc import Callable, Sequence

import numpy as np
from scipy.optimize import least_squares
from scipy.special import chdtrc

from clearance.accuracy.by_differences import Impossible, recorded
from clearance.identify.estimation import spread
from clearance.identify.scene_fit import SHIFT, Problem, Solved
from clearance.identify.verdict import DOUBTFUL, TOGETHER, Interval, Verdict
from clearance.metrics.statistics import BATCHES, student
from clearance.results.record import cubic

FEWEST = 20  # turns of a record
TURNS = 200  # of a run at each point
RTOL = 1e-6
BANDS = (1, 3, 9, 33)  # first orders of the bands of a spectrum; the last ends at half the samples
ROUNDS, SHRUNK = 4, 0.35  # boxes, and the width of one over that before, at least
DEVIATIONS = 4.0  # half the width of a box, in deviations of the parameters, at least
LEAST = 1e-12  # power over that of all orders, below which a band is empty


def turns_of(problem: Problem) -> int:
    """Full turns of the shortest record; 0 where nothing turns."""
    if not problem.turn:
        return 0
    return min(math.floor(_places(problem, i)[-1] + _step(problem, i)) for i in _all(problem))


def reason_without(problem: Problem) -> str:
    """Reason for which there is no fit by statistics; "" where there is one."""
    if turns_of(problem) < FEWEST:
        return f"statistics need at least {FEWEST} turns, and the record has {turns_of(problem)}"
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
        parts = [
            self._numbers(i, _places(problem, i), c.measured.values, self.turns)
            for i, c in enumerate(problem.curves)
        ]
        rows = np.concatenate(parts, axis=1)
        self.seen = np.isfinite(rows).all(axis=0)
        self.measured = rows[:, self.seen].mean(axis=0)

    def _numbers(self, i: int, places: np.ndarray, values: np.ndarray, turns: int) -> np.ndarray:
        """Numbers (turns, ...) of a channel; places: of its values [turns]."""
        count = round(1.0 / _step(self.problem, i))
        at = np.arange(turns * count) / count
        by_turn = cubic(places, values, at).reshape(turns, count)
        power = np.abs(np.fft.rfft(by_turn, axis=1)) ** 2
        ends = [*(b for b in BANDS if b < count // 2), count // 2 + 1]
        bands = [power[:, a:b].sum(axis=1) for a, b in zip(ends[:-1], ends[1:], strict=True)]
        total = power[:, 1:].sum(axis=1)
        columns = [total, np.ptp(by_turn, axis=1) ** 2, *bands]
        empty = [c.mean() < LEAST * total.mean() for c in columns]
        logs = [
            np.full(turns, math.nan) if e else 0.5 * np.log(np.maximum(c, 1e-300))
            for c, e in zip(columns, empty, strict=True)
        ]
        return np.stack(logs, axis=1)

    def of(self, x: np.ndarray) -> np.ndarray:
        """Numbers (TURNS, ...) of a run at coordinates. Raises Impossible."""
        problem, random = self.problem, np.random.default_rng(self.seed)
        scene = problem.scene_of(x, problem.groups[0].changes)
        per_turn = round(1.0 / min(_step(problem, i) for i in _all(problem)))
        length = math.ceil(problem.settle) + TURNS + 1
        run = problem.prepared(
            scene, until=length * scene.turn, samples=length * per_turn + 1, rtol=RTOL
        )
        record, parts = recorded(run), []
        self.evaluations += 1
        for i, curve in enumerate(problem.curves):
            places = np.arange(round((TURNS + 0.5) / _step(problem, i))) * _step(problem, i)
            times = record.time_at(places + problem.settle)
            values = problem.sensed(record, i, times)
            values = values + random.normal(0.0, curve.sigma, values.size)
            parts.append(self._numbers(i, places, values, TURNS))
        return np.concatenate(parts, axis=1)[:, self.seen]


def by_statistics(
    problem: Problem, seed: int, progress: Callable[[float], None] | None = None
) -> tuple[Solved, Verdict]:
    """The least Q and what it is worth.

    Raises ValueError where runs fail, and where statistics do not outnumber parameters.
    """
    made, p = TurnStatistics(problem, seed), len(problem.free)
    if made.measured.size <= p:
        raise ValueError(f"fit: {made.measured.size} statistics do not determine {p} parameters")
    low, high = problem.ends.T
    points, means, rows = [], [], []
    box = low, high
    count = 2 ** math.ceil(math.log2(4 + (p + 1) * (p + 2)))
    for turn in range(ROUNDS):
        for x in problem.spread(count, seed + turn, box):
            try:
                numbers = made.of(x)
            except (Impossible, ValueError, ArithmeticError) as reason:
                problem.reason = str(reason)
                continue
            if np.isfinite(numbers).all():
                points.append(x)
                means.append(numbers.mean(axis=0))
                rows.append(numbers)
        if progress is not None:
            progress((turn + 1) / ROUNDS)
        x, covariance, cost = _least(made, np.array(points), np.array(means), rows, box)
        half = 0.5 * (box[1] - box[0])
        wide = np.maximum(DEVIATIONS * np.sqrt(np.diag(covariance)), SHRUNK * half)
        wide = np.minimum(wide, half)
        box = np.maximum(x - wide, low), np.minimum(x + wide, high)
    solved = Solved(np.append(x, problem.middle[p:]), cost, True)
    return solved, _verdict(problem, made, solved, covariance)


def _verdict(
    problem: Problem, made: TurnStatistics, solved: Solved, covariance: np.ndarray
) -> Verdict:
    """Intervals from the covariance, inside of the bounds."""
    count, p = made.measured.size, len(problem.free)
    sd = np.sqrt(np.diag(covariance))
    correlated = covariance / np.outer(sd, sd)
    x, wide = solved.x[:p], student(count - p) * sd
    ends = np.clip([x - wide, x + wide], *problem.ends.T)
    rows = zip(problem.free, x.tolist(), ends.T.tolist(), sd.tolist(), strict=True)
    intervals = [Interval.of(*row, "statistics") for row in rows]
    probability = float(chdtrc(count - p, 2.0 * solved.cost))
    doubts = [
        f"no trajectory follows the records: they are fitted by {count} statistics of "
        f"{made.turns} turns, with {TURNS} turns of a run at each of {made.evaluations} points"
    ]
    if probability < DOUBTFUL:
        doubts.append(f"the model does not fit: chi-square has a probability of {probability:.2g}")
    if (np.abs(correlated[~np.eye(p, dtype=bool)]) > TOGETHER).any():
        doubts.append("parameters cannot be told apart by these statistics")
    names, tests = problem.names[:p], {"chi-square": probability}
    about = covariance, correlated, 1.0, count, float(count), [], tests, [], doubts
    return Verdict(names, intervals, *about)


def _least(
    made: TurnStatistics,
    points: np.ndarray,
    means: np.ndarray,
    rows: Sequence[np.ndarray],
    box: tuple[np.ndarray, np.ndarray],
) -> tuple[np.ndarray, np.ndarray, float]:
    """Least Q in a box, the covariance there, and half of Q."""
    low, high = box
    inside = ((points >= low - 1e-12) & (points <= high + 1e-12)).all(axis=1)
    points, means = points[inside], means[inside]
    if len(points) < (len(low) + 1) * (len(low) + 2) // 2 + 1:
        raise ValueError(f"fit: too few runs for statistics: {made.problem.reason}")
    middle, wide = 0.5 * (low + high), 0.5 * (high - low)
    terms = _terms((points - middle) / wide)
    weights, *_ = np.linalg.lstsq(terms, means, rcond=None)
    gap = np.linalg.norm((means - made.measured) / (means.std(axis=0) + 1e-12), axis=1)
    near = int(np.argmin(gap))
    of_turn = _of_turn(rows[int(np.flatnonzero(inside)[near])])
    # of the quadratic: what runs of so many points leave, and what it does not follow
    errors = means - terms @ weights
    spare = max(len(points) - terms.shape[1], 1)
    of_fit = (errors.T @ errors) / spare * terms.shape[1] / len(points)
    covariance = of_turn / made.turns + of_fit
    root = np.linalg.inv(np.linalg.cholesky(covariance + 1e-14 * np.eye(len(covariance))))

    def residuals(y: np.ndarray) -> np.ndarray:
        return root @ (_terms(y[None])[0] @ weights - made.measured)

    begins = np.clip((points[np.argsort(gap)[:3]] - middle) / wide, -1.0, 1.0)
    ends = [least_squares(residuals, y, bounds=(-1.0 - 1e-9, 1.0 + 1e-9)) for y in begins]
    end = min(ends, key=lambda e: e.cost)
    freedom = max(made.measured.size - len(low), 1)
    cost = max(float(end.cost), 0.5 * freedom)  # larger residuals widen the intervals
    slopes = end.jac / wide
    return middle + wide * end.x, spread(slopes, cost, made.measured.size)[0], float(end.cost)


def _terms(y: np.ndarray) -> np.ndarray:
    """Terms of a quadratic at points (n, p)."""
    p = y.shape[1]
    pairs = [y[:, i] * y[:, j] for i in range(p) for j in range(i + 1)]
    return np.stack([np.ones(len(y)), *y.T, *pairs], axis=1)


def _of_turn(rows: np.ndarray) -> np.ndarray:
    """Covariance of a turn's numbers, as large as the means of batches show."""
    plain = np.cov(rows.T)
    length = len(rows) // BATCHES
    batches = rows[: BATCHES * length].reshape(BATCHES, length, -1).mean(axis=1)
    growth = length * batches.var(axis=0, ddof=1) / np.diag(plain)
    growth = np.sqrt(np.maximum(growth, 1.0))
    return plain * np.outer(growth, growth)


def _all(problem: Problem) -> range:
    return range(len(problem.curves))


def _places(problem: Problem, i: int) -> np.ndarray:
    """Places of the values of a record [turns], from 0 on."""
    turns = problem.in_turns(i)
    return turns - turns[0]


def _step(problem: Problem, i: int) -> float:
    """Distance of the values of a record [turns], a full number of them a turn."""
    return 1.0 / max(round(1.0 / float(np.median(np.diff(_places(problem, i))))), 8)
