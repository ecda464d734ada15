"""Loads on a mechanism: drives, springs and dampers, forces and torques."""

import math
from dataclasses import dataclass

from clearance import checks
from clearance.joints import ClearanceRevolute, Joint, Prismatic, Revolute
from clearance.laws.law import BoundLaw, bound, effort, signal
from clearance.scene import Body, Point, as_point, ground


class Load:
    """Base of drives and loads."""

    #: whether a body that only this load knows may float freely in the plane
    holds_free_bodies = False

    def _set(self, name, value):
        object.__setattr__(self, name, value)

    def _name(self, default: str):
        name = self.name if self.name is not None else default
        self._set("name", checks.identifier(f"{type(self).__name__} name", name))

    def label(self) -> str:
        """Name of the load in messages."""
        return f"{type(self).__name__} {self.name}"

    @property
    def key(self) -> str:
        """Places of the load's numbers in the parameter vector."""
        return f"load.{self.name}"

    def _amount(self, field, family):
        """A plain number, or a bound law of the family."""
        value = getattr(self, field)
        label = f"{self.label()}: {field}"
        if isinstance(value, int | float) and not isinstance(value, bool):
            self._set(field, checks.finite(label, value))
        else:
            self._set(field, bound(label, value, family))


@checks.answers
@dataclass(frozen=True)
class Drive(Load):
    """Drives a body's angle (from ground), or the relative coordinate of a Revolute or Prismatic joint.

    target: a Body, a Revolute (angle of b against a) or a Prismatic (displacement of b along the axis).
    Exactly one of: speed, constant [rad/s or m/s]; motion, a `signal` law giving the coordinate over time [rad or m];
    torque or force, a number or an `effort` law (time, position, rate) [N m or N].
    start: the coordinate at t = 0 [rad or m] (default: that of the rough start); for a torque or force, speed_start is
    the rate at t = 0.
    """

    target: Body | Revolute | Prismatic
    speed: float | None = None
    motion: BoundLaw | None = None
    torque: float | BoundLaw | None = None
    force: float | BoundLaw | None = None
    start: float | None = None
    speed_start: float | None = None
    name: str | None = None

    def __post_init__(self):
        target = self.target
        if isinstance(target, ClearanceRevolute) or not isinstance(target, Body | Joint) or target is ground:
            raise TypeError(f"Drive: target must be a body, a Revolute or a Prismatic joint, got {target!r}")
        self._name(target.name)
        given = [n for n in ("speed", "motion", "torque", "force") if getattr(self, n) is not None]
        if len(given) != 1:
            raise ValueError(f"{self.label()}: give exactly one of speed, motion, torque, force; got {given or 'none'}")
        wrong = "torque" if isinstance(target, Prismatic) else "force"
        if getattr(self, wrong) is not None:
            raise ValueError(f"{self.label()}: a {type(target).__name__} target takes no {wrong}")
        if self.speed is not None:
            self._set("speed", checks.finite(f"{self.label()}: speed", self.speed))
        if self.motion is not None:
            self._set("motion", bound(f"{self.label()}: motion", self.motion, signal))
        for name in ("torque", "force"):
            if getattr(self, name) is not None:
                self._amount(name, effort)
        if self.start is not None:
            self._set("start", checks.finite(f"{self.label()}: start", self.start))
            if self.motion is not None:
                raise ValueError(f"{self.label()}: start is given by the motion itself; leave it out")
        if self.speed_start is not None:
            self._set("speed_start", checks.finite(f"{self.label()}: speed_start", self.speed_start))
            if self.prescribes:
                raise ValueError(f"{self.label()}: speed_start belongs to a torque or force drive")

    @property
    def turn(self) -> float | None:
        """Duration of one turn [s], where the drive turns at constant speed."""
        if not self.speed or isinstance(self.target, Prismatic):
            return None
        return 2.0 * math.pi / abs(self.speed)

    @property
    def prescribes(self) -> bool:
        """True where the motion is given (and the effort found), not the other way round."""
        return self.speed is not None or self.motion is not None

    @property
    def effort_kind(self) -> str:
        """Kind of effort on the target: "torque", or "force" along a slide."""
        return "force" if isinstance(self.target, Prismatic) else "torque"

    @property
    def effort(self) -> float | BoundLaw | None:
        """The torque [N m] or force [N] of a drive that finds the motion; None where that is prescribed."""
        return self.torque if self.torque is not None else self.force

    def bodies(self) -> tuple[Body, ...]:
        """The bodies it acts on."""
        return (self.target,) if isinstance(self.target, Body) else self.target.bodies()


@checks.answers
@dataclass(frozen=True)
class SpringDamper(Load):
    """Linear spring and damper between two points.

    Tension k (l - free_length) + damping l' along the line of the points; stiffness k [N/m], damping [N s/m],
    free_length [m]. It lies parallel to the plane of motion: a point's z gives its force an arm, and l no more length.
    """

    a: Point
    b: Point
    stiffness: float = 0.0
    damping: float = 0.0
    free_length: float = 0.0
    name: str | None = None
    holds_free_bodies = True

    def __post_init__(self):
        self._name("spring")
        self._set("a", as_point(self.label(), self.a))
        self._set("b", as_point(self.label(), self.b))
        if self.a.body is self.b.body:
            raise ValueError(f"{self.label()} acts between body {self.a.body.name!r} and itself")
        for name in ("stiffness", "damping", "free_length"):
            self._set(name, checks.non_negative(f"{self.label()}: {name}", getattr(self, name)))

    def bodies(self) -> tuple[Body, Body]:
        """The bodies it acts on."""
        return self.a.body, self.b.body


@checks.answers
@dataclass(frozen=True)
class TorsionSpring(Load):
    """Linear torsion spring and damper between two bodies, free at relative angle theta_b - theta_a = free_angle.

    stiffness [N m/rad], damping [N m s/rad], free_angle [rad].
    """

    a: Body
    b: Body
    stiffness: float = 0.0
    damping: float = 0.0
    free_angle: float = 0.0
    name: str | None = None

    def __post_init__(self):
        self._name("torsion_spring")
        for body in (self.a, self.b):
            if not isinstance(body, Body):
                raise TypeError(f"{self.label()} acts between two bodies, got {body!r}")
        if self.a is self.b:
            raise ValueError(f"{self.label()} acts between body {self.a.name!r} and itself")
        for name in ("stiffness", "damping"):
            self._set(name, checks.non_negative(f"{self.label()}: {name}", getattr(self, name)))
        self._set("free_angle", checks.finite(f"{self.label()}: free_angle", self.free_angle))

    def bodies(self) -> tuple[Body, Body]:
        """The bodies it acts on."""
        return self.a, self.b


@checks.answers
@dataclass(frozen=True)
class Force(Load):
    """Force on a point of a body, along the fixed axes: x, y and z (out of the plane) are numbers or `signal` laws of
    time [N].
    """

    point: Point
    x: float | BoundLaw = 0.0
    y: float | BoundLaw = 0.0
    z: float | BoundLaw = 0.0
    name: str | None = None

    def __post_init__(self):
        self._name("force")
        self._set("point", as_point(self.label(), self.point))
        if self.point.body is ground:
            raise ValueError(f"{self.label()} acts on ground, which does not move")
        for name in ("x", "y", "z"):
            self._amount(name, signal)

    def bodies(self) -> tuple[Body]:
        """The bodies it acts on."""
        return (self.point.body,)


@checks.answers
@dataclass(frozen=True)
class Torque(Load):
    """Torque on a body: a number or a `signal` law of time [N m]."""

    body: Body
    torque: float | BoundLaw = 0.0
    name: str | None = None

    def __post_init__(self):
        self._name("torque")
        if not isinstance(self.body, Body) or self.body is ground:
            raise TypeError(f"{self.label()}: body must be a moving body, got {self.body!r}")
        self._amount("torque", signal)

    def bodies(self) -> tuple[Body]:
        """The bodies it acts on."""
        return (self.body,)


__all__ = ["Drive", "Force", "Load", "SpringDamper", "Torque", "TorsionSpring"]
