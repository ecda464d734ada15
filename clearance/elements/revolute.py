"""Hinge without clearance."""

from dataclasses import dataclass

from clearance.elements.body import Point
from clearance.elements.joint import FREE, FRICTIONS, FrictionJoint
from clearance.elements.quantities import law, optional
from clearance.laws.joint_friction import pin_load
from clearance.laws.law import BoundLaw
from clearance.values import checks


@checks.answers
@dataclass(frozen=True)
class Revolute(FrictionJoint):
    """Hinge without clearance: point b coincides with point a.

    friction, self_aligning: see FrictionJoint. A law that depends on the reaction needs pin_radius
    R_p. Where the hinge carries axial force or bending moments, it also needs friction_arm R_n of
    its thrust face and bending_arm R_b [m].
    """

    a: Point
    b: Point
    name: str | None = None
    friction: BoundLaw | None = law("friction in the pin", *FRICTIONS)
    pin_radius: float | None = optional("radius of the pin [m]")
    friction_arm: float | None = optional("arm of the thrust face [m]")
    bending_arm: float | None = optional("arm of bending reactions [m]")
    self_aligning: bool = False

    turn = FREE
    arms = ("pin_radius", "friction_arm", "bending_arm")
    needed = ("pin_radius",)
    load, arm = staticmethod(pin_load), "pin_radius"

    @property
    def geometry(self) -> dict[str, float]:
        ratio = self.pin_radius / self.bending_arm if self.bending_arm is not None else 0.0
        return {
            "pin_radius": self.pin_radius,
            "friction_arm": self.friction_arm or 0.0,
            "bending_ratio": ratio,
        }

    def components(self, m, reaction: tuple, across: tuple) -> list:
        (fx, fy, _), (axial, mx, my) = reaction, across
        thrust = self.through("friction_arm", "axial force", axial)
        return [fx, fy, *thrust, *self.through("bending_arm", "a bending moment", mx, my)]
