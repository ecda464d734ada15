"""Given forces and torques."""

from dataclasses import dataclass

from clearance.elements.body import Body, Point, ground
from clearance.elements.element import Load
from clearance.elements.quantities import ZERO, number
from clearance.laws.law import BoundLaw, signal
from clearance.values import checks


class PointForce(Load):
    """Base of forces on a point of a body."""

    group = "forces"

    def __post_init__(self):
        super().__post_init__()
        if self.point.body is ground:
            raise ValueError(f"{self.label()} acts on ground, which does not move")

    def _push(self, m, w, x, y, z=0.0) -> None:
        """Apply a force along the fixed axes, and the power that it puts in."""
        w.at(self, "point", x, y, z)
        px, py = m.point(self, "point")
        w.feed(x * px.d + y * py.d)


@checks.answers
@dataclass(frozen=True)
class Force(PointForce):
    """Force on a point of a body, along the fixed axes. x, y and z (out of the plane) are numbers
    or `signal` laws of time [N].
    """

    point: Point
    x: float | BoundLaw = number("force x [N]", default=0.0, families=(signal,))
    y: float | BoundLaw = number("force y [N]", default=0.0, families=(signal,))
    z: float | BoundLaw = number("force z [N]", default=0.0, fold=ZERO, families=(signal,))
    name: str | None = None

    kind = "force"

    def act(self, m, w) -> None:
        x, y, z = (m.amount(self, axis, [m.time]) for axis in "xyz")
        self._push(m, w, x, y, z)


@checks.answers
@dataclass(frozen=True)
class FollowerForce(PointForce):
    """Force on a point of a body, along the axes of the body's frame, with which it turns. x, y are
    numbers or `signal` laws of time [N].
    """

    point: Point
    x: float | BoundLaw = number("force along the body's x [N]", default=0.0, families=(signal,))
    y: float | BoundLaw = number("force along the body's y [N]", default=0.0, families=(signal,))
    name: str | None = None

    kind = "follower_force"

    def act(self, m, w) -> None:
        x, y = m.pose(self.point.body).turned(*(m.amount(self, axis, [m.time]) for axis in "xy"))
        self._push(m, w, x, y)


@checks.answers
@dataclass(frozen=True)
class Torque(Load):
    """Torque on a body: a number or a `signal` law of time [N m]."""

    body: Body
    torque: float | BoundLaw = number("torque [N m]", default=0.0, families=(signal,))
    name: str | None = None

    group, kind = "torques", "torque"

    def __post_init__(self):
        super().__post_init__()
        if not isinstance(self.body, Body) or self.body is ground:
            raise TypeError(f"{self.label()}: body must be a moving body, got {self.body!r}")

    def act(self, m, w) -> None:
        moment = m.amount(self, "torque", [m.time])
        w.add(self.body, moment=moment)
        w.feed(moment * m.spin(self.body))
