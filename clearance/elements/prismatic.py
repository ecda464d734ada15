"""Slide without clearance."""

from dataclasses import dataclass

from clearance.elements.body import Point
from clearance.elements.joint import FREE, FRICTIONS, FrictionJoint, Known, axis_field
from clearance.elements.quantities import UNIT, law, number, optional
from clearance.laws.joint_friction import slide_load
from clearance.laws.law import BoundLaw
from clearance.values import checks


@checks.answers
@dataclass(frozen=True)
class Prismatic(FrictionJoint):
    """Slide without clearance: point b stays on the line through point a along `axis`; b does not
    turn relative to a.

    axis: direction (x, y) in a's frame, any length but zero; angle: constant angle of b's frame
        against a's [rad].
    friction, self_aligning: see FrictionJoint. A law that depends on the reaction needs the overlap
    of slide and guide s [m]. Where the slide carries a moment about its own axis, it also needs
    friction_arm R_n [m].
    """

    a: Point
    b: Point
    axis: tuple[float, float] = axis_field()
    angle: float = number("angle of b's frame against a's [rad]", checks.finite, 0.0, fold=UNIT)
    name: str | None = None
    friction: BoundLaw | None = law("friction in the slide", *FRICTIONS)
    overlap: float | None = optional("overlap of slide and guide [m]")
    friction_arm: float | None = optional("arm of the twist [m]")
    self_aligning: bool = False

    along, turn, turns = FREE, Known("angle"), True
    arms = ("overlap", "friction_arm")
    needed = ("overlap",)
    load = staticmethod(slide_load)

    @property
    def geometry(self) -> dict[str, float]:
        inverse = 1.0 / self.friction_arm if self.friction_arm is not None else 0.0
        return {"friction_arm_inverse": inverse, "overlap_inverse": 1.0 / self.overlap}

    def components(self, m, reaction: tuple, across: tuple) -> list:
        fx, fy, moment = reaction
        axial, mx, my = across
        dx, dy = m.axis(self)
        (twist,) = self.through("friction_arm", "a moment about its axis", mx * dx + my * dy)
        return [dx * fy - dy * fx, axial, twist, moment, dx * my - dy * mx]
