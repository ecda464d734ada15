"""Rigid time stepping of the case `four_bar_clearances`: an implementation that shares only the
controller with it.

Bodies and walls are rigid, impacts have restitution 0, Coulomb friction is set-valued; 7
coordinates, no loop is closed. The rule is that of the reference run: Moreau and Jean's with
theta = 1/2, contacts are those whose gap is closed at the end of a step, and the end is projected
onto them. Their impulses are solved for by block Gauss-Seidel. First order in the step.

Friction of an impact has two laws. Moreau's takes the sliding at its end, as the reference run
does. The other one follows the sliding through the impact, as a stiff contact does (Darboux,
Keller). They differ where an impact turns the sliding round.

`python -m tests.validation.rigid_four_bar` writes the rows that the tests read: of the reference's
step and law, and of a small step with the sliding followed (one minute).

Source: Moreau, in Nonsmooth Mechanics and Applications (1988), 1; Jean, Comput. Methods Appl. Mech.
Eng. 177 (1999) 235; Acary, Comput. Methods Appl. Mech. Eng. 256 (2013) 224, for the projection;
Keller, J. Appl. Mech. 53 (1986) 1, for sliding in impacts.
"""

from pathlib import Path
from types import FunctionType

import numpy as np
from numba import njit

from clearance.scene.catalogue import find_case

CASE = find_case("four_bar_clearances").function.__globals__
FOLDER = Path(__file__).parent
HEADS = ["time", "crank", "coupler", "rocker"]
HEADS += [f"{joint}_{part}" for joint in "BCD" for part in ("x", "y", "across", "along")]
#: step [s] of the rows of each file, and whether they follow the sliding through impacts
RUNS = {"rigid_four_bar.csv": (2e-6, True), "rigid_four_bar_coarse.csv": (1e-4, False)}
TURNING = 1e-4  # m/s, sliding within which friction turns round in impacts, as in the case
TOUCHING = 1e-6  # m, gap to which the end of a step is projected
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
def impact(v, rows, closed):
    """Speeds after the closed contacts have stopped, with friction by the sliding at each moment.

    Pushes grow as their contacts approach, as those of equal dampers do.
    """
    first, v = 0.0, v.copy()
    while True:
        speeds, pushes, fastest = rows @ v, np.zeros(6), 0.0
        for n in range(0, 6, 2):
            if closed[n // 2] and speeds[n] < 0.0:
                pushes[n] = -speeds[n]
                slide = min(1.0, max(-1.0, speeds[n + 1] / TURNING))
                pushes[n + 1] = -FRICTION * slide * pushes[n]
                fastest = max(fastest, pushes[n])
        first = max(first, fastest)
        if fastest <= 1e-7 * first:
            return v
        v = v + 2e-4 * (rows.T @ pushes) / INERTIA


@njit
def loads(time, q, v):
    """Weights and the controller's torque [N m, N]."""
    force = np.array([0.0, 0.0, 0.0, 0.0, -9.81, 0.0, -9.81])
    force[0] = CONTROL(time, q[0], v[0], 200.0, 10.0) - 0.5 * 9.81 * np.cos(q[0])
    return force


@njit
def ended(time, step, q, v, closed):
    """Places, speeds and impulses at the end of a step with these contacts closed: the implicit
    trapezium, by iteration."""
    begin, end = loads(time - step, q, v), v
    while True:
        middle = q + 0.5 * step * (v + end)
        _, _, rows = pins(middle)
        free = v + 0.5 * step * (begin + loads(time, middle, end)) / INERTIA
        pushes = impulses(closed, rows @ free, (rows / INERTIA) @ rows.T)
        last, end = end, free + (rows.T @ pushes) / INERTIA
        if np.abs(end - last).max() < 1e-12:
            return middle, end, pushes


@njit
def projected(q, closed):
    """The nearest places at which the closed contacts touch, and the gaps there."""
    while True:
        _, gaps, rows = pins(q)
        if not closed.any() or np.abs(gaps[closed]).max() < TOUCHING:
            return q, gaps
        across = rows[::2][closed]
        q = q - across.T @ np.linalg.solve((across / INERTIA) @ across.T, gaps[closed]) / INERTIA


@njit
def run(step, steps, every, followed):
    """Rows of HEADS, one each `every` steps: angles [rad], places of journals in bearings [m],
    forces [N]. followed: the sliding through impacts."""
    q, v, table = START.copy(), np.zeros(7), np.zeros((steps // every, 16))
    pushes, before = np.zeros(6), np.zeros(3, np.bool_)
    for k in range(1, steps + 1):
        closed = np.zeros(3, np.bool_)
        while True:
            if followed and (closed & ~before).any():
                v, before = impact(v, pins(q)[2], closed), closed.copy()
            end, speeds, pushes = ended(k * step, step, q, v, closed)
            end, gaps = projected(end, closed)
            if ((gaps > 0.0) | closed).all():
                break
            closed |= gaps <= 0.0
        q, v, before = end, speeds, closed
        if k % every == 0:
            offsets, _, _ = pins(q)
            row = table[k // every - 1]
            row[0], row[1:4] = k * step, q[:3]
            for j in range(3):
                row[4 + 4 * j], row[5 + 4 * j] = offsets[j].real, offsets[j].imag
                row[6 + 4 * j : 8 + 4 * j] = pushes[2 * j : 2 * j + 2] / step
    return table


def second(step, followed):
    """The 20 rows of a second."""
    steps = round(1.0 / step)
    return run(step, steps, steps // 20, followed)


if __name__ == "__main__":
    for name, (step, followed) in RUNS.items():
        friction = "followed through" if followed else "by the end of"
        head = [
            f"rigid time stepping, step {step:g} s, sliding {friction} impacts",
            "angles [rad], places of journals in bearings [m], forces across and along [N];",
            "by python -m tests.validation.rigid_four_bar",
        ]
        head = "\n".join([*head, ",".join(HEADS)])
        np.savetxt(FOLDER / name, second(step, followed), "%.9g", ",", header=head)
