"""Every number of a scene in one flat vector, so that a sweep changes numbers and never the
compiled code.

Structure is the rest: kinds, laws, connectivity, and the geometric numbers that are exactly 0 (for
a slide's direction also +-1). These are folded into the code, because most mechanisms are full of
them.
"""

from collections.abc import Iterator
from dataclasses import fields, is_dataclass

from clearance.body import Body, Point
from clearance.elements.element import Element
from clearance.laws.law import BoundLaw
from clearance.quantities import ZERO, Row
from clearance.scene import Scene
from clearance.tracing.interpreter import fingerprint


class Numbers:
    """Names, values and foldability of all numbers of a scene. `signature` is equal for scenes that
    share kernels.
    """

    def __init__(self, scene: Scene):
        rows = list(_rows(scene))
        folded = [(key, value) for key, value, fold in rows if value in fold]
        free = [(key, value) for key, value, fold in rows if value not in fold]
        self.constants = dict(folded)
        self.index = {key: i for i, (key, _) in enumerate(free)}
        self.values = [float(value) for _, value in free]
        self.signature = (tuple(folded), tuple(self.index), _structure(scene))


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
    """Connectivity, kinds and laws."""
    return tuple(b.name for b in scene.bodies), tuple(_shape(e) for e in scene.elements)


def _shape(element: Element) -> tuple:
    """All of an element that its numbers leave open."""
    values = (getattr(element, f.name) for f in fields(element))
    return type(element), element.name, *map(_of_structure, values)


def _of_structure(value: object) -> object:
    """Part of a field that belongs to the structure."""
    if isinstance(value, BoundLaw):
        return fingerprint(value.law.function)
    if isinstance(value, Point):
        return value.body.name
    if isinstance(value, Body | Element):
        return value.key
    if is_dataclass(value):
        return tuple(_of_structure(getattr(value, f.name)) for f in fields(value))
    return value if isinstance(value, bool | str) else value is not None
