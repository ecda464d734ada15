"""Films on worn outlines: rows of an independent code, and what must be true of any outline."""

import csv
import math
import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import clearance as cl
from clearance.film.bearing import Bearing
from clearance.film.conserving import MemoryFilm
from clearance.film.online import MemoryAnswer
from clearance.laws import FilmJoint
from clearance.laws.outline import Outline, worn
from clearance.laws.worn_film import short_on_outlines
from clearance.machine.callback import SLOPES, VALUE
from tests import mechanisms as m
from tests.differences import slopes
from tests.seeds import few_of

FILE = Path(__file__).with_name("worn_film_rows.csv")
ROWS = [
    r for r in csv.DictReader(FILE.read_text().splitlines()) if not r["case"].startswith("short")
]
RADIUS, CLEARANCE, VISCOSITY = 0.01, 1e-5, 0.02
FINE = 0.1  # deg between depths of an outline whose edges are sharp


def scar(depth, step=FINE):
    """Dufrane's arc of a depth over c at angle 0 [m]."""
    theta = np.deg2rad(np.arange(0.0, 360.0, step))
    return CLEARANCE * np.maximum((1.0 + depth) * np.cos(theta) - 1.0, 0.0)


def film(slenderness, full=False, mesh=(96, 6), **outlines):
    """The memoryless film of a bearing, and the unit of the rows' forces [N]."""
    length = 2.0 * slenderness * RADIUS
    joint = FilmJoint(RADIUS, CLEARANCE, length, VISCOSITY)
    bearing = Bearing.of(joint, ambient=1e13 if full else None)
    unit = VISCOSITY * (RADIUS / CLEARANCE) ** 2 * RADIUS * length
    return MemoryFilm(bearing, mesh, 0.0, False, **outlines), unit


@cache
def of_row(kind, depth):
    """The film of some rows on 192 x 12 cells; a long bearing is one of L/D 5000."""
    long = kind.startswith("long")
    return film(5000.0 if long else 0.5, long, (192, 12), outline=scar(depth))


@pytest.mark.parametrize(
    "row", few_of(ROWS[::3] + ROWS[1::3] + ROWS[2::3], len(ROWS[::3])), ids=lambda r: r["id"]
)
def test_rows(row):
    """Forces of long full films and of finite ones with P >= 0, within 2e-3 of the force."""
    pattern = r"d=([\d.]+) eps=([\d.]+) at ([-\d.]+) deg, (.*)"
    depth, eps, angle, motion = re.match(pattern, row["given"]).groups()
    if "=" in motion:
        spin, vx, vy = (float(v) for v in re.findall(r"-?[\d.]+", motion))
    else:
        rates = dict(part.split() for part in [motion])
        spin, vx, vy = (float(rates.get(n, 0.0)) for n in ("spin", "vx", "vy"))
    solver, unit = of_row(row["case"], float(depth))
    x, y = (float(eps) * f(math.radians(float(angle))) for f in (math.cos, math.sin))
    fx, fy = solver.trial(x, y, vx, vy, spin, 0.0)[:2, 0] / unit
    actual = fx if row["quantity"] == "Fx" else fy
    assert actual == pytest.approx(float(row["value"]), abs=2e-3 * math.hypot(fx, fy))


def test_linear_and_symmetric():
    """A full film is linear in (vx, vy, spin); its damping is symmetric (1e-9 of the largest)."""
    solver, _ = film(0.5, True, outline=scar(0.3))
    journal = 0.5, 0.3

    def force(vx, vy, spin):
        return solver.trial(*journal, vx, vy, spin, 0.0)[:2, 0].copy()

    units = [force(*row) for row in np.eye(3)]
    size = np.abs(units).max()
    mixed = force(0.3, -0.2, 0.7)
    assert mixed == pytest.approx(0.3 * units[0] - 0.2 * units[1] + 0.7 * units[2], abs=1e-9 * size)
    assert units[0][1] == pytest.approx(units[1][0], abs=1e-3 * size)


def test_lift_is_uniform_wear():
    """A lift of the gap all around gives what an outline deeper by it does, to rounding."""
    depths, state = scar(0.2, 1.0), (0.6, 0.3, 0.2, -0.1, 20.0, 0.0)
    lifted, _ = film(0.5, outline=depths)
    deeper, _ = film(0.5, outline=depths + 0.05 * CLEARANCE)
    here = lifted.trial(*state, 0.0, 0.05)
    np.testing.assert_allclose(here, deeper.trial(*state), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("lift_rate", [0.0, 3.0, -3.0])
def test_lifted_film_of_a_short_bearing(lift_rate):
    """A lift and its rate as in the closed form of a short bearing; L/D 0.02 is within 2e-2."""
    depths = 0.1 * CLEARANCE * (1.0 + np.cos(np.deg2rad(np.arange(360.0))))
    motion, lift = (0.6, 0.3, 0.2, -0.1, 20.0), 0.05
    long, _ = film(0.02, mesh=(192, 6), outline=depths)
    joint = FilmJoint(RADIUS, CLEARANCE, 0.04 * RADIUS, VISCOSITY)
    numbers = Outline(None, worn(bearing=depths).parameters).numbers
    short = short_on_outlines(*motion, 0.0, lift, lift_rate, joint, numbers, 0.0)[:2]
    force = long.trial(*motion, 0.0, 0.0, lift, lift_rate)[:2, 0]
    assert force == pytest.approx(short, abs=2e-2 * math.hypot(*short))


def test_slopes_by_lift():
    """The answer's derivatives by lift and its rate, against wider differences (1e-3)."""
    depths = tuple(scar(0.2, 1.0))
    law = cl.conserving_film(mesh=(48, 4), memory=False)
    joint = FilmJoint(RADIUS, CLEARANCE, RADIUS, VISCOSITY)
    answer = MemoryAnswer(joint, dict(law.settings) | {"bearing": depths, "journal": None})
    state = np.array([0.6, 0.3, 0.2, -0.1, 20.0, 0.0, 0.05, 1.0, 0.0])
    actual = np.array(answer._solve(SLOPES, list(state)))

    def force(*lift):
        return np.array(answer._solve(VALUE, [*state[:6], *lift, 0.0]))[:2, 0]

    expected = slopes(force, state[6:8], (1e-4, 1e-2))
    assert actual[:2, 7:9] == pytest.approx(expected, rel=1e-3)


def test_uniform_wear_is_a_larger_clearance():
    """Bearing and journal worn evenly: the film of the larger clearance, to rounding."""
    even = np.full(360, 0.2 * CLEARANCE)
    joint = FilmJoint(RADIUS, 1.2 * CLEARANCE, RADIUS, VISCOSITY)
    wide = MemoryFilm(Bearing.of(joint), (96, 6), 0.0, False)
    expected = wide.trial(0.5, 0.1, 0.2, -0.1, 1.0, 0.0)[:2, 0]
    for outlines in ({"outline": even}, {"journal": even}):
        solver, _ = film(0.5, **outlines)
        actual = solver.trial(0.6, 0.12, 0.24, -0.12, 1.0, 0.0, 0.7)[:2, 0]
        assert actual == pytest.approx(expected, rel=1e-9)


def test_surfaces_change_places():
    """A worn journal is a worn bearing seen from the journal, which turns the other way (1e-3 of
    the force).
    """
    x, y, vx, vy, spin = 0.5, 0.2, 0.1, -0.2, 0.9
    seen = vx + spin * y, vy - spin * x, -spin
    on_journal, on_bearing = (
        film(0.5, True, (192, 8), **{surface: scar(0.3)})[0].trial(x, y, *motion, 0.0)[:2, 0]
        for surface, motion in (("journal", (vx, vy, spin)), ("outline", seen))
    )
    assert on_journal == pytest.approx(on_bearing, abs=1e-3 * np.hypot(*on_bearing))


def test_derivatives():
    """Exact by place, rates and spin, both surfaces worn, against differences (1e-5 of the largest
    of a column).
    """
    solver, _ = film(0.5, mesh=(48, 4), outline=scar(0.3, 1.0), journal=np.roll(scar(0.2, 1.0), 40))
    motion = np.array([0.55, 0.25, 0.2, -0.1, 1.0])
    actual = solver.trial(*motion, 1e-3, 0.4)[:2].copy()
    expected = slopes(lambda *at: solver.trial(*at, 1e-3, 0.4)[:2, 0], motion, 1e-6)
    assert (np.abs(actual[:, 1:6] - expected) <= 1e-5 * np.abs(expected).max(axis=0)).all()


@pytest.mark.slow
def test_journal_rests_in_its_scar():
    """A lubricated journal under a load at rest stands in a scar, farther off than the clearance,
    on a film.
    """
    ratios = []
    for depth in (0.0, 0.3):
        body = cl.Body("rotor", 0.5, 1e-4)
        joint = m.film(
            cl.ground,
            body,
            "B",
            clearance=CLEARANCE,
            viscosity=VISCOSITY,
            length=RADIUS,
            film=cl.conserving_film(memory=False, mesh=(48, 3)),
            outline=worn(bearing=scar(depth, 1.0)),
            eccentricity=((0.9 + depth) * CLEARANCE, 0.0),
        )
        load = cl.Force(body.at(0, 0), x=2000.0, name="load")
        scene = cl.Scene(joint, load, cl.Drive(body, speed=100.0), gravity=(0, 0), name="rotor")
        result = cl.simulate(scene, until=5e-3, rtol=1e-4, samples=21)
        assert result.joint("B").gap.min() > 0.0
        assert np.abs(result.energy.residual).max() < 1e-3 * np.abs(result.energy.input).max()
        ratios.append(result.joint("B").eccentricity_ratio[-1])
    assert ratios[0] < 1.0 < ratios[1]
