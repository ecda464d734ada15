"""Statistics over turns, with their sampling error: what is comparable of a chaotic run."""

import math
from dataclasses import dataclass

import numpy as np

from clearance.results import Result

TRANSIENT = 1  # turns left out at the start
FEWEST = 4  # turns needed for a sampling error


@dataclass(frozen=True)
class Mean:
    """Mean of a quantity over turns, and the standard error of that mean."""

    value: float
    error: float
    turns: int

    def __str__(self) -> str:
        return f"{self.value:.4g} +- {self.error:.2g}"


def mean(values: np.ndarray) -> Mean:
    """Mean and standard error of a series that may be correlated from turn to turn.

    error = s / sqrt(N) * sqrt((1 + r) / (1 - r)), s the standard deviation, r the correlation of neighbours where it is
    positive: with r the number of independent turns falls (Bartlett 1946).
    """
    values = np.asarray(values, float)
    count = len(values)
    deviation = values - values.mean()
    spread = float((deviation**2).sum())
    r = float((deviation[1:] * deviation[:-1]).sum()) / spread if spread > 0.0 else 0.0
    r = min(max(r, 0.0), 0.95)
    error = math.sqrt(spread / (count - 1) / count * (1.0 + r) / (1.0 - r))
    return Mean(float(values.mean()), error, count)


def over_turns(result: Result, turn: float | None) -> dict[str, Mean]:
    """Means over whole turns after the first: contacts and largest contact force by joint, effort of the drives, energy
    dissipated. Empty for runs too short for a sampling error, or without turns.
    """
    time = np.asarray(result.time)
    if turn is None or not time.size:
        return {}
    turns = int(math.floor(result.turns_at(time[-1]) * (1.0 + 1e-12)))
    if turns - TRANSIENT < FEWEST:
        return {}
    edges = result.time_at(np.arange(TRANSIENT, turns + 1))
    found = {}
    events = result.events
    for joint in dict.fromkeys(str(j) for j in events["joint"]):
        own = np.array([str(j) == joint for j in events["joint"]])
        at, force = np.asarray(events["time"])[own], np.asarray(events["peak_force"])[own]
        place = np.digitize(at, edges) - 1
        found[f"{joint} contacts a turn"] = mean(np.bincount(place[place >= 0], minlength=turns)[: len(edges) - 1])
        found[f"{joint} largest contact force [N]"] = mean(
            [force[place == i].max(initial=0.0) for i in range(len(edges) - 1)]
        )
    place = np.digitize(time, edges) - 1
    for name in result.names("drives"):
        drive = result.drive(name)
        quantity, unit = ("torque", "N m") if "torque" in drive else ("force", "N")
        if quantity not in drive:
            continue
        values = getattr(drive, quantity)
        rows = [values[place == i] for i in range(len(edges) - 1)]
        if all(len(r) for r in rows):
            found[f"{name} rms {quantity} [{unit}]"] = mean([math.sqrt((r**2).mean()) for r in rows])
    if "energy/dissipated" in result:
        dissipated = np.interp(edges, time, result.energy.dissipated)
        found["dissipated a turn [J]"] = mean(np.diff(dissipated))
    return found
