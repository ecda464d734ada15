"""A run by name: `run["slider"].ax`, `run.joint("B").force`, its extremes and means; its
warnings in Python, one for each run that has some.
"""

import importlib
import json
import math
import warnings
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from clearance.results.errors import Error, Errors
from clearance.results.extremes import ROUNDING, SLIDES, Extreme, Extremes, Integrals, better
from clearance.values.accessors import Drawn, accessor
from clearance.values.checks import RunWarning, meant
from clearance.values.spelling import as_path


def warn(texts: Sequence[str]) -> None:
    """Issue the warnings of a run as one, at the line that called a `watched` study; nothing for
    none.
    """
    if texts:
        heading = f"{counted(texts)} of this run, also in `result.warnings`:"
        warnings.warn("\n".join([heading, *texts]), RunWarning, stacklevel=4)


def counted(texts: Sequence[str]) -> str:
    """Number of warnings, in words."""
    return f"{len(texts) or 'no'} warning{'' if len(texts) == 1 else 's'}"


#: the transition of before 0.3 with which contact begins with a touch
FIRST_TOUCH = "clearance.laws.transition:flores_hybrid"
#: groups whose channels move along time
MOVING = ("bodies", "joints", "springs", "drives", "nodes", "friction", "energy")
#: groups that have a group for each part
PARTS = ("bodies", "joints", "springs", "drives", "nodes")
GROUPS = ("energy", "friction")  # of channels, beside those of parts
#: extremes that follow from the smallest gap [m]
OF_GAP = {
    "film_thickness_ratio_min": lambda gap, joint: gap / joint["roughness"],
    "eccentricity_ratio_max": lambda gap, joint: 1.0 - gap / joint["clearance"],
}
NEAR = 0.05  # of a sample interval: a turn ends where the run located an end so near to it
#: group of a joint that holds sums of its wear
WEAR = "wear"


@dataclass(frozen=True)
class PressureFields:
    """Pressure fields of one joint, as arrays over instants, axial positions and angles; see
    run/pressure_fields.py.
    """

    instant: np.ndarray
    time: np.ndarray
    axial: np.ndarray
    angle: np.ndarray
    pressure: np.ndarray
    content: np.ndarray
    line_of_centres: np.ndarray
    eccentricity_ratio: np.ndarray


class Description(dict):
    """A scene as plain data; `dict(scene)` shows all of it."""

    def __repr__(self) -> str:
        joints = ", ".join(f"{j['name']}:{j['type']}" for j in self["joints"])
        return f"<description of {self['name']}: {len(self['bodies'])} bodies; {joints}>"


class Channels:
    """The channels of one group as attributes: `.ax`, and `.force` for the pair of `.force_x` and
    `.force_y`.
    """

    def __init__(self, record: "Record", group: str):
        self._record, self._group = record, group

    def __getattr__(self, name: str) -> np.ndarray:
        record, group = self.__dict__["_record"], self.__dict__["_group"]
        names = record.names(group)
        if name == "time":
            return record.time
        if name in names:
            return record.values(f"{group}/{name}")
        if f"{name}_x" in names:
            return np.stack([record.values(f"{group}/{name}_{axis}") for axis in "xy"], axis=-1)
        raise AttributeError(f"{group} has no channel {name!r}; it has {', '.join(names)}")

    def __contains__(self, name: str) -> bool:
        return name in self._record.names(self._group)

    def __dir__(self):
        return [*super().__dir__(), *self._record.names(self._group)]

    def __repr__(self) -> str:
        return f"<channels of {self._group}: {', '.join(self._record.names(self._group))}>"


def time_of(turns: np.ndarray, time: np.ndarray, counted: np.ndarray) -> np.ndarray:
    """Times at which turns were made, from those counted at samples, see `Record.time_at`."""
    turns = np.clip(turns, counted[0], counted[-1])
    ahead = np.concatenate([[True], np.diff(counted) > 0.0])
    if not ahead.all():
        return np.interp(turns, counted[ahead], time[ahead])
    return np.clip(cubic(counted, time, turns), time[0], time[-1])


class Record(Drawn, ABC):
    """Results of a run by name: `run["slider"].ax`, `run.joint("B").force`, `run.energy.residual`.

    Subclasses state where it is (in a file, in memory) by `attributes`, `solver`, `warnings`,
    `events`, `located`, `names`, `values`, `facts` and `units`. `located`: extremes that were
    located as the run went; None where only samples were seen. `integrals`: over time, likewise.
    `errors`: stated errors of its metrics and channels, see errors.py.
    """

    attributes: dict
    solver: dict
    warnings: list[str]
    events: dict[str, np.ndarray]
    located: Extremes | None = None
    integrals: Integrals | None = None
    errors: Errors = Errors(reason="this run has none")

    @abstractmethod
    def names(self, group: str) -> tuple[str, ...]:
        """Names in a group: the joints of "joints", the channels of "joints/B"; () where there is
        none.
        """

    @property
    def channels(self) -> tuple[str, ...]:
        """Paths of all stored channels, such as "joints/B/gap"."""
        groups = [f"{kind}/{n}" for kind in PARTS for n in self.names(kind)]
        return tuple(f"{group}/{n}" for group in (*groups, *GROUPS) for n in self.names(group))

    def _without(self, path: str) -> KeyError:
        """The error for a channel that it does not have."""
        hint = meant(path, self.channels)
        return KeyError(f"the result {self._label} has no channel {path!r}{hint}, or not stored")

    @abstractmethod
    def values(self, path: str) -> np.ndarray:
        """A channel by its path, such as "joints/B/gap". Raises KeyError for one that the run does
        not have.
        """

    @abstractmethod
    def facts(self, group: str) -> dict:
        """Facts of a group: `facts("joints/B")["peak_force"]`."""

    @abstractmethod
    def units(self, path: str) -> str:
        """SI units of a channel."""

    def __contains__(self, path: str) -> bool:
        group, _, name = path.rpartition("/")
        return name in self.names(group)

    def __repr__(self) -> str:
        errors = f"errors of {count} numbers" if (count := len(self.errors)) else "errors not"
        parts = f"{self._samples} samples", self.status, counted(self.warnings), f"{errors} stated"
        return f"<Result {self._label}: {', '.join(parts)}>"

    @property
    def _label(self) -> str:
        return f"of {self.attributes['case']}"

    @property
    def _samples(self) -> int:
        return len(self.time)

    @property
    def time(self) -> np.ndarray:
        """Times of the samples [s], shape (samples,)."""
        return self.values("time")

    @property
    def status(self) -> str:
        """ "complete", or "partial: " and why the run ended early."""
        return self.attributes["status"]

    @property
    def complete(self) -> bool:
        """True where the run came to its end."""
        return self.status == "complete"

    @cached_property
    def scene(self) -> dict:
        """The scene's description, as plain data."""
        return Description(json.loads(self.attributes["scene"]))

    @cached_property
    def turn(self) -> float | None:
        """Time of one turn of the drive at its constant or nominal speed [s]; None where there is
        none.
        """
        speed = None if self.turning is None else speed_of(self.turning)
        return 2.0 * np.pi / abs(speed) if speed else None

    @cached_property
    def turning(self) -> dict | None:
        """Description of the first drive that turns at a constant or nominal speed."""
        drives = (d for d in self.scene["loads"] if d["type"] == "Drive")
        return next((d for d in drives if speed_of(d) and _turns(d["target"])), None)

    @cached_property
    def _counted(self) -> np.ndarray | None:
        """Most turns that a drive with a nominal speed has made up to each sample; None where time
        counts them.
        """
        if self.turning is None or self.turning["speed"]:
            return None
        path = f"drives/{self.turning['name']}/turns"
        return np.maximum.accumulate(self.values(path)) if path in self else None

    @property
    def uneven(self) -> bool:
        """True where turns are counted by the angle of a finite drive, False where time counts
        them.
        """
        return self._counted is not None

    def turns_at(self, times: np.ndarray) -> np.ndarray:
        """Turns of the drive from the start to times [s], by its angle; by the nominal speed where
        that was not stored.

        Raises ValueError where no drive has a constant or nominal speed.
        """
        self._need_turns()
        if self._counted is None:
            return times / self.turn
        return np.interp(times, self.time, self._counted)

    def time_at(self, turns: np.ndarray) -> np.ndarray:
        """Times [s] at which the drive has first made so many turns: inverse of `turns_at`, by a
        cubic through four samples where it turns one way. Beyond the ends they are those of the
        ends. Raises ValueError as `turns_at`.
        """
        self._need_turns()
        if self._counted is None:
            return turns * self.turn
        times, integrals = time_of(turns, self.time, self._counted), self.integrals
        if integrals is None:
            return times
        near = integrals.edges[integrals.nearest(times)]
        return np.where(np.abs(near - times) < NEAR * np.ptp(self.time[-2:]), near, times)

    def summed(self, name: str, times: np.ndarray) -> np.ndarray | None:
        """Integrals between times, see `Integrals.between`."""
        return None if self.integrals is None else self.integrals.between(name, times)

    def _need_turns(self) -> None:
        if self.turning is None:
            raise ValueError("no drive turns at a constant or nominal speed; turns need one")

    def described(self, joint: str) -> dict:
        """Description of a joint, as plain data."""
        return next(j for j in self.scene["joints"] if j["name"] == joint)

    def begins_with_touch(self, joint: str) -> bool:
        """True where contact of a joint begins with a touch, as a row of the events.

        Files of before 0.3 have it from the law, where that is one of ours.
        """
        if (touching := self.attributes.get("first_touch")) is not None:
            return json.dumps(joint) in str(touching)
        law = self.described(joint).get("transition")
        return law is None or law["law"] == FIRST_TOUCH

    @property
    def clearances(self) -> dict[str, float]:
        """Radial clearance [m] of each clearance joint whose channels were stored."""
        joints = {j["name"]: j.get("clearance") for j in self.scene["joints"]}
        return {n: joints[n] for n in self.names("joints") if joints.get(n) is not None}

    def range(self, path: str) -> tuple[float, float]:
        """Smallest and largest sample of a channel, such as "joints/B/gap"."""
        values = self.values(path)
        return float(values.min()), float(values.max())

    def extreme(self, name: str, begin: float = 0.0, end: float = math.inf) -> Extreme:
        """Smallest or largest value of a quantity between two times [s], and its time.

        name: path of a channel, or of a vector for its size, and the end: "joints/B/gap_min",
            "joints/B/force_max", or as columns have it, "joint_B_force_max". Located to the
            tolerance of the run, one in each of its stretches (turns, mostly). These are gaps, film
            pressures and forces of joints, friction of joints without clearance, efforts of drives
            and accelerations along guides. Elsewhere, and in stretches that the times cut, they are
            those of the samples; at the times themselves also values between these.
        Raises KeyError for a channel the run does not have, ValueError where nothing lies between.
        """
        name = as_path(str(name).strip("/"), self.scene)
        path, _, which = name.rpartition("_")
        if which not in ("min", "max") or path.partition("/")[0] not in MOVING:
            raise KeyError(
                f"{name!r}: the name of an extreme is the path of a channel and _min or _max"
            )
        if not begin <= end:
            raise ValueError(
                f"extreme {name}: begin must not lie after end, got {begin!r} and {end!r}"
            )
        located = self._located_extreme(name, begin, end)
        parts = [(begin, end)]
        if located is not None and self.located is not None:
            parts = self._cut(self.located, begin, end)
        seen = []
        if located is None or path in self or f"{path}_x" in self:
            seen = [self._of_samples(path, which, *part) for part in parts]
        if parts and self.located is not None and name in self.located:
            seen += self._at_ends(name, begin, end)
        if (outermost := better(name, [*seen, located])) is None:
            raise ValueError(f"extreme {name}: the run has nothing between {begin:g} and {end:g} s")
        return replace(outermost, units=self._units_of(name))

    def _units_of(self, name: str) -> str:
        """SI units of an extreme; none of a ratio that follows from a gap."""
        path, located = name.rpartition("_")[0], self.located
        if located is not None and name in located:
            return located.units[located.columns[name]]
        return next((self.units(p) for p in (path, f"{path}_x") if p in self), "1")

    def _cut(self, located: Extremes, begin: float, end: float) -> list[tuple[float, float]]:
        """Parts between two times [s] whose samples count beside located extremes.

        Samples stand between the steps. A stiff film magnifies the errors of states there.
        """
        last = self._times[-1] if self._times.size else math.inf
        return located.cut(begin, math.inf if end >= last * (1.0 - ROUNDING) else end)

    def mean_square(self, path: str, begin: float, end: float) -> float | None:
        """Mean over time of the square of a channel, or of a vector, between two times [s]."""
        return self._mean(f"{path}_square", begin, end)

    def share_above_zero(self, path: str, begin: float, end: float) -> float | None:
        """Share of the time between two times [s] in which a channel is positive."""
        return self._mean(f"{path}_positive", begin, end)

    def _mean(self, name: str, begin: float, end: float) -> float | None:
        """Mean of an integrand from the integrals of the run; beside its parts from the samples.

        None where the run has no integral of it there. Squares and times are never negative, but
        cubics through samples may be.
        """
        integrals = self.integrals
        if integrals is None or name not in integrals.cumulated:
            return None
        first, last = integrals.inside(begin, end)
        if first == last:
            return None
        total = integrals.cumulated[name][last] - integrals.cumulated[name][first]
        for one, other in ((begin, integrals.edges[first]), (integrals.edges[last], end)):
            if other - one > ROUNDING * integrals.edges[1]:
                total += self._integral_of_samples(name, one, other)
        return max(float(total), 0.0) / (end - begin)

    def _integral_of_samples(self, name: str, begin: float, end: float) -> float:
        """Integral of an integrand between two times [s], by Simpson's rule on cubics through
        samples.
        """
        path, _, form = name.rpartition("_")
        time, values = self.time, self.sizes(path)
        values = values**2 if form == "square" else np.asarray(values > 0.0, dtype=float)
        inside = time[(time > begin) & (time < end)]
        edges = np.concatenate([[begin], inside, [end]])
        middles = 0.5 * (edges[1:] + edges[:-1])
        at_edges, at_middles = (cubic(time, values, places) for places in (edges, middles))
        sums = at_edges[:-1] + 4.0 * at_middles + at_edges[1:]
        return float((np.diff(edges) * sums).sum()) / 6.0

    def error(self, name: str, begin: float = 0.0, end: float = math.inf) -> Error:
        """The extreme of this name between two times [s], as `extreme` has it, with its stated
        error.

        The error is the largest of those of the stretches that lie there. Where a sample lies
        beyond them, it is at least that of its channel. Raises KeyError where none is stated.
        """
        errors, located, name = self.errors, self.located, as_path(name, self.scene)
        if errors.extremes is None or located is None or name not in located:
            raise KeyError(
                f"no stated error of {name!r}: {errors.reason or 'it is no located extreme'}"
            )
        column = located.columns[name]
        value, units = self.extreme(name, begin, end).value, located.units[column]
        parts = errors.extremes.stated, errors.extremes.film
        inside = located.inside(begin, end)[:, column]
        stated, film = (float(part[inside, column].max(initial=0.0)) for part in parts)
        searched = located.of(name, begin, end)
        if searched is None or value != searched.value:
            stated = max(stated, self._error_of_samples(name.rpartition("_")[0]))
        return Error(value, stated, units, film=film)

    def _error_of_samples(self, path: str) -> float:
        """Stated error of the samples of a channel, or of the sizes of a vector's."""
        shares = self.errors.channels
        paths = [path] if path in self else [f"{path}_x", f"{path}_y"]
        return math.hypot(*(shares[p] * float(np.ptp(self.values(p))) for p in paths))

    def _located_extreme(self, name: str, begin: float, end: float) -> Extreme | None:
        """A located extreme; of the ratios of a gap, that of the gap."""
        if self.located is None or name in self.located:
            return None if self.located is None else self.located.of(name, begin, end)
        group, _, quantity = name.rpartition("/")
        if quantity not in OF_GAP or f"{group}/gap_min" not in self.located:
            return None
        gap = self.located.of(f"{group}/gap_min", begin, end)
        joint = self.described(group.partition("/")[2])
        return gap and Extreme(OF_GAP[quantity](gap.value, joint), gap.time)

    def _of_samples(self, path: str, which: str, begin: float, end: float) -> Extreme | None:
        inside = self._between(begin, end)
        values = self.sizes(path)[inside]
        if not values.size:
            return None
        i = int(values.argmin() if which == "min" else values.argmax())
        return Extreme(float(values[i]), float(self._times[inside][i]))

    def _at_ends(self, name: str, begin: float, end: float) -> Iterator[Extreme]:
        """Values of a located quantity at two times [s] which lie between samples."""
        inside = [t for t in (begin, end) if 0.0 < t < self._times[-1]]
        values = self.between_samples(name.rpartition("_")[0], np.array(inside))
        for time, value in zip(inside, [] if values is None else values.tolist(), strict=False):
            yield Extreme(value, time)

    def between_samples(self, path: str, times: np.ndarray) -> np.ndarray | None:
        """Values of a channel, or sizes of a vector's, at times [s]: cubics through samples, never
        beyond the two about a time. None of a channel that was not stored.
        """
        if path not in self and f"{path}_x" not in self:
            return None
        values = self.sizes(path)
        high = np.clip(np.searchsorted(self._times, times), 1, len(values) - 1)
        pair = values[high - 1], values[high]
        return np.clip(cubic(self._times, values, times), np.minimum(*pair), np.maximum(*pair))

    @cached_property
    def _times(self) -> np.ndarray:
        """Times of the samples, read once."""
        return self.time

    def sizes(self, path: str) -> np.ndarray:
        """Samples of a channel, or sizes of a vector's."""
        if path in self or f"{path}_x" not in self:
            return self.values(path)
        return np.hypot(self.values(f"{path}_x"), self.values(f"{path}_y"))

    def extremes(self, path: str, begin: float = 0.0, end: float = math.inf) -> tuple[float, float]:
        """Smallest and largest value of a channel between two times [s], as `extreme` gives
        them.
        """
        return self.extreme(f"{path}_min", begin, end).value, self.extreme(
            f"{path}_max", begin, end
        ).value

    def _between(self, begin: float, end: float) -> slice:
        """Samples between two times [s]."""
        first = np.searchsorted(self._times, begin * (1.0 - ROUNDING))
        last = np.searchsorted(self._times, end * (1.0 + ROUNDING), side="right")
        return slice(int(first), int(last))

    def _channels(self, kind: str, name: str) -> Channels:
        if name not in self.names(kind):
            raise KeyError(
                f"no {name!r} among {kind}; there are: {', '.join(self.names(kind)) or 'none'}"
            )
        return Channels(self, f"{kind}/{name}")

    def __getitem__(self, body: str) -> Channels:
        if "/" in body:
            raise KeyError(f"{body!r} is not a body; a channel is result.values({body!r})")
        return self._channels("bodies", body)

    def joint(self, name: str) -> Channels:
        """Channels of a joint: `joint("B").eccentricity`, `.force`. Raises KeyError for a joint
        there is not.
        """
        return self._channels("joints", name)

    def drive(self, name: str) -> Channels:
        """Channels of a drive: `drive("crank").torque`, `.power`. Raises KeyError for a drive there
        is not.
        """
        return self._channels("drives", name)

    def node(self, name: str) -> Channels:
        """Channels of a thermal node: `node("housing").temperature`. Raises KeyError for a node
        there is not.
        """
        return self._channels("nodes", name)

    def pressure_fields(self, joint: str) -> PressureFields | None:
        """Pressure fields of a joint's film; None where none was requested of the run."""
        return None

    @cached_property
    def dataset(self):
        """Channels along time as an xarray Dataset, by the names of the command line:
        `dataset["slider.ax"]`.

        Names that two parts share are full paths, as "joints/B/force_x". Coordinates: time [s],
        and turns of the drive where one turns. Raises ImportError where xarray is not installed.
        """
        xarray = extra("xarray")
        paths = self.channels
        short = {path: ".".join(path.split("/")[-2:]) for path in paths}
        shared = Counter(short.values())
        names = {path: short[path] if shared[short[path]] == 1 else path for path in paths}
        columns = {names[path]: ("time", self.values(path), self._about(path)) for path in paths}
        along = {"time": ("time", self.time, {"units": "s"})}
        if self.turning is not None:
            along["turns"] = "time", self.turns_at(self.time), {"units": "1"}
        about = {
            n: v
            for n, v in self.attributes.items()
            if n in ("case", "status", "parameters", "created")
        }
        return xarray.Dataset(columns, along, about)

    def _about(self, path: str) -> dict[str, str]:
        """Attributes of a channel in a dataset."""
        return {"units": self.units(path)}

    def to_csv(self, path: str | Path, channels: Sequence[str] | None = None) -> Path:
        """Write channels along time as CSV, with units in the heads: `cl.fit` and `cl.compare` read
        it. channels: paths or patterns, default all. Raises ValueError for one that is not stored.
        """
        return accessor("to_csv")(self, path, channels)

    def to_mat(self, path: str | Path, channels: Sequence[str] | None = None) -> Path:
        """Write channels, their units and the metrics for MATLAB: `load` gives bodies.slider.ax.

        channels: as in `to_csv`. Raises ValueError for one that is not stored.
        """
        return accessor("to_mat")(self, path, channels)

    def to_latex(self, path: str | Path | None = None, metrics: Sequence[str] | None = None) -> str:
        """A LaTeX table of the metrics with their stated errors, written where a path is given.

        metrics: names or patterns, such as "joint_B_*", default all. Raises ValueError for one that
        the run does not have.
        """
        return accessor("to_latex")(self, path, metrics)

    def metrics(self, settle: float | None = None) -> dict:
        """Numbers that `clearance run --json` prints, by column or path: value, units, text; of an
        extreme its time.

        settle: turns [s, where no drive turns] left out at the start, default one where there is a
        second. Raises ValueError for a settle that is negative or not finite.
        """
        return accessor("metrics")(self, settle)

    def citations(self) -> str:
        """BibTeX of what the run used: clearance, laws of the scene, the integrator."""
        return accessor("citations")(self)

    @property
    def energy(self) -> Channels:
        """The energy ledger [J]: kinetic, potential, input, dissipated, residual; where it was
        stored.
        """
        return Channels(self, "energy")


def cubic(x: np.ndarray, y: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Values of y(x) at points by a cubic through the four samples around each, or through fewer
    where there are.
    """
    count, at = min(4, len(x)), np.asarray(at, dtype=float)
    first = np.clip(np.searchsorted(x, at, side="right") - count // 2, 0, len(x) - count)
    return lagrange([x[first + i] for i in range(count)], [y[first + i] for i in range(count)], at)


def lagrange(nodes: list[np.ndarray], values: list[np.ndarray], at: np.ndarray) -> np.ndarray:
    """The polynomial through values at nodes, a list of arrays like `at` each."""
    total = np.zeros_like(at)
    for i, node in enumerate(nodes):
        others = [(at - other) / (node - other) for j, other in enumerate(nodes) if j != i]
        total += np.prod(others, axis=0) * values[i]
    return total


def speed_of(drive: dict) -> float | None:
    """Constant or nominal speed of a drive, from its description."""
    return drive.get("speed") or drive.get("nominal")


def _turns(target: str | dict) -> bool:
    """True where a drive turns its target, the name of a body or a joint, rather than pushing a
    slide.
    """
    return isinstance(target, str) or target["type"] not in SLIDES


def extra(package: str):
    """A package of the extra xarray. Raises ImportError stating how it is installed."""
    try:
        return importlib.import_module(package)
    except ImportError:
        raise ImportError(f"{package} is not installed: pip install 'clearance[xarray]'") from None
