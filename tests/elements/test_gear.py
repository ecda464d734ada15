"""Meshing teeth against closed forms: mesh force, bearing forces, vibration, planets, racks."""

import dataclasses
import math
import re

import numpy as np
import pytest

import clearance as cl
from tests.seeds import few_of

PINION, WHEEL, DISTANCE = 1e-3, 4e-3, 0.15  # moments of inertia [kg m2], distance of axes [m]


def pair(ratio=-0.5, torque=0.0, **teeth):
    """A pinion that a torque drives, and a wheel, both on ground."""
    one, two = cl.Body("one", 1.0, PINION), cl.Body("two", 2.0, WHEEL)
    hinges = (
        cl.Revolute(cl.ground, one, name="one"),
        cl.Revolute(cl.ground.at(DISTANCE, 0.0), two, name="two"),
    )
    gear = cl.Gear(*hinges, ratio=ratio, **teeth)
    return cl.Scene(*hinges, gear, cl.Torque(one, torque=torque), gravity=(0.0, 0.0))


@pytest.mark.parametrize("ratio", [-0.5, 0.4], ids=["external", "ring"])
def test_a_pinion_drives_a_wheel(ratio):
    """Rigid teeth: alpha = T / (I1 + i^2 I2); what the mesh carries, and with 20 degrees of
    pressure angle what the bearings carry of it.

    Teeth of 1e7 N/m with a damper: to 1e-4 at rtol 1e-8, for their vibration has died out by then.
    """
    angle = cl.degree(20)
    scene = pair(ratio, torque=1.0, stiffness=1e7, damping=1e3, pressure_angle=angle)
    run = cl.simulate(scene, until=0.1, samples=11, rtol=1e-8, error=None)
    alpha = 1.0 / (PINION + ratio**2 * WHEEL)
    assert run["one"].omega[-1] == pytest.approx(0.1 * alpha, rel=1e-4)
    assert run["two"].omega[-1] == pytest.approx(ratio * run["one"].omega[-1], rel=1e-5)
    radius = DISTANCE / (ratio - 1.0)  # signed: of the wheel, from its axis to the pitch point
    force = WHEEL * ratio * alpha / radius
    assert run.values("springs/gear/force")[-1] == pytest.approx(force, rel=1e-4)
    apart = math.copysign(
        abs(force) * math.tan(angle), -ratio
    )  # on the wheel, along the axes' line
    wheel, pinion = run.joint("two"), run.joint("one")
    assert wheel.force_y[-1] == pytest.approx(-force, rel=1e-4)
    assert wheel.force_x[-1] == pytest.approx(-apart, rel=1e-4)
    assert pinion.force_y[-1] == pytest.approx(force, rel=1e-4)
    assert pinion.force_x[-1] == pytest.approx(apart, rel=1e-4)
    assert run.solver["energy_residual_share"] < 1e-6


def test_elastic_teeth_vibrate():
    """Free wheels that begin with a deflection d0: d0 cos(w t), w^2 = k (r1^2 / I1 + r2^2 / I2); to
    1e-6 of d0 over three periods at rtol 1e-9.
    """
    scene = pair(-0.5, stiffness=1e6, phase=1e-4)
    run = cl.simulate(scene, until=6e-3, samples=101, rtol=1e-9, error=None)
    one, two = DISTANCE / 3.0, 2.0 * DISTANCE / 3.0
    frequency = math.sqrt(1e6 * (one**2 / PINION + two**2 / WHEEL))
    wanted = -1e-4 * two * np.cos(frequency * run.time)
    actual = run.values("springs/gear/deflection")
    np.testing.assert_allclose(actual, wanted, atol=1e-6 * 1e-4 * two)
    np.testing.assert_allclose(run.values("springs/gear/force"), 1e6 * actual, rtol=1e-12)


def test_a_planet_rolls_on_a_sun_at_rest():
    """A driven carrier: the planet turns (1 - i) times as fast, i = -r_sun / r_planet, to 1e-5:
    the error of stiff teeth in explicit steps at rtol 1e-9.
    """
    carrier = cl.Body("carrier", 1.0, 1e-2, points={"c": (0.0, 0.0), "p": (0.1, 0.0)}, angle=0.4)
    planet = cl.Body("planet", 0.5, 1e-3, angle=0.4, angular_velocity=30.0)
    sun = cl.Revolute(carrier["c"], cl.ground, name="sun")
    axle = cl.Revolute(carrier["p"], planet, name="axle")
    gear = cl.Gear(sun, axle, ratio=-2.0, stiffness=1e7, damping=1e3, phase=-2.0 * 0.4)
    scene = cl.Scene(sun, axle, gear, cl.Drive(carrier, speed=10.0, start=0.4))
    run = cl.simulate(scene, until=0.5, samples=101, rtol=1e-9, error=None)
    assert run["planet"].omega == pytest.approx(30.0, rel=1e-5)
    assert np.ptp(run["planet"].theta) == pytest.approx(15.0, rel=1e-6)
    assert run.solver["energy_residual_share"] < 1e-6


def rack(**teeth):
    """A wheel on a rack that a spring holds; the rack is at rest where the spring is free."""
    wheel, bar = cl.Body("wheel", 1.0, PINION), cl.Body("bar", 2.0, 1e-2)
    axle = cl.Revolute(cl.ground.at(0.0, 0.05), wheel, name="axle")
    slide = cl.Prismatic(cl.ground, bar, name="slide")
    gear = cl.Gear(axle, slide, ratio=0.05, **teeth)
    hold = cl.SpringDamper(cl.ground.at(1.0, 0.0), bar, stiffness=400.0, free_length=1.0)
    torque = cl.Torque(wheel, torque=0.2)
    return cl.Scene(axle, slide, gear, hold, torque, gravity=(0.0, 0.0))


def test_a_rack_moves_with_its_wheel():
    """x = r q: both swing about T / (r k) with w^2 = k / (m + I / r^2), to 1e-3 of it, for teeth of
    1e8 N/m with a damper that holds their vibration below 1e-8 m. The axle carries the mesh force.
    """
    run = cl.simulate(rack(stiffness=1e8, damping=1e3), until=0.5, samples=101, error=None)
    shift, frequency = 0.2 / (0.05 * 400.0), math.sqrt(400.0 / (2.0 + PINION / 0.05**2))
    wanted = shift * (1.0 - np.cos(frequency * run.time))
    np.testing.assert_allclose(run["bar"].x, wanted, atol=1e-3 * shift)
    force = run.values("springs/gear/force")
    deflection = 0.05 * run["wheel"].theta - run["bar"].x
    np.testing.assert_allclose(deflection, force / 1e8, atol=1e-8)
    np.testing.assert_allclose(run.joint("axle").force_x, force, rtol=1e-9)
    # the pitch point lies on the slide's axis: no moment
    np.testing.assert_allclose(run.joint("slide").moment, 0.0, atol=1e-12)
    assert run.solver["energy_residual_share"] < 1e-6


def test_backlash_lets_the_pinion_run_until_the_flank():
    """A pinion alone in a play of 1 mm: alpha = T / I1 until it has turned play / 2 / r1; the wheel
    rests till then and moves after it.
    """
    scene = pair(torque=0.1, mesh=cl.backlash(stiffness=1e7, play=1e-3))
    meets = math.sqrt(2.0 * (0.5e-3 / (DISTANCE / 3.0)) * PINION / 0.1)
    run = cl.simulate(scene, until=1.2 * meets, samples=121, error=None)
    free = run.time < 0.99 * meets
    np.testing.assert_allclose(run["one"].omega[free], 100.0 * run.time[free], rtol=1e-9)
    assert not run["two"].omega[free].any()
    assert run["two"].omega[-1] < 0.0 < run["one"].omega[-1]


def test_teeth_that_start_apart_are_named():
    """Wheels at random angles: warned of from 0.02 on, with the phase that meshes them."""
    rng = np.random.default_rng(6)
    for _ in range(20):
        ratio, off = rng.choice([-1.0, 1.0]) * rng.uniform(0.2, 0.9), rng.choice([0.015, 0.03, 2.0])
        angles = rng.uniform(-3.0, 3.0, 2)
        one, two = (
            cl.Body(n, 1.0, WHEEL, angle=a) for n, a in zip(("one", "two"), angles, strict=True)
        )
        hinges = cl.Revolute(cl.ground, one), cl.Revolute(cl.ground.at(DISTANCE, 0.0), two)
        phase = angles[1] - ratio * angles[0] + off
        gear = cl.Gear(*hinges, ratio=ratio, stiffness=1e6, phase=phase)
        doubts = cl.Scene(*hinges, gear).doubts
        assert bool(doubts) == (off > 0.02)
        if doubts:
            phase = float(re.search("phase=([^ ]+)", doubts[0])[1])
            scene = cl.Scene(*hinges, dataclasses.replace(gear, phase=phase))
            run = cl.simulate(scene, until=1e-6, samples=2, error=None)
            assert abs(run.values("springs/gear/deflection")[0]) < 1e-5 * DISTANCE


@cl.signal
def swinging(time, first):
    """An angle at t = 0, and a rate."""
    return first + 0.5 * time


@pytest.mark.parametrize("driven", ["body", "hinge", "second", "carrier"])
@pytest.mark.parametrize("way", ["speed", "torque", "motion"])
def test_teeth_of_driven_wheels_are_those_of_the_start(driven, way):
    """Wheels, their hinges and their carrier driven from random angles, evenly, by a torque, by a
    law of time: the phase is that of the run's first sample, to the six digits printed.
    """
    rng = np.random.default_rng([ord(c) for c in driven + way])
    for off in (0.0, 0.015, 0.03, *rng.uniform(-2.0, 2.0, 3)):
        ratio, start = rng.choice([-1.0, 1.0]) * rng.uniform(0.2, 0.9), rng.uniform(-3.0, 3.0)
        one, two, arm = (
            cl.Body(n, 1.0, WHEEL, angle=a)
            for n, a in zip(("one", "two", "arm"), rng.uniform(-3.0, 3.0, 3), strict=True)
        )
        base, extra = cl.ground, []
        if driven == "carrier":
            base, extra = arm, [cl.Revolute(cl.ground, arm, name="C")]
        first = cl.Revolute(base, one, name="A")
        second = cl.Revolute(base.at(DISTANCE, 0.0), two, name="B")
        target = {"body": one, "hinge": first, "second": two, "carrier": arm}[driven]
        effort = {"speed": {"speed": 1.0}, "torque": {"torque": 0.0}}.get(way, {})
        drive = (
            cl.Drive(target, motion=swinging(first=start))
            if way == "motion"
            else cl.Drive(target, start=start, **effort)
        )
        gear = cl.Gear(first, second, ratio=ratio, stiffness=1e3, name="teeth")
        run = cl.simulate(
            cl.Scene(*extra, first, second, gear, drive), until=1e-9, samples=2, error=None
        )
        turned = run["arm"].theta[0] if extra else 0.0
        meshing = run["two"].theta[0] - turned - ratio * (run["one"].theta[0] - turned)
        gear = dataclasses.replace(gear, phase=meshing + off)
        doubts = cl.Scene(*extra, first, second, gear, drive).doubts
        assert bool(doubts) == (abs(off) > 0.02)
        for doubt in doubts:
            stated = float(re.search("phase=([^ ]+)", doubt)[1])
            assert stated == pytest.approx(meshing, rel=1e-5, abs=1e-9)


def test_impossible_teeth_are_refused():
    """By field and value, before anything runs."""
    one, two = cl.Body("one", 1.0, PINION), cl.Body("two", 2.0, WHEEL)
    on_ground = cl.Revolute(cl.ground, one, name="one")
    on_one = cl.Revolute(one, two, name="two")
    with pytest.raises(ValueError, match="need one carrier as body a, got ground and one"):
        cl.Gear(on_ground, on_one, ratio=-1.0, stiffness=1e6)
    with pytest.raises(ValueError, match=r"ratio=1.5: .* put the pinion first"):
        pair(1.5, stiffness=1e6)
    with pytest.raises(ValueError, match="ratio must not be 0"):
        pair(0.0, stiffness=1e6)
    with pytest.raises(TypeError, match="Gear: first must be"):
        cl.Gear(one, on_one, ratio=-1.0)
    with pytest.raises(ValueError, match="takes the place of stiffness and damping"):
        pair(stiffness=1e6, mesh=cl.backlash(stiffness=1e7, play=1e-3))
    with pytest.raises(ValueError, match="its second joint, joint two, is not in the scene"):
        cl.Scene(on_ground, cl.Gear(on_ground, cl.Revolute(cl.ground, two, name="two"), ratio=-1.0))


def test_teeth_are_read_from_a_document():
    """A scene of a result file has its gear with all numbers."""
    scene = pair(stiffness=1e7, damping=1e3, pressure_angle=0.35)
    again = cl.Scene.from_json(scene.to_json())
    assert again.to_json() == scene.to_json()
    assert again.loads[0].first is again.joints[0]


def wound(seed):
    """A driven arm with two wheels whose teeth have play; all three have turned by thousands of
    radians at the start, or less.
    """
    rng = np.random.default_rng(seed)
    turned = rng.uniform(50.0, 5000.0, 3)
    far = {"far": (rng.uniform(0.2, 1.5), 0.0)}
    arm = cl.Body("arm", 0.1, rng.uniform(0.01, 0.1), points=far, angle=turned[0])
    inner = cl.Body(
        "inner", 0.5, rng.uniform(0.01, 0.1), angle=turned[1], com=(rng.uniform(0.0, 0.5), 0.0)
    )
    outer = cl.Body("outer", 0.2, rng.uniform(0.01, 0.1), angle=turned[2])
    hinges = cl.Revolute(arm, inner, name="inner"), cl.Revolute(arm["far"], outer, name="outer")
    ratio = rng.uniform(0.3, 0.95)
    mesh = cl.backlash(stiffness=rng.uniform(1e3, 1e4), play=rng.uniform(5e-3, 2e-2))
    speed = cl.pi_speed(proportional=70.0, integral=100.0, speed=13.0, limit=600.0)
    gear, drive = cl.Gear(*hinges, ratio=ratio, mesh=mesh), cl.Drive(arm, torque=speed)
    return cl.Scene(cl.Revolute(cl.ground, arm, name="axis"), *hinges, gear, drive)


@pytest.mark.parametrize("seed", few_of([7, 13, 21, *range(7), *range(30, 50)], 4))
def test_play_is_crossed_far_from_the_first_turn(seed):
    """Angles are rounded to 1e-12 there, ten times the dead band of a kink: runs ended at one.

    Their energy closes: nothing is damped. Measured 2e-6 of what is turned over, once an error too
    large by chance; 1e-5 is rtol times ten thousand kinks.
    """
    run = cl.simulate(wound(seed), until=0.5, samples=11, rtol=1e-8, error=None)
    assert run.complete
    assert run.solver["energy_residual_share"] < 1e-5
