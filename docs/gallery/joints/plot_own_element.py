"""
An element of one's own
=======================

A rubber bush as a joint: two states that forces hold, with what it stores and loses. It
carries a motor whose rotor has an unbalance.
"""

from dataclasses import dataclass

import clearance as cl
from clearance.elements.element import State
from clearance.elements.joint import FREE, Joint, Known
from clearance.elements.quantities import number
from clearance.values import checks


@checks.answers
@dataclass(frozen=True)
class Bush(Joint):
    """A pin (point b) in a rubber ring about point a: force -k e - d e' on b, free to turn."""

    a: cl.Point
    b: cl.Point
    stiffness: float = number("stiffness [N/m]", checks.positive)
    damping: float = number("damping [N s/m]", checks.non_negative, 0.0)
    name: str | None = None

    along, across, turn = Known(state="give_x"), Known(state="give_y"), FREE

    def states(self):
        return [State("give_x", "m", 1e-3), State("give_y", "m", 1e-3)]

    def act(self, m, w):
        k, d = m.number(self, "stiffness"), m.number(self, "damping")
        x, y = m.state(self, "give_x"), m.state(self, "give_y")
        force = [-k * x.v - d * x.d, -k * y.v - d * y.d]
        w.pair(self, *force)
        w.store(0.5 * k * (x.v * x.v + y.v * y.v))
        w.lose(self, d * (x.d * x.d + y.d * y.d))
        for axis, e, f in zip("xy", (x, y), force, strict=True):
            w.show(self, f"force_{axis}", "N", f"force {axis} on {self.b.body.name}", f)
            w.show(self, f"give_{axis}", "m", f"displacement of the pin, {axis}", e.v)


motor = cl.Body("motor", 8.0, 0.03, points={"foot": (0, 0), "axle": (0, 0.08)}, com=(0, 0.06))
rotor = cl.Body("rotor", 2.0, 2e-3, points={"hub": (0, 0), "rim": (0.04, 0)}, com=(0.002, 0))
scene = cl.Scene(
    Bush(cl.ground, motor["foot"], stiffness=4e4, damping=120.0, name="bush"),
    cl.TorsionSpring(cl.ground, motor, stiffness=400.0, damping=1.0, name="twist"),
    hinge := cl.Revolute(motor["axle"], rotor["hub"], name="axle"),
    cl.Drive(hinge, speed=cl.rpm(700), start=0.0),
    name="motor_on_rubber",
)
run = cl.simulate(scene, turns=20, samples_per_turn=100)
run.plot.sketch()

# %%
# The bush gives by the weight, and more as the unbalance turns:

run.plot.history("bush.give_x,bush.give_y,motor.theta")
