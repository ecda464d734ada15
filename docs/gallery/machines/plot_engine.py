"""
Engine with gas force
=====================

A four-stroke engine at 3000 rpm. The gas force on the piston is a law of time of one's
own. The small end has an oil film, which ignition squeezes.
"""

import math

import clearance as cl

SPEED, THROW, ROD, BORE = cl.rpm(3000), 0.04, 0.13, 0.08


@cl.signal
def gas(time, area, speed):
    """Force of the gas on the piston [N]: compression and expansion, one firing in two turns."""
    angle = speed * time
    to_firing = angle - 4.0 * math.pi * math.floor(angle / (4.0 * math.pi)) - 2.0 * math.pi
    volume = 0.12 + 0.5 * (1.0 - math.cos(to_firing))
    pressure = 1e5 * (1.12 / volume) ** 1.32 * (1.0 + 2.2 / (1.0 + math.exp(-8.0 * to_firing)))
    valve = 0.5 + 0.5 * math.tanh(6.0 * (2.6 - abs(to_firing)))  # closed around the firing
    return -area * (valve * pressure + (1.0 - valve) * 1e5 - 1e5)


crank = cl.Body("crank", 2.0, 5e-3, points={"main": (0, 0), "pin": (THROW, 0)})
rod = cl.Body("rod", 0.6, 2e-3, points={"big": (0, 0), "small": (ROD, 0)}, com=(0.04, 0))
piston = cl.Body("piston", 0.5, 5e-4, points={"pin": (0, 0)})
scene = cl.Scene(
    cl.Revolute(cl.ground, crank["main"], name="main"),
    cl.Revolute(crank["pin"], rod["big"], name="big_end"),
    cl.ClearanceRevolute(
        rod["small"],
        piston["pin"],
        name="small_end",
        radius=0.011,
        clearance=2e-5,
        length=0.03,
        film=cl.table_film(),
        lubricant=cl.Lubricant(0.02),
    ),
    cl.Prismatic(cl.ground, piston["pin"], name="bore"),
    cl.Force(piston["pin"], x=gas(area=math.pi / 4 * BORE**2, speed=SPEED)),
    cl.Drive(crank, speed=SPEED, start=0.0),
    name="engine",
)
run = cl.simulate(scene, turns=4)
run.plot.sketch()

# %%
# Two turns: the path of the small end's journal, and its film.

run.plot.orbit("small_end")

# %%
gap = run.extreme("joints/small_end/gap_min", begin=0.04)
print(f"thinnest film {1e6 * gap.value:.2f} um, at {1e3 * gap.time:.1f} ms")
run.plot.history("small_end.force,small_end.gap,crank.torque", along="angle", last=2)
