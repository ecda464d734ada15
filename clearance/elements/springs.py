"""Springs and dampers: between two points, and between two bodies."""

from contextlib import suppress
from dataclasses import dataclass

from clearance.elements.body import Body, Point
from clearance.elements.element import Load, Spot
from clearance.elements.quantities import ZERO, law, number
from clearance.laws.law import BoundLaw, spring
from clearance.values import checks
from clearance.values.spots import BLENDED

#: elongations at which a law is looked at for a free way [m or rad]
SIZES = tuple(10.0**e for e in range(-7, 2))


class Spring(Load):
    """Base of springs with dampers: linear ones, or with a `spring` law in place of both.

    slot: the field that the law stands in.
    """

    group, slot, feeds = "springs", "", False

    def __post_init__(self):
        super().__post_init__()
        if self.by_law and (self.stiffness or self.damping):
            raise ValueError(
                f"{self.label()}: {self.slot} "
                "takes the place of stiffness and damping; leave these out"
            )
        a, b = self.bodies()
        for body in (a, b):
            if not isinstance(body, Body):
                raise TypeError(f"{self.label()} acts between two bodies, got {body!r}")
        if a is b:
            raise ValueError(f"{self.label()} acts between body {a.name!r} and itself")

    @property
    def by_law(self) -> bool:
        """True where a law gives its tension or moment."""
        return getattr(self, self.slot) is not None

    def spots(self) -> list[Spot]:
        law = getattr(self, self.slot)
        if law is None or law.law.engaged is None:
            return []
        return [Spot(BLENDED, law.law.engaged[1](law.values))]

    def doubts(self) -> list[str]:
        texts = super().doubts()
        law = getattr(self, self.slot)
        if law is None or law.law.engaged is not None:
            return texts
        forces = []
        for size in SIZES:
            with suppress(ArithmeticError, ValueError):
                forces += law(-size, 0.0), law(size, 0.0)
        if 0.0 in forces and any(forces):
            reason = (
                "sets in after a free way, which a step may pass; state engaged=, see the guide"
            )
            texts.append(f"{self.label()}: {law.law.name} {reason}, or take max_step")
        return texts

    @property
    def lost(self) -> str:
        """Meaning of what it takes out of the mechanism."""
        by = "its law (stored and lost)" if self.by_law else "the damper"
        return f"work that {by} has taken out since the start"

    def pull(self, m, w, elongation, rate):
        """Its tension or moment; the energy that it stores and takes out."""
        if self.by_law:
            (tension,) = m.law(self, self.slot, [elongation, rate])
            if engaged := getattr(self, self.slot).law.engaged:
                w.spot(self, *m.of_law(self, self.slot, engaged[0], [elongation, rate]))
            w.lose(self, tension * rate)
            return tension
        stiffness = m.number(self, "stiffness")
        damping = m.number(self, "damping")
        w.store(0.5 * stiffness * elongation * elongation)
        w.lose(self, damping * rate * rate)
        return stiffness * elongation + damping * rate


@checks.answers
@dataclass(frozen=True)
class SpringDamper(Spring):
    """Spring and damper between two points.

    Tension k (l - free_length) + damping l' along the line of the points; stiffness k [N/m],
    damping [N s/m], free_length [m]. tension: a `spring` law of l - free_length and l' in their
    place.
    It lies parallel to the plane of motion: a point's z gives its force an arm, and l no more
    length.
    """

    a: Point
    b: Point
    stiffness: float = number(
        "stiffness [N/m]", checks.non_negative, 0.0, fold=ZERO, usual=((1e-6, 1e13),)
    )
    damping: float = number("damping [N s/m]", checks.non_negative, 0.0, fold=ZERO)
    free_length: float = number("length without tension [m]", checks.non_negative, 0.0, fold=ZERO)
    name: str | None = None
    tension: BoundLaw | None = law("tension over elongation and its rate", spring)

    kind, slot = "spring", "tension"
    holds_free_bodies = True

    def act(self, m, w) -> None:
        ax, ay = m.point(self, "a")
        bx, by = m.point(self, "b")
        x, y = bx - ax, by - ay
        length = m.trace.sqrt(x.v * x.v + y.v * y.v + 1e-300)
        rate = (x.d * x.v + y.d * y.v) / length
        tension = self.pull(m, w, length - m.number(self, "free_length"), rate)
        pull = -tension / length
        w.at(self, "a", -(pull * x.v), -(pull * y.v))
        w.at(self, "b", pull * x.v, pull * y.v)
        w.show(self, "length", "m", "length", length)
        w.show(self, "tension", "N", "tension of spring and damper", tension)


@checks.answers
@dataclass(frozen=True)
class TorsionSpring(Spring):
    """Torsion spring and damper between two bodies, free at relative angle
    theta_b - theta_a = free_angle.

    stiffness [N m/rad], damping [N m s/rad], free_angle [rad]. moment: a `spring` law of the twist
    and its rate in their place.
    """

    a: Body
    b: Body
    stiffness: float = number("stiffness [N m/rad]", checks.non_negative, 0.0, fold=ZERO)
    damping: float = number("damping [N m s/rad]", checks.non_negative, 0.0, fold=ZERO)
    free_angle: float = number("relative angle without moment [rad]", checks.finite, 0.0, fold=ZERO)
    name: str | None = None
    moment: BoundLaw | None = law("moment over twist and its rate", spring)

    kind, slot = "torsion_spring", "moment"

    def act(self, m, w) -> None:
        twist = m.turned(self.b) - m.turned(self.a) - m.number(self, "free_angle")
        moment = self.pull(m, w, twist, m.spin(self.b) - m.spin(self.a))
        w.add(self.a, moment=moment)
        w.add(self.b, moment=-moment)
