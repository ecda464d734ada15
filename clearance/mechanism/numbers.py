"""Every number of a scene in one flat vector, so that a sweep changes numbers and never the
compiled code.

Structure is the rest: kinds, laws, connectivity, and the geometric numbers that are exactly 0 (for
a slide's direction also +-1). These are folded into the code, because most mechanisms are full of
them.
"""

from collections.abc import Iterator
from dataclasses import is_dataclass

from clearance.body import Body
from clearance.elements.element import Element
from clearance.laws.law import BoundLaw
from clearance.quantities import ZERO, Row, fields_of
from clearance.scene import Scene
from clearance.tracing.interpreter import fingerprint


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
    """Connectivity, kinds and laws."""
    shapes = tuple((type(e), *_shape(e, scene.positions)) for e in scene.elements)
    return len(scene.bodies), shapes


def _shape(part: object, positions: dict[str, int]) -> Iterator[object]:
    """All of an element, or of a field with fields, that its numbers and its name leave open."""
    for one in fields_of(type(part)):
        if one.name != "name":
            yield _of_structure(getattr(part, one.name), positions)


def _of_structure(value: object, positions: dict[str, int]) -> object:
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
