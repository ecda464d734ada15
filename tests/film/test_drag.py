"""The drag of a film: of the filled ring, or of the area that oil wets.

Raimondi and Boyd's friction is the ring's (test_published.py), and so is that of a friction rig
(test_friction_rig.py).
"""

import math

import pytest

from clearance.film.bearing import RING, WET, Groove
from clearance.film.conserving import MemoryFilm
from clearance.film.names import conserving, fast, fem, table
from clearance.laws import FilmJoint
from clearance.scene.joint_options import film_of
from tests.film import states

JOINT = FilmJoint(1e-2, 1e-4, 2e-2, 0.05)


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
