"""
A slide with four corners
=========================

A slider in a guide with 1 mm of play lifts, tilts and touches with its corners (Flores,
Leine and Glocker, 2010).
"""

import clearance as cl

run = cl.simulate(cl.load_case("guide_slider", tilt_rate=0.01), until=0.1)
run.plot.sketch()

# %%
# The block in its guide, its modes of contact, and its path in the polygon of touch:

run.plot.guide()
