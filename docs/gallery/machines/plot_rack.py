"""
Rack and pinion
===============

A steering rack on a spring. The pinion follows a prescribed motion; the teeth have play.
"""

import math

import clearance as cl


@cl.signal
def steering(time, amplitude, frequency):
    """Angle of the pinion [rad]."""
    return amplitude * (1.0 - math.cos(2.0 * math.pi * frequency * time))


pinion, rack = cl.Body("pinion", 0.3, 5e-5), cl.Body("rack", 2.0, 1e-2, points={"end": (0.12, 0)})
shaft = cl.Revolute(cl.ground, pinion, name="shaft")
slide = cl.Prismatic(cl.ground.at(0, -0.03), rack, name="slide")
teeth = cl.backlash(stiffness=2e7, play=2e-4, dissipation=0.5)
scene = cl.Scene(
    shaft,
    slide,
    cl.Gear(shaft, slide, ratio=0.03, mesh=teeth, name="teeth"),
    cl.SpringDamper(
        cl.ground.at(0.3, -0.03), rack["end"], stiffness=5e3, damping=50.0, free_length=0.2
    ),
    cl.Drive(pinion, motion=steering(amplitude=1.0, frequency=2.0)),
    name="rack",
)
run = cl.simulate(scene, until=1.0)
run.plot.sketch()

# %%
# The rack lags behind by the play wherever the force of the teeth changes its sign:

run.plot.history("rack.x,teeth.force,pinion.torque")
