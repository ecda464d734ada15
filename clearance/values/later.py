"""Mappings that are made where somebody looks into them."""

from collections.abc import Callable, Mapping
from functools import cached_property


class Later(Mapping):
    """A mapping that is made where somebody looks into it; make: makes it."""

    def __init__(self, make: Callable[[], Mapping]):
        self._make: Callable[[], Mapping] | None = make

    @cached_property
    def _made(self) -> Mapping:
        made, self._make = self._make(), None
        return made

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
