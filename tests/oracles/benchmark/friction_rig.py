"""Problem 8 from its page alone: the journal's equilibrium by scipy's root finding."""

import math

import numpy as np
from scipy.optimize import brentq

RADIUS, CLEARANCE, LENGTH, VISCOSITY, SIGMA = 0.02, 4e-5, 0.01, 0.02, 5e-7
LOAD, MODULUS, RUB, SLOW = 500.0, 1.15e11, 0.1, 1e-3
SPEEDS = 0.3, 1.0, 3.0, 10.0, 30.0, 100.0


def forces(e, speed):
    """Along and across the line of centres, and the torque of the shaft."""
    ratio = (CLEARANCE - e) / SIGMA
    tail = 0.5 * math.erfc(ratio / math.sqrt(2.0))
    density = math.exp(-0.5 * ratio**2) / math.sqrt(2.0 * math.pi)
    height = math.hypot(SIGMA * (ratio * (1.0 - tail) + density), 0.02 * SIGMA)
    eps = 1.0 - height / CLEARANCE
    scale = VISCOSITY * RADIUS * LENGTH**3 / (2.0 * CLEARANCE**2) * eps * speed
    along = -scale * 2.0 * eps / (1.0 - eps**2) ** 2
    across = scale * 0.5 * math.pi / (1.0 - eps**2) ** 1.5
    third = (ratio**2 + 2.0) * density - (ratio**3 + 3.0 * ratio) * tail
    strength = 16.0 * math.sqrt(2.0) * math.pi / 15.0 * 0.04**2 * math.sqrt(1e-3) * MODULUS
    area = RADIUS * LENGTH * math.sqrt(2.0 * SIGMA / e)
    load = 5.0 * math.pi / 16.0 * strength * area * max(third, 0.0) * (ratio < 12.0)
    load += 1e10 * max(e - CLEARANCE, 0.0) ** 1.5
    slide = RADIUS * speed
    rub = -RUB * load * slide / math.hypot(slide, SLOW)
    drag = 2.0 * math.pi * VISCOSITY * RADIUS**3 * LENGTH * speed
    drag /= CLEARANCE * math.sqrt(1.0 - eps**2)
    return along - load, across + rub, drag + 0.5 * e * across - RADIUS * rub


def solve(rtol=None):
    """Values by quantity."""
    values = {}
    for speed in SPEEDS:

        def off(x, speed=speed):
            return np.hypot(*forces(x * CLEARANCE, speed)[:2]) - LOAD

        ratio = brentq(off, 0.5, 1.0, xtol=1e-15, rtol=1e-14)
        along, across, torque = forces(ratio * CLEARANCE, speed)
        name = f"{speed:g}"
        values |= {f"ratio_{name}": ratio, f"torque_{name}": torque}
        values[f"attitude_{name}"] = math.atan2(across, -along)
    return values
