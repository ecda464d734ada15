"""Springs with dampers: between two points, and between two bodies."""

from dataclasses import dataclass

from clearance import checks
from clearance.body import Body, Point
from clearance.elements.load import Load
from clearance.quantities import ZERO, number


class Spring(Load):
    """Base of springs with dampers."""

    group = "springs"
    lost = "work the damper has taken out since the start"

    def __post_init__(self):
        super().__post_init__()
        a, b = self.bodies()
        for body in (a, b):
            if not isinstance(body, Body):
                raise TypeError(f"{self.label()} acts between two bodies, got {body!r}")
        if a is b:
            raise ValueError(f"{self.label()} acts between body {a.name!r} and itself")


@checks.answers
@dataclass(frozen=True)
class SpringDamper(Spring):
    """Linear spring and damper between two points.

    Tension k (l - free_length) + damping l' along the line of the points; stiffness k [N/m], damping [N s/m],
    free_length [m]. It lies parallel to the plane of motion: a point's z gives its force an arm, and l no more length.
    """

    a: Point
    b: Point
    stiffness: float = number("stiffness [N/m]", checks.non_negative, 0.0, fold=ZERO)
    damping: float = number("damping [N s/m]", checks.non_negative, 0.0, fold=ZERO)
    free_length: float = number("length without tension [m]", checks.non_negative, 0.0, fold=ZERO)
    name: str | None = None

    kind = "spring"
    holds_free_bodies = True

    def bodies(self) -> tuple[Body, Body]:
        return self.a.body, self.b.body

    def act(self, m, w) -> None:
        (ax, ay), (bx, by) = m.point(self, "a"), m.point(self, "b")
        x, y = bx - ax, by - ay
        length = m.trace.sqrt(x.v * x.v + y.v * y.v + 1e-300)
        stiffness, damping = m.number(self, "stiffness"), m.number(self, "damping")
        stretch = length - m.number(self, "free_length")
        rate = (x.d * x.v + y.d * y.v) / length
        tension = stiffness * stretch + damping * rate
        pull = -tension / length
        w.at(self, "a", -(pull * x.v), -(pull * y.v))
        w.at(self, "b", pull * x.v, pull * y.v)
        w.store(0.5 * stiffness * stretch * stretch)
        w.lose(self, damping * rate * rate)
        w.show(self, "length", "m", "length", length)
        w.show(self, "tension", "N", "tension of spring and damper", tension)


@checks.answers
@dataclass(frozen=True)
class TorsionSpring(Spring):
    """Linear torsion spring and damper between two bodies, free at relative angle theta_b - theta_a = free_angle.

    stiffness [N m/rad], damping [N m s/rad], free_angle [rad].
    """

    a: Body
    b: Body
    stiffness: float = number("stiffness [N m/rad]", checks.non_negative, 0.0, fold=ZERO)
    damping: float = number("damping [N m s/rad]", checks.non_negative, 0.0, fold=ZERO)
    free_angle: float = number("relative angle without moment [rad]", checks.finite, 0.0, fold=ZERO)
    name: str | None = None

    kind = "torsion_spring"

    def bodies(self) -> tuple[Body, Body]:
        return self.a, self.b

    def act(self, m, w) -> None:
        stiffness, damping = m.number(self, "stiffness"), m.number(self, "damping")
        twist = m.turned(self.b) - m.turned(self.a) - m.number(self, "free_angle")
        rate = m.spin(self.b) - m.spin(self.a)
        moment = stiffness * twist + damping * rate
        w.add(self.a, moment=moment)
        w.add(self.b, moment=-moment)
        w.store(0.5 * stiffness * twist * twist)
        w.lose(self, damping * rate * rate)
