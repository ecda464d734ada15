"""
Six-bar feeder
==============

The rocking feeder at 300 rpm with three dry joints: impacts at each change of the load.
"""

import clearance as cl

scene = cl.load_case("six_bar_feeder", model="dry", joints="B,C,E", clearance=2e-4)
run = cl.simulate(scene, turns=3)
run.plot.sketch()

# %%
# The acceleration of the slider is that of ideal joints with peaks upon it:

ideal = cl.simulate(cl.load_case("six_bar_feeder", model="ideal"), turns=3)
cl.plot([run, ideal], "history", channels="slider.ax", along="angle", last=1)
