"""The file of a short run: held in memory until the run has ended, then written in one piece.

Without a path it is made on demand only.
"""

import hashlib
import time
import zlib
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from clearance.files.locks import replace_file, temporary_file
from clearance.results.reading import ABOUT, MemoryReader, checked
from clearance.results.recorder import SOLVER_COLUMNS, Memory, Ranges, Samples
from clearance.results.result import DIMENSIONS, EVENT_TEXTS, HeldResult, MemoryResult, Result
from clearance.results.stream import (
    FULL,
    Content,
    ImageSink,
    Stream,
    Unwritable,
    check_name,
    closing,
    columns_of,
    lock_of,
    opening,
    ranged,
    spots,
)
from clearance.results.tables import Group
from clearance.values.algebra import Arrays
from clearance.values.later import Later

if TYPE_CHECKING:  # what files alone need
    from clearance.results.hdf5_image import Attributes, Image

PATIENCE = 1.0  # seconds of wall time after which a run is no short one
MOST_IMAGES = 8  # that a process keeps
_images: "dict[tuple, Image | None]" = {}  # None: one file like it has been written


class ShortFile(Memory):
    """Keeps what a run puts out; `store` writes its file where it has a path.

    lasting: a run that has not ended after PATIENCE goes on in a file, as long runs do, as one does
        whose samples memory does not hold. What was computed before stays where it is killed.
    locked: nobody else may write a run of this name meanwhile.
    remembering: `record` holds all of it also where the run went on in a file.
    """

    image = b""
    lasting = locked = True

    def __init__(self, path: str | Path | None, content: Content, remembering: bool = False):
        moment = time.time()
        self.about = Later(lambda: opening(content.attributes, moment))
        super().__init__(content.channels, content.attributes, content.logs)
        self.target, self.remembering = None if path is None else Path(path), remembering
        self.kept, self.lock = content.kept, None
        self._content_of_run = content
        if self.target is not None:
            self._check_path()
        self.rows_in_chunk = content.rows_in_chunk
        self.groups: dict[str, Group] = {}
        self.stream: Stream | None = None
        self.began, self.stored = time.perf_counter(), False

    @cached_property
    def content(self) -> Content:
        """Parts of the run that its file has."""
        return replace(self._content_of_run, attributes=self.about)

    def _check_path(self) -> None:
        check_name(self.target)
        self.target.parent.mkdir(parents=True, exist_ok=True)
        if self.locked:
            self.lock = lock_of(self.target)

    def _take(self, kind: str, *piece) -> None:
        if self.stream is not None:
            getattr(self.stream, kind)(*piece)
        if self.stream is None or self._remembers(kind):
            super()._take(kind, *piece)

    def _remembers(self, kind: str) -> bool:
        """True for pieces that stay in memory beside the stream: no record has a log of steps."""
        return self.remembering and kind != "steps"

    def flush(self) -> None:
        """Go on in a file once the run is no short one."""
        if self.stream is not None:
            self.stream.flush()
        elif self.lasting and (self.samples.stored or time.perf_counter() - self.began > PATIENCE):
            self.go_on()

    def go_on(self) -> None:
        """Go on in a file as long runs do. Raises Unwritable where it does not take the pieces."""
        alone = self.lock is None or self.lock.held
        self.stream = Stream(self.path, self.content, alone)
        self.hand_on(self.stream)
        self.pieces = [piece for piece in self.pieces if self._remembers(piece[0])]
        if not self.remembering:
            self.samples = Samples(len(self.channels))

    def close(self, *ended) -> None:
        """The end of the run; its file comes with `store`, unless it is there already."""
        super().close(*ended)
        if self.stream is not None:
            self.stream.close(*ended)

    def add(self, groups: Mapping[str, Group]) -> None:
        """Add groups to a run that has ended."""
        if self.stream is not None:
            self.stream.add(groups)
        for path, group in groups.items():
            before = self.groups.get(path)
            self.groups[path] = group if before is None else before.joined(group)

    def has_room(self, extra: int) -> bool:
        """True where the disk has room for more bytes in the file of a run that has ended."""
        return self.stream is None or self.stream.has_room(extra)

    @property
    def written(self) -> tuple[int, int]:
        """Bytes and CRC-32 of the file."""
        return len(self.image), zlib.crc32(self.image)

    def result(self) -> Result:
        """The run, once it is stored."""
        if self.target is None:
            return MemoryResult(self.reader(), self._file)
        if self.stream is not None:
            return Result(self.target)
        return HeldResult(self.target, self.reader())

    # --- its file
    @property
    def path(self) -> Path:
        """Place of the file; a temporary one where none was given."""
        if self.target is None:
            self.target = temporary_file()
        return self.target

    @property
    def placed(self) -> bool:
        """True once the file has its name, or the run needs none."""
        return self.stored or (self.stream is not None and self.stream.placed)

    @property
    def remains(self) -> str:
        """Description of the files of a run that ended early."""
        if self.stream is not None:
            return self.stream.remains
        if self.ended is None:
            return f"{self.target or 'a file'} was not written"
        return f"what was computed is stored in {self.path}"

    def store(self) -> None:
        """Write the file of a run that has ended, where it has a path.

        Raises Unwritable where the disk has no room for it; the part that fits is stored.
        """
        try:
            if self.stream is None and self.ended is not None:
                if self.target is not None:
                    self.image = self._file()
                    self._write()
                self.stored = True
        finally:
            if self.lock is not None:
                self.lock.release()

    def _write(self) -> None:
        try:
            replace_file(self.target, self.image)
        except OSError as error:
            if self.lasting and error.errno in FULL:
                self._keep_what_fits(Unwritable(self.target, error.errno))
            raise

    def _keep_what_fits(self, reason: Unwritable) -> None:
        """The pieces that a full disk takes, as of a run that ended early."""
        with suppress(Unwritable):
            self.go_on()
        if self.stream is not None:
            self.stream.full = True
            self.stream.close(f"partial: {reason}", *self.ended[1:])
        raise reason

    def _file(self) -> bytes:
        """The file, from the image of one like it where the store has it."""
        from clearance.results import hdf5_image

        attributes, growing, tables = content = self._content()
        if self.content.compression or not hdf5_image.available():
            return self._from_hdf5(*content)[0]
        shapes = hdf5_image.likeness(attributes, growing, tables, self.rows_in_chunk)
        named = tuple(self.channels[i] for i in self.kept), *spots(self.channels)
        key = *named, self.rows_in_chunk, shapes
        image, data = _images.get(key), b""
        if image is None:
            # many processes write one file, or few that are alike
            lasting = not _images or key in _images
            image, data = self._image(key, content, lasting)
            while len(_images) >= MOST_IMAGES:
                del _images[next(iter(_images))]
            _images[key] = image
        return data or bytes(image.filled(attributes, growing | tables))

    def _image(self, key: tuple, content: tuple, lasting: bool) -> "tuple[Image | None, bytes]":
        """The image of files like this from the store, or the file, and its image where that is to
        last.
        """
        from clearance.machine import store
        from clearance.results.hdf5_image import Image, made_from

        text, data = f"{made_from()} {key}", b""
        name = f"image_{hashlib.sha256(text.encode()).hexdigest()[:32]}"

        def make() -> bytes:
            nonlocal data
            data, image = self._from_hdf5(*content)
            return image.packed() if image else b""

        if not lasting and not store.file_of(name).exists():
            return None, self._from_hdf5(*content)[0]
        packed, _ = store.stored(name, make)
        image = Image.unpacked(packed) if packed else None
        return image, data or (b"" if image else self._from_hdf5(*content)[0])

    def _from_hdf5(self, attributes, growing, tables) -> "tuple[bytes, Image | None]":
        """The file as HDF5 makes it, and its image where it has one."""
        from clearance.results.hdf5_image import Image, Unknown

        maker = ImageSink(self.target or Path("run.h5"), self.content)
        self.hand_on(maker)
        maker.close(*self.ended, self.groups)
        with maker.file as file:
            try:
                image = Image.of(maker.image, file, attributes, growing | tables)
            except Unknown:
                image = None
        return maker.image, image

    def _content(self) -> "tuple[Attributes, dict, dict]":
        """Attributes of the file, columns that grow with the run, and those of other tables."""
        ranges, groups = self.ended[-1], self.groups_at_end(self.ended[-1])
        attributes = {n: checked(a) for n, a in self._about_groups(groups).items()}
        if ranges is not None:
            attributes |= {self.channels[i].path: {"actual_range": ranges.of(i)} for i in self.kept}
        growing = self._growing()
        growing |= {f"events/{n}": np.char.encode(growing[f"events/{n}"]) for n in EVENT_TEXTS}
        return attributes, growing, _tables(groups)

    def _about_groups(self, groups: Mapping[str, Group]) -> dict[str, dict]:
        """Attributes of the groups of the file."""
        attributes = closing(*self.ended[:-1])
        for path, group in groups.items():
            if group.attributes:
                attributes[path] = {**attributes.get(path, {}), **group.attributes}
        attributes[""] = {**self.about, **attributes[""]}
        return attributes

    def reader(self) -> MemoryReader:
        """A reader of what the file holds, as it holds it."""
        return MemoryReader(Later(self._ready), self._all, self.target)

    def _ready(self) -> dict[str, Mapping]:
        """Attributes of the file and of its solver."""
        ended = closing(*self.ended[:3], {})
        added = self.groups[""].attributes if "" in self.groups else {}
        return {"": {**self.about, **ended[""], **added}, "solver": ended["solver"]}

    def _all(self) -> tuple[dict, dict]:
        """All columns, and the attributes of groups and columns."""
        groups, ranges = self.groups_at_end(self.ended[-1]), self.ended[-1]
        channels = [(i, self.channels[i]) for i in self.kept]
        texts = columns_of(c for _, c in channels)
        texts |= {f"{p}/{n}": g.about[n] for p, g in groups.items() for n in g.columns}
        about = {path: dict(zip(ABOUT, pair, strict=True)) for path, pair in texts.items()}
        for i, channel in channels if ranges else ():
            about[channel.path]["actual_range"] = ranges.of(i)
        columns = self._growing() | _tables(groups)
        times = {c.path.rpartition("/")[0] + "/time" for _, c in channels}
        columns |= dict.fromkeys(times, columns["time"])
        about |= dict.fromkeys(times, about["time"])
        return columns, self._about_groups(groups) | about

    def groups_at_end(self, ranges: Ranges | None) -> dict[str, Group]:
        """Groups of the file: located extremes, and what has been added."""
        groups = ranged(ranges)
        for path, group in self.groups.items():
            groups[path] = groups[path].joined(group) if path in groups else group
        return groups

    def _growing(self) -> Arrays:
        """Columns along time, contacts and steps."""
        taken, contacts, steps = self.samples, self.contacts(), self.step_log()
        columns = {self.channels[i].path: taken.column(i) for i in self.kept}
        columns = {"time": taken.times} | columns
        columns |= {f"events/{n}": values for n, values in contacts.items()}
        columns |= {f"solver/{n}": steps[:, i] for i, n in enumerate(SOLVER_COLUMNS)}
        lengths = {"events": len(contacts["time"]), "solver": len(steps)}
        return columns | {f"{g}/{d}": np.zeros(lengths[g], ">f4") for g, d in DIMENSIONS.items()}


def _tables(groups: Mapping[str, Group]) -> Arrays:
    """Columns of groups, by path."""
    return {
        f"{p}/{n}": values for p, group in groups.items() for n, values in group.columns.items()
    }
