"""
Walking leg
===========

Jansen's linkage turns a crank into the step of a foot.
"""

import numpy as np

import clearance as cl

A, B, C, D, E, F = 0.38, 0.415, 0.393, 0.401, 0.558, 0.394
G, H, N, J, K, L, M = 0.367, 0.657, 0.49, 0.5, 0.619, 0.078, 0.15


def meet(p, q, a, b):
    """The point at a from p and at b from q, to the left of the way from p to q."""
    way = q - p
    along = (abs(way) ** 2 + a**2 - b**2) / (2 * abs(way))
    return p + way / abs(way) * (along + 1j * np.sqrt(a**2 - along**2))


def link(name, **points):
    """A body through places of the start, which are its own points; 1 kg/m."""
    places = {n: (z.real, z.imag) for n, z in points.items()}
    size = max(abs(p - q) for p in points.values() for q in points.values())
    middle = sum(points.values()) / len(points)
    return cl.Body(name, size, size**3 / 12, points=places, com=(middle.real, middle.imag))


o, p, q = 0j, M + 0j, -A - 1j * L
t, u = meet(q, p, B, J), meet(p, q, K, C)
s = meet(q, t, D, E)
v = meet(u, s, G, F)
foot = meet(u, v, N, H)
crank, top, low = link("crank", o=o, p=p), link("top", p=p, t=t), link("low", p=p, u=u)
hip, thigh = link("hip", q=q, t=t, s=s), link("thigh", q=q, u=u)
rod, leg = link("rod", s=s, v=v), link("leg", u=u, v=v, foot=foot)
scene = cl.Scene(
    cl.Revolute(cl.ground, crank["o"], name="O"),
    cl.Revolute(crank["p"], top["p"], name="P"),
    cl.Revolute(crank["p"], low["p"], name="P2"),
    cl.Revolute(cl.ground.at(q.real, q.imag), hip["q"], name="Q"),
    cl.Revolute(cl.ground.at(q.real, q.imag), thigh["q"], name="Q2"),
    cl.Revolute(top["t"], hip["t"], name="T"),
    cl.Revolute(low["u"], thigh["u"], name="U"),
    cl.Revolute(hip["s"], rod["s"], name="S"),
    cl.Revolute(rod["v"], leg["v"], name="V"),
    cl.Revolute(thigh["u"], leg["u"], name="W"),
    cl.Drive(crank, speed=cl.rpm(30), start=0.0),
    name="walking_leg",
)
run = cl.simulate(scene, turns=1)
run.plot.sketch()

# %%
# The torque that gravity and the motion of the links need:

run.plot.history("crank.torque", along="angle")
