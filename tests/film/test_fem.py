"""The finite element film: its own order of convergence, conserved oil, bad input.

Published bearings and closed forms: test_published.py.
"""

import math
from functools import partial

import numpy as np
import pytest

from clearance.film import bands
from clearance.film.bearing import Groove, load_error
from clearance.film.fem import FemFilm, flow_factors, solve
from clearance.laws.asperity import contact_flow_factor, pressure_flow_factor
from tests.film.states import (
    LINE,
    SOMMERFELD,
    C,
    R,
    apart,
    bearing,
    force,
    rows,
)  # fmt: skip
from tests.seeds import few_of


def fed(*grooves, **more):
    """A bearing whose film keeps its oil, fed by grooves (a line at the widest gap)."""
    return bearing(cavitation="mass_conserving", grooves=grooves or LINE, **more)


def test_couette_shear(validated):
    """Full film: 2 pi / sqrt(1 - eps^2) exactly.

    Rupture at 219.69 degrees (long film, eps 0.5): half a cell of the 64 is 1 % of this
    integral; L/D 40 has 1 % ends.
    """
    full = solve(bearing(cavitation="none"), 0.5, 0.0, 1.0)
    wanted = 2.0 * math.pi / math.sqrt(0.75)
    validated("shear integral of a full film", full.shear, wanted, 1e-7, **SOMMERFELD)
    theta = np.linspace(0.0, math.radians(219.69402), 2001)
    wet = np.trapezoid(1.0 / (1.0 + 0.5 * np.cos(theta)), theta)
    film = solve(bearing(40.0, grooves=LINE), 0.5, 0.0, 1.0)
    validated("shear integral up to the rupture", film.shear, wet, 0.015, **SOMMERFELD)


@pytest.mark.parametrize(
    ("cavitation", "exact", "order", "last"),
    [
        ("none", None, 3.5, 5e-5),
        ("gumbel", None, 3.2, 5e-5),
        ("reynolds", None, 2.2, 5e-4),
        ("mass_conserving", (-14.40617, 10.55485), 1.7, 5e-3),
    ],
)
def test_order_of_the_load(cavitation, exact, order, last):
    """Error of the force at eps 0.8 on 16 x 2, 32 x 4 and 64 x 8: mean order over both halvings
    and last error.

    Biquadratic elements give a functional of order 4 (measured 3.6; 3.96 in the last halving),
    also when the pressure is cut at the quadrature points; a free boundary takes it to 3.1 and
    makes it uneven; first-order upwinding acts in the cavity only and leaves 2.
    """
    (row,) = (r for r in rows("map") if (r["eps"], r["degrees"]) == (0.8, 90.0))
    exact = exact or [row[f"{cavitation} {way}"] for way in ("radial", "tangential")]
    oil = fed() if cavitation == "mass_conserving" else bearing(cavitation=cavitation)
    errors = [
        apart(force(solve(oil, 0.8, 0.0, 2.5, (16 * n, 2 * n))), exact) for n in (1, 2, 4, 10)
    ]
    assert 0.5 * math.log2(errors[0] / errors[2]) > order
    assert errors[2] < last
    assert errors[3] < 0.5 * errors[2]


class TestMassConserving:
    def test_cavity_carries_what_entered_it(self):
        """In the cavity the flow along theta is constant: content times the gap, here at the
        downstream face.
        """
        film = solve(fed(), 0.6, 0.0, 1.0)
        assert film.content.min() > 0.0
        assert np.all((film.content == 1.0) | (film.pressure == 0.0))
        middle = film.content[:, 0]
        dry = np.flatnonzero(middle < 1.0)[1:]
        face = film.theta[dry] + math.pi / 64
        carried = middle[dry] * (1.0 + 0.6 * np.cos(face))
        assert len(dry) > 10
        np.testing.assert_allclose(carried, carried[0], rtol=1e-10)

    def test_backwards_is_the_mirror_image(self):
        """Turned around, the tangential force changes its sign, to rounding."""
        film = FemFilm(fed(), (32, 4))
        ahead, back = force(film.solve(0.7, 0.0, 1.0)), force(film.solve(0.7, 0.0, -1.0))
        np.testing.assert_allclose(back, ahead * [1.0, -1.0], rtol=1e-9)


class TestSupply:
    def test_pressure_holds_in_the_groove(self):
        """Nodes stand on the groove's edges, and inside it the pressure is that of the feed."""
        film = solve(bearing(grooves=(Groove(1.234, 0.31, 0.37, 5e4),)), 0.5, 0.0, 10.0, (32, 4))
        end = 0.5 * 0.37 * film.bearing.length
        inside = np.abs(film.theta - 1.234) < 0.155 + 1e-6
        along = film.axial <= end + 1e-9
        assert film.theta[inside].max() == pytest.approx(1.234 + 0.155, abs=1e-9)
        assert film.axial[along].max() == pytest.approx(end, rel=1e-9)
        np.testing.assert_allclose(film.pressure[np.ix_(inside, along)], 5e4, rtol=1e-12)

    def test_flow_from_a_wide_groove(self):
        """Centred and at rest, a groove of 3 rad and half the length sheds 2 (3 R) c^3 p / (12 mu
        L / 4) along, and more at its corners: that part is in proportion to the distance to the
        ends over the width.
        """
        oil = bearing(0.1, grooves=(Groove(math.pi, 3.0, 0.5, 1e5),))
        flow = solve(oil, 0.0, 0.0, 0.0).side_flow
        along = 2.0 * 3.0 * R * C**3 * 1e5 / (12.0 * oil.viscosity * 0.25 * oil.length)
        assert along < flow < 1.12 * along

    @pytest.mark.parametrize("angle", [0.0, 1.0, -2.0, 3.1])
    def test_a_line_through_the_whole_length_cuts_the_film(self, angle):
        """A column of nodes stands on the line, at ambient pressure."""
        film = solve(bearing(grooves=(Groove(angle),), cavitation="none"), 0.4, 0.0, 1.0, (32, 4))
        column = np.argmin(np.abs((film.theta - angle + math.pi) % (2 * math.pi) - math.pi))
        assert film.theta[column] % (2 * math.pi) == pytest.approx(angle % (2 * math.pi), abs=1e-9)
        assert np.all(film.pressure[column] == 0.0)


class TestFields:
    def test_force_is_homogeneous_in_the_motion(self):
        """Three times the motion gives three times the force, to rounding."""
        film = FemFilm(bearing(), (32, 4))
        one, three = (force(film.solve(0.6, k, 1.5 * k)) for k in (1.0, 3.0))
        np.testing.assert_allclose(three, 3.0 * one, rtol=1e-9)

    def test_shapes(self):
        """Fields have two nodes a cell, along too, where the end is known."""
        film = solve(bearing(), 0.5, 0.0, 1.0, (16, 2))
        shape = len(film.theta), len(film.axial)
        assert film.pressure.shape == film.content.shape == shape == (32, 5)
        assert film.axial[-1] == pytest.approx(0.5 * film.bearing.length)
        assert film.unknowns == 32 * 4


class TestRoughness:
    def test_factors_are_those_of_the_laws(self):
        """1e-12; psi is the slope of the mean gap, against central differences, 1e-6."""
        oil, gap, h = bearing(roughness=0.2 * C), np.linspace(0.05, 2.0, 40), 1e-6
        phi, psi, mean = flow_factors(oil, gap)
        np.testing.assert_allclose(phi, [pressure_flow_factor(5.0 * x) for x in gap], rtol=1e-12)
        np.testing.assert_allclose(psi, [contact_flow_factor(5.0 * x) for x in gap], rtol=1e-12)
        above, below = (flow_factors(oil, gap + x)[2] for x in (h, -h))
        np.testing.assert_allclose((above - below) / (2 * h), psi, atol=1e-6)
        assert np.all(mean >= gap * (1.0 - 1e-14))

    def test_smooth_is_the_limit(self):
        """phi falls off as exp(-0.56 H c / sigma): nothing is left of it at c / sigma = 1000."""
        smooth, fine, coarse = (
            force(solve(bearing(roughness=s * C), 0.6, 0.3, 1.0, (32, 4))) for s in (0, 1e-3, 0.1)
        )
        np.testing.assert_allclose(fine, smooth, rtol=1e-10)
        assert np.linalg.norm(coarse) > 1.05 * np.linalg.norm(smooth)


class TestMeshError:
    """H2: short bearings need more cells; the sentence on the mesh of 64 by 8, and what
    `load_error` states.
    """

    @pytest.mark.parametrize("slenderness", few_of([0.125, 1.0, 0.1, 1 / 6, 0.25, 0.5, 2.0], 2))
    def test_H2_load_error(self, slenderness):
        """Of meshes of 32 and 64 cells, never above what is stated; bounds of the docstring: 1e-3
        up to eps 0.7, at 0.9 4e-3, from L/D 1/2 on 1e-3. The fast solver on a fine mesh is right to
        1e-5.
        """
        of = bearing(slenderness, grooves=LINE)
        films = {cells: FemFilm(of, (cells, cells // 8)) for cells in (32, 64)}
        for eps in (0.5, 0.7, 0.8, 0.85, 0.9, 0.95):
            for state in ((0.0, 1.0), (0.5, 1.0), (1.0, 0.0)):
                wanted = bands.solve(of, eps, *state, (384, 24)).load
                loads = {n: film.solve(eps, *state).load for n, film in films.items()}
                errors = {n: abs(load / wanted - 1.0) for n, load in loads.items()}
                assert all(error < load_error(n, eps, slenderness) for n, error in errors.items())
                bound = 1e-3 if eps <= 0.7 or (slenderness >= 0.5 and eps <= 0.9) else 4e-3
                assert errors[64] < bound or eps > 0.9


KEEPING = bearing(cavitation="mass_conserving")
SMALL = partial(FemFilm, mesh=(16, 2))


@pytest.mark.parametrize(
    ("refused", "message"),
    [
        *(
            (partial(FemFilm, bearing(), mesh), "too coarse")
            for mesh in ((8, 4), (16, 1), (32.0, 4))
        ),
        *(
            (partial(solve, bearing(), eps, 0.0, 1.0, (16, 2)), message)
            for eps, message in (
                (1.0, "at or beyond contact"),
                (1.5, "at or beyond contact"),
                (0.99, "mesh: 16 cells .* 0.99: the load may be 61.7% off; take 64"),
            )
        ),
        (partial(solve, KEEPING, 0.5, 0.0, 1.0, (16, 2)), "needs a supply groove"),
        *(
            (partial(SMALL, bearing(grooves=grooves)), "too coarse for the grooves")
            for grooves in (
                tuple(Groove(angle=0.5 * k, width=0.1) for k in range(12)),
                tuple(Groove(length=x) for x in (0.3, 0.5, 0.7)),
            )
        ),
        (
            partial(
                SMALL, bearing(grooves=[Groove(0.3 * k, 0.5, 0.5, 1e4 * (1 + k)) for k in (0, 1)])
            ),
            "overlap and differ",
        ),
    ],
)
def test_bad_input(refused, message):
    """Meshes, states and grooves that cannot be are refused with one line."""
    with pytest.raises(ValueError, match=message):
        refused()
