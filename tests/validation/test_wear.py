"""Wear against an independent code: contact, asperities and films on outlines, replayed loads."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import clearance as cl
from clearance.laws import FilmJoint
from clearance.laws.contact import contact_modulus
from clearance.laws.materials import steel
from clearance.laws.outline import deepest, touching
from clearance.laws.worn_asperity import moment_and_slope, pressed, row_of
from clearance.laws.worn_film import short_on_outlines
from clearance.wearing.load_path import LoadPath, Worn
from clearance.wearing.replay import rest
from tests.laws import test_mixed_wear, test_wear
from tests.wearing import test_life

CODE = {"source": "plain code of worn joints", "kind": "independent"}


@pytest.mark.parametrize(
    ("depth", "e", "angle", "first"), [(0.0, 102e-6, 20.0, 1), (20e-6, 122e-6, 0.0, 8)]
)
def test_contact(depth, e, angle, first, validated):
    """Force, normal load and penetration on an unworn outline and in a scar."""
    x, y = e * math.cos(math.radians(angle)), e * math.sin(math.radians(angle))
    numbers, joint = test_wear.data(test_wear.scar(depth)), test_wear.JOINT
    actual = [test_wear.STIFFNESS * v for v in touching(x, y, 0.0, joint, numbers, 0.0)[:3]]
    rows = [test_wear.ROWS[f"U{first + i:02d}"] for i in range(3)]
    size = {"unit": "N", "relative": rows[2]}
    validated("force and normal load on a worn outline", actual, rows, 1e-3, **size, **CODE)
    lowest = deepest(x, y, 0.0, joint, numbers, 0.0)[0]
    row = test_wear.ROWS[f"U{first + 6:02d}"]
    validated("penetration on a worn outline", lowest, row, 1e-3, unit="m", **CODE)


@pytest.mark.parametrize(("ratio", "first"), [(0.5, 29), (2.0, 35)])
def test_asperities(ratio, first, validated):
    """Largest pressure, force and normal load of rough steel, place by place."""
    joint, rows = test_mixed_wear.ROUGH, test_mixed_wear.ROWS
    strength = cl.greenwood_tripp.pressure[1](contact_modulus(steel, steel), 0.04, 1e-3)
    e = joint.clearance - ratio * joint.roughness
    fx, _, load, _ = pressed(e, 0.0, 0.0, row_of(2.5), joint, test_mixed_wear.data(), 0.0)
    area = strength * joint.radius * joint.length
    peak = strength * moment_and_slope(ratio, 0)[0]
    row = rows[f"U{first}"]
    validated("largest pressure of the asperities", peak, row, 1e-5, unit="Pa", **CODE)
    loads = [rows[f"U{first + 1}"], rows[f"U{first + 2}"]]
    actual = -area * fx, area * load
    validated("force and normal load of the asperities", actual, loads, 1e-5, unit="N", **CODE)


@pytest.mark.parametrize(("motion", "first"), [((0.0, 0.0, 1.0), 25), ((0.3, -0.2, 1.0), 27)])
def test_short_film(motion, first, validated):
    """Film force of a short bearing in a scar with sharp edges, which fall between nodes."""
    journal = 0.8 * math.cos(math.radians(20.0)), 0.8 * math.sin(math.radians(20.0))
    numbers = test_mixed_wear.data(test_mixed_wear.scar(0.3 * test_mixed_wear.CLEARANCE))
    joint, rest = test_mixed_wear.SHORT, (0.0, 0.0, 0.0)
    fx, fy, _ = short_on_outlines(*journal, *motion, *rest, joint, numbers, 0.0)
    row = test_mixed_wear.ROWS[f"P{first}"], test_mixed_wear.ROWS[f"P{first + 1}"]
    actual = complex(fx, fy) / test_mixed_wear.UNIT
    validated("film force of a worn short bearing", actual, complex(*row), 1e-3, **CODE)


RADIUS, CLEARANCE, LENGTH = test_life.RADIUS, test_life.CLEARANCE, test_life.LENGTH
FORCE, MODULUS = test_life.FORCE, test_life.MODULUS
ARCHARD = cl.archard(coefficient=test_life.COEFFICIENT)
TENTH = cl.archard(coefficient=0.1 * test_life.COEFFICIENT)
SURFACE = 2.0 * math.pi * RADIUS * LENGTH  # of the journal
FORMS = {"source": "closed forms of worn joints", "kind": "exact"}


def along(rates, start, turns):
    """State after so many turns of a load path, d state / d phi = rates(state) (1e-11)."""
    end = 2.0 * math.pi * turns
    return solve_ivp(
        lambda _, state: rates(*state), (0.0, end), start, method="DOP853", rtol=1e-11, atol=1e-20
    ).y[:, -1]


def arc_sum(half):
    """a + sin a cos a of half an arc a."""
    return half + math.sin(half) * math.cos(half)


def resting(clearance):
    """Eccentricity of an unworn journal under the load, by the law of the contact."""
    numbers = {"length": LENGTH, "radius": RADIUS, "radius_difference": clearance}
    law = cl.winkler(layer_modulus=MODULUS, **numbers)
    depth = brentq(lambda d: law(d, 0.0, 0.0) - FORCE, 0.0, CLEARANCE, xtol=1e-18, rtol=1e-14)
    return clearance + depth


def pressing(e, clearance):
    """Normal load on an unworn foundation."""
    half = math.acos(clearance / e)
    return 2.0 * MODULUS * RADIUS * LENGTH * (e * math.sin(half) - clearance * half)


def test_rigid_law(validated):
    """Form A, rigid: the pressure F cos / (R L (a + sin a cos a)) wears a scar and its volume.

    It begins at the scar of 100 turns, where the form has a slope.
    """
    rows = test_life.ROWS

    def rates(e, volume):
        half = math.acos(CLEARANCE / e)
        peak = FORCE / (RADIUS * LENGTH * arc_sum(half))
        load = 2.0 * RADIUS * LENGTH * peak * math.sin(half)
        return ARCHARD(peak, RADIUS), ARCHARD(load, RADIUS)

    half = rows["W01"]
    begin = 2.0 * RADIUS * LENGTH * CLEARANCE * (math.tan(half) - half)
    e, volume = along(rates, (CLEARANCE + rows["W02"], begin), 4900)
    validated("depth by the law, rigid", e - CLEARANCE, rows["W06"], 1e-6, unit="m", **FORMS)
    validated("volume by the law, rigid", volume, rows["W08"], 1e-6, unit="m3", **FORMS)
    peak = FORCE / (RADIUS * LENGTH * arc_sum(math.acos(CLEARANCE / e)))
    validated("largest pressure, rigid", peak, rows["W07"], 1e-6, unit="Pa", **FORMS)


@pytest.mark.parametrize(("turns", "first"), [(10, 13), (1000, 19)])
def test_elastic_law(turns, first, validated):
    """Form B, an elastic layer: the journal sinks with its scar, and the place below it wears by
    the pressure that is left.
    """
    modulus, rows = MODULUS, test_life.ROWS

    def rates(e, depth, load, volume):
        half = math.acos(CLEARANCE / e)
        peak = modulus * (e - CLEARANCE - depth)
        sinks = ARCHARD(FORCE, 1.0) / (LENGTH * arc_sum(half))
        worn = ARCHARD(load, RADIUS)
        more = 2.0 * modulus * RADIUS * LENGTH * sinks * math.sin(half) - modulus * worn
        return sinks, ARCHARD(peak, RADIUS), more, worn

    start = resting(CLEARANCE)
    validated("eccentricity, unworn layer", start, rows["W12"], 1e-6, unit="m", **FORMS)
    begin = (start, 0.0, pressing(start, CLEARANCE), 0.0)
    e, depth, _, volume = along(rates, begin, turns)
    actual, expected = [e, depth], [rows[f"W{first}"], rows[f"W{first + 2}"]]
    validated("eccentricity and depth by the law, layer", actual, expected, 1e-6, unit="m", **FORMS)
    peak, row = modulus * (e - CLEARANCE - depth), rows[f"W{first + 1}"]
    validated("pressure by the law, layer", peak, row, 1e-6, unit="Pa", **FORMS)
    if turns == 1000:
        validated("volume by the law, layer", volume, rows["W25"], 1e-6, unit="m3", **FORMS)


def test_journal_law(validated):
    """Form C, a journal that turns under its load loses its radius all around."""

    def rates(lost):
        clearance = CLEARANCE + lost
        return (ARCHARD(pressing(resting(clearance), clearance), RADIUS) / SURFACE,)

    actual = [along(rates, (0.0,), turns)[0] for turns in (100, 5000)]
    rows = [test_life.ROWS[row] for row in ("W27", "W29")]
    validated("radius lost by the law, journal", actual, rows, 1e-6, unit="m", **FORMS)
    rigid = 5000 * 2.0 * math.pi * ARCHARD(FORCE, RADIUS) / SURFACE
    row = test_life.ROWS["W30"]
    validated("radius lost by the law, rigid journal", rigid, row, 1e-6, unit="m", **FORMS)


def test_both_laws(validated):
    """Form D: the bearing wears, and its journal a tenth as fast, all around."""

    def rates(e, load, lost):
        half = math.acos((CLEARANCE + lost) / e)
        thins = TENTH(load, RADIUS) / SURFACE
        sinks = ARCHARD(FORCE, 1.0) / LENGTH + 2.0 * thins * math.sin(half)
        sinks /= arc_sum(half)
        foundation = MODULUS * RADIUS * LENGTH
        more = 2.0 * foundation * (sinks * math.sin(half) - thins * half)
        return sinks, more - MODULUS * ARCHARD(load, RADIUS), thins

    start = resting(CLEARANCE)
    e = along(rates, (start, pressing(start, CLEARANCE), 0.0), 1000)[0]
    row = test_life.ROWS["W31"]
    validated("eccentricity by both laws", e, row, 1e-6, unit="m", **FORMS)


@pytest.mark.parametrize(("turns", "depth"), [(10, "W15"), (1000, "W21")])
def test_load_at_rest(turns, depth, validated):
    """Depth under a load at rest on an elastic layer, by jumps."""
    end, _ = test_life.replayed(test_life.standing(), turns)
    exact = {"source": "elastic layer under a load at rest", "kind": "exact", "unit": "m"}
    row = test_life.ROWS[depth]
    validated("depth under a load at rest", float(end.bearing[0]), row, 1e-3, **exact)


def test_jumps(validated):
    """Forms A, C and D by jumps: rigid bodies, a journal worn all around, both surfaces."""
    rows, stiff = test_life.ROWS, 1000.0 * MODULUS
    end, _ = test_life.replayed(test_life.standing(), 5000, stiff)
    validated("depth by jumps, rigid", end.bearing[0], rows["W06"], 1e-3, unit="m", **FORMS)
    path = test_life.standing(180, 0.0, test_life.COEFFICIENT)
    end, _ = test_life.replayed(path, 5000)
    lost, row = float(end.journal.mean()), rows["W29"]
    validated("radius lost by jumps, journal", lost, row, 1e-3, unit="m", **FORMS)
    end, _ = test_life.replayed(
        test_life.standing(60, test_life.COEFFICIENT, 0.1 * test_life.COEFFICIENT), 1000
    )
    joint, scale = FilmJoint(0.0, CLEARANCE, 0.0, 0.0, 0.0), MODULUS * RADIUS * LENGTH
    e = rest((-FORCE, 0.0, 0.3), end.position[0], joint, end.data, None, 0.0, scale)[0]
    validated("eccentricity by jumps, both", e, rows["W31"], 1e-4, unit="m", **FORMS)


def test_both_surfaces(validated):
    """Depths and volumes of a turn and of 1000 turns, bearing and journal worn."""
    path, rows = test_life.turning(), test_life.ROWS
    path_of_turn = LoadPath(path, test_life.MODULUS, test_life.RADIUS * test_life.LENGTH)
    end = path_of_turn.step(Worn.of(test_life.UNWORN, path, True), 1.0)
    actual = np.array([end.bearing[270], end.bearing[315], end.journal[30]])
    row = [rows[name] for name in ("W34", "W36", "W38")]
    validated("depths of a turn, both surfaces", actual, row, 3e-4, unit="m", **CODE)
    volumes = [rows["W40"]] * 2
    validated("volumes of a turn, both surfaces", end.volumes, volumes, 1e-4, unit="m3", **CODE)
    end, _ = test_life.replayed(path, 1000)
    actual, row = [end.bearing[270], end.journal[90]], [rows["W48"], rows["W52"]]
    validated("depths of 1000 turns, both surfaces", actual, row, 2e-3, unit="m", **CODE)


@pytest.mark.slow
def test_wear_a(tmp_path, validated):
    """Set wear-A after 21,400 turns, by the load path of its second turn alone.

    The row has a load path that never changes. A life has one that falls as the slider comes nearer
    to the anchor of its spring. It is 1.2e-3 below the row, by jumps and run turn by turn.
    """
    life = cl.wear("wear_a", turns=1, directory=tmp_path, settle=1, average=1, rtol=1e-4)
    joint = next(j for j in cl.load_case("wear_a").clearance_joints)
    path, surface = life.load_path("B"), joint.radius * joint.contact_length
    path_of_turn = LoadPath(path, joint.contact.values["layer_modulus"], surface)
    end, _, _ = path_of_turn.over(Worn.of(test_life.UNWORN, path, False), 21400.0, 1e-3)
    actual, row = float(end.bearing.max()), test_life.ROWS["W63"]
    validated("depth of wear-A, load path of one turn", actual, row, 1e-3, unit="m", **CODE)
