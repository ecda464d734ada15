"""Problem 12 from its page alone: scipy's DOP853 in sections, the energy as a state."""

import numpy as np
from scipy.integrate import solve_ivp

TILT, SPIN = (2.0, 2.5, 0.05, 1000.0, 1.0, 0.05), (1.5, 1.8, 0.08, 700.0, 0.8, 0.04)
KINETIC, STATIC, SPEED, STIFFNESS, DAMPING, VISCOUS = np.transpose([TILT, TILT, SPIN])
UNITS = {"torque_x": "N m", "torque_y": "N m"}
SIZES, SPEEDS = np.array([0.4, 0.3, 1.0]), 2.0 * np.pi * np.array([2.0, 3.0, 1.0])


def parts(time, z):
    """Rates of the joint and of its bristles, and the torque."""
    w = SIZES * np.sin(SPEEDS * time)
    size = np.sqrt(w @ w)
    level = KINETIC + (STATIC - KINETIC) * np.exp(-((size / SPEED) ** 2))
    pull = np.sqrt(((level * w) ** 2).sum())
    bending = w - pull * STIFFNESS * z / level**2
    return w, bending, STIFFNESS * z + DAMPING * bending + VISCOUS * w


def rates(time, state):
    """Slopes of the deflections and of the energy."""
    w, bending, torque = parts(time, state[:3])
    return [*bending, torque @ w]


def solve(rtol=1e-12):
    """Values by quantity."""
    values, state = {}, np.zeros(4)
    for i in range(10):
        # at the middle and the ends all rates are zero, and sizes of them have a kink
        for span in ((0.1 * i, 0.1 * i + 0.05), (0.1 * i + 0.05, 0.1 * (i + 1))):
            run = solve_ivp(rates, span, state, method="DOP853", rtol=rtol, atol=1e-3 * rtol)
            state = run.y[:, -1]
        torque = parts(0.1 * (i + 1), state[:3])[2]
        if i in (0, 2, 5, 8):
            values |= {f"torque_{n}_{i + 1}00ms": torque[k] for k, n in enumerate("xyz")}
    return values | {"energy": state[3]}
