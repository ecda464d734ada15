"""Checks of a user's element before anything is made of it; errors name element, field and
value.
"""

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import fields
from types import FunctionType

from clearance.elements.element import Element, Spot, State
from clearance.elements.joint import FREE, RELATIVE, Joint, Known
from clearance.values import checks
from clearance.values.spots import BLENDED, CONTACT, FILM

WATCHED = "contact_force", "gap"  # outputs of each contact whose extremes are located
OF_TRACE = "traced numbers take m.trace.select, m.trace.function and m.function"
OF_FILM = 2  # offsets of a joint that only a film holds, see `weigh_films` of the loop
PACKAGE = __name__.partition(".")[0]


def ours(part: type | FunctionType) -> bool:
    """True for a class or function of the package."""
    return part.__module__.partition(".")[0] == PACKAGE


def check(element: Element) -> None:
    """Raise ValueError or TypeError for what no element may declare."""
    _check_hash(element)
    states = _entries(element, "states", State)
    for state in states:
        _check_state(element, state)
    if isinstance(element, Joint):
        _check_coordinates(element, {s.name for s in states if s.order == 2})
    elif state := next((s for s in states if s.order == 2), None):
        raise _wrong(element, f"state {state.name}: order must be 1, for it is no joint, got 2")
    for spot in _entries(element, "spots", Spot):
        if spot.kind not in (FILM, CONTACT, BLENDED):
            kinds = "FILM, CONTACT or BLENDED"
            raise _wrong(element, f"spot {spot.name!r}: kind must be {kinds}, got {spot.kind!r}")
        if spot.kind == FILM and len(getattr(element, "soft_coordinates", ())) != OF_FILM:
            raise _wrong(
                element, f"spot {spot.name!r}: kind FILM needs {OF_FILM} offsets that are states"
            )
        checks.positive(f"{element.label()}: reach of spot {spot.name!r}", spot.reach)


def _wrong(element: Element, reason: str) -> ValueError:
    return ValueError(f"{element.label()}: {reason}")


def _check_hash(element: Element) -> None:
    for field in fields(element):
        try:
            hash(getattr(element, field.name) if type(element).__eq__ is not object.__eq__ else 0)
        except TypeError as reason:
            raise TypeError(
                f"{element.label()}: {field.name} has no hash ({reason}), got "
                f"{getattr(element, field.name)!r}; take a tuple, or dataclass(..., eq=False)"
            ) from None


def _entries(element: Element, method: str, kind: type) -> list:
    """States or spots of an element; names are distinct."""
    entries = getattr(element, method)()
    if not isinstance(entries, list | tuple) or not all(isinstance(e, kind) for e in entries):
        raise TypeError(
            f"{element.label()}: {method}() must return a list of {kind.__name__}, got {entries!r}"
        )
    checks.distinct(f"{element.label()}: {method}()", [e.name for e in entries])
    return list(entries)


def _check_state(element: Element, state: State) -> None:
    label = f"{element.label()}: state {state.name!r}"
    checks.identifier(f"{element.label()}: name of a state", state.name)
    if state.order not in (1, 2):
        raise ValueError(f"{label}: order must be 1 or 2, got {state.order!r}")
    checks.positive(f"{label}: size", state.size)
    for name in ("start", "start_rate"):
        checks.finite(f"{label}: {name}", getattr(state, name))


def _check_coordinates(joint: Joint, states: set[str]) -> None:
    """Relative coordinates are free or constrained by states and numbers that the joint has."""
    for axis in RELATIVE:
        value = getattr(joint, axis)
        if value is not FREE and not isinstance(value, Known):
            raise TypeError(f"{joint.label()}: {axis} must be FREE or Known(...), got {value!r}")
    bound = [k for k in (getattr(joint, axis) for axis in RELATIVE) if k is not FREE]
    numbers = {f.name for f in fields(joint) if joint.has_parameter(f)}
    for kind, valid in (("number", numbers), ("state", states)):
        for name in (getattr(k, kind) for k in bound):
            if name not in {"", *valid}:
                answer = f"{checks.meant(name, valid)}; it has {', '.join(sorted(valid)) or 'none'}"
                raise _wrong(joint, f"Known({kind}={name!r}) is no {kind} of it{answer}")
    for name in sorted(states - {k.state for k in bound}):
        raise _wrong(joint, f"state {name}: order 2 needs a coordinate Known(state={name!r})")


@contextmanager
def blamed(element: Element, method: str) -> Iterator[None]:
    """Errors of a user's method name the element and the method."""
    try:
        yield
    except Exception as error:
        if ours(type(element)) or element.label() in str(error):
            raise
        kind = "" if type(error) is ValueError else f"{type(error).__name__}: "
        hint = f"; {OF_TRACE}" if "scalar" in str(error).lower() else ""
        raise ValueError(f"{element.label()}: {method}: {kind}{error}{hint}") from error


def check_work(element: Element, work) -> None:
    """Each state of first order has a rate, each spot a place; neither has one that is not
    declared.
    """
    if ours(type(element)):
        return
    states = {s.name for s in element.states() if s.order == 1}
    rates = {name for owner, name in work.rates if owner is element}
    for name in sorted(states - rates):
        raise _wrong(element, f"act gives state {name!r} no rate: w.rate(self, {name!r}, ...)")
    for name in sorted(rates - states):
        raise _wrong(element, f"act gives a rate to {name!r}, no state of order 1 of it")
    count, declared = (len(spots) for spots in (work.spots.get(element, ()), element.spots()))
    if count != declared:
        raise _wrong(element, f"act gives {count} w.spot, but spots() has {declared}")


def check_outputs(element: Element, outputs: Iterable[tuple], is_value: Callable) -> list[tuple]:
    """Outputs of an element as (name, unit, description, value), each with a name and a number."""
    outputs = list(outputs)
    for output in outputs:
        if len(output) != 4 or not all(isinstance(text, str) for text in output[:3]):
            reason = f"an output is (name, unit, description, value), got {output!r}"
            raise _wrong(element, reason)
        checks.identifier(f"{element.label()}: name of an output", output[0])
        if not is_value(output[3]):
            raise _wrong(element, f"output {output[0]} must be one number, got {output[3]!r}")
    names = [output[0] for output in outputs]
    checks.distinct(f"{element.label()}: outputs", names)
    watched = [s.path(element, n) for s in element.spots() if s.kind == CONTACT for n in WATCHED]
    for path in watched:
        if (name := path.rpartition("/")[2]) not in names:
            raise _wrong(element, f"a contact shows its {name}: w.show(self, {name!r}, ...)")
    return outputs
