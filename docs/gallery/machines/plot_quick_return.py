"""
Quick return
============

A crank turns evenly and moves a block in a slotted lever. The lever swings back faster
than it swings forth.
"""

import numpy as np

import clearance as cl

throw, distance = 0.05, 0.12
crank = cl.Body("crank", 0.2, 5e-5, points={"shaft": (0, 0), "pin": (throw, 0)})
block = cl.Body("block", 0.1, 2e-5, points={"pin": (0, 0)})
lever = cl.Body("lever", 0.5, 2e-3, points={"pivot": (0, 0), "end": (0.22, 0)}, com=(0.1, 0))
scene = cl.Scene(
    cl.Revolute(cl.ground.at(distance, 0), crank["shaft"], name="A"),
    cl.Revolute(crank["pin"], block["pin"], name="B"),
    cl.Revolute(cl.ground, lever["pivot"], name="O"),
    cl.Prismatic(lever["pivot"], block["pin"], name="slot"),
    cl.Drive(crank, speed=cl.rpm(120), start=1.0),
    name="quick_return",
)
run = cl.simulate(scene, turns=1)
run.plot.sketch()

# %%
# The speed of the lever, and the torque that the crank needs:

run.plot.history("lever.omega,crank.torque", along="angle")

# %%
# Shares of the turn in which the lever swings either way, and those of the geometry:

backward = np.mean(run["lever"].omega < 0.0)
geometry = np.arccos(throw / distance) / np.pi
print(f"backward {backward:.2f} of the turn, by the geometry {geometry:.3f}")
