"""Drives: a prescribed coordinate, or an effort on one."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from clearance.elements.body import Body, ground
from clearance.elements.element import Load, State
from clearance.elements.joint import Joint
from clearance.elements.prismatic import Prismatic
from clearance.elements.quantities import NEVER, RATES, Row, law, number, optional
from clearance.elements.revolute import Revolute
from clearance.laws.law import BoundLaw, drive_state, effort, signal
from clearance.values import checks

#: laws that a torque or force may follow
EFFORTS = (effort, drive_state)


@checks.answers
@dataclass(frozen=True)
class Drive(Load):
    """Drives a body's angle (from ground), or the relative coordinate of a Revolute or Prismatic
    joint.

    target: a Body, a Revolute (angle of b against a) or a Prismatic (displacement of b along the
        axis).
    Exactly one of: speed, constant [rad/s or m/s]; motion, a `signal` law giving the coordinate
    over time [rad or m]; torque or force. These two are a number or an `effort` law (time,
    position, rate) [N m or N], or a `drive_state` law, whose state starts at 0.
    start: the coordinate at t = 0 [rad or m] (default: that of the rough start). For a torque or
        force, speed_start is the rate at t = 0.
    nominal: speed [rad/s] of a rotating drive without a constant one. Lengths of runs and samples
        given in turns are those of this speed. Metrics and pictures count turns of the angle
        itself.

    Example:

        >>> crank = cl.Body("crank", mass=0.3, inertia=1e-4)
        >>> main = cl.Revolute(cl.ground, crank, name="A")
        >>> scene = cl.Scene(main, cl.Drive(crank, speed="300 rpm"))
        >>> round(scene.turn, 12)
        0.2
    """

    target: Body | Revolute | Prismatic
    speed: float | None = number("constant rate [rad/s or m/s]", default=None, usual=RATES)
    motion: BoundLaw | None = law("coordinate over time", signal)
    torque: float | BoundLaw | None = number("torque [N m]", default=None, families=EFFORTS)
    force: float | BoundLaw | None = number("force [N]", default=None, families=EFFORTS)
    start: float | None = optional("coordinate at t = 0 [rad or m]", checks.finite)
    speed_start: float | None = optional("rate at t = 0 [rad/s or m/s]", checks.finite)
    name: str | None = None
    nominal: float | None = optional("nominal speed [rad/s]", checks.finite, usual=RATES)

    group = "drives"

    def __post_init__(self):
        target = self.target
        driven = isinstance(target, Body) or isinstance(target, Joint) and target.driven is not None
        if not driven or target is ground:
            raise TypeError(
                f"Drive: target must be a body, a Revolute or a Prismatic joint, got {target!r}"
            )
        super().__post_init__()
        modes = [n for n in ("speed", "motion", "torque", "force") if getattr(self, n) is not None]
        if len(modes) != 1:
            raise ValueError(
                f"{self.label()}: give exactly one of speed, motion, torque, force; got "
                f"{modes or 'none'}"
            )
        wrong = "torque" if self.slides else "force"
        if getattr(self, wrong) is not None:
            raise ValueError(f"{self.label()}: a {type(target).__name__} target takes no {wrong}")
        if self.start is not None and self.motion is not None:
            raise ValueError(f"{self.label()}: start is given by the motion itself; leave it out")
        if self.speed_start is not None and self.prescribes:
            raise ValueError(f"{self.label()}: speed_start belongs to a torque or force drive")
        self._check_nominal()
        self._check_shown()

    def _check_nominal(self) -> None:
        if self.nominal is None:
            return
        if self.slides or self.speed is not None:
            kind = "that slides" if self.slides else "with a constant speed"
            raise ValueError(
                f"{self.label()}: nominal={self.nominal!r}: a drive {kind} takes no nominal speed"
            )
        if self.nominal == 0.0:
            raise ValueError(f"{self.label()}: nominal must not be 0; leave it out instead")

    def _check_shown(self) -> None:
        """Outputs that its law has of its own need a unit and a description."""
        law = self.controller and self.controller.law
        for name, stated in law.shown.items() if law else ():
            if not isinstance(stated, tuple) or len(stated) != 3:
                raise TypeError(
                    f"{self.label()}: law {law.name}: shown[{name!r}] "
                    f"must be (unit, description, function), got {stated!r}"
                )

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
        """Duration of one turn [s] at the constant or nominal speed, where the drive has one."""
        speed = self.speed or self.nominal
        if not speed or self.slides:
            return None
        return 2.0 * math.pi / abs(speed)

    @property
    def prescribes(self) -> bool:
        """True where the motion is given and the effort is the result."""
        return self.speed is not None or self.motion is not None

    @property
    def effort_kind(self) -> str:
        """Kind of effort on the target: "torque", or "force" along a slide."""
        return "force" if self.slides else "torque"

    @property
    def effort(self) -> float | BoundLaw | None:
        """The torque [N m] or force [N] of a drive that finds the motion; None where that is
        prescribed.
        """
        return self.torque if self.torque is not None else self.force

    @property
    def controller(self) -> BoundLaw | None:
        """Its law with a state of its own."""
        law = self.effort
        return law if isinstance(law, BoundLaw) and law.law.family is drive_state else None

    def companions(self) -> dict:
        return {} if isinstance(self.target, Body) else {"target": self.target}

    def bodies(self) -> tuple[Body, ...]:
        return (self.target,) if isinstance(self.target, Body) else self.target.bodies()

    def numbers(self) -> Iterator[Row]:
        if self.speed is not None or self.nominal is not None:
            yield f"{self.key}/start", math.nan if self.start is None else self.start, NEVER
        if self.motion is not None:
            yield f"{self.key}/turned", 0.0, NEVER
        if self.nominal is not None:
            yield f"{self.key}/whole_turn", math.copysign(2.0 * math.pi, self.nominal), NEVER
        yield from super().numbers()

    # --- for the compiler
    def motion_at(self, m) -> tuple:
        """Prescribed coordinate, its rate and its second rate at the present time."""
        if self.motion is not None:
            value, rate, second = m.slopes(self, "motion", m.time)
            return value + m.number(self, "turned"), rate, second
        speed = m.number(self, "speed")
        return m.number(self, "start") + speed * m.time, speed, 0.0

    def states(self) -> list[State]:
        if (controller := self.controller) is None:
            return []
        law = controller.law
        size = law.size(controller.values) if law.size else 1.0
        return [State(law.own_state[0], self._unit(law.own_state[1]), size, order=1)]

    def _unit(self, unit: str) -> str:
        """A unit of angles, for a drive of displacements one of lengths."""
        return unit.replace("rad", "m") if self.slides else unit

    def act(self, m, w) -> None:
        if self.prescribes:
            return
        coordinate = m.coordinate(self.target)
        state = [m.time, coordinate.v, coordinate.d]
        if self.controller:
            effort = self._controlled(m, w, state)
        else:
            effort = m.amount(self, self.effort_kind, state)
        w.on(self.target, effort)
        w.drive(self, effort, coordinate.d)

    def _controlled(self, m, w, state: list):
        """Effort of a law with a state, the rate of this, and the outputs of the law."""
        name, unit, text = self.controller.law.own_state
        state = [m.state(self, name).v, *state]
        rate, effort = m.law(self, self.effort_kind, state)
        w.rate(self, name, rate)
        w.show(self, name, self._unit(unit), text, state[0])
        for shown, output in m.shown(self, self.effort_kind, state).items():
            w.show(self, shown, *output)
        return effort

    def outputs(self, m) -> Iterable[tuple]:
        name = self.effort_kind
        units = "N" if self.slides else "N m"
        effort = m.effort(self)
        rate = m.coordinate(self.target).d
        yield name, units, f"driving {name}", effort
        if (ideal := m.effort_without_friction(self)) is not None:
            yield f"{name}_ideal", units, f"driving {name} without joint friction", ideal
        yield "power", "W", "power put in by the drive", effort * rate
        if self.nominal is not None:
            turned = m.coordinate(self.target).v - m.number(self, "start")
            text = "turns of the driven angle since the start, the way of the nominal speed"
            yield "turns", "1", text, turned / m.number(self, "whole_turn")
