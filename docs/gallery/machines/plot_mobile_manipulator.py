"""
Mobile manipulator
==================

Boom, stick and bucket on three hydraulic actuators, with friction in all joints (after
Chacko and Khan, 2017). All three actuators dig.
"""

import clearance as cl

run = cl.inverse_dynamics(cl.load_case("mobile_manipulator", simulation=2), until=40.0)
run.plot.sketch()

# %%
# Forces of the actuators, with friction and without:

run.plot.efforts()
