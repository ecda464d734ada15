"""The finite element film: exact and published films, its own order of convergence, slopes,
conserved oil, bad input.

Published digits: Butenschoen, dissertation, Karlsruhe (1976); Raimondi and Boyd, ASLE Trans. 1
(1958) 159. The force map and the "own" digits come from another solver (finite volumes on three
grids, extrapolated; error below 1e-5, with finite ambient pressure below 5e-4).
"""

import math

import numpy as np
import pytest

from clearance.film import bands
from clearance.film.bearing import Bearing, Groove, load_error
from clearance.film.fem import FemFilm, flow_factors, solve
from clearance.laws.asperity import contact_flow_factor, pressure_flow_factor
from tests.seeds import few_of

R, C = 0.01, 1e-4
LINE = (Groove(angle=0.0),)
BUTENSCHOEN, RAIMONDI = "Butenschoen 1976", "Raimondi and Boyd 1958"
SOMMERFELD = {"source": "Sommerfeld's infinitely long bearing", "kind": "exact"}
OCVIRK = {"source": "Ocvirk's short bearing", "kind": "exact"}
GRIDS = {"source": "finite volumes on three grids, extrapolated", "kind": "independent"}


def bearing(slenderness=1.0, **more) -> Bearing:
    return Bearing(R, C, 2.0 * R * slenderness, 0.05, **more)


def force(film) -> np.ndarray:
    """(W_r, W_t)."""
    return np.array([film.radial, film.tangential]) / film.bearing.force_scale


def sommerfeld(film) -> float:
    """So of a film whose speed is 1 rad/s or whose d(eps)/dt is 1/s."""
    return 0.5 * film.load / film.bearing.force_scale


def outputs(film) -> np.ndarray:
    return np.array([film.radial, film.tangential, film.shear, film.side_flow])


class TestLimits:
    @pytest.mark.parametrize(
        ("eps", "rotation", "attitude", "closing", "opening"),
        [
            (0.1, 0.1607659615, 82.707755, 4.107681644, 2.46423511),
            (0.5, 1.500762164, 53.680201, 18.23146215, 1.115731073),
            (0.8, 11.46265614, 30.500153, 183.5300597, 0.6991390959),
        ],
    )
    def test_short(self, eps, rotation, attitude, closing, opening, validated):
        """Ocvirk's So / (L/D)^2 is the limit L/D -> 0; what a finite length adds is of second order
        (1.2 % at L/D 0.05 and eps 0.8), so two short bearings are extrapolated: 1e-4. Oil that
        leaves: 2 L/D eps, 0.1 % at L/D 0.05.
        """
        lengths = 0.05, 0.025
        films = [FemFilm(bearing(x, cavitation="gumbel")) for x in lengths]
        for state, expected in (
            ((0.0, 1.0), rotation),
            ((1.0, 0.0), closing),
            ((-1.0, 0.0), opening),
        ):
            solved = [film.solve(eps, *state) for film in films]
            long, short = (sommerfeld(s) / x**2 for s, x in zip(solved, lengths, strict=True))
            validated(
                "So / (L/D)^2, short, finite elements",
                (4.0 * short - long) / 3.0,
                expected,
                1e-4,
                **OCVIRK,
            )
            if state[1]:
                angles = [math.degrees(s.attitude_angle) for s in solved]
                angle, leaves = (
                    (4.0 * angles[1] - angles[0]) / 3.0,
                    2.0 * lengths[0] * eps * C * R * R,
                )
                validated(
                    "attitude, short, finite elements",
                    angle,
                    attitude,
                    5e-3,
                    unit="deg",
                    relative=False,
                    **OCVIRK,
                )
                validated(
                    "side flow, short, finite elements",
                    solved[0].side_flow,
                    leaves,
                    1e-3,
                    unit="m3/s",
                    **OCVIRK,
                )

    @pytest.mark.parametrize(
        ("cavitation", "grooves", "tolerance", "degrees", "exact"),
        [
            (
                "none",
                (),
                2e-5,
                1e-9,
                {0.1: (0.9425132588, 90.0), 0.5: (4.836798305, 90.0), 0.8: (9.519977738, 90.0)},
            ),
            (
                "gumbel",
                (),
                2e-5,
                1e-3,
                {
                    0.1: (0.4722202559, 86.339052),
                    0.5: (2.576582604, 69.818965),
                    0.8: (6.243585416, 49.674525),
                },
            ),
            (
                "reynolds",
                LINE,
                3e-4,
                0.01,
                {
                    0.1: (0.6591226222, 69.029801),
                    0.5: (3.227778168, 58.296185),
                    0.8: (7.541640615, 42.180956),
                },
            ),
            (
                "mass_conserving",
                LINE,
                5e-3,
                0.15,
                {
                    0.1: (0.6591226222, 69.029801),
                    0.5: (3.227778168, 58.296185),
                    0.8: (7.541640615, 42.180956),
                },
            ),
        ],
    )
    def test_long(self, cavitation, grooves, tolerance, degrees, exact, validated):
        """The ends of a long bearing take the same load whatever its length: the difference between
        L/D 20 and 40 on the same cells is the infinitely long film. What is left is the error
        around, of order 4, 2 to 4 and 2.
        """
        meshes = (20.0, (64, 4)), (40.0, (64, 8))
        films = [
            FemFilm(bearing(x, cavitation=cavitation, grooves=grooves), mesh) for x, mesh in meshes
        ]
        for eps, (expected, attitude) in exact.items():
            shorter, longer = (force(film.solve(eps, 0.0, 1.0)) for film in films)
            radial, tangential = 2.0 * longer - shorter
            actual, angle = (
                0.5 * math.hypot(radial, tangential),
                math.degrees(math.atan2(tangential, -radial)),
            )
            what = f"long ({cavitation}), finite elements"
            validated(f"So, {what}", actual, expected, tolerance, **SOMMERFELD)
            validated(
                f"attitude, {what}",
                angle,
                attitude,
                degrees,
                unit="deg",
                relative=False,
                **SOMMERFELD,
            )

    def test_couette_shear(self, validated):
        """Full film: 2 pi / sqrt(1 - eps^2) exactly.

        Rupture at 219.69 degrees (long film, eps 0.5): half a cell of the 64 is 1 % of this
        integral; L/D 40 has 1 % ends.
        """
        full = solve(bearing(cavitation="none"), 0.5, 0.0, 1.0)
        validated(
            "shear integral of a full film",
            full.shear,
            2.0 * math.pi / math.sqrt(0.75),
            1e-7,
            **SOMMERFELD,
        )
        theta = np.linspace(0.0, math.radians(219.69402), 2001)
        wet = np.trapezoid(1.0 / (1.0 + 0.5 * np.cos(theta)), theta)
        film = solve(bearing(40.0, grooves=LINE), 0.5, 0.0, 1.0)
        validated("shear integral up to the rupture", film.shear, wet, 0.015, **SOMMERFELD)


SQUEEZE = {
    1.0: [
        (-0.9, 0.5518),
        (-0.5, 0.971),
        (-0.1, 1.9579),
        (0.0, 2.4076),
        (0.3, 5.0479),
        (0.6, 14.769),
        (0.9, 160.25),
    ],
    0.25: [
        (-0.9, 0.0376),
        (-0.5, 0.0688),
        (0.0, 0.1919),
        (0.3, 0.4675),
        (0.6, 1.8455),
        (0.9, 46.559),
    ],
}
ROTATION = {  # eps: So, attitude, Q / (R^2 c omega), printed and of the other solver
    1.0: [
        (0.1, 0.1196, 79.41, 0.161095),
        (0.3, 0.4091, 68.264, 0.477094),
        (0.5, 0.8903, 56.705, 0.786074),
        (0.7, 2.0432, 43.859, 1.08982),
        (0.9, 8.4352, 26.482, 1.39093),
    ],
    0.25: [
        (0.1, 0.0098, 82.481, 0.0492126),
        (0.3, 0.0354, 68.204, 0.147631),
        (0.5, 0.0888, 54.069, 0.246077),
        (0.7, 0.2708, 39.326, 0.344628),
        (0.9, 2.1595, 21.79, 0.443636),
    ],
}


class TestPublished:
    @pytest.mark.parametrize("slenderness", few_of([1.0, 0.25], 1))
    def test_squeeze(self, slenderness, validated):
        """Butenschoen's pure squeeze, negative eps: opening. 0.5 %: his digits are 0.2 % off, four
        of them 0.1 %.
        """
        film = FemFilm(bearing(slenderness))
        for eps, expected in SQUEEZE[slenderness]:
            actual = film.solve(abs(eps), math.copysign(1.0, eps), 0.0)
            what = f"So of squeeze, L/D {slenderness:g}, finite elements"
            validated(what, sommerfeld(actual), expected, 5e-3, source=BUTENSCHOEN)
            assert abs(actual.tangential) < 1e-9 * actual.load
            assert actual.radial * math.copysign(1.0, eps) < 0.0

    @pytest.mark.parametrize("slenderness", few_of([1.0, 0.25], 1))
    def test_rotation(self, slenderness, validated):
        """Butenschoen's steady rotation, film from the widest gap: 0.7 % and 0.15 degrees, as far
        as his digits are off; the flow against the other solver's, 0.1 %.
        """
        film = FemFilm(bearing(slenderness, grooves=LINE))
        for eps, load, attitude, flow in ROTATION[slenderness]:
            actual = film.solve(eps, 0.0, 1.0)
            angle, leaves = math.degrees(actual.attitude_angle), actual.side_flow / (C * R * R)
            what = f"of rotation, L/D {slenderness:g}, finite elements"
            validated(f"So {what}", sommerfeld(actual), load, 7e-3, source=BUTENSCHOEN)
            validated(
                f"attitude {what}",
                angle,
                attitude,
                0.15,
                unit="deg",
                relative=False,
                source=BUTENSCHOEN,
            )
            validated(f"side flow {what}", leaves, flow, 1e-3, **GRIDS)
            assert math.sin(actual.centre_of_pressure) > 0.0  # journal pressed the way it turns

    def test_raimondi_and_boyd(self, validated):
        """Their chart of L/D 1: S within 2 % and the attitude within 0.6 degrees, their own
        accuracy; friction, of a gap that is full all around, within 2 %.
        """
        film = FemFilm(bearing(grooves=LINE))
        for eps, number, attitude, friction in [
            (0.1, 1.33, 79.5, 26.4),
            (0.2, 0.631, 74.02, 12.8),
            (0.4, 0.264, 63.10, 5.79),
            (0.6, 0.121, 50.58, 3.22),
            (0.8, 0.0446, 36.24, 1.70),
            (0.9, 0.0188, 26.45, 1.05),
        ]:
            actual = film.solve(eps, 0.0, 1.0)
            load = actual.load / actual.bearing.force_scale
            angle, couette = (
                math.degrees(actual.attitude_angle),
                2.0 * math.pi / math.sqrt(1.0 - eps * eps),
            )
            rubs = couette / load + 0.5 * eps * math.sin(actual.attitude_angle)
            validated(
                "S, L/D 1, finite elements", 1.0 / (math.pi * load), number, 0.02, source=RAIMONDI
            )
            validated(
                "attitude, L/D 1, finite elements",
                angle,
                attitude,
                0.6,
                unit="deg",
                relative=False,
                source=RAIMONDI,
            )
            validated(
                "friction times R/c, L/D 1, finite elements", rubs, friction, 0.02, source=RAIMONDI
            )


#: L/D 1, eps and direction of V [deg]: (W_r, W_t) with reynolds, gumbel, none, and reynolds with
#: sigma 1 and 10
FORCES = {
    (0.0, 0): [(-4.8168, 0), (-4.4938, 0), (-8.9877, 0), (-6.2344, 0), (-8.9877, 0)],
    (0.2, 30): [
        (-6.6876, 2.9529),
        (-6.383, 2.9087),
        (-8.9109, 4.6485),
        (-7.7723, 3.6891),
        (-8.9109, 4.6485),
    ],
    (0.2, 90): [(-1.0896, 4.9804), (-0.8384, 4.6485), (0, 9.2969), (-0.91571, 6.397), (0, 9.2969)],
    (0.2, 150): [
        (2.78, 2.0272),
        (2.5279, 1.7397),
        (8.9109, 4.6485),
        (4.1305, 2.7153),
        (8.9109, 4.6485),
    ],
    (0.5, 0): [(-19.482, 0), (-19.27, 0), (-20.797, 0), (-20.54, 0), (-20.797, 0)],
    (0.5, 60): [
        (-10.47, 6.785),
        (-9.8159, 6.8214),
        (-10.398, 9.8487),
        (-10.728, 8.0799),
        (-10.398, 9.8487),
    ],
    (0.5, 90): [(-3.6967, 6.0756), (-2.8631, 5.6862), (0, 11.372), (-3.2779, 7.4895), (0, 11.372)],
    (0.5, 120): [
        (0.23027, 3.7351),
        (0.58252, 3.0273),
        (10.398, 9.8487),
        (1.282, 4.9159),
        (8.8416, 9.3063),
    ],
    (0.8, 0): [(-100.86, 0), (-100.7, 0), (-101.52, 0), (-101.52, 0), (-101.52, 0)],
    (0.8, 60): [
        (-51.863, 14.213),
        (-50.663, 14.573),
        (-50.759, 17.41),
        (-51.81, 15.553),
        (-50.759, 17.41),
    ],
    (0.8, 90): [
        (-14.251, 10.657),
        (-11.233, 10.052),
        (0, 20.104),
        (-13.638, 12.068),
        (-6.5879, 17.512),
    ],
    (0.8, 120): [
        (-0.93835, 4.1709),
        (0.095212, 2.8373),
        (50.759, 17.41),
        (0.25736, 5.3359),
        (10.692, 10.128),
    ],
}


@pytest.mark.parametrize("column", few_of(range(5), 1))
def test_force_map(column, validated):
    """Every cavitation and direction of motion, up to eps 0.8: 2e-3 of the force (measured: see the
    orders below).
    """
    cavitation = ("reynolds", "gumbel", "none", "reynolds", "reynolds")[column]
    sigma = (None, None, None, 1.0, 10.0)[column]
    ambient = None if sigma is None else sigma * bearing().pressure_scale
    film = FemFilm(bearing(cavitation=cavitation, ambient=ambient))
    for (eps, degrees), row in FORCES.items():
        angle, expected = math.radians(degrees), complex(*row[column])
        actual = film.solve(eps, math.cos(angle), 2.0 * math.sin(angle) / eps if eps else 0.0)
        what = (
            f"force of any motion ({cavitation}{f', ambient {sigma:g}' if sigma else ''}), "
            "finite elements"
        )
        validated(what, complex(*force(actual)), expected, 2e-3, **GRIDS)


class TestConvergence:
    @pytest.mark.parametrize(
        ("cavitation", "exact", "order", "last"),
        [
            ("none", (0.0, 20.10369), 3.5, 5e-5),
            ("gumbel", (-11.23309, 10.05185), 3.2, 5e-5),
            ("reynolds", (-14.25092, 10.65686), 2.2, 5e-4),
            ("mass_conserving", (-14.40617, 10.55485), 1.7, 5e-3),
        ],
    )
    def test_order_of_the_load(self, cavitation, exact, order, last):
        """Error of the force at eps 0.8 on 16 x 2, 32 x 4 and 64 x 8: mean order over both halvings
        and last error.

        Biquadratic elements give a functional of order 4 (measured 3.6; 3.96 in the last halving),
        also when the pressure is cut at the quadrature points; a free boundary takes it to 3.1 and
        makes it uneven; first-order upwinding acts in the cavity only and leaves 2.
        """
        grooves = LINE if cavitation == "mass_conserving" else ()
        oil, meshes = (
            bearing(cavitation=cavitation, grooves=grooves),
            [(16, 2), (32, 4), (64, 8), (160, 20)],
        )
        actual = [force(solve(oil, 0.8, 0.0, 2.5, mesh)) for mesh in meshes]
        errors = [np.linalg.norm(f - np.array(exact)) / np.linalg.norm(exact) for f in actual]
        assert 0.5 * math.log2(errors[0] / errors[2]) > order
        assert errors[2] < last
        assert errors[3] < 0.5 * errors[2]


SLOPES = {
    "rupture": {},
    "cut": {"cavitation": "gumbel"},
    "full": {"cavitation": "none", "roughness": 2e-5},
    "ambient": {"ambient": 0.5 * 0.05 * (R / C) ** 2},
    "groove": {"grooves": (Groove(1.0, 0.4, 0.5, 1e4),), "roughness": 3e-5},
    "conserving": {
        "cavitation": "mass_conserving",
        "grooves": (Groove(0.5, 0.2, 0.6, 1e4),),
        "roughness": 3e-5,
    },
}


@pytest.mark.parametrize("name", few_of([*SLOPES][::-1], 3))
def test_slopes(name):
    """Against central differences on the same wet region: 1e-5 of the largest slope (measured
    1e-8).
    """
    film, state = FemFilm(bearing(**SLOPES[name]), (48, 6)), np.array([0.6, 0.05, 3.0])
    actual = film.linearised(*state)
    np.testing.assert_allclose(actual[:, 0], outputs(film.solve(*state)), rtol=1e-12)
    scale = np.abs(actual[:, 1:]).max(axis=1)
    for k in range(3):
        step = 1e-5 * np.eye(3)[k]
        difference = (
            outputs(film.solve(*(state + step))) - outputs(film.solve(*(state - step)))
        ) / 2e-5
        assert np.all(np.abs(difference - actual[:, k + 1]) < 1e-5 * scale)


class TestMassConserving:
    def test_steady_film_is_that_of_rupture_at_zero_slope(self):
        """With a line groove at the widest gap: Raimondi and Boyd's film. 0.3 % and 0.05 degrees
        (0.1 % measured).
        """
        film = FemFilm(bearing(cavitation="mass_conserving", grooves=LINE), (128, 16))
        for eps, load, attitude in [
            (0.1, 0.119687, 79.4109),
            (0.5, 0.891026, 56.6986),
            (0.8, 3.57187, 36.2274),
        ]:
            actual = film.solve(eps, 0.0, 1.0)
            assert sommerfeld(actual) == pytest.approx(load, rel=3e-3)
            assert math.degrees(actual.attitude_angle) == pytest.approx(attitude, abs=0.05)
            assert actual.content.min() > 0.0
            assert np.all((actual.content == 1.0) | (actual.pressure == 0.0))

    def test_cavity_carries_what_entered_it(self):
        """In the cavity the flow along theta is constant: content times the gap, here at the
        downstream face.
        """
        film = solve(bearing(cavitation="mass_conserving", grooves=LINE), 0.6, 0.0, 1.0)
        middle = film.content[:, 0]
        dry = np.flatnonzero(middle < 1.0)[1:]
        face = film.theta[dry] + math.pi / 64
        carried = middle[dry] * (1.0 + 0.6 * np.cos(face))
        assert len(dry) > 10
        np.testing.assert_allclose(carried, carried[0], rtol=1e-10)

    @pytest.mark.parametrize("more", [{}, {"ambient": 2e4}, {"roughness": 2e-5}])
    def test_every_step_keeps_the_oil(self, more):
        """1e-10 of a full film in a step (measured 1e-15), the gap opening and closing; a steady
        film stays.
        """
        grooves = (Groove(0.0, 0.2, 0.5, 1e4),)
        film = FemFilm(bearing(0.5, cavitation="mass_conserving", grooves=grooves, **more), (48, 6))
        start = film.solve(0.6, 0.0, 20.0)
        still = film.advance(0.6, 0.0, 20.0, start.content, 0.01)
        np.testing.assert_allclose(outputs(still), outputs(start), rtol=1e-9)
        eps, content, step = 0.6, start.content, 2e-3
        for k in range(60):
            rate = 8.0 * math.cos(0.25 * k)
            eps += step * rate
            now = film.advance(eps, rate, 20.0 if k < 40 else -20.0, content, step)
            content = now.content
            assert abs(film.mass_defect) < 1e-10
            assert content.min() >= -1e-9
            assert content.max() <= 1.0 + 1e-9

    def test_forgets_how_it_started(self):
        """A half empty film comes to the steady one, without a solve of that state in between."""
        film = FemFilm(bearing(cavitation="mass_conserving", grooves=LINE), (32, 4))
        steady = film.solve(0.5, 0.0, 2.0)
        now, content = None, np.full(steady.content.shape, 0.5)
        for _ in range(60):
            now = film.advance(0.5, 0.0, 2.0, content, 0.5)
            content = now.content
        np.testing.assert_allclose(outputs(now), outputs(steady), rtol=1e-9)

    def test_needs_a_groove_when_steady(self):
        with pytest.raises(ValueError, match="needs a supply groove"):
            solve(bearing(cavitation="mass_conserving"), 0.5, 0.0, 1.0, (16, 2))

    def test_backwards_is_the_mirror_image(self):
        film = FemFilm(bearing(cavitation="mass_conserving", grooves=LINE), (32, 4))
        ahead, back = force(film.solve(0.7, 0.0, 1.0)), force(film.solve(0.7, 0.0, -1.0))
        np.testing.assert_allclose(back, ahead * [1.0, -1.0], rtol=1e-9)


class TestSupply:
    def test_pressure_holds_in_the_groove(self):
        groove = Groove(angle=1.234, width=0.31, length=0.37, pressure=5e4)
        film = solve(bearing(grooves=(groove,)), 0.5, 0.0, 10.0, (32, 4))
        inside = np.abs(film.theta - 1.234) < 0.155 + 1e-6
        along = film.axial <= 0.5 * 0.37 * film.bearing.length + 1e-9
        assert inside.any()
        assert film.theta[inside].max() == pytest.approx(1.234 + 0.155, abs=1e-9)
        assert film.axial[along].max() == pytest.approx(0.5 * 0.37 * film.bearing.length, rel=1e-9)
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
        film = solve(bearing(grooves=(Groove(angle),), cavitation="none"), 0.4, 0.0, 1.0, (32, 4))
        column = np.argmin(np.abs((film.theta - angle + math.pi) % (2 * math.pi) - math.pi))
        assert film.theta[column] % (2 * math.pi) == pytest.approx(angle % (2 * math.pi), abs=1e-9)
        assert np.all(film.pressure[column] == 0.0)


class TestReuse:
    def test_warm_start_gives_the_same_film_sooner(self):
        film = FemFilm(bearing())
        for eps in (0.3, 0.6, 0.9):
            film.solve(eps, 0.2, 1.5)
            warm, cold = (
                film.solve(eps + 0.01, 0.2, 1.5),
                film.solve(eps + 0.01, 0.2, 1.5, warm=False),
            )
            np.testing.assert_allclose(outputs(warm), outputs(cold), rtol=1e-10)
            assert warm.iterations < cold.iterations

    def test_force_is_homogeneous_in_the_motion(self):
        film = FemFilm(bearing(), (32, 4))
        np.testing.assert_allclose(
            force(film.solve(0.6, 3.0, 4.5)), 3.0 * force(film.solve(0.6, 1.0, 1.5)), rtol=1e-9
        )

    def test_shapes(self):
        film = solve(bearing(), 0.5, 0.0, 1.0, (16, 2))
        assert (
            film.pressure.shape
            == film.content.shape
            == (len(film.theta), len(film.axial))
            == (32, 5)
        )
        assert film.axial[-1] == pytest.approx(0.5 * film.bearing.length)
        assert film.unknowns == 32 * 4


class TestRoughness:
    def test_factors_are_those_of_the_laws(self):
        """1e-12; slopes against central differences, 1e-6."""
        oil, gap, h = bearing(roughness=0.2 * C), np.linspace(0.05, 2.0, 40), 1e-6
        phi, phi_slope, psi, psi_slope, mean = flow_factors(oil, gap)
        np.testing.assert_allclose(phi, [pressure_flow_factor(5.0 * x) for x in gap], rtol=1e-12)
        np.testing.assert_allclose(psi, [contact_flow_factor(5.0 * x) for x in gap], rtol=1e-12)
        above, below = flow_factors(oil, gap + h), flow_factors(oil, gap - h)
        smooth = np.abs(5.0 * gap - 0.5) > 0.01
        for k, slope in ((0, phi_slope), (2, psi_slope), (4, psi)):
            np.testing.assert_allclose(
                ((above[k] - below[k]) / (2 * h))[smooth], slope[smooth], atol=1e-6
            )
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
                loads = {n: math.hypot(*film.outputs(eps, *state)[:2]) for n, film in films.items()}
                errors = {n: abs(load / wanted - 1.0) for n, load in loads.items()}
                assert all(error < load_error(n, eps, slenderness) for n, error in errors.items())
                bound = 1e-3 if eps <= 0.7 or (slenderness >= 0.5 and eps <= 0.9) else 4e-3
                assert errors[64] < bound or eps > 0.9

    def test_H2_doubt_knows_the_slenderness(self):
        """The mesh of a run: 2 % of a short bearing's load at eps 0.9, less than 1 % of a longer
        one's.
        """
        message = FemFilm(bearing(0.125), (32, 4)).doubt(0.9)
        assert (
            message
            == "32 cells around are too coarse for eccentricity ratio 0.9: the load may be 1.5% "
            "off; take 64"
        )
        assert FemFilm(bearing(1.0), (32, 4)).doubt(0.9) is None
        with pytest.raises(
            ValueError, match="mesh: 16 cells .* 0.99: the load may be 61.7% off; take 64"
        ):
            solve(bearing(), 0.99, 0.0, 1.0, (16, 2))


class TestBadInput:
    @pytest.mark.parametrize("mesh", [(8, 4), (16, 1), (32.0, 4)])
    def test_mesh(self, mesh):
        with pytest.raises(ValueError, match="too coarse"):
            FemFilm(bearing(), mesh)

    @pytest.mark.parametrize("eps", [1.0, 1.5])
    def test_contact(self, eps):
        with pytest.raises(ValueError, match="at or beyond contact"):
            solve(bearing(), eps, 0.0, 1.0, (16, 2))

    def test_more_grooves_than_cells(self):
        crowd = tuple(Groove(angle=0.5 * k, width=0.1) for k in range(12))
        with pytest.raises(ValueError, match="too coarse for the grooves"):
            FemFilm(bearing(grooves=crowd), (16, 2))
        with pytest.raises(ValueError, match="too coarse for the grooves"):
            FemFilm(bearing(grooves=tuple(Groove(length=x) for x in (0.3, 0.5, 0.7))), (16, 2))

    def test_grooves_that_disagree(self):
        with pytest.raises(ValueError, match="overlap and differ"):
            FemFilm(bearing(grooves=(Groove(0.0, 0.5, 0.5, 1e4), Groove(0.3, 0.5, 0.5, 2e4))))

    def test_advance(self):
        with pytest.raises(TypeError, match="no content to advance"):
            FemFilm(bearing(), (16, 2)).advance(0.5, 0.0, 1.0, np.ones((32, 5)), 0.1)
        film = FemFilm(bearing(cavitation="mass_conserving"), (16, 2))
        with pytest.raises(ValueError, match="content must lie in"):
            film.advance(0.5, 0.0, 1.0, np.full((16, 3), 1.5), 0.1)
        with pytest.raises(ValueError, match="content must lie in"):
            film.advance(0.5, 0.0, 1.0, np.ones((16, 4)), 0.1)
        with pytest.raises(ValueError, match="step must be positive"):
            film.advance(0.5, 0.0, 1.0, np.ones((16, 3)), 0.0)
