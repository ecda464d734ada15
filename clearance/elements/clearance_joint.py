"""Joints with clearance, whose bodies touch: the parts that all kinds of them share."""

from collections import namedtuple

from clearance.elements.element import State
from clearance.elements.joint import Joint
from clearance.laws.law import bristle
from clearance.laws.materials import Lubricant

#: facts that contact laws read of a body on a flat wall, which is a bore without end
Surfaces = namedtuple("Surfaces", "radius clearance length material layer")


class ClearanceJoint(Joint):
    """Base of joints with clearance: contact, friction at it, and a film, each where the joint has
    it.
    """

    lubricant: Lubricant | None = None

    @property
    def first_touch(self) -> bool:
        """True where contact begins with a touch; with most transitions it sets in gradually."""
        return self.transition is None or self.transition.law.first_touch

    @property
    def impacts(self) -> bool:
        """True where there is contact that begins with a touch."""
        return self.contact is not None and self.first_touch

    @property
    def viscosity(self) -> float | None:
        """Dynamic viscosity of the oil [Pa s]."""
        return None if self.lubricant is None else self.lubricant.viscosity

    def _check_oil(self, size: str, meaning: str) -> None:
        """Raise ValueError where the film lacks its oil, or a size of the joint."""
        if not isinstance(self.lubricant, Lubricant):
            reason = f"film needs lubricant=Lubricant(viscosity), got {self.lubricant!r}"
            raise ValueError(f"{self.label()}: {reason}")
        if getattr(self, size) is None:
            raise ValueError(f"{self.label()}: film needs {meaning} [m]")

    def _bristles(self, *names: str) -> list[State]:
        """States of the friction law's bristles, one for each name; none where it has no
        bristles.
        """
        law = self.friction
        if law is None or law.law.family is not bristle:
            return []
        return [State(name, "m", law.law.size(law.values), order=1) for name in names]

    def rub(self, m, w, sliding, normal, bristles="bristle_deflection", suffix=""):
        """Friction force [N] at a contact, from the sliding speed [m/s] and the normal force [N].

        bristles: name of their state, where the law has some; suffix: names the contact.
        """
        if self.friction.law.family is not bristle:
            return m.law(self, "friction", [sliding, normal])[0]
        deflection = m.state(self, bristles).v
        rate, force = m.law(self, "friction", [deflection, sliding, normal])
        w.rate(self, bristles, rate)
        text = f"deflection of the friction law's bristles{suffix}"
        w.show(self, bristles, "m", text, deflection)
        return force

    def show_force(self, w, force: tuple) -> None:
        """Outputs of the force on body b."""
        for axis, value in zip("xy", force, strict=True):
            w.show(self, f"force_{axis}", "N", f"force {axis} on {self.b.body.name}", value)
