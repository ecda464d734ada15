"""Values that are made where somebody looks into them."""

from collections.abc import Callable, Mapping
from functools import cached_property


class Postponed:
    """Base of what is made where somebody looks into it; make: makes it, and is let go then."""

    def __init__(self, make: Callable):
        self._make: Callable | None = make

    @cached_property
    def _content(self):
        content, self._make = self._make(), None
        return content


class Later(Postponed, Mapping):
    """A mapping that is made where somebody looks into it."""

    def __getitem__(self, key):
        return self._content[key]

    def __iter__(self):
        return iter(self._content)

    def __len__(self) -> int:
        return len(self._content)

    def __or__(self, other: Mapping) -> dict:
        return {**self, **other}

    def __ror__(self, other: Mapping) -> dict:
        return {**other, **self}
