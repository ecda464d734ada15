"""
A joint that warms up
=====================

The oil of a bearing takes up the heat of its film and thins. The gap shrinks until as much
heat leaves as comes.
"""

import clearance as cl

rotor = cl.Body("rotor", 4.0, 2e-3)
bearing = cl.ClearanceRevolute(
    cl.ground,
    rotor,
    name="B",
    radius=0.02,
    clearance=3e-5,
    length=0.02,
    film=cl.table_film(),
    lubricant=cl.Lubricant("60 cP"),
    heat=cl.HeatBalance(capacity=0.5, conductance=2.0),
    eccentricity=(0.0, -1e-5),
)
scene = cl.Scene(
    bearing,
    cl.Force(rotor.at(0, 0), y=-800.0),
    cl.Drive(rotor, speed=cl.rpm(3000)),
    name="warm_bearing",
)
run = cl.simulate(scene, turns=60, samples_per_turn=40)
run.plot.orbit("B")

# %%
run.plot.history("B.oil_temperature,B.gap,B.power_loss")
