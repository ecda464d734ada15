"""Weld, pin in a slot with and without clearance, follower force: against closed forms and other
elements.
"""

import math

import numpy as np
import pytest

import clearance as cl
from clearance.mechanism.build import build
from tests import mechanisms as m
from tests.plain import observed


def observed_at_start(scene):
    """Outputs of a scene at its start."""
    return observed(build(scene))


def halves(angle):
    """A pendulum of two welded halves, the second turned by an angle against the first."""
    first = cl.Body(
        "first",
        1.0,
        0.01,
        points={"pin": (-0.1, 0.0), "end": (0.1, 0.0)},
        angle=0.4,
        angular_velocity=2.0,
    )
    turned = -angle
    start = (-0.1 * math.cos(turned), -0.1 * math.sin(turned))
    second = cl.Body("second", 2.0, 0.02, points={"start": start}, angle=0.4 + angle)
    return cl.Scene(
        cl.Revolute(cl.ground, first["pin"], name="P"),
        cl.Weld(first["end"], second["start"], angle=angle, name="W"),
    )


@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_two_welded_halves_are_one_body(angle):
    """Angular acceleration of the compound pendulum, and the weld's load from the balance of one
    half.

    To 1e-9: the start closes to 1e-12 of the size, an angle by some 1e-11.
    """
    seen = observed_at_start(halves(angle))
    mass, arm = 3.0, (1.0 * 0.1 + 2.0 * 0.3) / 3.0
    about_pin = 0.01 + 1.0 * 0.1**2 + 0.02 + 2.0 * 0.3**2
    alpha = -mass * 9.81 * arm * math.cos(0.4) / about_pin
    assert seen["bodies/first/alpha"] == pytest.approx(alpha, rel=1e-9)
    assert seen["bodies/second/alpha"] == pytest.approx(alpha, rel=1e-9)
    ax = 0.3 * (-alpha * math.sin(0.4) - 4.0 * math.cos(0.4))
    ay = 0.3 * (alpha * math.cos(0.4) - 4.0 * math.sin(0.4))
    fx, fy = 2.0 * ax, 2.0 * (ay + 9.81)
    assert seen["joints/W/force_x"] == pytest.approx(fx, rel=1e-9)
    assert seen["joints/W/force_y"] == pytest.approx(fy, rel=1e-9)
    # from the weld to the second half's centre
    arm_x, arm_y = 0.1 * math.cos(0.4), 0.1 * math.sin(0.4)
    assert seen["joints/W/moment"] == pytest.approx(
        0.02 * alpha + arm_x * fy - arm_y * fx, rel=1e-9
    )


def test_a_body_of_no_mass_is_a_distance_rod():
    """Its force lies along its line, to 1e-12: the inertia of 1e-15 kg bends it by no more."""
    crank, rod = m.bar("crank", 0.05, 0.4), m.bar("rod", 0.15, 0.6, 1e-15, 1e-15)
    hinges = m.loop(crank, rod, m.bar("rocker", 0.12, 1.5), 0.16, "OPQD")
    seen = observed_at_start(cl.Scene(*hinges, cl.Drive(crank, speed=30.0, start=0.4)))

    x, y, angle = seen["joints/P/force_x"], seen["joints/P/force_y"], seen["bodies/rod/theta"]
    assert math.hypot(x, y) > 1.0
    assert abs(y * math.cos(angle) - x * math.sin(angle)) < 1e-12 * math.hypot(x, y)


def yoke(slot):
    """Scotch yoke: a crank pin drives a slide by a slot across it."""
    crank = cl.Body("crank", 0.2, 1e-4, points={"shaft": (0.0, 0.0), "pin": (0.05, 0.0)})
    slide = cl.Body("slide", 0.5, 1e-4)
    return cl.Scene(
        cl.Revolute(cl.ground, crank["shaft"], name="A"),
        slot(slide, crank),
        cl.Prismatic(cl.ground, slide, name="G"),
        cl.Drive(crank, speed=20.0, start=0.6),
        gravity=(0.0, 0.0),
    )


def test_a_scotch_yoke_by_a_pin_in_a_slot():
    """x = r cos(theta): position, speed and acceleration, and the torque that moves the slide;
    rounding.
    """
    ideal = observed_at_start(
        yoke(lambda slide, crank: cl.PinSlot(slide, crank["pin"], axis=(0.0, 1.0), name="S"))
    )
    assert ideal["bodies/slide/x"] == pytest.approx(0.05 * math.cos(0.6), rel=1e-13)
    assert ideal["bodies/slide/vx"] == pytest.approx(-0.05 * 20.0 * math.sin(0.6), rel=1e-13)
    assert ideal["bodies/slide/ax"] == pytest.approx(-0.05 * 400.0 * math.cos(0.6), rel=1e-13)
    push = 0.5 * ideal["bodies/slide/ax"]  # of the pin on the slide, and back on the pin's body b
    assert ideal["joints/S/force_x"] == pytest.approx(-push, rel=1e-12)
    assert ideal["drives/crank/torque"] == pytest.approx(push * -0.05 * math.sin(0.6), rel=1e-12)


def test_a_yoke_whose_slot_has_clearance_follows_the_ideal_one():
    """Within twice its clearance; the pin stays between the walls but for 5 % of it, the ledger
    closes to 1e-6.
    """
    law = cl.lankarani_nikravesh(stiffness=1e10, restitution=0.7)
    gap = {
        "radius": 0.008,
        "clearance": 1e-4,
        "contact": law,
        "friction": cl.coulomb(coefficient=0.1),
    }
    scene = yoke(
        lambda slide, crank: cl.ClearancePinSlot(
            slide, crank["pin"], axis=(0.0, 1.0), name="S", **gap
        )
    )
    run = cl.simulate(scene, turns=1.0, samples_per_turn=200)
    slot = run.joint("S")
    assert np.abs(run["slide"].x - 0.05 * np.cos(run["crank"].theta)).max() < 2e-4
    assert min(slot.gap_upper.min(), slot.gap_lower.min()) > -5e-6
    np.testing.assert_allclose(slot.gap_upper + slot.gap_lower, 2e-4, rtol=1e-9)
    assert run.solver["energy_residual_share"] < 1e-6
    assert {str(n) for n in run.events["joint"]} == {"S/upper", "S/lower"}


def test_a_pin_bounces_between_the_walls_as_its_law_delivers():
    """Lankarani and Nikravesh deliver .913 for .9: each impact takes that share of the speed, to
    1e-3.
    """
    law = cl.lankarani_nikravesh(stiffness=1e10, restitution=0.9, grazing_speed=1e-6)
    block = cl.Body("block", 0.5, 1e-4)
    scene = cl.Scene(
        cl.ClearancePinSlot(cl.ground, block, 0.01, 1e-3, contact=law, offset_rate=0.5, name="S"),
        gravity=(0.0, 0.0),
    )
    run = cl.simulate(scene, until=0.02, samples=11, rtol=1e-9)
    speeds = np.array(run.events["impact_speed"])
    assert len(speeds) >= 3
    chi = 0.75 * (1.0 - 0.9**2)
    np.testing.assert_allclose(speeds[1:] / speeds[:-1], cl.delivered_restitution(chi), atol=1e-3)


def test_a_pin_takes_its_stiffness_from_its_material():
    """Hertz's of a ball on a plane, 4/3 E* sqrt(r), where the law leaves it to the joint."""
    block = cl.Body("block", 0.5, 1e-4)
    law = cl.lankarani_nikravesh(restitution=0.9)
    slot = cl.ClearancePinSlot(cl.ground, block, 0.01, 1e-3, contact=law, name="S")
    modulus = 207e9 / (2.0 * (1.0 - 0.3**2))
    assert slot.contact.values["stiffness"] == pytest.approx(
        4.0 / 3.0 * modulus * math.sqrt(0.01), rel=1e-12
    )
    run = cl.simulate(
        cl.Scene(cl.ClearancePinSlot(cl.ground, block, 0.01, 1e-3, contact=cl.hertz())), until=0.01
    )
    assert run.complete


@pytest.mark.parametrize(
    ("joint", "sizes"),
    [
        (cl.ClearanceRevolute, {"radius": 0.01, "clearance": 1e-4, "length": 0.01}),
        (cl.ClearancePrismatic, {"clearance": 1e-4, "overlap": 0.1, "height": 0.02}),
        (cl.ClearancePinSlot, {"radius": 0.01, "clearance": 1e-4}),
    ],
)
def test_a_material_is_a_material(joint, sizes):
    """A name of the table may stand for it; anything else is refused by field and value."""

    def of(material):
        block, law = cl.Body("block", 1.0, 1e-3), cl.hertz(stiffness=1e8)
        return joint(cl.ground, block, name="S", contact=law, material=material, **sizes)

    assert of("bronze").material == cl.Material.named("bronze")
    with pytest.raises(ValueError, match=r"joint S: no material 'stel' \(did you mean steel\?\)"):
        of("stel")
    with pytest.raises(TypeError, match="joint S: material must be a Material, got 3"):
        of(3)


def trammel(slot=cl.PinSlot, **more):
    """A bar with its ends in two slots at right angles; the slots are on ground."""
    ends = {"p": (-0.1, 0.0), "q": (0.1, 0.0)}
    bar = cl.Body("bar", 1.0, 0.01, points=ends, angle=0.3, angular_velocity=2.0)
    return cl.Scene(
        cl.PinSlot(cl.ground, bar["p"], name="h"),
        slot(cl.ground, bar["q"], axis=(0.0, 1.0), name="v", **more),
    )


def test_a_body_in_two_slots_is_a_trammel():
    """Its centre moves on a circle of half its length: angular acceleration of that pendulum, and
    reactions by the balance of forces, to 1e-9 (the start closes to 1e-12); energy to 1e-6.
    """
    seen = observed_at_start(trammel())
    angle, spin, arm = 0.3, 2.0, 0.1
    alpha = -9.81 * arm * math.cos(angle) / (arm**2 + 0.01)
    ax = arm * (math.sin(angle) * alpha + math.cos(angle) * spin**2)
    ay = arm * (math.cos(angle) * alpha - math.sin(angle) * spin**2)
    assert seen["bodies/bar/alpha"] == pytest.approx(alpha, rel=1e-9)
    assert seen["joints/v/force_x"] == pytest.approx(ax, rel=1e-9)
    assert seen["joints/h/force_y"] == pytest.approx(ay + 9.81, rel=1e-9)
    run = cl.simulate(trammel(), until=2.0, samples=101, error=None)
    np.testing.assert_allclose(run["bar"].x, -0.1 * np.cos(run["bar"].theta), atol=1e-15)
    assert run.solver["energy_residual_share"] < 1e-6


def test_a_trammel_with_a_wide_slot_follows_the_ideal_one():
    """Until the first touch takes energy the paths agree within the clearance; the ledger closes
    to 1e-6.
    """
    law = cl.lankarani_nikravesh(stiffness=1e10, restitution=0.9)
    wide = trammel(cl.ClearancePinSlot, radius=0.008, clearance=1e-4, contact=law)
    run = cl.simulate(wide, until=0.3, samples=101, error=None)
    assert np.abs(run["bar"].x + 0.1 * np.cos(run["bar"].theta)).max() < 1.1e-4
    assert run.solver["energy_residual_share"] < 1e-6


def test_joints_without_an_order_of_solution_are_refused():
    """Two welded bodies, each in a slot: the first leaves two coordinates free, the others have one
    equation too many for the second.
    """
    one = cl.Body("one", 1.0, 0.01, points={"p": (-0.1, 0.0)}, angle=0.3)
    two = cl.Body("two", 1.0, 0.01, points={"q": (0.1, 0.0)}, angle=0.3)
    slots = (
        cl.PinSlot(cl.ground, one["p"], name="h"),
        cl.PinSlot(cl.ground, two["q"], axis=(0.0, 1.0), name="v"),
    )
    with pytest.raises(ValueError, match="no order of solution has a place for it: bodies two"):
        build(cl.Scene(*slots, cl.Weld(one, two, name="W")))


def test_a_follower_force_turns_with_its_body():
    """At right angles to a pinned rod it is a constant torque: angle F l t^2 / (2 I), to 1e-9."""
    rod = cl.Body("rod", 1.0, 0.01, points={"pin": (-0.1, 0.0), "end": (0.1, 0.0)})
    scene = cl.Scene(
        cl.Revolute(cl.ground, rod["pin"], name="P"),
        cl.FollowerForce(rod["end"], y=0.5),
        gravity=(0.0, 0.0),
    )
    run = cl.simulate(scene, until=1.0, samples=11, rtol=1e-10)
    np.testing.assert_allclose(run["rod"].theta, 0.5 * 0.2 / 0.02 * run.time**2 / 2.0, atol=1e-8)
    assert np.abs(run.energy.residual).max() < 1e-8
