"""Every number of a scene in one flat vector, so that a sweep changes numbers and never the
compiled code.

Structure is the rest: kinds, laws, connectivity, and the geometric numbers that are exactly 0 (for
a slide's direction also +-1). These are folded into the code, because most mechanisms are full of
them. Fields that are no numbers belong to the structure by their values, and in a user's element
all that are no parameters. Kernels of the package's elements read parameters alone.
"""

from collections.abc import Hashable, Iterator, Mapping
from dataclasses import Field, fields, is_dataclass
from functools import cache, partial
from inspect import isfunction
from types import FunctionType

import numpy as np

from clearance.elements.body import Body, Point
from clearance.elements.declared import ours
from clearance.elements.element import Element
from clearance.elements.quantities import ZERO, Row, fields_of
from clearance.laws.law import BoundLaw
from clearance.scene.scene import Scene
from clearance.tracing.interpreter import fingerprint, names_in

TRACED = ("act", "outputs")  # methods of elements that kernels are made of
PLAIN = (bool, int, float, complex, str, bytes, np.number, np.bool_)


class Numbers:
    """Names, values and foldability of all numbers of a scene. `signature` is equal for scenes that
    share kernels, whatever the names of their parts.
    """

    def __init__(self, scene: Scene):
        rows = list(_rows(scene))
        folded = [(key, value) for key, value, fold in rows if value in fold]
        free = [(key, value) for key, value, fold in rows if value not in fold]
        self.constants = dict(folded)
        self.index = {key: i for i, (key, _) in enumerate(free)}
        self.values = [float(value) for _, value in free]
        rest = (key.split("/", 2)[2] for key in self.index)
        parts = ((key.split("/", 2)[2], value) for key, value in folded)
        self.signature = (tuple(parts), tuple(rest), _structure(scene))


def numbers_of(scene: Scene) -> Iterator[tuple[str, float]]:
    """(name, value) of each number, in scene order."""
    for key, value, _ in _rows(scene):
        yield key, value


def _rows(scene: Scene) -> Iterator[Row]:
    """(name, value, values that are folded) of each number, in scene order."""
    for axis, value in zip("xyz", (*scene.gravity, 0.0), strict=False):
        yield f"scene/gravity/{axis}", value, ZERO
    for part in (*scene.bodies, *scene.elements):
        yield from part.numbers()


def _structure(scene: Scene) -> tuple:
    """Connectivity, kinds, laws, and values of plain fields."""
    shapes = tuple(
        (type(e), _outside(type(e)), *_element(e, scene.positions)) for e in scene.elements
    )
    return len(scene.bodies), shapes


@cache
def _plain(kind: type) -> list[tuple[Field, bool]]:
    """Fields of an element beside its name; True: the package declares it a number or a law."""
    return [
        (field, ours(kind) and not {"number", "law"}.isdisjoint(field.metadata))
        for field in fields_of(kind)
        if field.name != "name"
    ]


def _element(element: Element, positions: dict[str, int]) -> Iterator[Hashable]:
    """All of an element that its numbers and its name leave open."""
    for field, declared in _plain(type(element)):
        value = getattr(element, field.name)
        if declared or _in_vector(element, field, value):
            yield _of_structure(value, positions)
        else:
            yield _content(element, field.name, value, positions)


def _in_vector(element: Element, field: Field, value: object) -> bool:
    """True for a field whose numbers are parameters."""
    if isinstance(value, BoundLaw | Point) or value is None:
        return True
    if ours(type(element)):
        return is_dataclass(value)
    return element.has_parameter(field) and field.name not in _read(type(element))


@cache
def _methods(kind: type) -> list[FunctionType]:
    """Methods of a user's element that run while it is traced."""
    names = [m for m in TRACED if _of_user(getattr(kind, m))]
    for name in names:
        read = names_in(getattr(kind, name).__code__)
        names += [m for m in read if m not in names and _of_user(getattr(kind, m, None))]
    return [getattr(kind, name) for name in dict.fromkeys(names)]


@cache
def _read(kind: type) -> frozenset[str]:
    """Attributes that a user's element reads while it is traced: they are constants of kernels."""
    return frozenset(name for method in _methods(kind) for name in names_in(method.__code__))


def _outside(kind: type) -> tuple:
    """Code of a user's element, with the numbers and functions of its module that it reads now."""
    return tuple(map(fingerprint, _methods(kind)))


def _of_user(method: object) -> bool:
    return isfunction(method) and not ours(method)


def _content(element: Element, name: str, value: object, positions: dict[str, int]) -> Hashable:
    """A plain field of an element. Raises TypeError, which names them."""
    try:
        key = content(value, positions)
        hash(key)
        return key
    except TypeError:
        raise TypeError(
            f"{element.label()}: {name} of type {type(value).__name__} cannot be told from other "
            "values; take numbers, texts, tuples or a frozen dataclass"
        ) from None


def _shape(part: object, positions: dict[str, int]) -> Iterator[Hashable]:
    """All of a field with fields that its numbers and its name leave open."""
    for field in fields_of(type(part)):
        if field.name != "name":
            yield _of_structure(getattr(part, field.name), positions)


def _of_structure(value: object, positions: dict[str, int]) -> Hashable:
    """Part of a field that belongs to the structure."""
    if value is None or isinstance(value, float):
        return value is not None
    if isinstance(value, bool | str):
        return value
    if isinstance(value, BoundLaw):
        return fingerprint(value.law.function)
    if isinstance(value, Body | Element):
        return positions.get(value.key)  # None: the ground
    return tuple(_shape(value, positions)) if is_dataclass(value) else True


def content(value: object, positions: dict[str, int]) -> Hashable:
    """A value of a plain field, as a part of a structure: the code may have it as a constant.

    Equal for values that are the same to a formula. Parts of the scene are their positions.

    It has no hash where a value of unknown kind has none.
    """
    kind = type(value)
    if isinstance(value, PLAIN):
        return kind, repr(value)  # 1, 1.0 and True are equal, and nan is not
    if isinstance(value, Body | Element):
        return kind, positions.get(value.key)  # None: the ground
    if isinstance(value, Point):
        return kind, positions.get(value.body.key)  # its place is a parameter
    inner = partial(content, positions=positions)
    if isinstance(value, FunctionType):
        return value, fingerprint(value)
    if isinstance(value, BoundLaw):
        return fingerprint(value.law.function), inner(value.values)
    if isinstance(value, np.ndarray) and not value.dtype.hasobject:
        return kind, value.shape, value.dtype.str, value.tobytes()
    if isinstance(value, tuple | list):
        return kind, tuple(map(inner, value))
    if isinstance(value, set | frozenset):
        return kind, frozenset(map(inner, value))
    if isinstance(value, Mapping):
        return kind, tuple((inner(k), inner(v)) for k, v in value.items())
    if is_dataclass(value) and not isinstance(value, type):
        return kind, tuple(inner(getattr(value, field.name)) for field in fields(value))
    return kind, value
