"""Values that are made where somebody looks into them."""

from collections.abc import Callable, Mapping
from functools import cached_property


class Postponed:
    """Base of what is made where somebody looks into it; make: makes it, and is let go then."""

    def __init__(self, make: Callable):
        self._make: Callable | None = make

    @cached_property
    def _made(self):
        made, self._make = self._make(), None
        return made


class Later(Postponed, Mapping):
    """A mapping that is made where somebody looks into it."""

    def __getitem__(self, key):
        return self._made[key]

    def __iter__(self):
        return iter(self._made)

    def __len__(self) -> int:
        return len(self._made)

    def __or__(self, other: Mapping) -> dict:
        return {**self, **other}

    def __ror__(self, other: Mapping) -> dict:
        return {**other, **self}
