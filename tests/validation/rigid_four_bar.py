"""Rigid time stepping of the case `four_bar_clearances`: an implementation that shares only the
controller with it.

Bodies and walls are rigid, impacts have restitution 0, Coulomb friction is set-valued; 7
coordinates, no loop is closed. Moreau's midpoint rule: contacts are those whose gap is closed at
the middle of a step; their impulses are solved for by block Gauss-Seidel. First order in the step.
Writes the rows that the tests read (ten seconds):

    python -m tests.validation.rigid_four_bar

Source: Moreau, in Nonsmooth Mechanics and Applications (1988), 1; Jean, Comput. Methods Appl. Mech.
Eng. 177 (1999) 235.
"""

from pathlib import Path
from types import FunctionType

import numpy as np
from numba import njit

from clearance.catalogue import find_case

CASE = find_case("four_bar_clearances").function.__globals__
ROWS = Path(__file__).with_name("rigid_four_bar.csv")
HEADS = ["time", "crank", "coupler", "rocker"]
HEADS += [f"{joint}_{part}" for joint in "BCD" for part in ("x", "y", "across", "along")]
STEP = 2e-6  # s
FRICTION, CLEARANCE, RADIUS = 0.1, 5e-3, 0.055
FRAME = 3.0 + 0.0j  # m
#: of angles of crank, coupler, rocker [kg m2], then places of centres of coupler and rocker [kg]
INERTIA = np.array([1.0 / 3.0, 4.0**2 / 12.0, 2.5**2 / 12.0, 1.0, 1.0, 1.0, 1.0])
#: of the joints B, C, D: body of bearing and of journal (crank 0, coupler 1, rocker 2, frame 3),
#: and arms along them [m]
BODIES = np.array([[1, 0], [2, 1], [3, 2]])
ARMS = np.array([[-2.0, 1.0], [1.25, 2.0], [0.0, -1.25]])
#: the reference run's start [rad, m]; places of the rocker are counted from the frame's pin D
START = np.array(
    [
        1.57082377240798,
        0.353284202062446,
        1.264872058968431,
        1.87645458509765,
        1.691962091335582,
        0.3764686197082958,
        1.191962183453451,
    ]
)


def torque():
    """The case's controller, compiled."""
    names = dict(CASE)
    for name in ("closed", "reduced"):
        names[name] = njit(FunctionType(CASE[name].__code__, names))
    return njit(FunctionType(CASE["passivity"].function.__code__, names))


CONTROL = torque()


@njit
def pins(q):
    """Places of the journals in their bearings (3,), gaps (3,), and rows (6, 7) of closing and
    sliding speeds."""
    centres = np.array([0.0j, q[3] + 1j * q[4], FRAME + q[5] + 1j * q[6], FRAME])
    offsets, gaps, rows = np.zeros(3, np.complex128), np.zeros(3), np.zeros((6, 7))
    for j in range(3):
        for side, sign in ((0, -1.0), (1, 1.0)):
            body, arm = BODIES[j, side], ARMS[j, side]
            offsets[j] += sign * (centres[body] + (arm * np.exp(1j * q[body]) if body < 3 else 0.0))
        outward = offsets[j] / abs(offsets[j])
        gaps[j] = CLEARANCE - abs(offsets[j])
        for side, sign, radius in ((0, -1.0, RADIUS + CLEARANCE), (1, 1.0, RADIUS)):
            body = BODIES[j, side]
            if body == 3:
                continue
            swing = ARMS[j, side] * 1j * np.exp(1j * q[body])
            for k, direction in ((2 * j, -outward), (2 * j + 1, 1j * outward)):
                rows[k, body] += sign * (swing * np.conj(direction)).real
                if body > 0:
                    rows[k, 2 * body + 1] += sign * direction.real
                    rows[k, 2 * body + 2] += sign * direction.imag
            rows[2 * j + 1, body] += sign * radius
    return offsets, gaps, rows


@njit
def impulses(closed, free, coupling):
    """Impulses (6,) across and along the closed contacts, from the speeds without any [N s]."""
    pushes = np.zeros(6)
    for _ in range(1000):
        change = 0.0
        for j in range(3):
            if not closed[j]:
                continue
            n, t = 2 * j, 2 * j + 1
            a, b, d = coupling[n, n], coupling[n, t], coupling[t, t]
            across = free[n] + coupling[n] @ pushes - a * pushes[n] - b * pushes[t]
            along = free[t] + coupling[t] @ pushes - b * pushes[n] - d * pushes[t]
            push, rub = 0.0, 0.0
            if across < 0.0:
                push, rub = (
                    (b * along - d * across) / (a * d - b * b),
                    (b * across - a * along) / (a * d - b * b),
                )
                if abs(rub) > FRICTION * push:
                    sign = np.sign(rub)
                    push = -across / (a + b * FRICTION * sign)
                    rub = sign * FRICTION * push
            change = max(change, abs(push - pushes[n]), abs(rub - pushes[t]))
            pushes[n], pushes[t] = push, rub
        if change < 1e-14:
            break
    return pushes


@njit
def run(step, steps, every):
    """Rows of HEADS, one each `every` steps: angles [rad], places of journals in bearings [m],
    forces [N]."""
    q, v, table = START.copy(), np.zeros(7), np.zeros((steps // every, 16))
    for k in range(1, steps + 1):
        middle = q + 0.5 * step * v
        _, gaps, rows = pins(middle)
        force = np.array([0.0, 0.0, 0.0, 0.0, -9.81, 0.0, -9.81])
        force[0] = CONTROL((k - 0.5) * step, middle[0], v[0], 200.0, 10.0) - 0.5 * 9.81 * np.cos(
            middle[0]
        )
        free = v + step * force / INERTIA
        pushes = impulses(gaps <= 0.0, rows @ free, (rows / INERTIA) @ rows.T)
        v = free + (rows.T @ pushes) / INERTIA
        q = middle + 0.5 * step * v
        if k % every == 0:
            offsets, _, _ = pins(q)
            row = table[k // every - 1]
            row[0], row[1:4] = k * step, q[:3]
            for j in range(3):
                row[4 + 4 * j], row[5 + 4 * j] = offsets[j].real, offsets[j].imag
                row[6 + 4 * j : 8 + 4 * j] = pushes[2 * j : 2 * j + 2] / step
    return table


if __name__ == "__main__":
    steps = round(1.0 / STEP)
    head = f"rigid time stepping, step {STEP:g} s, by python -m tests.validation.rigid_four_bar\n"
    head += (
        "angles [rad], places of the journals in their bearings [m], forces across and along [N]\n"
    )
    np.savetxt(ROWS, run(STEP, steps, steps // 20), "%.9g", ",", header=head + ",".join(HEADS))
