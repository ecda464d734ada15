"""Result files from images: the bytes of a file that HDF5 made once, with the numbers of another
run in their places.

A run has some two hundred attributes and ninety columns, and HDF5 takes a hundred times longer for
them than their bytes take to be copied. Runs of one structure differ in numbers, texts and lengths
of columns alone. `Image.of` learns from a file where these stand, `Image.filled` replaces them and
the checksums over them. The store keeps images, as it keeps kernels.

The format: HDF5 File Format Specification 3.0, superblock version 2, object headers version 2,
attributes in their headers (IV.A.2.m), global heap (III.E). Its checksums are those of the HDF5
library that is loaded: lookup3 for headers, Fletcher's for chunks of columns.
"""

import ctypes
import math
import mmap
import os
import pickle
import struct
import zlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import h5py
import numpy as np

from clearance.files.sealed import digest_of_code
from clearance.files.texts import CHECK

SUPERBLOCK = 48  # bytes of the superblock of version 2, its checksum the last four
END = 28  # place of the file's length in the superblock
TIMES, PHASES, ORDERED = 0x20, 0x10, 0x04  # flags of an object header: what stands in it
DATASPACE, ATTRIBUTE, CONTINUATION, ABOUT = 0x01, 0x0C, 0x10, 0x15  # types of messages
NOWHERE = b"\xff" * 8  # place of what is not there
VARYING = 9  # class of a type whose values stand in a heap
REFERENCE = struct.Struct("<IQI")  # to one of them: its length, its heap, its number there
HEAP = 4096  # bytes of a global heap, at least

#: attributes by place ("" is the root), columns by path
Attributes = Mapping[str, Mapping[str, object]]
Columns = Mapping[str, np.ndarray]


class Unknown(ValueError):
    """A file of another form than those that this module reads."""


@cache
def _checksums() -> tuple[Callable, Callable] | None:
    """HDF5's checksums of headers and of chunks; None where its library hides them."""
    here = Path(h5py.__file__).parent
    libraries = [*here.parent.glob("h5py.libs/libhdf5-*"), *here.glob("libhdf5*")]
    for path in libraries:
        try:
            library = ctypes.CDLL(os.fspath(path))
            header, chunk = library.H5_checksum_lookup3, library.H5_checksum_fletcher32
        except (OSError, AttributeError):
            continue
        header.argtypes = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_uint32
        chunk.argtypes = ctypes.c_void_p, ctypes.c_size_t
        header.restype = chunk.restype = ctypes.c_uint32
        return header, chunk
    return None


def available() -> bool:
    """True where files can be made from images."""
    return _checksums() is not None


@dataclass(frozen=True)
class Header:
    """Places in an object header.

    blocks: begin and end of its pieces, each with its checksum behind; extent: place of a column's
    lengths; attributes: place and bytes of their values, by name; varying: names of those whose
    values stand in a heap.
    """

    blocks: tuple[tuple[int, int], ...]
    extent: int
    attributes: dict[str, tuple[int, int]]
    varying: tuple[str, ...]


def header(data: bytes | mmap.mmap, address: int) -> Header:
    """The object header at a place of a file.

    Raises Unknown for one of another version, and for attributes that stand elsewhere.
    """
    if data[address : address + 5] != b"OHDR\x02":
        raise Unknown(f"no object header of version 2 at {address}")
    flags, begin = data[address + 5], address + 6
    begin += 16 * bool(flags & TIMES) + 4 * bool(flags & PHASES)
    width = 1 << (flags & 3)
    size = int.from_bytes(data[begin : begin + width], "little")
    blocks, attributes, varying, extent = [], {}, [], 0
    waiting = [(address, begin + width, begin + width + size)]
    while waiting:
        first, begin, end = waiting.pop()
        blocks.append((first, end))
        for kind, body, length in _messages(data, begin, end, 4 + 2 * bool(flags & ORDERED)):
            if kind == CONTINUATION:
                at, long = struct.unpack_from("<QQ", data, body)
                waiting.append((at, at + 4, at + long - 4))
            elif kind == DATASPACE:
                extent = body + 4
            elif kind == ATTRIBUTE:
                name, of_heap, value = _attribute(data, body)
                attributes[name] = value, body + length - value
                varying += [name] if of_heap else []
            elif kind == ABOUT:
                at = body + 2 + 2 * (data[body + 1] & 1)
                if data[at : at + 8] != NOWHERE:
                    raise Unknown(f"attributes beside the header at {address}")
    return Header(tuple(blocks), extent, attributes, tuple(varying))


def heaps(data: bytes | mmap.mmap, address: int) -> set[int]:
    """Places of the heaps that hold texts of attributes of the object header at a place.

    Raises Unknown as `header` does.
    """
    head = header(data, address)
    values = (head.attributes[name] for name in head.varying)
    references = b"".join(data[begin : begin + length] for begin, length in values)
    return {heap for length, heap, _ in REFERENCE.iter_unpack(references) if length}


def _messages(
    data: bytes | mmap.mmap, begin: int, end: int, head: int
) -> Iterator[tuple[int, int, int]]:
    """Messages of a piece of a header: type, place and length of their bodies."""
    while begin + head <= end:
        kind, length = struct.unpack_from("<BH", data, begin)
        yield kind, begin + head, length
        begin += head + length


def _attribute(data: bytes | mmap.mmap, body: int) -> tuple[str, bool, int]:
    """Name of an attribute, whether its values stand in a heap, and the place of its value."""
    version, _, name, kind, space, _ = struct.unpack_from("<BBHHHB", data, body)
    if version != 3:
        raise Unknown(f"attribute of version {version}")
    begin = body + 9
    after = begin + name
    of_heap = data[after] & 0x0F == VARYING
    return data[begin : after - 1].decode(), of_heap, after + kind + space


@dataclass(frozen=True)
class Column:
    """Places of a column: its length, the checksum of its values (0: none), its chunks one after
    another, and rows in each of them, of so many values each.

    fixed: its bytes are packed, and the same in all files from this image.
    """

    extent: int
    check: int
    chunks: tuple[int, ...]
    rows: int
    dtype: np.dtype
    fixed: bool
    width: int = 1


@dataclass(frozen=True)
class Image:
    """A file and the places in it; see the module."""

    data: bytes
    columns: dict[str, Column]
    attributes: dict[str, dict[str, tuple[int, int]]]
    dtypes: dict[str, dict[str, np.dtype | None]]
    blocks: np.ndarray

    @classmethod
    def of(cls, data: bytes, file: h5py.File, attributes: Attributes, columns: Columns) -> "Image":
        """The image of a file that holds these; data: its bytes.

        Raises Unknown where one of them does not stand where this module looks for it.
        """
        if data[:9] != b"\x89HDF\r\n\x1a\n\x02":
            raise Unknown("no superblock of version 2")
        blocks: list[tuple[int, int]] = [(0, SUPERBLOCK - 4)]
        places, dtypes, tables = {}, {}, {}
        for group, values in attributes.items():
            item = file[group] if group else file
            head = header(data, h5py.h5o.get_info(item.id).addr)
            if missing := values.keys() - head.attributes.keys():
                raise Unknown(f"/{group}: {missing} do not stand in its header")
            places[group] = {name: head.attributes[name] for name in values}
            dtypes[group] = {name: _dtype(item.attrs.get_id(name)) for name in values}
            blocks += head.blocks
        for path in columns:
            data_set = file[path]
            head = header(data, h5py.h5o.get_info(data_set.id).addr)
            tables[path] = _column(data_set, head)
            blocks += head.blocks
        texts = [
            data[begin : begin + length]
            for group, inside in places.items()
            for name, (begin, length) in inside.items()
            if dtypes[group][name] is None
        ]
        data = _without(data, b"".join(texts))
        return cls(data, tables, places, dtypes, np.unique(np.array(blocks), axis=0))

    def filled(self, attributes: Attributes, columns: Columns) -> bytearray:
        """The file with other numbers and texts; all of the same names, kinds and shapes."""
        texts = _Texts(len(self.data))
        out = bytearray(self.data)
        for group, values in attributes.items():
            dtypes, places = self.dtypes[group], self.attributes[group]
            for name, value in values.items():
                begin, length = places[name]
                dtype = dtypes[name]
                if dtype is None:
                    stored = texts.references(value)
                else:
                    stored = np.asarray(value, dtype).tobytes()
                out[begin : begin + len(stored)] = stored
                assert len(stored) <= length
        out += texts.heap()  # a profiler that keeps frames may keep views of columns: none is yet
        for path, values in columns.items():
            self._fill(out, self.columns[path], values)
        struct.pack_into("<Q", out, END, len(out))
        self._check(out)
        return out

    def _fill(self, out: bytearray, column: Column, values: np.ndarray) -> None:
        """The values of a column, chunk by chunk, each with its checksum behind."""
        if column.fixed:
            return
        assert not column.chunks or len(values) <= column.rows * len(column.chunks)
        values = np.ascontiguousarray(values, column.dtype)
        if values.ndim == 1:
            struct.pack_into("<Q", out, column.extent, len(values))
        if column.check:
            struct.pack_into("<I", out, column.check, zlib.crc32(values))
        _, fletcher = _checksums()
        room, file = column.rows * values[:1].nbytes, np.frombuffer(out, np.uint8)
        stored = values.reshape(-1).view(np.uint8)
        for i, address in enumerate(column.chunks):
            part = stored[i * room : (i + 1) * room]
            file[address : address + part.nbytes] = part
            file[address + part.nbytes : address + room] = 0
            check = fletcher(file[address:].ctypes.data, room)
            struct.pack_into("<I", out, address + room, check)

    def _check(self, out: bytearray) -> None:
        """The checksums of all headers."""
        lookup, _ = _checksums()
        first = ctypes.addressof(ctypes.c_char.from_buffer(out))
        for begin, end in self.blocks.tolist():
            struct.pack_into("<I", out, end, lookup(first + begin, end - begin, 0))

    def packed(self) -> bytes:
        """The image in few bytes: without the values of its columns, which `filled` replaces."""
        data = bytearray(self.data)
        for column in self.columns.values():
            room = 0 if column.fixed else column.rows * column.dtype.itemsize * column.width
            for address in column.chunks:
                data[address : address + room] = bytes(room)
        return zlib.compress(pickle.dumps(replace(self, data=bytes(data))), 1)

    @classmethod
    def unpacked(cls, data: bytes) -> "Image":
        """The image that `packed` gave these bytes for."""
        return pickle.loads(zlib.decompress(data))


@cache
def made_from() -> str:
    """Versions and the digest of our sources, which files are made from."""
    sources = digest_of_code(*sorted(Path(__file__).parent.glob("*.py")))
    return " ".join([h5py.version.version, h5py.version.hdf5_version, np.__version__, sources])


def _without(data: bytes, references: bytes) -> bytes:
    """Data with zeros in place of some texts: no file from an image has those of another run."""
    out = bytearray(data)
    for length, heap, number in REFERENCE.iter_unpack(references):
        address = heap + 16
        while length and (object_ := struct.unpack_from("<HHIQ", data, address))[0] != number:
            address += 16 + object_[3] + -object_[3] % 8
        out[address + 16 : address + 16 + length] = bytes(length)
    return bytes(out)


def _dtype(attribute: h5py.h5a.AttrID) -> np.dtype | None:
    """Kind of an attribute's numbers; None of texts."""
    dtype = attribute.dtype
    if h5py.check_string_dtype(dtype) is not None:
        return None
    if dtype.kind not in "biuf":
        raise Unknown(f"attribute of kind {dtype}")
    return dtype


def _column(data: h5py.Dataset, head: Header) -> Column:
    """Places of a column; without chunks where it holds nothing."""
    check = head.attributes[CHECK][0] + 4 if CHECK in head.attributes else 0
    if data.chunks is None:
        if data.size:
            raise Unknown(f"{data.name} has no chunks")
        return Column(head.extent, check, (), 1, data.dtype, True)
    chunks: list[tuple] = []  # place in the column, and in the file
    data.id.chunk_iter(lambda chunk: chunks.append((chunk.chunk_offset, chunk.byte_offset)))
    places = tuple(address for _, address in sorted(chunks))
    fixed = data.compression is not None
    if not fixed and not (data.fletcher32 or not chunks):
        raise Unknown(f"{data.name} has no checksum")
    width = math.prod(data.chunks[1:])
    return Column(head.extent, check, places, data.chunks[0], data.dtype, fixed, width)


class _Texts:
    """Texts of attributes, which stand in a heap behind the rest of a file."""

    def __init__(self, address: int):
        self.aside = -address % 8
        self.address, self.objects = address + self.aside, []

    def references(self, texts: str | list[str]) -> bytes:
        """Length, heap and number of each of them."""
        references = b""
        for text in [texts] if isinstance(texts, str) else texts:
            data = str(text).encode()
            self.objects.append(data)
            references += REFERENCE.pack(len(data), self.address, len(self.objects))
        return references

    def heap(self) -> bytes:
        """The heap: its length, then its texts, each at a multiple of eight, then what is free."""
        body = b"".join(
            struct.pack("<HHIQ", i, 1, 0, len(text)) + text + bytes(-len(text) % 8)
            for i, text in enumerate(self.objects, 1)
        )
        size = max(HEAP, 16 + len(body) + 16)
        free = struct.pack("<HHIQ", 0, 0, 0, size - 16 - len(body))
        head = b"GCOL\x01\0\0\0" + struct.pack("<Q", size)
        return (bytes(self.aside) + head + body + free).ljust(self.aside + size, b"\0")


def likeness(attributes: Attributes, growing: Columns, tables: Columns, rows: int) -> tuple:
    """Equal for runs whose files can be made from one image.

    growing: columns with so many rows in a chunk; tables: columns of one chunk each.
    """
    kinds = tuple(
        (group, tuple((name, *_kind(value)) for name, value in values.items()))
        for group, values in attributes.items()
    )
    lengths = tuple((path, -(-len(values) // rows)) for path, values in growing.items())
    shapes = tuple(
        (path, values.tobytes() if values.dtype.kind == "U" else values.shape)
        for path, values in tables.items()
    )
    return kinds, lengths, shapes


def _kind(value: object) -> tuple:
    """Type and shape of an attribute."""
    if isinstance(value, str):
        return ("text",)
    if isinstance(value, float):
        return ("<f8",)
    if isinstance(value, list) and all(isinstance(v, str) for v in value):
        return "texts", len(value)
    array = np.asarray(value)
    return array.dtype.str, array.shape
