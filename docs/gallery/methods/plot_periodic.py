"""
A periodic motion, directly
===========================

A dry joint settles after dozens of turns. ``cl.steady`` solves for the motion that returns,
with the growth of disturbances over a turn: all multipliers lie in the unit circle.
"""

import clearance as cl

dry = {"model": "dry", "friction": "coulomb", "friction_coefficient": 0.03, "clearance": 1e-3}
orbit = cl.steady(cl.load_case("slider_crank", speed=cl.rpm(3000), restitution=0.9, **dry))
orbit.orbit.plot.history("C.force,slider.ax", along="angle")

# %%
print("settled in", round(orbit.turns_spent), "turns")
print("multipliers", *(f"{m:.4f}" for m in orbit.multipliers))
