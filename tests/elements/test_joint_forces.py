"""A clearance joint between real bodies: entrainment, torques, friction at the contact point,
momentum balance.
"""

import math

import numpy as np
import pytest

import clearance as cl
from clearance import laws
from clearance.laws import pinkus_sternlicht
from clearance.mechanism.build import build
from tests import mechanisms as m
from tests.plain import observed
from tests.seeds import few_of

C = 1e-4


def pair(joint=m.film, spin_a=0.0, spin_b=0.0, ratio=0.6, rate=(0.0, 0.0), **more):
    """Two free spinning bodies on soft springs, joined by one clearance joint; no gravity."""
    a = cl.Body("bearing", 1.3, 2e-3, angular_velocity=spin_a)
    b = cl.Body("journal", 0.7, 1e-3, angular_velocity=spin_b)
    return cl.Scene(
        joint(
            a.at(0, 0),
            b.at(0, 0),
            "J",
            C,
            eccentricity=(ratio * C, 0.0),
            eccentricity_rate=rate,
            **more,
        ),
        cl.SpringDamper(cl.ground.at(1, 0), a, stiffness=1e-9),
        gravity=(0.0, 0.0),
    )


def test_entrainment_is_the_sum_of_the_spins_less_twice_the_whirl():
    """Half-speed whirl: omega_J + omega_B = 2 gamma' leaves a film without wedge; the difference
    form would not.
    """
    spin_a, spin_b = 30.0, 90.0
    whirl = 0.5 * (spin_a + spin_b)
    row = observed(build(pair(spin_a=spin_a, spin_b=spin_b, rate=(0.0, whirl * 0.6 * C))))
    still = observed(build(pair(spin_a=spin_a, spin_b=spin_b)))
    scale = math.hypot(still["joints/J/film_radial"], still["joints/J/film_tangential"])
    assert abs(row["joints/J/film_radial"]) < 1e-9 * scale
    assert abs(row["joints/J/film_tangential"]) < 1e-9 * scale


@pytest.mark.parametrize("direction", [0.0, 1.0, 2.5, -2.0])
def test_film_in_any_direction(direction):
    """The force on the journal is the law's, turned into the line of centres."""
    rate = np.array([0.02, -0.01])
    turn = np.array(
        [[math.cos(direction), -math.sin(direction)], [math.sin(direction), math.cos(direction)]]
    )
    scene = pair(spin_a=20.0, spin_b=-70.0, rate=tuple(turn @ rate))
    object.__setattr__(scene.joints[0], "eccentricity", tuple(turn @ [0.6 * C, 0.0]))
    row = observed(build(scene))
    expected = pinkus_sternlicht()(
        0.6, rate[0] / C, -50.0 - 2 * rate[1] / (0.6 * C), scene.joints[0]
    )
    actual = turn.T @ [row["joints/J/force_x"], row["joints/J/force_y"]]
    assert actual == pytest.approx(expected, rel=1e-12)


STEEL = laws.contact_modulus(cl.steel, cl.steel)
WINKLER = laws.winkler(layer_modulus=1e13, length=0.02, radius=0.01, radius_difference=C)
MIXED = {
    "none": {"transition": laws.superposed()},
    "flores": {"transition": laws.flores_hybrid()},
    "fuzzy": {"transition": laws.fuzzy()},
    "load_sharing": {
        "transition": laws.load_sharing(),
        "asperity": laws.greenwood_tripp(modulus=STEEL),
    },
    "lugre": {"transition": laws.load_sharing(), "friction": laws.lugre(static=0.2, kinetic=0.1)},
}
OTHERS = "none", "flores", "fuzzy"


def mixed(name, ratio, **more):
    """A film and a contact together at some eccentricity, sliding and closing."""
    slots = (
        {"friction": cl.coulomb(coefficient=0.2), "contact": WINKLER, "roughness": 1e-6}
        | MIXED[name]
        | more
    )
    return pair(spin_a=20.0, spin_b=-70.0, rate=(0.01, 0.03), ratio=ratio, **slots)


@pytest.mark.parametrize(
    "kind", few_of(["film", "dry", "load_sharing", "none", "flores", "fuzzy", "lugre"], 3)
)
@pytest.mark.parametrize("ratio", [0.6, 0.99, 1.01])
def test_momentum_and_angular_momentum_are_kept(kind, ratio):
    """A joint's forces are internal: total force and total moment about a fixed point vanish; 1e-11
    of the terms.
    """
    if kind == "film":
        scene = pair(spin_a=20.0, spin_b=-70.0, rate=(0.01, 0.03), ratio=min(ratio, 0.99))
    elif kind == "dry":
        scene = pair(m.dry, 20.0, -70.0, 1.01, (0.01, 0.03), friction=cl.coulomb(coefficient=0.2))
    else:
        scene = mixed(kind, ratio)
    row = observed(build(scene))
    force, moment, size = np.zeros(2), 0.0, 0.0
    for body in scene.bodies:
        f = body.mass * np.array([row[f"bodies/{body.name}/ax"], row[f"bodies/{body.name}/ay"]])
        x, y = row[f"bodies/{body.name}/x"], row[f"bodies/{body.name}/y"]
        spin = body.inertia * row[f"bodies/{body.name}/alpha"]
        force += f
        moment += spin + x * f[1] - y * f[0]
        size += abs(spin)
    assert np.abs(force).max() < 2e-9 + 1e-11 * np.hypot(
        row["joints/J/force_x"], row["joints/J/force_y"]
    )
    assert size > 0.0
    assert abs(moment) < 1e-11 * size + 1e-11


@pytest.mark.parametrize("name", few_of(["load_sharing", *OTHERS], 1))
@pytest.mark.parametrize("ratio", [0.5, 0.985, 0.995, 1.002])
def test_mixed_force_is_its_parts(name, ratio):
    """Shares, film, asperities and contact put together by hand give the compiled joint's force;
    1e-12.
    """
    scene = mixed(name, ratio, friction=None)
    joint, row = scene.joints[0], observed(build(scene))
    facts = joint.film_joint
    film, gap, slope, share, depth, *states = joint.transition((1.0 - ratio) * C, facts)
    w = 20.0 - 70.0 - 2.0 * 0.03 / (C - gap)  # the film turns as its own eccentricity does
    radial, tangential = joint.film(1.0 - gap / C, slope * 0.01 / C, w, facts)
    touching = not joint.impacts or ratio > 1.0
    push = share * joint.contact(depth, 0.01, 0.0) if touching else 0.0
    if joint.asperity is not None:
        push += joint.asperity((1.0 - ratio) * C / 1e-6, facts)
    assert row["joints/J/force_x"] == pytest.approx(film * radial - push, rel=1e-9)
    assert row["joints/J/force_y"] == pytest.approx(film * tangential, rel=1e-9, abs=1e-9)
    actual = [row[f"joints/J/membership_{s}"] for s in ("full_film", "mixed", "dry")]
    assert actual == pytest.approx(states, abs=1e-12)


def test_asperities_rub():
    """Boundary friction acts on the load of contact and asperities together."""
    row = observed(build(mixed("load_sharing", 0.999)))
    load = row["joints/J/contact_force"] + row["joints/J/asperity_force"]
    assert row["joints/J/asperity_force"] > 0.0
    assert row["joints/J/friction"] == pytest.approx(0.2 * load, rel=1e-3)


def test_only_what_was_chosen_is_there():
    """Outputs and states are those of the laws that a joint has."""
    plain, entire = observed(build(pair())), observed(build(mixed("lugre", 0.9)))
    for name in (
        "membership_dry",
        "asperity_force",
        "contact_force",
        "friction",
        "bristle_deflection",
    ):
        assert f"joints/J/{name}" not in plain
    assert "joints/J/asperity_force" not in entire
    assert build(mixed("lugre", 0.9)).size == build(mixed("fuzzy", 0.9)).size + 1


def test_leaving_the_drag_out_breaks_the_balance():
    """The negative of the test above: forces at the two centres alone have the net moment e F_t."""
    row = observed(build(pair(spin_a=20.0, spin_b=-70.0, film_torques=False)))
    assert row["bodies/journal/alpha"] == 0.0
    assert row["joints/J/film_tangential"] != 0.0


def test_friction_turns_both_bodies_and_takes_energy():
    """Friction slows the journal, drags the bearing and loses power."""
    scene = pair(m.dry, 0.0, 100.0, 1.01, (0.0, 0.0), friction=cl.coulomb(coefficient=0.2))
    row = observed(build(scene))
    assert row["bodies/journal/alpha"] < 0.0 < row["bodies/bearing/alpha"]
    assert row["joints/J/power_loss"] > 0.0
    normal, tangential = row["joints/J/contact_force"], row["joints/J/friction"]
    assert tangential == pytest.approx(-0.2 * normal, rel=1e-4)
    assert row["joints/J/force_x"] == pytest.approx(-normal, rel=1e-12)


def test_film_thickness_ratio_only_with_roughness():
    """The ratio is the gap over the roughness, where there is one."""
    rough = observed(build(pair(roughness=1e-6)))
    assert rough["joints/J/film_thickness_ratio"] == pytest.approx(0.4 * C / 1e-6, rel=1e-12)
    assert "joints/J/film_thickness_ratio" not in observed(build(pair()))


def test_centred_journal_has_no_direction_and_no_trouble():
    """A concentric journal is damped along its motion only."""
    row = observed(build(pair(ratio=0.0, rate=(0.0, 0.01), spin_b=50.0)))
    p0 = 0.05 * 0.02 * 0.01**3 / C**2
    assert row["joints/J/force_y"] == pytest.approx(-6 * math.pi * p0 * 0.01 / C, rel=1e-6)
    assert abs(row["joints/J/force_x"]) < 1e-6 * abs(row["joints/J/force_y"])


def leaning(friction, torque=0.02):
    """A journal at the bottom of a fixed bearing, turned by a torque below what friction can
    hold.
    """
    body = cl.Body("journal", 1.0, 1e-4)
    contact = laws.hunt_crossley_memoryless(stiffness=1e10, dissipation=50.0)
    joint = cl.ClearanceRevolute(
        cl.ground.at(0, 0),
        body.at(0, 0),
        name="J",
        radius=0.01,
        clearance=C,
        contact=contact,
        friction=friction,
        eccentricity=(0.0, -1.0005 * C),
    )
    return cl.Scene(joint, cl.Torque(body, torque))


def test_lugre_holds_what_smooth_friction_lets_creep():
    """With bristles the journal rolls to and fro about the place where its weight holds the torque
    (drifting by less than a fiftieth); regularised friction creeps, where it gives the torque:
    v / sqrt(v^2 + v_t^2) = 2 N / (0.5 N_n).
    """
    smooth, sticking = (
        cl.simulate(leaning(f), until=3.0, rtol=1e-6)
        for f in (
            cl.coulomb(coefficient=0.5),
            laws.lugre(static=0.5, kinetic=0.5, stiffness=1e6, damping=1e3),
        )
    )
    share = 2.0 / (0.5 * math.sqrt(9.81**2 - 2.0**2))
    creep = 1e-3 * share / math.sqrt(1.0 - share**2) / 0.01
    late = smooth.time > 1.0
    slope = [np.polyfit(r.time[late], r["journal"].theta[late], 1)[0] for r in (smooth, sticking)]
    assert slope[0] == pytest.approx(creep, rel=0.02)
    assert abs(slope[1]) < 0.02 * creep
    assert sticking.solver["energy_residual_share"] < 1e-4
