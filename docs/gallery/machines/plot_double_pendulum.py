"""
Double pendulum
===============

Two rods, released from rest. Neighbouring starts part, and the energy stays.
"""

import numpy as np

import clearance as cl

runs = [
    cl.simulate(cl.load_case("double_pendulum", angle1=1.0, angle2=1.0 + d), until=6.0, rtol=1e-10)
    for d in (0.0, 1e-6)
]
runs[0].plot.sketch()

# %%
cl.plot(runs, "history", channels="lower.theta")

# %%
apart = np.abs(runs[1]["lower"].theta - runs[0]["lower"].theta)
share = runs[0].solver["energy_residual_share"]
print(f"apart after 6 s by {apart[-1]:.2g} rad; energy off by {share:.1g} of itself")
