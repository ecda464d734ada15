"""Newton-Euler over traced scalars: islands projected on their independent speeds, reactions recovered on demand."""

from dataclasses import dataclass, field, replace

from clearance.joints import ClearanceRevolute, Prismatic
from clearance.loads import Drive, Force, SpringDamper, Torque, TorsionSpring
from clearance.mechanism.branches import folded, product, times
from clearance.mechanism.joint_forces import Calls, JointForce, amount, clearance_force, spring
from clearance.mechanism.kinematics import ZERO, Kinematics, Propagation, moved
from clearance.mechanism.spatial import inertia_across, reactions_across
from clearance.mechanism.topology import Plan
from clearance.mechanism.trace import is_zero
from clearance.scene import Scene, ground


@dataclass
class Ledger:
    """Energies [J] and powers [W] of the whole mechanism; input and losses are integrated along the run."""

    kinetic: object = 0.0
    potential: object = 0.0
    input_power: object = 0.0
    losses: dict = field(default_factory=dict)  # clearance joint or damper -> power it takes out

    def lose(self, part, power) -> None:
        """Note the power that a part takes out; one that cannot take any out is not a part of the ledger."""
        if not is_zero(power):
            self.losses[part] = power


@dataclass
class Applied:
    """Everything but inertia and reactions: wrenches (x, y, moment) on bodies about their centres of mass.

    across: what acts out of the plane, (force z, moment x, moment y) about the centre of mass.
    """

    wrench: dict = field(default_factory=dict)
    across: dict = field(default_factory=dict)
    joints: dict = field(default_factory=dict)  # ClearanceRevolute -> JointForce
    springs: dict = field(default_factory=dict)  # SpringDamper -> (length, tension)
    efforts: dict = field(default_factory=dict)  # Drive -> effort of a torque or force drive
    ledger: Ledger = field(default_factory=Ledger)

    def add(self, body, x=0.0, y=0.0, moment=0.0):
        if body is not ground:
            old = self.wrench.get(body, ZERO)
            self.wrench[body] = (old[0] + x, old[1] + y, old[2] + moment)

    def add_at(self, body, arm, x, y, z=0.0):
        """A force at an arm (x, y, z) from the centre of mass."""
        self.add(body, x, y, arm[0] * y - arm[1] * x)
        self.add_across(body, z, arm[1] * z - arm[2] * y, arm[2] * x - arm[0] * z)

    def add_across(self, body, z=0.0, moment_x=0.0, moment_y=0.0):
        if body is not ground:
            old = self.across.get(body, ZERO)
            self.across[body] = (old[0] + z, old[1] + moment_x, old[2] + moment_y)


@dataclass
class Reactions:
    """Reactions of joints without clearance and efforts of drives, which keep the motion."""

    forces: dict = field(default_factory=dict)  # joint -> force x, y and moment about the joint's b point, on body b
    efforts: dict = field(default_factory=dict)  # Drive -> effort
    across: dict = field(default_factory=dict)  # joint -> force z, moments x and y about the joint's point, on body b


class Dynamics:
    """Equations of motion of a scene whose poses and velocities are known."""

    def __init__(self, scene: Scene, kinematics: Kinematics, motion: dict, plan: Plan, calls: Calls, time):
        self.scene, self.kinematics, self.motion, self.plan = scene, kinematics, motion, plan
        self.calls, self.time, self.trace = calls, time, kinematics.trace
        self.propagation = Propagation(kinematics, plan)

    # --- applied forces
    def applied(self, offsets: dict, offset_rates: dict, memories: dict) -> Applied:
        result = Applied()
        number, k = self.kinematics.number, self.kinematics
        gx, gy, gz = (number(f"scene.gravity.{axis}") for axis in "xyz")
        self.trace.section = "gravity"
        for body in self.scene.bodies:
            mass, pose = number(f"{body.key}.mass"), k.poses[body]
            result.add(body, mass * gx, mass * gy)
            result.add_across(body, mass * gz)
            x, y, w = self.motion[body]
            inertia = number(f"{body.key}.inertia")
            result.ledger.kinetic = result.ledger.kinetic + 0.5 * mass * (x * x + y * y) + 0.5 * inertia * w * w
            result.ledger.potential = result.ledger.potential - mass * (gx * pose.x + gy * pose.y)
        for joint in self.scene.clearance_joints:
            self._clearance(joint, offsets[joint], offset_rates[joint], memories[joint], result)
        for load in self.scene.loads:
            self.trace.section = load.label()
            handler = {
                SpringDamper: self._spring, TorsionSpring: self._torsion, Force: self._force, Torque: self._torque,
                Drive: self._drive,
            }[type(load)]  # fmt: skip
            handler(load, result)
        return result

    def _clearance(self, joint: ClearanceRevolute, offset, rate, memory, result: Applied) -> None:
        a, b = joint.a.body, joint.b.body
        spins = self.motion[a][2], self.motion[b][2]
        found: JointForce = clearance_force(self.calls, self.kinematics, joint, offset, rate, spins, memory)
        result.joints[joint] = found
        fx, fy = found.force
        result.add_at(a, self._arm(joint, "a"), -fx, -fy)
        result.add_at(b, self._arm(joint, "b"), fx, fy)
        result.add(a, moment=found.torque_a)
        result.add(b, moment=found.torque_b)
        result.ledger.lose(joint, found.power)

    def _spring(self, load, result: Applied) -> None:
        (fx, fy), energy, loss, length, tension = spring(self.calls, self.kinematics, load, self.motion)
        result.add_at(load.a.body, self._arm(load, "a"), -fx, -fy)
        result.add_at(load.b.body, self._arm(load, "b"), fx, fy)
        result.springs[load] = (length, tension)
        result.ledger.potential = result.ledger.potential + energy
        result.ledger.lose(load, loss)

    def _torsion(self, load, result: Applied) -> None:
        number = self.kinematics.number
        stiffness, damping = number(f"{load.key}.stiffness"), number(f"{load.key}.damping")
        twist = (
            self.kinematics.whole_angle(load.b) - self.kinematics.whole_angle(load.a) - number(f"{load.key}.free_angle")
        )
        rate = self.motion[load.b][2] - self.motion[load.a][2]
        moment = stiffness * twist + damping * rate
        result.add(load.a, moment=moment)
        result.add(load.b, moment=-moment)
        result.ledger.potential = result.ledger.potential + 0.5 * stiffness * twist * twist
        result.ledger.lose(load, damping * rate * rate)

    def _force(self, load, result: Applied) -> None:
        k, body = self.kinematics, load.point.body
        local = k.number(f"{load.key}.point.x"), k.number(f"{load.key}.point.y")
        arm = (*k.poses[body].turned(*local), k.number(f"{load.key}.point.z"))
        x, y, z = (amount(self.calls, f"{load.key}.{n}", getattr(load, n), [self.time]) for n in "xyz")
        result.add_at(body, arm, x, y, z)
        vx, vy = moved(self.motion[body], arm)
        result.ledger.input_power = result.ledger.input_power + x * vx + y * vy

    def _torque(self, load, result: Applied) -> None:
        moment = amount(self.calls, f"{load.key}.torque", load.torque, [self.time])
        result.add(load.body, moment=moment)
        result.ledger.input_power = result.ledger.input_power + moment * self.motion[load.body][2]

    def _drive(self, load: Drive, result: Applied) -> None:
        if load.prescribes:
            return
        position, rate = self.drive_coordinate(load)
        effort = amount(self.calls, f"{load.key}.{load.effort_kind}", load.effort, [self.time, position, rate])
        result.efforts[load] = effort
        self.apply_effort(load.target, effort, result)
        result.ledger.input_power = result.ledger.input_power + effort * rate

    def apply_effort(self, target, effort, result: Applied) -> None:
        """A torque on a body or between two, or a force along a slide."""
        if isinstance(target, Prismatic):
            dx, dy = self.kinematics.axis(target, target.a.body)
            arm_a, arm_b = self._slide_arms(target)
            result.add_at(target.b.body, arm_b, effort * dx, effort * dy)
            result.add_at(target.a.body, arm_a, -(effort * dx), -(effort * dy))
        elif target in self.scene.bodies:
            result.add(target, moment=effort)
        else:
            result.add(target.b.body, moment=effort)
            result.add(target.a.body, moment=-effort)

    def rubbed(self, applied: Applied, efforts: dict) -> Applied:
        """Applied wrenches, with the friction efforts of joints without clearance."""
        result = replace(applied, wrench=dict(applied.wrench), across=dict(applied.across))
        for joint, effort in efforts.items():
            self.apply_effort(joint, effort, result)
        return result

    def _arm(self, part, side: str):
        """From the centre of mass to the point of a joint or spring, out of the plane too."""
        return *self.kinematics.arm(part, side), self.kinematics.number(f"{part.key}.{side}.z")

    def _slide_arms(self, joint: Prismatic):
        """Arms of both bodies to the same place, the sliding point b."""
        height = self.kinematics.number(f"{joint.key}.a.z")
        return (*self.kinematics.reach(joint.a.body, joint, "b"), height), self._arm(joint, "b")

    def joint_rate(self, joint):
        """Rate of body b against body a: of the angle, or of the displacement along the axis."""
        if isinstance(joint, Prismatic):
            return self.kinematics.slide_rate(joint, self.motion)
        return self.motion[joint.b.body][2] - self.motion[joint.a.body][2]

    def drive_coordinate(self, load: Drive):
        """Driven coordinate and its rate, from poses and velocities."""
        k, target, f = self.kinematics, load.target, self.motion
        if isinstance(target, Prismatic):
            dx, dy = k.axis(target, target.a.body)
            pa, pb = k.joint_point(target, "a"), k.joint_point(target, "b")
            return dx * (pb[0] - pa[0]) + dy * (pb[1] - pa[1]), self.joint_rate(target)
        if target in self.scene.bodies:
            return k.whole_angle(target), f[target][2]
        return k.whole_angle(target.b.body) - k.whole_angle(target.a.body), self.joint_rate(target)

    # --- accelerations
    def solution(self, applied: Applied, driven: dict) -> tuple[dict, Reactions]:
        """Accelerations, and the reactions they come with."""
        acceleration = self.accelerations(applied, driven)
        return acceleration, self.reactions(applied, acceleration)

    def accelerations(self, applied: Applied, driven: dict) -> dict:
        """Acceleration of every body: per island M a = f, solved by an unrolled LDL^T, long branches folded before.

        driven: accelerations of prescribed coordinates.
        """
        self.trace.section = "bias accelerations"
        bias = self.propagation.field(driven, {}, self.motion)
        self.trace.section = "branches"
        branches = folded(self, applied.wrench, driven)
        self.trace.section = "columns and projection"
        free = [c for c in self.plan.free if c.body in branches.inertia]
        columns = [self.propagation.field({c: 1.0}, {}) for c in free]
        load = [0.0] * len(free)
        mass_matrix: dict[tuple[int, int], object] = {}
        for body, inertia in branches.inertia.items():
            pushed = times(inertia, bias[body])
            net = [w - p for w, p in zip(branches.wrench[body], pushed, strict=True)]
            active = [(i, c[body]) for i, c in enumerate(columns) if not all(map(is_zero, c[body]))]
            for i, column in active:
                load[i] = load[i] + product(column, net)
                weighted = times(inertia, column)
                for j, other in active:
                    if j <= i:
                        mass_matrix[i, j] = mass_matrix.get((i, j), 0.0) + product(weighted, other)
        self.trace.section = "independent accelerations"
        speeds = solve_blocks(mass_matrix, load)
        result = {ground: ZERO}
        for body in branches.inertia:
            result[body] = tuple(
                bias[body][axis] + self.trace.sum(c[body][axis] * s for c, s in zip(columns, speeds, strict=True))
                for axis in range(3)
            )
        for link in reversed(branches.links):
            result[link.attachment.body] = link.acceleration(result[link.attachment.parent])
        return result

    def inertia(self, body) -> list:
        """Mass, mass, moment of inertia: what resists the three components of a body's acceleration."""
        number = self.kinematics.number
        return [number(f"{body.key}.mass")] * 2 + [number(f"{body.key}.inertia")]

    def _unbalanced(self, applied: Applied, acceleration: dict) -> dict:
        """Rest of each body's applied wrench behind an acceleration."""
        return {
            body: tuple(
                w - m * a
                for w, m, a in zip(applied.wrench.get(body, ZERO), self.inertia(body), acceleration[body], strict=True)
            )
            for body in self.scene.bodies
        }

    def coordinate_acceleration(self, coordinate, joint, acceleration: dict):
        """Second derivative of an independent coordinate from body accelerations."""
        if coordinate.what in ("x", "y", "angle"):
            return acceleration[coordinate.body][("x", "y", "angle").index(coordinate.what)]
        k, a, b = self.kinematics, joint.a.body, joint.b.body
        dx, dy = k.axis(joint, a)
        ax, ay = self._point_acceleration(a, self._slide_arms(joint)[0], acceleration)
        bx, by = self._point_acceleration(b, k.arm(joint, "b"), acceleration)
        return dx * (bx - ax) + dy * (by - ay)

    def offset_acceleration(self, joint, acceleration: dict):
        """Second derivative of a clearance joint's eccentricity."""
        k = self.kinematics
        ax, ay = self._point_acceleration(joint.a.body, k.arm(joint, "a"), acceleration)
        bx, by = self._point_acceleration(joint.b.body, k.arm(joint, "b"), acceleration)
        return bx - ax, by - ay

    def _point_acceleration(self, body, arm, acceleration: dict):
        x, y = moved(acceleration[body], arm)
        turning = self.motion[body][2]
        return x - turning * turning * arm[0], y - turning * turning * arm[1]

    # --- reactions
    def reactions(self, applied: Applied, acceleration: dict) -> Reactions:
        """Reactions of joints without clearance, and drive efforts.

        Groups are walked backwards: closing forces from virtual work, then each body's balance gives the joint to its
        parent.
        """
        open_wrench = Applied(self._unbalanced(applied, acceleration), dict(applied.across))
        forces, efforts = {}, {}
        for index in reversed(range(len(self.plan.groups))):
            group = self.plan.groups[index]
            self.trace.section = f"reactions of {group.label()}"
            if group.closures:
                work = [
                    -self.trace.sum(
                        t * w for b, twist in effect.items() for t, w in zip(twist, open_wrench.wrench[b], strict=True)
                    )
                    for _, effect in self.propagation.effects(index, group)
                ]
                multipliers = self.propagation.transposed(index, group, work)
                for j, joint in enumerate(group.closures):
                    self._apply_closure(joint, multipliers[2 * j], multipliers[2 * j + 1], open_wrench, forces)
            for attachment in reversed(group.attachments):
                self._balance(attachment, open_wrench, forces, efforts)
        self.trace.section = "reactions out of the plane"
        for body in self.scene.bodies:
            moments = inertia_across(self.kinematics, body, acceleration[body], self.motion[body][2])
            open_wrench.add_across(body, 0.0, *moments)
        across = reactions_across(self.scene, self._flat_arms, open_wrench.across)
        return Reactions(forces, {**applied.efforts, **efforts}, across)

    def _flat_arms(self, joint):
        return tuple(arm[:2] for arm in self._slide_arms(joint))

    def _apply_closure(self, joint, first, second, open_wrench: Applied, forces: dict) -> None:
        """A closing joint's forces on both its bodies, from the multipliers of its two equations."""
        k, moment = self.kinematics, 0.0
        if isinstance(joint, Prismatic):
            dx, dy = k.axis(joint, joint.a.body)
            fx, fy, moment = -(first * dy), first * dx, second
        else:
            fx, fy = first, second
        self._pair(joint, fx, fy, moment, open_wrench)
        forces[joint] = (fx, fy, moment)

    def _pair(self, joint, fx, fy, moment, open_wrench: Applied) -> None:
        """Force (at point b) and moment on body b, the opposite on body a."""
        arm_a, arm_b = self._slide_arms(joint)
        open_wrench.add_at(joint.b.body, arm_b, fx, fy)
        open_wrench.add_at(joint.a.body, arm_a, -fx, -fy)
        open_wrench.add(joint.b.body, moment=moment)
        open_wrench.add(joint.a.body, moment=-moment)

    def _balance(self, attachment, open_wrench: Applied, forces: dict, efforts: dict) -> None:
        """The parent joint takes what is left of a body's wrench; a driven coordinate's share is the drive's effort."""
        body, joint = attachment.body, attachment.joint
        x, y, moment = open_wrench.wrench[body]
        driven = next((c for c in attachment.coordinates if c.source == "drive"), None)
        if joint is None:
            if driven is not None:
                efforts[driven.drive] = -moment
            return
        sign = 1.0 if body is joint.b.body else -1.0
        arm = self._slide_arms(joint)[1 if sign > 0 else 0]
        left = moment - arm[0] * y + arm[1] * x
        fx, fy, turn = -sign * x, -sign * y, 0.0
        if isinstance(joint, Prismatic):
            turn = -sign * left
            if driven is not None:
                dx, dy = self.kinematics.axis(joint, joint.a.body)
                efforts[driven.drive] = fx * dx + fy * dy
        elif driven is not None:
            efforts[driven.drive] = -sign * left if driven.what == "relative" else -left
            turn = -sign * left if driven.what == "relative" else 0.0
        self._pair(joint, fx, fy, turn, open_wrench)
        forces[joint] = (fx, fy, turn)


def solve_blocks(matrix: dict, right: list) -> list:
    """Solve a symmetric positive system of traced scalars by LDL^T; structural zeros are never touched."""
    size = len(right)
    lower: dict[tuple[int, int], object] = {}
    scaled: dict[tuple[int, int], object] = {}
    inverse = []
    solution = list(right)
    for i in range(size):
        pivot = matrix[i, i]
        for j in range(i):
            value = matrix.get((i, j), 0.0)
            for m in range(j):
                if (i, m) in scaled and (j, m) in lower:
                    value = value - scaled[i, m] * lower[j, m]
            if not is_zero(value):
                scaled[i, j] = value
                lower[i, j] = value * inverse[j]
                pivot = pivot - value * lower[i, j]
                solution[i] = solution[i] - lower[i, j] * solution[j]
        inverse.append(1.0 / pivot)
    for i in reversed(range(size)):
        solution[i] = solution[i] * inverse[i]
        for m in range(i + 1, size):
            if (m, i) in lower:
                solution[i] = solution[i] - lower[m, i] * solution[m]
    return solution
