"""
A motor that yields
===================

The same dry slider-crank with a prescribed speed and with a motor, whose torque falls with
its speed.
"""

import clearance as cl

dry = {"model": "dry", "clearance": 1e-4, "speed": cl.rpm(600)}
even, motor = (
    cl.simulate(cl.load_case("slider_crank", drive=d, **dry), turns=6) for d in ("speed", "motor")
)
motor.plot.sketch()

# %%
cl.plot([even, motor], "history", channels="crank.omega,C.force", along="angle", last=1)
