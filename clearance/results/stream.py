"""A run in its HDF5 file, written piece by piece as it comes (layout in result.py)."""

import errno
import fnmatch
import io
import os
import re
import shutil
import zlib
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import MappingProxyType

import h5py
import numpy as np

from clearance.files.locks import Lock, check_replaceable, temporary_name
from clearance.files.texts import CHECK
from clearance.results.reading import ABOUT, FACT_UNITS, Reader, checked, column_check
from clearance.results.recorder import CONTACT_KINDS, EVENT_COLUMNS, SOLVER_COLUMNS, Ranges
from clearance.results.result import DIMENSIONS, EVENT_TEXTS, Result
from clearance.results.tables import (
    LIBVER,
    Group,
    appending,
    check_result,
    compact_groups,
    extremes_group,
    in_memory,
    integrals_group,
    provenance,
    reopened,
)
from clearance.values import checks

CHUNK = 2048  # rows
# the form of netCDF
NO_VALUES = f"This is a netCDF dimension but not a netCDF variable. {0:9d}"
FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)  # error numbers of a system that has no room
NODES = 4096  # bytes of the index of a column that a piece may add, beside 64 for each chunk
# bytes that closing a file needs at most: contacts cut off, facts; extremes
CLOSING, CLOSING_COLUMN = 2**18, 2**12
OPENING_COLUMN = 2**12  # bytes of the header of an empty column, with its share of the groups


def matching(channels: Sequence, patterns: Sequence[str] | None) -> list[int]:
    """Places of the channels whose path a pattern fits: "joints/B/*", "bodies/slider/ax", "energy";
    None: all.

    The events are always stored, the log of steps where all is or a pattern is "solver".
    Raises ValueError for a pattern that fits none.
    """
    if patterns is None:
        return list(range(len(channels)))
    if isinstance(patterns, str):
        raise TypeError(f"channels: {LISTED}, got the text {patterns!r}")
    places: set[int] = set()
    for pattern in patterns:
        fits = [i for i, c in enumerate(channels) if fits_path(c.path, pattern)]
        if not fits and not fits_path(STEP_LOG, pattern):
            groups = dict.fromkeys(c.path.rpartition("/")[0] for c in channels)
            raise ValueError(
                f"channels: {pattern!r} fits none; there are {', '.join(f'{g}/*' for g in groups)}"
            )
        places.update(fits)
    return sorted(places)


def spots(channels: Sequence) -> list[str]:
    """Labels of places that touch, as tables of impacts have them: a joint, or its spot as in
    guide/1.
    """
    touching = (re.fullmatch(r"joints/(.+)/contact_force(?:_(.+))?", c.path) for c in channels)
    return ["/".join(filter(None, match.groups())) for match in touching if match]


#: tables that go along a dimension of their own, without values: units of columns, what they are
TABLES = {
    "events": EVENT_COLUMNS | {n: ("1", text) for n, text in EVENT_TEXTS.items()},
    "solver": SOLVER_COLUMNS,
}


def columns_of(channels: Iterable) -> dict[str, tuple[str, str]]:
    """Units of the columns of a run with these channels, and what they are, by path."""
    columns = {"time": ("s", "time")} | {c.path: (c.units, c.long_name) for c in channels}
    for group, table in TABLES.items():
        columns |= {f"{group}/{n}": about for n, about in table.items()}
        columns[f"{group}/{DIMENSIONS[group]}"] = "1", f"dimension of the columns of /{group}"
    return columns


STEP_LOG = "solver/step"
#: what channels are given as
LISTED = 'give a list of paths or patterns, as ["bodies/slider/ax"]'
MOST_IMAGES = 8  # of empty files that a process keeps, some 300 kB each
_images: dict[tuple, bytes] = {}


def fits_path(path: str, pattern: str) -> bool:
    return fnmatch.fnmatchcase(path, pattern) or path.startswith(pattern.rstrip("/") + "/")


class Unwritable(OSError):
    """A run's file cannot take any more, for the reason that the system gives (errno)."""

    def __init__(self, path: Path, number: int):
        super().__init__(number, f"{path} cannot be written: {os.strerror(number)}")

    def __str__(self) -> str:
        return self.strerror


@dataclass(frozen=True)
class Content:
    """Parts of a run that its file has.

    keep: patterns of the channels to keep (default all). compression: gzip level 0 to 9 of all
        columns, 0: none. expected: rows to expect, where they are few.
    """

    channels: list
    attributes: Mapping
    keep: Sequence[str] | None = None
    compression: int = 0
    expected: int = CHUNK

    @cached_property
    def kept(self) -> list[int]:
        """Places of the channels. Raises ValueError for a pattern that fits none."""
        return matching(self.channels, self.keep)

    @property
    def logs(self) -> bool:
        """True where the log of steps is stored."""
        return self.keep is None or any(fits_path(STEP_LOG, p) for p in self.keep)

    @property
    def layout(self) -> dict:
        """Settings of columns. Raises ValueError for what is no gzip level."""
        return filters(self.compression) | {"chunks": (self.rows_in_chunk,)}

    @property
    def rows_in_chunk(self) -> int:
        return min(max(self.expected, 1), CHUNK)


class FinishedFile:
    """The file of a run that has its name."""

    path: Path

    def add(self, groups: Mapping[str, Group]) -> None:
        """Add groups to it; it stays as it was until all are written."""
        with appending(self.path) as file:
            for name, group in groups.items():
                group.write(file, name)

    def store(self) -> None:
        """It has its name already."""

    def result(self) -> Result:
        """It, opened."""
        return Result(self.path)

    def has_room(self, extra: int) -> bool:
        """True where the disk has room for another copy of it with more bytes in it."""
        return shutil.disk_usage(self.path.parent).free >= os.path.getsize(self.path) + extra


class Stream(FinishedFile):
    """Writes a run into `<path>.partial` and gives it its final name when the run has ended.

    alone: somebody else sees to it that nobody else writes this file.
    placed: whether the file has its final name. full: whether the disk refused a piece of the
        record. gone: whether the file could not be stored.

    A write that fails leaves a file that HDF5 can neither mend nor close. The room for each piece,
    and for closing the file after it, is therefore claimed from the system before it is written. A
    piece that does not fit is refused, and the file stays complete. Where a system cannot promise
    room, a write that fails costs the file. All that writes raises Unwritable; after a refusal the
    file can still be closed.
    """

    placed = full = gone = False
    lock: Lock | None = None
    # bytes of the file after the last flush; bytes that its record may have grown by since
    flushed = due = 0

    def __init__(self, path: Path, stored: Content, alone: bool = False):
        self.path = Path(path)
        check_name(self.path)
        self.channels, self.kept = stored.channels, stored.kept
        self.logs, self.layout = stored.logs, stored.layout
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self.partial = self.path.with_name(self.path.name + ".partial")
        if not alone:
            self._lock()
        try:
            self._begin(stored.attributes)
        except BaseException:
            self._release()
            raise

    def _lock(self) -> None:
        """Refuse a second run onto this name.

        Without locks both write files of their own, and the last one stays.
        """
        self.lock = lock_of(self.path)
        if not self.lock.held:
            self.partial = temporary_name(self.path)

    def _release(self) -> None:
        if self.lock is not None:
            self.lock.release()

    def _begin(self, attributes: dict) -> None:
        """Make the file, with the room that it needs to be closed in order."""
        self.closing = CLOSING + CLOSING_COLUMN * len(self.kept)
        about = checked(opening(attributes))
        room = (
            self.closing
            + OPENING_COLUMN * len(self.kept)
            + 2 * sum(len(str(v)) for v in about.values())
        )
        self.file = self._open(room)
        with self._writing():
            self._claim(room)
            self.due = room - self.closing
            self.file.attrs.update(about)
            self._find()

    def _open(self, room: int) -> h5py.File:
        """Columns stay open, each with a chunk cache: a small one, for rows are only appended."""
        self.partial.unlink(missing_ok=True)  # of a run that was killed; never what a link leads to
        with open(self.partial, "xb") as file:
            try:
                _set_aside(file.fileno(), 0, room)
                file.write(self._empty())
            except OSError as error:
                self.partial.unlink()
                raise Unwritable(self.path, error.errno) from None
            file.truncate(len(self._empty()))
        return h5py.File(self.partial, "r+", libver=LIBVER, rdcc_nbytes=2 * CHUNK * 8)

    def _empty(self) -> bytes:
        """A file of these columns without rows, made once: hundreds of things take HDF5 far longer
        than their rows.
        """
        key = (
            tuple(self.channels[i] for i in self.kept),
            *self.layout.items(),
            tuple(spots(self.channels)),
        )
        if key not in _images:
            while len(_images) >= MOST_IMAGES:
                del _images[next(iter(_images))]
            content = io.BytesIO()
            with in_memory(content) as self.file:
                self._create()
            _images[key] = content.getvalue()
        return _images[key]

    def _find(self) -> None:
        """The columns of a file, which stay open."""
        self.checks = Counter[str]()
        self.time = self.file["time"]
        self.columns = [self.file[self.channels[i].path] for i in self.kept]
        self.tables = {g: {n: self.file[f"{g}/{n}"] for n in table} for g, table in TABLES.items()}

    def _claim(self, room: int) -> None:
        """Have so many bytes set aside behind what has been flushed.

        Raises OSError where they are not there.
        """
        _set_aside(self.file.id.get_vfd_handle(), self.flushed, room)

    @contextmanager
    def _writing(self) -> Iterator[None]:
        """Let go of the file where HDF5 could not write, for it will not be able to close it."""
        try:
            yield
        except (OSError, RuntimeError) as error:
            # HDF5 gives the system's reason in words only
            words = re.search(r"errno = (\d+)", str(error))
            number = getattr(error, "errno", None) or (words and int(words[1]))
            if not number:
                raise
            self.abandon()
            raise Unwritable(self.path, number) from None

    def abandon(self) -> None:
        """Close the file and remove it; what comes after is not stored."""
        self.full = self.gone = True
        if self.file:
            self._detach()
        for _ in range(2):  # after a flush that failed the first call may fail too
            with suppress(OSError, RuntimeError):
                self.file.close()
        self.partial.unlink(missing_ok=True)
        self._release()

    def _detach(self) -> None:
        """Send to the null device what HDF5 has still to write: it would try, fail, and crash at
        the process's end.
        """
        null = os.open(os.devnull, os.O_RDWR)
        os.dup2(null, self.file.id.get_vfd_handle(), inheritable=False)
        os.close(null)

    def _rename(self) -> None:
        """Give the complete file its name."""
        with self._writing():
            self.file.flush()
            if hasattr(os, "posix_fallocate"):  # what was claimed for nothing
                os.ftruncate(self.file.id.get_vfd_handle(), self.file.id.get_filesize())
            self.file.close()
        os.replace(self.partial, self.path)
        self.placed = True
        self._release()

    @property
    def remains(self) -> str:
        """Description of the files of a run that ended early."""
        if not self.placed:
            return f"{self.path} was not written"
        return f"what {'fitted' if self.full else 'was computed'} is stored in {self.path}"

    def _create(self) -> None:
        file, channels = self.file, [self.channels[i] for i in self.kept]
        compact_groups(file, [c.path.rpartition("/")[0] for c in channels] + [*DIMENSIONS])
        kinds: dict = {f"{group}/{name}": ">f4" for group, name in DIMENSIONS.items()}
        # texts of one length, for checksums do not cover others
        for name, texts in ("joint", spots(self.channels)), ("kind", CONTACT_KINDS):
            length = max([1, *(len(text.encode()) for text in texts)])
            kinds[f"events/{name}"] = h5py.string_dtype("utf-8", length)
        for path, about in columns_of(channels).items():
            kind = kinds.get(path, np.float64)
            data = file.create_dataset(path, (0,), kind, maxshape=(None,), **self.layout)
            data.attrs.update(zip(ABOUT, about, strict=True))
        scale = file["time"]
        scale.make_scale("time")
        for channel in channels:
            column = file[channel.path]
            column.dims[0].attach_scale(scale)
            if "time" not in column.parent:
                # the same dataset under a second name: each group opens with its times
                column.parent["time"] = scale
        for group, table in TABLES.items():
            dimension = file[f"{group}/{DIMENSIONS[group]}"]
            dimension.make_scale(NO_VALUES)
            for name in table:
                column = file[f"{group}/{name}"]
                column.dims[0].attach_scale(dimension)
                if name != "time":  # which is a coordinate along the dimension
                    column.attrs["coordinates"] = "time"
                if name in EVENT_TEXTS:
                    column.attrs["_Encoding"] = "utf-8"  # for xarray

    def rows(self, times: np.ndarray, rows: np.ndarray) -> None:
        self._append([self.time, *self.columns], [times, *(rows[:, i] for i in self.kept)])

    def impacts(self, joints: list[str], rows: np.ndarray, kind: str) -> None:
        texts = (np.char.encode(t, "utf-8") for t in (joints, [kind] * len(rows)))
        self._append(list(self.tables["events"].values()), [*rows.T[1:], *texts])

    def steps(self, log: np.ndarray) -> None:
        if self.logs:
            self._append(list(self.tables["solver"].values()), log.T)

    def _append(self, columns: list, values: Sequence) -> None:
        """Append to columns, to all or to none."""
        if self.gone or not self.file:
            return
        # then what was claimed for closing is used up: contacts that the end cuts off
        if not self.full:
            due = self.due + sum(_room(c, v) for c, v in zip(columns, values, strict=True))
            try:
                self._claim(due + self.closing)
            except OSError as error:
                self.full = True
                raise Unwritable(self.path, error.errno) from None
            self.due = due
        with self._writing():
            for column, part in zip(columns, values, strict=True):
                part = np.ascontiguousarray(part, dtype=column.dtype)
                _append(column, part)
                self.checks[column.name] = zlib.crc32(part, self.checks[column.name])

    def flush(self) -> None:
        with self._writing():
            self.file.flush()
            self.flushed, self.due = self.file.id.get_filesize(), 0
            with suppress(OSError):  # flushing gave back what was claimed for closing
                self._claim(self.closing)

    def _all_columns(self) -> list[h5py.Dataset]:
        """All columns of the run: along time, of contacts and of steps."""
        return [self.time, *self.columns, *(d for t in self.tables.values() for d in t.values())]

    def join(self, reader: Reader) -> None:
        """Append the columns of another file of the same run. Raises Damaged as readers do."""
        for column in self._all_columns():
            values = reader.column(column.name.lstrip("/"))
            self._append(
                [column], [np.char.encode(values, "utf-8") if values.dtype.kind == "U" else values]
            )

    def close(
        self,
        status: str,
        solver: dict,
        warnings: list[str],
        facts: dict,
        ranges,
        groups: Mapping[str, Group] = MappingProxyType({}),
    ) -> None:
        """State the status and what is known, add groups, give the file its name; nothing where it
        has been closed before.
        """
        if self.gone or not self.file:
            return
        with self._writing():
            compact_groups(self.file, facts)
            for path, attributes in closing(status, solver, warnings, facts).items():
                set_attributes(self.file[path or "/"], checked(attributes))
            for group, table in self.tables.items():
                self.file[f"{group}/{DIMENSIONS[group]}"].resize(table["time"].shape)
            for column in self._all_columns():
                texts, values = (column.attrs[n] for n in ABOUT), self.checks[column.name]
                column.attrs[CHECK] = column_check(*texts, values)
            if ranges is not None:
                for i, column in zip(self.kept, self.columns, strict=True):
                    column.attrs["actual_range"] = ranges.of(i)
            for path, group in (*ranged(ranges).items(), *groups.items()):
                group.write(self.file, path)
        self._rename()


def opening(attributes: Mapping, moment: float | None = None) -> dict:
    """Attributes of a file whose run is under way, without checksums; those of who made it too,
    unless they stand among them.

    moment: at which it began, seconds of `time.time`, default now.
    """
    return {**provenance(moment), **attributes, "status": "partial: still running"}


def closing(status: str, solver: dict, warnings: list[str], facts: dict) -> dict[str, dict]:
    """Attributes that the end of a run adds to a file and its groups, without checksums; the status
    last.
    """
    groups = {group: values | _units(group, values) for group, values in facts.items()}
    return {"solver": solver} | groups | {"": {"warnings": list(warnings), "status": status}}


def ranged(ranges: Ranges | None) -> dict[str, Group]:
    """The groups of located extremes and of integrals, where there are."""
    groups = {}
    if ranges is not None and ranges.extremes is not None:
        groups["extremes"] = extremes_group(ranges.extremes)
    if ranges is not None and ranges.integrals is not None:
        groups["integrals"] = integrals_group(ranges.integrals)
    return groups


def set_attributes(holder: h5py.Group, attributes: Mapping[str, object]) -> None:
    """Attributes of a group; a list of texts has that kind also when it is empty."""
    for name, value in attributes.items():
        if name == "warnings":
            holder.attrs.create(name, value, dtype=h5py.string_dtype(), shape=(len(value),))
        else:
            holder.attrs[name] = value


class ImageSink(Stream):
    """Makes the file in memory; `image` once it is closed: on a full disk HDF5 could neither write
    one nor let go of it.
    """

    image = b""

    def _lock(self) -> None:
        """Nothing is written."""

    def _open(self, room: int) -> h5py.File:
        self.content = io.BytesIO(self._empty())
        return reopened(self.content)

    def _claim(self, room: int) -> None:
        """Memory is not a disk."""

    def _detach(self) -> None:
        """There is nothing that writes to a disk."""

    def _rename(self) -> None:
        """The file is opened again: what `image` is made of can be looked up in it."""
        self.file.close()
        self.image = self.content.getvalue()
        self.file = reopened(self.content)


def filters(compression: int) -> dict:
    """Settings of a column. Raises ValueError for what is no gzip level."""
    checks.whole("compression", compression, 0, 9)
    packed = (
        {"compression": "gzip", "compression_opts": compression, "shuffle": True}
        if compression
        else {}
    )
    return {"fletcher32": True} | packed


def _units(group: str, facts: dict) -> dict[str, str]:
    """Units of what is known of a group in total, as NAME_units."""
    documented = group.partition("/")[0] in ("joints", "energy")
    return {f"{n}_units": FACT_UNITS[n] for n in facts if n in FACT_UNITS} if documented else {}


def check_name(path: Path) -> None:
    """A run may write a file of this name. Raises ValueError."""
    check_replaceable(path)
    check_result(path)


def lock_of(path: Path) -> Lock:
    """The lock that stands beside a result file while a run writes it.

    Raises InUse where another run does; OSError, where the disk is full Unwritable, where nothing
    can be written.
    """
    try:
        return Lock(path.with_name(f"{path.name}.lock"), f"another run writes {path}")
    except OSError as error:
        if error.errno in FULL:
            raise Unwritable(path, error.errno) from None
        raise OSError(
            error.errno, f"it cannot be written: {os.strerror(error.errno)}", path
        ) from None


def _set_aside(descriptor: int, begin: int, room: int) -> None:
    """Claim room for a file.

    Raises OSError where there is none; a system that cannot promise any is left out.
    """
    if not hasattr(os, "posix_fallocate"):
        return
    try:
        os.posix_fallocate(descriptor, begin, room)
    except OSError as error:
        if error.errno in FULL:
            raise


def _room(data, values) -> int:
    """Bytes by which appending to a column makes its file grow, at most."""
    old, (chunk,) = data.shape[0], data.chunks
    added = -(-(old + len(values)) // chunk) - -(-old // chunk)
    moved = data.compression is not None  # a chunk that is compressed anew no longer fits its place
    return (added + moved) * (chunk * data.dtype.itemsize + 64) + NODES


def _append(data, values) -> None:
    old = data.shape[0]
    data.resize((old + len(values),))
    data[old:] = values
