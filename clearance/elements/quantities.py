"""Fields of bodies and elements: a number's meaning, unit, check and place in the kernel from one
statement.
"""

from collections.abc import Callable, Iterator
from dataclasses import MISSING, Field, dataclass, field, fields
from functools import cache, cached_property

from clearance.laws.law import BoundLaw, Family, bound
from clearance.laws.materials import Record
from clearance.values import checks
from clearance.values.units import labelled, unusual

#: values of a number that are folded into the code
NEVER: tuple[float, ...] = ()
ZERO = (0.0,)
UNIT = (0.0, 1.0, -1.0)
#: ranges beyond which a run warns: sizes of joints, clearances, roughness [m]
SIZES, GAPS, ROUGH = ((1e-5, 5.0),), ((1e-8, 0.03),), ((1e-10, 1e-4),)
#: constant rates of drives [rad/s or m/s]
RATES = (0.0, 1000.0), (0.0, 100.0)
#: name in the parameter vector, value, values that are folded
Row = tuple[str, float, tuple[float, ...]]


@dataclass(frozen=True)
class Number:
    """A field that is a number: its meaning with the unit, its check, and the values that are
    folded into the code.

    parts: names of its components, where it is a vector. parameter: False where it is none of the
        kernel's; beside: a field without which it is none. families: of laws that may stand
        in its place. usual: range beyond which a run warns, for each of its units.
    """

    text: str
    check: Callable = checks.finite
    fold: tuple[float, ...] = NEVER
    parts: tuple[str, ...] = ()
    parameter: bool = True
    beside: str = ""
    families: tuple[Family, ...] = ()
    usual: tuple[tuple[float, float], ...] = ()

    @cached_property
    def units(self) -> tuple[str, ...]:
        """Its units, from its description."""
        _, _, unit = self.text.rpartition("[")
        return tuple(unit.rstrip("]").split(" or ")) if unit.endswith("]") else ()

    def doubt(self, label: str, value: object, unit: int = 0) -> str | None:
        """A warning about a value beyond the usual; unit: which of its units it has."""
        return unusual(label, value, self.units[unit], *self.usual[unit])

    def checked(self, label: str, value: object) -> object:
        """The value as the field has it: a number, or a law where the field takes one.

        A text with a unit becomes a number. Raises ValueError, TypeError.
        """
        value = labelled(label, value, self.units)
        if not self.families or isinstance(value, int | float) and not isinstance(value, bool):
            return self.check(label, value)
        return bound(label, value, *self.families)

    def rows(self, name: str, value: object) -> Iterator[Row]:
        """Its numbers of the kernel."""
        if not self.parts:
            yield name, value, self.fold
        for part, number in zip(self.parts, value, strict=True) if self.parts else ():
            yield f"{name}/{part}", number, self.fold


def number(text: str, check: Callable = checks.finite, default=MISSING, **options) -> Field:
    """A field that is a number. Its description names the unit; `options`: see Number."""
    return field(default=default, metadata={"number": Number(text, check, **options)})


def optional(text: str, check: Callable = checks.positive, **options) -> Field:
    """A number that may be missing, and that is no parameter."""
    return number(text, check, None, parameter=False, **options)


def start(text: str, check: Callable = checks.finite, default=0.0) -> Field:
    """A number of the state at t = 0, no parameter."""
    return number(text, check, default, parameter=False)


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
        for entry in fields(self):
            value = getattr(self, entry.name)
            label = f"{self.label()}: {entry.name}"
            spec = entry.metadata.get("number")
            if "law" in entry.metadata:
                self._set(entry.name, bound(label, value, *entry.metadata["law"]))
            elif spec is not None and (value is not None or entry.default is not None):
                self._set(entry.name, spec.checked(label, value))

    def doubts(self) -> list[str]:
        """Warnings about its numbers, and about those of its oil and material."""
        texts = []
        slides = getattr(self, "slides", False)
        for entry in fields_of(type(self)):
            value = getattr(self, entry.name)
            spec = entry.metadata.get("number")
            if spec is not None and spec.usual:
                unit = slides and len(spec.units) - 1
                texts.append(spec.doubt(f"{self.label()}: {entry.name}", value, unit))
            elif isinstance(value, Record):
                texts += value.doubts()
        return [t for t in texts if t]

    def numbers(self) -> Iterator[Row]:
        """All numbers of the kernel: name, value, values that are folded into the code."""
        key = self.key
        for entry in fields_of(type(self)):
            value = getattr(self, entry.name)
            name = f"{key}/{entry.name}"
            spec = entry.metadata.get("number")
            if isinstance(value, BoundLaw):
                yield from ((f"{name}/{p}", v, NEVER) for p, v in value.values.items())
            elif spec is not None and value is not None and self._is_parameter(spec):
                yield from spec.rows(name, value)

    def has_parameter(self, entry: Field) -> bool:
        """True where a field's number is one of the kernel."""
        spec = entry.metadata.get("number")
        return spec is not None and self._is_parameter(spec)

    def _is_parameter(self, spec: Number) -> bool:
        return spec.parameter and (not spec.beside or getattr(self, spec.beside) is not None)
