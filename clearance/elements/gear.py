"""Meshing teeth: two wheels on one carrier, or a wheel and a rack."""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from clearance.elements.body import Body
from clearance.elements.prismatic import Prismatic
from clearance.elements.quantities import ZERO, Row, law, number
from clearance.elements.revolute import Revolute
from clearance.elements.springs import Spring
from clearance.laws.law import BoundLaw, spring
from clearance.values import checks

APART = 0.02  # deflection of teeth at the start over the pitch radius, beyond any play


def _angle(hinge: Revolute, starts: Mapping[str, float]) -> float:
    """Start angle of a hinge; starts: of driven parts, by their keys."""
    a, b = (starts.get(p.body.key, p.body.angle) for p in (hinge.a, hinge.b))
    return starts.get(hinge.key, b - a)


@checks.answers
@dataclass(frozen=True)
class Gear(Spring):
    """Meshing teeth of a wheel and a second wheel or a rack, which one carrier bears; it may move.

    first: Revolute of the wheel, second: Revolute of the other wheel or Prismatic of the rack, both
        with the carrier as body a. ratio i: turn of the second wheel over that of the first [-]. It
        is negative for external teeth, between 0 and 1 for a pinion in a ring. Of a rack it is the
        pitch radius of the wheel [m/rad]; the rack lies to the right of its axis where it is
        positive.
    The teeth are elastic along the pitch line, so that a mesh force F follows from its deflection:

        d = s (i q1 - q2 + phase),   F = k d + c d',
        s: pitch radius of the second wheel; of a rack 1

    stiffness k [N/m], damping c [N s/m]; mesh: a `spring` law of d and d' in their place, such as
    backlash. F acts at the pitch point on both bodies; pressure_angle a [rad] adds |F| tan(a),
    which presses the wheels apart. Pitch radii follow from the ratio and the distance of the
    hinges.
    phase [rad or m]: of the teeth at the start, 0 where q2 = i q1. Stiff teeth, k -> inf, keep q2 =
    i q1.
    Source: Niemann and Winter, Maschinenelemente II, Springer 2003, ch. 21 (steel wheels: k is 14
    to 20 N/(mm um) times the width).
    """

    first: Revolute
    second: Revolute | Prismatic
    ratio: float = number("second coordinate over the first [- or m/rad]", checks.nonzero)
    stiffness: float = number("stiffness [N/m]", checks.non_negative, 0.0, fold=ZERO)
    damping: float = number("damping [N s/m]", checks.non_negative, 0.0, fold=ZERO)
    phase: float = number("phase of the teeth [rad or m]", checks.finite, 0.0, fold=ZERO)
    pressure_angle: float = number(
        "pressure angle [rad]", checks.non_negative, 0.0, parameter=False
    )
    name: str | None = None
    mesh: BoundLaw | None = law("mesh force over deflection and its rate", spring)

    kind, slot = "gear", "mesh"

    def __post_init__(self):
        for name, kinds in (("first", Revolute), ("second", Revolute | Prismatic)):
            if not isinstance(joint := getattr(self, name), kinds):
                raise TypeError(f"Gear: {name} must be a hinge without clearance, got {joint!r}")
        super().__post_init__()
        if self.first.a.body is not self.second.a.body:
            raise ValueError(
                f"{self.label()}: both joints need one carrier as body a, got "
                f"{self.first.a.body.name} and {self.second.a.body.name}"
            )
        if not self.second.slides and self.ratio >= 1.0:
            raise ValueError(
                f"{self.label()}: ratio={self.ratio!r}: "
                "a pinion in a ring has a ratio below 1; put the pinion first"
            )

    def bodies(self) -> tuple[Body, Body]:
        return self.first.b.body, self.second.b.body

    def companions(self) -> dict:
        return {"first joint": self.first, "second joint": self.second}

    def numbers(self) -> Iterator[Row]:
        yield from super().numbers()
        yield f"{self.key}/spread", math.tan(self.pressure_angle), ZERO

    def doubts_at_start(self, drives: Iterable) -> list[str]:
        """Teeth that the start angles press: those of drives, else of bodies."""
        if self.second.slides:
            return []
        starts = {d.target.key: d.motion(0.0) if d.motion else d.start for d in drives}
        starts = {key: start for key, start in starts.items() if start is not None}
        first, second = (_angle(j, starts) for j in (self.first, self.second))
        meshing = second - self.ratio * first
        if abs(meshing - self.phase) <= APART:
            return []
        reason = f"the start angles of the wheels press its teeth; phase={meshing:.6g} meshes them"
        return [f"{self.label()}: {reason}"]

    def act(self, m, w) -> None:
        ratio = m.number(self, "ratio")
        x, y = (c.v for c in m.point(self.first, "b"))
        (rx, ry), (tx, ty), scale = self._pitch(m, ratio, x, y)
        first = m.coordinate(self.first)
        second = m.coordinate(self.second)
        deflection = scale * (ratio * first.v - second.v + m.number(self, "phase"))
        force = self.pull(m, w, deflection, scale * (ratio * first.d - second.d))
        size = abs(force) * m.number(self, "spread")
        apart = size / m.trace.sqrt(rx * rx + ry * ry)
        fx = force * tx + apart * rx
        fy = force * ty + apart * ry
        for body, sign in zip(self.bodies(), (-1.0, 1.0), strict=True):
            pose = m.pose(body)
            w.add_at(body, (x + rx - pose.x, y + ry - pose.y, 0.0), sign * fx, sign * fy)
        w.show(self, "deflection", "m", "deflection of the teeth along the pitch line", deflection)
        w.show(self, "force", "N", "mesh force on the second body along the pitch line", force)

    def _pitch(self, m, ratio, x, y) -> tuple:
        """From the first hinge, at (x, y), to the pitch point; the pitch line; the radius there."""
        if self.second.slides:
            dx, dy = m.axis(self.second)
            return (ratio * dy, -(ratio * dx)), (dx, dy), 1.0
        to = m.point(self.second, "b")
        dx = to[0].v - x
        dy = to[1].v - y
        share = 1.0 / (ratio - 1.0)
        distance = m.trace.sqrt(dx * dx + dy * dy)
        radius = ratio * share
        line = -(dy / distance), dx / distance
        return (radius * dx, radius * dy), line, share * distance
