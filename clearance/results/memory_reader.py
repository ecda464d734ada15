"""The content of a result file that need not be made: read as that file would be."""

from collections.abc import Callable, Mapping
from functools import cached_property
from pathlib import Path

import numpy as np

from clearance.results.hdf5_image import Attributes, Columns
from clearance.results.reading import Damaged, Entries, Missing, Reader


class MemoryReader(Reader):
    """Groups and columns in memory, with the names, kinds and copies that a file of them has.

    ready: attributes of some groups; content: makes the columns by path, texts among them, and the
    attributes of all groups and columns. path: of the file, where there is one.
    """

    def __init__(
        self,
        ready: Attributes,
        content: Callable[[], tuple[Columns, Attributes]],
        path: Path | None = None,
    ):
        self.path = path or Path("the result")
        self._ready, self._make, self.closed = ready, content, False

    @property
    def is_open(self) -> bool:
        return not self.closed

    @cached_property
    def _content(self) -> tuple[Columns, Attributes]:
        return self._make()

    @property
    def _columns(self) -> Columns:
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
