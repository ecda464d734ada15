"""Summary metrics of a run: what a map over speed and clearance shows.

Each is computed over the window of a run: full turns after the first `settle` ones. Turns are
counted by the angle of a finite drive. A run of less than a turn, or without a drive that turns,
counts as it is; `settle` is in seconds then. Extremes are located to the tolerance of the run, in
its turns that lie fully in the window. A run without turns has hundredths instead, one of more than
a hundred turns stretches of several. Outside of these the samples count. Mean squares of forces and
efforts are integrals over the steps of the run, other means are over time of samples. Impacts count
where they begin; names are made of body, drive and joint names:

  <body>_acceleration_min, _max   of bodies that slide on the ground, along their guide [m/s2]
  drive_<drive>_torque_min, _max, _rms (or force)                                       [N m] ([N])
  joint_<joint>_force_max         largest force                                          [N]
  joint_<joint>_force_rms         root mean square                                       [N]
  joint_<joint>_gap_min           smallest gap, negative where surfaces overlap          [m]
  joint_<joint>_eccentricity_ratio_max   1 - gap_min / clearance                         [-]
  joint_<joint>_film_thickness_ratio_min gap_min over composite roughness                [-]
  joint_<joint>_elastic_film_min  thinnest film between elastic surfaces                 [m]
  joint_<joint>_contact_fraction  share of the time in contact, without asperities alone [-]
  joint_<joint>_impacts_per_turn  contacts that begin with a touch                       [-]
  joint_<joint>_impact_speed_max  of these contacts, 0 for none                          [m/s]
  joint_<joint>_wear_bearing_per_turn, _wear_journal_per_turn   volume worn off in a turn  [m3]
  joint_<joint>_load_over_force   normal load over force of a worn outline, means          [-]
  joint_<slide>_corner_1_impacts_per_turn, ...   of each corner of a block in its guide  [-]
  joint_<slide>_mode_free, _one_corner, _two_on_one_side, _two_across, ...   shares of the time [-]
  joint_<slide>_jam_ratio         mu d / a in contact across, d: arm of the push along the
                                  guide; the slide jams at 1                             [-]
  joint_<joint>_dissipated_per_turn   energy that the joint takes out in a turn          [J]
  dissipated_per_turn             of all joints and dampers                              [J]
  <body>_position_deviation_max   from the mechanism with ideal joints                   [m]
  <body>_acceleration_deviation_rms   from the mechanism with ideal joints               [m/s2]
  period                          smallest number of turns after which the journals return
                                  within 1 % of their clearance at every sample; up to a third
                                  of the turns seen; inf: none                           [turns]
  period_error                    largest distance over the clearance after that many turns
                                  (without a period: the least)                          [-]
  settling_ratio                  change of the journals from turn to turn, of the last turn
                                  seen over the first; a motion without a period is still
                                  settling below SETTLING                                [-]

Without a turn, rates are per second: impacts_per_second [1/s], dissipated_power [W]. A run that
ended early is seen as the one it should have become: the first turn does not count, nor does a part
of one. A user's own function `name(run) -> value`, `{"metric": value}` or `{"metric": (value,
units, text)}` adds to them; `run` reads like a result.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from clearance.results.extremes import BOTH, along, guides
from clearance.results.record import Extreme, Record, cubic
from clearance.values import checks
from clearance.values.spelling import ByName
from clearance.values.spots import CORNERS, MODES

PERIODIC = 0.01  # distance over the clearance below which a journal counts as back
RECURRING = 3  # least number of turns that show a period
SETTLING = 0.5  # change from turn to turn, last over first, below which a motion settles
SURFACES = ("bearing", "journal")  # that wear
EFFORTS = {"torque": "N m", "force": "N"}
ROUNDING = 1e-9  # share of a run that rounding may take off a turn
COARSE = 20  # samples a turn below which nothing is known between them
ON_SAMPLE = 1e-6  # share of a step within which a turn counts as an integer number of samples


@dataclass(frozen=True)
class Metric:
    """One number that sums up a run; time [s]: of an extreme."""

    value: float
    units: str
    text: str
    time: float | None = None


Metrics = dict[str, Metric]  # by name


def described(values: Mapping[str, Metric]) -> dict[str, tuple[str, str]]:
    """Units and text of each metric."""
    return {name: (metric.units, metric.text) for name, metric in values.items()}


@dataclass(frozen=True)
class Window:
    """The part of a run that its metrics are about: from begin to end [s], and the samples in it.

    turns: full ones, but for a window of less than one; None where no drive turns. weights: share
        of the window that each sample stands for, (samples,).
    """

    begin: float
    end: float
    turns: float | None
    samples: slice
    weights: np.ndarray

    @classmethod
    def of(cls, record: Record, settle: float | None) -> "Window | None":
        """None for a run that ended before it; settle None: the first turn is left out where there
        is a second.

        Raises ValueError for a settle that is negative or not finite.
        """
        if settle is not None:
            settle = checks.non_negative("settle", settle)
        if record.time.size < 2:
            return None
        length = float(record.time[-1])
        if not record.turn:
            begin = settle or 0.0
            return cls.between(record, begin, length, None) if begin < length else None
        done = float(record.turns_at(length)) * (1.0 + ROUNDING)
        if settle is None:
            settle = 1.0 if done >= 2.0 or not record.complete else 0.0
        begin, full = float(record.time_at(settle)), math.floor(done - settle)
        if begin >= length or (full < 1 and not record.complete):
            return None
        if full < 1:
            part = float(record.turns_at(length)) - settle
            return cls.between(record, begin, length, part)
        end = min(float(record.time_at(settle + full)), length)
        return cls.between(record, begin, end, float(full))

    @classmethod
    def between(
        cls, record: Record, begin: float, end: float, turns: float | None
    ) -> "Window | None":
        """The part between two times; None where it has less than two samples."""
        time = record.time
        samples = slice(
            np.searchsorted(time, begin * (1.0 - 1e-12)), np.searchsorted(time, end * (1.0 + 1e-12))
        )
        inside = time[samples]
        if inside.size < 2:
            return None
        if record.uneven:
            weights = integrating(inside, begin, end)
        else:
            edges = np.concatenate([[begin], 0.5 * (inside[1:] + inside[:-1]), [end]])
            weights = np.diff(edges)
        return cls(begin, end, turns, samples, weights / (end - begin))

    def mean(self, values: np.ndarray) -> float:
        """Mean over time of values at the window's samples."""
        return float((self.weights * values).sum())

    def rms(self, values: np.ndarray) -> float:
        return math.sqrt(self.mean(values * values))

    def mean_square(self, record: Record, path: str) -> float:
        """Mean over time of the square of a channel, or of a vector: by the steps of the run, or by
        its samples where it has no integrals.
        """
        summed = record.mean_square(path, self.begin, self.end)
        return self.mean(record.sizes(path)[self.samples] ** 2) if summed is None else summed

    def bounds(self, record: Record) -> tuple[float, float]:
        """Begin and end [s], the end beyond that of the run where the window reaches it."""
        return self.begin, math.inf if self.end >= record.time[-1] * (1.0 - ROUNDING) else self.end

    def per(self) -> tuple[float, str, str]:
        """Unit of rates: its count in the window, and its form in names and texts."""
        if self.turns is None:
            return self.end - self.begin, "per_second", "in a second"
        return self.turns, "per_turn", "in a turn"


def integrating(places: np.ndarray, begin: float, end: float) -> np.ndarray:
    """Weights of values at ascending places whose sum is their integral from begin to end.

    Straight lines stand between them; the first and the last reach to begin and end.
    """
    width, weights = np.diff(places), np.zeros(len(places))
    edges = np.concatenate([[begin], places[1:-1], [end]])
    middle, share = 0.5 * (edges[1:] + edges[:-1]), np.diff(edges) / width
    weights[:-1] += share * (places[1:] - middle)
    weights[1:] += share * (middle - places[:-1])
    return weights


Numbers = Iterator[tuple]  # name, value, units, text, and of extremes their time [s]


def named(*parts: Numbers) -> Metrics:
    """Metrics of a run by name."""
    return {name: Metric(float(value), *about) for part in parts for name, value, *about in part}


def metrics(record: Record, settle: float | None = None, ideal: dict | None = None) -> Metrics:
    """All metrics of a run by name, or by path; empty for one that ended before its window.

    settle: turns left out at the start (seconds, where no drive turns), default one where there is
        a second.
    ideal: position and acceleration of the sliding bodies with ideal joints at the run's samples,
        by body, along their guides (see run/ideal_motion.py).
    Raises ValueError for a settle that is negative or not finite.
    """
    window = Window.of(record, settle)
    if window is None:
        return {}
    parts = *reduced(OfRecord(record, window, ideal or {})), periodicity(record, window)
    return ByName(named(*parts))


def startup(record: Record, settle: float | None = None) -> Metrics:
    """Extremes of the start-up, which the window of `metrics` leaves out, under the same names;
    none without one.
    """
    window = Window.of(record, settle)
    if window is None or window.begin == 0.0:
        return {}
    before = Window.between(
        record, 0.0, window.begin, window.turns and float(record.turns_at(window.begin))
    )
    if before is None:
        return {}
    *parts, _ = reduced(OfRecord(record, before, {}))
    return {name: metric for name, metric in named(*parts).items() if metric.time is not None}


class Reductions(ABC):
    """Numbers of the window of one run, or of many, that metrics are made of.

    Of many runs a number is an array over them. record: of the run, or of one of them; rates: as
    `Window.per`.
    """

    def __init__(self, record: Record, rates: tuple[float, str, str]):
        self.record, self.scene, self.rates = record, record.scene, rates

    def names(self, group: str) -> Sequence[str]:
        """As `Record.names`."""
        return self.record.names(group)

    def __contains__(self, path: str) -> bool:
        return path in self.record

    def described(self, joint: str) -> dict:
        """As `Record.described`; of many runs some numbers are arrays."""
        return self.record.described(joint)

    @abstractmethod
    def extreme(self, name: str) -> Extreme:
        """As `Record.extreme`, in the window."""

    @abstractmethod
    def mean_square(self, path: str):
        """Mean over time of the square of a channel, or of a vector."""

    @abstractmethod
    def increase(self, path: str):
        """Growth of a sum from the window's begin to its end."""

    @abstractmethod
    def deviation(self, body: str, direction: tuple[float, float]) -> tuple | None:
        """Largest distance of a body [m], and mean square distance of its acceleration
        [(m/s2)^2], from those with ideal joints, along its guide; None where these are not known.
        """

    @abstractmethod
    def contact(self, joint: dict) -> Numbers:
        """Metrics of a joint in contact."""


class OfRecord(Reductions):
    """Numbers of the window of a record; ideal: see `metrics`."""

    def __init__(self, record: Record, window: Window, ideal: dict):
        super().__init__(record, window.per())
        self.window, self.ideal = window, ideal

    def extreme(self, name: str) -> Extreme:
        return self.record.extreme(name, *self.window.bounds(self.record))

    def mean_square(self, path: str) -> float:
        return self.window.mean_square(self.record, path)

    def increase(self, path: str) -> float:
        ends = np.array([self.window.begin, self.window.end])
        if (growth := self.record.summed(f"{path}_growth", ends)) is not None:
            return growth.item()
        begin, end = cubic(self.record.time, self.record.values(path), ends)
        return end - begin

    def deviation(self, body: str, direction: tuple[float, float]) -> tuple | None:
        x, y, ax, ay = (
            self.record.values(f"bodies/{body}/{n}")[self.window.samples]
            for n in ("x", "y", "ax", "ay")
        )
        if body not in self.ideal:
            return None
        (dx, dy), (position, rate) = direction, (v[self.window.samples] for v in self.ideal[body])
        beyond = ax * dx + ay * dy - rate
        return np.abs(x * dx + y * dy - position).max(), self.window.mean(beyond * beyond)

    def contact(self, joint: dict) -> Numbers:
        yield from touching(self.record, self.window, joint)
        if joint["contact"]:
            yield from _wear(self, joint["name"])


def reduced(seen: Reductions) -> tuple[Numbers, ...]:
    """Metrics made of reductions; the last are about energy."""
    return sliders(seen), drives(seen), joints(seen), dissipation(seen)


def sliders(seen: Reductions) -> Numbers:
    """Motion of bodies on guides, and its distance from that with ideal joints."""
    for body, direction in guides(seen.scene).items():
        axis, share = along(direction)
        ends = BOTH if share > 0.0 else BOTH[::-1]
        for which, size, end in zip(BOTH, ("smallest", "largest"), ends, strict=True):
            peak = seen.extreme(f"bodies/{body}/a{axis}_{end}")
            text = f"{size} acceleration of {body} along its guide"
            yield f"{body}_acceleration_{which}", peak.value / share, "m/s2", text, peak.time
        if (deviation := seen.deviation(body, direction)) is not None:
            far, beyond = deviation
            text = f"largest distance of {body} from where ideal joints have it"
            yield f"{body}_position_deviation_max", far, "m", text
            text = f"root mean square of what {body} accelerates beyond ideal joints"
            yield f"{body}_acceleration_deviation_rms", np.sqrt(beyond), "m/s2", text


def efforts(seen: Reductions) -> Iterator[tuple[str, str, str, str]]:
    """Efforts of drives: path, name, units and words."""
    for drive in seen.names("drives"):
        for quantity, units in EFFORTS.items():
            if (path := f"drives/{drive}/{quantity}") in seen:
                yield path, f"drive_{drive}_{quantity}", units, f"{quantity} of drive {drive}"


def drives(seen: Reductions) -> Numbers:
    """Efforts of drives."""
    for path, name, units, text in efforts(seen):
        for end, size in zip(BOTH, ("smallest", "largest"), strict=True):
            peak = seen.extreme(f"{path}_{end}")
            yield f"{name}_{end}", peak.value, units, f"{size} {text}", peak.time
        rms = np.sqrt(seen.mean_square(path))
        yield f"{name}_rms", rms, units, f"root mean square {text}"


def joints(seen: Reductions) -> Numbers:
    """Forces in all joints; how near, how hard and how often surfaces come in clearance joints."""
    for name in seen.names("joints"):
        if (path := f"joints/{name}/force") + "_x" not in seen:
            continue
        peak, text = seen.extreme(f"{path}_max"), f"largest force in joint {name}"
        yield f"joint_{name}_force_max", peak.value, "N", text, peak.time
        rms, text = np.sqrt(seen.mean_square(path)), f"root mean square force in joint {name}"
        yield f"joint_{name}_force_rms", rms, "N", text
        joint = seen.described(name)
        if joint.get("clearance") is not None:
            yield from _gap(seen, joint)
            yield from seen.contact(joint)


def _gap(seen: Reductions, joint: dict) -> Numbers:
    name, clearance, roughness = joint["name"], joint["clearance"], joint.get("roughness")
    smallest = seen.extreme(f"joints/{name}/gap_min")
    gap, time = smallest.value, smallest.time
    text = f"smallest gap of joint {name}, negative in contact"
    yield f"joint_{name}_gap_min", gap, "m", text, time
    if "overlap" not in joint:
        ratio, text = 1.0 - gap / clearance, f"largest eccentricity over clearance of joint {name}"
        yield f"joint_{name}_eccentricity_ratio_max", ratio, "1", text, time
    if roughness is not None:
        least, text = gap / roughness, f"smallest gap over roughness of joint {name}"
        yield f"joint_{name}_film_thickness_ratio_min", least, "1", text, time
    paths = (f"joints/{name}/{film}" for film in ("elastic_film", "film_least"))
    for path in (path for path in paths if path in seen):
        thinnest, text = seen.extreme(f"{path}_min"), f"thinnest film of joint {name}, elastic"
        yield f"joint_{name}_elastic_film_min", thinnest.value, "m", text, thinnest.time


def contact_fraction(name: str, share) -> tuple:
    """The share of the time in contact of a joint, as a metric."""
    text = f"share of the time in contact of joint {name}"
    return f"joint_{name}_contact_fraction", share, "1", text


def touching(record: Record, window: Window, joint: dict) -> Numbers:
    """Metrics of the contacts of a joint."""
    events, name = record.events, joint["name"]
    mine = np.array([spot.partition("/")[0] == name for spot in events["joint"]], bool)
    rows = {column: values[mine] for column, values in events.items()}
    rows["begun"] = (rows["time"] >= window.begin) & (rows["time"] < window.end)
    if joint["contact"]:
        yield from _contact(record, window, joint, rows)
    if f"joints/{name}/mode" in record:
        yield from _slide(record, window, joint, rows)


def _contact(record: Record, window: Window, joint: dict, rows: dict) -> Numbers:
    """Time in contact and impacts; contact that sets in gradually is read off the samples.

    rows: columns of the joint's rows of the events; `begun` states which begin in the window.
    """
    name, begin = joint["name"], rows["time"]
    if not begin.size and not record.begins_with_touch(name):
        path = f"joints/{name}/contact_force"
        part = record.share_above_zero(path, window.begin, window.end)
        if part is None:
            part = window.mean(_carried(record, joint)[window.samples] > 0.0)
        yield contact_fraction(name, part)
        return
    end = np.minimum(begin + rows["duration"], window.end)
    order = np.argsort(begin, kind="stable")  # contacts of several corners overlap
    begin, end = begin[order], end[order]
    before = np.maximum.accumulate(np.concatenate([[window.begin], end[:-1]])) if end.size else end
    touching = np.maximum(end - np.maximum(begin, before), 0.0).sum()
    yield contact_fraction(name, touching / (window.end - window.begin))
    count, rate, when = window.per()
    number, units = rows["begun"].sum() / count, "1" if rate == "per_turn" else "1/s"
    yield f"joint_{name}_impacts_{rate}", number, units, f"contacts begun {when} of joint {name}"
    fastest = rows["impact_speed"][rows["begun"]].max(initial=0.0)
    yield f"joint_{name}_impact_speed_max", fastest, "m/s", f"largest impact speed of joint {name}"


def _wear(seen: OfRecord, name: str) -> Numbers:
    """Volumes worn off, and what a law of wear by the force alone leaves out."""
    count, rate, when = seen.rates
    for surface in SURFACES:
        path = f"joints/{name}/wear_volume_{surface}"
        if path in seen:
            text = f"volume worn off the {surface} of joint {name} {when}"
            units = "m3" if rate == "per_turn" else "m3/s"
            yield f"joint_{name}_wear_{surface}_{rate}", seen.increase(path) / count, units, text
    if f"joints/{name}/normal_load" in seen and f"joints/{name}/asperity_force" not in seen:
        load, force = (
            seen.window.mean(seen.record.values(f"joints/{name}/{column}")[seen.window.samples])
            for column in ("normal_load", "contact_force")
        )
        text = f"mean normal load over mean contact force of joint {name}"
        yield f"joint_{name}_load_over_force", load / force if force > 0.0 else 1.0, "1", text


def _slide(record: Record, window: Window, joint: dict, contacts: dict) -> Numbers:
    """Contacts of each corner of a block in its guide, shares of time in each mode, nearness to a
    jam.
    """
    name, (count, rate, when) = joint["name"], window.per()
    corners = np.array([spot.partition("/")[2] for spot in contacts["joint"]])
    for corner, _, _ in CORNERS:
        number = (contacts["begun"] & (corners == corner)).sum() / count
        text = f"contacts begun {when} of corner {corner} of joint {name}"
        yield (
            f"joint_{name}_corner_{corner}_impacts_{rate}",
            number,
            "1" if rate == "per_turn" else "1/s",
            text,
        )
    edges, modes = modes_of(record, name, window.begin, window.end)
    spent = np.bincount(modes, np.diff(edges), len(MODES)) / (window.end - window.begin)
    for mode, share in zip(MODES, spent, strict=True):
        yield (
            f"joint_{name}_mode_{mode.replace(' ', '_')}",
            share,
            "1",
            f"share of the time of joint {name}: {mode}",
        )
    yield from _jam(record, window, joint)


def modes_of(record: Record, joint: str, begin: float, end: float) -> tuple[np.ndarray, np.ndarray]:
    """Pieces between two times [s] in which a block touches with the same corners.

    Their edges (pieces + 1,) [s] and modes (pieces,), places in MODES; from its contacts, or from
    the samples where contact sets in gradually.
    """
    if not record.begins_with_touch(joint):
        time, mode = record.time, record.values(f"joints/{joint}/mode")
        middles = 0.5 * (time[1:] + time[:-1])
        edges = np.unique(np.clip(np.concatenate([[begin, end], middles]), begin, end))
        nearest = np.searchsorted(middles, 0.5 * (edges[1:] + edges[:-1]))
        return edges, mode[nearest].astype(int)
    spots, start = record.events["joint"], record.events["time"]
    over = start + record.events["duration"]
    edges = np.unique(np.clip(np.concatenate([[begin, end], start, over]), begin, end))
    middle, count, walls = 0.5 * (edges[1:] + edges[:-1]), np.zeros(len(edges) - 1, int), {}
    for corner, _, side in CORNERS:
        mine = spots == f"{joint}/{corner}"
        starts, ends = np.sort(start[mine]), np.sort(over[mine])
        touching = np.searchsorted(starts, middle) - np.searchsorted(ends, middle)
        count, walls[side] = count + touching, walls.get(side, 0) + touching
    return edges, count + ((walls[-1.0] > 0) & (walls[1.0] > 0))


def jam_channels(joint: str) -> list[str]:
    """Channels of a slide that its jam ratio is computed from."""
    channels = [f"joints/{joint}/{n}" for n in ("friction", "force_x", "force_y", "mode")]
    return channels + [f"joints/{joint}/contact_force_{corner}" for corner, _, _ in CORNERS]


def _jam(record: Record, window: Window, joint: dict) -> Numbers:
    """mu d / a of a block that touches across, d: arm of the push P along the guide, which its
    normal forces N balance.

    P d = 2 a N for two corners, so that mu d / a is their friction 2 mu N over the push. mu: the
    largest ratio of friction to normal force in the window; N and P: means over the samples with
    contact across. The push is all that acts on the body but this joint.
    """
    body, channels = joint["b"]["body"], jam_channels(joint["name"])
    if joint["a"]["body"] != "ground" or not all(path in record for path in channels):
        return
    friction, fx, fy, mode, *normal = (record.values(path)[window.samples] for path in channels)
    normal, across = np.sum(normal, axis=0), mode >= MODES.index("two across")
    if not across.any():
        return
    dx, dy = joint["axis"]
    ax, ay = (record.values(f"bodies/{body}/{n}")[window.samples] for n in ("ax", "ay"))
    mass = next(b["mass"] for b in record.scene["bodies"] if b["name"] == body)
    push = np.abs(mass * (dx * ax + dy * ay) - (dx * fx + dy * fy))
    touching = normal > 0.0
    mu = float((np.abs(friction[touching]) / normal[touching]).max(initial=0.0))
    ratio = mu * normal[across].sum() / max(push[across].sum(), 1e-300)
    text = f"mu d / a of joint {joint['name']} in contact across; it jams at 1"
    yield f"joint_{joint['name']}_jam_ratio", ratio, "1", text


def _carried(record: Record, joint: dict) -> np.ndarray:
    """Largest contact force of a hinge or of the corners of a slide [N] at each sample."""
    path = f"joints/{joint['name']}/contact_force"
    ends = (
        [f"_{corner}" for corner, _, _ in CORNERS]
        if joint["type"] == "ClearancePrismatic"
        else [""]
    )
    return np.max([record.values(path + end) for end in ends], axis=0)


def dissipation(seen: Reductions) -> Numbers:
    """Energy that joints take out, and all parts together."""
    count, rate, when = seen.rates
    name, units = ("dissipated_per_turn", "J") if rate == "per_turn" else ("dissipated_power", "W")
    parts = {
        f"joint_{j}_{name}": (f"joints/{j}/dissipated", f"by joint {j}")
        for j in seen.names("joints")
    }
    for metric, (path, who) in (parts | {name: ("energy/dissipated", "in all")}).items():
        if path in seen:
            yield metric, seen.increase(path) / count, units, f"energy taken out {when} {who}"


def recurring(per_turn: float | np.ndarray) -> bool | np.ndarray:
    """True for samples of which so many a turn show a period."""
    return (per_turn >= COARSE) | (np.abs(per_turn - np.round(per_turn)) <= ON_SAMPLE)


def periodicity(record: Record, window: Window) -> Numbers:
    """After how many turns the journals come back.

    Impacts recur only where samples do: a turn should be an integer number of samples. Else values
    between samples are those of a cubic, and too few of them mean nothing.
    """
    time, moving = record.time, offsets(record)
    if not record.clearances or window.turns is None or window.turns < RECURRING:
        return
    per_turn = record.turn * (time.size - 1) / float(time[-1])
    if not recurring(per_turn):
        return
    x, y = (
        np.stack([_evenly(record, path, window) / size for path, size in part])
        for part in (moving[0::2], moving[1::2])
    )
    states = x + 1j * y
    changes = _sizes(_change(states, per_turn)).max(axis=0)
    period, least = math.inf, math.inf
    for turns in range(1, (int(window.turns) + 1) // 3 + 1):
        later = changes if turns == 1 else _sizes(_change(states, turns * per_turn))
        error = float(later.max())
        if error < PERIODIC:
            period, least = float(turns), error
            break
        least = min(least, error)
    yield (
        "period",
        period,
        "turns",
        "turns after which all journals are back within 1 % of their clearance",
    )
    yield "period_error", least, "1", "largest distance over the clearance after a period"
    turn = round(per_turn)
    first, last = float(changes[:turn].max()), float(changes[-turn:].max())
    yield (
        "settling_ratio",
        last / first if first > 0.0 else 0.0,
        "1",
        "change from turn to turn, last over first",
    )


def offsets(record: Record) -> list[tuple[str, float]]:
    """Both channels of each body's place in its clearance, with their natural sizes."""
    pairs: list[tuple[str, float]] = []
    for name, clearance in record.clearances.items():
        path, joint = f"joints/{name}", record.described(name)
        if joint["type"] == "ClearancePrismatic":
            tilt = 2.0 * clearance / joint["overlap"]
            pairs += [(f"{path}/offset", clearance), (f"{path}/tilt", tilt)]
        if joint["type"] == "ClearanceRevolute":
            pairs += [(f"{path}/eccentricity_{axis}", clearance) for axis in "xy"]
    return pairs


def _evenly(record: Record, path: str, window: Window) -> np.ndarray:
    """Samples of a channel in a window, evenly over the turns of the drive, which may not turn
    evenly itself.
    """
    values, time = record.values(path), record.time
    if not record.uneven:
        return values[window.samples]

    every = record.turn * (time.size - 1) / float(time[-1])
    turns = (
        record.turns_at(window.begin)
        + np.arange(math.floor(window.turns * every * (1.0 + ROUNDING)) + 1) / every
    )
    return cubic(time, values, record.time_at(turns))


def _sizes(numbers: np.ndarray) -> np.ndarray:
    """Sizes of complex numbers, in a third of the time of numpy's, which fears overflow."""
    return np.sqrt(numbers.real**2 + numbers.imag**2)


def _change(states: np.ndarray, shift: float) -> np.ndarray:
    """By how much states (joints, samples) differ `shift` samples later; between samples by a cubic
    through four.
    """
    turns = math.floor(shift + ON_SAMPLE)
    f = shift - turns
    if f < ON_SAMPLE:
        return states[:, turns:] - states[:, : states.shape[1] - turns]
    taps = (
        -f * (f - 1.0) * (f - 2.0) / 6.0,
        (f + 1.0) * (f - 1.0) * (f - 2.0) / 2.0,
        -(f + 1.0) * f * (f - 2.0) / 2.0,
        (f + 1.0) * f * (f - 1.0) / 6.0,
    )
    count = states.shape[1] - turns - 2
    later = sum(
        tap * states[:, turns - 1 + i : turns - 1 + i + count] for i, tap in enumerate(taps)
    )
    return later - states[:, :count]


def of_user(function: Callable, record: Record) -> Metrics:
    """Metrics of a user's function.

    Raises ValueError for one that gives neither a number nor numbers by name.
    """
    returned = function(record)
    name = getattr(function, "__name__", "metric")
    if hasattr(returned, "__float__") or isinstance(returned, tuple):
        returned = {name: returned}
    if not isinstance(returned, dict):
        raise ValueError(
            f"metric {name}: expected a number or a dictionary of numbers, got {returned!r}"
        )
    values = {}
    for key, entry in returned.items():
        checks.identifier(f"metric {name}: its name", key)
        value, units, text = (
            entry if isinstance(entry, tuple) and len(entry) == 3 else (entry, "?", key)
        )
        try:
            values[key] = Metric(float(value), str(units), str(text))
        except (TypeError, ValueError):
            raise ValueError(f"metric {name}: {key} is no number: {value!r}") from None
    return values
