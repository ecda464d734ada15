"""Problem 1 from its page alone: numpy and scipy."""

import numpy as np
from scipy.integrate import solve_ivp

MASS, GRAVITY, CLEARANCE, STIFFNESS, RESTITUTION = 0.5, 9.81, 1e-4, 1e9, 0.8
END, TIMES = 0.04, (0.01, 0.02, 0.03, 0.04)


def depth(_, state):
    """Depth of the journal in the wall, negative in flight."""
    return np.hypot(*state[:2]) - CLEARANCE


def outward(_, state):
    """Speed along the line of centres."""
    return state[:2] @ state[2:] / np.hypot(*state[:2])


def rates(time, state, impact):
    """Velocity and acceleration; impact: speed of the contact under way, None in flight."""
    force = np.zeros(2)
    if impact is not None:
        deep = max(depth(time, state), 0.0)
        factor = 0.75 * (1.0 - RESTITUTION**2) * outward(time, state) / max(impact, 1e-3)
        load = STIFFNESS * deep**1.5 * max(1.0 + factor, 0.0)
        force = -load * state[:2] / np.hypot(*state[:2])
    return np.concatenate([state[2:], force / MASS - [0.0, GRAVITY]])


def solve(rtol=1e-12):
    """Values by quantity."""
    values, time, state, impact, count = {}, 0.0, np.array([3e-5, 0.0, 0.0, 0.0]), None, 0
    wall, turning = (lambda t, y, _: depth(t, y)), (lambda t, y, _: outward(t, y))
    wall.terminal = True
    while time < END:
        wall.direction = 1 if impact is None else -1
        turning.direction = -1
        options = {"method": "DOP853", "rtol": rtol, "atol": 1e-3 * rtol * CLEARANCE}
        run = solve_ivp(
            rates,
            (time, END),
            state,
            args=(impact,),
            events=(wall, turning),
            dense_output=True,
            **options,
        )
        for at in TIMES:
            if time < at <= run.t[-1]:
                name, position = f"{1e3 * at:g}ms", run.sol(at) if at < run.t[-1] else run.y[:, -1]
                values |= {f"x_{name}": position[0], f"y_{name}": position[1]}
        if impact is not None:
            deepest = max(depth(0.0, y) for y in run.y_events[1])
            values |= {f"impact_{count}_depth": deepest, f"impact_{count}_end": run.t[-1]}
        time, state = run.t[-1], run.y[:, -1]
        if impact is None and time < END:
            count, impact = count + 1, outward(time, state)
            values |= {f"impact_{count}_time": time, f"impact_{count}_speed": impact}
        else:
            impact = None
    return values
