"""A law is a plain function: its leading arguments are the state, the others its parameters.

Decorating it with its family makes it a `Law`; calling the law with parameters gives a `BoundLaw`:
frozen, checked, callable on floats and arrays. Nothing is registered anywhere: kernels take the
function's own source.
"""

import inspect
from collections import namedtuple
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import product

from clearance.values.checks import Check, finite, meant

LONGEST_ROW = 24  # values of a parameter that its text has one by one
#: values of the joint that laws read, zero where the joint has none: journal radius [m],
#: radial clearance [m], bearing length [m], viscosity [Pa s], composite rms roughness [m]
FilmJoint = namedtuple("FilmJoint", "radius clearance length viscosity roughness", defaults=(0.0,))

#: what pad laws read of a face of a block: half length and width [m], viscosity [Pa s]
PadFace = namedtuple("PadFace", "half_length width viscosity")
#: state of a film with a memory, in the bearing's frame. Eccentricity over clearance and its rate
#: [1/s]; spin = omega_J - omega_B [rad/s]; angle of a worn journal against the bearing. Lift of
#: the gap of worn outlines all around, by a transition, over clearance, and its rate [1/s]; time
FilmState = namedtuple(
    "FilmState",
    "eccentricity_x eccentricity_y rate_x rate_y spin angle lift lift_rate time",
)
#: arguments that are named tuples
TUPLES = {"joint": FilmJoint, "face": PadFace, "film_state": FilmState}


class Derived:
    """In place of a check: this parameter is not given but computed from the others, once, when the
    law is bound.
    """

    def __init__(self, function: Callable[[dict], float]):
        self.function = function


class OfJoint:
    """A check of a parameter that may be left out where the law stands in a joint, which determines
    it.

    function(joint, parameters) -> its number, None where the joint lacks the values for it.
    """

    def __init__(self, check: Check, function: Callable[[object, dict], float | None]):
        self.check, self.function = check, function

    def __call__(self, field: str, value: object) -> float:
        """The given number, checked."""
        return self.check(field, value)


@dataclass(frozen=True)
class Family:
    """The contract of one kind of law: what its leading arguments are, and how many values it
    returns.
    """

    name: str
    state: tuple[str, ...]
    outputs: int

    def __call__(self, function: Callable | None = None, /, **stated):
        """Decorate a law; keyword arguments name the check of each parameter (default: finite) and
        traits of the law, see `Law`.
        """
        if function is not None:
            return Law(self, function, {})
        return lambda wrapped: Law(self, wrapped, stated)


class _Signed:
    """Signature of a law for editors and `inspect`: its parameters; None where a joint has them."""

    def __get__(self, law: "Law | None", kind: type) -> inspect.Signature:
        if law is None:  # the class has that of its constructor
            raise AttributeError("__signature__")
        pairs = {
            n: None if isinstance(law.checks.get(n), OfJoint) else law.parameters[n]
            for n in law.inputs
        }
        named = inspect.Parameter.KEYWORD_ONLY
        return inspect.Signature([inspect.Parameter(n, named, default=d) for n, d in pairs.items()])


NONE: Mapping = {}  # outputs of a law's own that has none


class Law:
    """A physical law without its numbers. Call it with its parameters to bind them.

    Its traits are attributes that the decorator of its family states.
    """

    __signature__ = _Signed()

    doubt: Callable | None = None
    demand: Callable | None = None
    #: of laws with a state of their own: its natural size, from the parameters
    size: Callable | None = None
    #: of drive_state: name, unit, description
    own_state: tuple[str, str, str] = ("state", "rad", "state of the law")
    #: outputs of its own: unit, description, function of the same arguments, number of its value
    shown: Mapping[str, tuple] = NONE
    first_touch: bool = False  # of transitions: contact starts at the wall, as an event
    carries_roughness: bool = False  # of these: rough surfaces share the load below full film
    #: of these: film share and memberships from the film [m] on elastic surfaces, in place of the
    #: gap, by the same arguments
    on_film: Callable | None = None
    #: of these: beside an asperity law alone, nothing else stands for asperities
    needs_asperity: bool = False
    linear_in_viscosity: bool = True  # of films
    through_wall: bool = False  # of films: whether it goes over into contact
    on_outlines: bool = False  # of films: whether worn outlines have it beside a contact
    #: of films with a memory: called with the law's arguments at each step's end
    keep: Callable | None = None
    #: of asperities: order n of F_n in their pressure, and its factor [Pa], by parameters
    pressure: tuple[float, Callable] | None = None
    needs_load: bool = True  # of joint friction: whether the reaction of the joint enters
    smooth: Callable | None = None  # of these: whether it has a slope at rest, by parameters
    #: of these: least and largest rate of what it does around rest, by parameters
    layer: Callable | None = None
    limit: Callable | None = None  # of contacts: penetration [m] that it is meant for
    #: of laws of time: times [s] at which a slope jumps, by parameters; steps end there
    kinks: Callable | None = None
    #: of springs: depth into contact and its rate, by the law's arguments; free way before it [m],
    #: by parameters. No step crosses the begin of a contact
    engaged: tuple[Callable, Callable] | None = None
    #: of contacts: the law for a pair of bodies and a restitution, where no parameter is that
    from_restitution: Callable | None = None
    #: of friction: the law for a coefficient, where no parameter alone is that
    from_coefficient: Callable | None = None

    def __init__(self, family: Family, function: Callable, stated: Mapping[str, object]):
        arguments = list(inspect.signature(function).parameters.values())
        leading = tuple(a.name for a in arguments[: len(family.state)])
        if leading != family.state:
            raise TypeError(
                f"{family.name} law {function.__name__} must start with arguments {family.state}, "
                f"got {leading}"
            )
        if any(a.kind is not a.POSITIONAL_OR_KEYWORD for a in arguments):
            raise TypeError(
                f"{family.name} law {function.__name__} must have plain arguments, no *, ** or "
                f"keyword-only ones"
            )
        parameters = {a.name: a.default for a in arguments[len(family.state) :]}
        traits = {n: v for n, v in stated.items() if n in TRAITS and n not in parameters}
        checks = {n: check for n, check in stated.items() if n not in traits}
        if unknown := set(checks) - set(parameters):
            raise TypeError(f"{function.__name__} has no parameter {sorted(unknown)} to check")
        self.family, self.function, self.parameters = family, function, parameters
        self.checks = checks
        vars(self).update(traits)
        self.inputs = [n for n in parameters if not isinstance(checks.get(n), Derived)]
        self.name = self.__name__ = function.__name__
        self.__doc__ = function.__doc__
        self.__module__ = function.__module__

    @property
    def kinds(self) -> tuple:
        """Kind of each argument: "number", a named tuple type, or "data" (a flat array)."""
        state = [TUPLES.get(name, "number") for name in self.family.state]
        data = ["data"] if isinstance(self, DataLaw) else []
        return (*state, *data, *["number"] * len(self.parameters))

    @property
    def needed(self) -> list[str]:
        """Parameters without a default that no joint determines."""
        empty = [n for n in self.inputs if self.parameters[n] is inspect.Parameter.empty]
        return [n for n in empty if not isinstance(self.checks.get(n), OfJoint)]

    def __call__(self, *unnamed, **values) -> "BoundLaw":
        if unnamed:
            named = ", ".join(f"{n}={v!r}" for n, v in zip(self.inputs, unnamed, strict=False))
            raise TypeError(f"{self.name}({', '.join(self.inputs)}): name its parameters: {named}")
        missing = [n for n in self.needed if n not in values]
        unknown = [n for n in values if n not in self.inputs]
        if missing or unknown:
            hint = meant(unknown[0], self.inputs) if unknown else ""
            parts = [f"missing {', '.join(missing)}"] if missing else []
            parts += [f"unknown {', '.join(unknown)}{hint}"] if unknown else []
            raise TypeError(f"{self.name}({', '.join(self.inputs)}): {'; '.join(parts)}")
        numbers = {n: self._number(n, values) for n in self.inputs}
        values_of_all = [
            self.checks[n].function(numbers) if n not in numbers else numbers[n]
            for n in self.parameters
        ]
        return pulls_never(BoundLaw(self, tuple(values_of_all)))

    def _number(self, name: str, values: dict) -> float | None:
        """A parameter as given, else its default; None where the joint determines it."""
        check = self.checks.get(name, finite)
        if values.get(name) is None and isinstance(check, OfJoint):
            return None
        return check(f"{self.name}: {name}", values.get(name, self.parameters[name]))

    def __reduce__(self) -> str:
        return self.__name__

    def doubts(self, function: Callable) -> Callable:
        """Decorate `function(joint, parameters) -> str or None`: a warning for the user of this
        law.
        """
        self.doubt = function
        return function

    def demands(self, function: Callable) -> Callable:
        """Decorate `function(joint, parameters) -> str or None`: what makes a joint with this law
        impossible.
        """
        self.demand = function
        return function

    def __repr__(self) -> str:
        return f"<{self.family.name} law {self.name}({', '.join(self.inputs)})>"


#: names of traits
TRAITS = frozenset(Law.__annotations__)


class DataLaw(Law):
    """A law that reads numbers made for its joint, such as a table of forces.

    Its first parameters are `data`, a flat array, and `start`, the index of its first number in it.
    In a kernel `data` is the parameter vector, so that other numbers need no other kernel.
    make(facts, settings) -> an object with those `numbers`. The facts are values of the joint that
    the law reads. The settings choose the numbers and are no numbers of the kernel; the law's own
    parameters are among them.
    """

    def __init__(
        self,
        family: Family,
        function: Callable,
        stated: Mapping[str, object],
        make: Callable,
        name: str | None = None,
    ):
        super().__init__(family, function, stated)
        # that users give it, where it is not the function's
        self.name = self.__name__ = name or self.name
        if list(self.parameters)[:2] != ["data", "start"]:
            raise TypeError(
                f"{family.name} law {self.name} must take data and start after its state"
            )
        self.make = make
        self.looked_at = lru_cache(maxsize=8)(lambda joint, settings: make(joint, dict(settings)))
        # for calls one by one, in half the time of numpy's numbers
        self.listed = lru_cache(maxsize=8)(lambda *of: [*map(float, self.looked_at(*of).numbers)])
        self.of_numbers = Law(family, function, {})  # with its data among its parameters
        del self.parameters["data"]
        self.inputs = [n for n in self.inputs if n not in ("data", "start")]
        self.checks |= {"start": Derived(lambda values: 0.0)}

    def bind(self, settings: dict, **values) -> "BoundLaw":
        """The law with its settings and parameters."""
        bound_law = super().__call__(**values)
        return BoundLaw(self, bound_law.numbers, tuple(settings.items()))

    def __call__(self, **values) -> "BoundLaw":
        return self.bind({}, **values)


@dataclass(frozen=True)
class BoundLaw:
    """A law with its parameters. `law(*state)` evaluates it on floats or, element by element, on
    arrays.

    numbers: in the order of the law's parameters; None where a joint determines it, until the law
        is `of` one.
    of_joint: parameters that the joint has determined, and would determine anew.
    """

    law: Law
    numbers: tuple[float | None, ...]
    settings: tuple[tuple[str, object], ...] = ()
    of_joint: tuple[str, ...] = field(default=(), compare=False)

    @property
    def values(self) -> dict[str, float]:
        """All parameters by name, those derived from others too."""
        return dict(zip(self.law.parameters, self.numbers, strict=True))

    @property
    def parameters(self) -> dict:
        """The parameters and settings that were given."""
        return dict(self.settings) | {n: v for n, v in self.values.items() if n in self.law.inputs}

    def replaced(self, **changes: float) -> "BoundLaw":
        """The law with some of its parameters changed.

        Raises TypeError for a parameter that does not exist.
        """
        names = [n for n in self.law.inputs if n not in self.of_joint]
        numbers = {n: self.values[n] for n in names if self.values[n] is not None}
        if isinstance(self.law, DataLaw):
            return self.law.bind(dict(self.settings), **(numbers | changes))
        return self.law(**(numbers | changes))

    def of(self, joint) -> "BoundLaw":
        """The law in a joint, which determines the parameters that were not given.

        joint: something with radius, clearance, length, material and layer, such as a
            ClearanceRevolute.
        Raises ValueError for a parameter that the joint cannot determine.
        """
        rest = tuple(n for n, v in self.values.items() if v is None or n in self.of_joint)
        if not rest:
            return self
        values = self.values | dict.fromkeys(rest)
        values |= {name: self.law.checks[name].function(joint, values) for name in rest}
        if missing := [name for name in rest if values[name] is None]:
            raise ValueError(f"{missing[0]} is missing: give it to the law or to the joint")
        return pulls_never(BoundLaw(self.law, tuple(values.values()), self.settings, rest))

    def source(self, facts: FilmJoint | PadFace):
        """Data of a law in a joint with these numbers: an object with `numbers`, a flat array."""
        return self.law.make(facts, self.parameters)

    def __call__(self, *state):
        if len(state) != len(self.law.family.state):
            raise TypeError(
                f"{self.law.name} takes {', '.join(self.law.family.state)}; got {len(state)} "
                f"arguments"
            )
        if any(number is None for number in self.numbers):
            missing = [n for n, v in self.values.items() if v is None]
            raise ValueError(
                f"{self.law.name}: give {', '.join(missing)}; without a joint nothing determines it"
            )
        if isinstance(self.law, DataLaw):
            return self._of_data(*state)
        if all(not hasattr(s, "__array__") or getattr(s, "ndim", 1) == 0 for s in state):
            return self.law.function(*state, *self.numbers)
        import numpy as np

        fixed = {i for i, name in enumerate(self.law.family.state) if name in TUPLES}
        values = np.vectorize(
            lambda *s: self.law.function(*s, *self.numbers),
            "d" * self.law.family.outputs,
            excluded=fixed,
        )
        return values(*state)

    def plain(self, facts: FilmJoint | PadFace) -> Callable:
        """The law in a joint with these numbers, as a function of floats: for many calls."""
        function, numbers = self.law.function, self.numbers
        if isinstance(self.law, DataLaw):
            numbers = (self.law.listed(facts, tuple(self.parameters.items())), 0.0, *numbers[1:])
        return lambda *state: function(*state, *numbers)

    def _of_data(self, *state):
        """As a law whose parameters are this joint's numbers."""
        numbers = (
            self.law.listed(state[-1], tuple(self.parameters.items())),
            0.0,
            *self.numbers[1:],
        )
        return BoundLaw(self.law.of_numbers, numbers)(*state)

    def __repr__(self) -> str:
        arguments = ", ".join(f"{k}={_brief(v)}" for k, v in self.parameters.items())
        return f"{self.law.name}({arguments})"


#: penetrations [m], their rates and impact speeds [m/s] at which contacts are looked at
DEPTHS = (-1e-3, -1e-6, 0.0, 1e-9, 1e-7, 1e-5, 1e-3)
RATES, IMPACTS = (-10.0, -1e-3, 0.0, 1e-3, 10.0), (1e-3, 1.0)


def pulls_never(law: BoundLaw) -> BoundLaw:
    """A law as it is.

    Raises ValueError for a user's contact that pulls, or that is not 0 without penetration.
    """
    numbers = all(isinstance(n, int | float) for n in law.numbers)
    if (
        law.law.family is not contact
        or not numbers
        or str(law.law.__module__).startswith("clearance.")
    ):
        return law
    for depth, rate, impact in product(DEPTHS, RATES, IMPACTS):
        force = _force(law, depth, rate, impact)
        state = f"at a penetration of {depth:g} m and its rate {rate:g} m/s"
        if depth <= 0.0 and force != force:
            rule = "outside contact a power of the negative penetration is no number; "
            rule += "max(penetration, 0.0) cuts it"
            raise ValueError(f"contact {law.law.name}: no value {state}: {rule}")
        if depth <= 0.0 and force != 0.0:
            raise ValueError(
                f"contact {law.law.name}: {force:g} N {state}: "
                "it is called outside contact too, and must return 0.0 there"
            )
        if force < 0.0:
            raise ValueError(
                f"contact {law.law.name}: {force:g} N {state}: "
                "a contact never pulls; max(..., 0.0) cuts its force"
            )
    return law


def _force(law: BoundLaw, *state: float) -> float:
    """Of a contact; nan where it has no value."""
    try:
        return float(law.law.function(*state, *law.numbers))
    except (ArithmeticError, TypeError, ValueError):
        return float("nan")


def _brief(value: object) -> str:
    """Text of a parameter: long rows of numbers, such as an outline, as their count and range."""
    if isinstance(value, tuple) and len(value) > LONGEST_ROW:
        return f"<{len(value)} values from {min(value)} to {max(value)}>"
    return f"{value:g}" if isinstance(value, float) else str(value)


contact = Family("contact", ("penetration", "penetration_rate", "impact_speed"), 1)
friction = Family("friction", ("sliding_speed", "normal_force"), 1)
#: friction of a hinge (rate [rad/s], load and result [N m]) or a slide (rate [m/s], load and result
#: [N]). `load` follows from the joint's reaction and its geometry, see laws/joint_friction.py.
joint_friction = Family("joint_friction", ("rate", "load"), 1)
#: the same with a state of its own, the deflection of its bristles [rad or m]: returns (its rate,
#: torque or force)
joint_bristle = Family("joint_bristle", ("deflection", "rate", "load"), 2)
#: friction with a state of its own, the deflection of its bristles [m]: returns (its rate [m/s],
#: force [N])
bristle = Family("bristle", ("deflection", "sliding_speed", "normal_force"), 2)
film = Family("film", ("eccentricity_ratio", "radial_rate", "entrainment", "joint"), 2)
#: a film that also returns its wetted area: (radial, tangential, integral of 1/H over the wetted
#: area)
wet_film = Family("film", film.state, 3)
#: a film with a memory, in the bearing's frame: returns (force x, force y, integral of 1/H over the
#: wetted area)
memory_film = Family("film", ("film_state", "joint"), 3)
#: load that the asperities of the joint's surfaces carry [N]
asperity = Family("asperity", ("film_thickness_ratio", "joint"), 1)
#: how film and contact share a joint, from the nominal gap [m]: see laws/transition.py
transition = Family("transition", ("gap", "joint"), 8)
#: film on elastic surfaces, from load [N] and sum of the surface speeds [m/s]: returns (central
#: film, rigid film that carries the load) [m]
loaded_film = Family("loaded_film", ("load", "speed", "joint"), 2)
#: film of a flat pad over a flat wall: returns (load, its moment, drag), see laws/pad.py
pad = Family("pad", ("gap", "slope", "gap_rate", "slope_rate", "speed", "face"), 3)
#: wear of one surface: rate of its worn depth [m/s] from a pressure [Pa] and a speed [m/s], see
#: laws/wear.py
surface_wear = Family("surface_wear", ("pressure", "sliding_speed"), 1)
#: contact on worn outlines, in the bearing's frame, see laws/outline.py: force x, y, normal load,
#: moment
outline = Family("outline", ("eccentricity_x", "eccentricity_y", "angle", "joint"), 4)
#: tension of a spring or damper [N] over its elongation [m] and its rate; of a twist [N m], [rad]
spring = Family("spring", ("elongation", "rate"), 1)
#: a function of time, for prescribed motion and time-varying loads
signal = Family("signal", ("time",), 1)
#: a torque or force that may depend on time and on the driven coordinate (angle, displacement) and
#: its rate
effort = Family("effort", ("time", "position", "rate"), 1)
#: the same with a state of its own [rad or m], such as the integral of an error: returns (its rate,
#: torque or force)
drive_state = Family("drive_state", ("state", *effort.state), 2)

#: the families, to decorate laws of one's own with, and the laws by family
FAMILIES = (
    contact,
    friction,
    bristle,
    joint_friction,
    joint_bristle,
    film,
    pad,
    asperity,
    loaded_film,
    transition,
    spring,
    signal,
    effort,
    drive_state,
    surface_wear,
)


def bound(field: str, value: object, *families: Family) -> BoundLaw | None:
    """Check that a physics slot holds a bound law of its families (or None); a law that needs
    nothing binds itself.
    """
    if isinstance(value, Law) and not value.needed:
        value = value()
    if value is None or isinstance(value, BoundLaw) and value.law.family in families:
        return value
    if isinstance(value, Law):
        raise TypeError(f"{field}: give {value.name} its parameters ({', '.join(value.inputs)})")
    call = f"; call it: {value.__name__}(...)" if inspect.isfunction(value) else ""
    raise TypeError(f"{field} must be a {families[0].name} law or None, got {value!r}{call}")
