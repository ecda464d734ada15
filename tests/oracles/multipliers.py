"""Inverse dynamics by Lagrange multipliers: all bodies at once, in absolute planar coordinates, all
samples together.

With the motion and the notation of pairs.py, the balance of all bodies is

    J^T lambda = M q'' - F - G^T s

Here lambda are the forces of joints and the efforts of drives, F all other loads, and s the
friction efforts. G holds the gradients of the coordinates they act on. One solve gives lambda
without friction and for unit efforts, so all reactions are known as R_0 + R s. The friction load of
a joint is a norm of its reaction, and s = law(rate, load(R_0 + R s)) is
left: explicit where only driven joints rub, a contraction elsewhere. The traced mechanics has no
part in any of this.

A force f_x + i f_y at the arm r and the height h has the moment Im(conj(r) f). With a part f_z out
of the plane it has the moments m_x + i m_y = i (h f - f_z r).
"""

from collections.abc import Callable

import numpy as np

from clearance.elements import Force, SpringDamper, Torque, TorsionSpring
from clearance.elements.body import ground
from clearance.elements.joint import FrictionJoint
from clearance.laws.law import BoundLaw
from clearance.mechanism.assembly import assemble
from clearance.scene.scene import Scene
from clearance.tracing.interpreter import traced
from clearance.tracing.kernels import evaluated
from tests.oracles.pairs import Geometry, Pairs, amount, from_centre, solve

#: samples solved at once: more only take memory
BLOCK = 2048
#: change of the friction loads over the largest: at convergence, and the accepted one where it
#: falls no further
FOUND, ROUNDING = 1e-13, 1e-9
#: contraction of the friction's fixed point above which Newton's method takes over, and evaluations
#: before it is judged
SLOW, PATIENCE = 0.5, 2
LIMIT = 100
#: after that: least share of the friction added at a time, and Newton steps for it. Then the change
#: of the last step and the largest change with it, over the efforts.
SHORTEST, CORRECTIONS, CLOSED, FURTHEST = 1e-4, 6, 1e-12, 0.3


class SingularPosition(ValueError):
    """A motion that cannot be followed on: no position, or no unique forces in it.

    time: of the first sample that has no answer [s]; done: what `inverse` returns, of the samples
        before it.
    """

    def __init__(self, time: float, reason: str, done: dict[str, np.ndarray]):
        super().__init__(f"t = {time:.6g} s: {reason}")
        self.time, self.done = time, done


def inverse(
    scene: Scene, time: np.ndarray, poses: np.ndarray | None = None
) -> dict[str, np.ndarray]:
    """Motion, reactions, friction and driving efforts of a scene whose drives prescribe all of its
    motion.

    time: increasing (samples,) [s]. poses: guesses of (x, y, angle) of the centres of mass
        (samples, bodies, 3) [m, rad], angles on their right turns. Without them the motion is
        followed from the assembled start at t = 0. Returns arrays over time by the paths of result
        files; where joints rub also friction/iterations (evaluations of the laws) and
        friction/contraction.
    Raises ValueError for a scene that is not fully prescribed, SingularPosition where its motion
    ends.
    """
    time = _checked_time(time, followed=poses is None)
    _check(scene)
    pairs, friction = Pairs(scene, assemble(scene)), _Friction(scene)
    if poses is None:
        q, fault = pairs.followed(time)
    else:
        q, fault = pairs.polished(time, _checked_poses(poses, (time.size, len(scene.bodies), 3)))
    blocks = []
    for first in range(0, len(q), BLOCK):
        block = slice(first, min(first + BLOCK, len(q)))
        channels, found_fault = _solved(pairs, friction, time[block], q[block])
        blocks.append(channels)
        if found_fault:
            fault = found_fault
            break
    paths = blocks[0] if blocks else {}
    outputs = {path: np.concatenate([b[path] for b in blocks if path in b]) for path in paths}
    if fault:
        raise SingularPosition(time[len(next(iter(outputs.values()), ()))], fault, outputs)
    return outputs


# --- arguments
def _check(scene: Scene) -> None:
    """Joints without clearance, drives that prescribe, and as many equations as coordinates."""
    if scene.soft_joints:
        raise ValueError(
            f"{scene.soft_joints[0].label()}: inverse dynamics takes no joint with clearance"
        )
    drives = scene.drives
    for drive in (d for d in drives if not d.prescribes):
        raise ValueError(
            f"{drive.label()}: gives a torque or force; inverse dynamics takes a speed or a motion"
        )
    free = 3 * len(scene.bodies) - 2 * len(scene.joints)
    if free != len(drives):
        names = ", ".join(d.name for d in drives) or "none"
        wrong = (
            f"{abs(free - len(drives))} motion(s) {'missing' if free > len(drives) else 'too many'}"
        )
        raise ValueError(
            f"{wrong}: the joints leave {free} free movement(s), prescribed are {len(drives)} "
            f"({names})"
        )


def _checked_time(time, followed: bool) -> np.ndarray:
    time = np.asarray(time, dtype=float)
    if (
        time.ndim != 1
        or not time.size
        or not np.isfinite(time).all()
        or (np.diff(time) <= 0.0).any()
    ):
        raise ValueError(f"time must be increasing finite numbers [s], got {time!r}")
    if followed and time[0] < 0.0:
        raise ValueError(
            f"time must not be negative without poses: the motion starts at 0, got {time[0]!r} s"
        )
    return time


def _checked_poses(poses, shape: tuple[int, int, int]) -> np.ndarray:
    poses = np.asarray(poses, dtype=float)
    if poses.shape != shape or not np.isfinite(poses).all():
        raise ValueError(
            f"poses must be finite, of shape {shape} (samples, bodies, 3), got shape {poses.shape}"
        )
    return poses


# --- loads
class _Wrenches:
    """Forces and moments about the centres of mass, of all bodies and ground (samples, bodies + 1)
    each.
    """

    def __init__(self, shape: tuple[int, int]):
        self.force, self.moment = np.zeros(shape, dtype=complex), np.zeros(shape)
        self.axial, self.bending = np.zeros(shape), np.zeros(shape, dtype=complex)

    def add(self, body: int, arm, height: float, force, axial=0.0) -> None:
        """A force at an arm and a height, with its part out of the plane; (samples,) each."""
        self.force[:, body] += force
        self.moment[:, body] += (np.conj(arm) * force).imag
        self.axial[:, body] += axial
        self.bending[:, body] += 1j * (height * force - axial * arm)


def _unbalanced(pairs: Pairs, geometry: Geometry, time, v, a) -> _Wrenches:
    """Gravity, forces and springs, less inertia; joints and drives must balance it."""
    scene, wrenches = pairs.scene, _Wrenches(geometry.angle.shape)
    bodies, (x, y, z) = slice(0, len(scene.bodies)), (*scene.gravity, 0.0)[:3]
    mass, inertia = np.array([(b.mass, b.inertia) for b in scene.bodies]).T
    wrenches.force[:, bodies] = mass * (complex(x, y) - a[..., 0] - 1j * a[..., 1])
    wrenches.moment[:, bodies] = -inertia * a[..., 2]
    wrenches.axial[:, bodies] = mass * z
    products = geometry.turned[:, bodies] * np.array([complex(*b.products) for b in scene.bodies])
    wrenches.bending[:, bodies] = (a[..., 2] + 1j * v[..., 2] ** 2) * products
    v = np.concatenate([v, np.zeros((time.size, 1, 3))], axis=1)
    for load in scene.loads:
        if isinstance(load, Force):
            (local, height), body = from_centre(load.point), pairs.index[load.point.body]
            x, y, z = (amount(value, time) for value in (load.x, load.y, load.z))
            wrenches.add(body, geometry.turned[:, body] * local, height, x + 1j * y, z)
        elif isinstance(load, Torque):
            wrenches.moment[:, pairs.index[load.body]] += amount(load.torque, time)
        elif isinstance(load, SpringDamper):
            _add_spring(pairs, geometry, load, v, wrenches)
        elif isinstance(load, TorsionSpring):
            one, two = pairs.index[load.a], pairs.index[load.b]
            twist = geometry.angle[:, two] - geometry.angle[:, one] - load.free_angle
            moment = load.stiffness * twist + load.damping * (v[:, two, 2] - v[:, one, 2])
            wrenches.moment[:, one] += moment
            wrenches.moment[:, two] -= moment
    return wrenches


def _add_spring(
    pairs: Pairs, geometry: Geometry, load: SpringDamper, v: np.ndarray, wrenches: _Wrenches
) -> None:
    """Tension along the line of two points; none where they coincide, as it has no direction
    there.
    """
    bodies = [pairs.index[p.body] for p in (load.a, load.b)]
    local, heights = zip(*(from_centre(p) for p in (load.a, load.b)), strict=True)
    arms = [geometry.turned[:, body] * r for body, r in zip(bodies, local, strict=True)]
    places = [geometry.centre[:, body] + arm for body, arm in zip(bodies, arms, strict=True)]
    speeds = [
        v[:, i, 0] + 1j * (v[:, i, 1] + v[:, i, 2] * arm)
        for i, arm in zip(bodies, arms, strict=True)
    ]
    apart = places[1] - places[0]
    length = np.abs(apart)
    direction = np.divide(apart, length, out=np.zeros_like(apart), where=length > 0.0)
    rate = (direction.conj() * (speeds[1] - speeds[0])).real
    tension = (load.stiffness * (length - load.free_length) + load.damping * rate) * direction
    wrenches.add(bodies[0], arms[0], heights[0], tension)
    wrenches.add(bodies[1], arms[1], heights[1], -tension)


# --- reactions
class _Reactions:
    """Loads from a on b: without joint friction, then for a unit effort of each rubbing joint
    (columns k).

    relative (samples, 3 pairs, k): forces along and across and moment; force (samples, pairs, k):
    x + i y; efforts (samples, drives, k). Out of the plane, about the joints' points: axial,
    bending x + i y (samples, joints, k), zero where spatial is False as nothing acts there.
    """

    def __init__(self, pairs: Pairs, geometry: Geometry, rest: _Wrenches, rubbing: list[int]):
        samples, bodies, joints = (
            len(geometry.angle),
            len(pairs.scene.bodies),
            len(pairs.scene.joints),
        )
        planar = np.stack([rest.force.real, rest.force.imag, rest.moment], axis=-1)[
            :, :bodies
        ].reshape(samples, -1, 1)
        unit = geometry.rows[:, pairs.free[rubbing]].swapaxes(1, 2)
        multipliers = solve(
            geometry.rows[:, pairs.held].swapaxes(1, 2), -np.concatenate([planar, unit], axis=2)
        )
        self.relative = np.zeros((samples, 3 * pairs.a.size, 1 + len(rubbing)))
        self.relative[:, pairs.held] = multipliers
        self.relative[:, pairs.free[rubbing], range(1, 1 + len(rubbing))] += 1.0
        self.efforts = multipliers[:, 2 * joints :]
        self.force = (self.relative[:, 0::3] + 1j * self.relative[:, 1::3]) * geometry.axis[
            ..., None
        ]
        self.spatial = _leaves_the_plane(pairs.scene)
        self.axial, self.bending = (
            np.zeros((samples, joints, 1 + len(rubbing))),
            np.zeros_like(self.force[:, :joints]),
        )
        if self.spatial:
            self.axial[..., 0], self.bending = _across(
                pairs, geometry, rest, self.force[:, :joints]
            )


def _leaves_the_plane(scene: Scene) -> bool:
    """True where anything can make an axial force or a bending moment."""
    forces = [load for load in scene.loads if isinstance(load, Force)]
    springs = [load for load in scene.loads if isinstance(load, SpringDamper)]
    points = [p for part in (*scene.joints, *springs) for p in (part.a, part.b)] + [
        f.point for f in forces
    ]
    return (
        (*scene.gravity, 0.0)[2] != 0.0
        or any(f.z != 0.0 for f in forces)
        or any(p != 0.0 for b in scene.bodies for p in b.products)
        or any(from_centre(p)[1] != 0.0 for p in points if p.body is not ground)
    )


def _across(
    pairs: Pairs, geometry: Geometry, rest: _Wrenches, force: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Axial forces (samples, joints) and bending moments (samples, joints, k): the bodies' balance
    out of the plane.

    Joint forces in the plane make bending moments through their heights, friction too; axial forces
    are without it. Raises ValueError where the joints that are not self-aligning do not hang the
    bodies on ground as a tree.
    """
    joints, bodies = pairs.scene.joints, len(pairs.scene.bodies)
    onto_a, onto_b = (
        1.0 * (np.arange(bodies)[:, None] == side[: len(joints)]) for side in (pairs.a, pairs.b)
    )
    carry = [i for i, j in enumerate(joints) if not j.self_aligning]
    incidence = (onto_b - onto_a)[:, carry]
    if len(carry) != bodies or np.linalg.matrix_rank(incidence) < bodies:
        raise ValueError(
            f"loads out of the plane: joints {', '.join(joints[i].name for i in carry) or 'none'} "
            f"must hang "
            f"{bodies} bodies on ground as a tree, or what each carries is not unique; set "
            f"self_aligning=True on the "
            "joints of a loop that take no part"
        )
    inverse = np.zeros((len(joints), bodies))
    inverse[carry] = np.rint(np.linalg.inv(incidence))  # of a tree: 0, 1 and -1
    axial = -rest.axial[:, :bodies] @ inverse.T
    lever_a, lever_b = (
        axial * geometry.reach[:, : len(joints)],
        axial * geometry.arm_b[:, : len(joints)],
    )
    heights = onto_b * pairs.height_b[: len(joints)] - onto_a * pairs.height_a[: len(joints)]
    moments = 1j * (heights @ force)
    moments[..., 0] += rest.bending[:, :bodies] - 1j * (lever_b @ onto_b.T - lever_a @ onto_a.T)
    return axial, -(inverse @ moments)


# --- joint friction
class _Friction:
    """Joints with friction: their laws, and the loads that their reactions come to.

    Five parts of a reaction rub: two pairs that act by their length, and a single one. Of a hinge
    the radial force, the bending moments and the axial force. Of a slide the force across (in the
    plane and out of it), the moments about the axes across it and the moment about its own axis.
    The load is the sum of weights (joints, 3) times these lengths.
    """

    def __init__(self, scene: Scene):
        self.places = [i for i, j in enumerate(scene.joints) if j.friction is not None]
        self.joints = [scene.joints[i] for i in self.places]
        self.laws = [_plain(j.friction) for j in self.joints]
        self.slopes = [_slope(j.friction) for j in self.joints]
        self.weights = np.array([_weights(j) for j in self.joints]).reshape(-1, 3)
        #: makes a force of a load, to compare those of hinges and slides
        self.arms = np.where(self.weights[:, 0] > 0.0, self.weights[:, 0], 1.0)

    def parts(self, geometry: Geometry, reactions: _Reactions) -> np.ndarray:
        """Loads that rub, without friction and for unit friction efforts (samples, rubbing joints,
        5, k).

        Raises ValueError for a joint that carries loads out of the plane with no arm for them.
        """
        shares = np.empty((len(geometry.angle), len(self.joints), 5, 1 + len(self.joints)))
        for j, (p, joint) in enumerate(zip(self.places, self.joints, strict=True)):
            along, across, moment = reactions.relative[:, 3 * p : 3 * p + 3].swapaxes(0, 1)
            axial, bending = (
                reactions.axial[:, p],
                geometry.axis[:, p, None].conj() * reactions.bending[:, p],
            )
            if joint.slides:
                shares[:, j] = np.stack([across, axial, moment, bending.imag, bending.real], axis=1)
                needed = {"friction_arm": bending.real}
            else:
                shares[:, j] = np.stack([along, across, bending.real, bending.imag, axial], axis=1)
                needed = {"friction_arm": axial, "bending_arm": bending}
            for arm, carried in needed.items():
                if joint.rubs_by_load and getattr(joint, arm) is None and carried.any():
                    raise ValueError(
                        f"{joint.label()}: carries loads out of the plane, so friction "
                        f"{joint.friction.law.name} needs "
                        f"{arm} [m] (or self_aligning=True)"
                    )
        return shares

    def loads(self, parts: np.ndarray, efforts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Friction loads (samples, joints), and their gradients by the parts (samples, joints, 5),
        at these efforts.
        """
        acting = parts[..., 0] + (parts[..., 1:] @ efforts[:, None, :, None])[..., 0]
        pairs = np.hypot(acting[..., [0, 2]], acting[..., [1, 3]])
        lengths = np.concatenate([pairs, np.abs(acting[..., 4:])], axis=-1)
        each, weights = lengths[..., [0, 0, 1, 1, 2]], self.weights[:, [0, 0, 1, 1, 2]]
        gradient = weights * np.divide(acting, each, out=np.zeros_like(acting), where=each > 0.0)
        return (lengths * self.weights).sum(axis=-1), gradient

    def newton(self, parts, rates, efforts: np.ndarray, share: float) -> np.ndarray:
        """Newton's step of the efforts towards a share of those of the law: (1 - share law' load'
        R) step = error.
        """
        loads, gradient = self.loads(parts, efforts)
        error = share * _values(self.laws, rates, loads) - efforts
        slopes = _values(self.slopes, rates, loads)[..., None]
        response = np.einsum("sjc,sjck->sjk", gradient, parts[..., 1:])
        return solve(np.eye(len(self.laws)) - share * slopes * response, error[..., None])[..., 0]

    def followed(self, parts: np.ndarray, rates: np.ndarray) -> tuple[np.ndarray | None, int]:
        """Efforts of one sample, from no friction to all of it, and Newton steps; None where
        the way ends.

        Strong friction can have several solutions: this is the one that grows out of none.
        """
        efforts, reached, stride, count = np.zeros(rates.shape), 0.0, 0.0625, 0
        while stride > SHORTEST:
            share, trial = min(reached + stride, 1.0), efforts
            for _ in range(CORRECTIONS):
                step = self.newton(parts, rates, trial, share)
                trial, count = trial + step, count + 1
                closed = np.abs(step / self.arms).sum() <= CLOSED * np.abs(trial / self.arms).sum()
                if closed or not np.isfinite(trial).all():
                    break
            far = (
                reached > 0.0
                and np.abs((trial - efforts) / self.arms).sum()
                > FURTHEST * np.abs(trial / self.arms).sum()
            )
            if not closed or far:
                stride *= 0.5
                continue
            efforts, reached, stride = trial, share, 2.0 * stride
            if share >= 1.0:
                return efforts, count
        return None, count

    def balanced(self, parts: np.ndarray, rates: np.ndarray):
        """Efforts s with s = law(rate, load(s)), all joints and samples together, from no friction
        on.

        Returns efforts and loads (samples, joints), evaluations of the laws and contraction of the
        fixed point (samples,). The last part marks samples without a balance.
        """
        efforts, samples = np.zeros(rates.shape), len(rates)
        loads = self.loads(parts, efforts)[0]
        change = (loads / self.arms).max(axis=1)
        iterations, contraction, active = np.zeros(samples), np.zeros(samples), np.arange(samples)
        jammed = []
        for count in range(1, LIMIT + 1):
            slow = (contraction[active] > SLOW) & (count > PATIENCE)
            for i in active[slow]:
                friction, steps = self.followed(parts[i : i + 1], rates[i : i + 1])
                iterations[i] = count + steps
                if friction is None:
                    jammed.append(i)
                    continue
                efforts[i], loads[i] = friction[0], self.loads(parts[i : i + 1], friction)[0][0]
            active = active[~slow]
            if not active.size:
                break
            efforts[active] = _values(self.laws, rates[active], loads[active])
            fresh = self.loads(parts[active], efforts[active])[0]
            old, new = change[active], (np.abs(fresh - loads[active]) / self.arms).max(axis=1)
            contraction[active] = np.divide(new, old, out=np.zeros_like(new), where=old > 0.0)
            loads[active], change[active], iterations[active] = fresh, new, count
            largest = (fresh / self.arms).max(axis=1)
            active = active[(new > FOUND * largest) & ((new < old) | (new > ROUNDING * largest))]
            if not active.size:
                break
        return (
            efforts,
            loads,
            iterations,
            contraction,
            np.sort(np.array([*active, *jammed], dtype=int)),
        )


def _weights(joint: FrictionJoint) -> tuple[float, float, float]:
    """Of the lengths of what rubs, as in pin_load and slide_load; none where the law needs no
    load.
    """
    if not joint.rubs_by_load:
        return 0.0, 0.0, 0.0
    g = joint.geometry
    if joint.slides:
        return 1.0, 2.0 * g["overlap_inverse"], g["friction_arm_inverse"]
    return g["pin_radius"], g["bending_ratio"], g["friction_arm"]


def _plain(law: BoundLaw) -> Callable[[float, float], float]:
    """A law without the checks of its arguments, which take longer than most laws."""
    return lambda rate, load: law.law.function(rate, load, *law.numbers)


def _slope(law: BoundLaw) -> Callable[[float, float], float]:
    """Derivative of a law by its load, exact."""
    function = evaluated(traced(law.law.function).slopes((1,)))
    return lambda rate, load: function(rate, load, *law.numbers)[1]


def _values(functions: list[Callable], rates: np.ndarray, loads: np.ndarray) -> np.ndarray:
    """Functions of rate and load, one a column."""
    columns = zip(functions, rates.T.tolist(), loads.T.tolist(), strict=True)
    return np.array(
        [list(map(function, rate, load)) for function, rate, load in columns], dtype=float
    ).T


# --- results
def _solved(
    pairs: Pairs, friction: _Friction, time: np.ndarray, q: np.ndarray
) -> tuple[dict[str, np.ndarray], str]:
    """All channels up to the first sample without a unique answer, and its reason ("" where
    all have one).
    """
    geometry = Geometry(pairs, q)
    count, fault = pairs.regular(geometry)
    if count == 0:
        return {}, fault
    time, q = time[:count], q[:count]
    geometry = geometry if count == len(geometry.angle) else Geometry(pairs, q)
    v, a = pairs.motion(geometry, time)
    reactions = _Reactions(
        pairs, geometry, _unbalanced(pairs, geometry, time, v, a), friction.places
    )
    rates = (geometry.rows @ v.reshape(time.size, -1, 1))[..., 0]
    efforts, rubbed = np.zeros((time.size, 0)), {}
    if friction.joints:
        rubbing_rates = rates[:, pairs.free[friction.places]]
        efforts, loads, *course, jammed = friction.balanced(
            friction.parts(geometry, reactions), rubbing_rates
        )
        rubbed = _friction_channels(friction, rubbing_rates, efforts, loads)
        rubbed |= dict(zip(("friction/iterations", "friction/contraction"), course, strict=True))
        if jammed.size:
            count = jammed[0]
            worst = friction.joints[int(np.abs(efforts[count]).argmax())].label()
            fault = (
                "joint friction finds no balance with the reactions it makes (most of it in "
                f"{worst})"
            )
    channels = _body_channels(pairs.scene, q, v, a) | _joint_channels(
        pairs.scene, reactions, efforts
    )
    channels |= _drive_channels(pairs, reactions, efforts, rates) | rubbed
    return {path: values[:count] for path, values in channels.items()}, fault


def _total(columns: np.ndarray, efforts: np.ndarray) -> np.ndarray:
    """With the friction that acts: from (samples, n, k) to (samples, n)."""
    return columns[..., 0] + (columns[..., 1:] @ efforts[..., None])[..., 0]


def _body_channels(
    scene: Scene, q: np.ndarray, v: np.ndarray, a: np.ndarray
) -> dict[str, np.ndarray]:
    names, columns = (
        ("x", "y", "theta", "vx", "vy", "omega", "ax", "ay", "alpha"),
        np.concatenate([q, v, a], axis=2),
    )
    return {
        f"bodies/{b.name}/{n}": columns[:, i, c]
        for i, b in enumerate(scene.bodies)
        for c, n in enumerate(names)
    }


def _joint_channels(
    scene: Scene, reactions: _Reactions, efforts: np.ndarray
) -> dict[str, np.ndarray]:
    channels = {}
    force, relative, bending = (
        _total(r, efforts) for r in (reactions.force, reactions.relative, reactions.bending)
    )
    for p, joint in enumerate(scene.joints):
        here = f"joints/{joint.name}"
        channels |= {f"{here}/force_x": force[:, p].real, f"{here}/force_y": force[:, p].imag}
        if joint.slides:
            channels[f"{here}/moment"] = relative[:, 3 * p + 2]
        if reactions.spatial:
            channels[f"{here}/axial_force"] = reactions.axial[:, p, 0]
            channels |= {
                f"{here}/bending_x": bending[:, p].real,
                f"{here}/bending_y": bending[:, p].imag,
            }
    return channels


def _drive_channels(pairs: Pairs, reactions: _Reactions, efforts: np.ndarray, rates: np.ndarray):
    channels, total = {}, _total(reactions.efforts, efforts)
    for d, drive in enumerate(pairs.drives):
        path = f"drives/{drive.name}/{drive.effort_kind}"
        channels[path] = total[:, d]
        if efforts.shape[1]:
            channels[f"{path}_ideal"] = reactions.efforts[:, d, 0]
        channels[f"drives/{drive.name}/power"] = total[:, d] * rates[:, pairs.driven[d]]
    return channels


def _friction_channels(friction: _Friction, rates, efforts, loads) -> dict[str, np.ndarray]:
    channels = {}
    for j, joint in enumerate(friction.joints):
        channels[f"joints/{joint.name}/friction"] = efforts[:, j]
        if joint.friction.law.needs_load:
            channels[f"joints/{joint.name}/friction_load"] = loads[:, j]
        channels[f"joints/{joint.name}/power_loss"] = -efforts[:, j] * rates[:, j]
    return channels
