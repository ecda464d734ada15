"""HDF5 files of named columns: made, appended to, held in memory; who made them.

Tables of a result file are declared once: located extremes, integrals, stated errors, fields.
"""

import datetime
import io
import json
import platform
import shutil
import sys
import time
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import h5py
import numpy as np

from clearance.files.locks import replace_file, replacing
from clearance.files.texts import CHECK
from clearance.results.errors import Error, Errors, ExtremeErrors
from clearance.results.extremes import Extremes, Integrals
from clearance.results.reading import Damaged, Reader, checked, column_check
from clearance.version import VERSION

FORMAT = "clearance-result"
FORMAT_VERSION = 2
#: whose versions stand in a file beside our own
PACKAGES = ("numpy", "numba", "h5py")
#: of HDF5: from 1.8 (2008) on, what describes the columns has checksums, too
LIBVER = ("v108", "v108")
COMPACT = 1024  # attributes of a group that stand in its header, at most


def provenance(moment: float | None = None) -> dict:
    """Format, versions of what made a file, and when (UTC); attributes of every file.

    moment: seconds of `time.time`, default now.
    """
    moment = time.time() if moment is None else moment
    when = datetime.datetime.fromtimestamp(moment, datetime.UTC)
    return {
        "format": FORMAT,
        "format_version": FORMAT_VERSION,
        "created": when.isoformat(timespec="seconds"),
        "version_python": platform.python_version(),
        "version_clearance": VERSION,
        **_versions(),
    }


@cache
def _versions() -> dict[str, str]:
    """Versions of the packages, looked up once a process."""
    return {f"version_{package}": _version(package) for package in PACKAGES}


def _version(package: str) -> str:
    if package in sys.modules:
        return sys.modules[package].__version__
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


def check_result(path: Path) -> None:
    """A result may replace the file of this name.

    Raises ValueError for a file that is not HDF5, such as a scene file.
    """
    if path.is_file() and path.stat().st_size and not h5py.is_hdf5(path):
        reason = "is there already and is no result file"
        raise ValueError(f"{path} {reason}; give another name to the result")


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
    path: str | Path,
    kind: str,
    attributes: dict,
    tables: dict[str, tuple[dict, Table]],
    dated: bool = True,
) -> Path:
    """Write tables of a study (group -> attributes and columns) into one HDF5 file, completely or
    not at all; not dated it has the same bytes each day.
    """
    path, about = Path(path), provenance() | {"format": kind} | attributes
    if not dated:
        del about["created"]
    content = io.BytesIO()
    with in_memory(content, dated) as file:
        file.attrs.update(checked(about))
        for name, (length, columns) in tables.items():
            write_table(file, name, length, columns)
    replace_file(path, content.getvalue())
    return path


def columns_of(rows: Sequence, about: Mapping[str, tuple[str, str]]) -> Table:
    """Columns from attributes of rows; about: units of each, and what it is."""
    return {n: (*texts, np.array([getattr(row, n) for row in rows])) for n, texts in about.items()}


def write_table(file: h5py.File, path: str, about: dict, columns: Table) -> None:
    """Add a group with its attributes and columns."""
    group = file.create_group(path, track_order=True)
    group.attrs.update(checked(about))
    for column, (units, text, values) in columns.items():
        create_column(group, column, np.asarray(values), units, text)


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


def in_memory(content: io.BytesIO, dated: bool = True) -> h5py.File:
    """An HDF5 file whose bytes are made in memory: on a full disk HDF5 can neither write one nor
    let go of it.

    dated: it has the time at which it was made.
    """
    access = h5py.h5p.create(h5py.h5p.FILE_ACCESS)
    access.set_fileobj_driver(h5py.h5fd.fileobj_driver, content)
    access.set_libver_bounds(h5py.h5f.LIBVER_V18, h5py.h5f.LIBVER_V18)
    root = h5py.h5p.create(h5py.h5p.FILE_CREATE)
    root.set_attr_phase_change(COMPACT, 0)
    root.set_obj_track_times(dated)
    name = repr(content).encode()
    return h5py.File(h5py.h5f.create(name, h5py.h5f.ACC_TRUNC, root, access))


def reopened(content: io.BytesIO) -> h5py.File:
    """Such a file, opened again."""
    return h5py.File(content, "r+", libver=LIBVER)


def compact_groups(file: h5py.File, paths: Iterable[str]) -> None:
    """Make groups, with those above them, whose attributes stand in their headers."""
    properties = h5py.h5p.create(h5py.h5p.GROUP_CREATE)
    properties.set_attr_phase_change(COMPACT, 0)
    for path in dict.fromkeys(paths):
        parts = path.split("/")
        for group in ("/".join(parts[:i]) for i in range(1, len(parts) + 1)):
            if group and group not in file:
                h5py.h5g.create(file.id, group.encode(), gcpl=properties)


NUMBERS, WHOLE, TEXTS = "f", "i", "U"  # kinds of columns


@dataclass(frozen=True)
class Column:
    """A column of a table: its units and what it is.

    along: names of the columns that are the scales of its axes; none of a scale itself. kind: of
    its values, as numpy has it.
    """

    units: str
    text: str
    along: tuple[str, ...] = ()
    kind: str = NUMBERS


def texts(text: str, *along: str) -> Column:
    """A column of texts."""
    return Column("1", text, along, TEXTS)


class TableLayout(dict[str, Column]):
    """Columns of a table by name; a scale is of one axis, its own."""

    def axes(self, name: str) -> tuple[str, ...]:
        """Scales of the axes of a column."""
        return self[name].along or (name,)

    def read(self, reader: Reader, path: str, names: Iterable[str] = ()) -> dict[str, np.ndarray]:
        """Columns in a group of a file, all or some; their scales must be among them.

        Raises Damaged for a column of another kind, or one that does not fit its scales.
        """
        columns = {name: reader.column(f"{path}/{name}") for name in names or self}
        for name, values in columns.items():
            if values.dtype.kind != self[name].kind:
                raise Damaged(f"{reader.path}: /{path}/{name} is a column of another kind")
            if values.shape != tuple(columns[scale].size for scale in self.axes(name)):
                raise Damaged(f"{reader.path}: /{path}/{name} does not fit its table")
        return columns


@dataclass(frozen=True)
class Group:
    """Tables that stand in one group of a file.

    layout: of its columns; columns: by name; attributes: of the group.
    """

    layout: TableLayout = field(default_factory=TableLayout)
    columns: Mapping[str, np.ndarray] = field(default_factory=dict)
    attributes: Mapping[str, object] = field(default_factory=dict)

    @property
    def about(self) -> dict[str, tuple[str, str]]:
        """Units of each column and what it is."""
        return {name: (self.layout[name].units, self.layout[name].text) for name in self.columns}

    def write(self, file: h5py.File, path: str) -> None:
        """Add it to a file, whose group may be there already."""
        group = file.require_group(path) if path else file
        for name, values in self.columns.items():
            create_column(group, name, values, *self.about[name])
        for name in self.columns:
            if not self.layout[name].along:
                group[name].make_scale(name)
        for name in self.columns:
            for axis, scale in enumerate(self.layout[name].along):
                group[name].dims[axis].attach_scale(group[scale])
        group.attrs.update(checked(self.attributes))

    def joined(self, group: "Group") -> "Group":
        """Both in one."""
        return Group(
            TableLayout(self.layout | group.layout),
            {**self.columns, **group.columns},
            {**self.attributes, **group.attributes},
        )

    def variables(self) -> dict[str, tuple]:
        """Its columns as xarray takes them: axes, values, attributes."""
        return {
            name: (
                self.layout.axes(name),
                values,
                dict(zip(("units", "long_name"), self.about[name], strict=True)),
            )
            for name, values in self.columns.items()
        }


def texts_of(values: Iterable[str]) -> np.ndarray:
    """A column of texts."""
    return np.array(list(values), dtype=str)


OF_EXTREMES = ("stretch", "quantity")
EXTREMES = TableLayout(
    quantity=texts("quantity: path of a channel, or of a vector, and its end"),
    units_of=texts("units of each quantity", "quantity"),
    stretch=Column("s", "start of each stretch of the run"),
    value=Column(
        "1",
        "smallest (_min) or largest (_max) value in each stretch, in units_of",
        OF_EXTREMES,
    ),
    when=Column("s", "time of each value", OF_EXTREMES),
    stated=Column("1", "stated error of each value by the integration, in units_of", OF_EXTREMES),
    film=Column(
        "1",
        "change of each value by the largest error of the film tables, in units_of",
        OF_EXTREMES,
    ),
)
#: its columns in a run without stated errors, and those of the errors
LOCATED, OF_ERRORS = list(EXTREMES)[:5], list(EXTREMES)[5:]


def extremes_group(extremes: Extremes) -> Group:
    """The group /extremes: values and their times over the stretches of the run and the
    quantities.
    """
    columns = {
        "quantity": texts_of(extremes.names),
        "units_of": texts_of(extremes.units),
        "stretch": extremes.length * np.arange(len(extremes.values)),
        "value": extremes.values,
        "when": extremes.times,
    }
    return Group(EXTREMES, columns, {"stretch_s": extremes.length})


INTEGRALS = TableLayout(
    integral=texts("integrand: path of a channel, or of a vector, and _square or _positive"),
    integral_units=texts("units of each integral", "integral"),
    part_end=Column("s", "end of each part of the run; the first begins with the run"),
    amount=Column("1", "integral over each part, in integral_units", ("part_end", "integral")),
)


def integrals_group(integrals: Integrals) -> Group:
    """The group /integrals: amounts over the parts of the run and the integrands."""
    columns = {
        "integral": texts_of(integrals.names),
        "integral_units": texts_of(integrals.units),
        "part_end": integrals.ends,
        "amount": integrals.values,
    }
    return Group(INTEGRALS, columns)


def integrals_of(reader: Reader) -> Integrals:
    """The integrals of a file."""
    names, units, ends, values = INTEGRALS.read(reader, "integrals").values()
    return Integrals(tuple(map(str, names)), tuple(map(str, units)), ends, values)


#: stated errors; those of extremes stand in /extremes
ERRORS = TableLayout(
    name=texts("name of a metric, of a located extreme, or trajectory (over the clearance)"),
    units_of=texts("units of value, stated and film", "name"),
    kind=texts("way in which the error was found", "name"),
    channel=texts("path of a channel"),
    share=Column(
        "1",
        "three times the largest difference of a channel from the companion over its range",
        ("channel",),
    ),
    value=Column("1", "value of the run, in units_of", ("name",)),
    stated=Column("1", "stated error of the integration, in units_of", ("name",)),
    film=Column("1", "change by the largest error of the film tables, in units_of", ("name",)),
)


def error_groups(errors: Errors) -> dict[str, Group]:
    """The group /errors, and errors of the located extremes in /extremes; with nothing but the
    reason, in attributes of the file, where nothing is stated.
    """
    if errors.reason:
        return {"": Group(attributes={"errors_left_out": errors.reason})}
    rows = errors.rows.values()
    columns = {
        "name": texts_of(errors.rows),
        "units_of": texts_of(e.units for e in rows),
        "kind": texts_of(e.kind for e in rows),
        "channel": texts_of(errors.channels),
        "share": np.array(list(errors.channels.values()), dtype=float),
    }
    columns |= {n: np.array([getattr(e, n) for e in rows]) for n in ("value", "stated", "film")}
    rtol, companion_rtol = errors.rtol
    about = {
        "rtol": rtol,
        "companion_rtol": companion_rtol,
        "spread": errors.spread,
        "begin_s": errors.begin,
        "end_s": errors.end,
    }
    if errors.asked:
        about |= {"asked": json.dumps(dict(errors.asked)), "cannot": errors.cannot}
    of_extremes = {name: getattr(errors.extremes, name) for name in OF_ERRORS}
    return {"errors": Group(ERRORS, columns, about), "extremes": Group(EXTREMES, of_extremes)}


def errors_of(reader: Reader, of_extremes: ExtremeErrors | None) -> Errors:
    """The stated errors of a file."""
    table = {n: values.tolist() for n, values in ERRORS.read(reader, "errors").items()}
    about = reader.attributes("errors")
    rows = zip(*(table[n] for n in ("value", "stated", "units_of", "kind", "film")), strict=True)
    return Errors(
        dict(zip(table["name"], (Error(*row) for row in rows), strict=True)),
        dict(zip(table["channel"], table["share"], strict=True)),
        "",
        (float(about["rtol"]), float(about["companion_rtol"])),
        float(about["spread"]),
        float(about["begin_s"]),
        float(about["end_s"]),
        of_extremes,
        json.loads(about.get("asked", "{}")),
        about.get("cannot", ""),
    )


OF_FIELDS = ("instant", "axial", "angle")
#: pressure fields of the film of a joint
FIELDS_OF_PRESSURE = TableLayout(
    instant=Column("1", "place of the sample in /time", (), WHOLE),
    axial=Column("m", "axial position from the middle of the bearing"),
    angle=Column("rad", "angle on the bearing from its body's own x axis"),
    time=Column("s", "time of the field", OF_FIELDS[:1]),
    line_of_centres=Column("rad", "angle of the thinnest film on the bearing", OF_FIELDS[:1]),
    eccentricity_ratio=Column("1", "eccentricity over clearance", OF_FIELDS[:1]),
    pressure=Column("Pa", "film pressure above ambient", OF_FIELDS),
    content=Column("1", "share of the gap that holds oil", OF_FIELDS),
)
