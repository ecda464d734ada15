"""Bristle friction of hinges and slides: a state of the joint that has it, sticking, breaking away,
sliding.
"""

import math

import numpy as np
import pytest

import clearance as cl
from clearance.mechanism.build import build
from tests.elements.test_rubbing import hanging
from tests.plain import jacobian_error

NUMBERS = {
    "static": 2.0,
    "kinetic": 1.5,
    "stribeck_rate": 0.1,
    "stiffness": 500.0,
    "damping": 1.0,
    "viscous": 0.4,
}
LAW = cl.joint_lugre(**NUMBERS)


def arm(law=LAW, speed=None, **more):
    body = cl.Body(
        "arm", 2.0, 0.05, points={"pin": (0, 0)}, com=(0.2, 0), angle=-0.5 * math.pi + 0.1
    )
    joint = cl.Revolute(cl.ground, body["pin"], name="J", friction=law, **more)
    return cl.Scene(
        joint, *([cl.Drive(joint, speed=speed, start=-1.4, name="motor")] if speed else [])
    )


def test_a_prescribed_rate_bends_the_bristles_as_the_closed_form_says(validated):
    """z = (g / s_0) (1 - exp(-s_0 |x| / g)) at a constant rate, then steady; tolerances of rtol
    1e-10.
    """
    for rate in (0.02, 0.5):
        run = cl.simulate(arm(speed=rate), until=0.1 / rate, rtol=1e-10)
        level = 1.5 + 0.5 * math.exp(-((rate / 0.1) ** 2))
        way = rate * run.time
        expected = level / 500.0 * (1.0 - np.exp(-500.0 * way / level))
        joint, options = (
            run.joint("J"),
            {"source": "closed form at a constant rate", "kind": "exact"},
        )
        validated(
            "bristle deflection",
            joint.bristle_deflection,
            expected,
            1e-9,
            unit="rad",
            relative=False,
            **options,
        )
        validated(
            "sliding friction",
            joint.friction[-1],
            -(level + 0.4 * rate),
            1e-8,
            unit="N m",
            **options,
        )
        assert np.abs(run.energy.residual).max() < 1e-9


def test_it_sticks_under_a_load_below_break_away(validated):
    """The pendulum stops where its weight bends the bristles, and stays: no drift over 20 s but
    for thirty times the tolerance.
    """
    run = cl.simulate(arm(), until=20.0, rtol=1e-9, error=None)
    theta = run["arm"].theta
    weight = 2.0 * 9.81 * 0.2 * np.sin(theta[-1] + 0.5 * math.pi)
    assert 0.1 * NUMBERS["static"] < weight < 0.5 * NUMBERS["static"]
    actual = run.joint("J").bristle_deflection[-1]
    validated(
        "deflection of sticking bristles",
        actual,
        -weight / 500.0,
        1e-6,
        unit="rad",
        source="weight over stiffness",
        kind="exact",
    )
    later = theta[run.time > 5.0]
    assert np.ptp(later) < 3e-8


def test_it_breaks_away_above_the_static_level():
    """A weight beyond the static level moves the arm."""
    heavy = cl.joint_lugre(**NUMBERS | {"static": 0.3, "kinetic": 0.2, "viscous": 1.0})
    run = cl.simulate(arm(heavy), until=3.0, rtol=1e-8)
    # the weight of 0.39 N m at the start moves it
    assert abs(run["arm"].theta[-1] + 0.5 * math.pi) < 0.08


def test_the_state_is_carried_only_where_a_joint_has_bristles():
    """Bristles are one state, and one of their joint only."""
    assert build(arm(), ledger=False).size == 3
    assert (
        build(
            arm(cl.joint_coulomb(coefficient=0.1, transition_rate=0.1), pin_radius=0.01),
            ledger=False,
        ).size
        == 2
    )
    assert not any("bristle" in c.path for c in build(arm(None)).layout.channels)


def test_load_dependent_bristles_follow_the_reaction():
    """The load is that of the pin; sliding friction is Stribeck's for it."""
    law = cl.joint_lugre_loaded(
        static=0.3, kinetic=0.2, stribeck_rate=0.1, stiffness=80.0, viscous=0.1
    )
    run = cl.simulate(arm(law, speed=0.5, pin_radius=0.03), until=2.0, rtol=1e-9)
    joint = run.joint("J")
    load = 0.03 * np.hypot(joint.force_x, joint.force_y)
    np.testing.assert_allclose(joint.friction_load, load, rtol=1e-12)
    slow = math.exp(-((0.5 / 0.1) ** 2))
    sliding = -load * (0.2 + 0.1 * slow + 0.1 * 0.5)
    np.testing.assert_allclose(joint.friction[run.time > 1.0], sliding[run.time > 1.0], rtol=1e-6)


@pytest.mark.parametrize("name", ["lugre", "loaded", "pair"])
def test_the_jacobian_is_that_of_the_right_side(name):
    """Against central differences; tolerance 1e-6 of the largest entry of each column."""
    loaded = cl.joint_lugre_loaded(
        static=0.3, kinetic=0.2, stribeck_rate=0.5, stiffness=50.0, damping=0.1, viscous=0.1
    )
    scenes = {"lugre": arm(), "loaded": arm(loaded, pin_radius=0.05)}
    scenes["pair"] = hanging(loaded)
    mechanism = build(scenes[name])
    n, rng = mechanism.size, np.random.default_rng(5)
    y = mechanism.y0.copy()
    y[:n] += 0.3 * mechanism.scale * rng.uniform(0.2, 1.0, n)
    assert jacobian_error(mechanism, y) < 1e-6


def test_inverse_dynamics_has_no_time_to_bend_bristles():
    """A prescribed motion refuses friction with a state."""
    with pytest.raises(
        ValueError, match="joint J: friction joint_lugre has a state that time integrates"
    ):
        cl.inverse_dynamics(arm(speed=1.0), until=1.0)


def test_bristles_that_may_push_are_said():
    """Damping that may push is warned of; levels in the wrong order are refused."""
    run = cl.simulate(arm(cl.joint_lugre(**NUMBERS | {"viscous": 0.1, "damping": 2.0})), until=0.01)
    assert any(
        "joint J: joint_lugre: is passive at all rates only with viscous" in w for w in run.warnings
    )
    with pytest.raises(ValueError, match="joint J: friction joint_lugre needs static >= kinetic"):
        arm(cl.joint_lugre(**NUMBERS | {"static": 1.0}))
