"""The scene of a mechanism: bodies, points on them, and what joins them. Frozen descriptions in SI units."""

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields, is_dataclass
from types import MappingProxyType

from clearance import checks
from clearance.laws.law import BoundLaw


@dataclass(frozen=True)
class Point:
    """A point fixed on a body, coordinates in the body's frame [m]; z points out of the plane of motion."""

    body: "Body"
    name: str
    x: float
    y: float
    z: float = 0.0

    def __repr__(self) -> str:
        return f"{self.body.name}[{self.name!r}]"


@checks.answers
@dataclass(frozen=True, eq=False)
class Body:
    """A rigid body.

    name; mass [kg] > 0; inertia about the centre of mass [kg m2] > 0; points: named points (x, y) in the body's own
    frame [m]; com: centre of mass in that frame [m]. `body["pin"]` is the named point. The motion is planar, the masses
    need not be: points and com may have a third coordinate z, and products are the products of inertia
    (integral of x z dm, of y z dm) about the centre of mass [kg m2]; they make axial forces and bending moments.
    A rough start helps the assembly to find the intended configuration: angle [rad] of the body's frame, position
    (x, y) of its origin [m] (default: found by following the joints). What no drive prescribes and no loop decides
    starts as given here, wherever the loops close so. angular_velocity [rad/s] and velocity (of the
    centre of mass, m/s) start the motions that no drive prescribes.
    """

    name: str
    mass: float
    inertia: float
    points: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    com: tuple[float, ...] = (0.0, 0.0)
    products: tuple[float, float] = (0.0, 0.0)
    angle: float = 0.0
    position: tuple[float, float] | None = None
    angular_velocity: float = 0.0
    velocity: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self):
        checks.identifier("body name", self.name)
        if self.name == "ground":
            raise ValueError("body name 'ground' is taken by the frame; choose another")
        self._set("mass", checks.positive(f"body {self.name}: mass", self.mass))
        self._set("inertia", checks.positive(f"body {self.name}: inertia", self.inertia))
        self._set("com", checks.place(f"body {self.name}: com", self.com))
        self._set("products", checks.pair(f"body {self.name}: products", self.products))
        self._set("angle", checks.finite(f"body {self.name}: angle", self.angle))
        checks.finite(f"body {self.name}: angular_velocity", self.angular_velocity)
        self._set("velocity", checks.pair(f"body {self.name}: velocity", self.velocity))
        if self.position is not None:
            self._set("position", checks.pair(f"body {self.name}: position", self.position))
        if not isinstance(self.points, Mapping):
            raise TypeError(f"body {self.name}: points must map names to (x, y), got {self.points!r}")
        points = {p: checks.place(f"body {self.name}: point {p!r}", xyz) for p, xyz in self.points.items()}
        self._set("points", MappingProxyType(points))

    def _set(self, name, value):
        object.__setattr__(self, name, value)

    def __getstate__(self) -> dict:
        return {**vars(self), "points": dict(self.points)}

    def __setstate__(self, state: dict) -> None:
        vars(self).update(state, points=MappingProxyType(state["points"]))

    def __getitem__(self, name: str) -> Point:
        if name not in self.points:
            raise KeyError(f"body {self.name} has no point {name!r}; it has {sorted(self.points)}")
        return Point(self, name, *self.points[name])

    @property
    def key(self) -> str:
        """Places of the body's numbers in the parameter vector."""
        return f"body.{self.name}"

    def at(self, x: float, y: float, z: float = 0.0) -> Point:
        """An unnamed point of the body's frame."""
        place = checks.place(f"point of {self.name}", (x, y, z))
        return Point(self, f"({', '.join(f'{v:g}' for v in place)})", *place)

    def __repr__(self) -> str:
        return f"Body({self.name!r})"


class Ground(Body):
    """The fixed frame. `ground.at(x, y)` is a point of it; `ground` alone its origin."""

    def __init__(self):
        for name, value in {
            "name": "ground", "points": {}, "com": (0.0, 0.0), "products": (0.0, 0.0), "angle": 0.0,
            "position": (0.0, 0.0),
            "mass": float("inf"), "inertia": float("inf"), "angular_velocity": 0.0, "velocity": (0.0, 0.0),
        }.items():  # fmt: skip
            object.__setattr__(self, name, value)

    def __reduce__(self):
        return "ground"

    def __repr__(self) -> str:
        return "ground"


ground = Ground()


def as_point(owner: str, value: object) -> Point:
    """A point, or a body standing for the origin of its frame."""
    if isinstance(value, Point):
        return value
    if isinstance(value, Body):
        return Point(value, "origin", 0.0, 0.0)
    raise TypeError(f"{owner}: expected a point such as crank['pin'] or ground.at(x, y), got {value!r}")


@checks.answers
class Scene:
    """A whole mechanism: joints, drives and loads. Bodies are found from the parts, nothing is listed twice.

    parts: Revolute, Prismatic, ClearanceRevolute, Drive, SpringDamper, TorsionSpring, Force, Torque, in any order (the
    order fixes the order of outputs); gravity: acceleration (x, y) [m/s2], or (x, y, z) for
    a mechanism whose plane is not vertical; name: stored with results. `parameters`: those that its case was given;
    `origin`: texts that say where it is from, stored with results too.
    Raises ValueError naming the part for duplicate names, parts on bodies that no joint knows, floating parts.
    """

    def __init__(self, *parts, gravity: tuple[float, ...] = (0.0, -9.81), name: str = "scene"):
        from clearance.joints import Joint
        from clearance.loads import Load

        for part in parts:
            if not isinstance(part, Joint | Load):
                raise TypeError(f"scene parts must be joints, drives or loads, got {part!r}")
        vars(self).update(
            name=checks.identifier("scene name", name),
            gravity=checks.place("gravity", gravity),
            joints=tuple(p for p in parts if isinstance(p, Joint)),
            loads=tuple(p for p in parts if isinstance(p, Load)),
            bodies=_distinct(b for p in parts for b in p.bodies() if b is not ground),
            parameters={},
            origin={},
        )
        _check_names("body", self.bodies)
        _check_names("joint", self.joints)
        _check_names("load", self.loads)
        for load in self.loads:
            if isinstance(getattr(load, "target", None), Joint) and load.target not in self.joints:
                raise ValueError(f"{load.label()}: its target, {load.target.label()}, is not in the scene")
        self._check_connected()

    def __setattr__(self, name: str, value: object):
        raise AttributeError(f"a scene is frozen; make another with the {name} you want")

    def _check_connected(self):
        if not self.bodies:
            raise ValueError("the scene has no moving body: give at least one joint or load on a Body")
        jointed = {b for j in self.joints for b in j.bodies()}
        for load in self.loads:
            strangers = [b.name for b in load.bodies() if b is not ground and b not in jointed]
            if strangers and not load.holds_free_bodies:
                known = ", ".join(sorted(b.name for b in jointed if b is not ground)) or "none"
                raise ValueError(f"{load.label()}: unknown body {strangers[0]!r}; bodies with joints: {known}")
        reached = {ground}
        links = [p.bodies() for p in (*self.joints, *self.loads)]
        while grown := {b for link in links if reached & set(link) for b in link} - reached:
            reached |= grown
        if floating := [b.name for b in self.bodies if b not in reached]:
            raise ValueError(f"floating: {', '.join(floating)} hang together by no joint, drive or spring with ground")

    @property
    def clearance_joints(self) -> tuple:
        """Joints with clearance, in the order of the scene."""
        from clearance.joints import ClearanceRevolute

        return tuple(j for j in self.joints if isinstance(j, ClearanceRevolute))

    @property
    def rubbing_joints(self) -> tuple:
        """Joints without clearance that have friction."""
        from clearance.joints import FrictionJoint

        return tuple(j for j in self.joints if isinstance(j, FrictionJoint) and j.friction is not None)

    @property
    def turn(self) -> float | None:
        """Duration of one turn of the first constant-speed rotating drive [s], if there is one."""
        turns = (getattr(load, "turn", None) for load in self.loads)
        return next((t for t in turns if t is not None), None)

    @property
    def provenance(self) -> dict[str, str]:
        """Attributes of result files: case, parameters that were given (JSON), whole scene (JSON).

        Of a case also its file and the defaults of the other parameters (JSON), of a command its line.
        """
        given = json.dumps(self.parameters, default=str, sort_keys=True)
        return {"case": self.name, "parameters": given, "scene": self.to_json(), **self.origin}

    def description(self) -> dict:
        """The scene as plain data: bodies, joints, loads with every number."""
        return {
            "name": self.name,
            "gravity": self.gravity,
            "bodies": [{f.name: _plain(getattr(b, f.name)) for f in fields(Body)} for b in self.bodies],
            "joints": [_plain(j) for j in self.joints],
            "loads": [_plain(load) for load in self.loads],
        }

    def to_json(self) -> str:
        """The scene's description as a JSON document, for provenance."""
        return json.dumps(self.description())

    def __repr__(self) -> str:
        kinds = ", ".join(f"{j.name}:{type(j).__name__}" for j in self.joints)
        return f"Scene({self.name!r}: {len(self.bodies)} bodies; {kinds})"


def _distinct(items: Iterable) -> tuple:
    return tuple(dict.fromkeys(items))


def _check_names(kind: str, items: Iterable) -> None:
    names = [i.name for i in items]
    if twice := sorted({n for n in names if names.count(n) > 1}):
        raise ValueError(f"duplicate {kind} name {twice[0]!r}")


def _plain(value: object) -> object:
    """A scene part as JSON types."""
    if isinstance(value, BoundLaw):
        return {"law": f"{value.law.__module__}:{value.law.name}"} | {k: _plain(v) for k, v in value.parameters.items()}
    if isinstance(value, Body):
        return value.name
    if isinstance(value, Point):
        place = {"x": value.x, "y": value.y} | ({"z": value.z} if value.z else {})
        return {"body": value.body.name, "point": value.name, **place}
    if is_dataclass(value):
        return {"type": type(value).__name__} | {f.name: _plain(getattr(value, f.name)) for f in fields(value)}
    if isinstance(value, Mapping):
        return {k: _plain(v) for k, v in value.items()}
    if isinstance(value, tuple):
        return [_plain(v) for v in value]
    return value
