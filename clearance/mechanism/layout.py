"""Places of everything: in the state, the parameter vector, the work vector and a row of
outputs.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property


@dataclass(frozen=True)
class Channel:
    """One output: where it goes in the result file, its unit and what it is.

    wrapped: an angle known in (-pi, pi] only, to be made continuous by its reader.
    """

    path: str
    units: str
    long_name: str
    wrapped: bool = False


@dataclass(frozen=True)
class Layout:
    """The places of a structure's numbers, by their names in result files.

    State: coordinates, their rates, states of first order, the energy put in, and the losses of
    each of `dissipated`. Last come the integrals `sums` (all where there is a ledger). Work: the
    impact speed of each spot, negative in free flight; the coordinates that a step carries to the
    next, (name, of what). Last come the times of the memory of elements. Parameters: those of the
    scene by name, then derived ones.
    followed: numbers that a run hands on step by step.
    """

    coordinates: tuple[str, ...]
    first_order: tuple[str, ...]
    ledger: bool
    dissipated: tuple[str, ...]
    spots: tuple[str, ...]
    carried: tuple[tuple[str, str], ...]
    remembering: tuple[str, ...]
    parameters: dict[str, int]
    derived: int
    channels: tuple[Channel, ...]
    sums: tuple[str, ...] = ()
    followed: tuple[str, ...] = ()

    def renamed(self, renamed: Callable[[str], str]) -> "Layout":
        """The same places, each name passed through a function."""
        paths = (
            "coordinates",
            "first_order",
            "dissipated",
            "spots",
            "remembering",
            "sums",
            "followed",
        )
        return replace(
            self,
            **{attribute: tuple(map(renamed, getattr(self, attribute))) for attribute in paths},
            carried=tuple((axis, renamed(name)) for axis, name in self.carried),
            parameters={renamed(name): index for name, index in self.parameters.items()},
            channels=tuple(
                replace(c, path=renamed(c.path), long_name=renamed(c.long_name))
                for c in self.channels
            ),
        )

    @cached_property
    def size(self) -> int:
        """Number of second-order degrees of freedom."""
        return len(self.coordinates)

    @cached_property
    def rates(self) -> slice:
        """Rates of the coordinates in the state, in the order of these."""
        return slice(self.size, 2 * self.size)

    @cached_property
    def states(self) -> int:
        """Number of first-order states without the ledger."""
        return self.rates.stop + len(self.first_order)

    @cached_property
    def length(self) -> int:
        """Number of first-order states with the ledger."""
        return self.states + (1 + len(self.dissipated) + len(self.sums) if self.ledger else 0)

    @cached_property
    def commits(self) -> int:
        """Number of things that an accepted step carries to the next."""
        return len(self.carried) + len(self.remembering)

    @cached_property
    def work(self) -> int:
        """Length of the work vector."""
        return len(self.spots) + self.commits

    @cached_property
    def names(self) -> list[str]:
        """Names of the states without the ledger, in their order."""
        return [
            *self.coordinates,
            *(f"rate of {name}" for name in self.coordinates),
            *self.first_order,
        ]

    @cached_property
    def state(self) -> dict[str, int]:
        """Place of each state without the ledger, by its name."""
        return {name: i for i, name in enumerate(self.names)}

    @cached_property
    def output(self) -> dict[str, int]:
        """Place of each output in a row, by its path."""
        return {channel.path: i for i, channel in enumerate(self.channels)}

    @cached_property
    def wrapped(self) -> list[str]:
        """Paths of angles that are made continuous."""
        return [channel.path for channel in self.channels if channel.wrapped]

    @cached_property
    def carried_places(self) -> slice:
        """Coordinates that a step carries to the next, in the work vector."""
        return slice(len(self.spots), len(self.spots) + len(self.carried))
