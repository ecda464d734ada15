"""
Whirl of a rotor
================

At 9000 rpm the film of a light rotor is not stable: the journal whirls at half the speed
of the rotor.
"""

import clearance as cl


def rotor(speed):
    """A rigid rotor of 3 kg, its mass 4 um off the centre, in half of its two bearings."""
    body = cl.Body("rotor", 3.0, 1e-3, com=(4e-6, 0))
    bearing = cl.ClearanceRevolute(
        cl.ground,
        body.at(0, 0),
        name="B",
        radius=0.015,
        clearance=8e-5,
        length=0.015,
        film=cl.table_film(),
        lubricant=cl.Lubricant("5 cP"),
    )
    return cl.Scene(bearing, cl.Drive(body, speed=speed), name="rotor")


slow, fast = (cl.simulate(rotor(cl.rpm(n)), turns=40) for n in (1500, 9000))
fast.plot.orbit("B")

# %%
# At 1500 rpm it comes to rest on a small orbit:

slow.plot.orbit("B")

# %%
# The spectrum has its largest line at half the order of the rotor:

fast.plot.spectrum("B.eccentricity_x", settle=20)
