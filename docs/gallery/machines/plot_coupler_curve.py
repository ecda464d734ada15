"""
Coupler curve of a four-bar
===========================

A point of the coupler moves on a curve of the sixth degree.
"""

import clearance as cl

crank = cl.Body("crank", 0.2, 5e-5, points={"A": (0, 0), "B": (0.04, 0)})
coupler = cl.Body(
    "coupler",
    0.3,
    4e-4,
    points={"B": (0, 0), "C": (0.12, 0), "P": (0.06, 0.05)},
    com=(0.06, 0),
)
rocker = cl.Body(
    "rocker",
    0.3,
    3e-4,
    points={"D": (0, 0), "C": (0.1, 0)},
    com=(0.05, 0),
    angle=1.6,
)
scene = cl.Scene(
    cl.Revolute(cl.ground, crank["A"], name="A"),
    cl.Revolute(crank["B"], coupler["B"], name="B"),
    cl.Revolute(coupler["C"], rocker["C"], name="C"),
    cl.Revolute(cl.ground.at(0.13, 0), rocker["D"], name="D"),
    cl.Drive(crank, speed=cl.rpm(120), start=0.0),
    name="coupler_curve",
)
run = cl.simulate(scene, turns=1)
run.plot.sketch()

# %%
# The torque that the drive needs:

run.plot.history("crank.torque", along="angle")
