"""Film between elastic surfaces: line contact, the root of its gap, its part in mixed joints."""

import csv
import math
import random
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import clearance as cl
from clearance.commands.run import _joint_line
from clearance.elements.regimes import film_limits
from clearance.laws.contact import contact_modulus, layer_modulus
from clearance.laws.elastic_gap import centred, gap_scales, mismatch, unfolded
from clearance.laws.law import FilmJoint
from clearance.laws.line_contact import CENTRAL, LEAST, four_regimes
from clearance.laws.materials import Material, steel
from clearance.mechanism.elastic_surfaces import elastic_surfaces
from clearance.metrics.summary import elastic_state
from clearance.results.extremes import Extreme
from clearance.run.force_hole import hole_check
from clearance.studies.explain import explain
from clearance.tracing.kernels import evaluated
from tests.relations import Channels, Mirrored, Renamed, Rotated
from tests.seeds import few_of
from tests.trials import RTOL, Base

ROWS = Path(__file__).parents[1] / "validation" / "line_contact_rows.csv"
RADIUS, CLEARANCE = 0.01, 1e-4


def film_of(m, material, regimes):
    """H of Moes' numbers."""
    return math.exp(four_regimes(math.log(m), math.log(max(material, 1e-12)), regimes))


def test_solved_line_contacts(validated):
    """Central and least film of 40 solved contacts, within the 8 % that the fit is good for."""
    rows = list(csv.DictReader(ROWS.read_text().splitlines()))
    for column, regimes in (("Hc", CENTRAL), ("Hmin", LEAST)):
        pairs = [(film_of(float(r["M"]), float(r["L"]), regimes), r[column]) for r in rows]
        ratios = np.array([film / float(row) for film, row in pairs if row])
        validated(
            f"{column} of line contacts, over solutions with an exact kernel",
            (ratios.min(), ratios.max()),
            (1.0, 1.0),
            0.08,
            source="Newton's method with the kernel of half-spaces",
            kind="independent",
        )


@pytest.mark.parametrize("seed", range(3))
def test_films_grow_with_speed_and_pressure_viscosity(seed):
    """And fall with the load up to L = 4.5; beyond by at most its power 0.06. Rigid limit: 1e-4."""
    draws, step = np.random.default_rng(seed), 1.001
    for _ in range(200):
        m, material = 10.0 ** draws.uniform(-3, 2.5), 10.0 ** draws.uniform(-2, 1.3)
        film = film_of(m, material, CENTRAL)
        heavier = math.log(film_of(step * m, material, CENTRAL) / film) / math.log(step)
        assert heavier < (0.0 if material < 4.5 else 0.06)
        assert film_of(m, step * material, CENTRAL) >= film * (1.0 - 1e-12)
        faster = film_of(m * step**-0.5, material * step**0.25, CENTRAL)
        assert step**0.5 * faster > film
    assert pytest.approx(film_of(1e-3, 1.0, CENTRAL), rel=1e-4) == 2.448 / 1e-3


def drawn(draws):
    """A contact law, the numbers of a line contact, and its state of gap, speed and approach."""
    radius, slender = 10.0 ** draws.uniform(-2.3, -1.5), draws.uniform(0.5, 3.0)
    clearance = radius * 10.0 ** draws.uniform(-3, -1.5)
    soft = Material("soft", 10.0 ** draws.uniform(9.3, 11.3), 0.3, 1e3)
    material = steel if draws.random() < 0.7 else soft
    roughness = min(10.0 ** draws.uniform(-6.7, -5.8), clearance / 10.0)
    joint = FilmJoint(
        radius, clearance, slender * radius, 10.0 ** draws.uniform(-3.3, -1), roughness
    )
    sizes = {"length": joint.length, "radius_difference": clearance}
    modulus = contact_modulus(material, material)
    wall = layer_modulus(material, radius / 2)
    law = [
        cl.winkler(layer_modulus=wall, radius=radius, **sizes),
        cl.johnson(modulus=modulus, **sizes),
        cl.liu(modulus=modulus, **sizes),
    ][draws.integers(3)]
    scales = gap_scales(
        joint, modulus, draws.uniform(0.5e-8, 2.5e-8), roughness, law(roughness, 0.0, 1.0)
    )
    gap = draws.uniform(-4.0, 8.0) * roughness
    speed = draws.choice([-1, 1]) * 10.0 ** draws.uniform(-2.5, 1)
    return law, joint, scales, [gap, speed, draws.choice([-1, 1]) * 10.0 ** draws.uniform(-6, -2)]


def solved(law, joint, scales, state):
    """film, rigid film and the two rates."""
    function = evaluated(elastic_surfaces(law.law))
    numbers = joint.clearance, joint.roughness, 1e-3, *scales, *law.values.values()
    return np.array(function(*state, *numbers))


@pytest.mark.parametrize("seed", range(40))
def test_root_of_the_gap(seed):
    """By bisection: film 1 %, rigid film 8 %, what two steps of Newton leave; mostly 1e-4. Both are
    positive and finite, the rates are shares.
    """
    law, joint, scales, state = drawn(np.random.default_rng(seed))
    gap, speed, approach = state
    low, high = -90.0, 0.0
    for _ in range(80):
        z = 0.5 * (low + high)
        film, deflection = unfolded(z, gap)
        load = law(deflection, 0.0, 1.0)
        numbers = film, deflection, load, speed, approach, scales[5], 1e-3, scales[:4]
        miss, ratio = mismatch(*numbers)
        low, high = (low, z) if miss > 0.0 else (z, high)
    values = solved(law, joint, scales, state)
    wanted = film, film * math.exp(ratio)
    middle = centred(gap, joint.clearance)
    wanted = [(1.0 - middle) * w + middle * gap for w in wanted]
    np.testing.assert_allclose(values[0], wanted[0], rtol=0.01)
    np.testing.assert_allclose(values[1], wanted[1], rtol=0.08)
    assert (values > 0.0).all()
    assert values[3] <= 1.0


@pytest.mark.parametrize("seed", few_of(range(12), 4))
def test_slopes_of_the_gap_are_exact(seed):
    """Central differences of 1e-4 of the state, to 1e-4 of the slope's size; no jump at h_0 = 0."""
    law, joint, scales, state = drawn(np.random.default_rng(100 + seed))
    slopes = evaluated(elastic_surfaces(law.law).slopes((0, 1, 2)))
    numbers = joint.clearance, joint.roughness, 1e-3, *scales, *law.values.values()
    exact = np.reshape(slopes(*state, *numbers)[4:], (4, 3))
    values = solved(law, joint, scales, state)
    for k, size in enumerate((joint.roughness, abs(state[1]), abs(state[2]))):
        ends = []
        for sign in (1, -1):
            moved = list(state)
            moved[k] += sign * 1e-4 * size
            ends.append(solved(law, joint, scales, moved))
        np.testing.assert_allclose(
            exact[:, k] * size, (ends[0] - ends[1]) / 2e-4, atol=1e-4 * np.abs(values).max()
        )
    sides = [solved(law, joint, scales, [s * 1e-9 * joint.roughness, *state[1:]]) for s in (1, -1)]
    np.testing.assert_allclose(*sides, rtol=1e-6)


@pytest.mark.parametrize("seed", range(6))
def test_rest_is_dry_contact(seed):
    """Without entrainment and approach the deflection is the overlap, to 1e-6 of it."""
    law, joint, scales, state = drawn(np.random.default_rng(seed))
    gap = -abs(state[0])
    film, *_ = solved(law, joint, scales, [gap, 0.0, 0.0])
    assert film - gap == pytest.approx(-gap, rel=1e-6)


def feeder(**options):
    return cl.load_case("six_bar_feeder", model="mixed", **options)


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("transition", ["fuzzy", "load_sharing"])
def test_no_hole_and_never_below_dry_contact(transition, seed):
    """The load grows with every step inwards, at rest and closing, with at least that of the
    contact at the overlap (2 %: what a film of finite length carries less).
    """
    draws = np.random.default_rng(seed)
    options = {
        "clearance": 10.0 ** draws.uniform(-4.3, -3.5),
        "viscosity": 10.0 ** draws.uniform(-3.3, -2.3),
    }
    joint = feeder(transition=transition, elastic="true", **options).clearance_joints[0]
    entrainment, approach = draws.uniform(12, 190), draws.choice([0.0, 1e-3, 1e-2])
    hole = hole_check(joint, entrainment, approach)
    assert hole.monotone
    dry = [joint.contact(-ratio * joint.roughness, 0.0, 1.0) for ratio in hole.ratio]
    assert (np.array(hole.load) >= 0.98 * np.array(dry)).all()


@pytest.mark.parametrize("transition", ["fuzzy", "load_sharing"])
def test_summits_count_once(transition):
    """Asperities that touch are how the contact carries: the solids carry the larger of both loads
    (2 %). Their sum would be up to a quarter more.
    """
    asperity = None if transition == "load_sharing" else cl.greenwood_tripp()
    scene = feeder(transition=transition, elastic="true", viscosity=1e-3, friction="none")
    scene = scene.rebuilt(
        element=lambda part: (
            replace(part, asperity=asperity)
            if asperity and isinstance(part, cl.ClearanceRevolute)
            else part
        )
    )
    joint = cl.simulate(scene, turns=2).joint("B")
    law = scene.clearance_joints[0]
    share = joint.membership_dry
    if transition == "load_sharing":
        ratio = joint.elastic_film / law.roughness
        share = np.array([math.erfc(r / math.sqrt(2.0)) for r in ratio])
    deflection = joint.elastic_film - joint.gap
    alone = share * [law.contact(d, 0.0, 1.0) for d in deflection]
    summits = joint.asperity_force
    larger, solid = np.maximum(alone, summits), joint.contact_force + summits
    carries = larger > 1.0
    more = solid[carries] / larger[carries] - 1.0
    assert summits.max() > 100.0
    assert more.min() >= 0.0
    assert more.max() < 0.02


@pytest.mark.parametrize("joints", ["B", pytest.param("B,C,E", marks=pytest.mark.slow)])
@pytest.mark.parametrize("seed", few_of(range(50), 2))
def test_random_feeders_run(joints, seed):
    """All complete, with energy to 1e-5 of the turnover; the film is positive at every moment."""
    draws = np.random.default_rng(seed)
    result = cl.simulate(
        feeder(
            elastic="true",
            joints=joints,
            speed=cl.rpm(draws.uniform(60, 900)),
            clearance=draws.uniform(5e-5, 3e-4),
            viscosity=10.0 ** draws.uniform(-3.3, -2.3),
        ),
        turns=2,
    )
    assert result.complete
    assert result.solver["energy_residual_share"] < 1e-5
    joint = result.joint("B")
    assert (joint.elastic_film > 0.0).all()
    assert (joint.rigid_film > 0.0).all()
    states = joint.membership_full_film + joint.membership_mixed + joint.membership_dry
    np.testing.assert_allclose(states, 1.0, atol=1e-12)


@pytest.mark.parametrize("kind", [Rotated, Mirrored, Renamed])
@pytest.mark.parametrize("case", ["four_bar", pytest.param("slider_crank", marks=pytest.mark.slow)])
def test_the_frame_decides_nothing(case, kind):
    """A rotated, a mirrored and a renamed mechanism move alike, within a thousand times the
    tolerance of the runs; their energy closes to 1e-5 of the turnover.
    """
    rng = random.Random(5)
    options = {"viscosity": 0.002, "clearance": rng.uniform(5e-5, 2e-4), "elastic": "true"}
    scene = cl.load_case(case, model="mixed", **options)
    change, span = kind(rng, scene), {"until": 0.3 * scene.turn}
    one, other = (cl.simulate(s, rtol=RTOL, samples=101, **span) for s in (scene, change.of(scene)))
    assert max(r.solver["energy_residual_share"] for r in (one, other)) < 1e-5
    Base(scene, span, Channels(one)).agree(Channels(other), change, kind.__name__)


def test_lanes_agree(tmp_path):
    """The same points one by one: largest forces within 2e-3, of two runs at rtol 1e-6."""
    points = cl.grid(
        speed=np.linspace(cl.rpm(120), cl.rpm(400), 5), clearance=np.linspace(6e-5, 2e-4, 5)
    )
    fixed = {"model": "mixed", "viscosity": 0.005, "friction": "none", "elastic": "true"}
    options = {"fixed": fixed, "turns": 2.0, "channels": [], "workers": 1}
    sweep = cl.sweep("six_bar_feeder", points, tmp_path / "m", **options)
    assert str(sweep.ways).startswith("25 points in lanes")
    for row in range(0, 25, 6):
        values = points[row]
        run = cl.simulate(cl.load_case("six_bar_feeder", **fixed, **values), turns=2)
        peak = run.extreme("joints/B/force_max", begin=run.turn).value
        assert sweep.metrics["joint_B_force_max"][row] == pytest.approx(peak, rel=2e-3)


@pytest.mark.parametrize("law", [cl.greenwood_tripp, cl.greenwood_williamson])
def test_summits_above_the_mean_surface(law):
    """They take their height off the film: the load at h is that of others at h - height, but for
    the arc, which goes by the eccentricity (1 %).
    """
    joint = FilmJoint(0.01, 1e-4, 0.02, 0.005, 0.8e-6)
    high, low = law(modulus=1e11, summit_height=0.6e-6), law(modulus=1e11)
    for ratio in (-1.0, 0.5, 2.0, 4.0):
        assert high(ratio, joint) == pytest.approx(low(ratio - 0.75, joint), rel=0.01)


def test_a_run_says_where_it_is_elastic(typed, tmp_path):
    """M and L of the thinnest film, regime and film over rigid film: printed, and in the report.
    M, L and the ratio of the films are those of the law at that load and speed (rounding).
    """
    path = tmp_path / "run.h5"
    case = "run six_bar_feeder -p model=mixed -p elastic=true -p viscosity=0.002"
    printed = typed(f"{case} --turns 2 -o", path).out
    assert "of the rigid film" in " ".join(printed.split())
    run = cl.open_result(path)
    state = elastic_state(run, run.described("B"))
    film, rigid = (run.values(f"joints/B/{n}") for n in ("elastic_film", "rigid_film"))
    at, m = film.argmin(), state["moes_load"]
    assert state["film_over_rigid"] == pytest.approx(film[at] / rigid[at])
    ratio = m / 2.448 * film_of(m, state["moes_material"], CENTRAL)
    assert state["film_over_rigid"] == pytest.approx(ratio, rel=0.1)  # film of finite length
    assert 0.0 < state["load_in_mixed"] < 1.0
    thinnest = run.metrics(settle=0)["joint_B_elastic_film_min"].value
    assert 0.99 * film.min() <= thinnest <= film.min()  # located between samples
    early = elastic_state(run, run.described("B"), end=run.time[at - 1])  # a part has its own film
    assert early["least_elastic_film"] == film[:at].min() > film[at]
    typed("report", path, "-o", tmp_path / "run.html")
    assert "Moes" in (tmp_path / "run.html").read_text()


def test_a_layer_is_of_columns():
    """A joint with a layer is refused, by the name of the film that is meant for it."""
    joint = feeder(elastic="true").clearance_joints[0]
    with pytest.raises(ValueError, match="columns: take the film elastic"):
        replace(joint, layer=1e-3)


def test_true_stands_for_the_law():
    """A joint takes true and false where cases take them: the law, and none."""
    joint = feeder(elastic="true").clearance_joints[0]
    assert replace(joint, elastic=True) == joint
    assert replace(joint, elastic=False) == replace(joint, elastic=None)


def test_rigid_joints_have_nothing_of_it():
    """No output, number or operation; and what has no such state is refused by name."""
    rigid = feeder()
    assert rigid.clearance_joints[0].elastic is None
    contents = explain(rigid)
    assert not any("elastic" in path for path in contents["channels"])
    assert "elastic" in contents["left_out"]
    assert not any("elastic" in call for k in contents["kernels"].values() for call in k["calls"])
    for options, words in (
        ({"transition": "flores"}, "no state of elastic surfaces"),
        ({"transition": "fuzzy(squeeze=0)"}, "datum and squeeze"),
        ({"wear": 1e-15, "film": "short"}, "worn outlines"),
    ):
        with pytest.raises(ValueError, match=words):
            feeder(elastic="true", **options)


class Liner(dict):
    """A record of paths alone, a sample a second."""

    @property
    def time(self) -> np.ndarray:
        return np.arange(len(next(iter(self.items()))[1]), dtype=float)

    def values(self, path: str) -> np.ndarray:
        return self[path]

    def extreme(self, name: str, begin: float, end: float) -> Extreme:
        inside = (self.time >= begin) & (self.time <= end)
        return Extreme(self[name.removesuffix("_min")][inside].min(), 0.0)


def test_a_film_on_a_liner_has_its_thinnest_place():
    """The least film of the samples between two times, also printed; its gap is nominal."""

    record = Liner({"joints/F/film_least": np.array([1e-9, 3e-8, 2e-8])})
    state = elastic_state(record, {"name": "F", "roughness": 1e-8}, 1.0, 2.0)
    assert state == pytest.approx({"least_elastic_film": 2e-8, "least_elastic_ratio": 2.0})
    assert elastic_state(record, {"name": "F"}, 1.0, 1.5) == {"least_elastic_film": 3e-8}
    printed = _joint_line({"smallest_gap": -1e-6, **state})
    assert "smallest nominal gap -1" in printed
    assert printed.endswith("thinnest film 0.02 um on the elastic surfaces (2 roughnesses)")


def test_a_film_on_a_layer_has_its_state():
    """Motion where the layer is pressed most, and the film over the rigid one with that load
    (1e-6, bisection). Behind the wall the deflection is above the film.
    """
    radius, clearance, liner, eps, motion = 1e-2, 1e-4, 1e-13, 0.9, (1e-3, 2e-4)
    unit = FilmJoint(1.0, 1.0, 1.0, 1.0)  # L/D = 0.5
    load = cl.table_film()(eps, motion[1] / 12.0, motion[0] / 6.0, unit)
    load = math.hypot(*load[:2]) * clearance * radius * radius / liner
    rows = {
        "film_least": [4e-5, 3e-5, 5e-5, 6e-5],
        "film_middle": [4e-5, 4e-5, 5e-5, 6e-5],
        "gap": [3e-5, -1e-5, 5e-5, 6e-5],
        "film_radial": [0.0, load, load, load],
        "film_tangential": [0.0] * 4,
        "film_wedge": [0.0, motion[0], 0.0, 0.0],
        "film_squeeze": [0.0, motion[1], 0.0, 0.0],
    }
    record = Liner({f"joints/F/{name}": np.array(row) for name, row in rows.items()})
    joint = {"radius": radius, "clearance": clearance, "length": radius, "film": {"liner": liner}}
    state = elastic_state(record, {"name": "F", **joint})
    assert (state["wedge_number"], state["squeeze_number"]) == motion
    assert state["film_over_rigid"] == pytest.approx(0.3 / (1.0 - eps), rel=1e-6)
    assert state["deflection_over_film"] == pytest.approx(1.25)
    assert state["time_in_elastic"] == 0.25
    assert state["load_in_elastic"] == pytest.approx(1.0 / 3.0)
    printed = _joint_line(state | {"film_pressure": 2e8, "piezoviscous_number": 4.0})
    assert "between rigid and elastic, piezoviscous) where it is pressed most" in printed
    assert "elastic in 25% of the time and 33% of the load" in printed


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("film_least_min", 4e-12, "thins to 4e-12 m; below 1e-09 m, a molecule of oil"),
        ("film_wedge_max", 38.0, "C_w reaches 38"),
        ("film_squeeze_max", 2.0, "C_s reaches 2"),
    ],
)
def test_limits_of_a_film_on_a_layer(name, value, words):
    """A film thinner than a molecule, and a layer that is too soft, have words of their own."""
    film = "elastic(liner=1e-13,pressure_viscosity=0)"
    joint = cl.load_case("six_bar_feeder", model="lubricated", film=film).clearance_joints[0]
    sign, limit, text = next(limit for end, *limit in film_limits(joint) if end == name)
    assert sign * value > sign * limit
    assert words in text.format(value)
