"""Oil whose viscosity grows with the pressure, and its reduced pressure.

    Barus      mu = mu0 exp(alpha p)
    Roelands   mu = mu0 exp(b ((1 + p / 1.96e8 Pa)^z - 1)),   b = ln mu0 + 9.67,
               z = alpha 1.96e8 Pa / b     (mu0 in Pa s; at p = 0 with the slope of Barus)

A flow H^3 P' mu0 / mu between two places follows from their reduced pressures Q, the integral of
mu0 / mu over P from ambient on. So Reynolds' equation of a gap that the pressure does not open is
the isoviscous one of Q. Q stays below 1 / alpha of Barus: a rigid film has a largest load.

The exponent is at most MOST, so that every state has an answer; P beyond counts with that
viscosity. Units: P in 1/s, see clearance.film.bearing.

Sources: Barus, Am. J. Sci. 45 (1893) 87; Roelands, Correlational aspects of the viscosity-
temperature-pressure relationship of lubricating oils, dissertation, Delft (1966).
"""

import math
from collections import namedtuple

import numpy as np

from clearance.machine.store import njit

MOST = 15.0  # largest logarithm of mu / mu0
ROELANDS = 1.96e8  # pressure of Roelands' law [Pa]
STEPS = 60  # of the inverse, at most

#: alpha and limit, at which the exponent is MOST, in s and 1/s; Roelands' b, z and pressure [1/s],
#: of which b = 0 stands for Barus
Oil = namedtuple("Oil", "alpha limit b z pressure")
#: nodes and weights of the Gauss-Legendre rule on (-1/2, 1/2)
NODES, WEIGHTS = (0.5 * x for x in np.polynomial.legendre.leggauss(16))

compiled = njit(error_model="numpy", _nrt=False)


def oil_of(alpha: float, viscosity: float, scale: float, roelands: bool) -> Oil:
    """The Oil of a pressure-viscosity coefficient [1/Pa]; scale: p / P [Pa s].

    Raises ValueError for a viscosity too small for Roelands' law.
    """
    if alpha == 0.0:
        return Oil(0.0, math.inf, 0.0, 0.0, 1.0)
    if not roelands:
        return Oil(alpha * scale, MOST / (alpha * scale), 0.0, 0.0, 1.0)
    b = math.log(viscosity) + 9.67
    if b <= 0.0:
        raise ValueError(f"roelands: needs a viscosity above 6.32e-5 Pa s, got {viscosity!r}")
    z, pressure = alpha * ROELANDS / b, ROELANDS / scale
    return Oil(alpha * scale, pressure * ((1.0 + MOST / b) ** (1.0 / z) - 1.0), b, z, pressure)


@compiled
def exponent(p, oil):
    """ln(mu / mu0) and its slope at a P not above the oil's limit."""
    if oil.b == 0.0:
        return oil.alpha * p, oil.alpha
    base = max(1.0 + p / oil.pressure, 1e-3)
    power = base**oil.z
    return oil.b * (power - 1.0), oil.b * oil.z * power / (base * oil.pressure)


@compiled
def reduced(p, oil):
    """Q, its slope mu0 / mu, and the slope of ln(mu / mu0), at a P."""
    if oil.alpha == 0.0:
        return p, 1.0, 0.0
    within = min(p, oil.limit)
    thick, rate = exponent(within, oil)
    thin = math.exp(-thick)
    if oil.b == 0.0:
        q = -math.expm1(-thick) / oil.alpha
    else:
        q = 0.0
        for k in range(NODES.size):
            q += WEIGHTS[k] * math.exp(-exponent((0.5 + NODES[k]) * within, oil)[0])
        q *= within
    if p > within:
        return q + thin * (p - within), thin, 0.0
    return q, thin, rate


@compiled
def pressed(q, oil):
    """P of a reduced pressure and mu / mu0 there, complex where it is complex: Newton's method from
    below, which never passes P.
    """
    p, thick, rate = q.real, 1.0, 0.0
    for _ in range(STEPS if oil.alpha > 0.0 else 0):
        reached, thin, rate = reduced(p, oil)
        step = (q.real - reached) / thin
        thick = 1.0 / thin
        p += step
        if abs(step) <= 1e-13 * abs(p):
            break
    rest = (q - q.real) * thick
    return p + rest, thick * (1.0 + rate * rest)
