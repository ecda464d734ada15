"""Statistics of chaotic motion and their intervals: `python tests/benchmarks/turn_statistics.py
[--update]`.

Four hundred starts of 320 turns of the dry slider-crank, whose bursts of hard impacts last several
turns, and a hundred of the dry feeder, whose turns hardly depend on those before (some nine minutes
of CPU). The truth is the mean over all starts without their first 30 turns. Shares are over all
quantities of `clearance.metrics.by_turn` that vary; most of a mechanism show the same, so that
shares of a hundred starts scatter by 2 %. The widening of short intervals was measured on other
starts of the slider-crank. TURN_SERIES=FOLDER keeps the series, and takes those that are there.
"""

import itertools
import os
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from publishing import publish, require

import clearance as cl
from clearance.mechanism.build import build
from clearance.metrics import statistics
from clearance.metrics.by_turn import Series
from clearance.motions import chaos
from clearance.motions.ensemble import Ensemble
from clearance.run.options import Solver

BEGIN = "<!-- turn statistics -->"
STARTS, TURNS, SETTLED, LEFT_OUT = 100, 320, 30, 10  # starts of a seed
COUNTS = (9, 20, 40, 100, 200, 280)
LOWEST, HIGHEST, SHORT = 0.92, 0.98, 100
SHORTEST = 0.9  # lowest share of the intervals of few turns
APART = 0.04  # largest share of groups of one motion that are distinguished; 1 % expected
FEW = 0.86  # lowest share of 25 groups: two standard deviations below 95 %
ERRORS = (0.2, 0.1)
#: by name: case, parameters and seeds of the starts
SCENES = {
    "dry slider-crank, 5000 rpm": (
        "slider_crank",
        {
            "model": "dry",
            "friction": "coulomb",
            "restitution": 0.9,
            "friction_coefficient": 0.03,
            "clearance": 1e-3,
            "speed": cl.rpm(5000),
        },
        (3, 4, 5, 6),
    ),
    "dry feeder, 300 rpm": ("six_bar_feeder", {"model": "dry"}, (3,)),
}


def series_of(name: str) -> dict[str, np.ndarray]:
    """Numbers of all turns, (starts, turns), of quantities that vary; seed after seed."""
    case, parameters, seeds = SCENES[name]
    parts = [_of_seed(case, parameters, seed) for seed in seeds]
    values = {n: np.concatenate([part[n] for part in parts]) for n in parts[0]}
    return {n: v for n, v in values.items() if v.std() > 0.0}


def _of_seed(case: str, parameters: dict, seed: int) -> dict[str, np.ndarray]:
    stored = os.environ.get("TURN_SERIES")
    path = stored and Path(stored) / f"{case}_{seed}.npz"
    if path and path.exists():
        return dict(np.load(path))
    mechanism = build(cl.load_case(case, **parameters))
    ensemble = Ensemble(mechanism, TURNS, Solver(1e-6), STARTS, seed=seed)
    ensemble.extend(TURNS)
    if path:
        np.savez(path, **ensemble.values)
    return ensemble.values


def covered(values: dict, truth: dict, count: int, widened: bool = True) -> float:
    """Share of the intervals of so many turns that hold the truth."""
    held = []
    for name, rows in values.items():
        for row in rows:
            mean = statistics.mean(row[LEFT_OUT : LEFT_OUT + count], widened)
            held.append(abs(mean.value - truth[name]) <= mean.half_width)
    return float(np.mean(held))


def covered_quantiles(values: dict, share: float, count: int) -> float:
    """The same of the intervals of a quantile of turn peaks."""
    held = []
    for rows in (v for n, v in values.items() if n.endswith(chaos.PEAKS)):
        true = np.quantile(rows[:, SETTLED:], share)
        for row in rows:
            result = statistics.quantile(row[LEFT_OUT : LEFT_OUT + count], share)
            held.append(not (result.low > true or result.high < true))
    return float(np.mean(held))


def agreeing(values: dict, short: int, long: int) -> float:
    """Share of pairs of runs of two lengths, from different starts, whose means agree within their
    joint interval.
    """
    held = []
    for rows in values.values():
        for one, two in itertools.pairwise(rows):
            a = statistics.mean(one[LEFT_OUT : LEFT_OUT + short])
            b = statistics.mean(two[LEFT_OUT : LEFT_OUT + long])
            held.append(abs(a.value - b.value) <= np.hypot(a.half_width, b.half_width))
    return float(np.mean(held))


class Stored:
    """Four starts of those that were run, as an ensemble that goes on."""

    starts = 4

    def __init__(self, values: dict, group: int):
        rows = slice(self.starts * group, self.starts * (group + 1))
        self.all = {n: v[rows] for n, v in values.items()}
        self.about = {n: Series(np.zeros(0), "1", n) for n in values}
        self.mechanism = SimpleNamespace(scene=SimpleNamespace(turn=1.0))

    def extend(self, turns: int) -> None:
        self.values = {n: v[:, :turns] for n, v in self.all.items()}


def stopped(values: dict, truth: dict, error: float) -> str:
    """Groups of four starts whose force stops by the rule: intervals that hold the truth, and
    turns.
    """
    name = next(n for n in values if n.startswith("joint_") and n.endswith("_force_peak"))
    held, turns, apart = [], [], 0
    for group in range(len(values[name]) // Stored.starts):
        runner = Stored(values, group)
        result = chaos._until_narrow(runner, {name: error}, 4 * TURNS, 1e-6, None)
        apart += len(result.motions) > 1
        if result.reached and len(result.motions) == 1:
            mean = result[name].mean
            held.append(abs(mean.value - truth[name]) <= mean.half_width)
            turns.append(result.turns)
    require(np.mean(held) >= FEW, f"stopped at {error:.0%}: {np.mean(held):.0%} hold the mean")
    groups = len(values[name]) // Stored.starts
    require(apart <= APART * groups, f"{apart} of {groups} groups of one motion are told apart")
    return f"{sum(held)} of {len(held)}, {np.median(turns):.0f} turns"


def scene_lines(name: str) -> tuple[list[str], list[str]]:
    values = series_of(name)
    truth = {n: float(v[:, SETTLED:].mean()) for n, v in values.items()}
    shares = [covered(values, truth, c) for c in COUNTS]
    plain = [covered(values, truth, c, widened=False) for c in COUNTS]
    seeds = range(0, len(next(iter(values.values()))), STARTS)
    apart = [
        covered({n: v[i : i + STARTS] for n, v in values.items()}, truth, COUNTS[-1]) for i in seeds
    ]
    require(LOWEST <= shares[-1] <= HIGHEST, f"{name}: {shares[-1]:.1%} of the intervals hold")
    require(min(shares) >= SHORTEST, f"{name}: only {min(shares):.1%} of short intervals hold")
    cells = [f"{100 * a:.1f} ({100 * b:.1f})" for a, b in zip(shares, plain, strict=True)]
    cells.append(", ".join(f"{100 * a:.1f}" for a in apart))
    agree = agreeing(values, SHORT, COUNTS[-1])
    require(agree >= LOWEST, f"{name}: {agree:.1%} of two lengths agree")
    tenth = covered_quantiles(values, 0.9, COUNTS[-1])
    require(tenth >= FEW, f"{name}: {tenth:.1%} of the quantiles' intervals hold")
    asked = [stopped(values, truth, e) for e in ERRORS]
    return [name, *cells], [name, f"{100 * agree:.1f}", f"{100 * tenth:.1f}", *asked]


def lines() -> list[str]:
    """Both tables."""
    rows = [scene_lines(name) for name in SCENES]
    heads = ["% of the intervals that hold the mean; turns:", *map(str, COUNTS)]
    heads.append(f"{COUNTS[-1]}, seeds apart")
    more = [
        "",
        f"agree, {SHORT} and {COUNTS[-1]} turns [%]",
        f"hold 1 turn in 10, {COUNTS[-1]} turns [%]",
        *(f"hold the mean force, stopped at +- {e:.0%}" for e in ERRORS),
    ]
    first, second = zip(*rows, strict=True)
    return [*table(heads, first), "", *table(more, second)]


def table(heads, rows) -> list[str]:
    return [f"| {' | '.join(r)} |" for r in (heads, ["---"] * len(heads), *rows)]


if __name__ == "__main__":
    publish(__doc__, lines, BEGIN)
