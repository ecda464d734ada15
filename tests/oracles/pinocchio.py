"""The same scene in Pinocchio: recursive Newton-Euler on a spanning tree, multipliers for the
hinges cut out of loops.

Pinocchio has no joint that rubs, so friction is left out here. The motion is given (a record of
inverse dynamics has it). The efforts of the drives and all components of all reactions follow from
it. Pinocchio is three-
dimensional: axial forces and bending moments are its own, not a planar theory's.
"""

import numpy as np

from clearance.elements import Drive, Force, SpringDamper, Torque, TorsionSpring
from clearance.elements.body import Body, Point, ground
from clearance.results.record import Record
from clearance.scene.scene import Scene
from tests.oracles.pairs import amount, from_centre

STATE = ("x", "y", "theta", "vx", "vy", "omega", "ax", "ay", "alpha")


def states(scene: Scene, record: Record) -> np.ndarray:
    """Position, velocity and acceleration of the centres of mass along a record (samples, bodies
    and ground, 9).
    """
    columns = [[record.values(f"bodies/{b.name}/{n}") for n in STATE] for b in scene.bodies]
    return np.array([*columns, np.zeros((len(STATE), record.time.size))]).transpose(2, 0, 1)


def applied(scene: Scene, record: Record) -> np.ndarray:
    """Wrenches of loads but gravity and drives on the bodies along a record (samples, bodies, 6)
    [N, N m].

    Force x, y, z and moment x, y, z about the centre of mass, along the fixed axes.
    """
    state, index = states(scene, record), {b: i for i, b in enumerate((*scene.bodies, ground))}
    wrenches = np.zeros((*state.shape[:2], 6))

    def arm(point: Point) -> np.ndarray:
        local, height = from_centre(point)
        turned = local * np.exp(1j * state[:, index[point.body], 2])
        return np.stack([turned.real, turned.imag, np.full(len(state), height)], axis=-1)

    def push(point: Point, force: np.ndarray) -> None:
        wrenches[:, index[point.body], :3] += force
        wrenches[:, index[point.body], 3:] += np.cross(arm(point), force)

    def turn(body: Body, moment) -> None:
        wrenches[:, index[body], 5] += moment

    for load in scene.loads:
        if isinstance(load, Force):
            push(
                load.point,
                np.stack([amount(v, record.time) for v in (load.x, load.y, load.z)], axis=-1),
            )
        elif isinstance(load, Torque):
            turn(load.body, amount(load.torque, record.time))
        elif isinstance(load, SpringDamper):
            ends = [state[:, index[p.body], :2] + arm(p)[:, :2] for p in (load.a, load.b)]
            apart = np.pad(ends[1] - ends[0], [(0, 0), (0, 1)])
            length = np.linalg.norm(apart, axis=1)
            pull = record.values(f"springs/{load.name}/tension") / np.where(
                length > 0.0, length, 1.0
            )
            push(load.a, pull[:, None] * apart)
            push(load.b, -pull[:, None] * apart)
        elif isinstance(load, TorsionSpring):
            twisted = state[:, index[load.b]] - state[:, index[load.a]]
            moment = (
                load.stiffness * (twisted[:, 2] - load.free_angle) + load.damping * twisted[:, 5]
            )
            turn(load.a, moment)
            turn(load.b, -moment)
    return wrenches[:, :-1]


def spanning_tree(scene: Scene) -> tuple[list[tuple], list]:
    """(joint, parent, child) from the ground outwards, and the hinges left over, which close loops.

    Joints that carry loads out of the plane, driven joints and slides are in the tree; they never
    make a loop on their own. Raises ValueError where self-aligning joints leave no such tree.
    """
    driven = [d.target for d in scene.drives]
    islands = {body: {body} for body in (*scene.bodies, ground)}
    chosen, cuts = [], []
    for joint in sorted(
        scene.joints, key=lambda j: (j.self_aligning, j not in driven, not j.slides)
    ):
        a, b = (islands[body] for body in joint.bodies())
        if a is b:
            cuts.append(joint)
            continue
        chosen.append(joint)
        islands |= dict.fromkeys(a | b, a | b)
    if wrong := [j for j in cuts if j.slides or j in driven]:
        raise ValueError(
            f"{wrong[0].label()} is self-aligning; for Pinocchio slides and driven joints of loops "
            f"are not"
        )
    tree, placed = [], {ground}
    while chosen:
        joint = next(j for j in chosen if placed & set(j.bodies()))
        chosen.remove(joint)
        parent, child = sorted(joint.bodies(), key=lambda body: body not in placed)
        tree.append((joint, parent, child))
        placed.add(child)
    return tree, cuts


class Model:
    """A scene without clearance, whose drives prescribe all its motion, as a Pinocchio model.

    tree: (joint, parent, child) in Pinocchio's order; cuts: hinges that close loops; drives; signs
        (tree,): of a Pinocchio coordinate as our joint's (b against a). columns (tree, drives):
        efforts of drives on the coordinates.
    Raises ValueError for scenes that are no such thing.
    """

    def __init__(self, scene: Scene):
        import pinocchio

        self.pin, self.scene = pinocchio, scene
        self.drives = scene.drives
        if scene.soft_joints or not all(d.prescribes for d in self.drives):
            raise ValueError(
                f"{scene.name}: Pinocchio gets scenes without clearance, all of whose drives "
                f"prescribe"
            )
        self.tree, self.cuts = spanning_tree(scene)
        self.model = pinocchio.Model()
        self.model.gravity.linear = np.array((*scene.gravity, 0.0)[:3])
        self.ids, self.origins, self.chains = {ground: 0}, {ground: np.zeros(3)}, {ground: []}
        self.signs = np.ones(len(self.tree))
        for i, (joint, parent, child) in enumerate(self.tree):
            self._attach(i, joint, parent, child)
        if len(self.tree) != 2 * len(self.cuts) + len(self.drives):
            raise ValueError(f"{scene.name}: its drives do not prescribe all its motion")
        self.columns = np.stack([self._column(d) for d in self.drives], axis=1)
        self.ends = [
            [self._frame(p, f"{c.name} {p.body.name}") for p in (c.a, c.b)] for c in self.cuts
        ]
        self.data = self.model.createData()

    def _attach(self, i: int, joint, parent: Body, child: Body) -> None:
        """The frame of a Pinocchio joint stands at the child's own joint point, along the child's
        axes.
        """
        forward = child is joint.b.body
        at, of_joint = (_xyz(p) for p in ((joint.a, joint.b) if forward else (joint.b, joint.a)))
        turn, kind = 0.0, self.pin.JointModelRZ()
        if joint.slides:
            turn = joint.angle if forward else -joint.angle
            axis = turned([*joint.axis, 0.0], -turn) if forward else -np.array([*joint.axis, 0.0])
            kind = self.pin.JointModelPrismaticUnaligned(axis)
        elif not forward:
            self.signs[i] = -1.0
        placement = self.pin.SE3(turned(np.eye(3), turn).T, at - self.origins[parent])
        self.ids[child] = self.model.addJoint(self.ids[parent], kind, placement, joint.name)
        self.origins[child] = of_joint
        self.chains[child] = [*self.chains[parent], *([] if joint.slides else [i])]
        com = np.array((*child.com, 0.0)[:3]) - of_joint
        inertia = self.pin.Inertia(child.mass, com, _inertia(child))
        self.model.appendBodyToJoint(self.ids[child], inertia, self.pin.SE3.Identity())

    def _column(self, drive: Drive) -> np.ndarray:
        column = np.zeros(len(self.tree))
        if isinstance(drive.target, Body):
            column[self.chains[drive.target]] = 1.0
        else:
            i = next(i for i, (joint, *_) in enumerate(self.tree) if joint is drive.target)
            column[i] = self.signs[i]
        return column

    def _frame(self, point: Point, name: str) -> int:
        """Number of a frame at a point, 0 for one on the ground."""
        if point.body is ground:
            return 0
        placement = self.pin.SE3(np.eye(3), _xyz(point) - self.origins[point.body])
        frame = self.pin.Frame(name, self.ids[point.body], placement, self.pin.FrameType.OP_FRAME)
        return self.model.addFrame(frame)

    def coordinates(self, state: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Coordinates of the tree, their rates and accelerations (samples, tree), from the bodies'
        states.
        """
        index = {b: i for i, b in enumerate((*self.scene.bodies, ground))}
        values = np.empty((3, len(state), len(self.tree)))
        for i, (joint, *_) in enumerate(self.tree):
            a, b = (state[:, index[body]] for body in joint.bodies())
            if not joint.slides:
                values[:, :, i] = self.signs[i] * (b - a)[:, 2::3].T
                continue
            axis = complex(*joint.axis) * np.exp(1j * a[:, 2])
            apart, speed, change = (
                y - x for x, y in zip(_moved(a, joint.a), _moved(b, joint.b), strict=True)
            )
            slide = (axis.conj() * apart).real
            values[:, :, i] = (
                slide,
                (axis.conj() * speed).real,
                (axis.conj() * change).real + a[:, 5] ** 2 * slide,
            )
        return values[0], values[1], values[2]

    def outer(self, state: np.ndarray, wrenches: np.ndarray) -> np.ndarray:
        """Wrenches about the centres of mass (samples, bodies, 6) as Pinocchio takes them, in
        frames of the joints.
        """
        index = {b: i for i, b in enumerate(self.scene.bodies)}
        applied_ones = np.zeros((len(state), len(self.tree) + 1, 6))
        for _, _, body in self.tree:
            force, moment = (
                turned(wrenches[:, index[body], k : k + 3], -state[:, index[body], 2])
                for k in (0, 3)
            )
            arm = np.array((*body.com, 0.0)[:3]) - self.origins[body]
            applied_ones[:, self.ids[body]] = np.concatenate(
                [force, moment + np.cross(arm, force)], axis=1
            )
        return applied_ones


def inverse_in_loop(
    model: Model, q: np.ndarray, v: np.ndarray, a: np.ndarray, outer: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Efforts of drives (samples, drives) and forces x, y of the cuts on their bodies b (samples,
    cuts, 2).

    Pinocchio called from Python, sample by sample: rnea. With loops also computeJointJacobians, the
    Jacobians of the two points of each cut, and one dense solve. The solve has as many equations as
    the tree has joints.
    """
    pin, m, data, size = model.pin, model.model, model.data, 2 * len(model.cuts)
    efforts, matrix, loads = np.empty(q.shape), np.empty(q.shape[1:] * 2), _Loads(model, outer)
    matrix[:, size:], aligned = model.columns, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    for s in range(len(q)):
        tau = pin.rnea(m, data, q[s], v[s], a[s], *loads(s))
        if not size:
            efforts[s] = tau
            continue
        pin.computeJointJacobians(m, data, q[s])
        for k, ends in enumerate(model.ends):
            on_a, on_b = (
                pin.getFrameJacobian(m, data, end, aligned)[:2].T if end else 0.0 for end in ends
            )
            matrix[:, 2 * k : 2 * k + 2] = on_b - on_a
        efforts[s] = np.linalg.solve(matrix, tau)
    if not size:
        efforts = np.linalg.solve(model.columns, efforts.T).T
    return efforts[:, size:], efforts[:, :size].reshape(len(q), -1, 2)


def reactions_in_loop(
    model: Model, q: np.ndarray, v: np.ndarray, a: np.ndarray, outer: np.ndarray
) -> np.ndarray:
    """Wrenches that the parents put on the children (samples, tree, 6), in the frames of the
    joints.

    Pinocchio called from Python, sample by sample: rnea with the forces of the cuts among the outer
    ones, and data.f.
    """
    pin, m, data, loads = model.pin, model.model, model.data, _Loads(model, outer)
    reactions = np.empty((*q.shape, 6))
    for s in range(len(q)):
        pin.rnea(m, data, q[s], v[s], a[s], *loads(s))
        for i in range(q.shape[1]):
            reactions[s, i] = data.f[i + 1].vector
    return reactions


class _Loads:
    """Outer wrenches of a sample as rnea takes them; nothing where there are none."""

    def __init__(self, model: Model, outer: np.ndarray | None):
        self.pin, self.outer = model.pin, outer
        self.forces = model.pin.StdVec_Force()
        self.forces.extend([model.pin.Force.Zero() for _ in range(model.model.njoints)])
        self.loaded = [] if outer is None else np.flatnonzero(outer.any(axis=(0, 2))).tolist()

    def __call__(self, sample: int) -> tuple:
        for i in self.loaded:
            self.forces[i] = self.pin.Force(self.outer[sample, i])
        return (self.forces,) if self.loaded else ()


def inverse(scene: Scene, record: Record, model: Model | None = None) -> dict[str, np.ndarray]:
    """Efforts of drives and all reactions of joints, all without friction, by the channels of a
    record.

    record: of the same scene, whose motion is taken. Raises ValueError for scenes that `Model`
        cannot be.
    """
    model = model or Model(scene)
    state, wrenches = states(scene, record), applied(scene, record)
    q, v, a = model.coordinates(state)
    efforts, forces = inverse_in_loop(model, q, v, a, model.outer(state, wrenches))
    for k, drive in enumerate(model.drives):
        if isinstance(drive.target, Body):
            wrenches[:, scene.bodies.index(drive.target), 5] += efforts[:, k]
    outer = model.outer(state, wrenches) + of_cuts(model, state, forces)
    carried = reactions_in_loop(model, q, v, a, outer)
    channels = {}
    for drive, effort in zip(model.drives, efforts.T, strict=True):
        channels[f"drives/{drive.name}/{drive.effort_kind}"] = effort
    for i, (joint, _, child) in enumerate(model.tree):
        channels |= _channels(
            joint, child, state[:, scene.bodies.index(child), 2], q[:, i], carried[:, i]
        )
    for joint, force in zip(model.cuts, forces.swapaxes(0, 1), strict=True):
        channels |= _named(joint, np.pad(force, [(0, 0), (0, 4)]))
    return channels


def of_cuts(model: Model, state: np.ndarray, forces: np.ndarray) -> np.ndarray:
    """Outer wrenches that stand for the forces of the cut hinges (samples, cuts, 2), in frames of
    the joints.
    """
    wrenches = np.zeros((len(state), len(model.tree) + 1, 6))
    for k, joint in enumerate(model.cuts):
        for sign, point in ((-1.0, joint.a), (1.0, joint.b)):
            if point.body is not ground:
                angle = state[:, model.scene.bodies.index(point.body), 2]
                force = turned(sign * np.pad(forces[:, k], [(0, 0), (0, 1)]), -angle)
                arm = _xyz(point) - model.origins[point.body]
                wrenches[:, model.ids[point.body]] += np.concatenate(
                    [force, np.cross(arm, force)], axis=1
                )
    return wrenches


def _channels(
    joint, child: Body, angle: np.ndarray, q: np.ndarray, carried: np.ndarray
) -> dict[str, np.ndarray]:
    """A wrench in the child's frame as the joint's channels: on body b about the joint's point b,
    along fixed axes.
    """
    force, moment = (turned(carried[:, k : k + 3], angle) for k in (0, 3))
    if child is not joint.b.body:
        if joint.slides:  # the child's frame stands at point a
            moment = moment - np.cross(q[:, None] * turned([*joint.axis, 0.0], angle), force)
        force, moment = -force, -moment
    return _named(joint, np.concatenate([force, moment], axis=1))


def _named(joint, wrench: np.ndarray) -> dict[str, np.ndarray]:
    names = ["force_x", "force_y", "axial_force", "bending_x", "bending_y"]
    names += ["moment"] if joint.slides else []
    return {f"joints/{joint.name}/{name}": wrench[:, i] for i, name in enumerate(names)}


def _xyz(point: Point) -> np.ndarray:
    return np.array([point.x, point.y, point.z])


def _moved(state: np.ndarray, point: Point) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Position, velocity and acceleration x + i y of a point (samples,)."""
    x, y, angle, vx, vy, turning, ax, ay, alpha = state.T
    arm = from_centre(point)[0] * np.exp(1j * angle)
    return (
        x + 1j * y + arm,
        vx + 1j * vy + 1j * turning * arm,
        ax + 1j * ay + (1j * alpha - turning**2) * arm,
    )


def turned(vectors, angle) -> np.ndarray:
    """Vectors (..., 3) turned by an angle [rad] about z."""
    x, y, z = np.moveaxis(np.asarray(vectors), -1, 0)
    c, s = np.cos(angle), np.sin(angle)
    return np.stack(np.broadcast_arrays(c * x - s * y, s * x + c * y, z), axis=-1)


def _inertia(body: Body) -> np.ndarray:
    """Inertia about the centre of mass, in the body's axes; the part that planar motion does not
    feel is made up.

    Half of the moment of inertia goes to each axis of the plane, and enough along z to make the
    products possible.
    """
    x, y = body.products
    along = 4.0 * (x * x + y * y) / body.inertia
    across = 0.5 * body.inertia + along
    return np.array([[across, 0.0, -x], [0.0, across, -y], [-x, -y, body.inertia]])
