"""A joint of one's own that only forces hold, without surfaces: a rubber bush."""

from dataclasses import dataclass

import numpy as np
import pytest

import clearance as cl
from clearance.elements.element import State
from clearance.elements.joint import Joint, Known, axis_field
from clearance.elements.quantities import number
from clearance.metrics.metrics import metrics
from clearance.simulation import prepare
from clearance.values import checks
from tests.random_scenes import RubberBush

MASS, STIFFNESS, GRAVITY = 2.0, 1e5, 9.81


def hanging(**numbers) -> cl.Scene:
    """A body whose centre of mass hangs below its bush."""
    body = cl.Body("body", MASS, 1e-2, points={"pin": (0, 0.1)})
    bush = RubberBush(cl.ground, body["pin"], STIFFNESS, name="A", **numbers)
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
    """A motion that forces hold is not prescribed."""
    with pytest.raises(ValueError, match="joint A is held by forces: its motion is not prescribed"):
        cl.inverse_dynamics(hanging(), until=1.0)


@checks.answers
@dataclass(frozen=True)
class Mount(Joint):
    """Rubber in the frame of body a: stiffness 2 k along, k across, c about; damping d."""

    a: cl.Point
    b: cl.Point
    stiffness: float = number("stiffness [N/m]", checks.positive)
    torsion: float = number("torsion stiffness [N m/rad]", checks.positive)
    damping: float = number("damping [N s/m]", checks.non_negative, 0.0)
    angle: float = number("angle of b's frame against a's [rad]", checks.finite, 0.0)
    axis: tuple[float, float] = axis_field()
    name: str | None = None

    turns = True
    along, across, turn = Known(state="along"), Known(state="across"), Known("angle", "twist")

    def states(self):
        return [State("along", "m", 1e-4), State("across", "m", 1e-4), State("twist", "rad", 1e-3)]

    def act(self, m, w):
        x, y, twist = (m.state(self, s.name) for s in self.states())
        k, c, d = (m.number(self, n) for n in ("stiffness", "torsion", "damping"))
        fx, fy = (-2.0 * k * x.v - d * x.d, -k * y.v - d * y.d)
        dx, dy = m.axis(self)
        w.pair(self, fx * dx - fy * dy, fx * dy + fy * dx, -c * twist.v)
        w.store(k * x.v * x.v + 0.5 * (k * y.v * y.v + c * twist.v * twist.v))
        w.lose(self, d * (x.d * x.d + y.d * y.d))
        w.show(self, "twist", "rad", "twist", twist.v)


def swinging(count: int) -> cl.Scene:
    """A body on an arm that swings far, held there by equal mounts at one place."""
    arm = cl.Body("arm", 1.0, 1e-2, points={"end": (0.3, 0.1)}, com=(0.2, 0.0))
    body = cl.Body("body", MASS, 1e-2, points={"p": (0.05, 0.02)}, angle=0.3)
    numbers = {"stiffness": 1e4 / count, "torsion": 20.0 / count, "damping": 30.0 / count}
    ends = arm["end"], body["p"]
    return cl.Scene(
        cl.Revolute(cl.ground, arm, name="O"),
        *(Mount(*ends, **numbers, angle=0.3, axis=(3, 4), name=f"M{i}") for i in range(count)),
        gravity=(0.0, -GRAVITY),
    )


def test_two_mounts_at_one_place_are_one_of_twice_the_stiffness():
    """The states of the second follow from the bodies: all angles within 1e3 rtol; ledger 1e-6."""
    one, two = (cl.simulate(swinging(n), until=0.5, rtol=1e-9) for n in (1, 2))
    assert abs(one["arm"].theta[-1]) > 0.5
    assert np.abs(one.joint("M0").twist).max() > 0.1
    for body in ("arm", "body"):
        assert two[body].theta[-1] == pytest.approx(one[body].theta[-1], abs=1e-6)
    np.testing.assert_allclose(two.joint("M1").twist, two.joint("M0").twist, rtol=0, atol=1e-12)
    assert two.solver["energy_residual_share"] < 1e-6


def test_two_slides_with_clearance_on_one_block():
    """Two at one place are one of twice the contact stiffness: corners within 1e-6 clearances."""

    def falling(count):
        block = cl.Body("block", 0.1, 5e-5, points={"P": (0.005, 0)})
        contact = cl.lankarani_nikravesh(stiffness=1e8 / count, restitution=0.9)
        sizes = {"clearance": 1e-3, "overlap": 0.05, "height": 0.03, "contact": contact}
        slides = (
            cl.ClearancePrismatic(cl.ground, block["P"], name=f"S{i}", **sizes)
            for i in range(count)
        )
        return cl.simulate(cl.Scene(*slides, gravity=(0.0, -GRAVITY)), until=0.03, rtol=1e-9)

    one, two = falling(1), falling(2)
    assert one.joint("S0").gap.min() < 0.0
    for name, tolerance in (("offset", 1e-9), ("tilt", 1e-9 / 0.025)):
        expected = getattr(one.joint("S0"), name)[-1]
        for joint in ("S0", "S1"):
            assert getattr(two.joint(joint), name)[-1] == pytest.approx(expected, abs=tolerance)


@cl.spring
def runaway(elongation, rate, k):
    """It pushes away without bounds."""
    return -k * elongation**3


def test_a_failing_run_names_its_place():
    """The error of a run that ends early has time, reason and the place of its soft joints."""
    body = cl.Body("body", MASS, 1e-2, points={"pin": (0, 0.1)})
    spring = cl.SpringDamper(
        cl.ground.at(-1, 0), body, tension=runaway(k=1e9), free_length=0.9, name="S"
    )
    scene = cl.Scene(RubberBush(cl.ground, body["pin"], 1e3, name="A"), spring)
    with pytest.raises(cl.SimulationError, match=r"at t = .* s: .*A: give_x \S+ m, give_y \S+ m"):
        cl.simulate(scene, until=5.0)
