"""
Straight line without a guide
=============================

Peaucellier's linkage of seven bars moves a point on an exact straight line.
"""

import math

import numpy as np

import clearance as cl


@cl.signal
def swing(time, amplitude, frequency):
    """Angle of the crank [rad]."""
    return amplitude * math.sin(2.0 * math.pi * frequency * time)


def bar(name, begin, end):
    """A bar of 1 kg/m between two places."""
    length, angle = abs(end - begin), np.angle(end - begin)
    points = {"a": (0, 0), "b": (length, 0)}
    return cl.Body(name, length, length**3 / 12, points=points, com=(length / 2, 0), angle=angle)


ARM, SIDE, CRANK = 0.14, 0.06, 0.05
origin, A, P = 0j, CRANK + 0j, 2 * CRANK + 0j  # pivots, and the pin of the crank
x = (ARM**2 - SIDE**2 + abs(P) ** 2) / (2 * abs(P))
Q = x + 1j * np.sqrt(ARM**2 - x**2)
R = 2 * x - P
crank = bar("crank", A, P)
upper, lower = bar("upper", origin, Q), bar("lower", origin, Q.conjugate())
pu, pl = bar("pu", P, Q), bar("pl", P, Q.conjugate())
ru, rl = bar("ru", Q, R), bar("rl", Q.conjugate(), R)
scene = cl.Scene(
    cl.Revolute(cl.ground.at(A.real, 0), crank["a"], name="A"),
    cl.Revolute(cl.ground, upper["a"], name="O"),
    cl.Revolute(cl.ground, lower["a"], name="O2"),
    cl.Revolute(crank["b"], pu["a"], name="P"),
    cl.Revolute(crank["b"], pl["a"], name="P2"),
    cl.Revolute(upper["b"], pu["b"], name="Q"),
    cl.Revolute(lower["b"], pl["b"], name="Q2"),
    cl.Revolute(upper["b"], ru["a"], name="S"),
    cl.Revolute(lower["b"], rl["a"], name="S2"),
    cl.Revolute(ru["b"], rl["b"], name="R"),
    cl.Drive(crank, motion=swing(amplitude=0.5, frequency=1.0)),
    name="peaucellier",
)
run = cl.simulate(scene, until=1.0)
run.plot.sketch()

# %%
# How far the last point leaves its line:

theta = run["rl"].theta
end = run["rl"].x + SIDE / 2 * np.cos(theta)
print(f"line at x = {1e3 * end.mean():.3f} mm, off it by at most {1e3 * np.ptp(end):.1e} mm")
