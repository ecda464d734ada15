"""Planar kinematics along a plan, written once over traced scalars.

Poses are of centres of mass. A *field* gives each body a planar twist (x, y, turning): real
velocities, velocities per unit of one independent speed (columns), or accelerations. All three
follow the same linear rules, accelerations with the quadratic terms added.

`Geometry` has the relative coordinates of all joints over absolute coordinates of the bodies, with
their slopes. The joints' one statement is traced and written as plain Python, once for all scenes
of a structure.

A jet is a value with its rate along the real motion and a second rate: `Rates` of points and
directions, from one statement of each joint. Vectors that turn with a body have a rule of their
own, a = alpha x v - w^2 v + 2 w x r + q. Differentiating cosine and sine would cost more.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from clearance.elements.body import ABSOLUTE, Body, ground
from clearance.elements.joint import ACROSS, ALONG, FREE, RELATIVE, TURN, Joint
from clearance.mechanism import loops
from clearance.mechanism.loops import offsets, wrong_turn
from clearance.mechanism.numbers import Numbers
from clearance.mechanism.topology import Attachment, Group, Plan
from clearance.scene.scene import Scene
from clearance.tracing.emission import function_text
from clearance.tracing.function import Function
from clearance.tracing.trace import Trace, Value, is_zero, live

Twist = tuple  # (x, y, turning): rates of a centre of mass and of an angle
ZERO: Twist = (0.0, 0.0, 0.0)
UNITS = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


class Jet:
    """A value v, its rate d along the real motion, and its second rate a."""

    __slots__ = ("a", "d", "v")

    def __init__(self, v, d=0.0, a=0.0):
        self.v, self.d, self.a = v, d, a

    def __add__(self, other):
        return Jet(self.v + other.v, self.d + other.d, self.a + other.a)

    def __neg__(self):
        return Jet(-self.v, -self.d, -self.a)

    def __sub__(self, other):
        return Jet(self.v - other.v, self.d - other.d, self.a - other.a)

    def times(self, factor) -> "Jet":
        """The jet times a constant."""
        return Jet(self.v * factor, self.d * factor, self.a * factor)


class Rates:
    """Jets along fields of twists (body -> twist).

    field: twists that second rates a are linear in: velocities, columns, or accelerations. real:
        twists of the real motion, for rates d and for the quadratic terms of a; without it d is 0.
        second: a of coordinates by their place (joint or body, name), 0 where none is given.
    """

    def __init__(
        self, k, field: dict | None = None, real: dict | None = None, second: dict | None = None
    ):
        self.k = k
        self.field = field or {}
        self.real = real or {}
        self.second = second or {}

    def spin(self, body: Body) -> Jet:
        """Rates of a body's angle; the angle itself stays out of them."""
        return Jet(0.0, self.real.get(body, ZERO)[2], self.field.get(body, ZERO)[2])

    def vector(self, body: Body, *parts: tuple[Jet, Jet]) -> tuple[Jet, Jet]:
        """The sum of vectors of a body's frame, along the fixed axes."""
        return self._turned(body, parts, (Jet(0.0), Jet(0.0)))

    def point(self, body: Body, *parts: tuple[Jet, Jet]) -> tuple[Jet, Jet]:
        """A point of a body, given from its centre of mass."""
        pose = self.k.poses[body]
        u, v, _ = self.real.get(body, ZERO)
        x, y, _ = self.field.get(body, ZERO)
        return self._turned(body, parts, (Jet(pose.x, u, x), Jet(pose.y, v, y)))

    def _turned(self, body: Body, parts: tuple, start: tuple[Jet, Jet]) -> tuple[Jet, Jet]:
        """Vectors of a body's frame, added to a start."""
        turned, add = self.k.turned, self.k.trace.sum
        v, r, q = (
            [
                add(c)
                for c in zip(
                    *(turned(body, getattr(x, n), getattr(y, n)) for x, y in parts), strict=True
                )
            ]
            for n in "vda"
        )
        (x, y), spin = start, self.spin(body)
        w, alpha = spin.d, spin.a
        square, tx, ty = w * w, w * r[0], w * r[1]
        return (
            Jet(
                x.v + v[0],
                (x.d + r[0]) - w * v[1],
                (x.a + q[0] - alpha * v[1]) - (square * v[0] + (ty + ty)),
            ),
            Jet(
                y.v + v[1],
                (y.d + r[1]) + w * v[0],
                (y.a + q[1] + alpha * v[0]) - (square * v[1] - (tx + tx)),
            ),
        )

    def local(self, element, side: str) -> tuple[Jet, Jet]:
        """A point of an element, in the frame of its body."""
        return tuple(map(Jet, self.k.local(element, side)))

    def seen_from(
        self, joint: Joint, vector: tuple[Jet, Jet], fixed: dict[str, Jet]
    ) -> tuple[Jet, Jet]:
        """Components of a vector along and across a joint's axis; fixed: those that the joint
        gives.
        """
        dx, dy = self.k.axis(joint, joint.a.body)
        spin, (x, y) = self.spin(joint.a.body), vector
        w, alpha = spin.d, spin.a
        along, across = (
            [combine(getattr(x, n), getattr(y, n)) for n in "vda"]
            for combine in (lambda a, b: dx * a + dy * b, lambda a, b: dx * b - dy * a)
        )
        lx = fixed.get(ALONG, Jet(along[0])).v
        ly = fixed.get(ACROSS, Jet(across[0])).v
        jx = Jet(lx, along[1], along[2] + alpha * ly)
        jy = Jet(ly, across[1], across[2] - alpha * lx)
        if not is_zero(w):
            jx.d = fixed[ALONG].d if ALONG in fixed else along[1] + w * ly
            jy.d = fixed[ACROSS].d if ACROSS in fixed else across[1] - w * lx
            jx.a = jx.a + (w * across[1] + w * jy.d)
            jy.a = jy.a - (w * along[1] + w * jx.d)
        return jx, jy

    # --- joints
    def held(self, joint: Joint) -> dict[str, Jet]:
        """The relative coordinates that a joint does not leave free."""
        result = {}
        for axis in RELATIVE:
            if getattr(joint, axis) is not FREE:
                value, rate = self.k.held(joint, axis)
                result[axis] = Jet(
                    value, rate if self.real else 0.0, self.second.get((joint, axis), 0.0)
                )
        return result

    def measured(self, joint: Joint, fixed: dict[str, Jet]) -> dict[str, Jet]:
        """Relative coordinates from points and angles of both bodies; the turn has rates only.

        fixed: of a joint that is closed, which shortens the rates.
        """
        (ax, ay), (bx, by) = (
            self.point(p.body, self.local(joint, s)) for s, p in (("a", joint.a), ("b", joint.b))
        )
        gap = bx - ax, by - ay
        along, across = self.seen_from(joint, gap, fixed) if joint.turns else gap
        return {
            ALONG: along,
            ACROSS: across,
            TURN: self.spin(joint.b.body) - self.spin(joint.a.body),
        }

    def residual(self, joint: Joint) -> list[Jet]:
        """Rates of what closes a joint: measured minus fixed, of each coordinate that is not
        free.
        """
        fixed = self.held(joint)
        measured = self.measured(joint, fixed)
        return [measured[axis] - value for axis, value in fixed.items()]

    def carried(self, attachment) -> Twist:
        """Twist of an attached body from its parent's and its coordinates' rates; the field takes
        it up.
        """
        if attachment.joint is None:
            twist = tuple(self.second.get(c.address, 0.0) for c in attachment.coordinates)
        else:
            twist = self._carried_by(attachment)
        self.field[attachment.body] = twist
        return twist

    def _carried_by(self, attachment) -> Twist:
        body, joint, parent = attachment.body, attachment.joint, attachment.parent
        side, sign = joint.side(body), joint.sign(body)
        jets = self.relative(joint)
        absolute = any(c.axis == "angle" for c in attachment.coordinates)
        turn = (
            self.second.get((body, "angle"), 0.0)
            if absolute
            else self.spin(parent).a + sign * jets[TURN].a
        )
        self.field[body] = (0.0, 0.0, turn)  # what turns with the body needs its spin only
        local = {end: [self.local(joint, end)] for end in "ab"}
        if joint.turns:
            local["a"].append(self.step(joint, jets))
        opposite = "a" if side == "b" else "b"
        px, py = self.point(parent, *local[opposite])
        qx, qy = self.vector(body, *local[side])
        if not joint.turns:
            px += jets[ALONG].times(sign)
            py += jets[ACROSS].times(sign)
        return px.a - qx.a, py.a - qy.a, turn

    def relative(self, joint: Joint) -> dict[str, Jet]:
        """All relative coordinates; the turn has rates only, where it is free."""
        return self.held(joint) | {axis: self._free(joint, axis) for axis in joint.free}

    def step(self, joint: Joint, jets: dict[str, Jet]) -> tuple[Jet, Jet]:
        """From point a to point b, in the frame of body a."""
        dx, dy = self.k.local_axis(joint)
        along, across = jets[ALONG], jets[ACROSS]
        return along.times(dx) - across.times(dy), along.times(dy) + across.times(dx)

    def _free(self, joint: Joint, axis: str) -> Jet:
        """A free coordinate of a joint along the way."""
        second = self.second.get((joint, axis), 0.0)
        if axis == TURN:
            return Jet(0.0, 0.0, second)
        value, rate = self.k.free(joint, axis, self.real)
        return Jet(value, rate, second)


Vector = tuple[Value, Value]


@dataclass(frozen=True)
class Pose:
    """Centre of mass and orientation; angle is None where a closed form gives cosine and sine
    only.
    """

    x: Value
    y: Value
    cosine: Value
    sine: Value
    angle: Value | None = None

    def turned(self, x, y) -> Vector:
        """A vector of the body's frame in the fixed frame."""
        return self.cosine * x - self.sine * y, self.sine * x + self.cosine * y


class Kinematics:
    """Poses, and fields over them.

    number(name) reads a scene number. coordinate: values of coordinates by their place; rate: of
    those that the real motion has; state: (element, name) -> value and rate of states that are
    coordinates. memory(i): work slot i, for what is carried from step to step.
    """

    def __init__(self, trace: Trace, number, coordinate: dict, state: dict, memory=None):
        self.trace, self.number, self.coordinate, self.state = trace, number, coordinate, state
        self.memory = memory
        self.rate: dict[tuple, Value] = {}
        self.poses: dict[Body, Pose] = {ground: Pose(0.0, 0.0, 1.0, 0.0, 0.0)}
        self.solved: list = []  # groups that Newton's method solves
        self.remembered: list[tuple[str, str]] = []  # coordinate (its name, of what) in each slot
        self.values: list = []  # what an accepted step puts there
        self.columns: Columns | None = None  # what poses and turning vectors are differentiated by

    # --- geometry
    def local(self, element, side: str) -> Vector:
        """A point of an element from its body's centre of mass, in the body's frame."""
        return self.number(f"{element.key}/{side}/x"), self.number(f"{element.key}/{side}/y")

    def arm(self, element, side: str) -> Vector:
        """From a body's centre of mass to an element's point, along the fixed axes."""
        return self.turned(getattr(element, side).body, *self.local(element, side))

    def turned(self, body: Body, x, y) -> Vector:
        """A vector of a body's frame along the fixed axes; it is differentiated as one that
        turns.
        """
        vector = self.poses[body].turned(x, y)
        if self.columns is not None and body is not ground:
            self.columns.turn(body, vector, (x, y))
        return vector

    def joint_point(self, joint, side: str) -> Vector:
        pose = self.poses[getattr(joint, side).body]
        x, y = self.arm(joint, side)
        return pose.x + x, pose.y + y

    def held(self, joint: Joint, axis: str) -> Vector:
        """Value and rate of a relative coordinate that the joint does not leave free."""
        source = getattr(joint, axis)
        value = self.number(f"{joint.key}/{source.number}") if source.number else 0.0
        offset, rate = self.state.get((joint, source.state), (0.0, 0.0))
        return value + offset, rate

    def free(self, joint: Joint, axis: str, real: dict) -> Vector:
        """Value and rate of a coordinate that a joint leaves free: of the plan, or measured."""
        key = joint, axis
        if key not in self.coordinate:
            self.coordinate[key] = Rates(self).measured(joint, {})[axis].v
        if not real:
            return self.coordinate[key], 0.0
        if key not in self.rate:
            rates = Rates(self, real=real)
            self.rate[key] = rates.measured(joint, rates.held(joint))[axis].d
        return self.coordinate[key], self.rate[key]

    def pin(self, joint, side: str) -> Vector:
        """Place of a hinge's pin by the other side: r_b = r_a + e."""
        x, y = self.joint_point(joint, "a" if side == "b" else "b")
        ex, ey = (self.held(joint, axis)[0] for axis in (ALONG, ACROSS))
        return (x + ex, y + ey) if side == "b" else (x - ex, y - ey)

    def local_axis(self, joint: Joint) -> Vector:
        """Direction of a joint's axis in the frame of body a."""
        return self.number(f"{joint.key}/axis/x"), self.number(f"{joint.key}/axis/y")

    def axis(self, joint: Joint, base: Body) -> Vector:
        """Direction of a joint's axis along the fixed axes, from the orientation of one of its
        bodies.
        """
        x, y = self.local_axis(joint)
        if base is joint.b.body:
            c, s = self.relative(joint)
            x, y = c * x + s * y, c * y - s * x
        return self.turned(base, x, y)

    def turn(self, joint: Joint) -> Value:
        """Angle of body b against body a."""
        a, b = joint.bodies()
        return self.angle(b) - self.angle(a)

    def relative(self, joint: Joint) -> Vector:
        """Cosine and sine of the turn that a joint keeps."""
        turn = self.held(joint, TURN)[0]
        return self.trace.cos(turn), self.trace.sin(turn)

    def arms(self, joint: Joint) -> tuple:
        """From both centres of mass to a joint's point b, with the heights of points a and b."""
        rates = Rates(self)
        parts = [rates.local(joint, "a")]
        if joint.turns:
            parts.append(rates.step(joint, rates.relative(joint)))
        x, y = rates.vector(joint.a.body, *parts)
        heights = (self.number(f"{joint.key}/{side}/z") for side in "ab")
        return tuple(
            (*arm, z) for arm, z in zip(((x.v, y.v), self.arm(joint, "b")), heights, strict=True)
        )

    # --- positions
    def place_all(self, plan: Plan) -> None:
        for group in plan.groups:
            self.trace.section = f"position of {group.label()}"
            self.place_group(group)

    def place_group(self, group: Group) -> None:
        if group.form == "newton":
            loops.solve_by_newton(self, group)
        elif group.form != "tree":
            getattr(loops, f"place_{group.form.lower()}")(self, group)
            return
        for attachment in group.attachments:
            self.place_body(attachment)

    def place_body(self, attachment: Attachment) -> None:
        """Place a body whose coordinates are given."""
        body, joint, parent = attachment.body, attachment.joint, attachment.parent
        values = {c.axis: self.coordinate[c.address] for c in attachment.coordinates}
        if joint is None:
            angle = values["angle"]
            cosine = self.trace.cos(angle)
            sine = self.trace.sin(angle)
            self.poses[body] = Pose(values["x"], values["y"], cosine, sine, angle)
            return
        if TURN in values:
            turn = self.angle(parent)
            values["angle"] = turn + values[TURN] if body is joint.b.body else turn - values[TURN]
        if "angle" in values:
            angle = values["angle"]
            orientation = self.trace.cos(angle), self.trace.sin(angle), angle
        else:
            orientation = self.orientation(attachment)
        self.place_by(attachment, orientation, values.get(ALONG), values.get(ACROSS))

    def orientation(self, attachment: Attachment) -> tuple:
        """Cosine, sine and angle of a body that does not turn against its parent."""
        joint = attachment.joint
        base = self.poses[attachment.parent]
        c, s = self.relative(joint)
        turn = self.held(joint, TURN)[0]
        if attachment.body is joint.a.body:
            s, turn = -s, -turn
        angle = None if base.angle is None else base.angle + turn
        return base.cosine * c - base.sine * s, base.sine * c + base.cosine * s, angle

    def place_by(self, attachment: Attachment, orientation: tuple, along=None, across=None) -> None:
        """Place a body of a given orientation on its parent; along, across: where the joint leaves
        them free.
        """
        body, joint = attachment.body, attachment.joint
        along, across = (
            self.held(joint, axis)[0] if value is None else value
            for axis, value in ((ALONG, along), (ACROSS, across))
        )
        side, sign = joint.side(body), joint.sign(body)
        x, y = self.joint_point(joint, "a" if side == "b" else "b")
        pose = Pose(0.0, 0.0, *orientation)
        if joint.turns:
            base = self.poses[joint.a.body] if side == "b" else pose
            dx, dy = base.turned(*self.local_axis(joint))
            ex = along * dx - across * dy
            ey = along * dy + across * dx
        else:
            ex, ey = along, across
        ax, ay = pose.turned(*self.local(joint, side))
        self.poses[body] = Pose(x + sign * ex - ax, y + sign * ey - ay, *orientation)

    def angle(self, body: Body) -> Value:
        """Orientation as an angle, in (-pi, pi] where only cosine and sine are known."""
        pose = self.poses[body]
        return pose.angle if pose.angle is not None else self.trace.atan2(pose.sine, pose.cosine)

    def remember(self, axis: str, name: str) -> Value:
        """The last accepted value of a coordinate; its present value must follow in self.values."""
        self.remembered.append((axis, name))
        return self.memory(len(self.remembered) - 1)

    def whole_angle(self, body: Body) -> Value:
        """Orientation without jumps: counted on from the last accepted step where only cosine and
        sine are known.
        """
        pose = self.poses[body]
        if pose.angle is not None:
            return pose.angle
        slot = ("angle", body.name)
        if slot in self.remembered:
            return self.values[self.remembered.index(slot)]
        last = self.remember(*slot)
        c = self.trace.cos(last)
        s = self.trace.sin(last)
        turned = self.trace.atan2(pose.sine * c - pose.cosine * s, pose.cosine * c + pose.sine * s)
        self.values.append(last + turned)
        return self.values[-1]


class Columns:
    """Tangents of poses and of turning vectors along the coordinates of a plan: columns solved once
    for all.

    values: of the coordinates and of states that are coordinates, by their place.
    """

    def __init__(self, kinematics: Kinematics, plan: Plan, values: dict):
        self.k = kinematics
        self.values = values
        self.propagation = Propagation(kinematics, plan)
        self.moving = _moving(plan, values)

    @cached_property
    def fields(self) -> dict[tuple, dict]:
        """The field of each coordinate's unit rate."""
        return {coordinate: self.propagation.field({coordinate: 1.0}) for coordinate in self.values}

    def _inputs(self, body: Body) -> list:
        return [self.values[coordinate] for coordinate in self.moving[body]]

    def poses(self) -> None:
        """Differentiate all poses by columns."""
        for body, pose in self.k.poses.items():
            if body is not ground:
                self.k.trace.follow(
                    [pose.x, pose.y], self._inputs(body), partial(self._moved, body)
                )
                self.turn(body, (pose.cosine, pose.sine), (1.0, 0.0))

    def turn(self, body: Body, vector: Vector, local: Vector) -> None:
        """Differentiate a vector that turns with a body, and whose parts in the body's frame may
        change.
        """
        self.k.trace.follow(
            list(vector), [*self._inputs(body), *local], partial(self._turned, body, vector)
        )

    def _moved(self, body: Body, tangents: list) -> list:
        return [self._rate(body, axis, tangents) for axis in (0, 1)]

    def _turned(self, body: Body, vector: Vector, tangents: list) -> list:
        """w x v, and the change in the body's frame, turned."""
        spin = self._rate(body, 2, tangents)
        dx, dy = tangents[-2:]
        x, y, pose = {}, {}, self.k.poses[body]
        for column in sorted({*spin, *dx, *dy}):
            w = spin.get(column, 0.0)
            step = pose.turned(dx.get(column, 0.0), dy.get(column, 0.0))
            x[column] = step[0] - w * vector[1]
            y[column] = step[1] + w * vector[0]
        return [x, y]

    def _rate(self, body: Body, axis: int, tangents: list) -> dict:
        """One component of a body's columns, times the tangents of the coordinates."""
        factors = [self.fields[coordinate][body][axis] for coordinate in self.moving[body]]
        pairs = [(t, f) for t, f in zip(tangents, factors, strict=False) if not is_zero(f)]
        columns = sorted({c for t, _ in pairs for c in t})
        return {c: self.k.trace.sum(f * t[c] for t, f in pairs if c in t) for c in columns}


def _moving(plan: Plan, places: dict) -> dict[Body, list]:
    """The coordinates that move each body."""
    moving: dict[Body, dict] = {ground: {}}
    for group in plan.groups:
        together: dict = {}
        for attachment in group.attachments:
            joints = {attachment.joint, *group.closures}
            mine = [
                p
                for p in places
                if p[0] in joints or p in (c.address for c in attachment.coordinates)
            ]
            together |= moving.get(attachment.parent, {}) | dict.fromkeys(mine)
            for body in (b for j in group.closures for b in j.bodies()):
                together |= moving.get(body, {})
            moving[attachment.body] = dict(together)
        if group.closures:
            moving |= {a.body: together for a in group.attachments}
    return {body: list(those) for body, those in moving.items()}


class Propagation:
    """Spreads rates over the groups of a plan; the loops' linear equations are set up once per
    group.
    """

    def __init__(self, kinematics: Kinematics, plan: Plan):
        self.kinematics, self.plan = kinematics, plan
        self._loops: dict[int, tuple[list, list]] = {}

    def field(self, second: dict, real: dict | None = None) -> dict:
        """Field for given rates of coordinates and of states by their place (absent: zero).

        With `real`, the field of velocities, they are second rates, and the result includes the
        quadratic terms.
        """
        return self._spread(Rates(self.kinematics, {ground: ZERO}, real, second), {})

    def velocities(self, rates: dict) -> dict:
        """The field of the real motion; the rates of all coordinates of the plan are noted."""
        self.kinematics.rate.update(rates)
        return self._spread(
            Rates(self.kinematics, {ground: ZERO}, None, rates), self.kinematics.rate
        )

    def _spread(self, rates: Rates, noted: dict) -> dict:
        for number, group in enumerate(self.plan.groups):
            for attachment in group.attachments:
                rates.carried(attachment)
            if group.closures:
                noted |= self._close(number, group, rates)
        return rates.field

    def _loop(self, number: int, group: Group):
        """Effect of each unknown rate on the group's bodies, and the matrix of the closing
        equations.
        """
        if number not in self._loops:
            effects = []
            for unknown in group.unknowns:
                rates = Rates(self.kinematics, second={unknown.address: 1.0})
                for attachment in group.attachments:
                    rates.carried(attachment)
                effects.append((unknown, rates))
            columns = [
                [r.a for j in group.closures for r in rates.residual(j)] for _, rates in effects
            ]
            matrix = [list(row) for row in zip(*columns, strict=True)]
            self._loops[number] = [(c, rates.field) for c, rates in effects], matrix
        return self._loops[number]

    def _close(self, number: int, group: Group, rates: Rates) -> dict:
        """Rates of a group's unknown coordinates that keep its loops closed; their motion is
        added.
        """
        residual = [r.a for j in group.closures for r in rates.residual(j)]
        if all(map(is_zero, residual)):
            values = [0.0] * len(residual)
        else:
            values = loops.solve(
                self.kinematics.trace, self.matrix(number, group), [-r for r in residual]
            )
        for (_, effect), value in zip(self.effects(number, group), values, strict=True):
            for body, twist in effect.items():
                rates.field[body] = tuple(
                    o + value * t for o, t in zip(rates.field[body], twist, strict=True)
                )
        return {c.address: value for c, value in zip(group.unknowns, values, strict=True)}

    def transposed(self, number: int, group: Group, load: list) -> list:
        """Forces of the closing equations that balance generalised loads of the group's unknown
        coordinates.
        """
        columns = zip(*self.matrix(number, group), strict=True)
        return loops.solve(self.kinematics.trace, [list(c) for c in columns], load)

    def effects(self, number: int, group: Group) -> list:
        return self._loop(number, group)[0]

    def matrix(self, number: int, group: Group) -> list:
        """The closing equations of a group's unknown rates, row by row."""
        return self._loop(number, group)[1]


MOST = 100  # traced statements that a process keeps
_traced: dict[tuple, tuple] = {}


class Geometry:
    """Values and slopes of coordinates at positions q, (x, y, angle) of each body.

    places: (joint, name) of the relative coordinates, known ones less the numbers that joints keep
        them at, then (body, "x"), (body, "y"), (body, "angle"). angles: places of the last in q.
        read: the scene's numbers that they depend on.
    """

    def __init__(self, scene: Scene, values: list[float], traced: tuple):
        relative = [(j, axis) for j in scene.joints for axis in RELATIVE]
        absolute = [(b, axis) for b in scene.bodies for axis in ABSOLUTE]
        self.count = len(relative)
        self.size = len(absolute)
        self.places = [*relative, *absolute]
        self.index = {coordinate: i for i, coordinate in enumerate(self.places)}
        self.function, self.rows, self.columns, read = traced
        self.values = values
        self.read = tuple(values[i] for i in read)
        self.angles = [i for i, (_, axis) in enumerate(absolute) if axis == "angle"]

    def pose(self, body: Body) -> slice:
        """Places of a body's x, y and angle in q."""
        first = self.index[body, ABSOLUTE[0]] - self.count
        return slice(first, first + len(ABSOLUTE))

    @classmethod
    def of(cls, scene: Scene, numbers: Numbers) -> "Geometry":
        """The geometry of a scene; scenes of one structure share its tracing."""
        if numbers.signature not in _traced:
            if len(_traced) >= MOST:
                del _traced[next(iter(_traced))]
            _traced[numbers.signature] = _trace(scene, numbers)
        return cls(scene, numbers.values, _traced[numbers.signature])

    def __call__(self, q: Sequence[float]) -> tuple[list[float], np.ndarray]:
        """Values of all coordinates, and their slopes (coordinates, q)."""
        q = [float(v) for v in q]
        out = self.function((), *q, *self.values)
        slopes = np.zeros((self.count + self.size, self.size))
        slopes[self.rows, self.columns] = out[self.count :]
        slopes[self.count :] = np.eye(self.size)
        return [*out[: self.count], *q], slopes

    def value(self, q: Sequence[float], coordinate: tuple) -> float:
        """Value of one coordinate."""
        return self(q)[0][self.index[coordinate]]


def _trace(scene: Scene, numbers: Numbers) -> tuple[Callable, np.ndarray, np.ndarray, list[int]]:
    """Function of q and the scene's numbers: values, then slopes at the places rows, columns;
    numbers that it reads.
    """
    function = Function("geometry")
    q = {body: [function.argument() for _ in ABSOLUTE] for body in scene.bodies}
    free = {name: function.argument() for name in numbers.index}
    parameters = numbers.constants | free
    trace = function.trace
    k = Kinematics(trace, parameters.__getitem__, {}, {})
    k.poses |= {
        body: Pose(x, y, trace.cos(angle), trace.sin(angle), angle)
        for body, (x, y, angle) in q.items()
    }
    values = [v for joint in scene.joints for v in _relative(k, joint)]
    if not values:
        return lambda par, *numbers: (), *np.zeros((2, 0), dtype=int), []
    leaves = [leaf for pose in q.values() for leaf in pose]
    slopes = trace.tangent(values, {leaf: {i: 1.0} for i, leaf in enumerate(leaves)})
    places = [(i, j) for i, slope in enumerate(slopes) for j in slope]
    function.outputs = [*values, *(slopes[i][j] for i, j in places)]
    scope: dict = {"math": math}
    exec(function_text(function), scope)  # noqa: S102
    rows, columns = np.array(places, dtype=int).reshape(-1, 2).T
    alive = set(live(function.outputs))
    return (
        scope[function.name],
        rows,
        columns,
        [i for i, leaf in enumerate(free.values()) if leaf in alive],
    )


def _relative(k: Kinematics, joint) -> list:
    """Along, across and turn of a joint; a turn that it keeps is in (-pi, pi]."""
    along, across = offsets(k, joint)
    if TURN in joint.free:
        return [along, across, k.poses[joint.b.body].angle - k.poses[joint.a.body].angle]
    return [along, across, k.trace.atan2(*wrong_turn(k, joint))]
