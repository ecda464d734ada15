"""All that elements apply to a mechanism: wrenches, energies and powers, rates of their states,
contacts, outputs.

Loads out of the plane of motion are axial forces and bending moments of the joints. Each body is
balanced along z and about x and y. The loads are gravity and forces along z, offsets
of points and centres of mass in z, and products of inertia. A joint answers with an axial force and
two bending moments at its point.
"""

from dataclasses import dataclass, field

from clearance.elements.body import Body, ground
from clearance.mechanism.rates import ZERO
from clearance.tracing.trace import Value, is_zero


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
            old = self.wrench.get(body, ZERO)
            self.wrench[body] = (old[0] + x, old[1] + y, old[2] + moment)

    def add_across(self, body, z=0.0, moment_x=0.0, moment_y=0.0) -> None:
        """Force z and moments x, y out of the plane, about a body's centre of mass."""
        if body is not ground:
            old = self.across.get(body, ZERO)
            self.across[body] = (old[0] + z, old[1] + moment_x, old[2] + moment_y)

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
        self.potential = self.potential + energy

    def feed(self, power) -> None:
        """Power that a load puts in."""
        self.input_power = self.input_power + power

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
        (ax, ay), (bx, by) = arms(joint)
        (x, y), (ox, oy) = ((bx, by), (ax, ay)) if sign > 0 else ((ax, ay), (bx, by))
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
