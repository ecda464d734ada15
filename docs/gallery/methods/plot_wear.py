"""
The life of a bushing
=====================

A journal turns in a bushing under a load at rest. The bushing wears by Archard's law over
300 turns. Jumps between runs of one turn replay the load path.
"""

import tempfile

import clearance as cl

rotor = cl.Body("rotor", 0.5, 1e-4)
bushing = cl.ClearanceRevolute(
    cl.ground,
    rotor,
    name="B",
    radius=0.01,
    clearance=1e-4,
    length=0.02,
    eccentricity=(1.09e-4, 0.0),
    contact=cl.winkler(layer_modulus=1e12, restitution=0.5),
    wear=cl.archard(coefficient=1e-13),
)
load, drive = cl.Force(rotor.at(0, 0), x=1000.0), cl.Drive(rotor, speed=cl.rpm(60))
scene = cl.Scene(bushing, load, drive, gravity=(0, 0), name="bushing")
life = cl.wear(scene, turns=300, directory=tempfile.mkdtemp(), settle=0, average=1)
cl.plot(life, "life")

# %%
# The depth beside the closed form of a rigid journal under the first load path:

for turns, depth, form in zip(
    life.turns, life.depth("B").max(axis=1), life.closed_form("B"), strict=True
):
    print(f"{turns:5.0f} turns {1e6 * depth:6.2f} um, closed form {1e6 * form:6.2f} um")
