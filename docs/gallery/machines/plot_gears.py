"""
Gear pair with backlash
=======================

A pinion drives a wheel through elastic teeth with a play of 0.1 mm. The load on the
wheel changes its sign, and the teeth knock.
"""

import math

import clearance as cl


@cl.signal
def swinging(time, amplitude, frequency):
    """A torque that swings about zero [N m]."""
    return amplitude * math.sin(2.0 * math.pi * frequency * time)


pinion, wheel = cl.Body("pinion", 0.5, 2e-4), cl.Body("wheel", 2.0, 3e-3)
first = cl.Revolute(cl.ground, pinion, name="A")
second = cl.Revolute(cl.ground.at(0.09, 0), wheel, name="B")
teeth = cl.backlash(stiffness=2e7, play=1e-4, dissipation=0.5)
scene = cl.Scene(
    first,
    second,
    cl.Gear(first, second, ratio=-0.5, mesh=teeth, name="mesh"),
    cl.Torque(wheel, swinging(amplitude=20.0, frequency=25.0)),
    cl.Drive(pinion, speed=cl.rpm(600), start=0.0),
    name="gears",
)
run = cl.simulate(scene, turns=4, samples_per_turn=2000)
run.plot.sketch()

# %%
# The force of the teeth, their deflection, and the speed of the wheel:

run.plot.history("mesh.force,mesh.deflection,wheel.omega", last=1)
