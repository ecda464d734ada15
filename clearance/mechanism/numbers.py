"""Every number of a scene in one flat vector, so that a sweep changes numbers and never the compiled code.

Structure is what the vector leaves out: kinds, laws, connectivity, and which geometric numbers are exactly 0 (for a
slide's direction also +-1): those are folded into the code, because most mechanisms are full of them.
"""

import math
from collections.abc import Iterator

from clearance.joints import SLOTS, ClearanceRevolute, Prismatic
from clearance.laws.law import BoundLaw
from clearance.loads import Drive, Force, SpringDamper, Torque, TorsionSpring
from clearance.mechanism.interpreter import fingerprint
from clearance.scene import Point, Scene

#: values of a number that are folded into the code
NEVER: tuple[float, ...] = ()
ZERO = (0.0,)
UNIT = (0.0, 1.0, -1.0)
Row = tuple[str, float, tuple[float, ...]]


class Numbers:
    """Names, values and foldability of all numbers of a scene. `signature` is equal for scenes that share kernels."""

    def __init__(self, scene: Scene):
        rows = list(_rows(scene))
        folded = [(key, value) for key, value, fold in rows if value in fold]
        kept = [(key, value) for key, value, fold in rows if value not in fold]
        self.constants = dict(folded)
        self.index = {key: i for i, (key, _) in enumerate(kept)}
        self.values = [float(value) for _, value in kept]
        self.signature = (tuple(folded), tuple(self.index), _structure(scene))


def _rows(scene: Scene) -> Iterator[Row]:
    """(name, value, values that are folded) of each number, in scene order."""
    yield "scene.gravity.x", scene.gravity[0], ZERO
    yield "scene.gravity.y", scene.gravity[1], ZERO
    yield "scene.gravity.z", _height(scene.gravity), ZERO
    for body in scene.bodies:
        yield f"{body.key}.mass", body.mass, NEVER
        yield f"{body.key}.inertia", body.inertia, NEVER
        for name, product in zip(("xz", "yz"), body.products, strict=True):
            yield f"{body.key}.products.{name}", product, ZERO
    for joint in scene.joints:
        yield from _ends(joint.key, joint.a, joint.b)
        if isinstance(joint, Prismatic):
            yield f"{joint.key}.axis.x", joint.axis[0], UNIT
            yield f"{joint.key}.axis.y", joint.axis[1], UNIT
            yield f"{joint.key}.angle", joint.angle, UNIT
        yield from _clearance(joint) if isinstance(joint, ClearanceRevolute) else _friction(joint)
    for load in scene.loads:
        yield from _load(load)


def _ends(key: str, a: Point, b: Point) -> Iterator[Row]:
    """Points relative to the centres of mass of their bodies."""
    for side, point in (("a", a), ("b", b)):
        yield f"{key}.{side}.x", point.x - point.body.com[0], ZERO
        yield f"{key}.{side}.y", point.y - point.body.com[1], ZERO
        yield f"{key}.{side}.z", point.z - _height(point.body.com), ZERO


def _height(place: tuple[float, ...]) -> float:
    """The coordinate out of the plane, where a place has one."""
    return place[2] if len(place) > 2 else 0.0


def _friction(joint) -> Iterator[Row]:
    """Numbers of the friction of a joint without clearance."""
    if joint.rubs_by_load:
        for name, value in joint.geometry.items():
            yield f"{joint.key}.{name}", value, ZERO
    yield from _law(f"{joint.key}.friction", joint.friction)


def _clearance(joint: ClearanceRevolute) -> Iterator[Row]:
    yield f"{joint.key}.clearance", joint.clearance, NEVER
    yield f"{joint.key}.radius", joint.radius, NEVER
    if joint.film is not None:
        yield f"{joint.key}.length", joint.length, NEVER
        yield f"{joint.key}.viscosity", joint.lubricant.viscosity, NEVER
    yield f"{joint.key}.roughness", joint.roughness or 0.0, ZERO
    for name, value in vars(joint.heat).items() if joint.heat is not None else ():
        yield f"{joint.key}.heat.{name}", value, NEVER
    for slot in SLOTS:
        yield from _law(f"{joint.key}.{slot}", getattr(joint, slot))


def _law(name: str, value: float | BoundLaw | None) -> Iterator[Row]:
    if isinstance(value, BoundLaw):
        for parameter, number in value.values.items():
            yield f"{name}.{parameter}", number, NEVER
    elif value is not None:
        yield name, value, NEVER


def _load(load) -> Iterator[Row]:
    if isinstance(load, Drive):
        if load.speed is not None:
            yield f"{load.key}.start", math.nan if load.start is None else load.start, NEVER
        for slot in ("speed", "motion", "torque", "force"):
            yield from _law(f"{load.key}.{slot}", getattr(load, slot))
    elif isinstance(load, SpringDamper):
        yield from _ends(load.key, load.a, load.b)
        for slot in ("stiffness", "damping", "free_length"):
            yield f"{load.key}.{slot}", getattr(load, slot), ZERO
    elif isinstance(load, TorsionSpring):
        for slot in ("stiffness", "damping", "free_angle"):
            yield f"{load.key}.{slot}", getattr(load, slot), ZERO
    elif isinstance(load, Force):
        yield f"{load.key}.point.x", load.point.x - load.point.body.com[0], ZERO
        yield f"{load.key}.point.y", load.point.y - load.point.body.com[1], ZERO
        yield f"{load.key}.point.z", load.point.z - _height(load.point.body.com), ZERO
        for axis in "xy":
            yield from _law(f"{load.key}.{axis}", getattr(load, axis))
        if isinstance(load.z, BoundLaw):
            yield from _law(f"{load.key}.z", load.z)
        else:
            yield f"{load.key}.z", load.z, ZERO
    elif isinstance(load, Torque):
        yield from _law(f"{load.key}.torque", load.torque)


def _print_of(value: object) -> object:
    """Part of a slot that belongs to the structure: the law's code, else its presence."""
    return fingerprint(value.law.function) if isinstance(value, BoundLaw) else value is not None


def _structure(scene: Scene) -> tuple:
    """Connectivity and laws."""
    joints = tuple(
        (
            type(j).__name__,
            j.name,
            j.a.body.name,
            j.b.body.name,
            getattr(j, "film_torques", None),
            getattr(j, "heat", None) is None,
            getattr(j, "self_aligning", None),
        )
        + tuple(_print_of(getattr(j, s, None)) for s in SLOTS)
        for j in scene.joints
    )
    loads = tuple(
        (
            type(load).__name__,
            load.name,
            *(b.name for b in load.bodies()),
            getattr(getattr(load, "target", None), "key", None),
        )
        + tuple(_print_of(v) for v in vars(load).values())
        for load in scene.loads
    )
    return tuple(b.name for b in scene.bodies), joints, loads
