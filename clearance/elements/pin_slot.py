"""A pin in a straight slot, without clearance and with it."""

import math
from dataclasses import dataclass

from clearance.elements.body import Point
from clearance.elements.element import Spot, State
from clearance.elements.joint import FREE, ClearanceJoint, Joint, Known, Surfaces, axis_field
from clearance.elements.quantities import GAPS, SIZES, law, number, optional, start
from clearance.laws.law import BoundLaw, contact, friction
from clearance.laws.materials import Material, steel
from clearance.values import checks
from clearance.values.spots import CONTACT

#: the walls of the slot: name, and side of the axis
WALLS = (("upper", 1.0), ("lower", -1.0))


@checks.answers
@dataclass(frozen=True)
class PinSlot(Joint):
    """A pin in a slot without clearance: point b stays on the line through point a along `axis`; b
    turns freely.

    axis: direction (x, y) of the slot in a's frame, any length but zero.
    """

    a: Point
    b: Point
    axis: tuple[float, float] = axis_field()
    name: str | None = None

    along, turn, turns = FREE, FREE, True


@checks.answers
@dataclass(frozen=True)
class ClearancePinSlot(ClearanceJoint):
    """A pin (on b, about its point b) in a wider slot (on a, along `axis` through point a): two
    walls.

    radius of the pin [m]; clearance: half the width of the slot less the radius [m]; contact: a
    contact law, bound;
    friction: a friction law, or None. material and length of the pin [m]: for what laws leave to
        the joint. offset [m], offset_rate [m/s]: start of the pin's centre across the slot.
    On either wall, s = +1 for the upper and -1 for the lower one:

        penetration = s e - c,   its rate = s e',
        sliding speed = x' - s r w   (the pin's surface against the wall)

    with the offset e across and the displacement x along the slot, seen from it, and w the spin of
    the pin against it.
    """

    a: Point
    b: Point
    radius: float = number("radius of the pin [m]", checks.positive, usual=SIZES)
    clearance: float = number("half the free width of the slot [m]", checks.positive, usual=GAPS)
    contact: BoundLaw | None = law("contact of pin and wall", contact)
    friction: BoundLaw | None = law("friction at the wall", friction)
    axis: tuple[float, float] = axis_field()
    offset: float = start("start of the pin across the slot [m]")
    offset_rate: float = start("its rate [m/s]")
    name: str | None = None
    length: float | None = optional("length of the pin in the slot [m]", usual=SIZES)
    material: Material = steel

    along = FREE
    across = Known(state="offset")
    turn = FREE
    turns = True

    def __post_init__(self):
        super().__post_init__()
        if self.contact is None:
            raise ValueError(f"{self.label()} needs a contact law")
        self._determine("contact")
        self._check_laws()

    def seen_by(self, slot: str):
        """The pin and a flat wall, for contact laws."""
        return Surfaces(self.radius, math.inf, self.length, self.material, None)

    # --- for diagnosis
    @property
    def solid(self) -> tuple[float, str]:
        return self.radius, "pin radius"

    def ideal(self) -> PinSlot:
        return PinSlot(self.a, self.b, axis=self.axis, name=self.name)

    def place_of(self, states: dict[str, float]) -> str:
        return f"offset {states['offset'] / self.clearance:.9f} c"

    # --- for the compiler
    def states(self) -> list[State]:
        return [State("offset", "m", self.clearance, 2, self.offset, self.offset_rate)]

    def spots(self) -> list[Spot]:
        return [Spot(CONTACT, self.clearance, abs(self.offset_rate), name) for name, _ in WALLS]

    def act(self, m, w) -> None:
        """Normal and friction forces of both walls, about the pin's centre."""
        along = across = moment = power = 0.0
        radius = m.number(self, "radius")
        spin = m.spin(self.b.body) - m.spin(self.a.body)
        offset = m.state(self, "offset")
        advance = m.coordinate(self).d
        w.show(self, "offset", "m", "centre of the pin across the slot", offset.v)
        for i, (name, side) in enumerate(WALLS):
            gap = m.number(self, "clearance") - side * offset.v
            rate = side * offset.d
            depth, speed = m.contact(self, -gap, i)
            (normal,) = m.law(self, "contact", [depth, rate, speed])
            sliding = advance - side * radius * spin
            rub = 0.0
            if self.friction is not None:
                rub = self.rub(m, w, sliding, normal)
                w.show(
                    self,
                    f"friction_{name}",
                    "N",
                    f"friction force on the pin at the {name} wall",
                    rub,
                )
            along += rub
            across -= side * normal
            moment -= side * radius * rub
            power = power + normal * rate - rub * sliding
            w.spot(self, -gap, rate)
            w.show(self, f"gap_{name}", "m", f"gap between the pin and the {name} wall", gap)
            w.show(
                self,
                f"contact_force_{name}",
                "N",
                f"normal contact force of the {name} wall",
                normal,
            )
        size = abs(offset.v)
        w.show(
            self,
            "gap",
            "m",
            "smaller gap of both walls, negative in contact",
            m.number(self, "clearance") - size,
        )
        dx, dy = m.axis(self)
        fx = along * dx - across * dy
        fy = along * dy + across * dx
        w.pair(self, fx, fy, moment)
        w.lose(self, power)
        self.show_force(w, (fx, fy))
        w.show(self, "power_loss", "W", "power the joint takes out of the mechanism", power)
