"""The drag of a film: of the filled ring, or of the area that oil wets.

Raimondi and Boyd's friction is the ring's (test_published.py). rows/rig.csv is the shaft torque
over speed of a friction rig: Sander et al., Tribol. Int. 96 (2016) 173, as maintainers of MBDyn
read it off for a test of theirs. Its clearances are their assumption. Nothing there states that the
curve is measured.
"""

import math

import pytest

from clearance.film.bearing import RING, WET, Bearing, Groove
from clearance.film.conserving import MemoryFilm
from clearance.film.moving import MovingFilm
from clearance.film.names import conserving, fast, fem, table
from clearance.laws import FilmJoint
from clearance.laws.film import wet_film_torques
from clearance.scene.law_names import film_of
from tests.film import states

JOINT = FilmJoint(1e-2, 1e-4, 2e-2, 0.05)
OIL = 6.8e-3  # of the rig at 100 C [Pa s]


def filled(eps: float) -> float:
    """Integral of 1 / H all around."""
    return 2.0 * math.pi / math.sqrt(1.0 - eps * eps)


@pytest.mark.parametrize("film", [table, fast, fem])
@pytest.mark.parametrize("state", [(0.3, 0.0, 30.0), (0.9, 5.0, 30.0), (0.7, -8.0, 4.0)])
def test_ring(film, state):
    """By default the drag is that of the filled ring, to rounding; the wet area has less, and the
    same force.
    """
    ring, wet = film()(*state, JOINT), film(drag=WET)(*state, JOINT)
    assert ring[2] == pytest.approx(filled(state[0]), rel=1e-12)
    assert 0.2 * ring[2] < wet[2] < 0.97 * ring[2]
    # elements settle to 1e-8 of the largest pressure, from what they solved before
    assert ring[:2] == pytest.approx(wet[:2], rel=1e-7, abs=1e-7 * math.hypot(*ring[:2]))


def test_memory():
    """A cavity drags as if full, or with its content; oil under pressure drags more than thin oil
    on either.
    """
    shears = []
    for oil in (0.0, 2e-8):
        of = states.bearing(viscosity=0.5, pressure_viscosity=oil, grooves=(Groove(math.pi),))
        shears += [MemoryFilm(of, (64, 6), drag=d).steady(0.7, 0.0, 60.0)[2] for d in (RING, WET)]
    ring, wet, thick_ring, thick_wet = shears
    assert ring == pytest.approx(filled(0.7), rel=1e-3)  # Simpson's rule on 64 cells
    assert 0.5 * ring < wet < 0.97 * ring
    assert thick_ring - ring == pytest.approx(thick_wet - wet, rel=0.1) != 0.0


def test_ambient():
    """A table with a third axis has the ring too."""
    law = table(ambient=2e5, nodes=9, mesh=(32, 4))
    assert law(0.8, 1.0, 30.0, JOINT)[2] == pytest.approx(filled(0.8), rel=1e-12)


def torque(load: float, speed: float, drag: str) -> float:
    """Of the rig's shaft [N m]: a bearing that carries the load between two that carry half."""
    total = 0.0
    for diameter, length, share, count in ((47.8e-3, 17.2e-3, 1.0, 1), (54e-3, 25e-3, 0.5, 2)):
        size = 0.5 * diameter, 0.5e-3 * diameter, length, OIL
        film = MovingFilm(Bearing(*size, ambient=1e5, pressure_viscosity=9.5e-9), (36, 3), drag)
        low, high = 0.1, 0.998
        for _ in range(16):
            eps = 0.5 * (low + high)
            radial, tangential, shear, _ = film.outputs(eps, 0.0, speed)
            carries = math.hypot(radial, tangential) > share * load
            low, high = (low, eps) if carries else (eps, high)
        total -= count * wet_film_torques(eps, tangential, shear, speed, 0.0, *size)[0]
    return total


def test_rig():
    """In full film the ring is nearer to the rig at each point, 17 % off at most, the wet area 25
    %.
    """
    rows = [r for r in states.rows("rig") if r["speed_rpm"] >= 1000.0]
    assert len(rows) == 3
    for row in rows:
        load = 8e3 if row["specific_load_MPa"] == 10.0 else 4e3
        of = load, row["speed_rpm"] * math.pi / 30.0
        ring, wet = (
            abs(math.log(torque(*of, drag) / row["shaft_torque_Nm"])) for drag in (RING, WET)
        )
        assert ring < min(wet, 0.16)


def test_by_name():
    """Options of cases: a film that always has the ring refuses another drag; an unknown one is
    named.
    """
    assert dict(film_of("table", 0.0, False, "auto").settings)["drag"] == RING
    assert dict(film_of("fem", 0.0, False, "auto", WET).settings)["drag"] == WET
    with pytest.raises(ValueError, match="film short has no drag; table, fast, fem, conserving"):
        film_of("short", 0.0, False, "auto", WET)
    for law in (table, conserving):
        with pytest.raises(ValueError, match="drag must be one of ring, wet; got 'dry'"):
            law(drag="dry")
