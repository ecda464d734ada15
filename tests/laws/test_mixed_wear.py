"""Wear of mixed joints: asperities and films on worn outlines; rows of an independent code."""

import csv
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import clearance as cl
from clearance.laws import FilmJoint
from clearance.laws.outline import NODES, edges, worn
from clearance.laws.worn_asperity import (
    Rough,
    moment_and_slope,
    moments,
    pressed,
    pressed_slopes,
    row_of,
)
from clearance.laws.worn_film import short_on_outlines, short_slopes
from clearance.wearing.load_path import LoadPath, Worn
from tests.differences import slopes
from tests.laws.test_wear import THETA, WAVY, data, scar

HERE = Path(__file__).parents[1]
FILES = (HERE / "laws" / "wear_profile_rows.csv", HERE / "film" / "worn_film_rows.csv")
ROWS = {
    row["id"]: float(row["value"])
    for file in FILES
    for row in csv.DictReader(file.read_text().splitlines())
}
CLEARANCE, ROUGHNESS = 1e-4, 8e-7
ROUGH = FilmJoint(radius=0.01, clearance=CLEARANCE, length=0.02, viscosity=0.0, roughness=ROUGHNESS)
SHORT = FilmJoint(radius=0.01, clearance=CLEARANCE, length=0.005, viscosity=0.02)
UNIT = SHORT.viscosity * (SHORT.radius / SHORT.clearance) ** 2 * SHORT.radius * SHORT.length


def check_slopes(function, actual, position, steps, *others):
    """Exact derivatives against central differences (1e-6 of the largest of a column)."""
    count = len(function(*position, *others))
    assert tuple(actual[:count]) == pytest.approx(function(*position, *others), rel=1e-12)
    expected = slopes(lambda *at: function(*at, *others), position, steps)
    off = np.abs(np.array(actual[count:]).reshape(expected.shape) - expected)
    assert (off <= 1e-6 * np.abs(expected).max(axis=0) + 1e-12).all()


class TestAsperities:
    @pytest.mark.parametrize("law", [cl.greenwood_tripp, cl.greenwood_williamson])
    def test_sum_over_the_arc_is_the_law(self, law):
        """Unworn, the force is that of the law's closed form (1e-3: its gap is a parabola)."""
        bound = law(modulus=1e11)
        order, factor = bound.law.pressure
        strength = factor(*bound.numbers) * ROUGH.radius * ROUGH.length
        for ratio in (0.3, 1.0, 3.0):
            e = CLEARANCE - ratio * ROUGHNESS
            fx = pressed(e, 0.0, 0.0, row_of(order), ROUGH, data(), 0.0)[0]
            assert -strength * fx == pytest.approx(bound(ratio, ROUGH), rel=2e-3)

    @pytest.mark.parametrize("order", [2.5, 1.5])
    def test_moments(self, order):
        """The table of F_n against its integral, 1e-5."""
        ratios = np.array([-3.3, -0.51, 0.0, 0.77, 2.9, 5.9])
        actual = [moment_and_slope(r, row_of(order))[0] for r in ratios]
        exact = moments(order, ratios)
        assert actual == pytest.approx(exact, rel=1e-5, abs=1e-9)

    def test_slopes_and_energy(self):
        """Exact slopes on two worn surfaces; the stiffness is symmetric, for one energy is
        behind.
        """
        position, others = np.array([118e-6, 30e-6, 0.37]), (0, ROUGH, WAVY, 0.0)
        actual = pressed_slopes(*position, *others)
        assert actual[2] > 0.0
        check_slopes(pressed, actual, position, (1e-11, 1e-11, 1e-6), *others)
        matrix = np.array([actual[4:7], actual[7:10], actual[13:16]])
        assert matrix == pytest.approx(matrix.T, rel=1e-12)


def film_in_scar(depth, at, way, share, motion):
    """Error of the short film's force over its load; share: of the way to the wall."""
    fine = np.linspace(0.0, 2.0 * math.pi, 72_000, endpoint=False)
    c, s = np.cos(fine), np.sin(fine)
    worn = np.maximum((1.0 + depth) * np.cos(fine - at) - 1.0, 0.0)
    along = np.maximum(np.cos(fine - way), 1e-9)
    e = (1.0 - share) * ((1.0 + worn) / along).min()
    x, y = e * math.cos(way), e * math.sin(way)
    bearing = CLEARANCE * np.maximum((1.0 + depth) * np.cos(THETA - at) - 1.0, 0.0)
    actual = short_on_outlines(x, y, *motion, 0.0, 0.0, 0.0, SHORT, data(bearing), 0.0)[:2]
    slope = np.where(worn > 0.0, -(1.0 + depth) * np.sin(fine - at), 0.0)
    source = 6.0 * motion[2] * (x * s - y * c + slope) - 12.0 * (motion[0] * c + motion[1] * s)
    pressure = np.where(source < 0.0, source / (1.0 - x * c - y * s + worn) ** 3, 0.0)
    pressure *= UNIT * (SHORT.length / SHORT.radius) ** 2 / 12.0 * 2.0 * math.pi / fine.size
    off = actual[0] - pressure @ c, actual[1] - pressure @ s
    return math.hypot(*off) / abs(pressure.sum())


class TestShortFilm:
    def test_ranges10_deep_scars(self):
        """Of 100 places in scars of 0.03 to 1 c, as against the integral over 72,000 angles: 2e-3
        of the load at films of 0.05 c or more. At 0.01 c nine in ten have 1e-2.

        Cells beside an edge are summed at three places. With one it was off by up to 1e-2 and 0.2.
        """
        rng, thin = np.random.default_rng(3), []
        for _ in range(100):
            depth, at = 10.0 ** rng.uniform(-1.5, 0.0), rng.uniform(0.0, 2.0 * math.pi)
            way, share = at + rng.uniform(-1.0, 1.0), 10.0 ** rng.uniform(-2.0, -0.3)
            motion = (*(0.3 * rng.normal(size=2)), rng.normal())
            error = film_in_scar(depth, at, way, share, motion)
            thin += [error] if share < 0.05 else []
            assert share < 0.05 or error < 2e-3
        assert np.quantile(thin, 0.9) < 1e-2

    def test_edges(self):
        """Edges of Dufrane's arc by its closed form (1e-3 of a cell), none on smooth outlines."""
        exact = math.degrees(math.acos(1.0 / 1.3))
        places = sorted(node + t for node, t, *_ in edges(scar(0.3 * CLEARANCE)))
        assert places == pytest.approx([exact, 360.0 - exact], abs=1e-3)
        assert edges(8e-6 * (1.0 + np.cos(3.0 * THETA))) == []
        assert edges(np.zeros(NODES)) == []

    def test_edges_of_straight_flanks(self):
        """A ramp that begins anywhere: bends of straight lines are rounding (1e-6 of a cell)."""
        for begin in 1.0 + 3e-3 * np.arange(400):
            ramp = np.where(THETA < 4.0, np.clip(THETA - begin, 0.0, 0.7), 0.0)
            places = np.array([node + t for node, t, *_ in edges(1e-6 * ramp)])
            assert np.abs(places - math.degrees(begin)).min() < 1e-6

    def test_smooth_outlines(self):
        """Smooth outlines on both surfaces: the integral over 7200 angles, within 1e-4."""
        turned, position, motion = 0.4, (0.5, 0.3), (0.2, -0.1, 1.0)
        wave, ripple = (
            (lambda t: 0.1 * (1.0 + np.cos(t - 1.0))),
            (lambda t: 0.05 * np.sin(2 * t) ** 2),
        )
        numbers = data(CLEARANCE * wave(THETA), CLEARANCE * ripple(THETA))
        actual = short_on_outlines(*position, *motion, turned, 0.0, 0.0, SHORT, numbers, 0.0)
        fine = np.linspace(0.0, 2.0 * math.pi, 7200, endpoint=False)
        c, s, ours = np.cos(fine), np.sin(fine), fine - turned
        gap = 1.0 - position[0] * c - position[1] * s + wave(fine) + ripple(ours)
        slopes = -0.1 * np.sin(fine - 1.0) - 0.1 * np.sin(4.0 * ours)
        drag = 6.0 * motion[2] * (position[0] * s - position[1] * c + slopes)
        source = drag - 12.0 * (motion[0] * c + motion[1] * s)
        pressure = np.where(source < 0.0, source / gap**3, 0.0)
        share = UNIT * (SHORT.length / SHORT.radius) ** 2 / 12.0 * 2.0 * math.pi / fine.size
        expected = share * (pressure @ c), share * (pressure @ s)
        assert actual[:2] == pytest.approx(expected, rel=1e-4)

    def test_unworn(self):
        """The closed form of the short bearing, within 1e-4."""
        closing, turning, spin, eps = 0.1, 0.3, 1.0, 0.8
        expected = cl.laws.short_film()(eps, closing, spin - 2.0 * turning, SHORT)
        state = eps, 0.0, closing, eps * turning, spin
        actual = short_on_outlines(*state, 0.0, 0.0, 0.0, SHORT, data(), 0.0)
        assert actual[:2] == pytest.approx(expected, rel=1e-4)

    def test_slopes(self):
        """Exact by place, rates, spin, angle and lift; squeezing is symmetric."""
        state, others = np.array([0.5, 0.3, 0.2, -0.1, 1.0, 0.37, 0.01, 0.05]), (SHORT, WAVY, 0.0)
        actual = short_slopes(*state, *others)
        check_slopes(short_on_outlines, actual, state, [1e-6] * 8, *others)
        assert actual[3 + 3] == pytest.approx(actual[3 + 8 + 2], rel=1e-12)

    def test_lift_is_a_larger_clearance(self):
        """A gap lifted all around is that of uniform wear, to rounding."""
        state = 0.5, 0.3, 0.2, -0.1, 1.0, 0.37
        lifted = short_on_outlines(*state, 0.2, 0.0, SHORT, data(), 0.0)
        even = data(np.full(NODES, 0.2 * CLEARANCE))
        assert lifted == pytest.approx(
            short_on_outlines(*state, 0.0, 0.0, SHORT, even, 0.0), rel=1e-9
        )


WEAR = 1e-15
LOAD = 400.0


def rotor(speed, start=4.8e-5, **fields):
    """A short mixed bearing of steel under a load at rest; lubricated alone for a fast journal."""
    body = cl.Body("rotor", 0.5, 1e-4)
    laws = {
        "contact": cl.winkler(layer_modulus=1e13, restitution=0.5),
        "film": cl.laws.short_film(),
        "transition": cl.laws.load_sharing(),
        "asperity": cl.greenwood_tripp(),
        "wear": cl.archard(coefficient=WEAR),
        "length": 0.008,
    }
    joint = cl.ClearanceRevolute(
        cl.ground,
        body,
        name="B",
        radius=0.01,
        clearance=5e-5,
        roughness=ROUGHNESS,
        lubricant=cl.Lubricant(0.05),
        eccentricity=(start, 0.0),
        **laws | fields,
    )
    load = cl.Force(body.at(0, 0), x=LOAD, name="load")
    drive = cl.Drive(body, speed=speed, name="d")
    return cl.Scene(joint, load, drive, gravity=(0, 0), name="rotor")


class TestJoint:
    @pytest.mark.slow
    def test_asperities_wear_and_the_film_does_not(self):
        """Slow: volume k int N |v| dt of the solids' load (1e-3 by samples), the ledger closes.

        Fast: a full film carries, and the asperities' load falls by more than 1e6.
        """
        loads = []
        for speed in (5.0, 200.0):
            result = cl.simulate(rotor(speed), turns=1)
            joint, time = result.joint("B"), result.time
            work = np.trapezoid(joint.normal_load * np.abs(joint.sliding_speed), time)
            if speed == 5.0:
                volume = joint.wear_volume_bearing[-1]
                assert volume == pytest.approx(WEAR * work, rel=1e-3)
                assert result.facts("joints/B/wear")["bins_error"] < 1e-6
                assert 0.02 < joint.asperity_share[-1] < 0.5
            residual = np.abs(result.energy.residual).max()
            assert residual < 1e-6 * np.abs(result.energy.input).max()
            loads.append(joint.normal_load[-1])
        assert loads[1] < 1e-6 * loads[0]

    def test_solids_and_film_carry_the_load(self):
        """At rest in the bearing film and asperities together carry the load, within 1e-3."""
        joint = cl.simulate(rotor(5.0), turns=2).joint("B")
        assert joint.force_x[-1] == pytest.approx(-LOAD, rel=1e-3)
        film = math.hypot(joint.film_radial[-1], joint.film_tangential[-1])
        assert film < LOAD < film + 1.1 * joint.asperity_force[-1]

    def test_worn_and_unworn_agree(self):
        """An even wear of a 100th of the roughness changes the load share by less than 3 %."""
        shares = []
        for depth in (0.0, 0.01 * ROUGHNESS):
            outline = worn(bearing=[depth] * NODES)
            joint = cl.simulate(rotor(5.0, outline=outline), turns=1).joint("B")
            shares.append(joint.asperity_share[-1])
        assert shares[1] == pytest.approx(shares[0], rel=3e-2)

    @pytest.mark.slow
    def test_conserving_film(self):
        """A conserving film and the asperities carry the load together, within 1e-3.

        It yields more than the short bearing's near the wall, so the solids carry more, and wear
        by k int N |v| dt (1e-3).
        """
        shares = []
        for film in (cl.laws.short_film(), cl.conserving_film(mesh=(64, 4), memory=False)):
            scene = rotor(20.0, length=0.004, film=film, outline=worn(bearing=[2e-7] * NODES))
            result = cl.simulate(scene, turns=0.05, rtol=1e-4)
            facts, joint = result.facts("joints/B/wear"), result.joint("B")
            assert joint.wear_volume_bearing[-1] == pytest.approx(WEAR * facts["rubbing"], rel=1e-3)
            assert joint.force_x[-1] == pytest.approx(-LOAD, rel=1e-3)
            shares.append(joint.asperity_share[-1])
        assert shares[0] < shares[1] < 0.9

    def test_fuzzy(self):
        """The weighted contact wears, beyond the thresholds nothing does."""
        fields = {"transition": cl.laws.fuzzy(), "asperity": None}
        slow = cl.simulate(rotor(1.0, **fields), turns=0.02)
        facts, volume = slow.facts("joints/B/wear"), slow.joint("B").wear_volume_bearing[-1]
        assert volume > 0.0
        assert volume == pytest.approx(WEAR * facts["rubbing"], rel=1e-3)
        assert facts["bins_error"] < 1e-3
        away = cl.simulate(rotor(200.0, start=4e-5, **fields), turns=1)
        assert away.joint("B").film_thickness_ratio.min() > 1.0
        assert away.joint("B").wear_volume_bearing[-1] == 0.0

    def test_refused(self):
        """Films, asperities and transitions that worn outlines have no form of, with the reason."""
        joint = next(j for j in rotor(5.0).joints if j.name == "B")
        with pytest.raises(ValueError, match="film alone wears nothing"):
            replace(joint, contact=None, transition=None, asperity=None)
        with pytest.raises(ValueError, match="film harmonic has no worn outline; short_film and"):
            replace(joint, film=cl.laws.harmonic())
        with pytest.raises(ValueError, match="load_sharing, got fuzzy"):
            replace(joint, transition=cl.laws.fuzzy())
        with pytest.raises(ValueError, match="needs a roughness from 1.25e-08 m"):
            replace(joint, roughness=1e-8)

    def test_lubricated_case_has_no_wear(self):
        """A case's wear is left out of joints with a film alone."""
        scene = cl.load_case("slider_crank", model="lubricated", film="short", wear=1e-15)
        assert all(j.wear is None for j in scene.clearance_joints)


class TestLife:
    @pytest.mark.slow
    def test_asperities_without_strength(self):
        """The replay of rough surfaces whose asperities carry nothing is that of smooth ones
        (3e-3).

        The pressure sums over nodes there, and over cells here.
        """
        phases = 12
        angle = 2.0 * math.pi * (np.arange(phases) + 0.5) / phases
        over = np.full(phases, 1e-13 * 2.0 * math.pi * 0.01 / phases)
        columns = [np.full(phases, -1000.0), np.zeros(phases), angle, over, 0.1 * over]
        path = np.column_stack([*columns, np.full(phases, CLEARANCE)])
        solids = Rough(1e12, ROUGHNESS, 1e-3, 0)
        ends = []
        for rough in (None, solids):
            begin = Worn.of(data(), path, True)
            ends.append(LoadPath(path, 1e12, 2e-4, rough).over(begin, 500.0, 1e-3)[0])
        smooth, rough = ends
        assert rough.bearing.max() == pytest.approx(smooth.bearing.max(), rel=3e-3)
        assert rough.volumes == pytest.approx(smooth.volumes, rel=3e-3)

    @pytest.mark.slow
    def test_jumps(self, tmp_path):
        """A mixed life in long jumps meets one in jumps of a tenth, within the error it states."""
        options = {"turns": 400, "settle": 1, "average": 1}
        long = cl.wear(rotor(5.0), directory=tmp_path / "long", **options)
        short = cl.wear(rotor(5.0), directory=tmp_path / "short", jump_turns=40.0, **options)
        apart = abs(long.depth("B")[-1].max() - short.depth("B")[-1].max())
        assert apart < long.error[-1] + short.error[-1]
        assert long.error[-1] < 0.1 * long.depth("B")[-1].max()
        assert len(long.stages) < len(short.stages)
