"""Studies of what a LuGre model leaves out: the preload, coefficients that depend on the speed,
scatter of the runs.

After appendices J and K of Pfitzer et al., Lubricants 13 (2025) 436, whose numbers were not at
hand. Also a study of the overshoot of models in fast spin on the synthetic bench.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from clearance.paper_figures.ball_joint_bench import PRELOAD, Joint, bench

from clearance.identify import models
from clearance.identify.fit import Fit, fit
from clearance.identify.models import VISCOUS, LuGre
from clearance.identify.records import Measurement, Trial

PRELOADS = 2000.0, 3500.0, 5000.0, 8000.0, 12000.0  # N
SEEN = 2000.0, 5000.0, 8000.0  # of these in the training; one lies between them, one beyond
#: choices for the functions of the speed, by what they are called
COEFFICIENTS = {
    "constant": {},
    "table of 4 speeds": {"knots": (0.02, 0.1, 0.3, 1.0)},
    "network of 2 units": {"network": 2},
}
STARTS, STARTS_NETWORK = 5, 2
FAST = 400.0  # deg/s, of the fastest motion
HELD, TURNED = 0.5, 0.25  # s and rad, for which a speed is held at least to see the steady torque


# --- the preload
@dataclass(frozen=True, eq=False)
class Load:
    """Fit of a model with one choice of `load` to trials of several preloads: NRMSE of test trials
    by preload.
    """

    load: str
    fit: Fit
    test: dict[float, float]


def loads(starts: int = STARTS, scatter: float = 0.0, seed: int = 0) -> list[Load]:
    """The three choices of LuGre's load, fitted to training trials at `SEEN`, tried on those of all
    `PRELOADS`.

    scatter: of the level from run to run, which has nothing to do with the load.
    """
    measured = bench(seed, scatter=scatter, preloads=PRELOADS)
    seen = [t for t in measured.of("training").trials if t.facts["preload"] in SEEN]
    tests = {
        p: [t for t in measured.of("test").trials if t.facts["preload"] == p] for p in PRELOADS
    }
    rows = []
    for load in models.LOADS:
        fitted = fit(
            Measurement(tuple(seen), measured.facts), models.lugre3d(load=load), starts=starts
        )
        rows.append(Load(load, fitted, {p: fitted.score(trials) for p, trials in tests.items()}))
    return rows


# --- coefficients
@dataclass(frozen=True, eq=False)
class Coefficients:
    """A choice for T, sigma0, sigma1: its fit, and NRMSE by group: training, test, fast, small,
    mixed.
    """

    name: str
    fit: Fit
    nrmse: dict[str, float]


def coefficients(
    measurement: Measurement, starts: int = STARTS, say: Callable[[str], None] = lambda text: None
) -> list[Coefficients]:
    """Constant coefficients beside those that depend on the speed, of the 3-D model."""
    groups = {role: list(measurement.of(role).trials) for role in ("training", "test")}
    kinds = {"triangle": "fast", "sine": "small", "mixed": "mixed"}
    for trial in bench(scatter=0.0, noise=0.0).of("extrapolation").trials:
        groups.setdefault(kinds[trial.kind], []).append(trial)
    rows = []
    for name, options in COEFFICIENTS.items():
        most = STARTS_NETWORK if "network" in options else starts
        fitted = fit(measurement, models.lugre3d(**options), starts=min(starts, most))
        rows.append(Coefficients(name, fitted, {g: fitted.score(t) for g, t in groups.items()}))
        say(f"{name}: fitted in {fitted.facts['seconds']:.1f} s")
    return rows


# --- fast spin
@dataclass(frozen=True, eq=False)
class Spin:
    """Fits of spin from training trials. Scatter and seeds (n,) of the bench, viscous coefficients
    (n,) [N m s/rad], and largest torques at 400 deg/s over the true one (n,).
    """

    scatter: float
    seeds: tuple[int, ...]
    viscous: np.ndarray
    peak: np.ndarray


def fast_spin(scatter: float, seeds: Sequence[int]) -> Spin:
    """LuGre of the spin axis on several draws of the bench, in its fastest motion."""
    fast = bench(scatter=0.0, noise=0.0).named("p15_triangle_spin")
    viscous, peak = [], []
    for seed in seeds:
        trials = [t for t in bench(seed, scatter=scatter).of("training").trials if t.axis == "spin"]
        result = fit(Measurement(tuple(trials)), models.lugre1d(), starts=3)
        viscous.append(result.values["spin_viscous"])
        peak.append(abs(result.torque(fast)[:, 2]).max() / abs(fast.torque[:, 2]).max())
    return Spin(scatter, tuple(seeds), np.array(viscous), np.array(peak))


def steady(torque: Callable[[Trial], np.ndarray], speeds: Sequence[float]) -> np.ndarray:
    """Torque (n,) [N m] about the stud once each speed [rad/s] was held; both ways are averaged."""
    rows = []
    for speed in speeds:
        ends, time = [], 1e-3 * np.arange(round(1e3 * max(HELD, TURNED / speed)))
        for way in (1.0, -1.0):
            rate = np.zeros((time.size, 3))
            rate[:, 2] = way * speed
            facts = {"preload": PRELOAD}
            trial = Trial(
                "held", "other", "spin", "other", time, rate, rate, (False, False, True), facts
            )
            ends.append(way * float(torque(trial)[-1, 2]))
        rows.append(np.mean(ends))
    return np.array(rows)


def true_steady(speeds: Sequence[float]) -> np.ndarray:
    """The same of the bench's joint, warm, and averaged over its seat."""
    joint, speeds = Joint(), np.asarray(speeds, float)
    excess = (joint.ratio - 1.0) * np.exp(-((speeds / joint.stribeck) ** 2))
    return joint.torque[2] * (1.0 + excess) + joint.viscosity * speeds


def viscous_share(result: Fit, speed: float) -> float:
    """Share of the viscous term in a LuGre model's steady torque of spin at a speed [rad/s]."""
    model: LuGre = result.model
    functions = model.functions(result.values, np.array([speed]))[2, :, 0]
    term = functions[VISCOUS] * speed
    return float(term / (functions[0] + term))


# --- tables
def load_table(rows: Sequence[Load]) -> list[str]:
    """NRMSE by preload as lines of Markdown."""
    heads = [f"{p:g} N{'' if p in SEEN else ' (not fitted)'}" for p in PRELOADS]
    lines = ["| load of the model | " + " | ".join(heads) + " | exponent, tilt | exponent, spin |"]
    lines.append("|---" * (len(heads) + 3) + "|")
    for f in rows:
        scores = " | ".join(f"{f.test[p]:.3f}" for p in PRELOADS)
        lines.append(
            f"| {f.load} | {scores} | {_exponent(f.fit, 'tilt')} | {_exponent(f.fit, 'spin')} |"
        )
    return lines


def _exponent(result: Fit, group: str) -> str:
    name = f"{group}_{models.FOLLOWS.name}"
    if name not in result.values:
        return {"fixed": "0", "proportional": "1"}[result.model.load]
    low, high = result.widened()
    return f"{result.values[name]:.3f} ({low[name]:.3f} to {high[name]:.3f})"


def coefficient_table(rows: Sequence[Coefficients]) -> list[str]:
    """NRMSE by group as lines of Markdown."""
    groups = list(rows[0].nrmse)
    lines = [
        "| T, sigma0, sigma1 | parameters | " + " | ".join(groups) + " |",
        "|---" * (len(groups) + 2) + "|",
    ]
    for f in rows:
        scores = " | ".join(f"{f.nrmse[g]:.3f}" for g in groups)
        lines.append(f"| {f.name} | {len(f.fit.values)} | {scores} |")
    return lines


def spin_table(rows: Sequence[Spin]) -> list[str]:
    """Table of fast spin over draws of the bench, as lines of Markdown."""
    lines = [
        "| scatter from run to run | draws | viscous [N m s/rad], true 0.05 | torque at 400 deg/s "
        "over the true one |",
        "|---|---|---|---|",
    ]
    for f in rows:
        texts = (
            f"{np.median(v):.2f} ({v.min():.2f} to {v.max():.2f})" for v in (f.viscous, f.peak)
        )
        lines.append(f"| {100 * f.scatter:g} % | {len(f.seeds)} | " + " | ".join(texts) + " |")
    return lines


def fastest() -> float:
    """The rate of the fastest motion [rad/s]."""
    return math.radians(FAST)
