"""An independent formulation of the same mechanics, for tests and benchmarks only.

Absolute coordinates of all bodies and Lagrange multipliers: [M J^T; J 0] [a; lambda] = [F; gamma],
one dense LAPACK solve in numba. Nothing of the package's mechanics is used, only the scene's data;
joint forces are written out here.
"""

import math

import numpy as np
from numba import njit

from clearance.elements import ClearancePrismatic, ClearanceRevolute, Prismatic
from clearance.scene.scene import Scene

REVOLUTE, PRISMATIC, FILM, CONTACT, ANGLE, RELATIVE, SLIDE = range(7)


class Augmented:
    """Arrays of a scene without springs and loads; `accelerations(q, v)` solves the augmented
    system.
    """

    def __init__(self, scene: Scene):
        self.scene = scene
        index = {b: i for i, b in enumerate(scene.bodies)}
        self.mass = np.array([m for b in scene.bodies for m in (b.mass, b.mass, b.inertia)])
        self.gravity = np.array([*scene.gravity, 0.0] * len(scene.bodies))
        rows, numbers = [], []
        self.index = index
        self.blocks = [j for j in scene.joints if isinstance(j, ClearancePrismatic)]
        for joint in (j for j in scene.joints if j not in self.blocks):
            kind = PRISMATIC if isinstance(joint, Prismatic) else REVOLUTE
            if isinstance(joint, ClearanceRevolute):
                kind = FILM if joint.film is not None else CONTACT
            rows.append((kind, index.get(joint.a.body, -1), index.get(joint.b.body, -1)))
            numbers.append([*_local(joint.a), *_local(joint.b), *_extra(joint)])
        self.pushes = []
        for drive in scene.drives:
            target = drive.target
            if drive.torque is not None:  # a constant torque on a body
                self.pushes.append(
                    (3 * index[target] + 2, drive.torque / self.mass[3 * index[target] + 2])
                )
                continue
            if target in index:
                rows.append((ANGLE, -1, index[target]))
                numbers.append([0.0] * 12)
            else:
                kind = SLIDE if isinstance(target, Prismatic) else RELATIVE
                rows.append((kind, index.get(target.a.body, -1), index.get(target.b.body, -1)))
                numbers.append([*_local(target.a), *_local(target.b), *_extra(target)])
        for row, push in self.pushes:
            self.gravity[row] += push
        self.rows, self.numbers = np.array(rows), np.array(numbers)
        self.count = 2 * sum(r[0] in (REVOLUTE, PRISMATIC) for r in rows) + sum(
            r[0] >= ANGLE for r in rows
        )

    def accelerations(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Accelerations of all bodies, then the multipliers (forces on the b side, in row order).

        Corners of blocks in guides have touched at `IMPACT`.
        """
        pushed = self.gravity.copy()
        for joint in self.blocks:
            for body, wrench in block(joint, *self._motions(joint, q, v)).items():
                if body in self.index:
                    at = slice(3 * self.index[body], 3 * self.index[body] + 3)
                    pushed[at] += wrench / self.mass[at]
        return augmented(q, v, self.mass, pushed, self.rows, self.numbers, self.count)

    def _motions(self, joint, q, v):
        """(x, y, angle) of both bodies and their rates; zeros for ground."""
        for body in (joint.a.body, joint.b.body):
            i = self.index.get(body)
            yield (np.zeros(3),) * 2 if i is None else (q[3 * i : 3 * i + 3], v[3 * i : 3 * i + 3])


def _local(point):
    return point.x - point.body.com[0], point.y - point.body.com[1]


def _extra(joint):
    if isinstance(joint, Prismatic):
        return [*joint.axis, 0, 0, 0, 0, 0, 0]
    if not isinstance(joint, ClearanceRevolute):
        return [0.0] * 8
    if joint.film is not None:
        return [
            joint.clearance,
            joint.radius,
            joint.length,
            joint.lubricant.viscosity,
            float(joint.film_torques),
            0,
            0,
            0,
        ]
    p = joint.contact.parameters
    return [
        joint.clearance,
        joint.radius,
        p["stiffness"],
        p["restitution"],
        math.hypot(*joint.eccentricity_rate),
        0,
        0,
        0,
    ]


IMPACT = 0.1  # m/s


def block(joint, guide, slider):
    """Wrenches on both bodies about their centres of mass, from places and velocities of corners in
    the plane.

    Lankarani and Nikravesh's contact and algebraic Coulomb friction, both written out.
    """
    (qa, va), (qb, vb) = guide, slider
    contact, friction = joint.contact.parameters, joint.friction.parameters
    d = turn(qa[2]) @ joint.axis
    n = np.array([-d[1], d[0]])
    foot = qa[:2] + turn(qa[2]) @ _local(joint.a)
    lie = turn(qb[2] - joint.angle)
    forces = {joint.a.body: np.zeros(3), joint.b.body: np.zeros(3)}
    for sx in (-1.0, 1.0):
        for sy in (-1.0, 1.0):
            along, across = lie @ joint.axis, lie @ [-joint.axis[1], joint.axis[0]]
            arm = 0.5 * (sx * joint.overlap * along + sy * joint.height * across)
            corner = qb[:2] + turn(qb[2]) @ _local(joint.b) + arm
            depth = sy * n @ (corner - foot) - 0.5 * joint.height - joint.clearance
            if depth <= 0.0:
                continue
            speeds = [velocity(q, v, corner) for q, v in ((qb, vb), (qa, va))]
            u = speeds[0] - speeds[1]
            damping = 0.75 * (1 - contact["restitution"] ** 2) * sy * (n @ u) / IMPACT
            load = contact["stiffness"] * depth**1.5 * max(1.0 + damping, 0.0)
            rub = (
                friction["coefficient"]
                * load
                * (d @ u)
                / math.hypot(d @ u, friction["transition_speed"])
            )
            force = -sy * load * n - rub * d
            for body, q, sign in ((joint.b.body, qb, 1.0), (joint.a.body, qa, -1.0)):
                x, y = corner - q[:2]
                forces[body] += sign * np.array([*force, x * force[1] - y * force[0]])
    return forces


def turn(angle):
    return np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])


def velocity(q, v, position):
    """Velocity of the body's point that stands at a place."""
    x, y = position - q[:2]
    return np.array([v[0] - v[2] * y, v[1] + v[2] * x])


@njit(error_model="numpy")
def film(ex, ey, vx, vy, wa, wb, c, radius, length, mu, torques):
    """Pinkus-Sternlicht in its textbook branches (k form), and both torques."""
    e = math.hypot(ex, ey)
    nx, ny = ex / e, ey / e
    eps, rate, swirl = e / c, (vx * nx + vy * ny) / c, (vy * nx - vx * ny) / e
    w = wa + wb - 2.0 * swirl
    p0 = mu * length * radius**3 / c**2
    k = math.sqrt((1 - eps**2) * ((w / (2 * rate)) ** 2 + 1 / eps**2))
    if rate > 0:
        fr = (
            -p0
            * 6
            * rate
            / ((2 + eps**2) * (1 - eps**2) ** 1.5)
            * (4 * k * eps**2 + (2 + eps**2) * math.pi * (k + 3) / (k + 1.5))
        )
        ft = (
            p0
            * 6
            * math.pi
            * eps
            * w
            / ((2 + eps**2) * math.sqrt(1 - eps**2))
            * (k + 3)
            / (k + 1.5)
        )
    else:
        fr = (
            p0
            * 6
            * rate
            / ((2 + eps**2) * (1 - eps**2) ** 1.5)
            * (4 * k * eps**2 - (2 + eps**2) * math.pi * k / (k + 1.5))
        )
        ft = p0 * 6 * math.pi * eps * w / ((2 + eps**2) * math.sqrt(1 - eps**2)) * k / (k + 1.5)
    couette = 2 * math.pi * mu * radius**3 * length / (c * math.sqrt(1 - eps**2)) * (wb - wa)
    tb, ta = -(couette + 0.5 * e * ft) * torques, (couette - 0.5 * e * ft) * torques
    return fr * nx - ft * ny, fr * ny + ft * nx, ta, tb


@njit(error_model="numpy")
def contact(ex, ey, vx, vy, c, stiffness, restitution, impact):
    e = math.hypot(ex, ey)
    if e <= c:
        return 0.0, 0.0
    nx, ny = ex / e, ey / e
    bracket = 1 + 0.75 * (1 - restitution**2) * (vx * nx + vy * ny) / max(impact, 1e-3)
    load = stiffness * (e - c) ** 1.5 * max(bracket, 0.0)
    return -load * nx, -load * ny


@njit(error_model="numpy")
def augmented(q, v, mass, gravity, rows, numbers, count):
    size = q.size
    matrix = np.zeros((size + count, size + count))
    right = np.zeros(size + count)
    for i in range(size):
        matrix[i, i] = mass[i]
        right[i] = mass[i] * gravity[i]
    row = size
    for r in range(rows.shape[0]):
        kind, a, b = rows[r]
        p = numbers[r]
        # points, their velocities and centripetal accelerations; jac: d(point)/dq as (x, y, angle)
        # coefficients
        ax, ay, xa, ya, ua, va, wa = p[0], p[1], p[0], p[1], 0.0, 0.0, 0.0
        cosa, sina = 1.0, 0.0
        if a >= 0:
            cosa, sina = math.cos(q[3 * a + 2]), math.sin(q[3 * a + 2])
            ax, ay = cosa * p[0] - sina * p[1], sina * p[0] + cosa * p[1]
            wa = v[3 * a + 2]
            xa, ya = q[3 * a] + ax, q[3 * a + 1] + ay
            ua, va = v[3 * a] - wa * ay, v[3 * a + 1] + wa * ax
        bx, by, xb, yb, ub, vb, wb = p[2], p[3], p[2], p[3], 0.0, 0.0, 0.0
        if b >= 0:
            cosb, sinb = math.cos(q[3 * b + 2]), math.sin(q[3 * b + 2])
            bx, by = cosb * p[2] - sinb * p[3], sinb * p[2] + cosb * p[3]
            wb = v[3 * b + 2]
            xb, yb = q[3 * b] + bx, q[3 * b + 1] + by
            ub, vb = v[3 * b] - wb * by, v[3 * b + 1] + wb * bx
        if kind in (FILM, CONTACT):
            if kind == FILM:
                fx, fy, ta, tb = film(
                    xb - xa, yb - ya, ub - ua, vb - va, wa, wb, p[4], p[5], p[6], p[7], p[8]
                )
            else:
                fx, fy = contact(xb - xa, yb - ya, ub - ua, vb - va, p[4], p[6], p[7], p[8])
                ta, tb = 0.0, 0.0
            if a >= 0:
                right[3 * a] -= fx
                right[3 * a + 1] -= fy
                right[3 * a + 2] += ta - (ax * fy - ay * fx)
            if b >= 0:
                right[3 * b] += fx
                right[3 * b + 1] += fy
                right[3 * b + 2] += tb + (bx * fy - by * fx)
            continue
        if kind == REVOLUTE:
            for axis in range(2):
                if a >= 0:
                    matrix[row, 3 * a + axis] = -1.0
                    matrix[row, 3 * a + 2] = ay if axis == 0 else -ax
                    right[row] -= wa * wa * (ax if axis == 0 else ay)
                if b >= 0:
                    matrix[row, 3 * b + axis] = 1.0
                    matrix[row, 3 * b + 2] = -by if axis == 0 else bx
                    right[row] += wb * wb * (bx if axis == 0 else by)
                row += 1
        if kind in (PRISMATIC, SLIDE):
            dx, dy = cosa * p[4] - sina * p[5], sina * p[4] + cosa * p[5]
            nx, ny = (-dy, dx) if kind == PRISMATIC else (dx, dy)
            x, y = xb - xa, yb - ya
            u, w = ub - ua, vb - va
            # phi = n.(rb - ra), n turns with a:
            # phi'' = n.(ab - aa) + 2 (wa J n).(vb - va) + (alpha J n - wa^2 n).(rb - ra)
            jnx, jny = -ny, nx
            if a >= 0:
                matrix[row, 3 * a], matrix[row, 3 * a + 1] = -nx, -ny
                matrix[row, 3 * a + 2] = nx * ay - ny * ax + jnx * x + jny * y
            if b >= 0:
                matrix[row, 3 * b], matrix[row, 3 * b + 1] = nx, ny
                matrix[row, 3 * b + 2] = -nx * by + ny * bx
            right[row] = (
                wb * wb * (nx * bx + ny * by)
                - wa * wa * (nx * ax + ny * ay)
                - 2.0 * wa * (jnx * u + jny * w)
                + wa * wa * (nx * x + ny * y)
            )
            row += 1
        if kind in (PRISMATIC, RELATIVE, ANGLE):
            if a >= 0:
                matrix[row, 3 * a + 2] = -1.0
            if b >= 0:
                matrix[row, 3 * b + 2] = 1.0
            row += 1
    for i in range(size, size + count):
        for j in range(size):
            matrix[j, i] = -matrix[i, j]
    return np.linalg.solve(matrix, right)
