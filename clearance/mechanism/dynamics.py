"""Newton-Euler over traced scalars: islands projected on their independent speeds, reactions
recovered on demand.

Long branches of hinges and slides are folded link by link into the bodies that they hang on. A
link that hangs on its parent moves with a = X a_p + S q'' + b. With q'' from S^T (I a - f) = 0
the parent feels

    I_p += X^T (I - I S S^T I / D) X,   f_p += X^T (f' - I S u / D)
    D = S^T I S,   u = S^T f',   f' = f - I b

so operations grow with the number of links, and not with its cube as those of a mass matrix do.
Source: Featherstone, Int. J. Robotics Res. 2 (1983) 13, in the plane.

`Work` is all that elements apply: wrenches, energies and powers, rates of their states, contacts,
outputs. Loads out of the plane of motion are axial forces and bending moments of the joints. Each
body is balanced along z and about x and y. The loads are gravity and forces along z, offsets
of points and centres of mass in z, and products of inertia. A joint answers with an axial force and
two bending moments at its point.
"""

from dataclasses import dataclass, field, replace

from clearance.elements.body import ABSOLUTE, Body, ground
from clearance.elements.declared import blamed
from clearance.elements.joint import RELATIVE, TURN
from clearance.mechanism.kinematics import UNITS, ZERO, Propagation, Rates
from clearance.mechanism.loops import of_solution
from clearance.mechanism.motion import Motion
from clearance.mechanism.topology import Attachment, Plan
from clearance.scene.scene import Scene
from clearance.tracing.trace import Trace, Value, is_zero


def product(a, b):
    """Sum of products of two twists or wrenches, structural zeros left out."""
    total = 0.0
    for x, y in zip(a, b, strict=True):
        total += x * y
    return total


def added(a, b) -> tuple:
    """Sum of two twists or wrenches."""
    return tuple(x + y for x, y in zip(a, b, strict=True))


@dataclass
class Work:
    """Adds up the effects of `Element.act`; k: kinematics, rates: along the real motion.

    wrench: (x, y, moment) on bodies about their centres of mass; across: what acts out of the
        plane, (force z, moment x, moment y). kinetic, potential [J]; input_power [W] of drives and
        loads; losses [W] by element.
    """

    k: object
    wrench: dict = field(default_factory=dict)
    across: dict = field(default_factory=dict)
    kinetic: Value = 0.0
    potential: Value = 0.0
    input_power: Value = 0.0
    losses: dict = field(default_factory=dict)
    efforts: dict = field(default_factory=dict)  # of drives that push
    # (element, state) -> rate of a state of first order, a sum
    rates: dict = field(default_factory=dict)
    commits: dict = field(default_factory=dict)  # element -> call that stores this state
    # (element, name) -> (unit, description, rate) of an integral
    sums: dict = field(default_factory=dict)
    # element -> {name: value} that a run follows step by step
    followed: dict = field(default_factory=dict)
    spots: dict = field(default_factory=dict)  # element -> [(penetration, its rate)]
    shown: dict = field(default_factory=dict)  # element -> [(name, unit, description, value)]

    # --- wrenches
    def add(self, body, x=0.0, y=0.0, moment=0.0) -> None:
        """A wrench on a body about its centre of mass."""
        if body is not ground:
            self.wrench[body] = added(self.wrench.get(body, ZERO), (x, y, moment))

    def add_across(self, body, z=0.0, moment_x=0.0, moment_y=0.0) -> None:
        """Force z and moments x, y out of the plane, about a body's centre of mass."""
        if body is not ground:
            wrench = z, moment_x, moment_y
            self.across[body] = added(self.across.get(body, ZERO), wrench)

    def add_at(self, body, arm, x, y, z=0.0) -> None:
        """A force at an arm (x, y, z) from the centre of mass."""
        self.add(body, x, y, arm[0] * y - arm[1] * x)
        self.add_across(body, z, arm[1] * z - arm[2] * y, arm[2] * x - arm[0] * z)

    def at(self, element, side: str, x, y, z=0.0) -> None:
        """A force at an element's point."""
        arm = *self.k.arm(element, side), self.k.number(f"{element.key}/{side}/z")
        self.add_at(getattr(element, side).body, arm, x, y, z)

    def pair(self, joint, x, y, moment=0.0) -> None:
        """A force at a joint's point b and a moment on body b, the opposite at the same place on
        body a.
        """
        arm_a, arm_b = self.k.arms(joint)
        for body, arm, sign in ((joint.b.body, arm_b, 1.0), (joint.a.body, arm_a, -1.0)):
            self.add_at(body, arm, sign * x, sign * y)
            self.add(body, moment=sign * moment)

    def on(self, target, effort) -> None:
        """An effort on the free coordinate of a joint, or a torque on a body."""
        if isinstance(target, Body):
            self.add(target, moment=effort)
        elif target.slides:
            dx, dy = self.k.axis(target, target.a.body)
            self.pair(target, effort * dx, effort * dy)
        else:
            self.add(target.b.body, moment=effort)
            self.add(target.a.body, moment=-effort)

    # --- energy
    def lose(self, element, power) -> None:
        """Power that an element takes out; one that cannot take any out is no part of the
        ledger.
        """
        if not is_zero(power):
            self.losses[element] = self.losses.get(element, 0.0) + power

    def store(self, energy) -> None:
        """Potential energy."""
        self.potential += energy

    def feed(self, power) -> None:
        """Power that a load puts in."""
        self.input_power += power

    def drive(self, element, effort, rate) -> None:
        """Effort of a drive that pushes, and the rate of its coordinate."""
        self.efforts[element] = effort
        self.feed(effort * rate)

    # --- states, contacts, outputs
    def rate(self, element, state: str, value) -> None:
        """Rate of a state of first order: the sum of what elements give to it."""
        self.rates[element, state] = self.rates.get((element, state), 0.0) + value

    def keep(self, element, value) -> None:
        """Calls a law with a memory to store the state of an accepted step."""
        self.commits[element] = value

    def sum(self, element, name: str, unit: str, text: str, rate) -> None:
        """An output that is the integral of a rate since the start, as exact as the motion."""
        self.sums[element, name] = unit, text, rate

    def follow(self, element, values: dict) -> None:
        """Numbers of an element that a run hands on at the start, middle and end of each step that
        touches.
        """
        self.followed[element] = values

    def spot(self, element, penetration, rate) -> None:
        """A place where the element may touch: the next of its `spots`."""
        self.spots.setdefault(element, []).append((penetration, rate))

    def show(self, element, name: str, unit: str, text: str, value) -> None:
        """An output."""
        self.shown.setdefault(element, []).append((name, unit, text, value))


def inertia_across(k, body, acceleration, turning) -> tuple:
    """Moments x, y of a body's inertia [N m]: minus the rate of its angular momentum (-P_xz w,
    -P_yz w).
    """
    px, py = k.poses[body].turned(*(k.number(f"{body.key}/products/{n}") for n in ("xz", "yz")))
    alpha, square = acceleration[2], turning * turning
    return alpha * px - square * py, alpha * py + square * px


def reactions_across(scene, arms, loads: dict) -> dict:
    """Axial force and bending moments (z, x, y) on body b about the joint's point, of every joint
    that carries them.

    loads: body -> (force z, moment x, moment y) about its centre of mass. arms(joint): arms (x, y)
        of bodies a and b to the joint's point. Empty where nothing acts out of the plane. Bodies
        are taken off from the ends: each leaves its load to its only joint.
    Raises ValueError where that leaves a loop with loads, or a body that nothing carries.
    """
    loads = {b: loads.get(b, ZERO) for b in scene.bodies}
    if not any(_acts(v) for v in loads.values()):
        return {}
    open_joints = [j for j in scene.joints if j.carries_across]
    reactions: dict = {}
    while end := _end(loads, open_joints):
        body, joint = end
        open_joints.remove(joint)
        sign, neighbour = (1.0, joint.a.body) if body is joint.b.body else (-1.0, joint.b.body)
        (ox, oy), (x, y) = arms(joint) if sign > 0 else reversed(arms(joint))
        force, mx, my = loads.pop(body)
        mx, my = mx - y * force, my + x * force  # about the joint's point
        reactions[joint] = (-sign * force, -sign * mx, -sign * my)
        if neighbour is not ground:
            old = loads[neighbour]
            loads[neighbour] = (old[0] + force, old[1] + mx + oy * force, old[2] + my - ox * force)
    for body, load in loads.items():
        if _acts(load):
            _refuse(body, [j for j in open_joints if body in j.bodies()])
    return reactions | dict.fromkeys(open_joints, ZERO)


def _acts(load: tuple) -> bool:
    return not all(map(is_zero, load))


def _end(loads: dict, joints: list):
    """A body with one joint left, and that joint."""
    for body in loads:
        mine = [j for j in joints if body in j.bodies()]
        if len(mine) == 1:
            return body, mine[0]
    return None


def _refuse(body, joints: list) -> None:
    if not joints:
        raise ValueError(
            f"body {body.name}: loads out of the plane act on it, and no joint carries them to "
            f"ground"
        )
    names = ", ".join(j.name for j in joints)
    raise ValueError(
        f"body {body.name}: loads out of the plane have no unique answer in a closed loop (joints "
        f"{names}); set "
        "self_aligning=True on the joints of the loop that leave them to the others"
    )


#: links in a row from which folding them has fewer operations than a mass matrix
LONG = 5


def times(matrix: list, twist) -> tuple:
    """A symmetric matrix times a twist."""
    return tuple(product(row, twist) for row in matrix)


@dataclass
class Link:
    """A folded body: twists by its parent's, its coordinate's twist, and what gives the
    coordinate's acceleration.
    """

    attachment: Attachment
    carried: list  # columns of X
    rest: tuple  # b
    axis: tuple | None  # S; None where a drive prescribes the coordinate
    inverse: object = 0.0  # 1 / D
    load: object = 0.0  # u
    pushed: tuple = ZERO  # I S

    def acceleration(self, parent: tuple) -> tuple:
        """The body's, from its parent's."""
        moved = tuple(product(row, parent) for row in zip(*self.carried, strict=True))
        result = added(moved, self.rest)
        if self.axis is None:
            return result
        rate = (self.load - product(self.pushed, moved)) * self.inverse
        return tuple(r + s * rate for r, s in zip(result, self.axis, strict=True))


@dataclass
class Folded:
    """Links, from the ends on; of the other bodies inertia (3, 3) and wrench, with those of the
    links on them.
    """

    inertia: dict[Body, list]
    wrench: dict[Body, tuple]
    links: list[Link] = field(default_factory=list)

    def add(self, link: Link) -> None:
        """Fold a link into its parent."""
        body, parent = link.attachment.body, link.attachment.parent
        inertia = self.inertia.pop(body)
        force = tuple(
            w - p for w, p in zip(self.wrench.pop(body), times(inertia, link.rest), strict=True)
        )
        if link.axis is not None:
            link.pushed = times(inertia, link.axis)
            link.inverse = 1.0 / product(link.axis, link.pushed)
            link.load = product(link.axis, force)
            share = [p * link.inverse for p in link.pushed]
            inertia = [
                [inertia[i][j] - share[max(i, j)] * link.pushed[min(i, j)] for j in range(3)]
                for i in range(3)
            ]
            force = tuple(f - s * link.load for f, s in zip(force, share, strict=True))
        self.links.append(link)
        if parent is ground:
            return
        columns = [times(inertia, c) for c in link.carried]
        self.inertia[parent] = [
            [
                old + product(link.carried[min(i, j)], columns[max(i, j)])
                for j, old in enumerate(row)
            ]
            for i, row in enumerate(self.inertia[parent])
        ]
        on_parent = (product(c, force) for c in link.carried)
        self.wrench[parent] = added(self.wrench[parent], on_parent)


def long_branches(plan: Plan) -> list[Attachment]:
    """Attachments that nothing but others of the same kind hangs on, from the ends on; none where
    they are few.
    """
    needed: set[Body] = set()
    hanging = []
    for group in reversed(plan.groups):
        (first, *others) = group.attachments
        if (
            others
            or group.closures
            or first.joint is None
            or len(first.coordinates) != 1
            or first.body in needed
        ):
            needed |= {a.parent for a in group.attachments} | {
                b for j in group.closures for b in j.bodies()
            }
        else:
            hanging.append(first)
    depth: dict[Body, int] = {}
    for branch in reversed(hanging):
        depth[branch.body] = depth.get(branch.parent, 0) + (branch.coordinates[0].source == "free")
    return hanging if max(depth.values(), default=0) >= LONG else []


def folded(dynamics, wrench: dict, driven: dict) -> Folded:
    """All bodies of a scene, its long branches folded. driven: accelerations of prescribed
    coordinates.
    """
    k, bodies = dynamics.kinematics, dynamics.scene.bodies
    result = Folded(
        {b: _diagonal(dynamics.inertia(b)) for b in bodies},
        {b: wrench.get(b, ZERO) for b in bodies},
    )
    for branch in long_branches(dynamics.plan):
        columns = [Rates(k, {branch.parent: unit}).carried(branch) for unit in UNITS]
        rest = Rates(k, {}, dynamics.velocities, driven).carried(branch)
        (coordinate,) = branch.coordinates
        free = coordinate.source == "free"
        axis = Rates(k, second={coordinate.address: 1.0}).carried(branch) if free else None
        result.add(Link(branch, columns, rest, axis))
    return result


def _diagonal(values: list) -> list:
    return [[value if i == j else 0.0 for j in range(3)] for i, value in enumerate(values)]


@dataclass
class Reactions:
    """Reactions of joints without clearance and efforts of drives, which keep the motion."""

    # joint -> force x, y and moment about the joint's b point, on body b
    forces: dict = field(default_factory=dict)
    efforts: dict = field(default_factory=dict)  # drive -> effort
    # joint -> force z, moments x and y about the joint's point, on body b
    across: dict = field(default_factory=dict)


@dataclass
class Friction:
    """Friction of the joints that have some: efforts on body b, loads behind them, rates of b
    against a.
    """

    efforts: dict = field(default_factory=dict)  # joint -> torque [N m] or force along the axis [N]
    # joint -> friction load [N m or N], where the law needs it
    loads: dict = field(default_factory=dict)
    rates: dict = field(default_factory=dict)
    bristle_rates: dict = field(default_factory=dict)  # of joints whose law has bristles
    ideal: dict = field(default_factory=dict)  # drive -> effort without any joint friction
    iterations: object = None  # of the coupled solve, where there is one
    contraction: object = None


class Dynamics:
    """Equations of motion of a scene whose poses and velocities are known."""

    def __init__(self, scene: Scene, motion: Motion, plan: Plan):
        self.scene, self.motion, self.plan = scene, motion, plan
        self.kinematics, self.trace, self.velocities = motion.k, motion.trace, motion.velocities
        self.propagation = Propagation(motion.k, plan)

    # --- applied forces
    def applied(self) -> Work:
        """Gravity and everything that elements apply."""
        work = Work(self.kinematics)
        self.trace.section = "gravity"
        for body in self.scene.bodies:
            self._gravity(body, work)
        for element in self.scene.elements:
            self.trace.section = element.label()
            with blamed(element, "act"):
                element.act(self.motion, work)
        return work

    def _gravity(self, body, work: Work) -> None:
        number = self.kinematics.number
        gx, gy, gz = (number(f"scene/gravity/{axis}") for axis in "xyz")
        mass, _, inertia = self.inertia(body)
        pose = self.kinematics.poses[body]
        x, y, w = self.velocities[body]
        work.add(body, mass * gx, mass * gy)
        work.add_across(body, mass * gz)
        work.kinetic = work.kinetic + 0.5 * mass * (x * x + y * y) + 0.5 * inertia * w * w
        work.potential -= mass * (gx * pose.x + gy * pose.y)

    def with_friction(self, work: Work, efforts: dict) -> Work:
        """Applied wrenches plus the friction efforts of joints without clearance."""
        result = replace(work, wrench=dict(work.wrench), across=dict(work.across))
        for joint, effort in efforts.items():
            result.on(joint, effort)
        return result

    # --- accelerations
    def solution(self, work: Work, driven: dict) -> tuple[dict, Reactions]:
        """Accelerations, and the reactions they come with."""
        acceleration = self.accelerations(work, driven)
        return acceleration, self.reactions(work, acceleration)

    def accelerations(self, work: Work, driven: dict) -> dict:
        """Acceleration of every body: per island M a = f, solved by an unrolled LDL^T, long
        branches folded before.

        driven: accelerations of prescribed coordinates, by their place.
        """
        self.trace.section = "bias accelerations"
        bias = self.propagation.field(driven, self.velocities)
        self.trace.section = "branches"
        branches = folded(self, work.wrench, driven)
        self.trace.section = "columns and projection"
        free = [c for c in self.plan.free if c.body in branches.inertia]
        columns = [self.propagation.field({c.address: 1.0}) for c in free]
        load = [0.0] * len(free)
        mass_matrix: dict[tuple[int, int], object] = {}
        for body, inertia in branches.inertia.items():
            pushed = times(inertia, bias[body])
            net = [w - p for w, p in zip(branches.wrench[body], pushed, strict=True)]
            active = [(i, c[body]) for i, c in enumerate(columns) if not all(map(is_zero, c[body]))]
            for i, column in active:
                load[i] += product(column, net)
                weighted = times(inertia, column)
                for j, row in active:
                    if j <= i:
                        mass_matrix[i, j] = mass_matrix.get((i, j), 0.0) + product(weighted, row)
        self.trace.section = "independent accelerations"
        speeds = solve_blocks(self.trace, mass_matrix, load)
        result = {ground: ZERO}
        for body in branches.inertia:
            moved = (product([c[body][axis] for c in columns], speeds) for axis in range(3))
            result[body] = added(bias[body], moved)
        for link in reversed(branches.links):
            result[link.attachment.body] = link.acceleration(result[link.attachment.parent])
        return result

    def inertia(self, body) -> list:
        """Mass, mass, moment of inertia: what resists the three components of a body's
        acceleration.
        """
        number = self.kinematics.number
        return [number(f"{body.key}/mass")] * 2 + [number(f"{body.key}/inertia")]

    def _unbalanced(self, work: Work, acceleration: dict) -> dict:
        """Rest of each body's applied wrench behind an acceleration."""
        return {
            body: tuple(
                w - m * a
                for w, m, a in zip(
                    work.wrench.get(body, ZERO), self.inertia(body), acceleration[body], strict=True
                )
            )
            for body in self.scene.bodies
        }

    def second_rate(self, coordinate: tuple, acceleration: dict):
        """Second rate of a coordinate by its place: of a body, or a relative one of a joint."""
        part, axis = coordinate
        if axis in ABSOLUTE:
            return acceleration[part][ABSOLUTE.index(axis)]
        rates = Rates(self.kinematics, acceleration, self.velocities)
        return rates.measured(part, rates.held(part))[axis].a

    # --- reactions
    def reactions(self, work: Work, acceleration: dict) -> Reactions:
        """Reactions of joints without clearance, and drive efforts.

        Groups are walked backwards: closing forces from virtual work, then each body's balance
        gives the joint to its parent.
        """
        rest = Work(self.kinematics, self._unbalanced(work, acceleration), dict(work.across))
        result = Reactions(efforts=dict(work.efforts))
        for index in reversed(range(len(self.plan.groups))):
            group = self.plan.groups[index]
            self.trace.section = f"reactions of {group.label()}"
            if group.closures:
                self._close(index, group, rest, result)
            for attachment in reversed(group.attachments):
                self._balance(attachment, rest, result)
        self.trace.section = "reactions out of the plane"
        for body in self.scene.bodies:
            moments = inertia_across(
                self.kinematics, body, acceleration[body], self.velocities[body][2]
            )
            rest.add_across(body, 0.0, *moments)
        result.across = reactions_across(self.scene, self._flat_arms, rest.across)
        return result

    def _flat_arms(self, joint) -> tuple:
        return tuple(arm[:2] for arm in self.kinematics.arms(joint))

    def _close(self, index: int, group, rest: Work, result: Reactions) -> None:
        """Forces of closing joints, from the work that the open loops' bodies would do."""
        effects = self.propagation.effects(index, group)
        loads = [
            -self.trace.sum(
                t * w
                for b, twist in effect.items()
                for t, w in zip(twist, rest.wrench[b], strict=True)
            )
            for _, effect in effects
        ]
        multipliers = iter(self.propagation.transposed(index, group, loads))
        for joint in group.closures:
            mine = {axis: next(multipliers) for axis in RELATIVE if axis not in joint.free}
            result.forces[joint] = self._closing_force(joint, mine, rest)

    def _closing_force(self, joint, multipliers: dict, rest: Work) -> tuple:
        """A closing joint's force on body b; both bodies take the gradient of its equations times
        the multipliers.
        """
        wrench = {}
        for body in joint.bodies():
            columns = [Rates(self.kinematics, {body: unit}).residual(joint) for unit in UNITS]
            wrench[body] = tuple(
                product([r.a for r in column], multipliers.values()) for column in columns
            )
            rest.add(body, *wrench[body])
        a, b = joint.bodies()
        fx, fy = wrench[b][:2] if b is not ground else (-v for v in wrench[a][:2])
        self._hand_across(joint, fx, fy, rest)
        return fx, fy, multipliers.get(TURN, 0.0)

    def _hand_across(self, joint, fx, fy, rest: Work) -> None:
        """Moments out of the plane of a joint's force, by the heights of its points."""
        height_a, height_b = (self.kinematics.number(f"{joint.key}/{side}/z") for side in "ab")
        rest.add_across(joint.b.body, 0.0, -(height_b * fy), height_b * fx)
        rest.add_across(joint.a.body, 0.0, height_a * fy, -(height_a * fx))

    def _balance(self, attachment, rest: Work, result: Reactions) -> None:
        """The parent joint takes what is left of a body's wrench; a driven coordinate's share is
        the drive's effort.
        """
        body, joint, parent = attachment.body, attachment.joint, attachment.parent
        load = rest.wrench[body]
        turn = None
        for c in (c for c in attachment.coordinates if c.source == "drive"):
            twist = Rates(self.kinematics, second={c.address: 1.0}).carried(attachment)
            result.efforts[c.drive] = -product(twist, load)
            turn = result.efforts[c.drive] if c.axis == TURN else None
        if joint is None:
            return
        if parent is not ground:
            carried = (Rates(self.kinematics, {parent: unit}).carried(attachment) for unit in UNITS)
            rest.add(parent, *(product(twist, load) for twist in carried))
        sign = joint.sign(body)
        fx, fy = -sign * load[0], -sign * load[1]
        if turn is None:
            turn = 0.0 if TURN in joint.free else self._moment_about_point(joint, body, load, sign)
        self._hand_across(joint, fx, fy, rest)
        result.forces[joint] = (fx, fy, turn)

    def _moment_about_point(self, joint, body, load, sign):
        """Moment on body b about the joint's point b that balances a body's load."""
        x, y, _ = self.kinematics.arms(joint)[1 if body is joint.b.body else 0]
        return -sign * (load[2] - x * load[1] + y * load[0])


def solve_blocks(trace: Trace, matrix: dict, right: list) -> list:
    """Solve a symmetric positive system of traced scalars by LDL^T; structural zeros are never
    touched.

    matrix: entries (i, j), j <= i. The solution is differentiated as one: A dx = db - dA x, with
        the same factors.
    """
    lower, inverse = _factors(matrix, len(right))
    solution = _backwards(lower, inverse, right)

    entries = [dict.fromkeys([(i, j), (j, i)]) for i, j in matrix]
    rule = of_solution(solution, entries, lambda change: _backwards(lower, inverse, change))
    trace.follow(solution, [*matrix.values(), *right], rule)
    return solution


def _factors(matrix: dict, size: int) -> tuple[dict, list]:
    """The lower factor of LDL^T and the inverse of D."""
    lower: dict[tuple[int, int], object] = {}
    scaled: dict[tuple[int, int], object] = {}
    inverse = []
    for i in range(size):
        pivot = matrix[i, i]
        for j in range(i):
            value = matrix.get((i, j), 0.0)
            for m in range(j):
                if (i, m) in scaled and (j, m) in lower:
                    value -= scaled[i, m] * lower[j, m]
            if not is_zero(value):
                scaled[i, j] = value
                lower[i, j] = value * inverse[j]
                pivot -= value * lower[i, j]
        inverse.append(1.0 / pivot)
    return lower, inverse


def _backwards(lower: dict, inverse: list, right: list) -> list:
    """The solution of LDL^T x = right."""
    size, solution = len(right), list(right)
    for i in range(size):
        for j in range(i):
            if (i, j) in lower:
                solution[i] -= lower[i, j] * solution[j]
    for i in reversed(range(size)):
        solution[i] *= inverse[i]
        for m in range(i + 1, size):
            if (m, i) in lower:
                solution[i] -= lower[m, i] * solution[m]
    return solution
