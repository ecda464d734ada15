"""Numbers of a run turn by turn: series whose means and quantiles do not depend on its length.

Names are made of body, drive and joint names:

  <body>_acceleration_peak        largest size of the acceleration in a turn, along the guide [m/s2]
  drive_<drive>_torque_peak, _rms (or force)                                        [N m] ([N])
  joint_<joint>_force_peak        largest force in a turn                            [N]
  joint_<joint>_penetration_peak  largest penetration in a turn, where surfaces touch [m]
  joint_<joint>_impact_speed_peak largest impact speed in a turn, 0 without impacts  [m/s]
  joint_<joint>_impacts_per_turn  contacts begun in a turn                           [-]
  dissipated_per_turn             energy taken out in a turn                         [J]
  <body>_position_deviation_peak  from the mechanism with ideal joints, in a turn    [m]
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from clearance.metrics.metrics import efforts
from clearance.metrics.statistics import FEWEST, Mean, mean
from clearance.results.extremes import BOTH, along, guides, sign_of
from clearance.results.record import Record

ROUNDING = 1e-9  # of a turn
TRANSIENT = 1  # turns of a start-up


@dataclass(frozen=True)
class Series:
    """One number a turn; values: (turns,), of many runs (runs, turns)."""

    values: np.ndarray
    units: str
    text: str


def by_turn(
    record: Record,
    first: float = 0.0,
    last: float = math.inf,
    forces: bool = False,
    ideal: dict | None = None,
) -> dict[str, Series]:
    """Series of a run over its full turns between `first` and `last`, counted from `first`, by
    name.

    forces: peaks of forces, efforts and accelerations alone; ideal: as of `metrics`. Empty for runs
        without turns. Numbers of channels that were not stored are left out.
    """
    if record.turn is None or not record.time.size:
        return {}
    last = min(last, float(record.turns_at(record.time[-1])))
    count = math.floor(last - first + ROUNDING)
    if count < 1:
        return {}
    edges = np.asarray(record.time_at(first + np.arange(count + 1)), float)
    turns = TurnsOfRecord(record, edges, ideal or {})
    return loads(turns) if forces else every(turns)


def means(record: Record, first: int = TRANSIENT) -> dict[str, Mean]:
    """Means over the turns from `first` on, with their 95 % intervals; none of fewer than eight
    turns.
    """
    series = by_turn(record, first)
    return {name: mean(s.values) for name, s in series.items() if len(s.values) >= FEWEST}


Numbers = Iterator[tuple[str, np.ndarray, str, str]]


class Turns(ABC):
    """Numbers of the turns of one run, (turns,), or of many, (runs, turns). None where they are not
    known.

    scene: description; names: of the members of a group, as of a record.
    """

    scene: dict
    names: Callable[[str], Sequence[str]]

    @abstractmethod
    def __contains__(self, path: str) -> bool: ...

    @abstractmethod
    def by_turn(self, name: str) -> np.ndarray | None:
        """An extreme in each turn."""

    @abstractmethod
    def mean_squares(self, path: str) -> np.ndarray | None:
        """Mean of the square of a channel in each turn."""

    @abstractmethod
    def increases(self, path: str) -> np.ndarray:
        """Growth of a sum in each turn."""

    @abstractmethod
    def impacts(self, joint: str) -> tuple[np.ndarray, np.ndarray]:
        """Largest speed of contacts that begin in each turn, 0 without any, and their number."""

    @abstractmethod
    def deviations(self, body: str, direction: tuple[float, float]) -> np.ndarray | None:
        """Largest distance of a body from where ideal joints have it, along its guide, among the
        samples up to each turn's end.
        """


class TurnsOfRecord(Turns):
    """Numbers of the turns of a record between some edges [s]; ideal: as of `metrics`."""

    def __init__(self, record: Record, edges: np.ndarray, ideal: dict):
        self.record, self.edges, self.ideal = record, edges, ideal
        self.scene, self.names = record.scene, record.names
        self.count = len(edges) - 1

    def __contains__(self, path: str) -> bool:
        return path in self.record

    def by_turn(self, name: str) -> np.ndarray | None:
        return _peaks(self.record, name, self.edges)

    def mean_squares(self, path: str) -> np.ndarray | None:
        turn, inside = placed(self.record.time, self.edges)
        counts = np.bincount(turn[inside], minlength=self.count)
        if not counts.all():
            return None
        if (amounts := self.record.summed(f"{path}_square", self.edges)) is not None:
            return amounts / np.diff(self.edges)
        squares = self.record.values(path)[inside] ** 2
        return np.bincount(turn[inside], squares, self.count) / counts

    def increases(self, path: str) -> np.ndarray:
        if (growth := self.record.summed(f"{path}_growth", self.edges)) is not None:
            return growth
        return np.diff(np.interp(self.edges, self.record.time, self.record.values(path)))

    def impacts(self, joint: str) -> tuple[np.ndarray, np.ndarray]:
        events, fastest = self.record.events, np.zeros(self.count)
        mine = np.array([str(spot).partition("/")[0] == joint for spot in events["joint"]], bool)
        turn, inside = placed(events["time"][mine], self.edges)
        np.maximum.at(fastest, turn[inside], events["impact_speed"][mine][inside])
        return fastest, np.bincount(turn[inside], minlength=self.count).astype(float)

    def deviations(self, body: str, direction: tuple[float, float]) -> np.ndarray | None:
        if body not in self.ideal:
            return None
        edges = self.edges
        turn = np.digitize(self.record.time, edges + ROUNDING * (edges[1] - edges[0])) - 1
        inside, largest = (turn >= 0) & (turn < self.count), np.zeros(self.count)
        x, y = (self.record.values(f"bodies/{body}/{axis}") for axis in "xy")
        (dx, dy), (position, _) = direction, self.ideal[body]
        np.maximum.at(largest, turn[inside], np.abs(x * dx + y * dy - position)[inside])
        return largest


def every(turns: Turns) -> dict[str, Series]:
    """All series, by name."""
    parts = _efforts(turns), _contacts(turns), _energy(turns), _deviations(turns)
    return loads(turns) | {name: Series(*about) for part in parts for name, *about in part}


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


def _efforts(turns: Turns) -> Numbers:
    for path, name, units, words in efforts(turns):
        if (means := turns.mean_squares(path)) is not None:
            yield f"{name}_rms", np.sqrt(means), units, f"root mean square {words} in a turn"


def _forces(turns: Turns) -> Numbers:
    for name in turns.names("joints"):
        force = turns.by_turn(f"joints/{name}/force_max")
        if force is not None:
            yield f"joint_{name}_force_peak", force, "N", f"largest force in joint {name} in a turn"


def _contacts(turns: Turns) -> Numbers:
    for joint in turns.scene["joints"]:
        if joint.get("clearance") is not None and joint["contact"]:
            yield from _touches(turns, joint["name"])


def _touches(turns: Turns, name: str) -> Numbers:
    if (gap := turns.by_turn(f"joints/{name}/gap_min")) is not None:
        text = f"largest penetration in joint {name} in a turn"
        yield f"joint_{name}_penetration_peak", np.maximum(-gap, 0.0), "m", text
    fastest, count = turns.impacts(name)
    text = f"largest impact speed of joint {name} in a turn"
    yield f"joint_{name}_impact_speed_peak", fastest, "m/s", text
    yield f"joint_{name}_impacts_per_turn", count, "1", f"contacts begun in a turn of joint {name}"


def _energy(turns: Turns) -> Numbers:
    if "energy/dissipated" in turns:
        spent = turns.increases("energy/dissipated")
        yield "dissipated_per_turn", spent, "J", "energy taken out in a turn"


def _deviations(turns: Turns) -> Numbers:
    for body, direction in guides(turns.scene).items():
        if (far := turns.deviations(body, direction)) is not None:
            text = f"largest distance of {body} from where ideal joints have it in a turn"
            yield f"{body}_position_deviation_peak", far, "m", text


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
    sign, best = sign_of(name), np.full(len(edges) - 1, -np.inf)
    for times, values in _seen(record, name):
        turn, inside = placed(times, edges)
        np.maximum.at(best, turn[inside], sign * values[inside])
    here = located is not None and name in located
    ends = record.between_samples(name.rpartition("_")[0], edges) if here else None
    if ends is not None:
        best = np.maximum.reduce([best, sign * ends[:-1], sign * ends[1:]])
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
