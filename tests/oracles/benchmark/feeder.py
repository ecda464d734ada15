"""Problem 3 from its page alone: numpy, scipy, and the bodies of multibody.py beside it."""

import math

import numpy as np
from scipy.integrate import solve_ivp

from tests.oracles.benchmark.multibody import Dry, impacts, named

SPEED, CLEARANCE, RADIUS, LENGTH, PIVOT, HEIGHT = (
    10.0 * math.pi,
    1e-4,
    0.01,
    0.02,
    (0.17, -0.09),
    0.08,
)
MASSES = [(0.0942, 3.14e-5), (0.2826, 7.724e-4), (0.314, 1.057e-3), (0.2669, 6.517e-4), (0.5, 1e-4)]
CRANK, ROD, ROCKER, LINK, SLIDER = range(5)
HINGES = {
    "A": (-1, (0.0, 0.0), CRANK, (-0.02, 0.0)),
    "B": (CRANK, (0.02, 0.0), ROD, (-0.08, 0.0)),
    "C": (ROD, (0.08, 0.0), ROCKER, (0.03, 0.0)),
    "D": (-1, PIVOT, ROCKER, (-0.09, 0.0)),
    "E": (ROCKER, (0.09, 0.0), LINK, (-0.075, 0.0)),
    "F": (LINK, (0.075, 0.0), SLIDER, (0.0, 0.0)),
}
SIGMA, MODULUS, STIFFNESS = 2e-6, 1.15e11, 1e10


def start(angle=0.0):
    """Places and rates of the mechanism without clearance, by the circles around its pins."""
    place = np.exp(1j * angle) * 0.04
    arm = complex(*PIVOT) - place
    gap, inner = abs(arm), (0.16**2 - 0.12**2 + abs(arm) ** 2) / (2.0 * abs(arm))
    c = place + arm / gap * (inner + 1j * math.sqrt(0.16**2 - inner**2))
    rocker = (c - complex(*PIVOT)) / 0.12
    e = complex(*PIVOT) + 0.18 * rocker
    f = complex(e.real + math.sqrt(0.15**2 - (HEIGHT - e.imag) ** 2), HEIGHT)
    ways = np.exp(1j * angle), (c - place) / 0.16, rocker, (f - e) / 0.15
    centres = 0.5 * place, 0.5 * (place + c), complex(*PIVOT) + 0.09 * rocker, 0.5 * (e + f), f
    angles = [*(np.angle(w) for w in ways), 0.0]
    q = [x for z, a in zip(centres, angles, strict=True) for x in (z.real, z.imag, a)]
    return Feeder().fitting(q, (SPEED, 0.0, 0.0))


def film(eps, rate, w, viscosity):
    """Pinkus and Sternlicht's force along and across the line of centres."""
    scale, gap = 6.0 * viscosity * LENGTH * RADIUS**3 / CLEARANCE**2, 1.0 - eps**2
    s = math.sqrt(gap) * math.hypot(0.5 * w, rate / eps)
    g = 1.0 + 1.5 * rate / (s + 1.5 * abs(rate))
    along = (
        -scale
        / ((2.0 + eps**2) * gap**1.5)
        * (4.0 * s * eps**2 + (2.0 + eps**2) * math.pi * rate * g)
    )
    return along, scale * math.pi * eps * w * g / ((2.0 + eps**2) * math.sqrt(gap))


def rough(e, rate, across, spins):
    """Film, asperities and contact of a mixed joint, along and across."""
    ratio = (CLEARANCE - e) / SIGMA
    tail, density = (
        0.5 * math.erfc(ratio / math.sqrt(2.0)),
        math.exp(-0.5 * ratio**2) / math.sqrt(2.0 * math.pi),
    )
    mean = SIGMA * (ratio * (1.0 - tail) + density)
    height = math.hypot(mean, 0.02 * SIGMA)
    slope, eps = (1.0 - tail) * mean / height, max(1.0 - height / CLEARANCE, 1e-9)
    w, back = spins - 2.0 * across / (CLEARANCE * eps), min(rate, 0.0) ** 2
    along, aside = film(eps, slope * rate / CLEARANCE, w, 0.001)
    held = (1.0 - slope) ** 4 * back
    along *= 1.0 - held / (back + (w * height) ** 2 + 1e-300)
    third = (ratio**2 + 2.0) * density - (ratio**3 + 3.0 * ratio) * tail
    strength = 16.0 * math.sqrt(2.0) * math.pi / 15.0 * 0.04**2 * math.sqrt(1e-3) * MODULUS
    area = RADIUS * LENGTH * math.sqrt(2.0 * SIGMA / max(e, 0.1 * CLEARANCE))
    load = 5.0 * math.pi / 16.0 * strength * area * third
    return along - load - STIFFNESS * max(e - CLEARANCE, 0.0) ** 1.5, aside


def slopes(rates, state, steps):
    """Jacobian by central differences."""
    each = np.diag(steps)
    return np.column_stack([(rates(state + h) - rates(state - h)) / (2.0 * h.sum()) for h in each])


class Feeder(Dry):
    """The feeder with clearance in some joints, dry or with a law of film forces."""

    def __init__(self, names="", force=None):
        rest, clear = ([h for n, h in HINGES.items() if (n in names) == c] for c in (False, True))
        super().__init__(MASSES, rest, clear, (2, 13, 14), 9.81, CLEARANCE, STIFFNESS, 0.9)
        self.names, self.force = names, force

    def oiled(self, state):
        """Forces of joints with oil, each at the centre of its own circle."""
        for hinge in self.clear:
            arm, arm_b, e, v = self.motion(state, hinge)
            size = math.hypot(*e)
            n = e / size if size > 1e-9 * CLEARANCE else np.array([1.0, 0.0])
            t, spins = (
                np.array([-n[1], n[0]]),
                self.spin(state, hinge[0]) + self.spin(state, hinge[2]),
            )
            along, aside = self.force(max(size, 1e-9 * CLEARANCE), v @ n, v @ t, spins)
            yield hinge[2], arm_b, along * n + aside * t, 0.0
            yield hinge[0], arm, -along * n - aside * t, 0.0

    def flowing(self, state):
        """Slopes of the state with oil."""
        return self.rates(state, list(self.oiled(state)))

    def values(self, state, prefix, time):
        """The printed quantities of a moment when no dry contact is closed."""
        solution = self.accelerations(state, list(self.oiled(state)) if self.force else ())
        named = {"slider_x": state[12], "torque": solution[15 + 2 * len(self.hinges)]}
        for name, hinge in zip(self.names, self.clear, strict=True):
            e = self.motion(state, hinge)[2]
            named |= {f"{name}_x": e[0], f"{name}_y": e[1]}
        if not self.names:
            named["slider_acceleration"] = solution[12]
            for k, name in ((1, "B"), (2, "C"), (4, "E")):
                named[f"force_{name}"] = math.hypot(*solution[15 + 2 * k : 17 + 2 * k])
        return {f"{prefix}{n}_{1e3 * time:g}ms": v for n, v in named.items()}


def solve(rtol=1e-12):
    """Values by quantity."""
    values, ideal = {}, Feeder()
    for time in (0.05, 0.1, 0.15, 0.2):
        values |= ideal.values(start(SPEED * time), "ideal_", time)
    dry = Feeder("BCE")
    scale = np.array([*np.full(15, 1e-4), *np.full(15, 1e-2)])
    at, rows = impacts(dry.moved, dry.depths, start(), 0.005, (0.005,), rtol, scale)
    values |= named(rows, 6, "dry_") | dry.values(at[0.005], "dry_", 0.005)
    wet = Feeder("B", lambda e, v, u, w: film(e / CLEARANCE, v / CLEARANCE, w - 2.0 * u / e, 0.05))
    for one, prefix, times in (
        (wet, "lubricated_", (0.05, 0.1)),
        (Feeder("BCE", rough), "mixed_", (0.025, 0.05)),
    ):
        run = solve_ivp(
            lambda t, y, one=one: one.flowing(y),
            (0.0, times[-1]),
            start(),
            method="Radau",
            rtol=100.0 * rtol,
            atol=100.0 * rtol * scale,
            t_eval=times,
            jac=lambda t, y, one=one: slopes(one.flowing, y, 1e-5 * scale),
        )
        for time, state in zip(times, run.y.T, strict=True):
            values |= one.values(state, prefix, time)
    return values
