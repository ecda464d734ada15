"""
Scotch yoke that knocks
=======================

A crank pin drives a yoke by a slot. The motion is a sine, but the pin has 0.1 mm of play
on either side. Twice a turn it changes the wall.
"""

import clearance as cl

crank = cl.Body("crank", 0.3, 1e-4, points={"shaft": (0, 0), "pin": (0.04, 0)})
yoke = cl.Body("yoke", 1.0, 1e-3, points={"slot": (0, 0), "end": (0.12, 0)})
slot = cl.ClearancePinSlot(
    yoke["slot"],
    crank["pin"],
    axis=(0, 1),
    radius=0.008,
    clearance=1e-4,
    length=0.02,
    contact=cl.lankarani_nikravesh(restitution=0.7),
    friction=cl.coulomb_tanh(coefficient=0.08),
    name="slot",
)
scene = cl.Scene(
    cl.Revolute(cl.ground, crank["shaft"], name="shaft"),
    slot,
    cl.Prismatic(cl.ground, yoke["slot"], name="guide"),
    cl.Drive(crank, speed=cl.rpm(600), start=0.0),
    gravity=(0, 0),
    name="scotch_yoke",
)
run = cl.simulate(scene, turns=3)
run.plot.sketch()

# %%
# The acceleration of the yoke, and the pin across the slot:

run.plot.history("yoke.ax,slot.offset", along="angle", last=2)
