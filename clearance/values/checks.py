"""Checks of user input: each raises ValueError (or TypeError) naming the field and the value.

`absent` and `lazily` are the `__getattr__` of packages.
"""

import functools
import math
import sys
from collections.abc import Callable, Collection, Iterable
from importlib import import_module

from clearance.values.accessors import stated
from clearance.values.columns import Column

Check = Callable[[str, object], float]
ROUNDING = 1e-15  # by which the length of a direction may be off


class RunWarning(UserWarning):
    """The warnings of a run. Its result has them too, as `warnings`."""


def meant(name: str, names: Iterable[str]) -> str:
    """ " (did you mean ...?)" where a known name is close or has the same words, in capitals or
    not; else nothing.
    """
    import difflib  # what few messages need

    plain = {k.lower(): k for k in names}
    name = str(name).lower()
    close = [k for k in plain if sorted(k.split("_")) == sorted(name.split("_"))]
    close += difflib.get_close_matches(name, plain, 1)
    return f" (did you mean {plain[close[0]]}?)" if close else ""


def answers(cls: type) -> type:
    """Decorate a class: a TypeError for an argument that it does not have lists those that it
    has, one for missing arguments names them.
    """
    import inspect

    original = cls.__init__
    kinds = [
        p for p in inspect.signature(original).parameters.values() if p.kind is not p.VAR_POSITIONAL
    ]
    names = [p.name for p in kinds][1:]
    needed = [p.name for p in kinds if p.default is p.empty][1:]

    @functools.wraps(original)
    def __init__(self, *values, **named):
        for name in named:
            if name not in names:
                raise TypeError(
                    f"{cls.__name__} has no argument {name!r}"
                    f"{meant(name, names)}; it has {', '.join(names)}"
                )
        if missing := [n for n in needed if n not in named and n not in names[: len(values)]]:
            label = " ".join([cls.__name__, *filter(None, [named.get("name")])])
            raise TypeError(f"{label} needs {', '.join(missing)}")
        original(self, *values, **named)

    cls.__init__ = __init__
    return cls


def absent(module: str, names: Iterable[str]) -> Callable[[str], object]:
    """`__getattr__` of a module: AttributeError with the public name that may be meant."""

    def __getattr__(name: str):
        raise AttributeError(f"module {module!r} has no attribute {name!r}{meant(name, names)}")

    return __getattr__


def finite(field: str, value: object) -> float:
    """A finite real number, returned as float."""
    if (
        isinstance(value, bool)
        or not isinstance(value, (int, float))
        and not hasattr(value, "__float__")
    ):
        hint = ", in SI units, such as cl.rpm(300)" if isinstance(value, str) else ""
        raise TypeError(f"{field} must be a number, got {value!r}{hint}")
    try:
        number = value if isinstance(value, Column) else float(value)
    except (TypeError, ValueError):
        raise TypeError(f"{field} must be a number, got {value!r}") from None
    if not number - number == 0.0:
        raise ValueError(f"{field} must be finite, got {value!r}")
    return number


def bounded(outside: Callable[[float], bool], bounds: str) -> Check:
    """A check of a number, returned as float; outside: True beyond its bounds.

    The check raises ValueError naming field, bounds and value.
    """

    def check(field: str, value: object) -> float:
        number = finite(field, value)
        if outside(number):
            raise ValueError(f"{field} must {bounds}, got {value!r}")
        return number

    return check


positive = bounded(lambda number: number <= 0.0, "be positive")
non_negative = bounded(lambda number: number < 0.0, "not be negative")
nonzero = bounded(lambda number: number == 0.0, "not be 0")
fraction = bounded(lambda number: not 0.0 <= number <= 1.0, "lie in [0, 1]")
inner_fraction = bounded(lambda number: not 0.0 < number < 1.0, "lie between 0 and 1")
at_least_one = bounded(lambda number: number < 1.0, "be at least 1")


def whole(field: str, value: object, least: int = 0, most: int | None = None) -> int:
    """An integer from `least` to `most`."""
    top = math.inf if most is None else most
    if isinstance(value, bool) or not hasattr(value, "__index__") or not least <= value <= top:
        ends = f"of at least {least}" if most is None else f"from {least} to {most}"
        raise ValueError(f"{field} must be a whole number {ends}, got {value!r}")
    return int(value)


def rising(field: str, ends: Iterable[object]) -> tuple[float, float]:
    """Two finite ends, the lower one first. Raises ValueError for others."""
    low, high = (finite(field, end) for end in ends)
    if low >= high:
        raise ValueError(f"{field} must rise, got {low:g} and {high:g}")
    return low, high


def one_of(field: str, value: str, names: Collection[str]) -> str:
    """The value, one of some names. Raises ValueError naming the closest of them."""
    if value not in names:
        raise ValueError(
            f"{field} must be one of {', '.join(names)}; got {value!r}{meant(value, names)}"
        )
    return value


def known(reason: str, name: str, names: Collection[str], of: str = "") -> None:
    """Raise ValueError for a name that is not among some.

    reason: "the case has no parameter", or "unknown field" of: " of a parameter".
    """
    if name not in names:
        verb = "it has" if of or " has no " in reason else "there are"
        there = ", ".join(names) or "none"
        raise ValueError(f"{reason} {name!r}{of}{meant(name, names)}; {verb} {there}")


def share(field: str, value: object) -> float:
    """A number > 0, also as a text: "1e-3", "5%". Raises ValueError naming the field and the
    value.
    """
    if isinstance(value, str):
        number = value.strip().removesuffix("%")
        percent = value.strip().endswith("%")
        try:
            value = float(number) * (0.01 if percent else 1.0)
        except ValueError:
            raise ValueError(f"{field}: {value!r} is no number such as 1e-3 or 5%") from None
    return positive(field, value)


def pair(field: str, value: object) -> tuple[float, float]:
    """Two finite numbers, returned as a tuple of floats."""
    try:
        x, y = value  # type: ignore[misc]
    except (TypeError, ValueError):
        raise TypeError(f"{field} must be a pair of numbers (x, y), got {value!r}") from None
    return finite(f"{field}[0]", x), finite(f"{field}[1]", y)


def direction(field: str, value: object) -> tuple[float, float]:
    """A vector of any length but zero, returned with length 1; one of length 1 stays as it is."""
    x, y = pair(field, value)
    length = math.hypot(x, y)
    if length <= 0.0:
        raise ValueError(f"{field} must not be zero: a direction, got {value!r}")
    if abs(length - 1.0) < ROUNDING:
        return x, y
    return x / length, y / length


def point(field: str, value: object) -> tuple[float, ...]:
    """Two finite numbers (x, y), or three (x, y, z) where z, out of the plane, is not zero; a tuple
    of floats.
    """
    if isinstance(value, str) or not hasattr(value, "__len__") or len(value) != 3:
        return pair(field, value)
    x, y, z = (finite(f"{field}[{i}]", v) for i, v in enumerate(value))
    return (x, y, z) if z else (x, y)


def distinct(field: str, names: Iterable[str]) -> None:
    """Raise ValueError for a name that stands there twice."""
    names = list(names)
    if twice := next((n for i, n in enumerate(names) if n in names[:i]), None):
        raise ValueError(f"{field}: {twice!r} stands there twice")


def identifier(field: str, value: object) -> str:
    """A name usable in files and on the command line: no slash, no blank, not empty."""
    if (
        not isinstance(value, str)
        or not value
        or not value.isprintable()
        or any(c in value for c in "/. ")
    ):
        raise ValueError(
            f"{field} must be a non-empty name without '/', '.' or blanks, got {value!r}"
        )
    return value


def lazily(package: str, file: str) -> tuple[Callable, Callable, list[str]]:
    """`__getattr__`, `__dir__` and `__all__` of a package with the names of its stub, see
    `accessors.stated`, imported on first use.
    """
    names = stated(file)
    public = sorted(names)
    missing = absent(package, names)

    def __getattr__(name: str):
        if name not in names:
            return missing(name)
        module, there = names[name]
        value = getattr(import_module(module), there)
        setattr(sys.modules[package], name, value)
        return value

    return __getattr__, lambda: public, public
