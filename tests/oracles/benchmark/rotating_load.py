"""Problem 6 from its page alone: scipy's Radau and root finding for the short bearing, polynomials
between the unknown edges of the film for the finite and the elastic one.
"""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from tests.oracles.benchmark.free_edges import Film

MASS, RADIUS, CLEARANCE, VISCOSITY, SPEED, TURNING = 1.0, 0.025, 5e-5, 0.02, 100.0, -50.0
SHORT, LONG, LIGHT, HEAVY, LAYER = 0.0125, 0.025, 200.0, 1000.0, 1e-12
BEST = "finite_", "elastic_"
NODES, WEIGHTS = np.polynomial.legendre.leggauss(100)
WHIRL = MASS * CLEARANCE * TURNING**2  # times the eccentricity ratio: centrifugal force


def short(eps, rate, w, scale):
    """Force of the positive half of a short film, along and across the line of centres."""
    start = np.arctan2(2.0 * rate, eps * abs(w))
    theta = start + 0.5 * np.pi * (NODES + 1.0)
    pressure = (eps * abs(w) * np.sin(theta) - 2.0 * rate * np.cos(theta)) * WEIGHTS
    pressure *= 0.5 * np.pi * scale / (1.0 + eps * np.cos(theta)) ** 3
    return pressure @ np.cos(theta), np.copysign(1.0, w) * (pressure @ np.sin(theta))


def steady(film, load, low=0.5, high=0.8):
    """Eccentricity ratio and lead of a steady orbit; film(eps) -> forces."""

    def held(eps):
        along, across = film(eps)
        return -along - WHIRL * eps, across

    eps = brentq(lambda e: np.hypot(*held(e)) - load, low, high, xtol=1e-14, rtol=1e-13)
    cosine, sine = held(eps)
    return np.array([eps, np.arctan2(sine, cosine)])


def orbit(rtol):
    """Places of the short bearing at 10 and 20 ms."""
    scale = VISCOSITY * RADIUS * SHORT**3 / (2.0 * CLEARANCE**2)

    def rates(time, state):
        e, v = complex(*state[:2]), complex(*state[2:])
        n = e / abs(e)
        along = (v / n).real / CLEARANCE
        w = SPEED - 2.0 * (v / n).imag / abs(e)
        force = complex(*short(abs(e) / CLEARANCE, along, w, scale)) * n
        push = (force + LIGHT * np.exp(1j * TURNING * time)) / MASS
        return [v.real, v.imag, push.real, push.imag]

    run = solve_ivp(
        rates,
        (0.0, 0.02),
        [1e-5, 0.0, 0.0, 0.0],
        method="Radau",
        rtol=rtol,
        atol=rtol * np.array([CLEARANCE, CLEARANCE, 1e-3, 1e-3]),
        t_eval=(0.01, 0.02),
    )
    return {
        f"short_{n}_{t}ms": run.y[i, k]
        for k, t in enumerate((10, 20))
        for i, n in ((0, "x"), (1, "y"))
    }


def finite(degrees, soft):
    """Steady orbit of the finite bearing, with polynomials of some degrees."""
    film = Film(RADIUS / LONG, soft, *degrees)
    scale = VISCOSITY * LONG * RADIUS**3 / CLEARANCE**2
    w = SPEED - 2.0 * TURNING
    return steady(lambda eps: scale * film.solve(eps, 0.0, w), HEAVY, 0.65, 0.72)


def solve(rtol=1e-11, degrees=(40, 16, 8)):
    """Values by quantity."""
    scale, w = VISCOSITY * RADIUS * SHORT**3 / (2.0 * CLEARANCE**2), SPEED - 2.0 * TURNING
    values = orbit(rtol) if rtol else {}
    layer = LAYER * VISCOSITY * (RADIUS / CLEARANCE) ** 2 / CLEARANCE
    pairs = {"short_": steady(lambda eps: short(eps, 0.0, w, scale), LIGHT)}
    pairs |= {"finite_": finite(degrees, 0.0), "elastic_": finite(degrees, layer)}
    for name, (eps, lead) in pairs.items():
        values |= {f"{name}ratio": eps, f"{name}lead": lead}
    return values


def coarser():
    """The same of lower degrees."""
    return solve(0.0, (32, 14, 7))
