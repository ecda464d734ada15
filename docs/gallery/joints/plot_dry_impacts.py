"""
Impacts in a dry joint
======================

The piston pin of a slider-crank has a clearance of 0.5 mm and no oil. Impacts are events:
the run locates where each one begins and ends.
"""

import clearance as cl

scene = cl.load_case("slider_crank", model="dry", speed=cl.rpm(2000), clearance=5e-4)
run = cl.simulate(scene, turns=4)
print(
    len(run.events["time"]),
    "contacts, the strongest with",
    round(run.events["peak_force"].max()),
    "N",
)

# %%
# The path of the journal in its clearance circle, in flight and in contact:

run.plot.orbit("C")

# %%
# Impact speeds and forces of all contacts:

run.plot.contacts("C", settle=1)
