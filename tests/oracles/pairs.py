"""Motion of a scene whose drives prescribe all of it: poses, velocities and accelerations of its
bodies, all samples.

The plane is that of complex numbers: a point is x + i y, a turn by theta the factor exp(i theta).

Body b has three relative coordinates against body a at a kinematic pair: along, across and turn. A
hinge measures the first two along the fixed axes, a slide along axes that turn with a. The joint
holds two of them, a drive may prescribe the third. All that is held, as many coordinates phi as the
poses q of the centres of mass have, gives the motion by

    phi(q) = r(t),   J q' = r',   J q'' = r'' - J' q'
"""

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np

from clearance.elements import Drive
from clearance.elements.body import Body, Point, as_point, ground
from clearance.laws.law import BoundLaw
from clearance.mechanism.assembly import Start
from clearance.scene.scene import Scene
from clearance.tracing.interpreter import traced
from clearance.tracing.kernels import evaluated

TURN = 2.0 * math.pi
#: closing errors [rad, sizes of the mechanism]: where Newton stops, and what is accepted where it
#: gets no further
CLOSED, CLOSURE = 1e-15, 1e-10
#: condition number of the held coordinates from which a position is singular. It is 10 to 300 in
#: common mechanisms. Next to a dead centre poses have that many roundings, forces the square of it.
SINGULAR = 1e7
#: largest first correction of a predicted pose [rad, sizes], and shortest step over the last time,
#: of a motion followed
JUMP, SHORTEST = 0.05, 1e-10
ITERATIONS = 50


def prescribed(
    drive: Drive, time: np.ndarray, start: float = 0.0
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Coordinate, rate and acceleration of a driven coordinate, each (samples,): [rad] or [m], per
    s, per s2.

    time (samples,) [s]; start: the coordinate at t = 0 of a drive with a speed but no start value
    of its own. Raises ValueError for a drive whose motion follows from its torque or force.
    """
    time = np.asarray(time, dtype=float)
    if not drive.prescribes:
        raise ValueError(f"{drive.label()}: gives a torque or force; its motion is not prescribed")
    if drive.speed is not None:
        start = start if drive.start is None else drive.start
        return start + drive.speed * time, np.full_like(time, drive.speed), np.zeros_like(time)
    derivatives = _derivatives(drive.motion.law.function)
    motion = np.array(
        [derivatives(t, *drive.motion.numbers) for t in time.tolist()], dtype=float
    ).reshape(-1, 4)
    return motion[:, 0], motion[:, 1], motion[:, 3]


@lru_cache(maxsize=64)
def _derivatives(function: Callable) -> Callable:
    """(x, x', x', x'') of a function of time, exact."""
    return evaluated(traced(function).slopes((0,)).slopes((0,)))


class Pairs:
    """A scene as arrays over its kinematic pairs: its joints, then one with ground for each driven
    body.

    a, b: places of their bodies in (*bodies, ground); local_a, local_b: their points x + i y from
    the centres of mass, in the bodies' frames, and height_a, height_b out of the plane [m]; slides:
    which turn with a, and axis (unit vector in a's frame). Relative coordinates are numbered 3 p +
    (0 along, 1 across, 2 turn), in this order: free (pairs,), driven (drives,), held
    (coordinates,). free is the one that no joint holds, held are all that joints and drives hold.
    """

    def __init__(self, scene: Scene, start: Start):
        self.scene, self.start, self.size = scene, start, start.size
        self.index = {b: i for i, b in enumerate((*scene.bodies, ground))}
        self.drives = scene.drives
        bodies = [d.target for d in self.drives if isinstance(d.target, Body)]
        ends = [(j.a, j.b) for j in scene.joints] + [
            (as_point("drive", ground), as_point("drive", b)) for b in bodies
        ]
        self.a, self.local_a, self.height_a = self._ends([a for a, _ in ends])
        self.b, self.local_b, self.height_b = self._ends([b for _, b in ends])
        self.slides = np.array([j.slides for j in scene.joints] + [False] * len(bodies))
        self.axis = np.array(
            [complex(*getattr(j, "axis", (1.0, 0.0))) for j in scene.joints] + [1.0] * len(bodies)
        )
        coordinates = np.arange(3 * len(ends)).reshape(-1, 3)
        self.free = np.where(self.slides, coordinates[:, 0], coordinates[:, 2])
        targets = [*scene.joints, *bodies]
        self.driven = np.array([self.free[targets.index(d.target)] for d in self.drives], dtype=int)
        joints = [c for p in range(len(scene.joints)) for c in coordinates[p] if c != self.free[p]]
        self.held = np.array([*joints, *self.driven], dtype=int)
        self.labels = [j.label() for j in scene.joints for _ in range(2)] + [
            d.label() for d in self.drives
        ]
        self.is_turn = self.held % 3 == 2
        #: makes what stays open of a held coordinate a share of the mechanism's size
        self.share = np.where(self.is_turn, 1.0, 1.0 / self.size)

    def _ends(self, points: list[Point]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        local, height = zip(*(from_centre(p) for p in points), strict=True)
        return np.array([self.index[p.body] for p in points]), np.array(local), np.array(height)

    def prescribed(self, time: np.ndarray) -> np.ndarray:
        """Values, rates and accelerations of all that is held (3, samples, held)."""
        motion = np.zeros((3, time.size, self.held.size))
        for j, joint in enumerate(self.scene.joints):
            motion[0, :, 2 * j + 1] = getattr(joint, "angle", 0.0)
        for d, drive in enumerate(self.drives, 2 * len(self.scene.joints)):
            motion[:, :, d] = prescribed(drive, time, self.start.coordinate(drive.target))
        return motion

    def motion(self, geometry: "Geometry", time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Velocities and accelerations of the bodies (samples, bodies, 3)."""
        _, rates, accelerations = self.prescribed(time)
        matrix = geometry.rows[:, self.held]
        v = solve(matrix, rates[..., None])
        spins = np.concatenate([v[:, 2::3, 0], np.zeros((time.size, 1))], axis=1)
        w_a, w_b = spins[:, self.a], spins[:, self.b]
        centripetal = geometry.axis.conj() * (w_a**2 * geometry.reach - w_b**2 * geometry.arm_b)
        coriolis = 2j * w_a * (geometry.rows[:, 0::3] @ v)[..., 0] * self.slides
        bias = _flat(centripetal - coriolis, np.zeros_like(w_a))
        a = solve(matrix, (accelerations - bias[:, self.held])[..., None])
        return v.reshape(time.size, -1, 3), a.reshape(time.size, -1, 3)

    def closed(
        self, guess: np.ndarray, values: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Newton's method on all that is held, all samples at once.

        Returns the poses (samples, bodies, 3), the residual of each held coordinate (samples, held)
        and the largest first correction (samples,). The last two are in rad and sizes of the
        mechanism.
        """
        q, rest, jump = guess.copy(), np.full(values.shape, np.inf), np.zeros(len(guess))
        active, trial = np.arange(len(guess)), guess
        for step in range(ITERATIONS):
            geometry = Geometry(self, trial)
            wrong = geometry.values[:, self.held] - values[active]
            error = np.abs(wrong * self.share).max(axis=1)
            better = error < np.abs(rest[active]).max(axis=1)
            q[active[better]], rest[active[better]] = trial[better], (wrong * self.share)[better]
            on = better & (error > CLOSED)
            if not on.any():
                break
            active = active[on]
            correction = solve(geometry.rows[on][:, self.held], wrong[on][..., None]).reshape(
                -1, *q.shape[1:]
            )
            if step == 0:
                jump[active] = np.abs(correction / [self.size, self.size, 1.0]).max(axis=(1, 2))
            trial = trial[on] - correction
        return q, rest, jump

    def whole_turns(self, q: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Complete turns [rad] between angles at these poses and the prescribed ones (samples,
        held).
        """
        away = Geometry(self, q).values[:, self.held] - values
        return np.where(self.is_turn, TURN * np.rint(away / TURN), 0.0)

    def polished(self, time: np.ndarray, guess: np.ndarray) -> tuple[np.ndarray, str]:
        """Poses up to the first sample that does not close, and what stays open there ("" where all
        close).
        """
        values = self.prescribed(time)[0]
        q, rest, _ = self.closed(guess, values + self.whole_turns(guess, values))
        failed = np.abs(rest).max(axis=1) > CLOSURE
        if not failed.any():
            return q, ""
        first = int(failed.argmax())
        return q[:first], self._opening(rest[first])

    def followed(self, time: np.ndarray) -> tuple[np.ndarray, str]:
        """Poses from the assembled start, up to the first sample out of reach, and what stays open
        there.

        A step predicts by velocity and acceleration and corrects all samples within it at once. It
        is accepted where no first correction exceeds JUMP, so that the motion stays on its branch.
        A singular position between two samples is passed the smooth way.
        """
        node = np.array([[self.start.pose[b] for b in self.scene.bodies]])
        turns = self.whole_turns(node, self.prescribed(np.zeros(1))[0])
        v, a = self.motion(Geometry(self, node), np.zeros(1))
        q, done, now, step = np.empty((time.size, *node.shape[1:])), 0, 0.0, 1e-3 * time[-1]
        while done < time.size:
            end = min(now + step, time[-1])
            count = int(np.searchsorted(time, end, side="right"))
            moments = np.append(time[done:count], end)
            after = (moments - now)[:, None, None]
            motion, rest, jump = self.closed(
                node + after * (v + 0.5 * after * a), self.prescribed(moments)[0] + turns
            )
            if np.abs(rest).max() <= CLOSURE and jump.max() <= JUMP:
                q[done:count], node, done, now = motion[:-1], motion[-1:], count, end
                v, a = self.motion(Geometry(self, node), moments[-1:])
                step *= min(2.0, 0.8 * (JUMP / max(jump[-1], 1e-3 * JUMP)) ** (1.0 / 3.0))
            elif step > SHORTEST * time[-1]:
                step *= 0.25
            else:
                values = self.prescribed(time[done : done + 1])[0] + turns
                return q[:done], self._opening(self.closed(node, values)[1][0])
        return q, ""

    def _opening(self, rest: np.ndarray) -> str:
        """The held coordinate that stays open most."""
        worst = int(np.abs(rest).argmax())
        amount, unit = abs(rest[worst] / self.share[worst]), "rad" if self.is_turn[worst] else "m"
        return f"the motion ends here; {self.labels[worst]} stays {amount:.3g} {unit} open"

    def regular(self, geometry: "Geometry") -> tuple[int, str]:
        """Number of samples before the first singular position, and what is singular there (""
        where none is).
        """
        size = np.tile([self.size, self.size, 1.0], len(self.scene.bodies))
        scaled = geometry.rows[:, self.held] * self.share[:, None] * size
        failed = np.linalg.cond(scaled, 1) > SINGULAR
        if not failed.any():
            return len(failed), ""
        first = int(failed.argmax())
        # forces that do no work in any motion
        unlimited = np.abs(np.linalg.svd(scaled[first])[0][:, -1])
        return (
            first,
            f"singular position; the reaction of {self.labels[int(unlimited.argmax())]} has no "
            f"unique answer",
        )


class Geometry:
    """Pairs at some poses q (samples, bodies, 3) of the centres of mass.

    With ground (samples, bodies + 1): angle, turned = exp(i angle), centre x + i y. Of the pairs
    (samples, pairs): axis of the coordinate along, and arm_b to point b from b's centre. reach goes
    to where the joint acts on a (the sliding point of a slide). values (samples, 3 pairs) of the
    relative coordinates, rows (samples, 3 pairs, 3 bodies) their gradients.
    """

    def __init__(self, pairs: Pairs, q: np.ndarray):
        samples, bodies, count = len(q), q.shape[1], pairs.a.size
        q = np.concatenate([q, np.zeros((samples, 1, 3))], axis=1)
        self.angle, self.turned, self.centre = (
            q[..., 2],
            np.exp(1j * q[..., 2]),
            q[..., 0] + 1j * q[..., 1],
        )
        self.arm_b, arm_a = (
            self.turned[:, pairs.b] * pairs.local_b,
            self.turned[:, pairs.a] * pairs.local_a,
        )
        apart = self.centre[:, pairs.b] + self.arm_b - self.centre[:, pairs.a] - arm_a
        self.axis = np.where(pairs.slides, self.turned[:, pairs.a], 1.0) * pairs.axis
        self.reach = arm_a + apart * pairs.slides
        self.values = _flat(
            self.axis.conj() * apart, self.angle[:, pairs.b] - self.angle[:, pairs.a]
        )
        rows, p = np.zeros((samples, count, 3, bodies + 1, 3)), np.arange(count)
        for sign, body, arm in ((-1.0, pairs.a, self.reach), (1.0, pairs.b, self.arm_b)):
            # by x, y and angle
            moved = np.stack([np.ones_like(arm), np.full_like(arm, 1j), 1j * arm], axis=-1)
            slopes = sign * self.axis.conj()[..., None] * moved
            rows[:, p, 0, body], rows[:, p, 1, body], rows[:, p, 2, body, 2] = (
                slopes.real,
                slopes.imag,
                sign,
            )
        self.rows = rows[..., :bodies, :].reshape(samples, 3 * count, 3 * bodies)


def from_centre(point: Point) -> tuple[complex, float]:
    """From the centre of mass to a point, in the body's frame [m]: x + i y in the plane, and
    height.
    """
    x, y, z = (*point.body.com, 0.0)[:3]
    return complex(point.x - x, point.y - y), point.z - z


def amount(value: float | BoundLaw, time: np.ndarray) -> np.ndarray:
    """A number, or a signal, over time (samples,)."""
    return (
        np.array([value(t) for t in time.tolist()])
        if isinstance(value, BoundLaw)
        else np.full(time.size, value)
    )


def solve(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solve for all samples (samples, n, k); where a matrix is exactly singular, by least
    squares.
    """
    try:
        return np.linalg.solve(matrix, right)
    except np.linalg.LinAlgError:
        return np.linalg.pinv(matrix) @ right


def _flat(planar: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """(samples, pairs) along + i across, and turn, in the order of the relative coordinates
    (samples, 3 pairs).
    """
    return np.stack([planar.real, planar.imag, turn], axis=-1).reshape(len(planar), -1)
