"""A joint of one's own that only forces hold, without surfaces: a rubber bush."""

from dataclasses import dataclass

import numpy as np
import pytest

import clearance as cl
from clearance import checks
from clearance.elements.element import State
from clearance.elements.joint import FREE, Joint, Known
from clearance.metrics import metrics
from clearance.quantities import number
from clearance.simulation import prepare

MASS, STIFFNESS, GRAVITY = 2.0, 1e5, 9.81


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
        return [State(f"give_{axis}", "m", 1e-4) for axis in "xy"]

    def act(self, m, w):
        give = [m.state(self, f"give_{axis}") for axis in "xy"]
        k, d = m.number(self, "stiffness"), m.number(self, "damping")
        force = [-k * e.v - d * e.d for e in give]
        w.pair(self, *force)
        w.store(0.5 * k * m.trace.sum(e.v * e.v for e in give))
        w.lose(self, d * m.trace.sum(e.d * e.d for e in give))
        for axis, e, value in zip("xy", give, force, strict=True):
            w.show(self, f"force_{axis}", "N", f"force {axis} on {self.b.body.name}", value)
            w.show(self, f"give_{axis}", "m", f"displacement of the pin, {axis}", e.v)


def hanging(**numbers) -> cl.Scene:
    """A body whose centre of mass hangs below its bush."""
    body = cl.Body("body", MASS, 1e-2, points={"pin": (0, 0.1)})
    bush = Bush(cl.ground, body["pin"], STIFFNESS, name="A", **numbers)
    return cl.Scene(bush, gravity=(0.0, -GRAVITY))


def test_vibration():
    """e = m g / k (cos w t - 1), w = sqrt(k / m): within 100 rtol of m g / k; ledger 1e-7."""
    run = cl.simulate(hanging(), until=0.1)
    give = -MASS * GRAVITY / STIFFNESS * (1.0 - np.cos(np.sqrt(STIFFNESS / MASS) * run.time))
    allowed = 1e-4 * MASS * GRAVITY / STIFFNESS
    np.testing.assert_allclose(run.joint("A").give_y, give, rtol=0, atol=allowed)
    assert run.solver["energy_residual_share"] < 1e-7
    twice = 2.0 * MASS * GRAVITY
    assert metrics(run)["joint_A_force_max"].value == pytest.approx(twice, rel=1e-4)


def test_change_and_rest():
    """A stiffer bush from 0.5 s on: it comes to rest at m g over the new stiffness (1e-6)."""
    run = prepare(hanging(damping=400.0), until=1.0)
    run.every(0.5, lambda r: r.change({"joints/A/stiffness": 2.0 * STIFFNESS}))
    run.trajectory()
    expected = -0.5 * MASS * GRAVITY / STIFFNESS
    assert run.outputs_here()[run.mechanism.layout.output["joints/A/give_y"]] == pytest.approx(
        expected, rel=1e-6
    )


def test_inverse_dynamics_is_refused():
    with pytest.raises(ValueError, match="joint A is held by forces: its motion is not prescribed"):
        cl.inverse_dynamics(hanging(), until=1.0)
