"""Problem 5 from its page alone: all bodies in absolute coordinates with multipliers, and scipy's
DOP853.
"""

import numpy as np

from tests.oracles.benchmark.multibody import Bodies, damped, impacts, named

CRANK, ROD = 0.153, 0.306
HALF, RISE, CLEARANCE = 0.05, 0.025, 1e-3
MASSES = [(0.038, 7.4e-5), (0.038, 5.9e-4), (0.076, 2.7e-6)]
HINGES = [(-1, (0.0, 0.0), 0, (-0.5 * CRANK, 0.0)), (0, (0.5 * CRANK, 0.0), 1, (-0.5 * ROD, 0.0))]
HINGES += [(1, (0.5 * ROD, 0.0), 2, (0.0, 0.0))]
CORNERS = [(-HALF, -RISE), (HALF, -RISE), (-HALF, RISE), (HALF, RISE)]


def solve(rtol=1e-12):
    """Values by quantity."""
    bodies = Bodies(MASSES, HINGES, (), 9.81)

    def corners(state):
        for x, y in CORNERS:
            arm, position, speed = bodies.point(state, 2, (x, y))
            side = 1.0 if y > 0.0 else -1.0
            yield arm, side, side * position[1] - RISE - CLEARANCE, side * speed[1], speed[0]

    def depths(state):
        return zip(*((depth, rate) for _, _, depth, rate, _ in corners(state)), strict=True)

    def rates(state, speeds):
        wrenches = []
        for (arm, side, depth, rate, slip), speed in zip(corners(state), speeds, strict=True):
            if speed is not None:
                load = damped(depth, rate, speed, 1e8, 0.9)
                rub = -0.01 * load * slip / np.hypot(slip, 1e-3)
                wrenches.append((2, arm, np.array([rub, -side * load]), 0.0))
        return bodies.rates(state, wrenches)

    def both(state):
        return [list(x) for x in depths(state)]

    places = [0.5 * CRANK, 0.0, 0.0, CRANK + 0.5 * ROD, 0.0, 0.0, CRANK + ROD, 0.0, 0.0]
    spins = 150.0, -75.0
    speeds = [0.0, 0.5 * CRANK * spins[0], spins[0], 0.0, CRANK * spins[0] + 0.5 * ROD * spins[1]]
    speeds += [spins[1], 0.0, CRANK * spins[0] + ROD * spins[1], -0.01]
    scale = np.array([*np.full(9, 1e-3), *np.full(9, 1e-1)])
    state = np.array([*places, *speeds])
    at, rows = impacts(rates, both, state, 0.03, (0.01, 0.02, 0.03), rtol, scale)
    values = named(rows, 6)
    for time, y in at.items():
        row = {"crank_angle": y[2], "crank_speed": y[11], "offset": y[7], "tilt": y[8]}
        values |= {f"{name}_{1e3 * time:g}ms": value for name, value in row.items()}
    return values
