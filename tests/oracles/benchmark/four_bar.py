"""Problem 4 from its page alone: all bodies in absolute coordinates with multipliers, and scipy's
DOP853.
"""

import math

import numpy as np

from tests.oracles.benchmark.multibody import Dry, impacts, named

SPEED, FRAME, BARS = 10.0 * math.pi, 0.16, (0.05, 0.15, 0.12)


def bar(length):
    """Mass and inertia of a steel bar of 20 mm x 10 mm with 10 mm beyond its pins."""
    mass = 7850.0 * 0.02 * 0.01 * (length + 0.02)
    return mass, mass * ((length + 0.02) ** 2 + 0.02**2) / 12.0


def solve(rtol=1e-12):
    """Values by quantity."""
    crank, coupler, rocker = ([(-0.5 * b, 0.0), (0.5 * b, 0.0)] for b in BARS)
    clear = [(0, crank[1], 1, coupler[0]), (1, coupler[1], 2, rocker[1])]
    clear += [(-1, (FRAME, 0.0), 2, rocker[0])]
    fixed, rest = (2,), [(-1, (0.0, 0.0), 0, crank[0])]
    options = {"friction": 0.1, "radius": 0.01}
    bodies = Dry([*map(bar, BARS)], rest, clear, fixed, 9.81, 1e-4, 1e10, 0.6, **options)
    gap = FRAME - BARS[0]
    along = (BARS[1] ** 2 - BARS[2] ** 2 + gap**2) / (2.0 * gap)
    c = complex(BARS[0] + along, math.sqrt(BARS[1] ** 2 - along**2))
    ways = 1.0, (c - BARS[0]) / BARS[1], (c - FRAME) / BARS[2]
    centres = 0.5 * BARS[0], 0.5 * (BARS[0] + c), 0.5 * (FRAME + c)
    pairs = zip(centres, ways, strict=True)
    places = [x for z, w in pairs for x in (z.real, z.imag, np.angle(w))]
    scale = np.array([*np.full(9, 1e-4), *np.full(9, 1e-2)])
    start = bodies.fitting(places, (SPEED,))
    at, rows = impacts(bodies.moved, bodies.depths, start, 6e-3, (3e-3, 6e-3), rtol, scale)
    values = named(rows, 8)
    for time, state in at.items():
        values |= {
            f"coupler_angle_{1e3 * time:g}ms": state[5],
            f"rocker_angle_{1e3 * time:g}ms": state[8],
        }
    return values
