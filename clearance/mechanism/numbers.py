"""Every number of a scene in one flat vector, so that a sweep changes numbers and never the compiled code.

Structure is what the vector leaves out: kinds, laws, connectivity, and which geometric numbers are exactly 0 or +-1
(those are folded into the code, because most mechanisms are full of them).
"""

import math
from collections.abc import Iterator

from clearance.joints import ClearanceRevolute, Prismatic
from clearance.laws.law import BoundLaw
from clearance.loads import Drive, Force, SpringDamper, Torque, TorsionSpring
from clearance.scene import Point, Scene


class Numbers:
    """Names, values and foldability of all numbers of a scene. `signature` is equal for scenes that share kernels."""

    def __init__(self, scene: Scene):
        rows = list(_rows(scene))
        folded = [(key, value) for key, value, fold in rows if fold and value in (0.0, 1.0, -1.0)]
        kept = [(key, value) for key, value, fold in rows if not (fold and value in (0.0, 1.0, -1.0))]
        self.constants = dict(folded)
        self.index = {key: i for i, (key, _) in enumerate(kept)}
        self.values = [float(value) for _, value in kept]
        self.signature = (tuple(folded), tuple(self.index), _structure(scene))


def _rows(scene: Scene) -> Iterator[tuple[str, float, bool]]:
    """(name, value, may be folded) of each number, in scene order."""
    yield "gravity.x", scene.gravity[0], True
    yield "gravity.y", scene.gravity[1], True
    for body in scene.bodies:
        yield f"{body.name}.mass", body.mass, False
        yield f"{body.name}.inertia", body.inertia, False
    for joint in scene.joints:
        yield from _ends(joint.name, joint.a, joint.b)
        if isinstance(joint, Prismatic):
            yield f"{joint.name}.axis.x", joint.axis[0], True
            yield f"{joint.name}.axis.y", joint.axis[1], True
            yield f"{joint.name}.angle", joint.angle, True
        if isinstance(joint, ClearanceRevolute):
            yield from _clearance(joint)
    for load in scene.loads:
        yield from _load(load)


def _ends(name: str, a: Point, b: Point) -> Iterator[tuple[str, float, bool]]:
    """Points relative to the centres of mass of their bodies."""
    for side, point in (("a", a), ("b", b)):
        yield f"{name}.{side}.x", point.x - point.body.com[0], True
        yield f"{name}.{side}.y", point.y - point.body.com[1], True


def _clearance(joint: ClearanceRevolute) -> Iterator[tuple[str, float, bool]]:
    yield f"{joint.name}.clearance", joint.clearance, False
    yield f"{joint.name}.radius", joint.radius, False
    if joint.film is not None:
        yield f"{joint.name}.length", joint.length, False
        yield f"{joint.name}.viscosity", joint.lubricant.viscosity, False
    if joint.roughness is not None:
        yield f"{joint.name}.roughness", joint.roughness, False
    for slot in ("contact", "friction", "film"):
        yield from _law(f"{joint.name}.{slot}", getattr(joint, slot))


def _law(name: str, value: float | BoundLaw | None) -> Iterator[tuple[str, float, bool]]:
    if isinstance(value, BoundLaw):
        for parameter, number in value.parameters.items():
            yield f"{name}.{parameter}", number, False
    elif value is not None:
        yield name, value, False


def _load(load) -> Iterator[tuple[str, float, bool]]:
    if isinstance(load, Drive):
        if load.speed is not None:
            yield f"{load.name}.start", math.nan if load.start is None else load.start, False
        for slot in ("speed", "motion", "torque", "force"):
            yield from _law(f"{load.name}.{slot}", getattr(load, slot))
    elif isinstance(load, SpringDamper):
        yield from _ends(load.name, load.a, load.b)
        for slot in ("stiffness", "damping", "free_length"):
            yield f"{load.name}.{slot}", getattr(load, slot), True
    elif isinstance(load, TorsionSpring):
        for slot in ("stiffness", "damping", "free_angle"):
            yield f"{load.name}.{slot}", getattr(load, slot), True
    elif isinstance(load, Force):
        yield f"{load.name}.point.x", load.point.x - load.point.body.com[0], True
        yield f"{load.name}.point.y", load.point.y - load.point.body.com[1], True
        yield from _law(f"{load.name}.x", load.x)
        yield from _law(f"{load.name}.y", load.y)
    elif isinstance(load, Torque):
        yield from _law(f"{load.name}.torque", load.torque)


def _structure(scene: Scene) -> tuple:
    """Connectivity and laws."""
    joints = tuple(
        (type(j).__name__, j.name, j.a.body.name, j.b.body.name, getattr(j, "film_torques", None))
        + tuple(getattr(getattr(j, s, None), "law", None) for s in ("contact", "friction", "film"))
        for j in scene.joints
    )
    loads = tuple(
        (type(load).__name__, load.name, *(b.name for b in load.bodies()), getattr(load, "target", None).__class__)
        + tuple(getattr(v, "law", v is not None) for v in vars(load).values())
        for load in scene.loads
    )
    return tuple(b.name for b in scene.bodies), joints, loads
