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

from clearance.extremes import along, guides
from clearance.results import Record
from clearance.series import FEWEST, Mean, mean

ROUNDING = 1e-9  # of a turn
TRANSIENT = 1  # turns of a start-up
EFFORTS = {"torque": "N m", "force": "N"}


@dataclass(frozen=True)
class Series:
    """One number a turn; values: (turns,)."""

    values: np.ndarray
    units: str
    text: str


def by_turn(record: Record, first: int = 0, last: int | None = None) -> dict[str, Series]:
    """Series of a run over its turns from `first` up to `last` (default: all whole ones), by name.

    Empty for runs without turns. Numbers of channels that were not kept are left out.
    """
    if record.turn is None or not record.time.size:
        return {}
    whole = math.floor(float(record.turns_at(record.time[-1])) + ROUNDING)
    last = whole if last is None else min(last, whole)
    if last <= first:
        return {}
    edges = np.asarray(record.time_at(np.arange(first, last + 1)), float)
    parts = (_bodies, _drives, _joints, _energy)
    return {name: Series(*about) for part in parts for name, *about in part(record, edges)}


def means(record: Record, first: int = TRANSIENT) -> dict[str, Mean]:
    """Means over the turns from `first` on, with their 95 % intervals; none of fewer than eight turns."""
    found = by_turn(record, first)
    return {name: mean(s.values) for name, s in found.items() if len(s.values) >= FEWEST}


Found = Iterator[tuple[str, np.ndarray, str, str]]


def _bodies(record: Record, edges: np.ndarray) -> Found:
    for body, direction in guides(record.scene).items():
        axis, share = along(direction)
        values = _sizes(record, f"bodies/{body}/a{axis}", edges)
        if values is not None:
            text = f"largest acceleration of {body} along its guide in a turn"
            yield f"{body}_acceleration_peak", values / abs(share), "m/s2", text


def _drives(record: Record, edges: np.ndarray) -> Found:
    place = np.digitize(record.time, edges - ROUNDING * record.turn) - 1
    for drive in record.names("drives"):
        for quantity, units in EFFORTS.items():
            path, name = f"drives/{drive}/{quantity}", f"drive_{drive}_{quantity}"
            if path not in record:
                continue
            yield f"{name}_peak", _sizes(record, path, edges), units, f"largest {quantity} of drive {drive} in a turn"
            inside = (place >= 0) & (place < len(edges) - 1)
            squares = record.values(path)[inside] ** 2
            counts = np.bincount(place[inside], minlength=len(edges) - 1)
            if counts.all():
                rms = np.sqrt(np.bincount(place[inside], squares, len(edges) - 1) / counts)
                yield f"{name}_rms", rms, units, f"root mean square {quantity} of drive {drive} in a turn"


def _joints(record: Record, edges: np.ndarray) -> Found:
    described = {j["name"]: j for j in record.scene["joints"]}
    for name in record.names("joints"):
        force = _peaks(record, f"joints/{name}/force_max", edges)
        if force is not None:
            yield f"joint_{name}_force_peak", force, "N", f"largest force in joint {name} in a turn"
        if name in record.clearances and described[name]["contact"]:
            yield from _contacts(record, name, edges)


def _contacts(record: Record, name: str, edges: np.ndarray) -> Found:
    gap = _peaks(record, f"joints/{name}/gap_min", edges)
    if gap is not None:
        deepest = np.maximum(-gap, 0.0)
        yield f"joint_{name}_penetration_peak", deepest, "m", f"largest penetration in joint {name} in a turn"
    events = record.events
    mine = np.array([str(spot).partition("/")[0] == name for spot in events["joint"]], bool)
    speed, place = events["impact_speed"][mine], np.digitize(events["time"][mine], edges) - 1
    inside = (place >= 0) & (place < len(edges) - 1)
    fastest = np.zeros(len(edges) - 1)
    np.maximum.at(fastest, place[inside], speed[inside])
    yield f"joint_{name}_impact_speed_peak", fastest, "m/s", f"largest impact speed of joint {name} in a turn"
    count = np.bincount(place[inside], minlength=len(edges) - 1).astype(float)
    yield f"joint_{name}_impacts_per_turn", count, "1", f"contacts begun in a turn of joint {name}"


def _energy(record: Record, edges: np.ndarray) -> Found:
    if "energy/dissipated" in record:
        values = np.diff(np.interp(edges, record.time, record.values("energy/dissipated")))
        yield "dissipated_per_turn", values, "J", "energy taken out in a turn"


def _sizes(record: Record, path: str, edges: np.ndarray) -> np.ndarray | None:
    """Largest size of a channel in each turn."""
    low, high = (_peaks(record, f"{path}_{end}", edges) for end in ("min", "max"))
    return None if low is None or high is None else np.maximum(np.abs(low), np.abs(high))


def _peaks(record: Record, name: str, edges: np.ndarray) -> np.ndarray | None:
    """An extreme in each turn; None for a channel that was not kept."""
    located = record.located
    if located is not None and name in located:
        first = round(edges[0] / located.length)
        starts = located.length * np.arange(first, first + len(edges))
        if np.allclose(edges, starts, rtol=0.0, atol=ROUNDING * located.length):
            return located.values[first : first + len(edges) - 1, located.columns[name]]
    try:
        pairs = zip(edges[:-1], edges[1:], strict=True)
        return np.array([record.extreme(name, begin, end).value for begin, end in pairs])
    except KeyError:
        return None
