"""Joints without clearance: their reaction, and the friction that it makes."""

from collections.abc import Iterable, Iterator

from clearance.elements.element import State
from clearance.elements.joint import Joint
from clearance.elements.quantities import ZERO, Row
from clearance.laws.law import joint_bristle, joint_friction

FRICTIONS = (joint_friction, joint_bristle)


class FrictionJoint(Joint):
    """Base of the joints without clearance: friction made by their own reaction, and what they
    carry.

    friction: a bound `joint_friction` or `joint_bristle` law, or None. self_aligning: the joint
        transmits no axial force and no bending moment. A closed loop needs at least one such joint,
        else loads out of the plane are statically indeterminate.
    """

    #: fields that make a load of the reaction, and the ones that every load-dependent law needs
    arms: tuple[str, ...] = ()
    needed: tuple[str, ...] = ()
    #: the function that makes a friction load of the components that rub
    load = None
    #: the field that makes friction torques of hinges comparable with forces of slides
    arm: str | None = None

    def __post_init__(self):
        super().__post_init__()
        law, label = self.friction, self.label()
        if law is None:
            return
        if law.law.needs_load and (missing := [n for n in self.needed if getattr(self, n) is None]):
            raise ValueError(
                f"{label}: friction {law.law.name} is made by the reaction and needs {missing[0]} "
                f"[m]"
            )
        self._check_laws()

    @property
    def geometry(self) -> dict[str, float]:
        """Numbers that make a friction load of the reaction, in the order of `load`."""
        raise NotImplementedError

    @property
    def carries_across(self) -> bool:
        return not self.self_aligning

    @property
    def rubs_by_load(self) -> bool:
        """True where its friction depends on its reaction."""
        return self.friction is not None and self.friction.law.needs_load

    def numbers(self) -> Iterator[Row]:
        yield from super().numbers()
        for name, value in self.geometry.items() if self.rubs_by_load else ():
            yield f"{self.key}/{name}", value, ZERO

    def states(self) -> list[State]:
        law = self.friction
        if law is None or law.law.family is not joint_bristle:
            return []
        return [State("bristle_deflection", self.units[0], law.law.size(law.values), order=1)]

    @property
    def units(self) -> tuple[str, str]:
        """Units of the coordinate that friction acts on, and of its effort."""
        return ("m", "N") if self.slides else ("rad", "N m")

    def components(self, m, reaction: tuple, across: tuple) -> list:
        """Components of the reaction that rub: arguments of `load`.

        reaction: force x, y and moment on body b at its point; across: axial force, bending moments
            x, y.
        """
        raise NotImplementedError

    def through(self, arm: str, meaning: str, *values) -> tuple:
        """Values that rub through an arm, which the joint must then have."""
        if getattr(self, arm) is None and not all(
            isinstance(v, float) and v == 0.0 for v in values
        ):
            raise ValueError(
                f"{self.label()}: carries {meaning} from out of the plane, so friction "
                f"{self.friction.law.name} needs "
                f"{arm} [m] (or self_aligning=True)"
            )
        return values

    def outputs(self, m) -> Iterable[tuple]:
        """Its reaction, and its friction."""
        yield from super().outputs(m)
        if self.friction is not None:
            yield from self._friction_outputs(m)

    def efforts_along(self, m) -> tuple:
        effort, words = super().efforts_along(m)
        if self.friction is None:
            return effort, words
        return effort + m.friction.efforts[self], [*words, "friction"]

    def _friction_outputs(self, m) -> Iterable[tuple]:
        friction, (unit, units) = m.friction, self.units
        effort, body = friction.efforts[self], self.b.body.name
        kind = "force" if self.slides else "torque"
        text = f"friction {kind} on {body}, opposed to its motion against {self.a.body.name}"
        yield "friction", units, text, effort
        if self.states():
            value = m.state(self, "bristle_deflection").v
            yield "bristle_deflection", unit, "deflection of the friction law's bristles", value
        if self in friction.loads:
            yield (
                "friction_load",
                units,
                "what friction makes of the reaction",
                friction.loads[self],
            )
        power = -effort * friction.rates[self]
        yield "power_loss", "W", "power the joint takes out of the mechanism", power
