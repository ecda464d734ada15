"""Fields of bodies and elements: a number's meaning, unit, check and place in the kernel from one
statement.
"""

from collections.abc import Callable, Iterator
from dataclasses import MISSING, Field, dataclass, field, fields
from functools import cache

from clearance import checks
from clearance.laws.law import BoundLaw, Family, bound

#: values of a number that are folded into the code
NEVER: tuple[float, ...] = ()
ZERO = (0.0,)
UNIT = (0.0, 1.0, -1.0)
#: name in the parameter vector, value, values that are folded
Row = tuple[str, float, tuple[float, ...]]


@dataclass(frozen=True)
class Number:
    """A field that is a number: its meaning with the unit, its check, and the values that are
    folded into the code.

    parts: names of its components, where it is a vector. parameter: False where it is none of the
        kernel's; beside: a field without which it is none. required: True where it must be given,
        though its default is None. families: of laws that may stand in its place.
    """

    text: str
    check: Callable = checks.finite
    fold: tuple[float, ...] = NEVER
    parts: tuple[str, ...] = ()
    parameter: bool = True
    beside: str = ""
    required: bool = False
    families: tuple[Family, ...] = ()

    def checked(self, label: str, value: object) -> object:
        """The value as the field has it: a number, or a law where the field takes one.

        Raises ValueError, TypeError.
        """
        if not self.families or isinstance(value, int | float) and not isinstance(value, bool):
            return self.check(label, value)
        return bound(label, value, *self.families)

    def rows(self, name: str, value: object) -> Iterator[Row]:
        """Its numbers of the kernel."""
        if not self.parts:
            yield name, value, self.fold
        for part, number in zip(self.parts, value, strict=True) if self.parts else ():
            yield f"{name}/{part}", number, self.fold


def number(text: str, check: Callable = checks.finite, default=MISSING, **more) -> Field:
    """A field that is a number. Its description names the unit; `more`: see Number."""
    return field(default=default, metadata={"number": Number(text, check, **more)})


def law(text: str, *families: Family) -> Field:
    """A field that takes a law of some families, or None."""
    return field(default=None, metadata={"law": families, "text": text})


@cache
def fields_of(kind: type) -> tuple[Field, ...]:
    """Fields of a dataclass."""
    return fields(kind)


class Described:
    """Base of frozen dataclasses whose fields declare their numbers and laws.

    Subclasses have `label` and `key`.
    """

    def _set(self, name: str, value: object) -> None:
        object.__setattr__(self, name, value)

    def _check_fields(self) -> None:
        """Check numbers and laws, as their fields declare them."""
        for one in fields(self):
            value, label = getattr(self, one.name), f"{self.label()}: {one.name}"
            spec = one.metadata.get("number")
            if "law" in one.metadata:
                self._set(one.name, bound(label, value, *one.metadata["law"]))
            elif spec is not None and (
                value is not None or one.default is not None or spec.required
            ):
                self._set(one.name, spec.checked(label, value))

    def numbers(self) -> Iterator[Row]:
        """All numbers of the kernel: name, value, values that are folded into the code."""
        key = self.key
        for one in fields_of(type(self)):
            value, name = getattr(self, one.name), f"{key}/{one.name}"
            spec = one.metadata.get("number")
            if isinstance(value, BoundLaw):
                yield from ((f"{name}/{p}", v, NEVER) for p, v in value.values.items())
            elif spec is not None and value is not None and self._is_parameter(spec):
                yield from spec.rows(name, value)

    def has_parameter(self, one: Field) -> bool:
        """True where a field's number is one of the kernel."""
        spec = one.metadata.get("number")
        return spec is not None and self._is_parameter(spec)

    def _is_parameter(self, spec: Number) -> bool:
        return spec.parameter and (not spec.beside or getattr(self, spec.beside) is not None)
