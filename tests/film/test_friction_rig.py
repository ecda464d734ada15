"""Shaft torque of a friction rig, see paper_figures/elastic_bearing.py: drag, liner, asperities."""

import math

import numpy as np
import pytest
from clearance.paper_figures import elastic_bearing as rig

import clearance as cl
from clearance.film.bearing import RING, WET, Bearing
from clearance.film.conserving import MemoryFilm
from clearance.film.summits import lifted, summits_of
from clearance.laws.worn_asperity import moments

SOURCE = {"source": "Sander et al. 2016, as read off for a test of MBDyn", "unit": "N m"}
RADIUS, CLEARANCE, LENGTH = 23.9e-3, 23.9e-6, 17.2e-3
FILM = rig.bearing_of(rig.JOURNALS[0])


def summit_pressure(gap):
    """Of the rig's asperities at gaps [m], by quadrature [Pa]."""
    ratios = (np.atleast_1d(gap) - 0.6e-6) / rig.ROUGHNESS
    return 1e-3 * 53.3e9 * moments(2.5, ratios)


def film(liner: float, mesh=(96, 8), **more) -> MemoryFilm:
    options = {"asperity": rig.ASPERITIES, "roughness": rig.ROUGHNESS, "drag": RING} | more
    return MemoryFilm(FILM, mesh, liner, False, grading=rig.GRADING, **options)


def test_full_film():
    """The ring is nearer to the rig at each point, 9 % off at most, the wet area more than 12 %."""
    rows = [row for row in rig.ROWS if row[1] >= 1000.0]
    assert len(rows) == 3
    for pressure, speed, value in rows:
        ring, wet = (
            abs(math.log(rig.torque(pressure, speed, rig.LINER, drag) / value))
            for drag in (RING, WET)
        )
        assert ring < 0.09 < 0.12 < wet


@pytest.mark.validation
def test_published(validated):
    """One liner in all bearings: each torque within 35 %, and all within an rms of 0.2 in their
    logarithm, where a rigid bearing has 0.6.

    The bounds are wide because clearances are assumed and the rows are read off a picture.
    """
    apart = rig.deviations(rig.LINER)
    values = np.array([value for *_, value in rig.ROWS])
    assert np.sqrt(np.mean(apart * apart)) <= 0.20
    validated("torque of a friction rig", values * np.exp(apart), values, 0.35, **SOURCE)


@pytest.mark.slow
def test_rigid():
    """A rigid bearing is up to 2.7 times too high in mixed friction, at both loads."""
    apart = rig.deviations(rig.RIGID)
    assert 0.5 < np.sqrt(np.mean(apart * apart)) < 0.75
    assert np.exp(apart).max() > 2.0


@pytest.mark.parametrize("seed", range(8))
def test_gap(seed):
    """H - kappa p_a(H) / c is the gap of smooth surfaces, to 1e-4 of the roughness: the table is
    straight between its nodes. Beyond the summits both are one, and the slope is that of the table.
    """
    rng = np.random.default_rng(seed)
    liner, clearance = 10.0 ** rng.uniform(-15.0, -12.0), 10.0 ** rng.uniform(-5.0, -3.5)
    table = summits_of(rig.ASPERITIES, rig.ROUGHNESS, liner, clearance)
    far = (6.5 * rig.ROUGHNESS + 0.6e-6) / clearance
    assert lifted(far, table) == (far, 1.0)
    low = max(-0.9, -liner * summit_pressure(0.0)[0] / clearance)
    for smooth in rng.uniform(low, far, 40):
        gap, slope = lifted(smooth, table)
        back = gap - liner * summit_pressure(gap * clearance)[0] / clearance
        error = abs(back - smooth) * slope * clearance
        assert error < 1e-4 * rig.ROUGHNESS + 1e-5 * clearance
        width = 1e-9
        rise = (lifted(smooth + width, table)[0] - lifted(smooth - width, table)[0]) / (2 * width)
        assert slope == pytest.approx(rise, abs=2e-3)  # a node may lie between


@pytest.mark.parametrize("eps", [0.97, 1.0, 1.05])
def test_at_rest(eps):
    """Without motion the film has no pressure, and asperities and liner in series carry the load
    of a quadrature around the bearing, to 1 % of a mesh of 192 columns.
    """
    liner = 1e-13
    still = film(liner, (192, 4))
    force = still.steady(eps, 0.0, 0.0)[:2]
    table = summits_of(rig.ASPERITIES, rig.ROUGHNESS, liner, CLEARANCE)

    angle, step = np.linspace(0.0, 0.6, 20001, retstep=True)  # beyond it no summit touches
    smooth = 1.0 - eps * np.cos(angle)
    pressure = np.array([lifted(gap, table)[0] - gap for gap in smooth]) * CLEARANCE / liner
    pressure[0] *= 0.5
    load = 2.0 * RADIUS * LENGTH * step * pressure.sum()
    along = 2.0 * RADIUS * LENGTH * step * (pressure * np.cos(angle)).sum()
    assert still.asperity_load == pytest.approx(load, rel=1e-2)
    assert force == pytest.approx([-along, 0.0], rel=1e-2, abs=1e-2 * load)


def test_far_apart():
    """Summits that do not touch change nothing: the same numbers as of smooth surfaces."""
    rough, smooth = film(2e-13), film(2e-13, asperity=None, roughness=0.0)
    assert rough.steady(0.5, 0.2, 100.0) == pytest.approx(smooth.steady(0.5, 0.2, 100.0), rel=1e-12)
    assert abs(rough.asperity_load) < 1e-9  # rounding


@pytest.mark.parametrize("eps", [1.02, 1.1])
def test_flat_summits(eps):
    """Summits far softer than the liner lie flat in a deep contact: forces are those of smooth
    surfaces, within the 1 % of the load that the film carries beyond the contact.
    """
    soft = cl.greenwood_tripp(modulus=1e3, summit_height=0.0)
    rough, smooth = film(2e-13, asperity=soft), film(2e-13, asperity=None, roughness=0.0)
    motion = eps, 0.0, 30.0
    load = np.linalg.norm(smooth.steady(*motion)[:2])
    assert np.linalg.norm(rough.steady(*motion)[:2]) == pytest.approx(load, rel=1e-2)


def test_softer_liners_take_load_from_asperities():
    """At one load and speed their share falls with the compliance."""
    journal, speed = rig.JOURNALS[0], 200.0 * math.pi / 30.0
    shares = [
        rig.balance(journal, 8e3, speed, liner, RING).asperities for liner in (5e-14, 2e-13, 5e-13)
    ]
    assert 0.4 > shares[0] > shares[1] > shares[2] > 0.05


def test_refusals():
    """Asperities need a liner, a roughness and a steady film."""
    with pytest.raises(ValueError, match="asperities press a liner in"):
        film(0.0)
    with pytest.raises(ValueError, match="roughness"):
        film(1e-13, roughness=0.0)
    with pytest.raises(ValueError, match="asperities are of a steady film"):
        film(1e-13).trial(0.5, 0.0, 0.0, 0.0, 1.0, 1e-3)
    law = cl.asperity(lambda film_thickness_ratio, joint, load=1.0: load)
    with pytest.raises(ValueError, match="no pressure at the local gap"):
        MemoryFilm(Bearing(0.01, 1e-4, 0.02, 0.05), (32, 4), 1e-13, asperity=law(), roughness=1e-6)
