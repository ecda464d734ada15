"""Problem 3 from its page alone: numpy and scipy. Vectors are complex numbers; all points of bodies
lie on their first axis.
"""

import math

import numpy as np
from scipy.integrate import solve_ivp

W, C, SIGMA = 10.0 * math.pi, 1e-4, 2e-6
BODIES = (0.0942, 3.14e-5), (0.2826, 7.724e-4), (0.314, 1.057e-3), (0.2669, 6.517e-4), (0.5, 1e-4)
MASS = np.array([m for mass, inertia in BODIES for m in (mass, mass, inertia)])
HINGES = {"A": (-1, 0.0, 0, -0.02), "B": (0, 0.02, 1, -0.08), "C": (1, 0.08, 2, 0.03)}
HINGES |= {"D": (-1, 0.17 - 0.09j, 2, -0.09), "E": (2, 0.09, 3, -0.075), "F": (3, 0.075, 4, 0.0)}
FIXED = np.eye(15)[[2, 13, 14]]  # of the crank's angle, and of the slider's height and angle
SIZES = np.repeat([1e-4, 1e-2], 15)
MARGIN = {"dry_": 20.0}  # impacts let errors of any code grow some thousand times


def hinge(s, name):
    """Row of the Jacobian, what its rate adds, place and velocity of point b less a."""
    a, pa, b, pb = HINGES[name]
    row, bias, position = np.zeros(15, complex), 0.0, 0.0
    for sign, i, p in ((-1.0, a, pa), (1.0, b, pb)):
        arm = p if i < 0 else p * np.exp(1j * s[3 * i + 2])
        position += sign * (arm if i < 0 else s[3 * i] + 1j * s[3 * i + 1] + arm)
        if i >= 0:
            row[3 * i : 3 * i + 3] += sign * np.array([1.0, 1j, 1j * arm])
            bias += sign * s[3 * i + 17] ** 2 * arm
    return row, bias, position, row @ s[15:]


def motion(s, names="", force=None):
    """Accelerations and multipliers; force(name, e, e', spins) on the journals of clear joints."""
    rows, biases = zip(*(hinge(s, n)[:2] for n in HINGES if n not in names), strict=True)
    jacobian = np.vstack([np.real(rows), np.imag(rows), FIXED])
    right = [MASS * np.tile([0.0, -9.81, 0.0], 5), np.real(biases), np.imag(biases), np.zeros(3)]
    for name in names:
        row, _, e, v = hinge(s, name)
        spins = s[3 * HINGES[name][0] + 17] + s[3 * HINGES[name][2] + 17]
        right[0] = right[0] + (np.conj(force(name, e, v, spins)) * row).real
    zero = np.zeros((len(jacobian),) * 2)
    return np.linalg.solve(
        np.block([[np.diag(MASS), -jacobian.T], [jacobian, zero]]), np.concatenate(right)
    )


def start(angle=0.0):
    """The mechanism without clearance, by the circles around its pins."""
    pin, pivot = 0.04 * np.exp(1j * angle), 0.17 - 0.09j
    arm = pivot - pin
    inner = (0.16**2 - 0.12**2 + abs(arm) ** 2) / (2.0 * abs(arm))
    c = pin + arm / abs(arm) * (inner + 1j * math.sqrt(0.16**2 - inner**2))
    e = pivot + 1.5 * (c - pivot)
    f = e.real + math.sqrt(0.15**2 - (0.08 - e.imag) ** 2) + 0.08j
    ways = np.angle([pin, c - pin, c - pivot, f - e, 1.0])
    centres = np.array([pin / 2, (pin + c) / 2, (pivot + e) / 2, (e + f) / 2, f])
    s = np.concatenate([np.column_stack([centres.real, centres.imag, ways]).ravel(), np.zeros(15)])
    rows = [hinge(s, n)[0] for n in HINGES]
    s[15:] = np.linalg.solve(
        np.vstack([np.real(rows), np.imag(rows), FIXED]), [0.0] * 12 + [W, 0, 0]
    )
    return s


def film(eps, rate, w, mu):
    """Pinkus and Sternlicht's force along and across the line of centres."""
    scale, gap, thick = 6.0 * mu * 0.02 * 0.01**3 / C**2, 1.0 - eps**2, 2.0 + eps**2
    turn = math.sqrt(gap) * math.hypot(0.5 * w, rate / eps)
    g = 1.0 + 1.5 * rate / (turn + 1.5 * abs(rate))
    along = -scale / (thick * gap**1.5) * (4.0 * turn * eps**2 + thick * math.pi * rate * g)
    return along, scale * math.pi * eps * w * g / (thick * math.sqrt(gap))


def oiled(name, e, v, spins):
    """Force of the lubricated joint."""
    size, n = max(abs(e), 1e-9 * C), e / abs(e) if abs(e) > 1e-9 * C else 1.0
    local = v * np.conj(n)
    return complex(*film(size / C, local.real / C, spins - 2.0 * local.imag / size, 0.05)) * n


def mixed(name, e, v, spins):
    """Force of a mixed joint."""
    size, n = max(abs(e), 1e-9 * C), e / abs(e) if abs(e) > 1e-9 * C else 1.0
    local, ratio = v * np.conj(n), (C - size) / SIGMA
    tail = 0.5 * math.erfc(ratio / math.sqrt(2.0))
    density = math.exp(-0.5 * ratio**2) / math.sqrt(2.0 * math.pi)
    mean = SIGMA * (ratio * (1.0 - tail) + density)
    height = math.hypot(mean, 0.02 * SIGMA)
    slope, eps = (1.0 - tail) * mean / height, max(1.0 - height / C, 1e-9)
    w, back = spins - 2.0 * local.imag / (C * eps), min(local.real, 0.0) ** 2
    along, across = film(eps, slope * local.real / C, w, 0.001)
    along *= 1.0 - (1.0 - slope) ** 4 * back / (back + (w * height) ** 2 + 1e-300)
    strength = 16.0 * math.sqrt(2.0) * math.pi / 15.0 * 0.04**2 * math.sqrt(1e-3) * 1.15e11
    area = 0.01 * 0.02 * math.sqrt(2.0 * SIGMA / max(size, 0.1 * C))
    third = (ratio**2 + 2.0) * density - (ratio**3 + 3.0 * ratio) * tail
    load = 5.0 * math.pi / 16.0 * strength * area * third + 1e10 * max(size - C, 0.0) ** 1.5
    return (along - load + 1j * across) * n


def dry(rtol):
    """State at 5 ms, and the contacts by their begins: time, speed, depth, end."""

    def depth(s, name):
        return abs(hinge(s, name)[2]) - C

    def rate(s, name):
        e, v = hinge(s, name)[2:]
        return (np.conj(e) * v).real / abs(e)

    def force(name, e, v, spins):
        if name not in closed:
            return 0.0
        n = e / abs(e)
        factor = 0.75 * (1.0 - 0.9**2) * (np.conj(n) * v).real / max(closed[name][1], 1e-3)
        return -1e10 * max(abs(e) - C, 0.0) ** 1.5 * max(1.0 + factor, 0.0) * n

    time, s, closed, done = 0.0, start(), {}, []
    while time < 0.005:
        events = [lambda t, s, n=n: depth(s, n) for n in "BCE"]
        events += [lambda t, s, n=n: rate(s, n) for n in closed]
        for event, name in zip(events, "BCE", strict=False):
            event.terminal, event.direction = True, -1 if name in closed else 1
        options = {"rtol": rtol, "atol": rtol * SIZES, "events": events, "max_step": 1e-5}
        run = solve_ivp(
            lambda t, s: [*s[15:], *motion(s, "BCE", force)[:15]],
            (time, 0.005),
            s,
            "DOP853",
            **options,
        )
        time, s = run.t[-1], run.y[:, -1]
        for name, states in zip(closed, run.y_events[3:], strict=True):
            closed[name][2] = max([closed[name][2], *(depth(y, name) for y in states)])
        for name, times in zip("BCE", run.t_events, strict=False):
            if times.size and name in closed:
                done.append((*closed.pop(name), time))
            elif times.size:
                closed[name] = [time, rate(s, name), 0.0]
    return s, sorted(done)


def printed(s, prefix, time, names="", force=None):
    """Values of a moment by quantity."""
    solution, at = motion(s, names, force), f"_{1e3 * time:g}ms"
    values = {"slider_x": s[12], "torque": solution[-3]}
    for name in names:
        e = hinge(s, name)[2]
        values |= {f"{name}_x": e.real, f"{name}_y": e.imag}
    if not names:
        values["slider_acceleration"] = solution[12]
        forces = {n: np.hypot(solution[15 + k], solution[21 + k]) for k, n in enumerate(HINGES)}
        values |= {f"force_{n}": forces[n] for n in "BCE"}
    return {f"{prefix}_{name}{at}": value for name, value in values.items()}


def solve(rtol=1e-12):
    """Values by quantity."""
    values = {}
    for time in (0.05, 0.1, 0.15, 0.2):
        values |= printed(start(W * time), "ideal", time)
    s, contacts = dry(rtol)
    values |= printed(s, "dry", 0.005, "BCE", lambda *_: 0.0)
    for n, row in enumerate(contacts[:6], 1):
        pairs = zip(("time", "speed", "depth", "end"), row, strict=True)
        values |= {f"dry_impact_{n}_{field}": value for field, value in pairs}
    for prefix, names, force, times in (
        ("lubricated", "B", oiled, (0.05, 0.1)),
        ("mixed", "BCE", mixed, (0.025, 0.05)),
    ):

        def rates(t, s, names=names, force=force):
            return np.concatenate([s[15:], motion(s, names, force)[:15]])

        def slopes(t, s, rates=rates):
            steps = np.diag(1e-5 * SIZES)
            return np.column_stack(
                [(rates(t, s + h) - rates(t, s - h)) / (2.0 * h.sum()) for h in steps]
            )

        options = {"rtol": 100.0 * rtol, "atol": 100.0 * rtol * SIZES, "t_eval": times}
        run = solve_ivp(rates, (0.0, times[-1]), start(), "Radau", jac=slopes, **options)
        for time, s in zip(times, run.y.T, strict=True):
            values |= printed(s, prefix, time, names, force)
    return values
