"""Wear: contact on worn outlines, and the laws; rows computed by an independent code."""

import csv
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import clearance as cl
from clearance.laws import FilmJoint
from clearance.laws.outline import (
    NODES,
    STEP,
    Outline,
    deepest,
    touching,
    touching_slopes,
    worn,
    worn_arc,
)
from clearance.laws.wear import is_linear
from clearance.mechanism.build import build
from tests.differences import slopes
from tests.plain import jacobian_error
from tests.typed import python

THETA = STEP * np.arange(NODES)
JOINT = FilmJoint(radius=0.01, clearance=1e-4, length=0.02, viscosity=0.0)
STIFFNESS = 1e12 * JOINT.length * JOINT.radius  # of the rows: K_w L R
FILE = Path(__file__).with_name("wear_profile_rows.csv")
ROWS = {row["id"]: float(row["value"]) for row in csv.DictReader(FILE.read_text().splitlines())}


def scar(depth):
    """Dufrane's arc of a depth at angle 0."""
    return np.maximum((JOINT.clearance + depth) * np.cos(THETA) - JOINT.clearance, 0.0)


def data(bearing=None, journal=None):
    """Numbers of outlines."""
    return Outline(JOINT, worn(bearing=bearing, journal=journal).parameters).numbers


WAVY = data(scar(20e-6), 8e-6 * (1.0 + np.cos(THETA - 1.0)) + 3e-6 * np.cos(5.0 * THETA) ** 2)
PLACES = [(118e-6, 30e-6, 0.37), (60e-6, -115e-6, -2.9), (-104e-6, 12e-6, 8.0)]


class TestContact:
    @pytest.mark.parametrize("penetration", [1e-7, 5e-7, 5e-6, 5e-5])
    def test_unworn_is_winkler(self, penetration):
        """The closed form within 1e-5, wherever the nodes are: the force is right between them
        too.
        """
        law = cl.winkler(layer_modulus=1e12, length=0.02, radius=0.01, radius_difference=1e-4)
        expected, e = law(penetration, 0.0, 0.0), 1e-4 + penetration
        for angle in np.linspace(0.0, 2.0 * STEP, 7):
            x, y = e * math.cos(angle), e * math.sin(angle)
            fx, fy, load, moment = touching(x, y, 0.0, JOINT, data(), 0.0)
            assert STIFFNESS * math.hypot(fx, fy) == pytest.approx(expected, rel=1e-5)
            assert load > math.hypot(fx, fy)
            assert moment == 0.0
            assert deepest(x, y, 0.0, JOINT, data(), 0.0)[0] == pytest.approx(penetration, rel=1e-4)

    @pytest.mark.parametrize("position", PLACES)
    def test_slopes(self, position):
        """Exact derivatives against central differences (1e-6 of the largest of a row)."""
        position = np.array(position)
        actual = np.array(touching_slopes(*position, JOINT, WAVY, 0.0))
        assert tuple(actual[:4]) == touching(*position, JOINT, WAVY, 0.0)
        slope = actual[4:].reshape(4, 3)
        steps = 1e-11, 1e-11, 1e-6
        wanted = slopes(lambda *at: touching(*at, JOINT, WAVY, 0.0), position, steps)
        assert slope == pytest.approx(wanted, rel=1e-6, abs=1e-6 * abs(slope).max())

    @pytest.mark.parametrize("position", PLACES)
    def test_one_energy(self, position):
        """The stiffness is symmetric: force and moment derive from one energy, and no turn gains
        any.
        """
        f = np.array(touching_slopes(*position, JOINT, WAVY, 0.0))
        matrix = np.array([f[4:7], f[7:10], f[13:16]])
        assert matrix == pytest.approx(matrix.T, rel=1e-12)

    def test_deepest_point_and_force_begin_together(self):
        """Along a path through the wall the force is there exactly where the penetration is
        positive.
        """
        for e in np.linspace(1.04e-4, 1.1e-4, 200):
            for angle in (0.0, 0.4, 2.0):
                x, y = e * math.cos(angle), e * math.sin(angle)
                touches = touching(x, y, 0.3, JOINT, WAVY, 0.0)[2] > 0.0
                assert touches == (deepest(x, y, 0.3, JOINT, WAVY, 0.0)[0] > 0.0)

    def test_uniform_wear_is_a_larger_clearance(self):
        """To rounding, on the bearing and on the turning journal."""
        wide = JOINT._replace(clearance=1.2e-4)
        uniform = np.full(NODES, 20e-6)
        expected = touching(1.25e-4, 3e-5, 0.0, wide, data(), 0.0)[:3]
        for numbers in (data(uniform), data(None, uniform)):
            actual = touching(1.25e-4, 3e-5, 1.234, JOINT, numbers, 0.0)
            assert actual[:3] == pytest.approx(expected, rel=1e-9)
            assert actual[3] == pytest.approx(0.0, abs=1e-20)

    def test_turned_together(self):
        """Journal and bearing change places: a journal's scar under a turned journal is a bearing's
        turned back.
        """
        shift = 47
        x, y = 1.18e-4, 2e-5
        actual = touching(x, y, shift * STEP, JOINT, data(None, scar(20e-6)), 0.0)
        expected = touching(x, y, 0.0, JOINT, data(np.roll(scar(20e-6), shift)), 0.0)
        assert actual[:3] == pytest.approx(expected[:3], rel=1e-9)


class TestLaws:
    def test_volume_over_work(self):
        """Archard's volume for load and way, Reye's for work, Sarkar's with friction's share."""
        assert cl.archard(coefficient=1e-13)(2e6, 0.5) == pytest.approx(1e-7, rel=1e-15)
        assert cl.archard_reye(energy_coefficient=1e-12, friction=0.1)(2e6, 0.5) == pytest.approx(
            1e-7, rel=1e-15
        )
        assert cl.sarkar(coefficient=1e-13, friction=0.0)(2e6, 0.5) == cl.archard(
            coefficient=1e-13
        )(2e6, 0.5)
        assert cl.sarkar(coefficient=1e-13, friction=1.0)(2e6, 0.5) == pytest.approx(
            2e-7, rel=1e-15
        )

    def test_linear(self):
        """Laws of the package are linear in the pressure; one's own need not be."""
        assert is_linear(cl.archard(coefficient=1e-13))
        assert not is_linear(beyond_yield(coefficient=1e-13, pressure_limit=1e5))

    def test_wrong_unit(self):
        """mm3/(N m) given as m2/N is off by 1e9 and refused with both readings."""
        with pytest.raises(
            ValueError, match=r"archard: coefficient .* got 0.000505 m2/N = 505000 mm3/\(N m\)"
        ):
            cl.archard(coefficient=5.05e-4)
        assert cl.units.quantity("5.05e-4mm3/Nm", "m2/N") == pytest.approx(5.05e-13, rel=1e-15)


@cl.surface_wear
def beyond_yield(pressure, sliding_speed, coefficient, pressure_limit):
    """Twice the wear beyond a pressure [m/s]."""
    return coefficient * sliding_speed * (pressure + max(pressure - pressure_limit, 0.0))


def slider_crank(**fields):
    """A dry joint C whose fields are changed."""
    scene = cl.load_case("slider_crank", model="dry", contact="winkler", speed=cl.rpm(1000))
    return scene.rebuilt(element=lambda e: replace(e, **fields) if e.name == "C" else e)


class TestJoint:
    def test_unworn_is_bit_equal(self):
        """An unworn outline changes no bit of the motion, nor of the contact's force."""
        plain, unworn = (
            cl.simulate(slider_crank(**f), turns=0.3) for f in ({}, {"outline": worn()})
        )
        assert np.array_equal(plain["slider"].ax, unworn["slider"].ax)
        before, joint = plain.joint("C"), unworn.joint("C")
        assert np.array_equal(before.contact_force, joint.contact_force)
        assert np.array_equal(before.gap, joint.gap)
        assert (joint.normal_load >= joint.contact_force * (1.0 - 1e-4)).all()

    def test_worn_run(self):
        """Both surfaces worn, rubbing: energy closes to 1e-6, both volumes are k int N |v| dt,
        which friction works.
        """
        k, mu = 1e-13, 0.1
        depths = {"bearing": tuple(scar(20e-6)), "journal": tuple(np.roll(scar(5e-6), 90))}
        laws = {"wear": cl.archard(coefficient=k), "wear_journal": cl.archard(coefficient=0.1 * k)}
        friction = cl.coulomb_tanh(coefficient=mu, transition_speed=1e-4)
        result = cl.simulate(
            slider_crank(outline=worn(**depths), friction=friction, **laws), turns=0.3
        )
        joint = result.joint("C")
        energy = result.energy
        assert np.abs(energy.residual).max() < 1e-6 * np.abs(energy.input).max()
        assert joint.wear_volume_bearing[-1] > 0.0
        assert joint.wear_volume_bearing[-1] == pytest.approx(
            10.0 * joint.wear_volume_journal[-1], rel=1e-12
        )
        slow = np.abs(joint.sliding_speed) < 1e-2
        rub = np.abs(joint.friction[~slow])
        assert rub == pytest.approx(mu * joint.normal_load[~slow], rel=1e-9, abs=1e-12)

    def test_jacobian(self):
        """The derivative of a worn joint that touches, against differences (1e-5 of the largest of
        a column).
        """
        depths = {"bearing": tuple(scar(20e-6)), "journal": tuple(np.roll(scar(5e-6), 90))}
        mechanism = build(slider_crank(outline=worn(**depths)))
        size, y = mechanism.size, mechanism.y0.copy()
        index = next(iter(mechanism.places.values()))
        y[index : index + 2] = 5.1e-4, 0.3e-4
        y[size // 2 + index : size // 2 + index + 2] = 0.02, -0.01
        work = mechanism.work0.copy()
        work[0] = 0.5
        assert jacobian_error(mechanism, y, 0.01, work, compiled=True) < 1e-5

    def test_another_outline_compiles_nothing(self):
        """Other depths are other numbers of the same structure."""
        wear = {"wear": cl.archard(coefficient=1e-13)}
        fresh, old = (
            build(slider_crank(outline=worn(bearing=scar(d)), **wear)) for d in (0.0, 3e-5)
        )
        assert fresh.structure is old.structure
        assert fresh.par.size == old.par.size

    def test_without_wear_nothing_is_added(self):
        """No outline: no kernel to follow it, no state, nothing imported."""
        structure = build(slider_crank()).structure
        assert structure.layout.followed == structure.layout.sums == ()
        assert "follow" not in structure.programs
        code = (
            "import sys, clearance as cl; cl.load_case('slider_crank', model='dry'); "
            "print(*sys.modules)"
        )
        modules = python("-c", code).stdout.split()

        of_wear = {f"clearance.{n}" for n in ("laws.wear", "laws.outline", "elements.worn_journal")}
        assert not (of_wear | {"numba"}) & set(modules)

    def test_coefficient_against_the_material(self):
        """A coefficient times the hardness that no pair reaches is warned of, with the numbers."""
        severe, usual, mild = 1e-10, 1e-13, 1e-21
        with cl.simulate(slider_crank(wear=cl.archard(coefficient=severe)), until=1e-4) as run:
            words = [w for w in run.warnings if "the severest dry wear" in w]
        assert words
        assert "archard: coefficient 1e-10 m2/N = 0.1 mm3/(N m) times the hardness of" in words[0]
        with cl.simulate(slider_crank(wear=cl.archard(coefficient=usual)), until=1e-4) as run:
            assert not any("look at its unit" in w for w in run.warnings)
        with cl.simulate(slider_crank(wear=cl.archard(coefficient=mild)), until=1e-4) as run:
            words = [w for w in run.warnings if "look at its unit" in w]
        assert "is 2.1e-12; the mildest wear in oil has 1e-11" in words[0]

    def test_refused(self):
        """Joints that worn outlines cannot stand in, by field and reason."""
        scene = cl.load_case("slider_crank", model="dry", contact="liu")
        joint = next(j for j in scene.joints if j.name == "C")
        with pytest.raises(
            ValueError, match="joint C: worn outlines need a pressure over the arc.* contact is liu"
        ):
            replace(joint, wear=cl.archard(coefficient=1e-13))
        with pytest.raises(ValueError, match="bearing needs 360 depths .* got 3"):
            worn(bearing=[0.0, 0.0, 1e-6])
        with pytest.raises(ValueError, match="journal must not be negative, got -1e-06 m at 7 deg"):
            worn(journal=[0.0] * 7 + [-1e-6] + [0.0] * 352)


@pytest.mark.parametrize("seed", range(5))
def test_a_worn_arc_is_of_a_circle(seed):
    """Of the radius of journal and depth, its centre a clearance from that of the bearing, to
    second order in c / R; deepest in its direction, and nothing where the bearing is as it was.
    """
    draw = np.random.default_rng(seed)
    clearance, direction = 10.0 ** draw.uniform(-5.0, -3.5), draw.uniform(-7.0, 7.0)
    depth, journal = draw.uniform(0.01, 1.99) * clearance, 0.02
    depths = np.array(worn_arc(depth, clearance, direction))
    angles = STEP * np.arange(NODES)
    radii = journal + clearance + depths
    x = radii * np.cos(angles) - clearance * math.cos(direction)
    y = radii * np.sin(angles) - clearance * math.sin(direction)
    inside = depths > 0.0
    assert np.abs(np.hypot(x, y) - journal - depth)[inside].max() < clearance**2 / journal
    width = math.acos(1.0 - depth / clearance)
    away = np.abs((angles - direction + math.pi) % (2.0 * math.pi) - math.pi)
    assert ((away < width) == inside).all()
    assert depth - depths.max() < clearance * (1.0 - math.cos(0.5 * STEP)) * (1.0 + 1e-9)
    mirrored = np.array(worn_arc(depth, clearance, -direction))
    np.testing.assert_allclose(mirrored[1:], depths[:0:-1], atol=1e-12 * clearance)


@pytest.mark.parametrize(
    ("depth", "clearance", "message"),
    [
        (2e-4, 1e-4, "below 2 clearances of 0.0001 m, got 0.0002"),
        (-1e-6, 1e-4, "worn depth must not be negative"),
        (1e-6, 0.0, "clearance must be positive"),
    ],
)
def test_worn_arcs_that_are_none(depth, clearance, message):
    """Numbers without an arc are refused with their name."""
    with pytest.raises(ValueError, match=message):
        worn_arc(depth, clearance, 0.0)
