"""A law is a plain function: its leading arguments are the state, the others its parameters.

Decorating it with its family makes it a `Law`; calling the law with parameters gives a `BoundLaw`: frozen, checked,
callable on floats and arrays. Nothing is registered anywhere: kernels take the function's own source.
"""

import inspect
from collections import namedtuple
from collections.abc import Callable
from dataclasses import dataclass

from clearance.checks import Check, finite

#: what a film law reads of its joint: journal radius [m], radial clearance [m], bearing length [m], viscosity [Pa s]
FilmJoint = namedtuple("FilmJoint", "radius clearance length viscosity")


@dataclass(frozen=True)
class Family:
    """The contract of one kind of law: what its leading arguments are, and how many values it returns."""

    name: str
    state: tuple[str, ...]
    outputs: int

    def __call__(self, function: Callable | None = None, /, **checks: Check):
        """Decorate a law; keyword arguments name the check of each parameter (default: finite)."""
        if function is not None:
            return Law(self, function, {})
        return lambda wrapped: Law(self, wrapped, checks)


class Law:
    """A physical law without its numbers. Call it with its parameters to bind them."""

    def __init__(self, family: Family, function: Callable, checks: dict[str, Check]):
        arguments = list(inspect.signature(function).parameters.values())
        leading = tuple(a.name for a in arguments[: len(family.state)])
        if leading != family.state:
            raise TypeError(
                f"{family.name} law {function.__name__} must start with arguments {family.state}, got {leading}"
            )
        if any(a.kind is not a.POSITIONAL_OR_KEYWORD for a in arguments):
            raise TypeError(
                f"{family.name} law {function.__name__} must have plain arguments, no *, ** or keyword-only ones"
            )
        parameters = {a.name: a.default for a in arguments[len(family.state) :]}
        if unknown := set(checks) - set(parameters):
            raise TypeError(f"{function.__name__} has no parameter {sorted(unknown)} to check")
        self.family, self.function, self.parameters, self.checks = family, function, parameters, checks
        self.name = self.__name__ = function.__name__
        self.doubt: Callable | None = None
        self.__doc__ = function.__doc__
        self.__module__ = function.__module__

    def __call__(self, **values) -> "BoundLaw":
        missing = [n for n, d in self.parameters.items() if n not in values and d is inspect.Parameter.empty]
        unknown = [n for n in values if n not in self.parameters]
        if missing or unknown:
            signature = ", ".join(self.parameters)
            raise TypeError(f"{self.name}({signature}): missing {missing}, unknown {unknown}")
        numbers = []
        for name, default in self.parameters.items():
            check = self.checks.get(name, finite)
            numbers.append(check(f"{self.name}: {name}", values.get(name, default)))
        return BoundLaw(self, tuple(numbers))

    def __reduce__(self) -> str:
        return self.__name__

    def doubts(self, function: Callable) -> Callable:
        """Decorate `function(joint, parameters) -> str or None`: what a user should know when a joint uses this law."""
        self.doubt = function
        return function

    def __repr__(self) -> str:
        return f"<{self.family.name} law {self.name}({', '.join(self.parameters)})>"


@dataclass(frozen=True)
class BoundLaw:
    """A law with its parameters. `law(*state)` evaluates it on floats or, element by element, on arrays."""

    law: Law
    numbers: tuple[float, ...]

    @property
    def parameters(self) -> dict[str, float]:
        return dict(zip(self.law.parameters, self.numbers, strict=True))

    def __call__(self, *state):
        if all(not hasattr(s, "__array__") or getattr(s, "ndim", 1) == 0 for s in state):
            return self.law.function(*state, *self.numbers)
        import numpy as np

        fixed = {i for i, name in enumerate(self.law.family.state) if name == "joint"}
        return np.vectorize(lambda *s: self.law.function(*s, *self.numbers), excluded=fixed)(*state)

    def __repr__(self) -> str:
        return f"{self.law.name}({', '.join(f'{k}={v:g}' for k, v in self.parameters.items())})"


contact = Family("contact", ("penetration", "penetration_rate", "impact_speed"), 1)
friction = Family("friction", ("sliding_speed", "normal_force"), 1)
film = Family("film", ("eccentricity_ratio", "radial_rate", "entrainment", "joint"), 2)
#: a function of time, for prescribed motion and time-varying loads
signal = Family("signal", ("time",), 1)
#: a torque or force that may depend on time and on the driven coordinate (angle, displacement) and its rate
effort = Family("effort", ("time", "position", "rate"), 1)


def bound(field: str, value: object, family: Family) -> BoundLaw | None:
    """Check that a physics slot holds a bound law of its family (or None); a law without parameters binds itself."""
    if isinstance(value, Law) and not value.parameters:
        value = value()
    if value is None or isinstance(value, BoundLaw) and value.law.family is family:
        return value
    if isinstance(value, Law):
        raise TypeError(f"{field}: give {value.name} its parameters ({', '.join(value.parameters)})")
    raise TypeError(f"{field} must be a {family.name} law or None, got {value!r}")
