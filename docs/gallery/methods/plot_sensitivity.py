"""
What depends on what
====================

Derivatives of printed numbers by parameters, each with its error: the change for 1 % more
of a parameter.
"""

import clearance as cl

scene = cl.load_case("six_bar_feeder")
run = cl.simulate(scene, turns=2, sensitivity="clearance,viscosity,speed")
run.plot.tornado("joint_B_gap_min,joint_B_force_max")

# %%
gap = run.sensitivities["joint_B_gap_min", "clearance"]
print(f"1 % more clearance changes the smallest gap by {1e9 * gap.change:.1f} nm")
