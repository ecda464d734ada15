"""Problem 2 from its page alone: all bodies in absolute coordinates with multipliers, and scipy's
DOP853.
"""

import math

import numpy as np

from tests.oracles.benchmark.multibody import Dry, impacts, named

SPEED = 5000.0 * math.pi / 30.0
MASSES = [(0.30, 6.25e-5), (0.21, 2.5e-4), (0.14, 1e-5)]
HINGES = [(-1, (0.0, 0.0), 0, (-0.025, 0.0)), (0, (0.025, 0.0), 1, (-0.06, 0.0))]
PIN = [(1, (0.06, 0.0), 2, (0.0, 0.0))]


def solve(rtol=1e-12):
    """Values by quantity."""
    bodies = Dry(MASSES, HINGES, PIN, (2, 7, 8), 9.81, 5e-4, 6.6e10, 0.9)
    start = bodies.fitting([0.025, 0.0, 0.0, 0.11, 0.0, 0.0, 0.17, 0.0, 0.0], (SPEED, 0.0, 0.0))
    scale = np.array([*np.full(9, 1e-4), *np.full(9, 1.0)])
    at, rows = impacts(bodies.moved, bodies.depths, start, 2e-3, (1e-3, 2e-3), rtol, scale)
    values = named(rows, 6)
    for time, state in at.items():
        values |= {f"slider_x_{1e3 * time:g}ms": state[6], f"rod_angle_{1e3 * time:g}ms": state[5]}
    return values
