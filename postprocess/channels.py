"""Channels of a result by name: their values, units and label, also between the samples.

A channel is named by its path ("bodies/slider/ax") or shortly ("slider.ax", "energy.kinetic"). The
common part of a recorded pair means its magnitude: "B.force" of force_x and force_y, "slider.v" of
vx and vy. "C.epsilon", "C.epsilon_x" and "C.epsilon_y" are the eccentricity over the clearance of
joint C.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from fnmatch import fnmatchcase

import numpy as np

from clearance.results.record import Record, cubic, speed_of

KINDS = ("bodies", "joints", "springs", "drives", "nodes")
#: groups of channels that belong to the entire mechanism
WHOLE = ("energy", "friction")
WORDS = {
    "x": "position x",
    "y": "position y",
    "theta": "angle",
    "vx": "velocity x",
    "vy": "velocity y",
    "v": "speed",
    "omega": "angular velocity",
    "ax": "acceleration x",
    "ay": "acceleration y",
    "a": "acceleration",
    "alpha": "angular acceleration",
    "epsilon": "eccentricity / c",
    "epsilon_x": "eccentricity x / c",
    "epsilon_y": "eccentricity y / c",
    "torque_ideal": "torque without friction",
    "force_ideal": "force without friction",
}
ENERGIES = {"input": "energy put in", "residual": "energy residual"}
#: recorded time derivatives of recorded channels
RATES = {"x": "vx", "y": "vy", "theta": "omega", "vx": "ax", "vy": "ay", "omega": "alpha"}
#: share of a step within which a time counts as that of a sample
ON_SAMPLE = 1e-6


@dataclass(frozen=True)
class Channel:
    """A recorded channel times `scale`, or the magnitude of a recorded pair."""

    path: str
    parts: tuple[str, ...]
    units: str
    label: str
    scale: float = 1.0

    def of(self, parts: list[np.ndarray]) -> np.ndarray:
        return self.scale * (np.hypot(*parts) if len(parts) == 2 else parts[0])


def channel(record: Record, path: str) -> Channel:
    """Channel of a name.

    Raises ValueError for one that the result does not have, with the names it has.
    """
    channels = [c for group, name in _places(record, path) if (c := _channel(record, group, name))]
    if len(channels) == 1:
        return channels[0]
    if channels:
        raise ValueError(
            f"channel {path!r} may be {' or '.join(c.path for c in channels)}; give the full path"
        )
    raise ValueError(
        f"{name_of(record)} has no channel {path!r}, or it was not stored; it has "
        f"{_known(record, path)}"
    )


def _places(record: Record, path: str) -> list[tuple[str, str]]:
    """Group and name that a path may mean."""
    if "/" in path:
        return [tuple(path.rsplit("/", 1))]
    owner, _, name = path.rpartition(".")
    groups = [f"{kind}/{owner}" for kind in KINDS if owner in record.names(kind)]
    return [(group, name) for group in ([owner] if owner in WHOLE else groups)]


def _channel(record: Record, group: str, name: str) -> Channel | None:
    names, scale, wanted = record.names(group), 1.0, name
    if name in ("epsilon", "epsilon_x", "epsilon_y"):
        clearance = record.clearances.get(group.removeprefix("joints/"))
        if clearance is None:
            return None
        scale, wanted = 1.0 / clearance, name.replace("epsilon", "eccentricity")
    for parts in ((wanted,), (f"{wanted}_x", f"{wanted}_y"), (f"{wanted}x", f"{wanted}y")):
        if wanted and set(parts) <= set(names):
            units = record.units(f"{group}/{parts[0]}") if wanted == name else "1"
            return Channel(
                f"{group}/{name}",
                tuple(f"{group}/{p}" for p in parts),
                units,
                _label(group, name),
                scale,
            )
    return None


def _label(group: str, name: str) -> str:
    kind, _, owner = group.partition("/")
    words = WORDS.get(name, name.replace("_", " "))
    if kind == "energy":
        return ENERGIES.get(name, f"{words} energy")
    if kind == "friction":
        return f"friction {words}"
    return f"joint {owner} {words}" if kind == "joints" else f"{owner} {words}"


def _known(record: Record, path: str) -> str:
    """The channels of the group that a path names, or of all groups."""
    groups = [group for group, _ in _places(record, path) if record.names(group)] or _groups(record)
    alike: dict[tuple, list[str]] = {}
    for group in groups:
        alike.setdefault(record.names(group), []).append(group)
    return (
        "; ".join(f"{', '.join(owners)}: {', '.join(names)}" for names, owners in alike.items())
        or "none"
    )


def _groups(record: Record) -> list[str]:
    groups = [f"{kind}/{owner}" for kind in KINDS for owner in record.names(kind)]
    return groups + [group for group in WHOLE if record.names(group)]


def expand(record: Record, names: str | Iterable[str]) -> list[str]:
    """Paths of the channels that names and patterns ("*.force", "joints/B/*") stand for, in order,
    each once.

    Magnitudes and eccentricity ratios of a joint are meant only where no recorded channel of it
    matches.
    Raises ValueError for a name or pattern without a channel.
    """
    channels = []
    for name in [names] if isinstance(names, str) else names:
        if set("*?[") & set(name):
            hits = [path for group in _groups(record) for path in _matches(record, group, name)]
            if not hits:
                raise ValueError(
                    f"no channel of {name_of(record)} matches {name!r}; it has "
                    f"{_known(record, name)}"
                )
            channels += hits
        else:
            channels.append(channel(record, name).path)
    return list(dict.fromkeys(channels))


def _matches(record: Record, group: str, pattern: str) -> list[str]:
    names = record.names(group)
    pairs = [n[:-2] for n in names if n.endswith("_x") and f"{n[:-2]}_y" in names]
    pairs += ["epsilon", "epsilon_x", "epsilon_y"] if "eccentricity" in pairs else []
    short = group.rpartition("/")[2]
    for candidates in (names, pairs):
        hits = [
            n
            for n in candidates
            if fnmatchcase(f"{group}/{n}", pattern) or fnmatchcase(f"{short}.{n}", pattern)
        ]
        if hits:
            return [f"{group}/{n}" for n in hits]
    return []


def series(record: Record, path: str) -> tuple[np.ndarray, str, str]:
    """Values (samples,), units and label of a channel.

    Raises ValueError for one that the result does not have.
    """
    values = channel(record, path)
    return values.of([record.values(p) for p in values.parts]), values.units, values.label


def at(record: Record, path: str, times: np.ndarray) -> np.ndarray:
    """Values of a channel at times [s] of the run, shape of `times`: the samples', or interpolated
    between them.

    Cubic Hermite where the rate of the channel is recorded too (positions, velocities, angles of
    bodies), else a cubic through the four nearest samples. Both are of fourth order in the sampling
    where the motion is smooth. Raises ValueError for an unknown channel and for times outside the
    run.
    """
    values, time, times = channel(record, path), record.time, np.asarray(times, float)
    if times.size and (not time.size or times.min() < time[0] or times.max() > time[-1]):
        run = f"{time[0]:.6g} s to {time[-1]:.6g} s" if time.size else "no sample"
        raise ValueError(
            f"times from {times.min():.6g} s to {times.max():.6g} s: {name_of(record)} has {run}"
        )
    if not times.size:
        return np.zeros(times.shape)
    return values.of([_between(record, part, time, times) for part in values.parts])


def interpolation(record: Record, path: str, times: np.ndarray) -> str:
    """In words, how `at` finds a channel at times [s]."""
    time = record.time
    if (
        not len(times)
        or (np.abs(times - time[_nearest(time, times)]) <= ON_SAMPLE * np.diff(time).mean()).all()
    ):
        return "values at samples"
    rated = all(_rate(record, part) for part in channel(record, path).parts)
    return "cubic Hermite between samples" if rated else "cubic through 4 samples"


def _nearest(time: np.ndarray, times: np.ndarray) -> np.ndarray:
    after = np.searchsorted(time, times).clip(1, max(len(time) - 1, 1))
    return np.where(
        times - time[after - 1] <= time[after.clip(max=len(time) - 1)] - times, after - 1, after
    )


def _rate(record: Record, part: str) -> str | None:
    group, _, name = part.rpartition("/")
    rate = f"{group}/{RATES.get(name)}"
    return rate if group.startswith("bodies/") and rate in record else None


def _between(record: Record, part: str, time: np.ndarray, times: np.ndarray) -> np.ndarray:
    values, rate = record.values(part), _rate(record, part)
    if rate and len(time) > 1:
        return _hermite(time, values, record.values(rate), times)
    return cubic(time, values, times)


def _hermite(time, values, rates, times):
    i = np.clip(np.searchsorted(time, times, side="right") - 1, 0, len(time) - 2)
    step = time[i + 1] - time[i]
    s = (times - time[i]) / step
    bend = s * (s - 1.0)
    rise = values[i + 1] - values[i]
    corrections = (rates[i] * step - rise) * (s - 1.0) + (rates[i + 1] * step - rise) * s
    return values[i] + s * rise + bend * corrections


# --- along the run


def name_of(record: Record) -> str:
    """File name of a result, or the case of one that has no file."""
    path = getattr(record, "path", None)
    return path.name if path else record.attributes["case"]


def turn_of(record: Record) -> float:
    """Time of one turn of the drive [s].

    Raises ValueError where no drive turns at constant or nominal speed.
    """
    if record.turn is None:
        reason = "no drive turns at constant speed, or has a nominal one"
        raise ValueError(f"{name_of(record)}: {reason}; turns and drive angles need it")
    return record.turn


def drive_angle(record: Record) -> tuple[float, float, str]:
    """Angle of the turning drive at t = 0 [rad], its speed [rad/s] and the name of what it turns.

    The angle is the drive's start, else that of its body where it was stored, else 0. Raises
    ValueError as `turn_of`.
    """
    turn_of(record)
    drive = record.turning
    start, speed, theta = drive["start"], speed_of(drive), f"bodies/{drive['target']}/theta"
    if start is None and theta in record and record.time.size:
        start = record.values(theta)[0] - speed * record.time[0]
    return float(start or 0.0), speed, drive["target"]


def angle_at(record: Record, times: np.ndarray) -> np.ndarray:
    """Angle of the turning drive [rad] at times [s]. Raises ValueError as `turn_of`."""
    start, speed, _ = drive_angle(record)
    if record.uneven:
        return start + np.copysign(2.0 * np.pi, speed) * record.turns_at(times)
    return start + speed * times


def kept(record: Record, *, last: float | None = None, settle: float = 0.0) -> slice:
    """Samples of the last turns, or of those after `settle` turns; the last full ones of a finite
    drive.

    Raises ValueError for what is not positive.
    """
    time = record.time
    if last is not None and not last > 0.0:
        raise ValueError(f"last must be a positive number of turns, got {last!r}")
    if not settle >= 0.0:
        raise ValueError(f"settle must be a number of turns, not negative, got {settle!r}")
    if not time.size or last is None and settle == 0.0:
        return slice(None)
    near, (begin, end) = 1e-9 * turn_of(record), record.turns_at(time[[0, -1]])
    if last is None:
        return slice(int(np.searchsorted(time, record.time_at(begin + settle) - near)), None)
    if record.uneven and end - begin >= last + 1.0:
        end = np.floor(end)
    ends = record.time_at(np.array([end - last, end])) + [-near, near]
    return slice(*np.searchsorted(time, ends).tolist())


def abscissa(
    record: Record, along: str, last: float | None = None
) -> tuple[np.ndarray, slice, str]:
    """Time [s], drive "turns" or drive "angle" [deg] of the samples stored, which they are, and the
    axis label.

    Turns and angles of the `last` turns count from the full turn in which they start.
    Raises ValueError for another `along`, and where turns are requested and no drive turns at
    constant speed.
    """
    part = kept(record, last=last)
    time = record.time[part]
    if along == "time":
        return time, part, "time [s]"
    if along == "turns":
        turn_of(record)
        turns = record.turns_at(time)
        return _from_first(turns, 1.0) if last is not None else turns, part, "drive turns [-]"
    if along != "angle":
        raise ValueError(f"along must be one of time, turns, angle; got {along!r}")
    angle, target = np.degrees(angle_at(record, time)), drive_angle(record)[2]
    return _from_first(angle, 360.0) if last is not None else angle, part, f"{target} angle [deg]"


def _from_first(values: np.ndarray, period: float) -> np.ndarray:
    """Less the full turns at its start, so that the last turns of runs of any length lie over each
    other.
    """
    return values - period * np.floor(values[:1] / period + 1e-9).sum()


def principal(record: Record) -> str:
    """The last body (the slider of most mechanisms) along the axis it moves on more, as
    "bodies/slider/{}x".

    Raises ValueError where no body has stored both positions.
    """
    for body in [b["name"] for b in reversed(record.scene["bodies"])]:
        if {"x", "y"} <= set(record.names(f"bodies/{body}")) and record.time.size:
            spans = [np.ptp(record.values(f"bodies/{body}/{axis}")) for axis in "xy"]
            return f"bodies/{body}/{{}}{'xy'[int(np.argmax(spans))]}"
    raise ValueError(f"{name_of(record)} has no body's x and y; name the channels")
