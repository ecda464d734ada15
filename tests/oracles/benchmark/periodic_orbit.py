"""Problem 9 from its page alone, in two coordinates, angle of the rod and place of the slider:
Newton's method on a turn of scipy's DOP853, slopes by central differences, the fold by multipliers
beside it.
"""

import math

import numpy as np

from tests.oracles.benchmark.multibody import damped, impacts

CRANK, HALF, ROD, RADIUS, CLEARANCE = 0.05, 0.06, (0.21, 2.5e-4), 9e-3, 1e-3
SLIDER, STIFFNESS, RESTITUTION, RUB, SLOW = 0.14, 4.55e10, 0.9, 0.03, 1e-3
RPM, BEGIN = math.pi / 30.0, math.radians(118.0)
SIZES = np.array([1e-4, 1e-5, 1e-1, 1e-2])  # of the rod's angle, the slider's place, their rates
#: near the motion at 3000 rpm
NEAR = np.array([-0.38563369, 0.08767838, 66.929530, -11.263738])
CLOSE = {  # the same at speeds [rpm] beside the fold
    3940.0: (-0.38565324346, 0.08764683048518, 87.871178239, -14.8633909004),
    3941.5: (-0.38565503669, 0.08764654417815, 87.892231283, -14.8698086244),
    3941.8: (-0.38565570060, 0.08764644187478, 87.894246335, -14.8712167218),
}
STEP = 3e-3  # of central differences, over the sizes
UNITS = {"fold": "rpm"}


class Crank:
    """The slider-crank at a speed [rad/s]; state: rod's angle, slider's place, rates, crank."""

    def __init__(self, speed):
        self.speed = speed

    def relative(self, state):
        """Eccentricity, its rate, and the direction of the rod."""
        rod, slider, turning, sliding, crank = state
        u = complex(math.cos(rod), math.sin(rod))
        pin = CRANK * complex(math.cos(crank), math.sin(crank))
        e = slider - pin - 2.0 * HALF * u
        return e, sliding - 1j * self.speed * pin - 2j * HALF * turning * u, u, pin

    def depths(self, state):
        """Depth and its rate."""
        e, v, _, _ = self.relative(state)
        size = abs(e)
        return [size - CLEARANCE], [(e.real * v.real + e.imag * v.imag) / size]

    def load(self, state, impact):
        """Force on the journal, and friction."""
        e, v, _, _ = self.relative(state)
        n, size = e / abs(e), abs(e)
        local = v / n
        load = damped(size - CLEARANCE, local.real, impact, STIFFNESS, RESTITUTION)
        slip = local.imag - (size + RADIUS) * state[2]
        rub = -RUB * load * slip / math.hypot(slip, SLOW)
        return (-load + 1j * rub) * n, rub, size

    def rates(self, state, speeds):
        """Slopes of the state."""
        _, _, u, pin = self.relative(state)
        force, torque = 0j, 0.0
        if speeds[0] is not None:
            force, rub, size = self.load(state, speeds[0])
            torque = -(size + RADIUS) * rub
        centripetal = -(self.speed**2) * pin + 9.81j
        moment = torque - 2.0 * HALF * (u.conjugate() * force).imag
        moment -= ROD[0] * HALF * (u.conjugate() * centripetal).imag
        bending = moment / (ROD[1] + ROD[0] * HALF**2)
        return np.array([state[2], state[3], bending, force.real / SLIDER, self.speed])

    def passed(self, y, begin=BEGIN, span=0.0, times=(), rtol=1e-12):
        """State after a span, a turn where none is given; states at times, contacts."""
        span = span or 2.0 * math.pi / self.speed
        start, scale = np.array([*y, begin]), np.array([1e-3, 1e-3, 1.0, 1.0, 1.0])
        stops = (*times, span)
        fewest = 50.0 * max(1.0, span * self.speed / (2.0 * math.pi))
        at, rows = impacts(self.rates, self.depths, start, span, stops, rtol, scale, fewest)
        return at[span][:4], at, rows

    def slopes(self, y, rtol=1e-12):
        """Jacobian of the map of a turn."""
        columns = []
        for d in np.diag(STEP * SIZES):
            after, before = (self.passed(z, rtol=rtol)[0] for z in (y + d, y - d))
            columns.append((after - before) / (2.0 * d.sum()))
        return np.array(columns).T


def closed(speed, y, rtol=1e-12):
    """Periodic state near y, and the slopes of its map."""
    crank = Crank(speed)
    for _ in range(12):
        off, slopes = crank.passed(y, rtol=rtol)[0] - y, crank.slopes(y, rtol)
        move = np.linalg.solve(slopes - np.eye(4), -off)
        y = y + move
        if np.abs(move / SIZES).max() < 1e-2:  # the next move is its square
            break
    return y, slopes


def fold():
    """Speed [rpm] at which the motion of one turn ends, where its largest multiplier m comes to 1:
    (1 - m)^2 goes to zero with the speed, by a parabola through three motions; within 0.1 rpm.
    """
    off = [
        (1.0 - np.linalg.eigvals(closed(speed * RPM, np.array(y), 1e-10)[1]).real.max()) ** 2
        for speed, y in CLOSE.items()
    ]
    return np.polyval(np.polyfit(1e2 * np.array(off), list(CLOSE), 2), 0.0)


def solve(rtol=1e-12):
    """Values by quantity."""
    speed = 3000.0 * RPM
    y, slopes = closed(speed, NEAR)
    crank = Crank(speed)
    times = [(math.radians(a) - BEGIN) / speed for a in (360.0, 450.0, 180.0, 270.0)]
    _, at, rows = crank.passed(y, times=times)
    values = {}
    for name, time in zip(("0", "90", "180", "270"), times, strict=True):
        e = crank.relative(at[time])[0]
        values |= {f"x_{name}deg": e.real, f"y_{name}deg": e.imag}
    ((_, begin, impact, depth, end),) = rows
    values |= {"impact_speed": impact, "impact_depth": depth, "impact_time": begin + BEGIN / speed}
    values["impact_end"] = end + BEGIN / speed
    first, _, third, _ = sorted(np.linalg.eigvals(slopes), key=lambda m: (-abs(m), m.imag))
    values |= {"multiplier_1_real": first.real, "multiplier_1_imaginary": abs(first.imag)}
    return values | {"multiplier_3": third.real, "fold": fold()}
