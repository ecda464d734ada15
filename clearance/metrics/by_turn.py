"""Numbers of a run turn by turn: series whose means and quantiles do not depend on its length.

Names are made of body, drive and joint names:

  <body>_acceleration_peak        largest size of the acceleration in a turn, along the guide [m/s2]
  drive_<drive>_torque_peak, _rms (or force)                                        [N m] ([N])
  joint_<joint>_force_peak        largest force in a turn                            [N]
  joint_<joint>_penetration_peak  largest penetration in a turn, where surfaces touch [m]
  joint_<joint>_impact_speed_peak largest impact speed in a turn, 0 without impacts  [m/s]
  joint_<joint>_impacts_per_turn  contacts begun in a turn                           [-]
  dissipated_per_turn             energy taken out in a turn                         [J]
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from clearance.metrics.metrics import efforts
from clearance.metrics.statistics import FEWEST, Mean, mean
from clearance.results.extremes import BOTH, along, guides
from clearance.results.record import Record

ROUNDING = 1e-9  # of a turn
TRANSIENT = 1  # turns of a start-up


@dataclass(frozen=True)
class Series:
    """One number a turn; values: (turns,)."""

    values: np.ndarray
    units: str
    text: str


def by_turn(
    record: Record, first: float = 0.0, last: float = math.inf, forces: bool = False
) -> dict[str, Series]:
    """Series of a run over its full turns between `first` and `last`, counted from `first`, by
    name.

    forces: peaks of forces, efforts and accelerations alone. Empty for runs without turns. Numbers
        of channels that were not stored are left out.
    """
    if record.turn is None or not record.time.size:
        return {}
    last = min(last, float(record.turns_at(record.time[-1])))
    count = math.floor(last - first + ROUNDING)
    if count < 1:
        return {}
    edges = np.asarray(record.time_at(first + np.arange(count + 1)), float)
    peaks = loads(Turns(record, edges))
    if forces:
        return peaks
    parts = _efforts(record, edges), _contacts(record, edges), _energy(record, edges)
    return peaks | {name: Series(*about) for part in parts for name, *about in part}


def means(record: Record, first: int = TRANSIENT) -> dict[str, Mean]:
    """Means over the turns from `first` on, with their 95 % intervals; none of fewer than eight
    turns.
    """
    series = by_turn(record, first)
    return {name: mean(s.values) for name, s in series.items() if len(s.values) >= FEWEST}


Numbers = Iterator[tuple[str, np.ndarray, str, str]]


class Turns:
    """Largest and smallest values of a record in each of the turns between some edges [s]."""

    def __init__(self, record: Record, edges: np.ndarray):
        self.record, self.edges = record, edges
        self.scene, self.names = record.scene, record.names

    def __contains__(self, path: str) -> bool:
        return path in self.record

    def by_turn(self, name: str) -> np.ndarray | None:
        """An extreme in each turn, see `_peaks`."""
        return _peaks(self.record, name, self.edges)


def loads(turns: Turns) -> dict[str, Series]:
    """Largest accelerations, efforts and forces in each turn, by name."""
    parts = _bodies(turns), _drives(turns), _forces(turns)
    return {name: Series(*about) for part in parts for name, *about in part}


def _bodies(turns: Turns) -> Numbers:
    for body, direction in guides(turns.scene).items():
        axis, share = along(direction)
        values = _sizes(turns, f"bodies/{body}/a{axis}")
        if values is not None:
            text = f"largest acceleration of {body} in a turn"
            yield f"{body}_acceleration_peak", values / abs(share), "m/s2", text


def _drives(turns: Turns) -> Numbers:
    for path, name, units, words in efforts(turns):
        yield f"{name}_peak", _sizes(turns, path), units, f"largest {words} in a turn"


def _efforts(record: Record, edges: np.ndarray) -> Numbers:
    turns = len(edges) - 1
    turn, inside = placed(record.time, edges)
    counts = np.bincount(turn[inside], minlength=turns)
    for path, name, units, words in efforts(record) if counts.all() else ():
        means = _mean_squares(record, path, edges)
        if means is None:
            means = np.bincount(turn[inside], record.values(path)[inside] ** 2, turns) / counts
        yield f"{name}_rms", np.sqrt(means), units, f"root mean square {words} in a turn"


def _mean_squares(record: Record, path: str, edges: np.ndarray) -> np.ndarray | None:
    """Mean squares of a channel between edges, from the integrals of the run; None where these have
    other edges.
    """
    integrals, name = record.integrals, f"{path}_square"
    if integrals is None or name not in integrals.cumulated:
        return None
    amounts = integrals.between(name, edges)
    return None if amounts is None else amounts / np.diff(edges)


def _forces(turns: Turns) -> Numbers:
    for name in turns.names("joints"):
        force = turns.by_turn(f"joints/{name}/force_max")
        if force is not None:
            yield f"joint_{name}_force_peak", force, "N", f"largest force in joint {name} in a turn"


def _contacts(record: Record, edges: np.ndarray) -> Numbers:
    for joint in record.scene["joints"]:
        if joint["name"] in record.clearances and joint["contact"]:
            yield from _touches(record, joint["name"], edges)


def _touches(record: Record, name: str, edges: np.ndarray) -> Numbers:
    gap = _peaks(record, f"joints/{name}/gap_min", edges)
    if gap is not None:
        deepest = np.maximum(-gap, 0.0)
        yield (
            f"joint_{name}_penetration_peak",
            deepest,
            "m",
            f"largest penetration in joint {name} in a turn",
        )
    events = record.events
    mine = np.array([str(spot).partition("/")[0] == name for spot in events["joint"]], bool)
    speed, (turn, inside) = events["impact_speed"][mine], placed(events["time"][mine], edges)
    fastest = np.zeros(len(edges) - 1)
    np.maximum.at(fastest, turn[inside], speed[inside])
    yield (
        f"joint_{name}_impact_speed_peak",
        fastest,
        "m/s",
        f"largest impact speed of joint {name} in a turn",
    )
    count = np.bincount(turn[inside], minlength=len(edges) - 1).astype(float)
    yield f"joint_{name}_impacts_per_turn", count, "1", f"contacts begun in a turn of joint {name}"


def _energy(record: Record, edges: np.ndarray) -> Numbers:
    if "energy/dissipated" in record:
        values = np.diff(np.interp(edges, record.time, record.values("energy/dissipated")))
        yield "dissipated_per_turn", values, "J", "energy taken out in a turn"


def _sizes(turns: Turns, path: str) -> np.ndarray | None:
    """Largest size of a channel in each turn."""
    low, high = (turns.by_turn(f"{path}_{end}") for end in BOTH)
    return None if low is None or high is None else np.maximum(np.abs(low), np.abs(high))


def _peaks(record: Record, name: str, edges: np.ndarray) -> np.ndarray | None:
    """An extreme in each turn; None where a turn has none, for the channel was not stored."""
    located = record.located
    if located is not None and name in located:
        first = round(edges[0] / located.length)
        starts = located.length * np.arange(first, first + len(edges))
        if np.abs(edges - starts).max() <= ROUNDING * located.length:
            return located.values[first : first + len(edges) - 1, located.columns[name]]
    sign, best = -1.0 if name.endswith("_min") else 1.0, np.full(len(edges) - 1, -np.inf)
    for times, values in _seen(record, name):
        turn, inside = placed(times, edges)
        np.maximum.at(best, turn[inside], sign * values[inside])
    return sign * best if np.isfinite(best).all() else None


def placed(times: np.ndarray, edges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The turn that each time lies in, and which lie in one at all; edges belong to the turn that
    they begin.
    """
    turn = np.digitize(times, edges - ROUNDING * (edges[1] - edges[0])) - 1
    return turn, (turn >= 0) & (turn < len(edges) - 1)


def _seen(record: Record, name: str) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Times and values that an extreme may be among: located ones, and samples."""
    path, located = name.rpartition("_")[0], record.located
    if located is not None and name in located:
        yield located.times[:, located.columns[name]], located.values[:, located.columns[name]]
    if path in record:
        yield record.time, record.values(path)
    elif f"{path}_x" in record:
        yield record.time, np.hypot(record.values(f"{path}_x"), record.values(f"{path}_y"))
