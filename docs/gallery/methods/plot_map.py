"""
A map over speed and clearance
==============================

A hundred runs of the lubricated feeder, side by side in vector registers. The same call
again computes only what is missing.
"""

import tempfile

import numpy as np

import clearance as cl

points = cl.grid(
    speed=cl.rpm(np.linspace(60, 600, 10)).tolist(), clearance=np.geomspace(2e-5, 5e-4, 10).tolist()
)
fixed = {"model": "mixed", "transition": "fuzzy"}
swept = cl.sweep("six_bar_feeder", points, tempfile.mkdtemp(), fixed=fixed, turns=3, channels=[])
swept.plot.map("joint_B_force_max")

# %%
# Where the film is thinner than the roughness, solids carry:

swept.plot.map("joint_B_film_thickness_ratio_min")
