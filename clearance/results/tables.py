"""HDF5 files of named columns: made, appended to, held in memory; who made them."""

import datetime
import importlib.metadata
import os
import platform
import shutil
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import h5py
import numpy as np

from clearance.files.replacing import replacing
from clearance.results.hdf5_image import CHECK, readable
from clearance.results.reading import checked, column_check
from clearance.version import VERSION

FORMAT = "clearance-result"
FORMAT_VERSION = 2
#: whose versions stand in a file beside our own
PACKAGES = ("numpy", "numba", "h5py")
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


def in_memory(path: Path, image: bytes | None = None, dated: bool = True) -> h5py.File:
    """An HDF5 file that is made in memory: on a full disk HDF5 can neither write one nor let go of
    it.

    image: of another one, to go on with; dated: it has the time at which it was made.
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
    root.set_obj_track_times(dated)
    return h5py.File(h5py.h5f.create(name, h5py.h5f.ACC_TRUNC, root, access))


def compact_groups(file: h5py.File, paths: Iterable[str]) -> None:
    """Make groups, with those above them, whose attributes stand in their headers."""
    properties = h5py.h5p.create(h5py.h5p.GROUP_CREATE)
    properties.set_attr_phase_change(COMPACT, 0)
    for path in dict.fromkeys(paths):
        parts = path.split("/")
        for group in ("/".join(parts[:i]) for i in range(1, len(parts) + 1)):
            if group and group not in file:
                h5py.h5g.create(file.id, group.encode(), gcpl=properties)


def image_of(file: h5py.File) -> bytes:
    """The bytes of a file that is made in memory."""
    file.flush()
    return readable(file.id.get_file_image())
