"""Joints: two points on two bodies, and which of three relative coordinates are free."""

from dataclasses import dataclass, fields

from clearance import checks
from clearance.body import Body, Point
from clearance.elements.element import Element
from clearance.laws.law import BoundLaw

#: relative coordinates: of point b against point a along and across the joint's axis, and of b's frame against a's
ALONG, ACROSS, TURN = "along", "across", "turn"
RELATIVE = (ALONG, ACROSS, TURN)


@dataclass(frozen=True)
class Known:
    """A relative coordinate that the joint does not leave free: a number of it, a state of it, or
    both together; without either zero.
    """

    number: str = ""
    state: str = ""


#: a relative coordinate that the joint leaves to the mechanism, and one that it keeps at zero
FREE, CLOSED = "free", Known()


class Joint(Element):
    """Base of all joints: points a and b on two different bodies.

    along, across, turn: FREE or Known, all that there is to say about the joint's kinematics.
    turns: offsets are measured in the frame of body a along `axis`; else along the fixed axes x, y.
    """

    group = "joints"
    lost = "work the joint has taken out since the start (contact: stored and lost)"
    along: Known | str = CLOSED
    across: Known | str = CLOSED
    turn: Known | str = CLOSED
    turns = False
    #: True where it takes axial forces and bending moments
    carries_across = False

    def __post_init__(self):
        kind = type(self).__name__
        given = [p.body.name if isinstance(p, Point) else getattr(p, "name", "?") for p in (self.a, self.b)]
        name = self.name if self.name is not None else "-".join(given)
        self._set("name", checks.identifier(f"{kind} name", name))
        self._check_fields()
        if self.a.body is self.b.body:
            raise ValueError(f"{self.label()} joins body {self.a.body.name!r} to itself")

    def label(self) -> str:
        return f"joint {self.name}"

    def bodies(self) -> tuple[Body, Body]:
        """The two bodies it joins."""
        return self.a.body, self.b.body

    def side(self, body: Body) -> str:
        """"b" or "a": the side that a body stands on."""
        return "b" if body is self.b.body else "a"

    @property
    def free(self) -> tuple[str, ...]:
        """Names of the relative coordinates that it leaves free."""
        return tuple(what for what in RELATIVE if getattr(self, what) is FREE)

    @property
    def soft_coordinates(self) -> list[tuple[str, str]]:
        """Relative coordinates that are states, with the names of these."""
        known = [(what, getattr(self, what)) for what in RELATIVE]
        return [(what, one.state) for what, one in known if one is not FREE and one.state]

    @property
    def soft(self) -> bool:
        """True where some relative coordinate is a state: only forces hold the joint together."""
        return bool(self.soft_coordinates)

    @property
    def slides(self) -> bool:
        """True where the free coordinate that a drive or friction acts on is a displacement."""
        return self.along is FREE

    #: numbers that film laws of hinges read of it
    film_joint = None

    def seen_by(self, slot: str):
        """What the law in a field reads of it: radius, clearance, length, material, layer of the surfaces."""
        return self

    @property
    def solid(self) -> tuple[float, str]:
        """Size [m] of the body that a penetration strains, and its name."""
        raise NotImplementedError

    def ideal(self) -> "Joint":
        """The same joint without clearance and friction, which carries nothing out of the plane."""
        raise NotImplementedError

    def place_of(self, states: dict[str, float]) -> str:
        """Where its own coordinates stand, in words; states: by name."""
        raise NotImplementedError

    def at_end(self, outputs: dict[str, float]) -> str | None:
        """A warning about where it ends; outputs: its last ones, by name."""
        return None

    def doubts(self) -> list[str]:
        """Warnings of its laws about their use in it."""
        slots = [(f.name, getattr(self, f.name)) for f in fields(self)]
        laws = [(n, v) for n, v in slots if isinstance(v, BoundLaw) and v.law.doubt]
        texts = [(v.law.name, v.law.doubt(self.seen_by(n), v.parameters)) for n, v in laws]
        return [f"{self.label()}: {t if t.startswith(n) else f'{n}: {t}'}" for n, t in texts if t]

    def _check_laws(self) -> None:
        """Laws that cannot stand in this joint."""
        for one in fields(self):
            value = getattr(self, one.name)
            demand = value.law.demand if isinstance(value, BoundLaw) else None
            if demand and (missing := demand(self.seen_by(one.name), value.parameters)):
                raise ValueError(f"{self.label()}: {one.name} {value.law.name} {missing}")
