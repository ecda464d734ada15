"""
Planetary gear
==============

A carrier bears a planet, which rolls in a ring that stands still and drives a sun. A
torque on the carrier runs the gear up against a brake on the sun. Each mesh is elastic.
"""

import clearance as cl

SUN, PLANET, RING = 0.03, 0.02, 0.07
carrier = cl.Body("carrier", 1.0, 1e-3, points={"O": (0, 0), "P": (SUN + PLANET, 0)})
planet, sun = cl.Body("planet", 0.3, 6e-5), cl.Body("sun", 0.8, 4e-4)
ring = cl.Revolute(carrier["O"], cl.ground, name="O")
axle = cl.Revolute(carrier["P"], planet, name="P")
shaft = cl.Revolute(carrier["O"], sun, name="S")
teeth = {"stiffness": 5e7, "damping": 5e3}
scene = cl.Scene(
    ring,
    axle,
    shaft,
    cl.Gear(axle, ring, ratio=PLANET / RING, **teeth, name="outer"),
    cl.Gear(axle, shaft, ratio=-PLANET / SUN, **teeth, name="inner"),
    cl.TorsionSpring(cl.ground, sun, damping=0.02),
    cl.Drive(carrier, torque=2.0),
    name="planetary",
)
run = cl.simulate(scene, until=0.5)
run.plot.sketch()

# %%
# The sun turns 1 + ring / sun times as fast as the carrier (Willis):

ratio = run["sun"].omega[-1] / run["carrier"].omega[-1]
print(f"ratio {ratio:.6f}, by the teeth {1 + RING / SUN:.6f}")
run.plot.history("sun.omega,inner.force")
