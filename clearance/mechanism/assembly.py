"""The start of a run: bodies put together from a rough position, every loop closed, velocities from the drives.

The coordinates that the mechanism's plan leaves free (the angle of an undriven crank or of a pendulum) start where the
scene says and the other bodies move to close the loops; only where no loop closes so do they give way as well.

Works on absolute coordinates of all bodies (numpy, once per run), independent of the compiled kinematics.
"""

import math
from dataclasses import dataclass

import numpy as np

from clearance.joints import ClearanceRevolute, Joint, Prismatic
from clearance.loads import Drive
from clearance.mechanism.interpreter import traced
from clearance.mechanism.kernels import evaluated
from clearance.mechanism.topology import closed_plan
from clearance.scene import Body, Scene, ground

CLOSURE = 1e-12  # largest closing error accepted, relative to the mechanism's size
RANK = 1e-9  # singular values below this share of the largest count as zero
ITERATIONS = 200
LARGEST_TURN = 0.5  # rad a single correction may turn a body


@dataclass(frozen=True)
class Start:
    """Assembled poses and velocities: body -> (x, y, angle) of the centre of mass; size of the mechanism [m].

    measured: clearance joints that would over-constrain the mechanism if they were closed (a third bearing of a bar, a
    second coupler of a parallelogram); their eccentricity follows from the other coordinates.
    """

    pose: dict[Body, tuple[float, float, float]]
    velocity: dict[Body, tuple[float, float, float]]
    size: float
    measured: tuple[ClearanceRevolute, ...] = ()

    def driven(self, drive: Drive) -> float:
        """Start value of a driven coordinate."""
        return _coordinate(drive.target, self.pose)

    def slide(self, joint: Prismatic) -> tuple[float, float]:
        """Displacement of a prismatic joint and its rate."""
        return _slide(joint, self.pose), _slide_rate(joint, self.pose, self.velocity)


def assemble(scene: Scene) -> Start:
    """Close all loops and find the start velocities.

    Raises ValueError naming the joint for a loop that cannot close (and by how much), a locked mechanism or a redundant
    loop, a drive that fights another.
    """
    system = _System(scene)
    q = system.rough()
    system.take_start_values(q)
    guilty, freedom = system.choose_measured(system.beside(q))
    if freedom and not guilty:
        system.hold(q)
    q = system.closed(q)
    system.report_dependent(*system.choose_measured(q))
    system.check_measured(q)
    velocity = system.velocities(q)
    poses = {b: tuple(map(float, q[3 * i : 3 * i + 3])) for i, b in enumerate(scene.bodies)}
    rates = {b: tuple(map(float, velocity[3 * i : 3 * i + 3])) for i, b in enumerate(scene.bodies)}
    return Start(
        poses | {ground: (0.0, 0.0, 0.0)}, rates | {ground: (0.0, 0.0, 0.0)}, system.size, tuple(system.measured)
    )


@dataclass(frozen=True)
class _Row:
    """One constraint equation: what it belongs to, residual, gradient, and the rate a joint's start asks for."""

    label: str
    residual: float
    slopes: dict[int, float]
    rate: float = 0.0


@dataclass(frozen=True)
class _Held:
    """A free coordinate and the value it starts with: "x" or "y" of a body, its angle, or a joint's slide."""

    target: Body | Prismatic
    what: str
    value: float


class _System:
    """Constraint equations of a scene: joints first, then drives, then free coordinates that keep their start."""

    def __init__(self, scene: Scene):
        self.scene = scene
        self.joints: list[Joint] = list(scene.joints)
        self.measured: list[ClearanceRevolute] = []
        self.place = {b: 3 * i for i, b in enumerate(scene.bodies)}
        self.drives = [d for d in scene.loads if isinstance(d, Drive)]
        self.start: dict[Drive, float] = {}
        self.held: list[_Held] = []
        self.size = _size(scene)

    # --- rough start
    def rough(self) -> np.ndarray:
        """Body angles as given, positions as given or found by following the joints from ground."""
        q = np.zeros(3 * len(self.scene.bodies))
        placed = {ground}
        given = {d.target: d.start for d in self.drives if d.start is not None and isinstance(d.target, Body)}
        for body in self.scene.bodies:
            q[self.place[body] + 2] = given.get(body, body.angle)
            if body.position is not None:
                self._set_origin(q, body, body.position)
                placed.add(body)
        pending = list(self.scene.joints)
        while pending:
            joint = next((j for j in pending if len(placed & set(j.bodies())) == 1), None)
            if joint is None:
                break
            pending.remove(joint)
            self._follow(q, joint, placed)
        return q

    def _set_origin(self, q, body: Body, origin) -> None:
        i = self.place[body]
        x, y = _turned(q[i + 2], *body.com[:2])
        q[i : i + 2] = origin[0] + x, origin[1] + y

    def _follow(self, q, joint: Joint, placed: set) -> None:
        known, new = (joint.a, joint.b) if joint.a.body in placed else (joint.b, joint.a)
        if isinstance(joint, Prismatic):
            turn = joint.angle if new is joint.b else -joint.angle
            q[self.place[new.body] + 2] = self._pose(q, known.body)[2] + turn
        target = self._point(q, known)
        i = self.place[new.body]
        arm = _turned(q[i + 2], new.x - new.body.com[0], new.y - new.body.com[1])
        q[i : i + 2] = target[0] - arm[0], target[1] - arm[1]
        placed.add(new.body)

    def take_start_values(self, q) -> None:
        """Start value of each driven coordinate: as given, from its motion, or that of the rough start."""
        for drive in self.drives:
            if drive.motion is not None:
                self.start[drive] = float(drive.motion(0.0))
            elif drive.start is not None:
                self.start[drive] = drive.start
            elif drive.prescribes:
                self.start[drive] = _coordinate(drive.target, {b: self._pose(q, b) for b in self._all()})

    def hold(self, q) -> None:
        """Free coordinates keep the values of the rough start, unless the start of a drive that pushes decides them."""
        place, pushed = self.beside(q), any(not d.prescribes for d in self.start)
        pose = {b: self._pose(q, b) for b in self._all()}
        plan = closed_plan(self.scene, tuple(self.measured))
        for joint, c in ((a.joint, c) for g in plan.groups for a in g.attachments for c in a.coordinates):
            if c.source != "free":
                continue
            target = joint if c.what == "slide" else c.body
            value = pose[c.body]["xy".index(c.what)] if c.what in ("x", "y") else _coordinate(target, pose)
            self.held.append(_Held(target, c.what, value))
            if pushed and np.linalg.matrix_rank(matrix := self.equations(place)[2]) < len(matrix):
                self.held.pop()

    def _all(self):
        return (*self.scene.bodies, ground)

    # --- geometry
    def _pose(self, q, body: Body):
        i = self.place.get(body)
        return (0.0, 0.0, 0.0) if i is None else (q[i], q[i + 1], q[i + 2])

    def _point(self, q, point):
        x, y, angle = self._pose(q, point.body)
        dx, dy = _turned(angle, point.x - point.body.com[0], point.y - point.body.com[1])
        return x + dx, y + dy

    # --- equations
    def equations(self, q, starting: bool = True):
        """Labels, residuals and Jacobian of all constraints.

        `starting` includes what only the start must meet: start values of effort drives and of held coordinates.
        """
        drives = [d for d in self.drives if d in self.start and (starting or d.prescribes)]
        rows = self._rows(q, drives) + [self._held_row(q, h) for h in self.held if starting]
        return [r.label for r in rows], np.array([r.residual for r in rows]), self._matrix(q, rows)

    def _rows(self, q, drives) -> "list[_Row]":
        """Of all joints, then of these drives. Plain floats: numpy's are slow one by one."""
        q = q.tolist()
        return [*(row for j in self.joints for row in self._joint_rows(q, j)), *(self._drive_row(q, d) for d in drives)]

    def _matrix(self, q, rows: "list[_Row]") -> np.ndarray:
        matrix = np.zeros((len(rows), q.size))
        for i, row in enumerate(rows):
            for j, slope in row.slopes.items():
                matrix[i, j] += slope
        return matrix

    def _joint_rows(self, q, joint: Joint):
        pa, pb = self._point(q, joint.a), self._point(q, joint.b)
        x, y = pb[0] - pa[0], pb[1] - pa[1]
        arms = self._arms(q, joint)
        if not isinstance(joint, Prismatic):
            ex, ey = getattr(joint, "eccentricity", (0.0, 0.0))
            u, v = getattr(joint, "eccentricity_rate", (0.0, 0.0))
            across = self._gradient(joint, arms, (1.0, 0.0)), self._gradient(joint, arms, (0.0, 1.0))
            return [_Row(joint.label(), x - ex, across[0], u), _Row(joint.label(), y - ey, across[1], v)]
        ta, tb = self._pose(q, joint.a.body)[2], self._pose(q, joint.b.body)[2]
        dx, dy = _turned(ta, *joint.axis)
        slopes = self._gradient(joint, arms, (-dy, dx))
        self._put(slopes, joint.a.body, 2, -(dx * x + dy * y))
        turn: dict[int, float] = {}
        self._put(turn, joint.a.body, 2, -1.0)
        self._put(turn, joint.b.body, 2, 1.0)
        wrong = math.remainder(tb - ta - joint.angle, 2.0 * math.pi)
        return [_Row(joint.label(), dx * y - dy * x, slopes), _Row(joint.label(), wrong, turn)]

    def _arms(self, q, joint):
        return tuple(
            _turned(self._pose(q, p.body)[2], p.x - p.body.com[0], p.y - p.body.com[1]) for p in (joint.a, joint.b)
        )

    def _gradient(self, joint, arms, direction) -> dict[int, float]:
        """Gradient of direction . (r_b - r_a)."""
        slopes: dict[int, float] = {}
        for sign, point, arm in ((-1.0, joint.a, arms[0]), (1.0, joint.b, arms[1])):
            self._put(slopes, point.body, 0, sign * direction[0])
            self._put(slopes, point.body, 1, sign * direction[1])
            self._put(slopes, point.body, 2, sign * (direction[1] * arm[0] - direction[0] * arm[1]))
        return slopes

    def _put(self, slopes: dict, body: Body, which: int, value: float) -> None:
        if body in self.place:
            i = self.place[body] + which
            slopes[i] = slopes.get(i, 0.0) + value

    def _drive_row(self, q, drive: Drive):
        return self._coordinate_row(q, drive.label(), drive.target, self.start.get(drive, 0.0))

    def _held_row(self, q, held: _Held):
        if held.what not in ("x", "y"):
            return self._coordinate_row(q, f"start of {held.target.name}", held.target, held.value)
        i = self.place[held.target] + "xy".index(held.what)
        return _Row(f"start of {held.target.name}", float(q[i]) - held.value, {i: 1.0})

    def _coordinate_row(self, q, label: str, target: Body | Joint, value: float):
        """A coordinate as `_coordinate` has it shall have a value."""
        slopes: dict[int, float] = {}
        pose = {b: self._pose(q, b) for b in self._all()}
        error = _coordinate(target, pose) - value
        if isinstance(target, Prismatic):
            dx, dy = _turned(pose[target.a.body][2], *target.axis)
            slopes = self._gradient(target, self._arms(q, target), (dx, dy))
            pa, pb = self._point(q, target.a), self._point(q, target.b)
            self._put(slopes, target.a.body, 2, dx * (pb[1] - pa[1]) - dy * (pb[0] - pa[0]))
        elif isinstance(target, Body):
            self._put(slopes, target, 2, 1.0)
        else:
            self._put(slopes, target.a.body, 2, -1.0)
            self._put(slopes, target.b.body, 2, 1.0)
        return _Row(label, error, slopes)

    # --- closing
    def closed(self, q: np.ndarray) -> np.ndarray:
        """The closed position nearest to the rough start; held coordinates are let go where it closes only so."""
        best, worst = self._nearest(q)
        if worst > CLOSURE * self.size and self.held:
            self.held.clear()
            best, worst = self._nearest(q)
        if worst > CLOSURE * self.size:
            # too many equations for any position? (a stretched loop is singular too, so look beside it)
            self.report_dependent(*self._dependent(self.beside(best)))
            labels, residual, _ = self.equations(best)
            self._report_open(labels, residual)
        return best

    def _nearest(self, q: np.ndarray) -> tuple[np.ndarray, float]:
        """Damped Gauss-Newton: the best position on the way, and its largest residual."""
        best, worst = q, math.inf
        for _ in range(ITERATIONS):
            _, residual, matrix = self.equations(q)
            error = float(np.abs(residual).max(initial=0.0))
            if error < worst:
                best, worst = q, error
            if error <= 0.01 * CLOSURE * self.size:
                break
            step = -np.linalg.lstsq(matrix, residual, rcond=1e-12)[0]
            turn = np.abs(step[2::3]).max(initial=0.0)
            q = q + step * min(1.0, LARGEST_TURN / turn if turn else 1.0)
            if worst <= CLOSURE * self.size and np.abs(step).max() < 1e-15 * self.size:
                break
        return best, worst

    def beside(self, q: np.ndarray) -> np.ndarray:
        """Some position with nothing special about it."""
        return q + 0.1 * self.size * np.random.default_rng(1).uniform(-1.0, 1.0, q.size)

    def _report_open(self, labels, residual) -> None:
        totals: dict[str, float] = {}
        for label, r in zip(labels, residual, strict=True):
            totals[label] = math.hypot(totals.get(label, 0.0), r)
        label = max(totals, key=totals.get)
        raise ValueError(
            f"loop cannot close: {label} stays {totals[label]:.6g} m open "
            f"(all together {float(np.linalg.norm(residual)):.6g}); check lengths and the rough start angles"
        )

    def choose_measured(self, q: np.ndarray) -> tuple[list[str], int]:
        """Leave out clearance joints, last first, until the others' equations are independent at q.

        Returns what is dependent still, as `_dependent` does.
        """
        while True:
            guilty, freedom = self._dependent(q)
            loose = [j for j in self.joints if isinstance(j, ClearanceRevolute) and j.label() in guilty]
            if not loose:
                return guilty, freedom
            self.joints.remove(loose[-1])
            self.measured.append(loose[-1])

    def check_measured(self, q: np.ndarray) -> None:
        """A film joint whose eccentricity follows from the others must start inside its clearance circle."""
        for joint in self.measured:
            (ax, ay), (bx, by) = self._point(q, joint.a), self._point(q, joint.b)
            e = math.hypot(bx - ax, by - ay)
            if joint.contact is None and e >= joint.clearance:
                raise ValueError(
                    f"loop cannot close: {joint.label()} starts {e:.6g} m off centre, outside its clearance circle "
                    f"({joint.clearance:.6g} m); the other joints leave it no other place"
                )

    def report_dependent(self, names: list[str], freedom: int) -> None:
        """Every equation must constrain something of its own."""
        if not names:
            return
        if freedom == 0:
            raise ValueError(f"locked: the joints leave no movement at all; too many equations in {', '.join(names)}")
        if any(not n.startswith("joint") for n in names):
            raise ValueError(
                f"locked: {', '.join(names)} prescribe more than the mechanism's {freedom} free movement(s)"
            )
        raise ValueError(
            f"redundant loop: {', '.join(names)} repeat each other's constraints "
            "(or the start is a singular position; start elsewhere)"
        )

    def _dependent(self, q: np.ndarray) -> tuple[list[str], int]:
        """Labels of equations that repeat each other at q, and how many movements the joints alone leave."""
        labels, _, matrix = self.equations(q, starting=False)
        scaled = matrix.copy()
        scaled[:, 2::3] /= self.size
        for i, label in enumerate(labels):
            if not label.startswith("joint") or not np.any(scaled[i, 0::3]) and not np.any(scaled[i, 1::3]):
                scaled[i] *= self.size
        if not scaled.size:
            return [], scaled.shape[1]
        values = np.linalg.svd(scaled, compute_uv=False)
        rank = int((values > RANK * values[0]).sum())
        if rank == len(labels):
            return [], scaled.shape[1] - rank
        left = np.linalg.svd(scaled)[0]
        guilty = np.abs(left[:, rank:]).max(axis=1) > 1e-6
        names = list(dict.fromkeys(n for n, g in zip(labels, guilty, strict=True) if g))
        joints = [n for n in labels if n.startswith("joint")]
        alone = scaled[: len(joints)]
        freedom = scaled.shape[1] - int((np.linalg.svd(alone, compute_uv=False) > RANK * values[0]).sum())
        return names, freedom

    # --- velocities
    def velocities(self, q: np.ndarray) -> np.ndarray:
        """Rates that satisfy all joints and drives, nearest to those given with the bodies (others count little)."""
        rough, free = np.zeros(q.size), np.ones(q.size)
        for body, i in self.place.items():
            rough[i : i + 3] = (*body.velocity, body.angular_velocity)
            free[i : i + 3] = (1.0, 1.0, 1.0 / self.size)
        free[rough != 0.0] *= 1e-6
        drives = [d for d in self.drives if d.prescribes or d.speed_start is not None]
        rows = self._rows(q, drives)
        rates = [r.rate for r in rows[: len(rows) - len(drives)]] + [_rate_at_start(d) for d in drives]
        matrix = self._matrix(q, rows)
        missing = np.array(rates) - matrix @ rough
        return rough + free * np.linalg.lstsq(matrix * free, missing, rcond=1e-12)[0]


def _turned(angle: float, x: float, y: float) -> tuple[float, float]:
    c, s = math.cos(angle), math.sin(angle)
    return c * x - s * y, s * x + c * y


def _coordinate(target: Body | Joint, pose) -> float:
    """Coordinate that a drive of this target drives: an angle, a relative angle, or a displacement."""
    if isinstance(target, Prismatic):
        return _slide(target, pose)
    if isinstance(target, Body):
        return pose[target][2]
    return pose[target.b.body][2] - pose[target.a.body][2]


def _joint_points(joint, pose):
    points = []
    for p in (joint.a, joint.b):
        x, y, angle = pose[p.body]
        dx, dy = _turned(angle, p.x - p.body.com[0], p.y - p.body.com[1])
        points.append((x + dx, y + dy, dx, dy))
    return points


def _slide(joint: Prismatic, pose) -> float:
    (ax, ay, *_), (bx, by, *_) = _joint_points(joint, pose)
    dx, dy = _turned(pose[joint.a.body][2], *joint.axis)
    return dx * (bx - ax) + dy * (by - ay)


def _slide_rate(joint: Prismatic, pose, velocity) -> float:
    _, (bx, by, arm_x, arm_y) = _joint_points(joint, pose)
    ax, ay, angle = pose[joint.a.body]
    va, vb = velocity[joint.a.body], velocity[joint.b.body]
    dx, dy = _turned(angle, *joint.axis)
    x = vb[0] - vb[2] * arm_y - (va[0] - va[2] * (by - ay))
    y = vb[1] + vb[2] * arm_x - (va[1] + va[2] * (bx - ax))
    return dx * x + dy * y


def _rate_at_start(drive: Drive) -> float:
    """Rate of a driven coordinate at t = 0: the speed given, or the motion's first derivative."""
    if drive.motion is None:
        return drive.speed if drive.prescribes else drive.speed_start
    slope = evaluated(traced(drive.motion.law.function).slopes((0,)))
    return slope(0.0, *drive.motion.numbers)[1]


def _size(scene: Scene) -> float:
    """A length of the mechanism: the farthest joint point from its body's centre of mass or the origin."""
    points = [p for j in scene.joints for p in (j.a, j.b)]
    reach = [math.hypot(p.x - p.body.com[0], p.y - p.body.com[1]) for p in points]
    ends = [p for load in scene.loads for p in (getattr(load, "a", None), getattr(load, "b", None)) if hasattr(p, "x")]
    reach += [math.hypot(p.x - p.body.com[0], p.y - p.body.com[1]) for p in ends]
    clearances = [j.clearance for j in scene.joints if isinstance(j, ClearanceRevolute)]
    return max([r for r in reach if r > 0.0] + clearances, default=1.0)
