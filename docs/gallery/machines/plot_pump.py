"""
Piston pump
===========

The pressure of the outlet acts while the piston goes in, that of the inlet while it goes
out. This is a law of the speed of the piston, as a spring law of one's own. The motor is a
direct-current motor.
"""

import math

import clearance as cl


@cl.spring
def valves(elongation, rate, inlet, outlet, speed):
    """Pull between piston and cylinder head [N]: forces by the sense of the motion."""
    going_in = 0.5 - 0.5 * math.tanh(rate / speed)
    return -(inlet + (outlet - inlet) * going_in)


area = math.pi / 4 * 0.03**2
crank = cl.Body("crank", 1.0, 2e-3, points={"main": (0, 0), "pin": (0.015, 0)})
rod = cl.Body("rod", 0.2, 1e-4, points={"big": (0, 0), "small": (0.08, 0)}, com=(0.04, 0))
piston = cl.Body("piston", 0.2, 1e-4, points={"pin": (0, 0)})
motor = cl.dc_motor(voltage=48.0, resistance=0.3, inductance=1e-3, constant=0.5)
scene = cl.Scene(
    cl.Revolute(cl.ground, crank["main"], name="main"),
    cl.Revolute(crank["pin"], rod["big"], name="big_end"),
    cl.Revolute(rod["small"], piston["pin"], name="small_end"),
    cl.Prismatic(cl.ground, piston["pin"], name="bore"),
    cl.SpringDamper(
        piston["pin"],
        cl.ground.at(0.16, 0),
        tension=valves(inlet=1e5 * area, outlet=2e6 * area, speed=0.02),
        name="oil",
    ),
    cl.Drive(crank, torque=motor, speed_start=0.0, nominal=cl.rpm(800)),
    name="pump",
)
run = cl.simulate(scene, until=1.0)
run.plot.sketch()

# %%
# The motor runs up, and its speed ripples with the strokes:

run.plot.history("crank.omega,crank.current,oil.tension")

# %%
# Mean flow over the last half second, and the power of the shaft beside it:

late = run.time > 0.5
speed = run["crank"].omega[late].mean()
flow = area * 0.03 * speed / (2 * math.pi)
print(f"{6e4 * flow:.2f} l/min, {run.drive('crank').power[late].mean():.0f} W on the shaft")
