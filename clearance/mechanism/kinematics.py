"""Planar kinematics along a plan, written once over traced scalars.

Poses are of centres of mass. A *field* gives each body a planar twist (x, y, turning): real velocities, velocities per
unit of one independent speed (columns), or accelerations; all three follow the same linear rules, accelerations with
the quadratic terms added.
"""

from dataclasses import dataclass

from clearance.joints import Prismatic
from clearance.mechanism import loops
from clearance.mechanism.topology import Attachment, Group, Plan
from clearance.mechanism.trace import Trace, Value, is_zero
from clearance.scene import Body, ground

Vector = tuple[Value, Value]
Twist = tuple[Value, Value, Value]
ZERO: Twist = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Pose:
    """Centre of mass and orientation; angle is None where a closed form gives cosine and sine only."""

    x: Value
    y: Value
    cosine: Value
    sine: Value
    angle: Value | None = None

    def turned(self, x, y) -> Vector:
        """A vector of the body's frame in the fixed frame."""
        return self.cosine * x - self.sine * y, self.sine * x + self.cosine * y


class Kinematics:
    """Poses, and fields over them. `number(name)` reads a scene number, `coordinate[c]` the value of a coordinate."""

    def __init__(self, trace: Trace, number, coordinate: dict, offset: dict, memory=None):
        self.trace, self.number, self.coordinate, self.offset = trace, number, coordinate, offset
        self.memory = memory  # work slot by number, for what is carried from step to step
        self.poses: dict[Body, Pose] = {ground: Pose(0.0, 0.0, 1.0, 0.0, 0.0)}
        self.solved: list = []  # groups that Newton's method solves
        self.remembered: list[tuple[str, str]] = []  # ("angle", body) or ("slide", joint) of each slot
        self.values: list = []  # what an accepted step puts there

    # --- geometry
    def arm(self, joint, side: str) -> Vector:
        """From the centre of mass to a joint's point, in the fixed frame."""
        body = (joint.a if side == "a" else joint.b).body
        local = (self.number(f"{joint.key}.{side}.x"), self.number(f"{joint.key}.{side}.y"))
        return self.poses[body].turned(*local)

    def joint_point(self, joint, side: str) -> Vector:
        body = (joint.a if side == "a" else joint.b).body
        x, y = self.arm(joint, side)
        return self.poses[body].x + x, self.poses[body].y + y

    def pin(self, joint, side: str) -> Vector:
        """Place of the pin by the other side: r_b = r_a + e."""
        x, y = self.joint_point(joint, "a" if side == "b" else "b")
        ex, ey = self.offset.get(joint, (0.0, 0.0))
        return (x + ex, y + ey) if side == "b" else (x - ex, y - ey)

    def axis(self, joint: Prismatic, base: Body) -> Vector:
        """Direction of a slide in the fixed frame, from the orientation of one of its bodies."""
        x, y = self.number(f"{joint.key}.axis.x"), self.number(f"{joint.key}.axis.y")
        if base is joint.b.body:
            c, s = self._relative(joint)
            x, y = c * x + s * y, c * y - s * x
        return self.poses[base].turned(x, y)

    def _relative(self, joint: Prismatic) -> Vector:
        angle = self.number(f"{joint.key}.angle")
        return self.trace.cos(angle), self.trace.sin(angle)

    # --- positions
    def place(self, plan: Plan) -> None:
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
        """Place a body whose coordinates are known."""
        body, joint = attachment.body, attachment.joint
        values = [self.coordinate[c] for c in attachment.coordinates]
        if joint is None:
            x, y, angle = values
            self.poses[body] = Pose(x, y, self.trace.cos(angle), self.trace.sin(angle), angle)
        elif isinstance(joint, Prismatic):
            self.place_slide(attachment, values[0])
        else:
            angle = values[0]
            if attachment.coordinates[0].what == "relative":
                parent = self.angle(attachment.parent)
                angle = parent + angle if body is joint.b.body else parent - angle
            self.place_hinge(attachment, self.trace.cos(angle), self.trace.sin(angle), angle)

    def angle(self, body: Body) -> Value:
        """Orientation as an angle, in (-pi, pi] where only cosine and sine are known."""
        pose = self.poses[body]
        return pose.angle if pose.angle is not None else self.trace.atan2(pose.sine, pose.cosine)

    def remember(self, what: str, name: str) -> Value:
        """The last accepted value of an angle or slide; its present value must follow in self.values."""
        self.remembered.append((what, name))
        return self.memory(len(self.remembered) - 1)

    def whole_angle(self, body: Body) -> Value:
        """Orientation without jumps: counted on from the last accepted step where only cosine and sine are known."""
        pose = self.poses[body]
        if pose.angle is not None:
            return pose.angle
        slot = ("angle", body.name)
        if slot in self.remembered:
            return self.values[self.remembered.index(slot)]
        last = self.remember(*slot)
        c, s = self.trace.cos(last), self.trace.sin(last)
        turned = self.trace.atan2(pose.sine * c - pose.cosine * s, pose.cosine * c + pose.sine * s)
        self.values.append(last + turned)
        return self.values[-1]

    def place_hinge(self, attachment: Attachment, cosine, sine, angle=None) -> None:
        body, joint = attachment.body, attachment.joint
        side = "b" if body is joint.b.body else "a"
        self._place_at(body, self.pin(joint, side), joint, side, cosine, sine, angle)

    def place_slide(self, attachment: Attachment, slide) -> None:
        body, joint, parent = attachment.body, attachment.joint, attachment.parent
        side, sign = ("b", 1.0) if body is joint.b.body else ("a", -1.0)
        cosine, sine, angle = self.slide_orientation(attachment)
        dx, dy = self.axis(joint, parent)
        x, y = self.joint_point(joint, "a" if side == "b" else "b")
        point = (x + sign * slide * dx, y + sign * slide * dy)
        self._place_at(body, point, joint, side, cosine, sine, angle)

    def slide_orientation(self, attachment: Attachment):
        """Cosine, sine and angle of a sliding body from its parent's."""
        joint, base = attachment.joint, self.poses[attachment.parent]
        c, s = self._relative(joint)
        turn = self.number(f"{joint.key}.angle")
        if attachment.body is joint.a.body:
            s, turn = -s, -turn
        angle = None if base.angle is None else base.angle + turn
        return base.cosine * c - base.sine * s, base.sine * c + base.cosine * s, angle

    def _place_at(self, body, point, joint, side, cosine, sine, angle) -> None:
        pose = Pose(0.0, 0.0, cosine, sine, angle)
        x, y = pose.turned(self.number(f"{joint.key}.{side}.x"), self.number(f"{joint.key}.{side}.y"))
        self.poses[body] = Pose(point[0] - x, point[1] - y, cosine, sine, angle)

    # --- fields
    def carried(self, attachment: Attachment, field: dict, rates: list, offset: Vector, motion=None) -> Twist:
        """Twist of an attached body from its parent's and its coordinates' rates.

        With `motion` (the field of real velocities) the quadratic terms of accelerations are added.
        """
        body, joint, parent = attachment.body, attachment.joint, attachment.parent
        if joint is None:
            return tuple(rates)
        above, rate = field.get(parent, ZERO), rates[0]
        side, other, sign = ("b", "a", 1.0) if body is joint.b.body else ("a", "b", -1.0)
        own = self.arm(joint, side)
        if isinstance(joint, Prismatic):
            base = self.reach(parent, joint, side)
            dx, dy = self.axis(joint, parent)
            x, y = moved(above, base)
            x, y = x + sign * rate * dx, y + sign * rate * dy
            turning = above[2]
            if motion is not None:
                double = 2.0 * sign * self.slide_rate(joint, motion) * motion[parent][2]
                x, y = x - double * dy, y + double * dx
        else:
            base = self.arm(joint, other)
            x, y = moved(above, base)
            x, y = x + sign * offset[0], y + sign * offset[1]
            turning = above[2] + sign * rate if attachment.coordinates[0].what == "relative" else rate
        x, y = x + turning * own[1], y - turning * own[0]
        if motion is not None:
            outer, inner = motion[parent][2], motion[body][2]
            x = x - outer * outer * base[0] + inner * inner * own[0]
            y = y - outer * outer * base[1] + inner * inner * own[1]
        return x, y, turning

    def reach(self, body: Body, joint, side: str) -> Vector:
        """From a body's centre of mass to a joint's point on the other body."""
        x, y = self.joint_point(joint, side)
        return x - self.poses[body].x, y - self.poses[body].y

    def separation(self, joint, field: dict) -> tuple[Vector, Vector]:
        """From a joint's point a to its point b, and the rate, from poses and velocities."""
        (ax, ay), (bx, by) = (self.joint_point(joint, s) for s in "ab")
        ua, va = moved(field[joint.a.body], self.arm(joint, "a"))
        ub, vb = moved(field[joint.b.body], self.arm(joint, "b"))
        return (bx - ax, by - ay), (ub - ua, vb - va)

    def slide_rate(self, joint: Prismatic, field: dict) -> Value:
        """Rate of the displacement of b along a's axis."""
        a = joint.a.body
        dx, dy = self.axis(joint, a)
        ax, ay = moved(field[a], self.reach(a, joint, "b"))
        bx, by = moved(field[joint.b.body], self.arm(joint, "b"))
        return dx * (bx - ax) + dy * (by - ay)

    def closure(self, joint, field: dict, offset: Vector, motion=None) -> list:
        """Rates of a closing joint's two equations for a field (with quadratic terms where motion is given)."""
        a, b = joint.a.body, joint.b.body
        arm_a, arm_b = self.arm(joint, "a"), self.arm(joint, "b")
        fa, fb = field.get(a, ZERO), field.get(b, ZERO)
        (ax, ay), (bx, by) = moved(fa, arm_a), moved(fb, arm_b)
        x, y = bx - ax, by - ay
        if motion is not None:
            wa, wb = motion[a][2], motion[b][2]
            x = x - wb * wb * arm_b[0] + wa * wa * arm_a[0]
            y = y - wb * wb * arm_b[1] + wa * wa * arm_a[1]
        if not isinstance(joint, Prismatic):
            return [x - offset[0], y - offset[1]]
        dx, dy = self.axis(joint, a)
        pa, pb = self.joint_point(joint, "a"), self.joint_point(joint, "b")
        along = dx * (pb[0] - pa[0]) + dy * (pb[1] - pa[1])
        across = dx * y - dy * x - fa[2] * along
        if motion is not None:
            (ax, ay), (bx, by) = moved(motion[a], arm_a), moved(motion[b], arm_b)
            across = across - 2.0 * motion[a][2] * (dx * (bx - ax) + dy * (by - ay))
        return [across, fb[2] - fa[2]]


def moved(twist: Twist, arm: Vector) -> Vector:
    """Velocity of a point at `arm` from the centre of mass."""
    return twist[0] - twist[2] * arm[1], twist[1] + twist[2] * arm[0]


class Propagation:
    """Spreads rates over the groups of a plan; the loops' linear equations are set up once per group."""

    def __init__(self, kinematics: Kinematics, plan: Plan):
        self.kinematics, self.plan = kinematics, plan
        self._loops: dict[int, tuple[list, list]] = {}

    def field(self, rates: dict, offsets: dict, motion: dict | None = None) -> dict:
        """Field for given rates of free and driven coordinates (absent: zero) and of the clearance joints' offsets.

        With `motion`, rates are accelerations and the result includes the quadratic terms of that motion.
        """
        result = {ground: ZERO}
        for number, group in enumerate(self.plan.groups):
            bodies = self._tree(group, result, rates, offsets, motion)
            if group.closures:
                unknowns = self._close(number, group, {**result, **bodies}, offsets, motion)
                for (_, effect), value in zip(self.effects(number, group), unknowns, strict=True):
                    for body, twist in effect.items():
                        bodies[body] = tuple(o + value * t for o, t in zip(bodies[body], twist, strict=True))
            result |= bodies
        return result

    def _tree(self, group: Group, field: dict, rates: dict, offsets: dict, motion) -> dict:
        bodies: dict = {}
        for attachment in group.attachments:
            own = [rates.get(c, 0.0) for c in attachment.coordinates]
            offset = offsets.get(attachment.joint, (0.0, 0.0))
            twist = self.kinematics.carried(attachment, {**field, **bodies}, own, offset, motion)
            bodies[attachment.body] = twist
        return bodies

    def _loop(self, number: int, group: Group):
        """Effect of each unknown rate on the group's bodies, and the matrix of the closing equations."""
        if number not in self._loops:
            effects = [(c, self._tree(group, {}, {c: 1.0}, {}, None)) for c in group.unknowns]
            columns = [
                [r for j in group.closures for r in self.kinematics.closure(j, e, (0.0, 0.0))] for _, e in effects
            ]
            matrix = [list(row) for row in zip(*columns, strict=True)]
            self._loops[number] = effects, matrix
        return self._loops[number]

    def _close(self, number: int, group: Group, field: dict, offsets: dict, motion) -> list:
        residual = [
            r for j in group.closures for r in self.kinematics.closure(j, field, offsets.get(j, (0.0, 0.0)), motion)
        ]
        if all(map(is_zero, residual)):
            return [0.0] * len(residual)
        return loops.solve(self.kinematics.trace, self.matrix(number, group), [-r for r in residual])

    def transposed(self, number: int, group: Group, load: list) -> list:
        """Forces of the closing equations that balance generalised loads of the group's unknown coordinates."""
        columns = zip(*self.matrix(number, group), strict=True)
        return loops.solve(self.kinematics.trace, [list(c) for c in columns], load)

    def effects(self, number: int, group: Group) -> list:
        return self._loop(number, group)[0]

    def matrix(self, number: int, group: Group) -> list:
        """The closing equations of a group's unknown rates, row by row."""
        return self._loop(number, group)[1]
