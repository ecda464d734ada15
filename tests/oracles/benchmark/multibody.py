"""Planar bodies in absolute coordinates with multipliers, contacts located by scipy's events."""

import numpy as np
from scipy.integrate import solve_ivp

FEWEST = 400  # steps of a motion: none may hide a flight from one impact to the next


class Bodies:
    """Masses (n, 2) [kg, kg m2] and hinges (a, point, b, point); fixed: places of coordinates
    whose acceleration is zero; a: -1 is the ground. State: (x, y, angle) of all, then their rates.
    """

    def __init__(self, masses, hinges, fixed, gravity=0.0):
        self.hinges, self.fixed = hinges, fixed
        self.mass = np.array([m for mass, inertia in masses for m in (mass, mass, inertia)])
        self.weight = self.mass * np.tile([0.0, -gravity, 0.0], len(masses))
        self.rows = 2 * len(hinges) + len(fixed)

    def point(self, state, body, local):
        """Arm, position and velocity of a body's point, in fixed axes."""
        if body < 0:
            return np.zeros(2), np.array(local), np.zeros(2)
        q, v = state[3 * body : 3 * body + 3], state[self.mass.size + 3 * body :][:3]
        c, s = np.cos(q[2]), np.sin(q[2])
        arm = np.array([c * local[0] - s * local[1], s * local[0] + c * local[1]])
        return arm, q[:2] + arm, v[:2] + v[2] * np.array([-arm[1], arm[0]])

    def spin(self, state, body):
        """Angular velocity."""
        return 0.0 if body < 0 else state[self.mass.size + 3 * body + 2]

    def accelerations(self, state, wrenches=()):
        """Accelerations, then multipliers; wrenches: (body, arm of the force, force, torque)."""
        n, row = self.mass.size, 2 * len(self.hinges)
        matrix, right = np.zeros((n + self.rows,) * 2), np.zeros(n + self.rows)
        matrix[range(n), range(n)], right[:n] = self.mass, self.weight
        for k, (*a, b, coordinate) in enumerate(self.hinges):
            for sign, body, at in ((-1.0, *a), (1.0, b, coordinate)):
                if body >= 0:
                    arm, _, _ = self.point(state, body, at)
                    i, j = 3 * body, n + 2 * k
                    matrix[j, i] = matrix[j + 1, i + 1] = sign
                    matrix[j, i + 2], matrix[j + 1, i + 2] = -sign * arm[1], sign * arm[0]
                    right[j : j + 2] += sign * self.spin(state, body) ** 2 * arm
        for k, coordinate in enumerate(self.fixed):
            matrix[n + row + k, coordinate] = 1.0
        matrix[:n, n:] = -matrix[n:, :n].T
        for body, arm, force, torque in wrenches:
            if body >= 0:
                moment = arm[0] * force[1] - arm[1] * force[0] + torque
                right[3 * body : 3 * body + 3] += [*force, moment]
        return np.linalg.solve(matrix, right)

    def rates(self, state, wrenches=()):
        """Slopes of the state."""
        n = self.mass.size
        return np.concatenate([state[n:], self.accelerations(state, wrenches)[:n]])


def impacts(rates, depths, state, end, times, rtol, scale, fewest=FEWEST):
    """Motion with contacts: (state at each time, list of (spot, time, speed, depth, end)).

    rates(state, speeds): with the impact speed of each closed spot, None of an open one;
    depths(state) -> depths and their rates of all spots.
    """
    count, time, at, closed = len(depths(state)[0]), 0.0, {}, {}
    done = []
    while time < end:
        speeds = [closed[i][0] if i in closed else None for i in range(count)]
        events = []
        for i in range(count):
            events.append(lambda t, y, i=i: depths(y)[0][i])
            events[-1].terminal, events[-1].direction = True, -1 if i in closed else 1
        for i in closed:
            events.append(lambda t, y, i=i: depths(y)[1][i])
            events[-1].direction = -1
        run = solve_ivp(
            lambda t, y, s=speeds: rates(y, s),
            (time, end),
            state,
            method="DOP853",
            rtol=rtol,
            atol=rtol * scale,
            events=events,
            dense_output=True,
            max_step=end / fewest,
        )
        at |= {t: run.sol(t) for t in times if time < t < run.t[-1]}
        for k, i in enumerate(closed):
            for y in run.y_events[count + k]:
                closed[i][2] = max(closed[i][2], depths(y)[0][i])
        time, state = run.t[-1], run.y[:, -1]
        for i in range(count):
            if run.t_events[i].size:
                if i in closed:
                    speed, begin, depth = closed.pop(i)
                    done.append((i, begin, speed, depth, time))
                else:
                    closed[i] = [depths(state)[1][i], time, 0.0]
    at |= {t: state for t in times if t >= end}
    return at, sorted(done, key=lambda row: row[1])


def named(rows, count, prefix=""):
    """The first contacts by quantity."""
    values = {}
    for number, (_, begin, speed, depth, end) in enumerate(rows[:count], 1):
        row = {"time": begin, "speed": speed, "depth": depth, "end": end}
        values |= {f"{prefix}impact_{number}_{name}": value for name, value in row.items()}
    return values


def damped(depth, rate, impact, stiffness, restitution):
    """Lankarani and Nikravesh's force."""
    factor = 0.75 * (1.0 - restitution**2) * rate / max(impact, 1e-3)
    return stiffness * max(depth, 0.0) ** 1.5 * max(1.0 + factor, 0.0)


class Dry(Bodies):
    """Bodies with clearance in some hinges: contact with Lankarani and Nikravesh's force, and
    smooth Coulomb friction.

    clear: their hinges; size: clearance [m]; friction: coefficient, of journals with a radius [m].
    """

    def __init__(
        self,
        masses,
        hinges,
        clear,
        fixed,
        gravity,
        size,
        stiffness,
        restitution,
        friction=0.0,
        radius=0.0,
    ):
        super().__init__(masses, hinges, fixed, gravity)
        self.clear, self.size, self.law = clear, size, (stiffness, restitution)
        self.friction, self.radius = friction, radius

    def motion(self, state, hinge):
        """Arms of both points, eccentricity and its rate."""
        a, pa, b, pb = hinge
        (arm, at, speed), (arm_b, at_b, speed_b) = (
            self.point(state, a, pa),
            self.point(state, b, pb),
        )
        return arm, arm_b, at_b - at, speed_b - speed

    def depths(self, state):
        """Depths of the journals in their walls, and rates."""
        moves = [self.motion(state, hinge)[2:] for hinge in self.clear]
        return [np.hypot(*e) - self.size for e, _ in moves], [
            e @ v / max(np.hypot(*e), 1e-99) for e, v in moves
        ]

    def pressed(self, state, speeds):
        """Forces of the closed contacts."""
        wrenches = []
        for hinge, speed in zip(self.clear, speeds, strict=True):
            if speed is None:
                continue
            arm, arm_b, e, v = self.motion(state, hinge)
            size = np.hypot(*e)
            n = e / size
            t, outer = np.array([-n[1], n[0]]), size + self.radius
            load = damped(size - self.size, v @ n, speed, *self.law)
            slip = (
                v @ t
                + self.radius * self.spin(state, hinge[2])
                - outer * self.spin(state, hinge[0])
            )
            rub = -self.friction * load * slip / np.hypot(slip, 1e-3)
            force = -load * n + rub * t
            wrenches += [
                (hinge[2], arm_b, force, self.radius * rub),
                (hinge[0], arm, -force, -outer * rub),
            ]
        return wrenches

    def moved(self, state, speeds):
        """Slopes of the state, for `impacts`."""
        return self.rates(state, self.pressed(state, speeds))

    def fitting(self, places, speeds):
        """State at places (x, y, angle) of all bodies, whose hinges, those with clearance too, stay
        closed; speeds: of the fixed coordinates.
        """
        n, state = self.mass.size, np.array([*places, *np.zeros(len(places))])
        matrix = np.zeros((0, n))
        for a, pa, b, pb in [*self.hinges, *self.clear]:
            units = [np.concatenate([state[:n], unit]) for unit in np.eye(n)]
            columns = [self.point(u, b, pb)[2] - self.point(u, a, pa)[2] for u in units]
            matrix = np.vstack([matrix, np.transpose(columns)])
        matrix = np.vstack([matrix, np.eye(n)[list(self.fixed)]])
        right = [*np.zeros(len(matrix) - len(self.fixed)), *speeds]
        state[n:] = np.linalg.lstsq(matrix, np.array(right), rcond=None)[0]
        return state
