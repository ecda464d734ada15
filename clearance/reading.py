"""HDF5 files of ours, read with care: what is damaged or a stranger's is stated by file and place;
nothing is executed.

Checksums reveal damage. HDF5 stores those of columns and of what describes them. Those of long
texts stand beside the texts as attributes NAME_crc32.
"""

import json
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import h5py
import numpy as np

#: attributes whose checksum stands beside them
CHECKED = ("scene", "kernel")
#: units of what is known of a joint or of the energy in total
FACT_UNITS = {
    "radius": "m",
    "clearance": "m",
    "length": "m",
    "viscosity": "Pa s",
    "roughness": "m",
    "layer": "m",
    "pin_radius": "m",
    "overlap": "m",
    "friction_arm": "m",
    "bending_arm": "m",
    "angle": "rad",
    "peak_force": "N",
    "peak_force_time": "s",
    "smallest_gap": "m",
    "smallest_gap_time": "s",
    "film_pressure": "Pa",
    "film_thickness_ratio": "1",
    "piezoviscous_number": "1",
    "flattening_ratio": "1",
    "share_full_film": "1",
    "share_mixed": "1",
    "share_dry": "1",
    "mean_asperity_share": "1",
    "film_table_error_closing": "1",
    "film_table_error_opening": "1",
    "film_table_error_flow": "1",
    "film_table_error_shear": "1",
    "film_table_error_median": "1",
    "turned_over": "J",
    "largest_residual": "J",
}
TEXT, NUMBER, ROW = "a text", "a number", "a row of numbers"
_TEXTS = (
    "case parameters scene kernel status created units long_name method method_reason key known "
    "kind axis role "
    "definition model options facts doubts errors_left_out asked cannot"
)
_NUMBERS = (
    "rtol wall_s loop_s stretch_s energy_residual_share order steps rejected evaluations jacobians "
    "factorisations "
    "journal_bytes format_version companion_rtol spread begin_s end_s"
)
_ROWS = "actual_range lowest highest force_highest atol"
#: what attributes of these names must be
KINDS = {
    **dict.fromkeys(FACT_UNITS, NUMBER),
    **dict.fromkeys(_TEXTS.split(), TEXT),
    **dict.fromkeys(_NUMBERS.split(), NUMBER),
    **dict.fromkeys(_ROWS.split(), ROW),
}
#: times by which gzip makes a column smaller, at most
PACKED = 1100


class NewerFormat(ValueError):
    """A file that a newer version of clearance wrote."""


class Damaged(ValueError):
    """A file that is not what was written, or was never written by clearance."""


class Missing(Damaged):
    """A place that a file does not have."""


def _texts(data: h5py.Dataset) -> np.ndarray:
    """Texts of a column; plain ones of one length are not decoded one by one."""
    if h5py.check_string_dtype(data.dtype).length is not None and data.ndim == 1:
        raw = np.ascontiguousarray(data[()])
        letters = raw.view(np.uint8).reshape(len(raw), raw.itemsize)
        if letters.size and letters.max() < 128:
            return letters.astype(np.uint32).view(f"U{raw.itemsize}")[:, 0]
    return np.asarray(data.asstr()[()]).astype(str)


class Entries(dict):
    """Entries of a file by name; a missing one raises Damaged with its place."""

    def __init__(self, where: str, items=()):
        super().__init__(items)
        self.where = where

    def __missing__(self, name):
        raise Damaged(f"{self.where} has no {name!r}")


@contextmanager
def _reading(path: Path, place: str) -> Iterator[None]:
    """HDF5 reports damage by errors of many kinds."""
    try:
        yield
    except Damaged:
        raise
    except MemoryError as error:
        raise Damaged(f"{path}: /{place} does not fit into memory: {error}") from None
    except Exception as error:
        reason = error.args[0] if isinstance(error, KeyError) else error
        raise Damaged(f"{path}: /{place} cannot be read, the file is damaged: {reason}") from None


class Reader:
    """An HDF5 file of ours whose content may be damaged or a stranger's.

    What cannot be read raises Damaged, naming the file and the place. Nothing is read from the
    other files that HDF5 can point to.
    """

    def __init__(self, path: Path, file: h5py.File):
        self.path, self.file = path, file

    def has(self, place: str) -> bool:
        """There is a dataset or group of this name; the root is ""."""
        self._check_open()
        with _reading(self.path, place):
            return not place or place in self.file

    def _check_open(self) -> None:
        if not self.file:
            raise ValueError(f"{self.path} has been closed")

    def item(self, place: str = "") -> h5py.Group | h5py.Dataset:
        """A dataset or group. Raises Missing where there is none of this name."""
        self._check_open()
        with _reading(self.path, place):
            try:
                item = self.file[place] if place else self.file
            except KeyError:
                if place in self.file:
                    raise
                raise Missing(f"{self.path} has no /{place}") from None
            if item.file.filename != self.file.filename:
                raise Damaged(f"{self.path}: /{place} points to another file")
            return item

    def names(self, place: str = "") -> tuple[str, ...]:
        """Names in a group; none where the group is missing."""
        try:
            group = self.item(place)
        except Missing:
            return ()
        with _reading(self.path, place):
            return tuple(group) if isinstance(group, h5py.Group) else ()

    def shape(self, place: str) -> tuple[int, ...]:
        """Shape of a column."""
        return self._data(place).shape

    def _data(self, place: str) -> h5py.Dataset:
        item = self.item(place)
        if not isinstance(item, h5py.Dataset) or item.shape is None:
            raise Damaged(f"{self.path}: /{place} is no column")
        return item

    def column(self, place: str) -> np.ndarray:
        """All of a column, of numbers or of texts."""
        data = self._data(place)
        with _reading(self.path, place):
            if data.external or data.is_virtual:
                raise Damaged(f"{self.path}: /{place} points to another file")
            if data.nbytes > PACKED * data.id.get_storage_size():
                raise Damaged(
                    f"{self.path}: /{place} claims {data.size} values, more than the file holds"
                )
            if h5py.check_string_dtype(data.dtype):
                return _texts(data)
            if data.dtype.kind not in "biuf":
                raise Damaged(
                    f"{self.path}: /{place} holds {data.dtype}, neither numbers nor texts"
                )
            return data[()]

    def attribute(self, place: str, name: str):
        """An attribute of a group or dataset; one of a known name is what it must be."""
        holder = self.item(place)
        with _reading(self.path, place):
            if name not in holder.attrs:
                raise Damaged(f"{self.path}: /{place} has no attribute {name!r}")
            value = holder.attrs[name]
            check = holder.attrs.get(f"{name}_crc32") if name in CHECKED else None
        where = f"{self.path}: /{place}: attribute {name}"
        kind = NUMBER if place == "metrics" else KINDS.get(name)
        if isinstance(value, str) and not _is(TEXT, value):
            raise Damaged(f"{where} is no UTF-8 text")
        if kind is not None and not _is(kind, value):
            raise Damaged(f"{where} must be {kind}, got {value!r:.80}")
        if check is not None and check != zlib.crc32(value.encode()):
            raise Damaged(f"{where} is not what was written: its checksum differs")
        return value

    def attributes(self, place: str = "") -> Entries:
        """All attributes of a group or dataset."""
        with _reading(self.path, place):
            names = list(self.item(place).attrs)
        return Entries(
            f"{self.path}: /{place}", ((name, self.attribute(place, name)) for name in names)
        )

    def document(self, place: str, name: str, kind: type = dict) -> dict | list:
        """An attribute that is a JSON object, or a JSON array where `kind` is list."""
        where, text = f"{self.path}: attribute {name}", self.attribute(place, name)
        try:
            document = json.loads(text, object_hook=lambda items: Entries(where, items))
        except ValueError as error:
            raise Damaged(f"{where} is no JSON: {error}") from None
        if not isinstance(document, kind):
            raise Damaged(f"{where} is no JSON {'object' if kind is dict else 'array'}")
        return document

    def close(self) -> None:
        """Close the file."""
        self.file.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def _is(kind: str, value) -> bool:
    """The value of an attribute is of this kind."""
    if kind == TEXT:
        return isinstance(value, str) and value == value.encode(errors="replace").decode()
    array = np.asarray(value)
    return array.dtype.kind in "biuf" and array.ndim == (kind == ROW)


def open_checked(path: Path, kind: str, form: str, version: int) -> Reader:
    """Open an HDF5 file of ours.

    Raises FileNotFoundError, or ValueError for other, broken or newer files.
    """
    if not path.exists():
        raise FileNotFoundError(f"no {kind.split()[-1]} file {path}")
    if path.is_dir():
        raise ValueError(f"{path} is a directory, not a {kind}")
    try:
        reader = Reader(path, h5py.File(path, "r"))
    except Exception as error:
        raise ValueError(f"{path} is not a readable HDF5 file: {error}") from None
    try:
        _check_format(reader, kind, form, version)
    except ValueError:
        reader.close()
        raise
    return reader


def _check_format(reader: Reader, kind: str, form: str, version: int) -> None:
    """Raises ValueError for a file of another format, NewerFormat for one of a newer version."""
    with _reading(reader.path, ""):
        mark = reader.file.attrs.get("format")
    if not isinstance(mark, str) or mark != form:
        raise ValueError(f"{reader.path} is not a {kind} (format {mark!r})")
    newer = reader.attribute("", "format_version")
    if newer > version:
        raise NewerFormat(
            f"{reader.path} was written by a newer clearance (format {newer}; this one reads up to "
            f"{version})"
        )
