"""Drives: a prescribed coordinate, or an effort on one."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from clearance import checks
from clearance.body import Body, ground
from clearance.elements.joint import Joint
from clearance.elements.load import Load
from clearance.elements.prismatic import Prismatic
from clearance.elements.revolute import Revolute
from clearance.laws.law import BoundLaw, effort, signal
from clearance.quantities import NEVER, Row, law, number


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
    speed: float | None = number("constant rate [rad/s or m/s]", default=None)
    motion: BoundLaw | None = law("coordinate over time", signal)
    torque: float | BoundLaw | None = number("torque [N m]", default=None, families=(effort,))
    force: float | BoundLaw | None = number("force [N]", default=None, families=(effort,))
    start: float | None = number("coordinate at t = 0 [rad or m]", default=None, parameter=False)
    speed_start: float | None = number("rate at t = 0 [rad/s or m/s]", default=None, parameter=False)
    name: str | None = None

    group = "drives"

    def __post_init__(self):
        target = self.target
        driven = isinstance(target, Body) or isinstance(target, Joint) and len(target.free) == 1 and not target.soft
        if not driven or target is ground:
            raise TypeError(f"Drive: target must be a body, a Revolute or a Prismatic joint, got {target!r}")
        super().__post_init__()
        given = [n for n in ("speed", "motion", "torque", "force") if getattr(self, n) is not None]
        if len(given) != 1:
            raise ValueError(f"{self.label()}: give exactly one of speed, motion, torque, force; got {given or 'none'}")
        wrong = "torque" if self.slides else "force"
        if getattr(self, wrong) is not None:
            raise ValueError(f"{self.label()}: a {type(target).__name__} target takes no {wrong}")
        if self.start is not None and self.motion is not None:
            raise ValueError(f"{self.label()}: start is given by the motion itself; leave it out")
        if self.speed_start is not None and self.prescribes:
            raise ValueError(f"{self.label()}: speed_start belongs to a torque or force drive")

    @property
    def kind(self) -> str:
        """Its name where none is given: that of its target."""
        return self.target.name

    @property
    def slides(self) -> bool:
        """True where it drives a displacement."""
        return isinstance(self.target, Joint) and self.target.slides

    @property
    def turn(self) -> float | None:
        """Duration of one turn [s], where the drive turns at constant speed."""
        if not self.speed or self.slides:
            return None
        return 2.0 * math.pi / abs(self.speed)

    @property
    def prescribes(self) -> bool:
        """True where the motion is given (and the effort found), not the other way round."""
        return self.speed is not None or self.motion is not None

    @property
    def effort_kind(self) -> str:
        """Kind of effort on the target: "torque", or "force" along a slide."""
        return "force" if self.slides else "torque"

    @property
    def effort(self) -> float | BoundLaw | None:
        """The torque [N m] or force [N] of a drive that finds the motion; None where that is prescribed."""
        return self.torque if self.torque is not None else self.force

    def bodies(self) -> tuple[Body, ...]:
        return (self.target,) if isinstance(self.target, Body) else self.target.bodies()

    def numbers(self) -> Iterator[Row]:
        if self.speed is not None:
            yield f"{self.key}/start", math.nan if self.start is None else self.start, NEVER
        yield from super().numbers()

    # --- what the compiler asks
    def motion_at(self, m) -> tuple:
        """Prescribed coordinate, its rate and its second rate at the present time."""
        if self.motion is not None:
            return m.slopes(self, "motion", m.time)
        speed = m.number(self, "speed")
        return m.number(self, "start") + speed * m.time, speed, 0.0

    def act(self, m, w) -> None:
        if self.prescribes:
            return
        coordinate = m.coordinate(self.target)
        state = [m.time, coordinate.v, coordinate.d]
        effort = m.amount(self, self.effort_kind, state)
        w.on(self.target, effort)
        w.drive(self, effort, coordinate.d)

    def outputs(self, m) -> Iterable[tuple]:
        name, units = self.effort_kind, "N" if self.slides else "N m"
        effort, rate = m.effort(self), m.coordinate(self.target).d
        yield name, units, f"driving {name}", effort
        if (ideal := m.effort_without_friction(self)) is not None:
            yield f"{name}_ideal", units, f"driving {name} without joint friction", ideal
        yield "power", "W", "power put in by the drive", effort * rate
