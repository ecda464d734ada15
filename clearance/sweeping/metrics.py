"""Summary metrics of a run: what a map over speed and clearance shows.

Each is computed over the window of a run: whole turns after the first `settle` ones (runs without a turn: after
`settle` seconds). Names are made of body, drive and joint names:

  <body>_acceleration_min, _max   of bodies that slide on the ground, along their guide [m/s2]
  drive_<drive>_torque_min, _max, _rms (or force)                                       [N m] ([N])
  joint_<joint>_force_max, _rms   largest (samples and contacts) and root mean square    [N]
  joint_<joint>_gap_min           smallest gap, negative in contact (clearance joints)   [m]
  joint_<joint>_eccentricity_ratio_max                                                   [-]
  joint_<joint>_film_thickness_ratio_min   gap over composite roughness                  [-]
  joint_<joint>_contact_fraction  share of the time in contact                           [-]
  joint_<joint>_impacts_per_turn, _impact_speed_max   of dry joints                      [-], [m/s]
  joint_<joint>_dissipated_per_turn   energy that the joint takes out in a turn          [J]
  dissipated_per_turn             of all joints and dampers                              [J]
  <body>_position_deviation_max, <body>_acceleration_deviation_rms   from the mechanism with ideal joints [m], [m/s2]
  period                          smallest number of turns after which the journals are back within 1 % of their
                                  clearance, up to a third of the turns seen; inf: none                      [turns]
  period_error                    largest distance over the clearance after that many turns (none: the least) [-]

Runs without a turn have rates per second (impacts_per_second, dissipated_power [W]) instead. A user's own function
`name(run) -> {"metric": value}` or `{"metric": (value, units, text)}` adds to them; `run` reads like a result.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from clearance.results import Record

PERIODIC = 0.01  # distance over the clearance below which a journal counts as back
FEWEST = 4  # points of a section needed to tell a period


@dataclass(frozen=True)
class Metric:
    """One number that sums up a run."""

    value: float
    units: str
    text: str


@dataclass(frozen=True)
class Window:
    """The part of a run that its metrics are about: from begin to end [s], and the samples in it."""

    begin: float
    end: float
    turns: float | None
    samples: slice

    @classmethod
    def of(cls, record: Record, settle: float | None) -> "Window | None":
        """None for a run that ended before it; settle None: the first turn is left out where there is a second."""
        time, turn = record.time, record.turn
        if time.size < 2:
            return None
        length, unit = float(time[-1]), turn or 1.0
        done = length / unit * (1.0 + 1e-9)
        if settle is None:
            settle = 1.0 if turn and done >= 2.0 else 0.0
        begin = settle * unit
        end = begin + math.floor(done - settle) * unit if turn and done - settle >= 1.0 else length
        if begin >= length:
            return None
        first = int(np.searchsorted(time, begin * (1.0 - 1e-12)))
        last = int(np.searchsorted(time, min(end, length) * (1.0 + 1e-12), side="right"))
        if last - first < 2:
            return None
        return cls(begin, min(end, length), (end - begin) / turn if turn else None, slice(first, last))

    @property
    def length(self) -> float:
        return self.end - self.begin

    def per(self) -> tuple[float, str, str]:
        """What rates are taken per: its count in the window, and how names and units say it."""
        return (self.turns, "per_turn", "a turn") if self.turns else (self.length, "per_second", "a second")


Found = Iterator[tuple[str, float, str, str]]


def metrics(record: Record, settle: float | None = None, ideal: dict | None = None) -> dict[str, Metric]:
    """All metrics of a run by name; empty for one that ended before its window.

    ideal: position and acceleration of the sliding bodies with ideal joints at the run's samples, by body, along
    their guides (see ideal.py).
    """
    window = Window.of(record, settle)
    if window is None:
        return {}
    parts = (sliders, drives, joints, contacts, dissipation, periodicity)
    found = {n: Metric(v, u, t) for part in parts for n, v, u, t in part(record, window)}
    if ideal is not None:
        found |= {n: Metric(v, u, t) for n, v, u, t in deviation(record, window, ideal)}
    return found


def guides(scene: dict) -> dict[str, tuple[float, float]]:
    """Direction of the guide of each body that slides on the ground."""
    found = {}
    for joint in scene["joints"]:
        bodies = joint["a"]["body"], joint["b"]["body"]
        if joint["type"] == "Prismatic" and bodies[0] == "ground":
            found[bodies[1]] = tuple(joint["axis"])
    return found


def along(record: Record, body: str, names: tuple[str, str], direction: tuple[float, float]) -> np.ndarray:
    x, y = (record.values(f"bodies/{body}/{n}") for n in names)
    return x * direction[0] + y * direction[1]


def sliders(record: Record, window: Window) -> Found:
    for body, direction in guides(record.scene).items():
        a = along(record, body, ("ax", "ay"), direction)[window.samples]
        yield f"{body}_acceleration_min", a.min(), "m/s2", f"smallest acceleration of {body} along its guide"
        yield f"{body}_acceleration_max", a.max(), "m/s2", f"largest acceleration of {body} along its guide"


def drives(record: Record, window: Window) -> Found:
    for drive in record.names("drives"):
        for quantity, units in (("torque", "N m"), ("force", "N")):
            if f"drives/{drive}/{quantity}" not in record:
                continue
            v = record.values(f"drives/{drive}/{quantity}")[window.samples]
            name, what = f"drive_{drive}_{quantity}", f"{quantity} of drive {drive}"
            yield f"{name}_min", v.min(), units, f"smallest {what}"
            yield f"{name}_max", v.max(), units, f"largest {what}"
            yield f"{name}_rms", _rms(v), units, f"root mean square {what}"


def _rms(values: np.ndarray) -> float:
    return math.sqrt((values * values).mean())


def joints(record: Record, window: Window) -> Found:
    clearances, events, inside = record.clearances, record.events, _inside(record, window)
    for joint in record.names("joints"):
        x, y = (record.values(f"joints/{joint}/force_{axis}")[window.samples] for axis in "xy")
        squared = x * x + y * y
        peak = math.sqrt(squared.max())
        if len(events["joint"]):
            peak = max(peak, events["peak_force"][inside & (events["joint"] == joint)].max(initial=0.0))
        yield f"joint_{joint}_force_max", peak, "N", f"largest force in joint {joint}"
        yield f"joint_{joint}_force_rms", math.sqrt(squared.mean()), "N", f"root mean square force in joint {joint}"
        if joint in clearances:
            yield from _gap(record, window, joint, clearances[joint], events, inside)


def _gap(record: Record, window: Window, joint: str, clearance: float, events: dict, inside: np.ndarray) -> Found:
    gap = float(record.values(f"joints/{joint}/gap")[window.samples].min())
    if len(events["joint"]):
        gap = min(gap, -events["peak_penetration"][inside & (events["joint"] == joint)].max(initial=-math.inf))
    yield f"joint_{joint}_gap_min", gap, "m", f"smallest gap of joint {joint}, negative in contact"
    ratio = 1.0 - gap / clearance
    yield f"joint_{joint}_eccentricity_ratio_max", ratio, "1", f"largest eccentricity over clearance of joint {joint}"
    if f"joints/{joint}/film_thickness_ratio" in record:
        least = record.values(f"joints/{joint}/film_thickness_ratio")[window.samples].min()
        yield f"joint_{joint}_film_thickness_ratio_min", least, "1", f"smallest gap over roughness of joint {joint}"


def _inside(record: Record, window: Window) -> np.ndarray:
    """Contacts that begin in the window."""
    at = record.events["time"]
    return (at >= window.begin) & (at < window.end)


def contacts(record: Record, window: Window) -> Found:
    """Time in contact and impacts; joints with a film have no impacts, their contact is read off the samples."""
    events, inside = record.events, _inside(record, window)
    count, rate, text = window.per()
    for joint in (j for j in record.scene["joints"] if j["type"] == "ClearanceRevolute" and j["contact"]):
        name, label = j_name(joint), f"of joint {joint['name']}"
        if joint["film"]:
            touching = record.values(f"joints/{joint['name']}/contact_force")[window.samples] > 0.0
            yield f"{name}_contact_fraction", touching.mean(), "1", f"share of the time in contact {label}"
            continue
        own = events["joint"] == joint["name"]
        begin, end = events["time"], events["time"] + events["duration"]
        touching = np.clip(np.minimum(end, window.end) - np.maximum(begin, window.begin), 0.0, None)[own].sum()
        yield f"{name}_contact_fraction", touching / window.length, "1", f"share of the time in contact {label}"
        yield f"{name}_impacts_{rate}", (own & inside).sum() / count, "1", f"contacts begun {text} {label}"
        fastest = events["impact_speed"][own & inside].max(initial=0.0)
        yield f"{name}_impact_speed_max", fastest, "m/s", f"largest impact speed {label}"


def j_name(joint: dict) -> str:
    return f"joint_{joint['name']}"


def dissipation(record: Record, window: Window) -> Found:
    count, rate, text = window.per()
    name, units = ("dissipated_per_turn", "J") if rate == "per_turn" else ("dissipated_power", "W")
    parts = {f"joint_{j}_{name}": (f"joints/{j}/dissipated", f"by joint {j}") for j in record.names("joints")}
    for metric, (path, who) in (parts | {name: ("energy/dissipated", "in all")}).items():
        if path in record:
            begin, end = np.interp((window.begin, window.end), record.time, record.values(path))
            yield metric, (end - begin) / count, units, f"energy taken out {text} {who}"


def periodicity(record: Record, window: Window) -> Found:
    """After how many turns the journals come back."""
    joints = record.clearances
    if not window.turns or window.turns < FEWEST - 1 or not joints:
        return
    at = window.end - record.turn * np.arange(int(round(window.turns)), -1, -1)
    paths = [(f"joints/{j}/eccentricity_{axis}", c) for j, c in joints.items() for axis in "xy"]
    states = np.stack([np.interp(at, record.time, record.values(p)) / c for p, c in paths], axis=1)
    count, best = len(states), (math.inf, math.inf)
    for turns in range(1, max(count // 3, 1) + 1):
        error = float(np.abs(states[turns:] - states[:-turns]).max())
        if error < PERIODIC:
            best = (float(turns), error)
            break
        best = min(best, (math.inf, error), key=lambda b: b[1])
    yield "period", best[0], "turns", "turns after which all journals are back within 1 % of their clearance"
    yield "period_error", best[1], "1", "largest distance over the clearance after a period"


def deviation(record: Record, window: Window, ideal: dict) -> Found:
    for body, direction in guides(record.scene).items():
        if body not in ideal:
            continue
        position, acceleration = (
            along(record, body, names, direction) - values[: record.time.size]
            for names, values in zip((("x", "y"), ("ax", "ay")), ideal[body], strict=True)
        )
        far = np.abs(position[window.samples]).max()
        yield f"{body}_position_deviation_max", far, "m", f"largest distance of {body} from where ideal joints have it"
        rms = _rms(acceleration[window.samples])
        yield (
            f"{body}_acceleration_deviation_rms",
            rms,
            "m/s2",
            f"root mean square of what {body} accelerates beyond it",
        )


def own(function: Callable, record: Record) -> dict[str, Metric]:
    """Metrics of a user's function. Raises ValueError for one that gives something else than numbers by name."""
    given = function(record)
    name = getattr(function, "__name__", "metric")
    if not isinstance(given, dict):
        raise ValueError(f"metric {name}: expected a dictionary of numbers, got {given!r}")
    found = {}
    for key, entry in given.items():
        value, units, text = entry if isinstance(entry, tuple) and len(entry) == 3 else (entry, "?", str(key))
        try:
            found[str(key)] = Metric(float(value), str(units), str(text))
        except (TypeError, ValueError):
            raise ValueError(f"metric {name}: {key} is no number: {value!r}") from None
    return found
