"""View that elements have of a mechanism: numbers, laws, states, places and their rates along the
real motion.
"""

from functools import partial

from clearance.elements.body import Body
from clearance.elements.joint import ALONG, TURN, Joint
from clearance.laws.law import BoundLaw
from clearance.mechanism.kinematics import Jet, Kinematics, Pose, Rates
from clearance.mechanism.loops import wrong_turn
from clearance.tracing.interpreter import traced
from clearance.tracing.trace import Trace, Value
from clearance.values.checks import meant


class Calls:
    """Calls of laws and other plain functions inside a trace. functions: those that have been
    traced already.
    """

    def __init__(self, trace: Trace, number, functions: dict | None = None):
        self.trace, self.number = trace, number
        self.functions = {} if functions is None else functions

    def law(self, element, slot: str, state: list, facts: tuple = ()) -> list:
        """Value(s) of an element's law; `facts` are what laws read of their joint, see
        FilmJoint.
        """
        law = getattr(element, slot).law
        values = self.of(element, slot, law.function, state, facts)
        if len(values) != law.family.outputs:
            raise ValueError(
                f"{law.family.name} law {law.name} must return {law.family.outputs} value(s), not "
                f"{len(values)}"
            )
        return values

    def of(self, element, slot: str, function, state: list, facts: tuple = ()) -> list:
        """A function of a law's arguments; what a law with data reads stands in the parameter
        vector.
        """
        law = getattr(element, slot).law
        numbers = [self.number(f"{element.key}/{slot}/{p}") for p in law.parameters]
        return self.function(function, [*state, *facts, *numbers], law.kinds)

    def function(self, function, args: list, shape: tuple = ()) -> list:
        """Outputs of a plain function."""
        return self.trace.call(self.traced(function, shape), args)

    def traced(self, function, shape: tuple = ()):
        """The function on the trace."""
        if (function, shape) not in self.functions:
            self.functions[function, shape] = traced(function, shape)
        return self.functions[function, shape]


class Motion:
    """The mechanism at one moment, as elements see it.

    velocities: twists of all bodies; impact_speeds: element -> one of each spot; first_order:
        (element, name) -> state that is no coordinate. reactions and friction are there once they
        are solved for, for outputs.
    """

    def __init__(
        self, k: Kinematics, calls: Calls, time: Value, first_order: dict, impact_speeds: dict
    ):
        self.k, self.calls, self.time, self.trace = k, calls, time, k.trace
        self.first_order, self.impact_speeds = first_order, impact_speeds
        self.reactions = self.friction = None
        self.at({})

    def at(self, velocities: dict) -> None:
        """Take the velocities of the real motion, twists of all bodies."""
        self.velocities, self.real = velocities, Rates(self.k, real=velocities)

    # --- numbers and laws
    def number(self, element, name: str) -> Value:
        """A number of an element."""
        return self.calls.number(f"{element.key}/{name}")

    def law(self, element, slot: str, state: list, facts: tuple = ()) -> list:
        """Values of an element's law."""
        return self.calls.law(element, slot, state, facts)

    def amount(self, element, name: str, state: list) -> Value:
        """An element's number, or its law of time (and coordinate)."""
        if isinstance(getattr(element, name), BoundLaw):
            return self.law(element, name, state)[0]
        return self.number(element, name)

    def slopes(self, element, slot: str, x: Value) -> tuple:
        """Value, first and second derivative of an element's law of one variable."""
        law = getattr(element, slot).law
        function = self.calls.traced(law.function)
        numbers = [self.number(element, f"{slot}/{p}") for p in law.parameters]
        value, rate, _, second = self.trace.call(function.slopes((0,)).slopes((0,)), [x, *numbers])
        return value, rate, second

    def function(self, function, args: list, shape: tuple = ()) -> list:
        """Outputs of a plain function; shape: see `traced`."""
        return self.calls.function(function, args, shape)

    def of_law(self, element, slot: str, function, state: list, facts: tuple = ()) -> list:
        """Values of another function that takes the arguments of an element's law."""
        return self.calls.of(element, slot, function, state, facts)

    def shown(self, element, slot: str, state: list, facts: tuple = ()) -> dict[str, tuple]:
        """Outputs that a law has of its own: name -> (unit, description, value)."""
        outputs = {}
        for name, (unit, text, function, *number) in getattr(element, slot).law.shown.items():
            values = self.calls.of(element, slot, function, state, facts)
            outputs[name] = unit, text, values[next(iter(number), 0)]
        return outputs

    def keep(self, element, slot: str, state: list, facts: tuple) -> Value:
        """Calls a law with a memory to store this state."""
        law = getattr(element, slot).law
        return self.calls.of(element, slot, law.keep, state, facts)[0]

    def elastic_film(self, element, state: list, facts: list) -> list:
        """Film on the elastic surfaces of a joint, see mechanism/elastic_surfaces.py."""
        from clearance.mechanism.elastic_surfaces import film_of

        number = partial(self.number, element)
        return film_of(self.trace, number, element.contact.law, state, facts)

    def film_behind(self, element, state: list, facts: list) -> tuple[list, list]:
        """Of a film on a layer with summits, see mechanism/rough_layer.py: its eccentricity ratio
        and the rate of that; liner, factor and height of the summits.
        """
        from clearance.mechanism.rough_layer import factor_of, film_behind

        film, asperity = element.film.law, element.asperity.law
        of_film, of_summits = (
            [self.number(element, f"{slot}/{n}") for n in law.parameters]
            for slot, law in (("film", film), ("asperity", asperity))
        )
        summits = factor_of(self.trace, asperity, of_summits)
        function = film_behind(film, asperity.pressure[0])
        behind = self.trace.call(function, [*state, *facts, *summits, *of_film])
        return behind, [self.number(element, "film/liner"), *summits]

    # --- states
    def state(self, element, name: str) -> Jet:
        """A state of an element; of a joint that would over-constrain the mechanism it is
        measured.
        """
        if (element, name) in self.first_order:
            return Jet(self.first_order[element, name])
        if (element, name) not in self.k.state:
            names = [state.name for state in element.states()]
            if name not in names:
                raise ValueError(f"no state {name!r}{meant(name, names)}; it has {names}")
            self._measure(element)
        return Jet(*self.k.state[element, name])

    def _measure(self, joint: Joint) -> None:
        """Take a joint's states from its bodies, less its numbers; a turn is in (-pi, pi]."""
        jets, states = self.real.measured(joint, {}), {}
        for axis, name in joint.soft_coordinates:
            value = jets[axis].v - self.k.held(joint, axis)[0]
            if axis == TURN:
                value = self.trace.atan2(*wrong_turn(self.k, joint))
            states[joint, name] = value, jets[axis].d
        self.k.state |= states

    def impact_speed(self, element, spot: int = 0) -> Value:
        """Speed at which a spot touched, negative in free flight."""
        return self.impact_speeds[element][spot]

    def contact(self, element, depth: Value, spot: int = 0) -> tuple[Value, Value]:
        """Penetration that the contact law of a spot with a first touch feels, and its impact
        speed.

        In free flight (a negative impact speed, see stepping/loop.py) the law feels no penetration.
        A trial step may cross the wall and stays smooth, so that the start of the contact can be
        located on it.
        """
        speed = self.impact_speed(element, spot)
        touching = speed + 0.5
        flying = self.trace.select(depth, 0.0, depth)
        return self.trace.select(touching, depth, flying), self.trace.select(touching, speed, 0.0)

    # --- places
    def pose(self, body: Body) -> Pose:
        """Place and orientation of a body."""
        return self.k.poses[body]

    def spin(self, body: Body) -> Value:
        """Angular velocity of a body."""
        return self.velocities[body][2]

    def turned(self, body: Body) -> Value:
        """Angle of a body, without jumps."""
        return self.k.whole_angle(body)

    def point(self, element, side: str) -> tuple[Jet, Jet]:
        """A point of an element, along the fixed axes."""
        return self.real.point(getattr(element, side).body, self.real.local(element, side))

    def axis(self, joint: Joint) -> tuple[Value, Value]:
        """Direction of a joint's axis, along the fixed axes."""
        return self.k.axis(joint, joint.a.body)

    def coordinate(self, target) -> Jet:
        """Angle of a body, or the free coordinate of a joint, without jumps."""
        if isinstance(target, Body):
            return Jet(self.turned(target), self.spin(target))
        if target.slides:
            return Jet(*self.k.free(target, ALONG, self.velocities))
        a, b = target.bodies()
        return Jet(self.turned(b) - self.turned(a), self.rate(target))

    def rate(self, joint: Joint) -> Value:
        """Rate of the free coordinate of a joint; an angle itself would have to be carried from
        step to step.
        """
        if joint.slides:
            return self.k.free(joint, ALONG, self.velocities)[1]
        a, b = joint.bodies()
        return self.spin(b) - self.spin(a)

    # --- reactions
    def reaction(self, joint: Joint) -> tuple:
        """Force x, y and moment about the joint's point b, on body b."""
        return self.reactions.forces[joint]

    def reaction_across(self, joint: Joint) -> tuple:
        """Force z and moments x, y about the joint's point, on body b; nothing where no load is out
        of the plane.
        """
        return self.reactions.across.get(joint, (0.0,) * 3) if self.reactions.across else ()

    def effort(self, drive) -> Value:
        """Effort of a drive."""
        return self.reactions.efforts[drive]

    def effort_without_friction(self, drive) -> Value | None:
        """Effort of a drive that prescribes, without any joint friction; None where no joint has
        some.
        """
        return self.friction.ideal.get(drive)

    def drives_of(self, target) -> list:
        """Drives of a joint or body."""
        return [d for d in self.reactions.efforts if d.target is target]
