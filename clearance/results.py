"""The result file: one HDF5 file a run, written as the run goes, complete or honestly partial.

Layout (SI units; every dataset has `units` and `long_name`): /time, /bodies, /joints, /springs, /drives, /energy
along time; /events with one row per contact; /solver with one row per step. Times are dimension scales, so that
xarray opens each group.
"""

import datetime
import importlib.metadata
import json
import os
import platform
import shutil
from functools import cached_property
from pathlib import Path

import h5py
import numpy as np

from clearance.regimes import Regime, regime

FORMAT = "clearance-result"
FORMAT_VERSION = 1
CHUNK = 2048  # rows
PACKAGES = ("clearance", "numpy", "numba", "h5py")

EVENT_COLUMNS = {
    "time": ("s", "start of the contact"),
    "impact_speed": ("m/s", "penetration rate at the start"),
    "peak_force": ("N", "largest normal contact force"),
    "peak_penetration": ("m", "largest penetration"),
    "duration": ("s", "duration of the contact"),
    "separation_speed": ("m/s", "speed of separation at the end"),
}
SOLVER_COLUMNS = {
    "time": ("s", "end of the step"),
    "step": ("s", "step size"),
    "error_estimate": ("1", "estimated local error over tolerance"),
}


class ResultWriter:
    """Writes a run into `<path>.partial` and gives it its final name when the run has ended."""

    def __init__(self, path: Path, channels: list, attributes: dict):
        self.path = Path(path)
        if self.path.is_dir():
            raise ValueError(f"result file {self.path} is a directory; give the name of a file")
        self.partial = self.path.with_name(self.path.name + ".partial")
        self.path.parent.mkdir(parents=True, exist_ok=True)
        # columns stay open, each with a chunk cache: a small one, for rows are only appended
        self.file = h5py.File(self.partial, "w", rdcc_nbytes=2 * CHUNK * 8)
        self.file.attrs.update(_provenance() | attributes | {"status": "partial: still running"})
        self.channels = channels
        self.angles = [
            (i, next(j for j, d in enumerate(channels) if d.path == c.path.replace("theta", "omega")))
            for i, c in enumerate(channels)
            if c.wrapped
        ]
        self.balance = next((i for i, c in enumerate(channels) if c.path == "energy/residual"), None)
        self.last: tuple[float, np.ndarray] | None = None
        self.zero = 0.0
        self.low, self.high = np.full(len(channels), np.inf), np.full(len(channels), -np.inf)
        self.totals, self.rows = np.zeros(len(channels)), 0
        self.peaks: dict[str, float] = {}  # largest force by joint, of samples and contacts
        self.depths: dict[str, float] = {}  # largest penetration by joint, of its contacts
        self.turned_over = 0.0
        self.ledger: LedgerWatch | None = None
        places = {c.path: i for i, c in enumerate(channels)}
        self.work = [places[p] for p in ("energy/input", "energy/dissipated") if p in places]
        if self.balance is not None:
            self.ledger = LedgerWatch([places["energy/kinetic"], *self.work], self.balance)
        self._create()

    def _create(self) -> None:
        scale = _dataset(self.file, "time", "s", "time")
        scale.make_scale("time")
        self.columns = [_dataset(self.file, c.path, c.units, c.long_name) for c in self.channels]  # kept open
        for column in self.columns:
            column.dims[0].attach_scale(scale)
            group = column.parent
            if "time" not in group:
                group["time"] = scale  # the same dataset under a second name: each group opens with its times
        for group, columns in (("events", EVENT_COLUMNS), ("solver", SOLVER_COLUMNS)):
            for name, (units, what) in columns.items():
                _dataset(self.file, f"{group}/{name}", units, what)
            own = self.file[f"{group}/time"]
            own.make_scale("time")
            for name in list(columns)[1:]:
                self.file[f"{group}/{name}"].dims[0].attach_scale(own)
        for name, what in (("joint", "joint in contact"), ("kind", "contact, or open_contact: not over at the end")):
            text = _dataset(self.file, f"events/{name}", "1", what, h5py.string_dtype())
            text.dims[0].attach_scale(self.file["events/time"])

    def samples(self, times: np.ndarray, rows: np.ndarray) -> None:
        """Append output rows; angles are made continuous with the help of the angular velocities."""
        if not times.size:
            return
        rows = rows.copy()
        self._unwrap(times, rows)
        if self.balance is not None:
            if self.last is None:
                self.zero = rows[0, self.balance]
            rows[:, self.balance] -= self.zero
        self._summarise(rows)
        if self.ledger:
            self.ledger.add(times, rows)
        self.last = (times[-1], rows[-1].copy())
        _append(self.file["time"], times)
        for i, column in enumerate(self.columns):
            _append(column, rows[:, i])

    def _summarise(self, rows: np.ndarray) -> None:
        """Ranges of all channels, peak joint forces, energy turned over: for summaries without reading the file."""
        self.low, self.high = np.minimum(self.low, rows.min(axis=0)), np.maximum(self.high, rows.max(axis=0))
        self.totals, self.rows = self.totals + rows.sum(axis=0), self.rows + len(rows)
        for i, c in enumerate(self.channels):
            if c.path.endswith("/force_x"):
                group = c.path.rpartition("/")[0]
                peak = float(np.hypot(rows[:, i], rows[:, i + 1]).max())
                self.peaks[group] = max(self.peaks.get(group, 0.0), peak)
            elif c.path == "energy/kinetic":
                before = [] if self.last is None else [self.last[1][i]]
                self.turned_over += float(np.abs(np.diff(np.concatenate([before, rows[:, i]]))).sum())

    def _unwrap(self, times: np.ndarray, rows: np.ndarray) -> None:
        for angle, speed in self.angles:
            if self.last is None:
                values, speeds, at = rows[:, angle], rows[:, speed], times
            else:
                values = np.concatenate([[self.last[1][angle]], rows[:, angle]])
                speeds = np.concatenate([[self.last[1][speed]], rows[:, speed]])
                at = np.concatenate([[self.last[0]], times])
            expected = np.diff(at) * 0.5 * (speeds[1:] + speeds[:-1])
            turns = np.round((np.diff(values) - expected) / (2.0 * np.pi))
            whole = np.concatenate([[0.0], np.cumsum(turns)]) * 2.0 * np.pi
            rows[:, angle] = (values - whole)[-len(times) :]

    def impacts(self, names: list[str], rows: np.ndarray, kind: str = "contact") -> None:
        """Append finished contacts: rows of (joint, time, impact speed, force, penetration, duration, separation)."""
        if not len(rows):
            return
        for column, name in enumerate(EVENT_COLUMNS, 1):
            _append(self.file[f"events/{name}"], rows[:, column])
        for j, force, depth in rows[:, (0, 3, 4)]:
            group = f"joints/{names[int(j)]}"
            self.peaks[group] = max(self.peaks.get(group, 0.0), force)
            self.depths[group] = max(self.depths.get(group, 0.0), depth)
        _append(self.file["events/joint"], [names[int(j)] for j in rows[:, 0]])
        _append(self.file["events/kind"], [kind] * len(rows))

    def steps(self, log: np.ndarray) -> None:
        for column, name in enumerate(SOLVER_COLUMNS):
            _append(self.file[f"solver/{name}"], log[:, column])

    def flush(self) -> None:
        self.file.flush()

    def lowest(self, path: str) -> float:
        """Smallest value of a channel so far."""
        return float(self.low[next(i for i, c in enumerate(self.channels) if c.path == path)])

    def highest(self, path: str) -> float:
        """Largest value of a channel so far."""
        return float(self.high[next(i for i, c in enumerate(self.channels) if c.path == path)])

    def regime(self, joint) -> Regime:
        """Diagnostics of a lubricated joint; they also become attributes of its group."""
        group = f"joints/{joint.name}"
        found = regime(joint, self.highest(f"{group}/film_pressure"), self.lowest(f"{group}/gap"))
        for name, value in vars(found).items():
            if value is not None:
                self.file[group].attrs[name] = value
        means = {f"{group}/membership_{s}": f"share_{s}" for s in ("full_film", "mixed", "dry")}
        means[f"{group}/asperity_share"] = "mean_asperity_share"
        for c, total in zip(self.channels, self.totals, strict=True):
            if c.path in means:
                self.file[group].attrs[means[c.path]] = float(total) / self.rows
        return found

    def residual_share(self) -> float:
        """Largest share of the energy turned over in some stretch of the run that its residual moved by."""
        return max(self.ledger.worst, self.ledger.share()) if self.ledger else 0.0

    def energy_scale(self) -> float:
        """The energy turned over so far: total variation of the kinetic energy, or what went in or was taken out."""
        return max([self.turned_over, *(self.high[i] - self.low[i] for i in self.work)])

    def close(self, status: str, solver: dict, warnings: list[str]) -> None:
        """Finish: state the status and the warnings, give the file its name."""
        self.file.attrs.create("warnings", warnings, dtype=h5py.string_dtype(), shape=(len(warnings),))
        self.file["solver"].attrs.update(solver)
        if self.last is not None:
            for column, low, high in zip(self.columns, self.low, self.high, strict=True):
                column.attrs["actual_range"] = (low, high)
            for group, peak in self.peaks.items():
                self.file[group].attrs["peak_force"] = peak
                if f"{group}/gap" in self.file:
                    depth = self.depths.get(group, -np.inf)
                    self.file[group].attrs["smallest_gap"] = min(self.lowest(f"{group}/gap"), -depth)
            self.file["energy"].attrs["turned_over"] = self.energy_scale()
        self.file.attrs["status"] = status
        self.file.close()
        os.replace(self.partial, self.path)


def _dataset(file, path: str, units: str, what: str, dtype=np.float64):
    data = file.create_dataset(path, (0,), dtype, maxshape=(None,), chunks=(CHUNK,))
    data.attrs["units"], data.attrs["long_name"] = units, what
    return data


def _append(data, values) -> None:
    old = data.shape[0]
    data.resize((old + len(values),))
    data[old:] = values


def _provenance() -> dict:
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


#: name of a column -> (units, what it is, values)
Table = dict[str, tuple[str, str, np.ndarray]]


def save_tables(path: str | Path, kind: str, attributes: dict, tables: dict[str, tuple[dict, Table]]) -> Path:
    """Write tables of a study (group -> attributes and columns) into one HDF5 file, whole or not at all."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f"{path.name}.{os.getpid()}.partial")
    with h5py.File(temporary, "w") as file:
        file.attrs.update(_provenance() | {"format": kind} | attributes)
        for name, (own, columns) in tables.items():
            group = file.create_group(name)
            group.attrs.update(own)
            for column, (units, what, values) in columns.items():
                text = np.asarray(values).dtype.kind in "UO"
                kept = np.asarray(values, dtype=object) if text else values
                data = group.create_dataset(column, data=kept, dtype=h5py.string_dtype() if text else None)
                data.attrs["units"], data.attrs["long_name"] = units, what
    os.replace(temporary, path)
    return path


class LedgerWatch:
    """Watches the energy residual stretch by stretch, so that a jump shows however long the run is.

    A stretch is long enough to turn over the range of the kinetic energy, or in motions that hardly have any (a journal
    sinking in oil) a hundredth of what has been put in and taken out; `worst` is the largest share of it that the
    residual moved by, `since` the first sample where a share above `limit` was passed.
    """

    limit = 0.05
    portion = 0.01  # of all energy put in or taken out so far that a stretch turns over at least

    def __init__(self, work: list[int], balance: int):
        self.work, self.balance = work, balance
        self.worst, self.since = 0.0, None
        self.low, self.high = np.full(len(work), np.inf), np.full(len(work), -np.inf)  # kinetic first
        self.rows: np.ndarray | None = None  # time, residual, then the energies, of the stretch under way

    def add(self, times: np.ndarray, rows: np.ndarray) -> None:
        """Append samples; every stretch in which enough energy has been turned over is judged."""
        self.low = np.minimum(self.low, rows[:, self.work].min(axis=0))
        self.high = np.maximum(self.high, rows[:, self.work].max(axis=0))
        most = self._most()
        new = np.column_stack([times, rows[:, self.balance], rows[:, self.work]])
        self.rows = new if self.rows is None else np.concatenate([self.rows, new])
        while most > 0.0:
            turned_over = self._turned_over()
            if turned_over[-1] < most:
                break
            end = int(np.argmax(turned_over >= most))
            self.worst = max(self.worst, self._share(end + 1, turned_over[end]))
            self.rows = self.rows[end:]

    def _most(self) -> float:
        """Energy that a stretch turns over."""
        span = self.high - self.low
        return max(float(span[0]), self.portion * float(span[1:].max(initial=0.0)))

    def _turned_over(self) -> np.ndarray:
        steps = np.abs(np.diff(self.rows[:, 2:], axis=0, prepend=self.rows[:1, 2:])).sum(axis=1)
        return np.cumsum(steps)

    def _share(self, end: int, scale: float) -> float:
        """Share of the first `end` rows' energy that the residual moved by."""
        moved = np.abs(self.rows[:end, 1] - self.rows[0, 1])
        if self.since is None and moved.max() > self.limit * scale:
            self.since = float(self.rows[np.argmax(moved > self.limit * scale), 0])
        return float(moved.max() / scale)

    def share(self) -> float:
        """Share of the stretch under way, against at least what a stretch turns over."""
        if self.rows is None:
            return 0.0
        scale = max(self._turned_over()[-1], self._most())
        return self._share(len(self.rows), scale) if scale > 0.0 else 0.0


class Channels:
    """The channels of one group as attributes: `.ax`, and `.force` for the pair of `.force_x` and `.force_y`."""

    def __init__(self, record: "Record", group: str):
        self._record, self._group = record, group

    def __getattr__(self, name: str) -> np.ndarray:
        record, group = self.__dict__["_record"], self.__dict__["_group"]
        known = record.names(group)
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


class Record:
    """What a run gave, by name: `run["slider"].ax`, `run.joint("B").force`, `run.energy.residual`.

    Subclasses say where it is (in a file, in memory) by `attributes`, `solver`, `warnings`, `events`, `names`,
    `values`, `facts` and `units`.
    """

    attributes: dict
    solver: dict
    warnings: list[str]
    events: dict[str, np.ndarray]

    def names(self, group: str) -> tuple[str, ...]:
        """What is in a group: the joints of "joints", the channels of "joints/B"; () where there is none."""
        raise NotImplementedError

    def values(self, path: str) -> np.ndarray:
        """A channel by its path, such as "joints/B/gap". Raises KeyError for one the run has not got."""
        raise NotImplementedError

    def facts(self, group: str) -> dict:
        """What is known of a group as a whole: `facts("joints/B")["peak_force"]`."""
        raise NotImplementedError

    def units(self, path: str) -> str:
        raise NotImplementedError

    def __contains__(self, path: str) -> bool:
        group, _, name = path.rpartition("/")
        return name in self.names(group)

    @property
    def time(self) -> np.ndarray:
        return self.values("time")

    @property
    def status(self) -> str:
        return self.attributes["status"]

    @property
    def complete(self) -> bool:
        return self.status == "complete"

    @cached_property
    def scene(self) -> dict:
        """The scene's description, as plain data."""
        return json.loads(self.attributes["scene"])

    @cached_property
    def turn(self) -> float | None:
        """Time of one turn of the drive at constant speed [s]; None where there is none."""
        loads = self.scene["loads"]
        speeds = [d["speed"] for d in loads if d["type"] == "Drive" and d.get("speed") and _turns(self.scene, d)]
        return 2.0 * np.pi / abs(speeds[0]) if speeds else None

    @property
    def clearances(self) -> dict[str, float]:
        """Radial clearance [m] of each clearance joint whose channels were kept."""
        joints = {j["name"]: j.get("clearance") for j in self.scene["joints"]}
        return {n: joints[n] for n in self.names("joints") if joints[n] is not None}

    def range(self, path: str) -> tuple[float, float]:
        """Smallest and largest value of a channel, such as "joints/B/gap"."""
        values = self.values(path)
        return float(values.min()), float(values.max())

    def _channels(self, kind: str, name: str) -> Channels:
        if name not in self.names(kind):
            raise KeyError(f"no {name!r} among {kind}; there are: {', '.join(self.names(kind)) or 'none'}")
        return Channels(self, f"{kind}/{name}")

    def __getitem__(self, body: str) -> Channels:
        return self._channels("bodies", body)

    def joint(self, name: str) -> Channels:
        return self._channels("joints", name)

    def drive(self, name: str) -> Channels:
        return self._channels("drives", name)

    @property
    def energy(self) -> Channels:
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
        """Smallest and largest value of a channel, without reading it."""
        low, high = self.file[path].attrs["actual_range"]
        return float(low), float(high)

    @property
    def events(self) -> dict[str, np.ndarray]:
        """The impact table: one entry per column, one row per contact."""
        columns = {name: data[()] for name, data in self.file["events"].items()}
        return {k: v.astype(str) if v.dtype == object else v for k, v in columns.items()}

    def save(self, path: str | Path) -> Path:
        """Copy the file to `path`, under a temporary name until it is whole."""
        path = Path(path)
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary = path.with_name(f"{path.name}.{os.getpid()}.partial")
        shutil.copyfile(self.path, temporary)
        os.replace(temporary, path)
        return path

    def close(self) -> None:
        self.file.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def __repr__(self) -> str:
        return f"<Result {self.path.name}: {self.file['time'].shape[0]} samples, {self.status}>"


def _turns(scene: dict, drive: dict) -> bool:
    """Whether a drive turns something rather than pushing a slide."""
    joint = next((j for j in scene["joints"] if j["name"] == drive.get("target")), None)
    return joint is None or joint["type"] != "Prismatic"


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
        raise ValueError(f"{path} was written by a newer clearance (format {newer}; this one reads up to {version})")
    return file


def open_result(path: str | Path) -> Result:
    """Open a result file. Raises FileNotFoundError or ValueError with a clear reason."""
    return Result(path)
