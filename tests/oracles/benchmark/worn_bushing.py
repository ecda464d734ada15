"""Problem 11 from its page alone: the journal's place, the depth and the load by a differential
equation over the way, scipy's DOP853.
"""

import math

from scipy.integrate import solve_ivp
from scipy.optimize import brentq

RADIUS, CLEARANCE, LENGTH = 0.01, 1e-4, 0.02
MODULUS, COEFFICIENT, LOAD = 1e12, 1e-13, 1000.0
BEST = ("depth",)


def carried(e):
    """Load of the unworn layer."""
    half = math.acos(CLEARANCE / e)
    return (
        MODULUS
        * RADIUS
        * LENGTH
        * (e * (half + math.sin(half) * math.cos(half)) - 2.0 * CLEARANCE * math.sin(half))
    )


def rates(way, state):
    """Of the journal's place and of the depth below it, over the angle that the journal turns."""
    e, depth = state
    half = math.acos(CLEARANCE / e)
    sinks = COEFFICIENT * LOAD / (LENGTH * (half + math.sin(half) * math.cos(half)))
    return sinks, COEFFICIENT * MODULUS * (e - CLEARANCE - depth) * RADIUS


def solve(rtol=1e-13):
    """Values by quantity."""
    start = [brentq(lambda e: carried(e) - LOAD, 1.0001e-4, 2e-4, xtol=1e-20, rtol=1e-15), 0.0]
    turns = (10, 100, 1000)
    ways = [2.0 * math.pi * n for n in turns]
    run = solve_ivp(
        rates, (0.0, ways[-1]), start, method="DOP853", rtol=rtol, atol=1e-20, t_eval=ways
    )
    return {f"depth_{n}": depth for n, depth in zip(turns, run.y[1], strict=True)}


def coarser():
    """The same at a looser tolerance."""
    return solve(1e-11)
