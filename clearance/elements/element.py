"""An element is anything in a scene: a joint, a drive, a spring, a force.

Its file defines all of it: numbers with unit and check, states, closing equations, applied forces,
contacts and outputs. The compiler uses nothing else.
"""

from collections.abc import Iterable, Iterator
from dataclasses import Field, dataclass, fields
from typing import ClassVar

from clearance.elements.body import Body, Point, as_point
from clearance.elements.quantities import Described, Row, fields_of
from clearance.laws.law import BoundLaw
from clearance.laws.materials import Material
from clearance.values import checks

WARMING = 10.0  # natural size of a warming [K]


@dataclass(frozen=True)
class State:
    """A state of an element. order 2: a coordinate that has a rate; 1: a state whose rate `act`
    gives.

    size: natural size; start, start_rate: at t = 0, in the unit.
    """

    name: str
    unit: str
    size: float
    order: int = 2
    start: float = 0.0
    start_rate: float = 0.0


@dataclass(frozen=True)
class Spot:
    """A place where an element may touch, which the time loop watches.

    reach: its free way [m]; speed: that of its start [m/s]; name: empty where an element has one
        only. longest: length that its penetration is a difference of beside its states [m].
    """

    kind: int
    reach: float
    speed: float = 0.0
    name: str = ""
    longest: float = 0.0

    def path(self, element: "Element", quantity: str) -> str:
        """Path of an output of this spot."""
        return f"{element.key}/{quantity}" + (f"_{self.name}" if self.name else "")

    def label(self, element: "Element") -> str:
        """Name in tables of impacts: that of the element, with the spot's where it has several."""
        return f"{element.name}/{self.name}" if self.name else element.name


class Element(Described):
    """Base of all parts of a scene. Subclasses are frozen dataclasses with a name."""

    #: folder of result files that its outputs stand in, and what it takes out of the mechanism, in
    #: words
    group = "loads"
    name: str | None
    __dataclass_fields__: ClassVar[dict[str, Field]]
    lost = "work the element has taken out since the start"
    holds_free_bodies = False  # True: a body that only this element holds may float in the plane

    def label(self) -> str:
        """Name of the element in messages."""
        return f"{type(self).__name__} {self.name}"

    @property
    def key(self) -> str:
        """Folder of its outputs in result files, and of its numbers in the parameter vector."""
        return f"{self.group}/{self.name}"

    def bodies(self) -> tuple[Body, ...]:
        """The bodies it acts on: those among its fields, and those of its points."""
        values = [getattr(self, field.name) for field in fields_of(type(self))]
        parts = [value.body if isinstance(value, Point) else value for value in values]
        return tuple(part for part in parts if isinstance(part, Body))

    def companions(self) -> dict[str, "Element"]:
        """Other elements that must stand in the scene with it, by what they are to it."""
        return {}

    def doubts_at_start(self, drives: Iterable) -> list[str]:
        """Warnings about the start of the scene, which drives decide, too."""
        return []

    # --- fields
    def _check_fields(self) -> None:
        """Check all points, materials, numbers and laws, as their fields declare them."""
        for field in fields(self):
            value = getattr(self, field.name)
            if field.type in (Point, "Point"):
                self._set(field.name, as_point(self.label(), value))
            if field.type in (Material, "Material"):
                self._set(field.name, Material.of(self.label(), field.name, value))
        super()._check_fields()

    def numbers(self) -> Iterator[Row]:
        for field in fields_of(type(self)):
            value = getattr(self, field.name)
            if isinstance(value, Point):
                yield from value.numbers(f"{self.key}/{field.name}")
        yield from super().numbers()

    @property
    def facts(self) -> dict[str, float | str]:
        """Its kind, numbers and the names of its laws, which result files keep as attributes."""
        values = {f.name: getattr(self, f.name) for f in fields(self)}
        laws = {n: v.law.name for n, v in values.items() if isinstance(v, BoundLaw)}
        numbers = {n: v for n, v in values.items() if isinstance(v, float)}
        return {"type": type(self).__name__} | {
            n: (laws | numbers)[n] for n in values if n in laws or n in numbers
        }

    # --- for the compiler
    def states(self) -> list[State]:
        """States of its own."""
        return []

    def spots(self) -> list[Spot]:
        """Places where it may touch."""
        return []

    def act(self, m, w) -> None:
        """Forces, rates of states, powers and contacts that follow from place and motion.

        m: Motion, see mechanism/motion.py; w: Work, see mechanism/dynamics.py.
        """

    def outputs(self, m) -> Iterable[tuple]:
        """(name, unit, description, value) of outputs that need accelerations and reactions."""
        return ()


class Load(Element):
    """An element that joins nothing, such as a drive, a spring or a force; its name is by default
    that of its kind.

    feeds: whether it puts power into the mechanism; springs give back what they took.
    """

    kind, feeds = "load", True

    def __post_init__(self):
        name = self.name if self.name is not None else self.kind
        self._set("name", checks.identifier(f"{type(self).__name__} name", name))
        self._check_fields()
