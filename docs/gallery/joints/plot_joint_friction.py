"""
Torques of a prescribed motion
==============================

A five-axis chain moves as its drives prescribe. ``inverse_dynamics`` gives torques,
reactions and the friction that they make in the joints.
"""

import clearance as cl

run = cl.inverse_dynamics(cl.load_case("five_axis_chain", friction="stribeck"), until=5.0)
run.plot.efforts()

# %%

run.plot.friction()
