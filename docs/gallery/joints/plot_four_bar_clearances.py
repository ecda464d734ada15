"""
Four-bar with clearance in three joints
=======================================

A controlled four-bar whose dry joints all have play (Akhadkar et al., 2016).
"""

import clearance as cl

run = cl.simulate(cl.load_case("four_bar_clearances"), until=1.0)
run.plot.sketch()

# %%
run.plot.orbit()
