"""Warnings about a fit: records that no friction gives, errors as large as the torque,
autocorrelated residuals.
"""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from clearance.identify.trials import AXES

GIVES = 0.05  # share of the power's size from which energy given counts as more than noise
WORST = 1.0  # NRMSE of a model without torque
FAINT = 0.02  # N m: rms torque below which the bounds of models end, and below that of ball joints
WINDOW = 5.0  # lags that are summed, over the correlation time that they give
LAG = 0.1  # least number of samples for the warning of a shift of torque and rate in time
SURE = 4.0  # standard errors, widened, from which that shift counts as there
UNLIKE = 1.1  # ratio of the largest preload to the smallest from which they differ
WIDER = 1.5  # factor for the warning that intervals are too narrow


def of_records(trials: Sequence) -> tuple[str, ...]:
    """Axes about which the joint gives energy over a trial: the sign of torque or rate is wrong."""
    doubts = []
    for i, axis in enumerate(AXES):
        works = {}
        for trial in (t for t in trials if t.measured[i] and t.rate[:, i].any()):
            power = trial.torque[:, i] * trial.rate[:, i] * trial.step
            works[trial.name] = float(power.sum()), float(abs(power).sum())
        giving = {name: work for name, (work, size) in works.items() if work < -GIVES * size}
        if giving:
            first, count = next(iter(giving)), f"{len(giving)} of {len(works)} trials"
            doubts.append(
                f"torque_{axis}: the joint gives energy in {count} ({-giving[first]:.3g} J in "
                f"{first}), which "
                f"friction cannot; is the sign of torque_{axis} or rate_{axis} flipped?"
            )
    return tuple(doubts)


def of_scores(scores: Mapping[str, float], trials: Sequence) -> tuple[str, ...]:
    """Roles whose error is as large as the torque itself."""
    bad = [r for r, score in scores.items() if not score < WORST]
    if not trials:
        return tuple(f"{r}: NRMSE {scores[r]:.3g}, no better than a model of zeros" for r in bad)
    squares = np.concatenate([(t.torque[:, np.array(t.measured)] ** 2).ravel() for t in trials])
    size = math.sqrt(float(squares.mean()))
    faint = (
        f"; the torques fitted are {size:.3g} N m (rms): are they in kN m?" if size < FAINT else ""
    )
    return tuple(
        f"{r}: NRMSE {scores[r]:.3g}, no better than a model without torque{faint}" for r in bad
    )


def of_loads(model, trials: Sequence) -> tuple[str, ...]:
    """Preloads that differ, of which the model makes nothing."""
    loads = [float(t.facts["preload"]) for t in trials if "preload" in t.facts]
    if getattr(model, "load", "") != "fixed" or not loads or max(loads) < UNLIKE * min(loads):
        return ()
    return (
        f"preloads lie between {min(loads):g} and {max(loads):g} N, and the model has one level "
        f"for all: "
        "-p load=proportional or power lets it follow",
    )


def correlation(errors: Sequence[np.ndarray]) -> float:
    """Integrated autocorrelation time of series (n,) of errors, in samples: 1 where all are
    independent.

    tau = 1 + 2 sum_k rho_k up to the least lag that is `WINDOW` times tau (Sokal), rho of all
    series together.
    """
    longest = max(len(e) for e in errors)
    products = np.zeros(longest)
    for e in errors:
        power = np.abs(np.fft.rfft(e, 2 * len(e))) ** 2
        products[: len(e)] += np.fft.irfft(power, 2 * len(e))[: len(e)]
    if not products[0] > 0.0:
        return 1.0
    times = 2.0 * np.cumsum(products / products[0]) - 1.0
    ended = np.flatnonzero(np.arange(longest) >= WINDOW * times)
    return max(float(times[ended[0]] if ended.size else times.max()), 1.0)


def of_short_damping(model, values: Mapping[str, float], trials: Sequence) -> tuple[str, ...]:
    """Dampings of bristles that half a sample between torque and rate would change by more than
    themselves.

    In presliding a torque that comes a time t late is one with sigma1 - sigma0 t in place of
    sigma1.
    """
    if not trials or getattr(model, "lag", True):
        return ()
    half, doubts = 0.5 * max(t.step for t in trials), []
    moved = {a for t in trials for a in range(3) if t.rate[:, a].any()}
    for group in dict.fromkeys(g for a, g in enumerate(model.groups) if a in moved):
        name, stiffness = f"{group}_damping", values.get(f"{group}_stiffness")
        if name in values and stiffness is not None and values[name] < half * stiffness:
            doubts.append(
                f"{name}: {values[name]:.3g} N m s/rad is less than half a sample between torque "
                f"and rate would make "
                f"({half * stiffness:.3g}): it means nothing unless both are measured at the same "
                f"time"
            )
    return tuple(doubts)


def of_lag(facts: Mapping, trials: Sequence) -> tuple[str, ...]:
    """A torque that comes before or after its rate, and the parameter that this moves most."""
    lag, error = facts.get("lag", 0.0), facts.get("lag_error", 0.0) * facts.get("widening", 1.0)
    step = max(t.step for t in trials)
    if not abs(lag) > max(LAG * step, SURE * error):
        return ()
    way = "after" if lag > 0.0 else "before"
    return (
        f"the torque comes about {abs(lag):.1g} s ({abs(lag) / step:.1g} samples) {way} its rate, "
        f"by the errors of the "
        f"fit; that moves {facts['lag_moves']} most: is each rate measured at the time of its "
        f"torque?",
    )


def of_intervals(widening: float, samples: int, independent: float) -> tuple[str, ...]:
    """Intervals from autocorrelated residuals."""
    if widening < WIDER:
        return ()
    return (
        f"the 95 % intervals are too narrow by a factor of about {widening:.2g}: the errors are "
        f"autocorrelated, {samples} samples are worth {independent:.0f} independent ones",
    )
