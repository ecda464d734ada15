"""The result file: one HDF5 file a run, written as the run goes, complete or honestly partial.

Layout (SI units; every dataset has `units` and `long_name`): /time, /bodies, /joints, /springs, /drives, /energy
along time; /events with one row per contact; /solver with one row per step. Times are dimension scales, so that
xarray opens each group.
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
from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path

import h5py
import numpy as np

from clearance.extremes import ROUNDING, Extreme, Extremes, better
from clearance.locks import Lock

LOG = logging.getLogger("clearance.files")
FORMAT = "clearance-result"
FORMAT_VERSION = 1
PACKAGES = ("clearance", "numpy", "numba", "h5py")
_count = itertools.count()


def provenance() -> dict:
    """Format, versions of what made a file, and when (UTC); attributes of every file."""
    versions = {}
    for package in PACKAGES:
        try:
            versions[f"version_{package}"] = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            versions[f"version_{package}"] = "not installed"
    return {
        "format": FORMAT,
        "format_version": FORMAT_VERSION,
        "created": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "version_python": platform.python_version(),
        **versions,
    }


def check_replaceable(path: Path) -> None:
    """A file may take this name. Raises ValueError for a device, a pipe or a socket, which would be lost."""
    if path.exists() and not path.is_file() and not path.is_dir():
        raise ValueError(f"{path} is a device, a pipe or a socket; give the name of a file")


def temporary_name(path: Path) -> Path:
    """A name beside a file that no other writer of it uses."""
    return path.with_name(f"{path.name}.{os.getpid()}.{next(_count)}.partial")


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A temporary name to write to; what is there at the end becomes `path`, whole or not at all.

    Raises ValueError as `check_replaceable` does.
    """
    check_replaceable(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = temporary_name(path)
    try:
        yield temporary
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


@contextmanager
def locked(folder: Path, doing: str) -> Iterator[None]:
    """One process at a time in a folder, where the system has file locks; they end with the process that holds them.

    doing: what the other one is doing, for the message. Raises ValueError where the folder is in use.
    """
    with Lock(folder / "lock", f"{folder} is in use: another process is {doing}") as lock:
        if not lock.held:
            LOG.warning("this file system has no locks: see that nobody else uses %s", folder)
        yield


#: name of a column -> (units, what it is, values)
Table = dict[str, tuple[str, str, np.ndarray]]


def save_tables(path: str | Path, kind: str, attributes: dict, tables: dict[str, tuple[dict, Table]]) -> Path:
    """Write tables of a study (group -> attributes and columns) into one HDF5 file, whole or not at all."""
    path = Path(path)
    with replacing(path) as temporary, h5py.File(temporary, "w") as file:
        file.attrs.update(provenance() | {"format": kind} | attributes)
        for name, (own, columns) in tables.items():
            group = file.create_group(name, track_order=True)
            group.attrs.update(own)
            for column, (units, what, values) in columns.items():
                text = np.asarray(values).dtype.kind in "UO"
                kept = np.asarray(values, dtype=object) if text else values
                data = group.create_dataset(column, data=kept, dtype=h5py.string_dtype() if text else None)
                data.attrs["units"], data.attrs["long_name"] = units, what
    return path


class Channels:
    """The channels of one group as attributes: `.ax`, and `.force` for the pair of `.force_x` and `.force_y`."""

    def __init__(self, record: "Record", group: str):
        self._record, self._group = record, group

    def __getattr__(self, name: str) -> np.ndarray:
        record, group = self.__dict__["_record"], self.__dict__["_group"]
        known = record.names(group)
        if name == "time":
            return record.time
        if name in known:
            return record.values(f"{group}/{name}")
        if f"{name}_x" in known:
            return np.stack([record.values(f"{group}/{name}_{axis}") for axis in "xy"], axis=-1)
        raise AttributeError(f"{group} has no channel {name!r}; it has {', '.join(known)}")

    def __contains__(self, name: str) -> bool:
        return name in self._record.names(self._group)

    def __dir__(self):
        return [*super().__dir__(), *self._record.names(self._group)]

    def __repr__(self) -> str:
        return f"<channels of {self._group}: {', '.join(self._record.names(self._group))}>"


class Record(ABC):
    """What a run gave, by name: `run["slider"].ax`, `run.joint("B").force`, `run.energy.residual`.

    Subclasses say where it is (in a file, in memory) by `attributes`, `solver`, `warnings`, `events`, `located`,
    `names`, `values`, `facts` and `units`. `located`: extremes that were located as the run went; None where only
    samples were seen.
    """

    attributes: dict
    solver: dict
    warnings: list[str]
    events: dict[str, np.ndarray]
    located: Extremes | None = None

    @abstractmethod
    def names(self, group: str) -> tuple[str, ...]:
        """What is in a group: the joints of "joints", the channels of "joints/B"; () where there is none."""

    @abstractmethod
    def values(self, path: str) -> np.ndarray:
        """A channel by its path, such as "joints/B/gap". Raises KeyError for one the run has not got."""

    @abstractmethod
    def facts(self, group: str) -> dict:
        """What is known of a group as a whole: `facts("joints/B")["peak_force"]`."""

    @abstractmethod
    def units(self, path: str) -> str:
        """SI units of a channel."""

    def __contains__(self, path: str) -> bool:
        group, _, name = path.rpartition("/")
        return name in self.names(group)

    @property
    def time(self) -> np.ndarray:
        """Times of the samples [s], shape (samples,)."""
        return self.values("time")

    @property
    def status(self) -> str:
        """"complete", or "partial: " and why the run ended early."""
        return self.attributes["status"]

    @property
    def complete(self) -> bool:
        """Whether the run came to its end."""
        return self.status == "complete"

    @cached_property
    def scene(self) -> dict:
        """The scene's description, as plain data."""
        return json.loads(self.attributes["scene"])

    @cached_property
    def turn(self) -> float | None:
        """Time of one turn of the drive at constant speed [s]; None where there is none."""
        loads = self.scene["loads"]
        speeds = [d["speed"] for d in loads if d["type"] == "Drive" and d.get("speed") and _turns(d["target"])]
        return 2.0 * np.pi / abs(speeds[0]) if speeds else None

    @property
    def clearances(self) -> dict[str, float]:
        """Radial clearance [m] of each clearance joint whose channels were kept."""
        joints = {j["name"]: j.get("clearance") for j in self.scene["joints"]}
        return {n: joints[n] for n in self.names("joints") if joints[n] is not None}

    def range(self, path: str) -> tuple[float, float]:
        """Smallest and largest sample of a channel, such as "joints/B/gap"."""
        values = self.values(path)
        return float(values.min()), float(values.max())

    def extreme(self, name: str, begin: float = 0.0, end: float = math.inf) -> Extreme:
        """Smallest or largest value of a quantity between two times [s], and its time.

        name: path of a channel, or of a vector for its size, and the end: "joints/B/gap_min", "joints/B/force_max".
        Located to the tolerance of the run in its stretches (turns, mostly) that lie whole between the times, for
        gaps, film pressures, friction and forces of joints, efforts of drives and accelerations along guides; of the
        samples elsewhere. Raises KeyError for a channel the run has not got.
        """
        path, _, which = name.rpartition("_")
        if which not in ("min", "max"):
            raise KeyError(f"{name!r}: the name of an extreme is that of a channel and _min or _max")
        seen = self.located.of(name, begin, end) if self.located and name in self.located else None
        return better(name, [self._of_samples(path, which, begin, end), seen])

    def _of_samples(self, path: str, which: str, begin: float, end: float) -> Extreme | None:
        time, inside = self.time, self._between(begin, end)
        if not inside.any():
            return None
        values = self._sizes(path)[inside]
        i = int(values.argmin() if which == "min" else values.argmax())
        return Extreme(float(values[i]), float(time[inside][i]))

    def _sizes(self, path: str) -> np.ndarray:
        """Samples of a channel, or sizes of a vector's."""
        if path in self or f"{path}_x" not in self:
            return self.values(path)
        return np.hypot(self.values(f"{path}_x"), self.values(f"{path}_y"))

    def extremes(self, path: str, begin: float = 0.0, end: float = math.inf) -> tuple[float, float]:
        """Smallest and largest value of a channel between two times [s], as `extreme` gives them."""
        return self.extreme(f"{path}_min", begin, end).value, self.extreme(f"{path}_max", begin, end).value

    def largest_force(self, joint: str, begin: float = 0.0, end: float = math.inf) -> float:
        """Largest force in a joint [N] between two times [s], as `extreme` gives it."""
        return self.extreme(f"joints/{joint}/force_max", begin, end).value

    def _between(self, begin: float, end: float) -> np.ndarray:
        """Which samples lie between two times [s]."""
        time = self.time
        return (time >= begin * (1.0 - ROUNDING)) & (time <= end * (1.0 + ROUNDING))

    def _channels(self, kind: str, name: str) -> Channels:
        if name not in self.names(kind):
            raise KeyError(f"no {name!r} among {kind}; there are: {', '.join(self.names(kind)) or 'none'}")
        return Channels(self, f"{kind}/{name}")

    def __getitem__(self, body: str) -> Channels:
        return self._channels("bodies", body)

    def joint(self, name: str) -> Channels:
        """Channels of a joint: `joint("B").eccentricity`, `.force`. Raises KeyError for a joint there is not."""
        return self._channels("joints", name)

    def drive(self, name: str) -> Channels:
        """Channels of a drive: `drive("crank").torque`, `.power`. Raises KeyError for a drive there is not."""
        return self._channels("drives", name)

    @property
    def energy(self) -> Channels:
        """The energy ledger [J]: kinetic, potential, input, dissipated, residual; where it was kept."""
        return Channels(self, "energy")


class Result(Record):
    """A result file, read lazily."""

    def __init__(self, path: str | Path):
        self.path = Path(path)
        self.file = open_checked(self.path, "clearance result", FORMAT, FORMAT_VERSION)

    def names(self, group: str) -> tuple[str, ...]:
        found = self.file.get(group) if group else self.file
        return tuple(n for n in found if n != "time" or not group) if isinstance(found, h5py.Group) else ()

    def values(self, path: str) -> np.ndarray:
        if not isinstance(self.file.get(path), h5py.Dataset):
            raise KeyError(f"{self.path.name} has no channel {path!r}; it may not have been kept when it was written")
        return self.file[path][()]

    def facts(self, group: str) -> dict:
        return dict(self.file[group].attrs) if group in self.file else {}

    def units(self, path: str) -> str:
        return str(self.file[path].attrs["units"])

    @property
    def attributes(self) -> dict:
        """Provenance: format, versions, scene JSON, kernel source, status."""
        return dict(self.file.attrs)

    @property
    def solver(self) -> dict:
        """Method, tolerances, counts and wall time of the run."""
        return dict(self.file["solver"].attrs)

    @property
    def warnings(self) -> list[str]:
        """What the run wants its reader to know, joint by joint."""
        return [str(w) for w in self.file.attrs["warnings"]]

    def range(self, path: str) -> tuple[float, float]:
        """Smallest and largest sample of a channel, without reading it."""
        low, high = self.file[path].attrs["actual_range"]
        return float(low), float(high)

    @cached_property
    def located(self) -> Extremes | None:
        """Extremes that were located as the run went; of files of format 1 those of step ends, without their times."""
        if "stretch_s" in self.file.attrs:
            return _extremes_of_format_1(self.file)
        if "extremes" not in self.file:
            return None
        group = self.file["extremes"]
        names, units = (tuple(group[n].asstr()[()]) for n in ("quantity", "units_of"))
        return Extremes(float(group.attrs["stretch_s"]), names, units, group["value"][()], group["when"][()])

    @property
    def events(self) -> dict[str, np.ndarray]:
        """The impact table: one entry per column, one row per contact."""
        columns = {name: data[()] for name, data in self.file["events"].items()}
        return {k: v.astype(str) if v.dtype == object else v for k, v in columns.items()}

    def save(self, path: str | Path) -> Path:
        """Copy the file to `path`, under a temporary name until it is whole."""
        path = Path(path)
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
        return f"<Result {self.path.name}: {self.file['time'].shape[0]} samples, {self.status}>"


def _extremes_of_format_1(file: h5py.File) -> Extremes:
    """Extremes of step ends, which were attributes of each channel and joint."""
    columns, units = {}, {}
    ends = {"lowest": "_min", "highest": "_max", "force_highest": "/force_max"}

    def take(path: str, item) -> None:
        for attribute in ends.keys() & item.attrs.keys():
            name = path + ends[attribute]
            columns[name], units[name] = item.attrs[attribute], item.attrs.get("units", "N")

    file.visititems(take)
    values = np.array(list(columns.values())).T.reshape(-1, len(columns))
    times = np.full(values.shape, np.nan)
    return Extremes(float(file.attrs["stretch_s"]), tuple(columns), tuple(units.values()), values, times)


def _turns(target: str | dict) -> bool:
    """Whether a drive turns its target, the name of a body or a joint, rather than pushing a slide."""
    return isinstance(target, str) or target["type"] != "Prismatic"


class NewerFormat(ValueError):
    """A file that a newer version of clearance wrote."""


def open_checked(path: Path, kind: str, form: str, version: int) -> h5py.File:
    """Open an HDF5 file of ours. Raises FileNotFoundError, or ValueError for other, broken or newer files."""
    if not path.exists():
        raise FileNotFoundError(f"no {kind.split()[-1]} file {path}")
    try:
        file = h5py.File(path, "r")
    except OSError as error:
        raise ValueError(f"{path} is not a readable HDF5 file: {error}") from None
    found = file.attrs.get("format")
    if found != form:
        file.close()
        raise ValueError(f"{path} is not a {kind} (format {found!r})")
    if (newer := file.attrs["format_version"]) > version:
        file.close()
        raise NewerFormat(f"{path} was written by a newer clearance (format {newer}; this one reads up to {version})")
    return file


def open_result(path: str | Path) -> Result:
    """Open a result file. Raises FileNotFoundError or ValueError with a clear reason."""
    return Result(path)
