"""The result file: one HDF5 file a run, written as the run goes, complete or honestly partial.

Layout, in SI units; every dataset has `units` and `long_name`. Along time are /time, /bodies,
/joints, /springs, /drives, /energy. /events has one row per contact, /solver one per step. Along
each goes a dimension of its own, so that xarray opens the entire file as a tree. Columns carry
checksums: reading a damaged file names the place.
"""

import datetime
import importlib.metadata
import itertools
import json
import logging
import math
import os
import platform
import shutil
import tempfile
import weakref
import zlib
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path

import h5py
import numpy as np

from clearance.files.locks import Lock
from clearance.results.accessors import Drawn
from clearance.results.errors import Error, Errors, ExtremeErrors
from clearance.results.extremes import ROUNDING, SLIDES, Extreme, Extremes, better
from clearance.results.hdf5_image import CHECK, readable
from clearance.results.integrals import Integrals
from clearance.results.reading import (
    FACT_UNITS,
    Damaged,
    Entries,
    Missing,
    Reader,
    checked,
    column_check,
    open_checked,
)
from clearance.results.run_warning import counted
from clearance.results.sensitivity import COLUMNS, Sensitivities
from clearance.scene.document import check
from clearance.version import VERSION

LOG = logging.getLogger("clearance.files")
FORMAT = "clearance-result"
FORMAT_VERSION = 2
#: whose versions stand in a file beside our own
PACKAGES = ("numpy", "numba", "h5py")
#: groups whose channels move along time
MOVING = ("bodies", "joints", "springs", "drives", "nodes", "friction", "energy")
#: groups that have a group for each part
PARTS = ("bodies", "joints", "springs", "drives", "nodes")
#: extremes that follow from the smallest gap [m]
OF_GAP = {
    "film_thickness_ratio_min": lambda gap, joint: gap / joint["roughness"],
    "eccentricity_ratio_max": lambda gap, joint: 1.0 - gap / joint["clearance"],
}
_count = itertools.count()
#: dimension of each table of a result file, a dataset beside its columns; along all other groups
#: goes time
DIMENSIONS = {"events": "event", "solver": "step_number"}
#: columns of contacts that hold texts
EVENT_TEXTS = {"joint": "joint in contact", "kind": "contact, or open_contact: not over at the end"}
#: group of the pressure fields of a joint's film, see run/pressure_fields.py
FIELDS = "film"
#: group of a joint that holds sums of its wear
WEAR = "wear"
PATH_OF_FIELDS = f"joints/{{}}/{FIELDS}"
#: of HDF5: from 1.8 (2008) on, what describes the columns has checksums, too
LIBVER = ("v108", "v108")
COMPACT = 1024  # attributes of a group that stand in its header, at most


def provenance() -> dict:
    """Format, versions of what made a file, and when (UTC); attributes of every file."""
    return {
        "format": FORMAT,
        "format_version": FORMAT_VERSION,
        "created": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "version_python": platform.python_version(),
        "version_clearance": VERSION,
        **_versions(),
    }


@cache
def _versions() -> dict[str, str]:
    """Versions of the packages, looked up once a process."""
    versions = {}
    for package in PACKAGES:
        try:
            versions[f"version_{package}"] = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            versions[f"version_{package}"] = "not installed"
    return versions


def check_replaceable(path: Path) -> None:
    """A file may take this name.

    Raises ValueError for a device, a pipe or a socket, which would be lost.
    """
    if path.exists() and not path.is_file() and not path.is_dir():
        raise ValueError(f"{path} is a device, a pipe or a socket; give the name of a file")


def check_result(path: Path) -> None:
    """A result may replace the file of this name.

    Raises ValueError for a file that is not HDF5, such as a scene file.
    """
    if path.is_file() and path.stat().st_size and not h5py.is_hdf5(path):
        reason = "is there already and is no result file"
        raise ValueError(f"{path} {reason}; give another name to the result")


def temporary_name(path: Path) -> Path:
    """A name beside a file that no other writer of it uses."""
    return path.with_name(f"{path.name}.{os.getpid()}.{next(_count)}.partial")


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A temporary name to write to; what is there at the end becomes `path`, completely or not at
    all.

    Raises ValueError as `check_replaceable` does.
    """
    check_replaceable(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = temporary_name(path)
    temporary.unlink(missing_ok=True)
    try:
        yield temporary
        os.replace(temporary, path)
    except OSError as error:
        if error.errno and not error.filename:  # the system does not name what it could not write
            error.filename = str(path)
        raise
    finally:
        temporary.unlink(missing_ok=True)


@contextmanager
def locked(folder: Path, doing: str) -> Iterator[None]:
    """One process at a time in a folder, where the system has file locks; they end with the process
    that holds them.

    doing: what the other one is doing, for the message. Raises ValueError where the folder is in
        use.
    """
    with Lock(folder / "lock", f"{folder} is in use: another process is {doing}") as lock:
        if not lock.held:
            LOG.warning("this file system has no locks: see that nobody else uses %s", folder)
        yield


@contextmanager
def appending(path: str | Path) -> Iterator[h5py.File]:
    """A result file to add groups to; it keeps its name and stays as it was until all of them are
    written.
    """
    with replacing(Path(path)) as temporary:
        shutil.copyfile(path, temporary)
        with h5py.File(temporary, "r+", libver=LIBVER) as file:
            yield file


#: name of a column -> (units, what it is, values)
Table = dict[str, tuple[str, str, np.ndarray]]


def save_tables(
    path: str | Path, kind: str, attributes: dict, tables: dict[str, tuple[dict, Table]]
) -> Path:
    """Write tables of a study (group -> attributes and columns) into one HDF5 file, completely or
    not at all.
    """
    path = Path(path)
    with in_memory(path) as file:
        file.attrs.update(checked(provenance() | {"format": kind} | attributes))
        for name, (length, columns) in tables.items():
            write_table(file, name, length, columns)
        image = image_of(file)
    with replacing(path) as temporary:
        temporary.write_bytes(image)
    return path


def write_table(file: h5py.File, place: str, about: dict, columns: Table) -> None:
    """Add a group with its attributes and columns."""
    group = file.create_group(place, track_order=True)
    group.attrs.update(checked(about))
    for column, (units, what, values) in columns.items():
        create_column(group, column, np.asarray(values), units, what)


def create_column(
    group: h5py.Group, name: str, values: np.ndarray, units: str, long_name: str
) -> None:
    """A column of a table with its checksum; texts have one length, for checksums do not cover
    others.
    """
    layout = {"chunks": values.shape, "fletcher32": True} if values.size and values.ndim else {}
    about: dict = {"units": units, "long_name": long_name}
    if values.dtype.kind in "UO":
        about["_Encoding"] = "utf-8"  # for xarray
        values = np.char.encode(values.astype(str), "utf-8")
        values = values.astype(h5py.string_dtype("utf-8", max(values.dtype.itemsize, 1)))
        layout |= {"compression": "gzip"} if layout else {}
    about[CHECK] = column_check(units, long_name, zlib.crc32(np.ascontiguousarray(values).data))
    group.create_dataset(name, data=values, dtype=values.dtype, **layout).attrs.update(about)


def in_memory(path: Path, image: bytes | None = None) -> h5py.File:
    """An HDF5 file that is made in memory: on a full disk HDF5 can neither write one nor let go of
    it.

    image: of another one, to go on with.
    """
    access = h5py.h5p.create(h5py.h5p.FILE_ACCESS)
    access.set_fapl_core(backing_store=False)
    access.set_libver_bounds(h5py.h5f.LIBVER_V18, h5py.h5f.LIBVER_V18)
    name = os.fsencode(path)
    if image is not None:
        access.set_file_image(image)
        return h5py.File(h5py.h5f.open(name, h5py.h5f.ACC_RDWR, access))
    root = h5py.h5p.create(h5py.h5p.FILE_CREATE)
    root.set_attr_phase_change(COMPACT, 0)
    return h5py.File(h5py.h5f.create(name, h5py.h5f.ACC_TRUNC, root, access))


def compact_groups(file: h5py.File, paths: Iterable[str]) -> None:
    """Make groups, with those above them, whose attributes stand in their headers."""
    properties = h5py.h5p.create(h5py.h5p.GROUP_CREATE)
    properties.set_attr_phase_change(COMPACT, 0)
    for path in dict.fromkeys(paths):
        parts = path.split("/")
        for place in ("/".join(parts[:i]) for i in range(1, len(parts) + 1)):
            if place and place not in file:
                h5py.h5g.create(file.id, place.encode(), gcpl=properties)


def image_of(file: h5py.File) -> bytes:
    """The bytes of a file that is made in memory."""
    file.flush()
    return readable(file.id.get_file_image())


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


#: datasets of a group of fields: units, what it is
FIELD_COLUMNS = {
    "instant": ("1", "place of the sample in /time"),
    "axial": ("m", "axial position from the middle of the bearing"),
    "angle": ("rad", "angle on the bearing from its body's own x axis"),
    "time": ("s", "time of the field"),
    "line_of_centres": ("rad", "angle of the thinnest film on the bearing"),
    "eccentricity_ratio": ("1", "eccentricity over clearance"),
    "pressure": ("Pa", "film pressure above ambient"),
    "content": ("1", "share of the gap that holds oil"),
}


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
        return json.loads(self.attributes["scene"])

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
        time, counted = self.time, self._counted
        turns = np.clip(turns, counted[0], counted[-1])
        ahead = np.concatenate([[True], np.diff(counted) > 0.0])
        if not ahead.all():
            return np.interp(turns, counted[ahead], time[ahead])
        return np.clip(cubic(counted, time, turns), time[0], time[-1])

    def _need_turns(self) -> None:
        if self.turning is None:
            raise ValueError("no drive turns at a constant or nominal speed; turns need one")

    def described(self, joint: str) -> dict:
        """Description of a joint, as plain data."""
        return next(j for j in self.scene["joints"] if j["name"] == joint)

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
            "joints/B/force_max". Located to the tolerance of the run, one in each of its stretches
            (turns, mostly). These are gaps, film pressures and forces of joints, friction of joints
            without clearance, efforts of drives and accelerations along guides. Elsewhere, and in
            stretches that the times cut, they are those of the samples.
        Raises KeyError for a channel the run does not have, ValueError where nothing lies between.
        """
        name = str(name).strip("/")
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
        if (outermost := better(name, [*seen, located])) is None:
            raise ValueError(f"extreme {name}: the run has nothing between {begin:g} and {end:g} s")
        return outermost

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
        errors, located = self.errors, self.located
        if errors.extremes is None or located is None or name not in located:
            raise KeyError(
                f"no stated error of {name!r}: {errors.reason or 'it is no located extreme'}"
            )
        inside, column = located.inside(begin, end, located.columns[name]), located.columns[name]
        value, units = self.extreme(name, begin, end).value, located.units[column]
        parts = errors.extremes.stated, errors.extremes.film
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
        groups = [f"{kind}/{n}" for kind in PARTS for n in self.names(kind)] + [
            "energy",
            "friction",
        ]
        paths = [f"{group}/{name}" for group in groups for name in self.names(group)]
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

    @property
    def energy(self) -> Channels:
        """The energy ledger [J]: kinetic, potential, input, dissipated, residual; where it was
        stored.
        """
        return Channels(self, "energy")


class Result(Record):
    """A result file, read lazily.

    What of it cannot be read raises Damaged, naming the file and the place.
    """

    def __init__(self, path: str | Path):
        self.path = Path(path)
        self.reader = open_checked(self.path, "clearance result", FORMAT, FORMAT_VERSION)
        self.file = self.reader.file

    def names(self, group: str) -> tuple[str, ...]:
        aside = {"time", DIMENSIONS.get(group)} if group else set()
        aside |= {FIELDS, WEAR} if group.startswith("joints/") else set()
        return tuple(n for n in self.reader.names(group) if n not in aside)

    def values(self, path: str) -> np.ndarray:
        along = None if path.partition("/")[0] in DIMENSIONS else self._samples
        try:
            column = self.reader.column(path, along)
        except Missing:
            if path == "time":
                raise
            raise KeyError(
                f"{self.reader.path.name} has no channel {path!r}; it may not have been stored "
                f"when the file was written"
            ) from None
        if column.dtype.kind != "f" or column.ndim != 1:
            raise Damaged(
                f"{self.path}: /{path} is no row of numbers, but {column.dtype} of shape "
                f"{column.shape}"
            )
        return column

    @cached_property
    def _samples(self) -> int:
        return math.prod(self.reader.shape("time"))

    def facts(self, group: str) -> dict:
        facts = self.reader.attributes(group) if self.reader.has(group) else {}
        return {
            n: v
            for n, v in facts.items()
            if n.removesuffix("_units") not in FACT_UNITS or not isinstance(v, str)
        }

    def units(self, path: str) -> str:
        return self.reader.attribute(path, "units")

    def _about(self, path: str) -> dict[str, str]:
        return {n: self.reader.attribute(path, n) for n in ("units", "long_name")}

    @property
    def attributes(self) -> dict:
        """Provenance: format, versions, scene JSON, kernel source, status."""
        return self.reader.attributes()

    @cached_property
    def scene(self) -> dict:
        """The scene's description, as plain data."""
        document = dict(self.reader.document("", "scene"))
        try:
            check(document)
        except ValueError as error:
            raise Damaged(f"{self.path}: attribute scene: {error}") from None
        return document

    @property
    def solver(self) -> dict:
        """Method, tolerances, counts and wall time of the run."""
        return self.reader.attributes("solver")

    @property
    def warnings(self) -> list[str]:
        """Warnings of the run, joint by joint."""
        return [str(w) for w in np.atleast_1d(self.reader.attribute("", "warnings"))]

    def range(self, path: str) -> tuple[float, float]:
        """Smallest and largest sample of a channel, without reading it."""
        low, high = self.reader.attribute(path, "actual_range")
        return float(low), float(high)

    @cached_property
    def located(self) -> Extremes | None:
        """Extremes that were located as the run went; of files of format 1 those of step ends,
        without their times.
        """
        if "stretch_s" in self.reader.item().attrs:
            return _extremes_of_format_1(self.reader)
        if not self.reader.has("extremes"):
            return None
        columns = ("quantity", "units_of", "value", "when")
        names, units, values, times = (self.reader.column(f"extremes/{n}") for n in columns)
        if (
            values.shape != times.shape
            or values.shape[1:] != names.shape
            or names.shape != units.shape
        ):
            raise Damaged(f"{self.path}: /extremes holds columns that do not fit one another")
        if {names.dtype.kind, units.dtype.kind} != {"U"} or {
            values.dtype.kind,
            times.dtype.kind,
        } != {"f"}:
            raise Damaged(f"{self.path}: /extremes holds columns of another kind")
        length = float(self.reader.attribute("extremes", "stretch_s"))
        if not 0.0 < length < math.inf:
            raise Damaged(
                f"{self.path}: /extremes: attribute stretch_s must be positive, got {length!r}"
            )
        return Extremes(length, tuple(map(str, names)), tuple(map(str, units)), values, times)

    @cached_property
    def integrals(self) -> Integrals | None:
        """Integrals over time that were summed as the run went; none in files of versions before
        0.2.
        """
        if not self.reader.has("integrals"):
            return None
        names, units = self._columns("integrals", "U", "integral", "integral_units")
        (ends,) = self._columns("integrals", "f", "part_end")
        values = self.reader.column("integrals/amount")
        shape = len(ends), len(names)
        if values.dtype.kind != "f" or values.shape != shape or len(units) != len(names):
            raise Damaged(f"{self.path}: /integrals holds columns that do not fit one another")
        return Integrals(tuple(map(str, names)), tuple(map(str, units)), ends, values)

    @cached_property
    def errors(self) -> Errors:
        """Stated errors of metrics, extremes and channels; none in files of versions before 0.2."""
        if not self.reader.has("errors"):
            return Errors(
                reason=str(self.reader.attributes().get("errors_left_out", "none was requested"))
            )
        texts = self._columns("errors", "U", "name", "units_of", "kind", "channel")
        value, stated, film, share = self._columns(
            "errors", "f", "value", "stated", "film", "share"
        )
        (names, units, kinds, channels), about = texts, self.reader.attributes("errors")
        if not len(names) == len(units) == len(kinds) == len(value) == len(stated) == len(film):
            raise Damaged(f"{self.path}: /errors holds columns that do not fit one another")
        rows = zip(
            value.tolist(),
            stated.tolist(),
            map(str, units),
            map(str, kinds),
            film.tolist(),
            strict=True,
        )
        return Errors(
            dict(zip(map(str, names), (Error(*row) for row in rows), strict=True)),
            dict(zip(map(str, channels), share.tolist(), strict=False)),
            "",
            (float(about["rtol"]), float(about["companion_rtol"])),
            float(about["spread"]),
            float(about["begin_s"]),
            float(about["end_s"]),
            self._extreme_errors(),
            json.loads(about.get("asked", "{}")),
            about.get("cannot", ""),
        )

    def _columns(self, group: str, kind: str, *names: str) -> list[np.ndarray]:
        """Columns of a table, texts or numbers. Raises Damaged for those of another kind."""
        columns = [self.reader.column(f"{group}/{name}") for name in names]
        for name, column in zip(names, columns, strict=True):
            if column.dtype.kind != kind or column.ndim != 1:
                raise Damaged(f"{self.path}: /{group}/{name} is a column of another kind")
        return columns

    @cached_property
    def sensitivities(self) -> Sensitivities:
        """Sensitivities of the metrics; none unless the run was made with some."""
        if not self.reader.has("sensitivities"):
            about = self.reader.attributes().get("sensitivities_left_out", "none were requested")
            return Sensitivities(reason=str(about))
        texts = "metric", "metric_units", "parameter", "parameter_units"
        numbers = "metric_value", "size"
        columns = dict(zip(texts, self._columns("sensitivities", "U", *texts), strict=True))
        columns |= zip(numbers, self._columns("sensitivities", "f", *numbers), strict=True)
        columns |= {n: self.reader.column(f"sensitivities/{n}") for n in ("value", "error")}
        shape = len(columns["metric"]), len(columns["parameter"])
        if any(
            columns[n].dtype.kind != "f" or columns[n].shape != shape for n in ("value", "error")
        ):
            raise Damaged(f"{self.path}: /sensitivities holds no table of numbers")
        try:
            return Sensitivities.of_columns(columns)
        except ValueError as error:
            raise Damaged(f"{self.path}: /sensitivities: {error}") from None

    def _extreme_errors(self) -> ExtremeErrors | None:
        if self.located is None or not self.reader.has("extremes/stated"):
            return None
        columns = [self.reader.column(f"extremes/{n}") for n in ("stated", "film")]
        if any(f.dtype.kind != "f" or f.shape != self.located.values.shape for f in columns):
            raise Damaged(f"{self.path}: /extremes holds errors that do not fit its values")
        return ExtremeErrors(*columns)

    @property
    def events(self) -> dict[str, np.ndarray]:
        """The impact table: one entry per column, one row per contact."""
        columns = {
            name: self.reader.column(f"events/{name}") for name in ("time", *self.names("events"))
        }
        if any(column.shape != (columns["time"].size,) for column in columns.values()):
            raise Damaged(f"{self.path}: the columns of /events differ in length")
        if any((c.dtype.kind == "U") != (n in EVENT_TEXTS) for n, c in columns.items()):
            raise Damaged(f"{self.path}: a column of /events is of another kind")
        return Entries(f"{self.path}: /events", columns)

    def pressure_fields(self, joint: str) -> PressureFields | None:
        """Pressure fields of a joint's film; None where none was requested of the run."""
        place = PATH_OF_FIELDS.format(joint)
        if not self.reader.has(place):
            return None
        fields = PressureFields(**{n: self.reader.column(f"{place}/{n}") for n in FIELD_COLUMNS})
        shape = fields.instant.size, fields.axial.size, fields.angle.size
        if not fields.pressure.shape == fields.content.shape == shape:
            raise Damaged(f"{self.path}: /{place} holds columns that do not fit one another")
        return fields

    def to_xarray(self):
        """All of it as an xarray DataTree in memory, with the groups, units and attributes of the
        file.
        """
        xarray = extra("xarray")
        groups = [f"{kind}/{n}" for kind in PARTS for n in self.names(kind)]
        datasets = {"/": xarray.Dataset(attrs=self.attributes)}
        for group in [*groups, "energy", "friction", *DIMENSIONS]:
            if not (names := self.names(group)):
                continue
            along, columns = DIMENSIONS.get(group, "time"), {}
            for name in ("time", *names):
                values, about = (
                    self.reader.column(f"{group}/{name}"),
                    self.reader.attributes(f"{group}/{name}"),
                )
                columns[name] = (along, values, {n: about[n] for n in ("units", "long_name")})
            data = xarray.Dataset(columns, attrs=self.reader.attributes(group))
            datasets[f"/{group}"] = data.set_coords("time")
        if self.reader.has("extremes") and (located := self.located) is not None:
            along = ("stretch", "quantity")
            columns = {
                "value": (along, located.values),
                "when": (along, located.times, {"units": "s"}),
            }
            starts = located.length * np.arange(len(located.values))
            names = {
                "stretch": starts,
                "quantity": list(located.names),
                "units_of": ("quantity", list(located.units)),
            }
            datasets["/extremes"] = xarray.Dataset(columns, names)
        if (integrals := self.integrals) is not None:
            columns = {"amount": (("part_end", "integral"), integrals.values)}
            names = {"part_end": integrals.ends, "integral": list(integrals.names)}
            names["integral_units"] = "integral", list(integrals.units)
            datasets["/integrals"] = xarray.Dataset(columns, names)
        if errors := self.errors:
            columns = {
                n: ("name", [getattr(e, n) for e in errors.values()])
                for n in ("value", "stated", "film")
            }
            columns["units_of"] = "name", [e.units for e in errors.values()]
            columns["share"] = "channel", list(errors.channels.values())
            datasets["/errors"] = xarray.Dataset(
                columns, {"name": list(errors), "channel": list(errors.channels)}
            )
        if sensitivities := self.sensitivities:
            columns = {n: (COLUMNS[n][0], values) for n, values in sensitivities.columns().items()}
            names = {n: columns.pop(n) for n in ("metric", "parameter")}
            datasets["/sensitivities"] = xarray.Dataset(columns, names)
        return xarray.DataTree.from_dict(datasets)

    def save(self, path: str | Path) -> Path:
        """Copy the file to `path`, under a temporary name until it is complete.

        Raises ValueError where that would replace a file that is no result.
        """
        path = Path(path)
        check_result(path)
        with replacing(path) as temporary:
            shutil.copyfile(self.path, temporary)
        return path

    def close(self) -> None:
        """Close the file; channels already read stay."""
        self.file.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def __repr__(self) -> str:
        return super().__repr__() if self.file else "<Result, closed>"

    @property
    def _label(self) -> str:
        return self.reader.path.name


class MemoryResult(Result):
    """A result without a file; `path` writes one, which goes with the result.

    image: the bytes of its file.
    """

    _label = Record._label

    def __init__(self, image: bytes):
        self.image = image
        name = Path("the result")
        self.reader = Reader(name, in_memory(temporary_name(name), image))
        self.file = self.reader.file

    @cached_property
    def path(self) -> Path:
        """A temporary file."""
        path = temporary_file()
        path.write_bytes(self.image)
        weakref.finalize(self, shutil.rmtree, path.parent, ignore_errors=True)
        return path

    def save(self, path: str | Path) -> Path:
        """Write the file, see `Result.save`."""
        path = Path(path)
        check_result(path)
        with replacing(path) as temporary:
            temporary.write_bytes(self.image)
        return path


def temporary_file() -> Path:
    """A place for the file of a run without one, in a folder of its own."""
    return Path(tempfile.mkdtemp(prefix="clearance-")) / "run.h5"


def extra(package: str):
    """A package of the extra xarray. Raises ImportError stating how it is installed."""
    try:
        return importlib.import_module(package)
    except ImportError:
        raise ImportError(f"{package} is not installed: pip install 'clearance[xarray]'") from None


def _extremes_of_format_1(reader: Reader) -> Extremes:
    """Extremes of step ends, which were attributes of each channel and joint."""
    ends = {"lowest": "_min", "highest": "_max", "force_highest": "/force_max"}
    groups = [
        f"{kind}/{name}"
        for kind in ("bodies", "joints", "springs", "drives")
        for name in reader.names(kind)
    ]
    columns, units = {}, {}
    for place in [
        *groups,
        *(f"{group}/{name}" for group in groups for name in reader.names(group)),
    ]:
        about = reader.attributes(place)
        for attribute in ends.keys() & about.keys():
            columns[place + ends[attribute]] = about[attribute]
            units[place + ends[attribute]] = str(about.get("units", "N"))
    values = np.array(list(columns.values()), dtype=float).T.reshape(-1, len(columns))
    length = float(reader.attribute("", "stretch_s"))
    return Extremes(
        length, tuple(columns), tuple(units.values()), values, np.full(values.shape, np.nan)
    )


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


def open_result(path: str | Path) -> Result:
    """Open a result file. Raises FileNotFoundError or ValueError with a clear reason."""
    return Result(path)
