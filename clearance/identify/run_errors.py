"""The error of the runs of a fit, beside the noise of its records.

    q = 2 |U^T (r' - r)| / s        r, r': residuals of the runs and of finer ones; s: of the noise

U has orthonormal columns that span the slopes of the residuals. The error of the runs moves no
parameter by more than q of its standard deviations (Cauchy and Schwarz). Its variance with this
error is at most 1 + q^2 times that of the noise. Where q is above SHARE the runs follow: to a
smaller tolerance, and to denser samples, between which a shifted record takes cubics.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from clearance.identify.estimation import ROUNDING
from clearance.identify.scene_fit import LAST, ROUNDS, Problem, Solved

SAFETY = 2.0  # of the error of the runs, over their distance from finer ones
SHARE = 0.2  # of a deviation by noise, to which the error of the runs counts as little
FINER, FINEST = 1e-2, 1e-9  # of the tolerance, and the least that runs follow to
LEAST = 1e-11  # tolerance of the runs that show the error of others; below it those of a larger one
DENSER, DENSEST = 4, 16  # the same of samples
SEEN = 0.3  # share of the residuals from which they are no noise


@dataclass(frozen=True)
class RunError:
    """shift: q; share: rms of the error over that of the residuals."""

    shift: float = 0.0
    share: float = 0.0

    @property
    def covers(self) -> bool:
        """True where the residuals are mostly this error: they do not test the model."""
        return self.share > SEEN


def refined(problem: Problem, best: Solved) -> tuple[Problem, Solved, RunError]:
    """The problem with runs whose error counts little, its least cost, and the error left."""
    while True:
        residuals, slopes = problem.residuals(best.x), problem.jacobian(best.x)
        rms = float(np.sqrt(np.mean(residuals**2)))
        noise = 1.0 if problem.stated else rms * math.sqrt(residuals.size / problem.freedom)
        rtol = problem.rtol * (FINER if problem.rtol * FINER >= LEAST else 1.0 / FINER)
        changes = [
            np.nan_to_num(problem.with_runs(*how).residuals(best.x) - residuals)
            for how in ((rtol,), (problem.rtol, DENSER))
        ]
        shifts = [SAFETY * _along(slopes, change) / max(noise, 1e-300) for change in changes]
        finer = shifts[0] > SHARE and problem.rtol > FINEST
        denser = shifts[1] > SHARE and problem.density < DENSEST
        if not (finer or denser):
            share = float(np.sqrt(np.mean(sum(changes) ** 2))) / max(rms, 1e-300)
            return problem, best, RunError(math.hypot(*shifts), share)
        problem = problem.with_runs(rtol if finer else problem.rtol, DENSER if denser else 1)
        best = weighted(problem, problem.solved(best.x, finish=LAST))


def weighted(problem: Problem, best: Solved) -> Solved:
    """The least cost with unknown errors of records taken from their residuals."""
    rounds = 0
    while problem.weighed(best.x) and rounds < ROUNDS:
        best, rounds = problem.solved(best.x, finish=LAST), rounds + 1
    return replace(best, cost=problem.priced(best.x).cost)


def _along(slopes: np.ndarray, change: np.ndarray) -> float:
    """Size of a change of residuals in the directions that parameters move them."""
    sizes = np.linalg.norm(slopes, axis=0)
    basis, singular, _ = np.linalg.svd(slopes / np.where(sizes > 0.0, sizes, 1.0), False)
    return float(np.linalg.norm(basis[:, singular > ROUNDING].T @ change))
