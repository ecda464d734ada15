"""HDF5 files of ours, read with care: what is damaged or a stranger's is stated by file and place;
nothing is executed.

Checksums reveal damage. HDF5 stores those of pieces of columns and of headers, but none of texts
and of the index of a column's pieces. Those of texts of a group stand beside them as attributes
NAME_crc32, those of a column in its attribute crc32: of its texts, and of its values.

`MemoryReader` reads the content of a result file that need not be made, as that file would be.
"""

import itertools
import math
import mmap
import re
import struct
import zlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import h5py
import numpy as np

from clearance.files.texts import CHECK, document_of

if TYPE_CHECKING:  # what files alone need
    from clearance.results.hdf5_image import Attributes, Columns

#: texts of a column that have a checksum
ABOUT = ("units", "long_name")
#: end of the names of checksums of texts
BESIDE = f"_{CHECK}"


def by_name(names: dict[str, str]) -> dict[str, str]:
    """From names by what they share, that by name."""
    return {name: shared for shared, several in names.items() for name in several.split()}


#: units of what is known of a joint or of the energy in total
FACT_UNITS = by_name(
    {
        "m": "radius clearance length roughness layer pin_radius overlap friction_arm bending_arm "
        "smallest_gap",
        "Pa s": "viscosity",
        "rad": "angle",
        "N": "peak_force",
        "s": "peak_force_time smallest_gap_time",
        "Pa": "film_pressure",
        "1": "film_thickness_ratio piezoviscous_number flattening_ratio share_full_film "
        "share_mixed share_dry mean_asperity_share film_table_error_closing "
        "film_table_error_opening film_table_error_flow film_table_error_shear "
        "film_table_error_median",
        "J": "turned_over largest_residual",
    }
)
TEXT, NUMBER, ROW = "a text", "a number", "a row of numbers"
#: what attributes of these names must be
KINDS = dict.fromkeys(FACT_UNITS, NUMBER) | by_name(
    {
        TEXT: "case parameters scene kernel status created units long_name method method_reason "
        "key known kind axis role definition model options facts doubts errors_left_out asked "
        "cannot parameter request made ended command",
        NUMBER: "rtol wall_s loop_s stretch_s energy_residual_share order steps rejected "
        "evaluations jacobians factorisations journal_bytes format_version companion_rtol spread "
        "begin_s end_s",
        ROW: "actual_range lowest highest force_highest atol",
    }
)
UNNAMED = Path("the result")
SMALL = 2**24  # bytes of a column that fits into the memory of any machine
#: times by which gzip makes a column smaller, at most
PACKED = 1100
ENDS = 2**24  # bytes at both ends of a file, where texts of ours stand


def crc_of(text: str | list[str]) -> int:
    """Checksum of a text, or of several."""
    return zlib.crc32("\0".join([text] if isinstance(text, str) else text).encode())


def checked(attributes: Mapping[str, object]) -> dict[str, object]:
    """Attributes of a group, with the checksums of its texts."""
    checks = {}
    for name, value in attributes.items():
        if isinstance(value, str) or (isinstance(value, list) and _all_texts(value)):
            checks[name + BESIDE] = crc_of(value)
    return {**attributes, **checks}


def _all_texts(values: list) -> bool:
    return all(isinstance(value, str) for value in values)


def column_check(units: str, long_name: str, values: int) -> np.ndarray:
    """Checksums of a column; values: CRC-32 of its values."""
    return np.array([crc_of([units, long_name]), values], np.uint32)


class NewerFormat(ValueError):
    """A file that a newer version of clearance wrote."""


class Damaged(ValueError):
    """A file that is not what was written, or was never written by clearance."""


class Missing(Damaged):
    """A place that a file does not have."""


def _texts(data: h5py.Dataset, raw: np.ndarray) -> np.ndarray:
    """Texts of a column; plain ones of one length are not decoded one by one."""
    if raw.dtype.kind == "S" and data.ndim == 1:
        letters = raw.view(np.uint8).reshape(len(raw), raw.itemsize)
        if letters.size and letters.max() < 128:
            return letters.astype(np.uint32).view(f"U{raw.itemsize}")[:, 0]
    return np.asarray(data.asstr()[()]).astype(str)


def _checksums(holder: h5py.Group | h5py.Dataset, name: str) -> np.ndarray | None:
    """Numbers of an attribute that holds checksums; None where there is none."""
    if not h5py.h5a.exists(holder.id, name.encode()):
        return None
    attribute = h5py.h5a.open(holder.id, name.encode())
    numbers = np.empty(attribute.shape, np.int64)
    attribute.read(numbers)
    return numbers.ravel()


def _free_memory() -> float:
    """Bytes of memory that a column may take; infinite where the system does not state it."""
    try:
        with open("/proc/meminfo") as table:
            return next(1024.0 * int(t.split()[1]) for t in table if t.startswith("MemAvailable"))
    except (OSError, StopIteration):
        return math.inf


def _is_complete(data: h5py.Dataset, sealed: bool) -> bool:
    """The index of a column, which has no checksum, names all of its pieces with their sizes.

    HDF5 reads a piece that it cannot find as zeros. Where values have no checksum (`sealed`), each
    is looked for, which raises. A piece that is too small would end the process.
    """
    if not data.chunks:
        return True
    pieces: list = []
    data.id.chunk_iter(pieces.append)
    check = 4 * bool(data.fletcher32)  # bytes behind a piece
    packing = data.id.get_create_plist().get_nfilters() - 1 - bool(check)  # place of that filter
    room = math.prod(data.chunks) * data.id.get_type().get_size() + check
    for piece in pieces:
        packed = data.compression and not piece.filter_mask >> packing and piece.size > check
        if piece.size != room and not packed:
            return False
    steps = [range(0, n, c) for n, c in zip(data.shape, data.chunks, strict=True)]
    if len(pieces) != math.prod(map(len, steps)):
        return False
    for piece in [] if sealed else pieces:
        data.id.read_direct_chunk(piece.chunk_offset)
    return sorted(p.chunk_offset for p in pieces) == list(itertools.product(*steps))


class Entries(dict):
    """Entries of a file by name; a missing one raises Damaged with its place."""

    def __init__(self, where: str, items=()):
        super().__init__(items)
        self.where = where

    def __missing__(self, name):
        raise Damaged(f"{self.where} has no {name!r}")


@contextmanager
def _reading(path: Path, key: str) -> Iterator[None]:
    """HDF5 reports damage by errors of many kinds."""
    try:
        yield
    except Damaged:
        raise
    except MemoryError as error:
        raise Damaged(f"{path}: /{key} does not fit into memory: {error}") from None
    except Exception as error:
        reason = error.args[0] if isinstance(error, KeyError) else error
        raise Damaged(f"{path}: /{key} cannot be read, the file is damaged: {reason}") from None


def arrays_of(path: Path) -> dict[str, np.ndarray]:
    """Arrays of a file of numpy; nothing in it is run. Raises Damaged for what cannot be read."""
    if not path.is_file():
        raise Damaged(f"there is no {path}")
    try:
        with open(path, "rb") as content, np.load(content, allow_pickle=False) as file:
            return {name: file[name] for name in file.files}
    except Exception as error:  # zip files report damage by errors of many kinds
        raise Damaged(f"{path} cannot be read, the file is damaged: {error}") from None


class Reader:
    """An HDF5 file of ours whose content may be damaged or a stranger's.

    What cannot be read raises Damaged, naming the file and the place. Nothing is read from the
    other files that HDF5 can point to. looked: places of headers whose texts can be read; None
    where all can.
    """

    def __init__(self, path: Path, file: h5py.File, looked: set[int] | None = None):
        self.path, self.file, self.looked = path, file, looked

    def has(self, key: str) -> bool:
        """There is a dataset or group of this name; the root is ""."""
        self._check_open()
        with _reading(self.path, key):
            return self._leads_somewhere(key)

    def _leads_somewhere(self, key: str) -> bool:
        """There is such a place in the file itself.

        Raises Damaged for a link: it may lead to another file, or to a pipe without an end.
        """
        links, path = self.file.id.links, b""
        for name in key.encode().split(b"/") if key else ():
            path += b"/" + name
            if not links.exists(path):
                return False
            if links.get_info(path).type != h5py.h5l.TYPE_HARD:
                raise Damaged(f"{self.path}: /{key} points to another file")
        return True

    @property
    def is_open(self) -> bool:
        """True until it is closed."""
        return bool(self.file)

    def _check_open(self) -> None:
        if not self.is_open:
            raise ValueError(f"{self.path} has been closed")

    def item(self, key: str = "") -> h5py.Group | h5py.Dataset:
        """A dataset or group. Raises Missing where there is none of this name."""
        self._check_open()
        with _reading(self.path, key):
            if not self._leads_somewhere(key):
                raise Missing(f"{self.path} has no /{key}")
            return self.file[key] if key else self.file

    def names(self, key: str = "") -> tuple[str, ...]:
        """Names in a group; none where the group is missing."""
        try:
            group = self.item(key)
        except Missing:
            return ()
        with _reading(self.path, key):
            return tuple(group) if isinstance(group, h5py.Group) else ()

    def columns(self) -> list[str]:
        """Paths of all columns, each once."""
        names: list[str] = []
        with _reading(self.path, ""):
            self.file.visit(names.append)
        return [name for name in names if isinstance(self.item(name), h5py.Dataset)]

    def shape(self, key: str) -> tuple[int, ...]:
        """Shape of a column."""
        return self._data(key).shape

    def _data(self, key: str) -> h5py.Dataset:
        item = self.item(key)
        with _reading(self.path, key):
            column = isinstance(item, h5py.Dataset)
            if column and (item.is_virtual or item.external):
                raise Damaged(f"{self.path}: /{key} points to another file")
            if not column or item.shape is None:
                raise Damaged(f"{self.path}: /{key} is no column")
        return item

    def column(self, key: str, samples: int | None = None) -> np.ndarray:
        """All of a column, of numbers or of texts. samples: length of a row, where it is known: a
        longer one may unpack to more than there is.
        """
        data = self._data(key)
        if samples is not None and data.ndim == 1 and len(data) != samples:
            raise Damaged(f"{self.path}: /{key} has {len(data)} values, /time has {samples}")
        with _reading(self.path, key):
            if data.nbytes > PACKED * data.id.get_storage_size():
                raise Damaged(
                    f"{self.path}: /{key} claims {data.size} values, more than the file holds"
                )
            if data.nbytes > SMALL and data.nbytes > (free := _free_memory()):
                raise Damaged(
                    f"{self.path}: /{key} has {data.nbytes:.3g} bytes, more than the {free:.3g} "
                    "that are free"
                )
            texts = h5py.check_string_dtype(data.dtype)
            if data.dtype.kind == "O":
                self._check_all_heaps()
            if not texts and data.dtype.kind not in "biuf":
                raise Damaged(f"{self.path}: /{key} holds {data.dtype}, neither numbers nor texts")
            check = _checksums(data, CHECK)
            if not _is_complete(data, check is not None):
                raise Damaged(f"{self.path}: /{key} lacks pieces")
            raw = np.ascontiguousarray(data[()])
            if check is not None and check[1] != zlib.crc32(raw):
                raise Damaged(f"{self.path}: /{key} is not what was written: its checksum differs")
            return _texts(data, raw) if texts else raw.reshape(data.shape)

    def has_attribute(self, key: str, name: str) -> bool:
        """True where a group or dataset has an attribute of this name."""
        return name in self.item(key).attrs

    def attribute(self, key: str, name: str):
        """An attribute of a group or dataset; one of a known name is what it must be."""
        return self._attribute(self._holder(key), key, name)

    def _holder(self, key: str) -> h5py.Group | h5py.Dataset:
        """A group or dataset whose texts can be read."""
        holder = self.item(key)
        with _reading(self.path, key):
            if self.looked is not None:
                self._check_heaps(h5py.h5o.get_info(holder.id).addr)
        return holder

    def _attribute(self, holder: h5py.Group | h5py.Dataset, key: str, name: str):
        with _reading(self.path, key):
            if name not in holder.attrs:
                raise Damaged(f"{self.path}: /{key} has no attribute {name!r}")
            value = holder.attrs[name]
            fits = self._fits(holder, name, value)
        where = f"{self.path}: /{key}: attribute {name}"
        kind = NUMBER if key == "metrics" else KINDS.get(name)
        if isinstance(value, str) and not _is(TEXT, value):
            raise Damaged(f"{where} is no UTF-8 text")
        if kind is not None and not _is(kind, value):
            raise Damaged(f"{where} must be {kind}, got {value!r:.80}")
        if not fits:
            raise Damaged(f"{where} is not what was written: its checksum differs")
        return value

    def _check_heaps(self, address: int) -> None:
        """HDF5 never comes back from a heap of texts with an entry of no length.

        Raises Damaged where a header has texts in such a heap.
        """
        if self.looked is None or address in self.looked:
            return
        from clearance.results.hdf5_image import Unknown, heaps

        with (
            open(self.path, "rb") as file,
            mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content,
        ):
            try:
                begins = heaps(content, address)
            except Unknown:
                self._check_all_heaps()
                return
            for begin in begins - self.looked:
                self._check_heap(content, begin, len(content))
        self.looked |= {address, *begins}

    def _check_heap(self, content: bytes | mmap.mmap, begin: int, size: int, before: int = 0):
        if _is_broken(content, begin, size):
            raise Damaged(
                f"{self.path} is damaged: its texts from byte {before + begin} on have no end"
            )

    def _check_all_heaps(self) -> None:
        """Of the ends of a file, where texts of ours stand; they are looked for."""
        if self.looked is None:
            return
        size = self.path.stat().st_size
        with open(self.path, "rb") as file:
            for begin in {0, max(size - ENDS, 0)}:
                file.seek(begin)
                content = file.read(ENDS)
                for match in re.finditer(b"GCOL\x01", content):
                    self._check_heap(content, match.start(), size - begin, begin)
        self.looked = None

    def _fits(self, holder: h5py.Group | h5py.Dataset, name: str, value: object) -> bool:
        """An attribute is as its checksum has it, or has none."""
        texts, check = value, None
        if name in ABOUT and isinstance(holder, h5py.Dataset):
            texts, check = [holder.attrs.get(n) for n in ABOUT], _checksums(holder, CHECK)
        elif isinstance(value, str) or (isinstance(value, np.ndarray) and value.dtype == object):
            check = _checksums(holder, name + BESIDE)
            texts = value if isinstance(value, str) else list(value)
        if check is None:
            return True
        return (isinstance(texts, str) or _all_texts(texts)) and check[0] == crc_of(texts)

    def attributes(self, key: str = "") -> Entries:
        """All attributes of a group or dataset, without checksums."""
        holder = self._holder(key)
        with _reading(self.path, key):
            names = [n for n in holder.attrs if n != CHECK and not n.endswith(BESIDE)]
        return Entries(
            f"{self.path}: /{key}", ((n, self._attribute(holder, key, n)) for n in names)
        )

    def document(self, key: str, name: str, kind: type = dict) -> dict | list:
        """An attribute that is a JSON object, or a JSON array where `kind` is list."""
        where, text = f"{self.path}: attribute {name}", self.attribute(key, name)
        if not isinstance(text, str):
            raise Damaged(f"{where} must be {TEXT}, got {text!r:.80}")
        try:
            return document_of(text, where, kind, lambda items: Entries(where, items))
        except ValueError as error:
            raise Damaged(str(error)) from None

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
    if not path.is_file():
        raise ValueError(f"{path} is a device, a pipe or a socket, not a {kind}")
    try:
        reader = Reader(path, h5py.File(path, "r"), set())
    except Exception as error:
        raise ValueError(f"{path} is not a readable HDF5 file: {error}") from None
    try:
        _check_format(reader, kind, form, version)
    except (ValueError, OSError):
        reader.close()
        raise
    return reader


def _is_broken(content: bytes | mmap.mmap, address: int, most: int) -> bool:
    """Entries of a heap do not follow one another; False where no heap is. most: of its bytes."""
    from clearance.results.hdf5_image import HEAP

    if address + 16 > len(content):
        return False
    (size,) = struct.unpack_from("<Q", content, address + 8)
    if not HEAP <= size <= most - address:
        return False
    end, address = address + size, address + 16
    while address + 16 <= min(end, len(content)):
        number, _, _, length = struct.unpack_from("<HHIQ", content, address)
        step = 16 + length + -length % 8 if number else length  # what is free counts its head
        if not 0 < step <= end - address:
            return True
        address += step
    return False


def _check_format(reader: Reader, kind: str, form: str, version: int) -> None:
    """Raises ValueError for a file of another format, NewerFormat for one of a newer version."""
    with _reading(reader.path, ""):
        mark = reader._holder("").attrs.get("format")
    if not isinstance(mark, str) or mark != form:
        raise ValueError(f"{reader.path} is not a {kind} (format {mark!r})")
    newer = reader.attribute("", "format_version")
    if newer > version:
        raise NewerFormat(
            f"{reader.path} was written by a newer clearance (format {newer}; this one reads up to "
            f"{version})"
        )


class MemoryReader(Reader):
    """Groups and columns in memory, with the names, kinds and copies that a file of them has.

    ready: attributes of some groups; content: makes the columns by path, texts among them, and the
    attributes of all groups and columns. path: of the file, where there is one.
    """

    def __init__(
        self,
        ready: "Mapping[str, Mapping]",
        content: "Callable[[], tuple[Columns, Attributes]]",
        path: Path | None = None,
    ):
        self.path = path or UNNAMED
        self._ready, self._make, self.closed = ready, content, False

    @property
    def is_open(self) -> bool:
        return not self.closed

    @cached_property
    def _content(self) -> "tuple[Columns, Attributes]":
        return self._make()

    @property
    def _columns(self) -> "Columns":
        return self._content[0]

    @cached_property
    def _groups(self) -> Mapping[str, tuple[str, ...]]:
        """Names in each group, sorted as HDF5 has them."""
        columns, about = self._content
        groups: dict[str, set[str]] = {path: set() for path in about if path not in columns}
        for path in (*columns, *about):
            while path:
                group, _, name = path.rpartition("/")
                groups.setdefault(group, set()).add(name)
                path = group
        return {group: tuple(sorted(names)) for group, names in groups.items()}

    def has(self, key):
        self._check_open()
        return key in self._groups or key in self._columns

    def has_attribute(self, key, name):
        return name in self._holder(key)

    def names(self, key=""):
        self._check_open()
        return self._groups.get(key, ())

    def columns(self):
        return list(self._columns)

    def shape(self, key):
        return self._data(key).shape

    def _data(self, key):
        self._check_open()
        if key not in self._columns:
            if key in self._groups:
                raise Damaged(f"{self.path}: /{key} is no column")
            raise Missing(f"{self.path} has no /{key}")
        return self._columns[key]

    def column(self, key, samples=None):
        return np.array(self._data(key))

    def _holder(self, key):
        self._check_open()
        if key in self._ready:
            return self._ready[key]
        if not self.has(key):
            raise Missing(f"{self.path} has no /{key}")
        return self._content[1].get(key, {})

    def attribute(self, key, name):
        held = self._holder(key)
        if name not in held:
            raise Damaged(f"{self.path}: /{key} has no attribute {name!r}")
        value = held[name]
        if isinstance(value, str):
            return value
        texts = name == "warnings" or (
            isinstance(value, list) and value and isinstance(value[0], str)
        )
        return np.array(value, dtype=object if texts else None)[()]  # no texts are of no kind

    def attributes(self, key=""):
        names = self._holder(key)
        return Entries(f"{self.path}: /{key}", ((n, self.attribute(key, n)) for n in names))

    def close(self):
        self.closed = True
