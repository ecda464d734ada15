"""Joints: two points on two bodies, and which of three relative coordinates are free.

Beside them the parts that kinds of joints share: of those without clearance the reaction and the
friction that it makes, of those with clearance the contact of their bodies.
"""

from collections import namedtuple
from collections.abc import Iterable, Iterator
from dataclasses import Field, dataclass, fields

from clearance.elements.body import Body, Point
from clearance.elements.element import Element, State
from clearance.elements.quantities import UNIT, ZERO, Row, number
from clearance.laws.law import BoundLaw, bristle, joint_bristle, joint_friction
from clearance.laws.materials import Lubricant
from clearance.values import checks
from clearance.values.spots import CONTACT, FILM

#: relative coordinates: of point b against point a along and across the joint's axis, and of b's
#: frame against a's
ALONG, ACROSS, TURN = "along", "across", "turn"
RELATIVE = (ALONG, ACROSS, TURN)


@dataclass(frozen=True)
class Known:
    """A relative coordinate that the joint does not leave free: a number of it, a state of it, or
    both together; without either zero.
    """

    number: str = ""
    state: str = ""


#: name, unit and axis of reactions out of the plane
OUT_OF_PLANE = (("axial_force", "N", "z"), ("bending_x", "N m", "x"), ("bending_y", "N m", "y"))
#: a relative coordinate that the joint leaves to the mechanism, and one that it keeps at zero
FREE, CLOSED = "free", Known()


def axis_field() -> Field:
    """A field for the direction (x, y) of a joint's axis in a's frame, of any length but zero."""
    return number("axis [-]", checks.direction, (1.0, 0.0), fold=UNIT, parts=("x", "y"))


class Joint(Element):
    """Base of all joints: points a and b on two different bodies.

    along, across, turn: FREE or Known, the kinematics of the joint.
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
    #: what only some joints have, see their fields
    contact = None
    film = None
    friction = None
    roughness = None
    transition = asperity = elastic = heat = None
    outline = wear = wear_journal = None
    through_wall = False  # whether its film goes over into contact
    rough_layer = False  # whether summits press back the layer that its film stands on
    arms: tuple[str, ...] = ()

    def __post_init__(self):
        kind = type(self).__name__
        names = [
            p.body.name if isinstance(p, Point) else getattr(p, "name", "?")
            for p in (self.a, self.b)
        ]
        name = self.name if self.name is not None else "-".join(names)
        self._set("name", checks.identifier(f"{kind} name", name))
        self._check_fields()
        if self.a.body is self.b.body:
            raise ValueError(f"{self.label()} joins body {self.a.body.name!r} to itself")

    def label(self) -> str:
        return f"joint {self.name}"

    def bodies(self) -> tuple[Body, Body]:
        """The two bodies it joins."""
        return self.a.body, self.b.body

    @property
    def driven(self) -> str | None:
        """The coordinate that a drive moves: the only free one, a turn or a displacement along the
        axis.
        """
        single = self.free == (TURN,) or self.free == (ALONG,) and self.turns
        return self.free[0] if single and not self.soft else None

    @property
    def first_touch(self) -> bool:
        """True where contact begins with a touch, and not gradually."""
        return True

    @property
    def impacts(self) -> bool:
        """True where its contact starts with a first touch."""
        return any(spot.kind == CONTACT for spot in self.spots())

    @property
    def film_reach(self) -> float | None:
        """Free way [m] of a joint whose surfaces only a film keeps apart; None for others."""
        return next((spot.reach for spot in self.spots() if spot.kind == FILM), None)

    def side(self, body: Body) -> str:
        """ "b" or "a": the side that a body stands on."""
        return "b" if body is self.b.body else "a"

    def sign(self, body: Body) -> float:
        """+1 for body b, which relative coordinates move; -1 for body a."""
        return 1.0 if body is self.b.body else -1.0

    @property
    def free(self) -> tuple[str, ...]:
        """Names of the relative coordinates that it leaves free."""
        return tuple(axis for axis in RELATIVE if getattr(self, axis) is FREE)

    @property
    def soft_coordinates(self) -> list[tuple[str, str]]:
        """Relative coordinates that are states, with the names of these."""
        coordinates = [(axis, getattr(self, axis)) for axis in RELATIVE]
        return [(axis, k.state) for axis, k in coordinates if k is not FREE and k.state]

    @property
    def soft(self) -> bool:
        """True where some relative coordinate is a state: only forces hold the joint together."""
        return bool(self.soft_coordinates)

    @property
    def slides(self) -> bool:
        """True where the free coordinate that a drive or friction acts on is a displacement."""
        return self.along is FREE and self.turns

    def outputs(self, m) -> Iterable[tuple]:
        """The reaction of a joint that nothing but itself keeps together, in the plane and out of
        it.
        """
        if self.soft:  # its forces are known before, and `act` shows them
            return
        fx, fy, moment = m.reaction(self)
        body = self.b.body.name
        words = ""
        if self.slides:  # all that passes from a to b there
            effort, parts = self.efforts_along(m)
            dx, dy = m.axis(self)
            fx += effort * dx
            fy += effort * dy
            words = f", with that of {' and '.join(parts)} along the slide" if parts else ""
        for axis, value in (("x", fx), ("y", fy)):
            yield f"force_{axis}", "N", f"force {axis} on {body}{words}", value
        if self.turn is not FREE:
            yield "moment", "N m", f"moment on {body} about its joint point", moment
        for (name, units, axis), value in zip(OUT_OF_PLANE, m.reaction_across(self), strict=False):
            meaning = "force" if units == "N" else "moment about the joint point,"
            yield name, units, f"{meaning} {axis} on {body}, out of the plane", value

    def efforts_along(self, m) -> tuple:
        """Efforts along a slide that its reaction does not include, and all that act there, in
        words.

        The effort of a drive that prescribes the motion stands in the reaction already.
        """
        drives = m.drives_of(self)
        effort = m.trace.sum(m.effort(d) for d in drives if not d.prescribes)
        return effort, [f"drive {d.name}" for d in drives]

    #: numbers that film laws of hinges read of it
    film_joint = None

    def facts_for(self, slot: str):
        """Numbers of the joint from which the law in a field makes its data, such as a film
        table.
        """
        return self.film_joint

    def seen_by(self, slot: str):
        """Surfaces that the law in a field reads: radius, clearance, length, material, layer of the
        surfaces.
        """
        return self

    @property
    def solid(self) -> tuple[float, str]:
        """Size [m] of the body that a penetration strains, and its name."""
        raise NotImplementedError

    def ideal(self) -> "Joint":
        """The same joint without clearance and friction, which carries nothing out of the plane."""
        raise NotImplementedError

    def place_of(self, states: dict[str, float]) -> str:
        """Its offsets in words; states: by name."""
        units = {state.name: state.unit for state in self.states()}
        return ", ".join(f"{name} {value:.6g} {units[name]}" for name, value in states.items())

    def at_end(self, outputs: dict[str, float]) -> str | None:
        """A warning about where it ends; outputs: its last ones, by name."""
        return None

    def doubts(self) -> list[str]:
        """Warnings about its numbers, and of its laws about their use in it."""
        slots = [(f.name, getattr(self, f.name)) for f in fields(self)]
        laws = [(n, v) for n, v in slots if isinstance(v, BoundLaw) and v.law.doubt]
        texts = [(v.law.name, v.law.doubt(self.seen_by(n), v.parameters)) for n, v in laws]
        named = [t if t.startswith(n) else f"{n}: {t}" for n, t in texts if t]
        return super().doubts() + [f"{self.label()}: {t}" for t in named]

    def _determine(self, *slots: str) -> None:
        """Give laws the parameters that this joint determines.

        Raises ValueError naming field and law.
        """
        for slot in slots:
            law = getattr(self, slot)
            try:
                self._set(slot, law and law.of(self.seen_by(slot)))
            except ValueError as error:
                raise ValueError(f"{self.label()}: {slot} {law.law.name}: {error}") from None

    def _check_laws(self) -> None:
        """Laws that cannot stand in this joint."""
        for field in fields(self):
            value = getattr(self, field.name)
            demand = value.law.demand if isinstance(value, BoundLaw) else None
            if demand and (missing := demand(self.seen_by(field.name), value.parameters)):
                raise ValueError(f"{self.label()}: {field.name} {value.law.name} {missing}")


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
        effort = friction.efforts[self]
        body = self.b.body.name
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
            raise ValueError(
                f"{self.label()}: film needs lubricant=Lubricant(viscosity), got {self.lubricant!r}"
            )
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
