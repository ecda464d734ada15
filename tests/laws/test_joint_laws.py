"""The ladders of a real joint: known tables, limits, passivity, smoothness, exact derivatives, wide
ranges.
"""

import logging
import math
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import clearance as cl
from clearance import laws
from clearance.elements import regimes
from clearance.laws import FilmJoint
from clearance.laws.asperity import second_moment, third_moment
from clearance.laws.contact import johnson_force, lambert_w
from clearance.laws.film import arc_integrals, harmonic_share
from clearance.laws.law import BoundLaw
from clearance.laws.materials import Material, steel
from clearance.laws.worn_asperity import moments
from clearance.results.recorder import Memory, Recorder
from clearance.run import force_hole
from clearance.run.diagnosis import Diagnosis
from clearance.scene.joint_options import ASPERITIES, CONTACTS, FRICTIONS, TRANSITIONS, Pair
from clearance.scene.joint_options import FILMS as ALL_FILMS
from clearance.simulation import prepare
from clearance.stepping import status as codes
from clearance.stepping.state import VALUE
from tests.differences import slopes
from tests.laws.test_laws import delivered_restitution
from tests.plain import differentiated

FILMS = {n: f for n, f in ALL_FILMS.items() if n != "table"}  # the table has tests of its own
PAIR = Pair(radius=9.5e-3, clearance=0.5e-3, length=0.04, material=steel)
#: L/D = 1, radius 10 mm, c = 0.1 mm, the feeder's joint
JOINT = FilmJoint(radius=0.01, clearance=1e-4, length=0.02, viscosity=0.05, roughness=0.8e-6)
#: P0 = 1 and L/D = 1
UNIT = FilmJoint(radius=1.0, clearance=1.0, length=2.0, viscosity=0.5)
LONG = FilmJoint(radius=1.0, clearance=1.0, length=1.0, viscosity=1.0)
GAUSS = np.polynomial.legendre.leggauss(800)


def derivative(law: BoundLaw, state: tuple, active: int) -> np.ndarray:
    """Outputs by arguments, from the exact derivative of the law's source."""
    actual = differentiated(law.law.function, range(active), law.law.kinds)(*state, *law.numbers)
    outputs = law.law.family.outputs
    return np.array(actual[outputs:]).reshape(outputs, active)


def difference(law: BoundLaw, state: tuple, active: int, steps: tuple) -> np.ndarray:
    """The same by central differences."""
    rest = state[active:]
    return slopes(lambda *at: np.atleast_1d(law(*at, *rest)), state[:active], steps)


class TestContact:
    #: section 4.2 of the models: delivered restitution, three printed digits
    TABLE = {
        "hunt_crossley": (0.516, 0.581, 0.663, 0.768, 0.833, 0.909, 0.952),
        "herbert_mcwhannell": (0.491, 0.520, 0.594, 0.723, 0.807, 0.901, 0.950),
        "lee_wang": (0.687, 0.739, 0.799, 0.869, 0.909, 0.952, 0.976),
        "lankarani_nikravesh": (0.665, 0.684, 0.725, 0.796, 0.847, 0.913, 0.954),
        "gonthier": (0.101, 0.304, 0.488, 0.670, 0.768, 0.876, 0.936),
        "zhiying_qishao": (0.217, 0.327, 0.483, 0.680, 0.787, 0.896, 0.949),
        "flores": (0.069, 0.256, 0.470, 0.683, 0.789, 0.894, 0.947),
        "hu_guo": (0.074, 0.271, 0.488, 0.697, 0.799, 0.900, 0.950),
        "exact_restitution": (0.1, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95),
    }

    @pytest.mark.parametrize("name", TABLE)
    def test_delivered_restitution(self, name, validated):
        """The known table, by integrating the impact: 6e-4 (half of its last digit)."""
        for asked, delivered in zip(
            (0.1, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95), self.TABLE[name], strict=True
        ):
            law = getattr(laws, name)(stiffness=1e6, restitution=asked)
            options = {
                "source": "table of another integration",
                "kind": "independent",
                "relative": False,
            }
            validated(
                f"restitution delivered by {name}",
                delivered_restitution(law),
                delivered,
                6e-4,
                **options,
            )

    @pytest.mark.parametrize(
        ("e", "factor"), [(0.1, 9.998), (0.3, 3.087), (0.5, 1.433), (0.7, 0.635), (0.9, 0.166)]
    )
    def test_exact_damping(self, e, factor, validated):
        """Known factors, four digits; and solved both ways."""
        factors = {"source": "table of factors solved for elsewhere", "kind": "independent"}
        both = {"source": "the restitution asked for", "kind": "exact"}
        validated(
            "damping factor for a restitution",
            laws.exact_damping(e),
            factor,
            6e-4,
            relative=False,
            **factors,
        )
        actual = laws.delivered_restitution(laws.exact_damping(e))
        validated("restitution of the damping factor", actual, e, 1e-9, relative=False, **both)

    @pytest.mark.parametrize("name", ["exact_restitution", "winkler", "liu", "johnson"])
    @pytest.mark.parametrize("e", [0.2, 0.6, 0.9])
    def test_exact_restitution_for_any_elastic_force(self, name, e, validated):
        """The factor does not depend on the elastic force: 2e-3 by integrating the impact."""
        law = CONTACTS[name](PAIR, e)
        actual = delivered_restitution(
            law, mass=0.14 * 1e6, speed=1e-3 if name == "johnson" else 0.01
        )
        options = {"source": "the restitution asked for", "kind": "exact", "relative": False}
        validated("restitution by integrating an impact", actual, e, 2e-3, **options)

    @pytest.mark.parametrize("name", CONTACTS)
    @given(
        depth=st.floats(-1e-3, 1e-3),
        rate=st.floats(-100, 100),
        impact=st.floats(0, 100),
        e=st.floats(0.01, 1.0),
    )
    def test_pushes_and_only_in_contact(self, name, depth, rate, impact, e):
        """Any force is finite, never pulls, and is zero without a touch."""
        force = CONTACTS[name](PAIR, e)(depth, rate, impact)
        assert math.isfinite(force)
        assert force >= 0.0
        assert depth > 0.0 or force == 0.0

    @pytest.mark.parametrize("name", [n for n in CONTACTS if n != "kelvin_voigt"])
    def test_no_jump_at_first_touch(self, name):
        """Continuous at zero penetration, however fast the approach (Kelvin and Voigt's jumps by
        its nature).
        """
        assert CONTACTS[name](PAIR, 0.5)(1e-15, 10.0, 1.0) < 1e-3

    @pytest.mark.parametrize("name", CONTACTS)
    @given(depth=st.floats(1e-7, 2e-4), rate=st.floats(-0.5, 0.5))
    def test_exact_derivative(self, name, depth, rate):
        """Against central differences: 1e-5 of the largest slope."""
        law, state = CONTACTS[name](PAIR, 0.8), (depth, rate, 1.0)
        if abs(1.0 + rate) < 0.05:
            return
        actual, checked = derivative(law, state, 2), difference(law, state, 2, (1e-4 * depth, 1e-5))
        size = np.abs(checked) + law(*state) * np.array([[1.0 / depth, 1.0]])
        assert (np.abs(actual - checked) <= 1e-5 * size).all()

    def test_winkler_by_quadrature(self, validated):
        """K_w L times the integral of (e cos a - c) R cos a over the arc of overlap; 1e-9."""
        law = laws.winkler(layer_modulus=1e13, length=0.04, radius=9.5e-3, radius_difference=5e-4)
        for depth in (1e-9, 1e-6, 1e-5, 1e-4, 4e-4):
            e, c = 5e-4 + depth, 5e-4
            top = math.acos(c / e)
            x, w = GAUSS
            a = 0.5 * top * (x + 1.0)
            # c - e cos a cancels: written with half angles
            gap = 2.0 * e * (np.sin(0.5 * top) ** 2 - np.sin(0.5 * a) ** 2)
            force = 2.0 * 1e13 * 0.04 * 9.5e-3 * 0.5 * top * np.sum(w * gap * np.cos(a))
            options = {"unit": "N", "source": "quadrature over the arc", "kind": "independent"}
            validated("force of Winkler's layer", law(depth, 0.0, 1.0), force, 1e-7, **options)

    def test_winkler_coefficient_of_the_flores_joint(self, validated):
        """Layer 5 mm of steel, c = 0.5 mm, L = 40 mm: 1.79e12 N/m^1.5, 27 times the sphere's (three
        digits).
        """
        modulus = laws.layer_modulus(steel, 5e-3)
        law = laws.winkler(
            layer_modulus=modulus, length=0.04, radius=9.5e-3, radius_difference=5e-4
        )
        actual = law(1e-8, 0.0, 1.0) / 1e-8**1.5
        validated(
            "coefficient of Winkler's layer, Flores' joint",
            actual,
            1.79e12,
            5e-3,
            unit="N/m^1.5",
            source="hand calculation",
            kind="independent",
        )

    @given(st.floats(-1.0 / math.e + 1e-9, -1e-12))
    def test_lambert_w(self, x):
        """The lower branch: w exp(w) is x, 1e-9."""
        w = lambert_w(x)
        assert w <= -1.0 + 1e-3
        assert w * math.exp(w) == pytest.approx(x, rel=1e-9)

    def test_johnson_solves_its_own_equation(self, validated):
        """delta = f / (pi E*) (ln(4 pi E* DR / f) - 1): 1e-9 up to 90 % of the limit; beyond it
        goes on growing.
        """
        modulus, length, gap = laws.contact_modulus(steel, steel), 0.04, 5e-4
        for share in (1e-6, 1e-3, 0.1, 0.5, 0.9):
            depth = share * 4.0 * gap / math.e**2
            f = johnson_force(depth, modulus, length, gap) / length
            back = f / (math.pi * modulus) * (math.log(4.0 * math.pi * modulus * gap / f) - 1.0)
            validated(
                "penetration of Johnson's force",
                back,
                depth,
                1e-9,
                unit="m",
                source="Johnson",
                kind="exact",
            )
        forces = [johnson_force(k * 1e-5, modulus, length, gap) for k in range(1, 200)]
        assert all(np.diff(forces) > 0.0)

    def test_conformal_laws_are_stiffer_than_the_sphere(self):
        """Trap 4: the sphere formula has no length; 10 um deep, Liu and Winkler carry over three
        times as much.
        """
        sphere = laws.hertz(stiffness=PAIR.stiffness)(1e-5, 0.0, 1.0)
        for name in ("liu", "winkler"):
            assert CONTACTS[name](PAIR, 1.0)(1e-5, 0.0, 1.0) > 3.0 * sphere

    def test_contact_modulus_is_not_twice_as_much(self):
        """Trap 5: E* of two equal solids is E / (2 (1 - nu^2))."""
        assert laws.contact_modulus(steel, steel) == pytest.approx(207e9 / (2 * (1 - 0.09)))

    @pytest.mark.parametrize(("e", "off"), [(0.95, 0.01), (0.9, 0.02), (0.8, 0.02), (0.5, 0.07)])
    def test_impact_is_chosen_by_its_restitution(self, e, off):
        """0.1 kg at 1 m/s comes back with about e: the damping is from energy along the elastic
        impact.
        """
        law = CONTACTS["impact"](PAIR, e)
        actual = delivered_restitution(law, mass=0.1, stiffness=law.parameters["stiffness"])
        assert actual == pytest.approx(e, abs=off)

    def test_impact_is_adams(self, validated):
        """IMPACT(...) of the manual: K x^e less STEP times rate, never pulling; STEP(d / 2) is half
        of its top.
        """
        law = laws.impact(stiffness=1e8, exponent=2.0, damping=50.0, depth=1e-4)
        actual, wanted = (
            [law(d, 0.3, 9.9) for d in (5e-5, 2e-4)],
            [1e8 * 5e-5**2 + 7.5, 1e8 * 2e-4**2 + 15.0],
        )
        validated(
            "force of IMPACT",
            actual,
            wanted,
            1e-6,
            unit="N",
            source="ADAMS manual, by hand",
            kind="exact",
        )
        assert law(2e-4, -1.0, 9.9) == 0.0

    def test_bad_numbers(self):
        """Numbers out of range are refused with their names."""
        with pytest.raises(
            ValueError, match=r"restitution must lie in \[0.01, 1\] for this law, got 0.0"
        ):
            laws.flores(stiffness=1e8, restitution=0.0)
        with pytest.raises(TypeError, match="unknown damping"):
            laws.exact_restitution(stiffness=1e8, restitution=0.5, damping=1.0)
        with pytest.raises(ValueError, match="incompressible"):
            laws.layer_modulus(Material("rubber", 1e7, 0.5, 1000.0), 1e-3)


class TestFriction:
    @pytest.mark.parametrize("name", [n for n in FRICTIONS if n != "lugre"])
    @given(speed=st.floats(-100, 100), load=st.floats(0, 1e6))
    def test_odd_opposed_and_bounded(self, name, speed, load):
        """Friction is odd, opposes the speed and stays below its level."""
        law = FRICTIONS[name](0.1)
        force = law(speed, load)
        assert force == -law(-speed, load)
        assert force * speed <= 0.0
        viscous = law.parameters.get("viscous", 0.0)
        assert abs(force) <= (0.125 * (1 + 1e-9) + viscous * abs(speed)) * load

    @pytest.mark.parametrize(
        ("name", "share"),
        [
            ("coulomb", 1.0),
            ("coulomb_tanh", 1.0),
            ("coulomb_viscous", 11.0),
            ("threlfall", 0.95),
            ("ambrosio", 1.0),
            ("bengisu_akay", 1.0),
            ("stribeck", 1.0),
        ],
    )
    def test_fast_sliding(self, name, share):
        """At 10 m/s the force is its share of mu F_n."""
        assert FRICTIONS[name](0.1)(10.0, 50.0) == pytest.approx(-share * 0.1 * 50.0, rel=1e-6)

    @pytest.mark.parametrize("name", [n for n in FRICTIONS if n != "lugre"])
    @given(speed=st.floats(-0.1, 0.1))
    def test_continuous(self, name, speed):
        """Within a ten-thousandth of the transition speed the force moves by less than a hundredth
        of the load (by 2e-4 of it at Threlfall's joint).
        """
        law = FRICTIONS[name](0.1)
        assert abs(law(speed + 1e-8, 1.0) - law(speed, 1.0)) < 1e-3

    def test_ambrosio_ramp(self):
        """Nothing at the dead speed; half of the force in the middle of the ramp."""
        law = laws.ambrosio(coefficient=0.2, dead_speed=1e-3, full_speed=3e-3)
        assert law(1e-3, 10.0) == 0.0
        assert law(2e-3, 10.0) == pytest.approx(-1.0)

    def test_bengisu_akay_peaks_at_its_transition_speed(self):
        """The static level at the transition speed, three quarters of it at half of that."""
        law = laws.bengisu_akay(static=0.3, kinetic=0.1, transition_speed=1e-2)
        assert law(1e-2, 1.0) == pytest.approx(-0.3)
        assert law(0.5e-2, 1.0) == pytest.approx(-0.3 * 0.75)

    def test_lugre_slides_like_stribeck(self, validated):
        """In steady sliding z' = 0 and F = -(g + sigma_2 v) F_n."""
        law = laws.lugre(static=0.3, kinetic=0.1, stribeck_speed=0.01, viscous=0.2)
        for speed in (-0.02, 0.003, 0.5):
            level = 0.1 + 0.2 * math.exp(-((speed / 0.01) ** 2))
            rate, force = law(math.copysign(level, speed) / 1e5, speed, 7.0)
            assert rate == pytest.approx(0.0, abs=1e-12)
            wanted, source = (
                -7.0 * (math.copysign(level, speed) + 0.2 * speed),
                "Stribeck curve of the numbers",
            )
            validated(
                "LuGre in steady sliding",
                force,
                wanted,
                1e-6,
                unit="N",
                source=source,
                kind="exact",
            )

    @pytest.mark.parametrize("mu", [0.001, 0.01, 0.1, 0.5])
    @given(speed=st.floats(-10, 10), share=st.floats(-1.0, 1.0))
    def test_lugre_never_rubs_harder_than_it_may(self, mu, speed, share):
        """Whatever the bristles hold (up to the static level), an impact's sliding meets at most
        1.7 times mu_s F_n.
        """
        law = FRICTIONS["lugre"](mu)
        _, force = law(share * 1.25 * mu / 1e5, speed, 1.0)
        assert abs(force) <= 1.7 * 1.25 * mu

    def test_lugre_is_continuous_at_first_touch(self):
        """From relaxing to rubbing within some millinewtons, without a jump."""
        law = FRICTIONS["lugre"](0.1)
        rates = [law(1e-7, 0.05, f)[0] for f in np.linspace(0.0, 0.02, 4001)]
        assert np.abs(np.diff(rates)).max() < 6e-3 * abs(rates[-1] - rates[0])

    def test_lugre_sticks(self):
        """At rest the bristles are a spring of sigma_0 F_n, without slip."""
        rate, force = laws.lugre(static=0.3, kinetic=0.1)(1e-6, 0.0, 5.0)
        assert (rate, force) == (0.0, pytest.approx(-5.0 * 1e5 * 1e-6))

    def test_lugre_forgets_without_contact(self):
        """Without load the bristles relax at stiffness over damping."""
        rate, force = laws.lugre(static=0.3, kinetic=0.1, stiffness=1e5, damping=30.0)(
            1e-6, 1.0, 0.0
        )
        assert (rate, force) == (pytest.approx(-1e-6 * 1e5 / 30.0), 0.0)


class TestFilms:
    #: section 3.8: Reynolds equation by finite differences, L/D = 1: eps, wedge -Fr, Ft, approach
    #: -Fr, recede Fr
    GRID = (
        (0.1, 0.0262, 0.2428, 6.0268, 3.9168),
        (0.3, 0.2620, 0.7803, 10.102, 2.6989),
        (0.5, 0.9242, 1.5189, 19.482, 1.9416),
        (0.7, 2.8895, 2.8716, 49.746, 1.4442),
        (0.9, 15.077, 7.5835, 321.17, 1.1034),
    )

    @pytest.mark.parametrize("row", GRID, ids=lambda r: f"eps {r[0]}")
    def test_harmonic_against_the_reynolds_equation(self, row, validated):
        """The finite bearing's film is within 8 % of the solved Reynolds equation for L/D = 1, in
        all pure motions.
        """
        eps, wedge_r, wedge_t, approach, recede = row
        film = laws.harmonic()
        actual = (
            *film(eps, 0.0, 1.0, UNIT),
            film(eps, 1.0, 0.0, UNIT)[0],
            film(eps, -1.0, 0.0, UNIT)[0],
        )
        options = {"source": "Reynolds equation by finite differences", "kind": "independent"}
        for mine, theirs in zip(actual, (-wedge_r, wedge_t, -approach, recede), strict=True):
            validated("force of the harmonic film, L/D 1", mine, theirs, 0.08, **options)

    @pytest.mark.parametrize(
        ("name", "low", "high"),
        [("long", 0.385, 6.75), ("short", 0.10, 5.55), ("harmonic", 0.0, 0.22)],
    )
    def test_errors_at_length_one(self, name, low, high):
        """Section 3.4 at L/D = 1: errors against Reynolds (39 to 671 %, 10 to 550 %, to 22 %)."""
        film, errors = FILMS[name](), []
        for eps, wedge_r, wedge_t, approach, recede in (self.GRID[1], self.GRID[4]):
            for state, wanted in (
                ((0, 1), (-wedge_r, wedge_t)),
                ((1, 0), (-approach, 0)),
                ((-1, 0), (recede, 0)),
            ):
                apart = np.subtract(film(eps, float(state[0]), float(state[1]), UNIT), wanted)
                errors.append(np.hypot(*apart) / np.hypot(*wanted))
        assert low <= min(errors)
        assert max(errors) <= high

    @pytest.mark.parametrize(
        ("eps", "long", "short"), [(0.3, 2.0, 0.5), (0.6, 2.0, 0.5), (0.9, 1.4, 0.5)]
    )
    def test_long_and_short_films_are_too_stiff_at_length_one(self, eps, long, short):
        """Section 3.4: at L/D = 1 the long film carries far too much, and so does the short one."""
        reference = np.hypot(*laws.harmonic()(eps, 0.0, 1.0, UNIT))
        assert np.hypot(*laws.long_film()(eps, 0.0, 1.0, UNIT)) > long * reference
        assert np.hypot(*laws.short_film()(eps, 0.0, 1.0, UNIT)) > (1 + short) * 0.7 * reference

    @pytest.mark.parametrize(
        ("state", "force"),
        [
            ((0.5, 1.0, 1.0), (-46.69790, 6.41712)),
            ((0.5, -1.0, 1.0), (11.34368, 3.25647)),
            ((0.95, -0.1, 1.0), (-6.74436, 10.61760)),
        ],
    )
    def test_long_film_check_values(self, state, force, validated):
        """Three states of another quadrature: 2e-6."""
        options = {"source": "quadrature of the long film", "kind": "independent"}
        validated("force of the long film", laws.long_film()(*state, LONG), force, 2e-6, **options)

    @given(st.floats(1e-4, 0.98), st.floats(-3, 3), st.floats(-3, 3))
    def test_long_film_by_quadrature(self, eps, rate, w):
        """The pressure of the long bearing, integrated over its positive arc: 1e-8 of the force."""
        if abs(rate) + abs(eps * w) < 1e-6:
            return
        start = math.atan2((2 + eps**2) * rate, eps * w)

        def q(t):
            h = 1 + eps * np.cos(t)
            return 6 * (
                w * eps * np.sin(t) * (2 + eps * np.cos(t)) / ((2 + eps**2) * h**2)
                + rate / eps / h**2
            )

        x, weight = GAUSS
        t = start + 0.5 * np.pi * (x + 1)
        p = q(t) - q(np.array(start))
        wanted = [0.5 * np.pi * np.sum(weight * p * f(t)) for f in (np.cos, np.sin)]
        assert laws.long_film()(eps, rate, w, LONG) == pytest.approx(
            wanted, abs=1e-8 * np.hypot(*wanted) + 1e-9 / eps
        )

    def test_short_film_is_ocvirk(self, validated):
        """eps = 0.5, steady: W c^2 / (mu omega R L^3) = 0.750381081812, attitude 53.680201
        degrees.
        """
        fr, ft = laws.short_film()(0.5, 0.0, 1.0, UNIT)
        load, angle, options = (
            math.hypot(fr, ft) / 4.0,
            math.degrees(math.atan2(ft, -fr)),
            {"source": "Ocvirk"},
        )
        validated(
            "W c^2 / (mu omega R L^3), eps 0.5",
            load,
            0.750381081812,
            1e-10,
            kind="exact",
            **options,
        )
        options |= {"unit": "deg", "relative": False, "kind": "exact"}
        validated("attitude, eps 0.5", angle, 53.680201, 1e-6, **options)

    @pytest.mark.parametrize("eps", [0.05, 0.0999999, 0.1000001, 0.4, 0.999])
    @pytest.mark.parametrize("start", [-2.0, 0.3, 1.5])
    def test_arc_integrals(self, eps, start, validated):
        """Closed form and Gauss points are the same integrals: 1e-10 of the largest."""
        x, w = GAUSS
        t = start + 0.5 * np.pi * (x + 1)
        h = 1 + eps * np.cos(t)
        powers = ((1, 0), (1, 1), (0, 1), (0, 2), (2, 0))
        wanted = [
            0.5 * np.pi * np.sum(w * np.sin(t) ** a * np.cos(t) ** b / h**3) for a, b in powers
        ]
        actual, size = arc_integrals(eps, 1 - eps**2, start), max(map(abs, wanted))
        validated(
            "arc integrals",
            actual,
            wanted,
            1e-10,
            source="Gauss points",
            kind="independent",
            relative=size,
        )

    @given(st.floats(1e-6, 1e6))
    def test_axial_mean_of_the_harmonic_sum(self, r):
        """Against quadrature over the axial coordinate; both branches; 1e-9."""
        x, w = GAUSS
        z = 0.5 * (x + 1.0)
        mean = 0.5 * np.sum(w * (1 - z**2) / ((1 - z**2) + r))
        assert harmonic_share(1.0 / (1.0 + r)) == pytest.approx(mean, rel=2e-6)

    @pytest.mark.parametrize("slender", [0.05, 10.0])
    def test_harmonic_between_short_and_long(self, slender):
        """A very short bearing is the short film to 5 %, a very long one the long film to 12 %
        (steady, eps = 0.6).
        """
        joint = FilmJoint(
            radius=1.0, clearance=1.0, length=2.0 * slender, viscosity=1.0 / (2.0 * slender)
        )
        limit, share = (laws.short_film(), 0.05) if slender < 1.0 else (laws.long_film(), 0.12)
        assert laws.harmonic()(0.6, 0.0, 1.0, joint) == pytest.approx(
            limit(0.6, 0.0, 1.0, joint), rel=share
        )

    @pytest.mark.parametrize("name", FILMS)
    @given(
        eps=st.floats(0.0, 3.0),
        rate=st.floats(-1e4, 1e4),
        w=st.floats(-1e4, 1e4),
    )
    @settings(max_examples=60)
    def test_finite_for_every_state(self, name, eps, rate, w):
        """Forces and their slopes have no state without a number."""
        assert all(map(math.isfinite, FILMS[name]()(eps, rate, w, JOINT)))
        assert np.isfinite(derivative(FILMS[name](), (eps, rate, w, JOINT), 3)).all()

    def test_a_harmonic_film_is_finite_at_the_wall(self):
        """Wherever the arc of its pressure begins; one of 300 motions divided by zero."""
        law, rng = FILMS["harmonic"](), np.random.default_rng(0)
        for eps, rate, w in zip(
            rng.choice([1.0, 1.5], 3000), *rng.uniform(-1e4, 1e4, (2, 3000)), strict=True
        ):
            assert all(map(math.isfinite, law(float(eps), float(rate), float(w), JOINT)))

    @pytest.mark.parametrize("name", FILMS)
    @pytest.mark.parametrize("eps", [0.0, 0.5, 0.99, 1.0, 1.2])
    @pytest.mark.parametrize("rate", [0.0, -0.0, 1e-9, -1e-9, 1e-12, 5.0])
    @pytest.mark.parametrize("w", [0.0, -100.0, 1e-12])
    def test_finite_at_the_corners(self, name, eps, rate, w):
        """Zeros of both signs, tiny rates, the wall and beyond it."""
        law, state = FILMS[name](), (eps, rate, w, JOINT)
        assert all(map(math.isfinite, law(*state)))
        assert np.isfinite(derivative(law, state, 3)).all()

    @pytest.mark.parametrize("name", FILMS)
    @pytest.mark.parametrize("eps", [0.3, 0.9])
    def test_continuous_at_rest(self, name, eps):
        """Below and above the rest floor the approach's force is proportional to its rate: 1 %."""
        film = FILMS[name]()
        below, above = film(eps, 0.9e-9, 0.0, JOINT)[0], film(eps, 1.1e-9, 0.0, JOINT)[0]
        assert below < 0.0
        if name != "pinkus_sternlicht":  # rests on a square root of its own
            assert below / above == pytest.approx(0.9 / 1.1, rel=0.01)

    @pytest.mark.parametrize("name", [n for n in FILMS if n != "short"])
    @given(eps=st.floats(0.05, 0.95), w=st.floats(1.0, 100.0))
    @settings(max_examples=30)
    def test_slope_is_continuous_where_approach_turns(self, name, eps, w):
        """C1 in the radial rate at 0 with entrainment: slopes from both sides agree to 2 %."""
        film, h = FILMS[name](), 1e-5 * w * eps
        rest = np.array(film(eps, 0.0, w, JOINT))
        right = (np.array(film(eps, h, w, JOINT)) - rest) / h
        behind = (rest - np.array(film(eps, -h, w, JOINT))) / h
        assert right == pytest.approx(behind, abs=0.02 * np.hypot(*right))

    @pytest.mark.parametrize("name", FILMS)
    @given(eps=st.floats(0.0, 1.5), rate=st.floats(-1e4, 1e4))
    def test_squeeze_dissipates(self, name, eps, rate):
        """Without entrainment a film never does work: F_r eps' <= 0."""
        if abs(rate) < 1e-6:
            return
        radial, tangential = FILMS[name]()(eps, rate, 0.0, JOINT)
        assert radial * rate <= 1e-200
        assert abs(tangential) <= 1e-9 * (abs(radial) + 1e-9)

    @pytest.mark.parametrize("name", FILMS)
    @given(
        eps=st.floats(0.0, 0.999),
        rate=st.floats(-1e3, 1e3),
        w=st.floats(-1e3, 1e3),
        scale=st.floats(0.1, 10.0),
    )
    def test_homogeneous_and_mirror_symmetric(self, name, eps, rate, w, scale):
        """Linear in (rate, w) together; turned around, the tangential force changes its sign: 1e-7
        (rest floor).
        """
        film = FILMS[name]()
        if abs(rate) + abs(eps * w) < 0.1:
            return
        fr, ft = film(eps, rate, w, JOINT)
        size = math.hypot(fr, ft)
        assert film(eps, scale * rate, scale * w, JOINT) == pytest.approx(
            (scale * fr, scale * ft), abs=1e-7 * scale * size
        )
        assert film(eps, rate, -w, JOINT) == pytest.approx((fr, -ft), abs=1e-7 * size)

    @pytest.mark.parametrize("name", FILMS)
    @given(eps=st.floats(0.01, 0.99), rate=st.floats(-50, 50), w=st.floats(-100, 100))
    def test_exact_derivative(self, name, eps, rate, w):
        """Against central differences: 1e-4 of the largest slope (the arcs' ends move too)."""
        if abs(rate) < 0.5 or abs(w) < 0.5 or 0.098 < eps < 0.102:
            return
        law, state = FILMS[name](), (eps, rate, w, JOINT)
        steps = (1e-6 * (1 - eps), 1e-5, 1e-5)
        actual, checked = derivative(law, state, 3), difference(law, state, 3, steps)
        scale = np.array([[1.0 - eps, abs(rate) + abs(w), abs(rate) + abs(w)]])
        size = np.abs(checked * scale).max() + np.abs(law(*state)).max()
        assert (np.abs((actual - checked) * scale) < 1e-4 * size).all()

    def test_wrong_entrainment_changes_the_film(self):
        """Trap 2: the sum of the speeds carries; with the difference bodies that turn alike would
        lose their wedge.
        """
        film = laws.harmonic()
        together, wrong = film(0.5, 0.0, 20.0 + 20.0, JOINT), film(0.5, 0.0, 20.0 - 20.0, JOINT)
        assert np.hypot(*together) > 0.0
        assert wrong == pytest.approx((0.0, 0.0), abs=1e-12)

    def test_sommerfeld_allows_tension(self, validated):
        """The full film pulls a receding journal back."""
        radial, _ = laws.full_sommerfeld()(0.5, -1.0, 0.0, LONG)
        wanted, source = 12 * math.pi / 0.75**1.5, "Sommerfeld's full film"
        validated(
            "tension of a receding long film", radial, wanted, 1e-6, source=source, kind="exact"
        )


class TestAsperities:
    @pytest.mark.parametrize("x", [-2.0, 0.0, 2.0])
    def test_closed_form_of_the_conformal_load(self, x, validated):
        """Greenwood and Tripp's pressure integrated over the parabolic gap: 1e-6."""
        u = np.linspace(-8.0, 8.0, 4001)
        pressure = moments(2.5, x + u[::20] ** 2)
        integral = np.trapezoid(pressure, u[::20])
        actual = 5 * math.pi / 16 * third_moment(x)
        validated(
            "Greenwood and Tripp's load of a parabolic gap",
            actual,
            integral,
            1e-5,
            source="quadrature",
            kind="independent",
        )

    @pytest.mark.parametrize("x", [-2.0, 0.5])
    def test_closed_form_for_one_rough_surface(self, x, validated):
        """Greenwood and Williamson's pressure integrated over the parabolic gap: 1e-5."""
        u = np.linspace(-8.0, 8.0, 201)
        integral = np.trapezoid(moments(1.5, x + u * u), u)
        actual = 3 * math.pi / 8 * second_moment(x)
        validated(
            "Greenwood and Williamson's load of a parabolic gap",
            actual,
            integral,
            1e-5,
            source="quadrature",
            kind="independent",
        )

    #: section 2.5: exact integrals, and how far two engineering fits of F_5/2 and one of F_2 are
    #: off
    FITS = (
        (0.0, 6.166e-1, 0.893, 1.004, 5.000e-1, 0.998),
        (1.0, 8.056e-2, 0.965, 1.068, 7.534e-2, 0.910),
        (2.0, 5.424e-3, 0.908, 2.21, 5.769e-3, 0.725),
        (3.0, 1.709e-4, 0.258, 9.7, 2.034e-4, 0.172),
        (3.5, 2.231e-5, 0.018, 27.8, 2.795e-5, 0.010),
    )

    @pytest.mark.parametrize("row", FITS, ids=lambda r: f"lambda {r[0]}")
    def test_table_of_integrals_and_fits(self, row, validated):
        """Four printed digits of the integrals, the printed digits of the ratios (trap 12: the fits
        end at 2.3).
        """
        x, f52, power, exponential, f2, second = row
        options = {"source": "table of another quadrature", "kind": "independent"}
        actual = moments(2.5, np.array([x]))[0]
        validated("F_5/2", actual, f52, 6e-4, **options)
        validated("F_2", second_moment(x), f2, 6e-4, **options)
        assert 4.4086e-5 * (4 - x) ** 6.804 / actual == pytest.approx(power, abs=1e-3)
        assert 0.6189 * math.exp(-1.973 * x) / actual == pytest.approx(exponential, rel=1e-2)
        assert 3.5e-5 * (4 - x) ** 6.9 / second_moment(x) == pytest.approx(second, abs=1e-3)

    @pytest.mark.parametrize("name", ASPERITIES)
    @given(ratio=st.floats(-30.0, 1e6))
    def test_finite_falling_and_positive(self, name, ratio):
        """The load falls with the gap, with finite slopes."""
        law = ASPERITIES[name](modulus=1e11)
        here, further = law(ratio, JOINT), law(ratio + 0.1, JOINT)
        assert math.isfinite(here)
        assert here >= further >= 0.0
        assert np.isfinite(derivative(law, (ratio, JOINT), 1)).all()

    def test_vanishes_in_full_film(self):
        """At lambda = 3, 2e-4 of the load at 0; at 4, 2.4e-6."""
        law = laws.greenwood_tripp(modulus=1e11)
        assert law(3.0, JOINT) / law(0.0, JOINT) == pytest.approx(2e-4, rel=0.3)
        assert law(4.0, JOINT) / law(0.0, JOINT) == pytest.approx(2.4e-6, rel=0.3)

    @pytest.mark.parametrize(
        ("law", "order", "strength"),
        [
            (
                laws.greenwood_tripp,
                2.5,
                16 * math.sqrt(2) * math.pi / 15 * 0.05**2 * math.sqrt(2e-3),
            ),
            (laws.greenwood_williamson, 1.5, 4 / 3 * 0.05 * math.sqrt(2e-3)),
        ],
    )
    @pytest.mark.parametrize("ratio", [-1.0, 0.5, 2.0])
    def test_load_is_the_pressure_over_the_arc(self, law, order, strength, ratio, validated):
        """Trap 5: K' E* F_5/2 (4/3 eta sqrt(beta) sigma^1.5 E* F_3/2) over the joint's true gap; 2
        % (parabola).
        """
        joint, modulus = JOINT, laws.contact_modulus(steel, steel)
        e = joint.clearance - ratio * joint.roughness
        angle = np.linspace(-0.6, 0.6, 401)
        gap = (joint.clearance - e * np.cos(angle)) / joint.roughness
        pressure = strength * modulus * moments(order, np.minimum(gap, 60.0))
        load = np.trapezoid(pressure * np.cos(angle), angle) * joint.radius * joint.length
        actual = law(modulus=modulus, roughness_group=0.05, slope_ratio=2e-3)(ratio, joint)
        options = {"unit": "N", "source": "pressure summed over the arc", "kind": "independent"}
        validated("load of asperities in a joint", actual, load, 2e-2, **options)

    def test_composite_roughness(self):
        """The root of the sum of squares."""
        assert laws.composite_roughness(3e-7, 4e-7) == pytest.approx(5e-7)

    @pytest.mark.parametrize("pattern", [1 / 9, 1 / 6, 1 / 3, 1, 3, 6, 9])
    def test_shear_flow_factor_is_continuous(self, pattern):
        """At H = 5 the two branches meet to four digits, for all seven patterns."""
        before, after = (laws.shear_flow_factor(h, pattern) for h in (5.0, 5.0 + 1e-12))
        assert before == pytest.approx(after, rel=6e-3)

    def test_published_flow_factors(self, validated):
        """phi_p at H = 1 and 3, isotropic: 1 - 0.9 exp(-0.56 H); phi_s at H = 1: 1.899
        exp(-0.92 + 0.05).
        """
        actual = [laws.pressure_flow_factor(*x) for x in ((1.0,), (3.0,), (2.0, 9.0))]
        options = {"source": "Patir and Cheng 1978, 1979", "relative": False}
        validated("pressure flow factors", actual, [0.4859, 0.8323, 1.3076], 1e-4, **options)
        validated("shear flow factor", laws.shear_flow_factor(1.0), 0.7956, 1e-4, **options)

    def test_smooth_limit_of_the_flow_factors(self):
        """Thick films do not see the roughness."""
        for pattern in (1 / 9, 1.0, 9.0):
            assert laws.pressure_flow_factor(1e3, pattern) == pytest.approx(1.0, abs=1e-4)
            assert laws.shear_flow_factor(1e3, pattern) == pytest.approx(0.0, abs=1e-6)
        assert laws.contact_flow_factor(10.0) == pytest.approx(1.0)

    @pytest.mark.parametrize(
        ("ratio", "factor"), [(0.0, 0.501), (0.5, 0.6899), (1.0, 0.8411), (2.0, 0.9778)]
    )
    def test_contact_flow_factor_is_what_wu_and_zheng_fitted(self, ratio, factor, validated):
        """Four printed factors."""
        actual, source = laws.contact_flow_factor(ratio), "Wu and Zheng 1989"
        validated("contact flow factor", actual, factor, 2e-3, source=source, relative=False)

    def test_unknown_pattern(self):
        """A pattern without coefficients is refused with those that have some."""
        with pytest.raises(ValueError, match="pattern must be one of 1/9, 1/6"):
            laws.pressure_flow_factor(1.0, 2.0)


gaps = st.floats(-30.0 * 0.8e-6, 1e-4)


class TestTransitions:
    @pytest.mark.parametrize("name", TRANSITIONS)
    @given(gap=gaps)
    def test_memberships_are_a_partition(self, name, gap):
        """Memberships add to one; all shares lie between 0 and 1."""
        law = TRANSITIONS[name](dry=0.4, mixed=1.0, full=3.0)
        film, film_gap, slope, contact, penetration, *states = law(gap, JOINT)
        assert sum(states) == pytest.approx(1.0, abs=1e-14)
        assert all(0.0 <= s <= 1.0 for s in states)
        assert film_gap > 0.0
        assert 0.0 <= film <= 1.0
        assert 0.0 <= contact <= 1.0
        assert 0.0 <= slope <= 1.0 + 1e-12
        assert math.isfinite(penetration)

    @pytest.mark.parametrize("name", ["fuzzy", "load_sharing"])
    @given(ratio=st.floats(-5.0, 5.0))
    def test_smooth(self, name, ratio):
        """C1: slopes to both sides of any gap agree within the change that a bounded curvature
        allows.
        """
        law = TRANSITIONS[name](dry=0.4, mixed=1.0, full=3.0)
        h, gap = 1e-6 * JOINT.roughness, ratio * JOINT.roughness
        here = np.array(law(gap, JOINT))
        right = (np.array(law(gap + h, JOINT)) - here) / h * JOINT.roughness
        behind = (here - np.array(law(gap - h, JOINT))) / h * JOINT.roughness
        assert np.abs(right - behind).max() < 1e-4

    def test_full_film_and_dry_limits_are_exact(self):
        """Fuzzy: the film alone from the upper threshold on; contact alone up to the lower one.
        A negative penetration is none.
        """
        law = laws.fuzzy()
        assert law(3.0 * 0.8e-6, JOINT)[:4] == (1.0, 3.0 * 0.8e-6, 1.0, 0.0)
        assert law(3.0 * 0.8e-6, JOINT)[4] == pytest.approx(-2.0 * 0.8e-6)
        film, _, _, contact, penetration, *_ = law(0.4 * 0.8e-6, JOINT)
        assert (film, contact, penetration) == (
            pytest.approx(0.0, abs=1e-15),
            1.0,
            pytest.approx(0.6 * 0.8e-6),
        )
        far = laws.load_sharing()(40 * 0.8e-6, JOINT)
        assert far[1] == pytest.approx(40 * 0.8e-6, rel=1e-6)
        assert far[2] == pytest.approx(1.0, abs=1e-6)

    @given(st.floats(-30.0, 1e6))
    def test_mean_gap(self, ratio):
        """h_T = E[max(h + s, 0)] of Gaussian heights: monotone, above h, never thinner than 0.02
        sigma.
        """
        _, gap, slope, *_ = laws.load_sharing()(ratio * 0.8e-6, JOINT)
        assert gap >= max(ratio, 0.02) * 0.8e-6 * (1 - 1e-12)
        assert slope >= 0.0

    @given(st.floats(-6.0, 30.0))
    def test_the_film_closes_as_its_mean_gap_does(self, ratio):
        """The slope that the squeeze is scaled with is the derivative of the film gap: 1e-5."""
        law, h = laws.load_sharing(), 1e-4
        ahead, behind = (law((ratio + s) * 0.8e-6, JOINT)[1] for s in (h, -h))
        assert law(ratio * 0.8e-6, JOINT)[2] == pytest.approx(
            (ahead - behind) / (2 * h * 0.8e-6), abs=1e-5
        )

    @pytest.mark.parametrize("squeeze", [0.0, 0.3, 1.0])
    @given(st.floats(-2.0, 4.0))
    def test_share_of_the_squeeze_rate(self, squeeze, ratio):
        """A film that is held closes at `squeeze` of the true rate: from the film gap's difference,
        1e-4.
        """
        law, h = laws.fuzzy(squeeze=squeeze), 1e-5
        ahead, behind = (law((ratio + s) * 0.8e-6, JOINT)[1] for s in (h, -h))
        held = (ahead - behind) / (2 * h * 0.8e-6)
        assert law(ratio * 0.8e-6, JOINT)[2] == pytest.approx(
            squeeze + (1.0 - squeeze) * held, abs=1e-4
        )

    @pytest.mark.parametrize(("squeeze", "least", "most"), [(1.0, 0.8, 1.0), (0.0, 0.0, 0.0)])
    def test_a_squeezed_load_does_not_drop_where_the_gap_is_held(self, squeeze, least, most):
        """A journal that only approaches, from 1.1 to 0.85 of the threshold: the film keeps the
        load but for its weight, which falls by 14 %. At the rate of a gap that stands still all is
        lost.
        """
        joint = mixed_joint(transition=laws.fuzzy(squeeze=squeeze), film=laws.harmonic())

        def film_load(ratio):
            share, gap, slope, *_ = joint.transition(ratio * joint.roughness, JOINT)
            return -share * joint.film(1.0 - gap / joint.clearance, 10.0 * slope, 0.0, JOINT)[0]

        assert least <= film_load(0.85) / film_load(1.1) <= most

    @pytest.mark.parametrize("datum", [0.0, 1.0, 2.0])
    def test_contact_begins_at_its_datum(self, datum):
        """Penetration is 0 at datum l_m sigma and grows with the approach from there (rounding)."""
        law = laws.fuzzy(dry=0.2, mixed=0.5, full=1.5, datum=datum)
        begin = datum * 0.5 * 0.8e-6
        assert law(begin + 1e-9, JOINT)[4] == pytest.approx(-1e-9, rel=1e-9)
        assert law(begin - 1e-7, JOINT)[4] == pytest.approx(1e-7, rel=1e-9)

    def test_full_film_is_exact_for_close_thresholds(self):
        """Above the upper threshold the film gap is the gap."""
        assert laws.fuzzy(full=1.02)(1.03 * 0.8e-6, JOINT)[1] == 1.03 * 0.8e-6

    @pytest.mark.parametrize("name", TRANSITIONS)
    def test_memberships_are_those_of_the_film_thickness_ratio(self, name):
        """In every rung alike, so that rungs can be compared."""
        for ratio in (0.2, 0.7, 1.7, 4.0):
            actual = TRANSITIONS[name](dry=0.4, mixed=1.0, full=3.0)(ratio * 0.8e-6, JOINT)[5:]
            assert actual == pytest.approx(laws.memberships(ratio, 0.4, 1.0, 3.0))

    def test_mean_gap_by_quadrature(self, validated):
        """The mean gap against its integral over the heights: 1e-4."""
        x, w = GAUSS
        for ratio in (-1.0, 0.0, 1.5):
            s = -ratio + 6.0 * (x + 1.0)
            mean = 6.0 * np.sum(w * (ratio + s) * np.exp(-0.5 * s * s) / math.sqrt(2 * math.pi))
            actual = laws.load_sharing()(ratio * 0.8e-6, JOINT)[1] / 0.8e-6
            gap = math.sqrt(actual**2 - 0.02**2)
            validated(
                "mean gap of rough surfaces over sigma",
                gap,
                mean,
                1e-4,
                source="quadrature",
                kind="independent",
            )

    def test_contact_starts_where_the_film_begins_to_fade(self):
        """Trap 8: with contact from e > c only, nothing would carry between lambda 0 and the lower
        threshold.
        """
        loads = force_hole.JointLoads(mixed_joint(transition=laws.fuzzy()))
        for ratio in np.linspace(-1.0, 4.0, 60):
            assert loads("loads", ratio * 0.8e-6, 1e-4, 30.0)[1] > 1.0

    def test_flores_is_its_formula(self):
        """F = ((c + e0 - e) F_film + (e - c) F_dry) / e0 between c and c + e0."""
        joint = mixed_joint(transition=laws.flores_hybrid(tolerance=0.05), asperity=None)
        e0, depth = 0.05 * joint.clearance, 0.02 * joint.clearance
        frozen = -joint.film(0.999, 0.0, 30.0, joint.film_joint)[0]
        blend = ((e0 - depth) * frozen + depth * joint.contact(depth, 0.0, 0.0)) / e0
        _, load = force_hole.JointLoads(joint)("loads", -depth, 0.0, 30.0)
        assert load == pytest.approx(blend, rel=1e-12)

    @pytest.mark.parametrize("name", TRANSITIONS)
    @given(gap=gaps)
    def test_exact_derivative(self, name, gap):
        """Against one-sided differences, of which one is close: 1e-3."""
        law = TRANSITIONS[name](dry=0.4, mixed=1.0, full=3.0)
        actual = derivative(law, (gap, JOINT), 1)[:, 0]
        sides = [
            (np.array(law(gap + s * 1e-12, JOINT)) - np.array(law(gap, JOINT))) / (s * 1e-12)
            for s in (1, -1)
        ]
        size = np.abs(sides[0]) + 1.0 / JOINT.roughness
        close = np.minimum(*(np.abs(actual - s) for s in sides)) < 1e-3 * size
        assert close[:5].all()


def mixed_joint(**more):
    """The feeder's joint, film and contact together."""
    body = cl.Body("rod", 1.0, 1e-3)
    slots = {
        "radius": 0.01,
        "clearance": 1e-4,
        "length": 0.02,
        "film": laws.harmonic(),
        "lubricant": cl.Lubricant(0.05),
        "contact": CONTACTS["winkler"](Pair(0.01, 1e-4, 0.02, steel), 0.9),
        "transition": laws.load_sharing(),
        "roughness": 0.8e-6,
        "asperity": laws.greenwood_tripp(modulus=laws.contact_modulus(steel, steel)),
    }
    return cl.ClearanceRevolute(cl.ground, body, name="J", **(slots | more))


def thrown(law, speed, clearance=1e-4, **more):
    """A body that flies against its bearing [m/s]; no weight."""
    joint = cl.ClearanceRevolute(
        cl.ground,
        cl.Body("rod", 1.0, 1e-3),
        name="J",
        radius=0.01,
        clearance=clearance,
        contact=law,
        eccentricity_rate=(speed, 0.0),
        **more,
    )
    return cl.Scene(joint, gravity=(0.0, 0.0))


class TestMixedJoints:
    @pytest.mark.parametrize(
        ("change", "line"),
        [
            (
                {"transition": None, "asperity": None},
                "joint J: film and contact together need a transition model",
            ),
            (
                {"film": None, "lubricant": None},
                "joint J: transition load_sharing needs a film law",
            ),
            (
                {"contact": None, "asperity": None},
                "joint J: transition load_sharing needs a contact law",
            ),
            ({"lubricant": None}, "joint J: film needs lubricant=Lubricant"),
            ({"length": None}, "joint J: film needs the bearing length"),
            ({"roughness": None}, "joint J: asperity greenwood_tripp needs the joint's roughness"),
            (
                {"roughness": None, "asperity": None},
                "joint J: transition load_sharing needs the joint's roughness",
            ),
            ({"roughness": -1e-6}, "joint J: roughness must be positive"),
            (
                {"roughness": 2e-5},
                "joint J: transition load_sharing needs a clearance of at least 6 times the "
                "roughness",
            ),
            (
                {"transition": laws.fuzzy(dry=2.0)},
                "joint J: transition fuzzy needs thresholds dry < mixed < full, got 2",
            ),
            (
                {"transition": laws.fuzzy(datum=4.0)},
                "transition fuzzy needs a datum of at most full / mixed = 3, got 4",
            ),
            (
                {"friction": laws.ambrosio(coefficient=0.1, dead_speed=1.0)},
                "joint J: friction ambrosio needs dead_speed",
            ),
            ({"layer": 0.0}, "joint J: layer must be positive"),
        ],
    )
    def test_bad_input_names_the_joint(self, change, line):
        """Missing and impossible fields are refused with the joint's name."""
        with pytest.raises((ValueError, TypeError), match=line):
            mixed_joint(**change)

    def test_hole_check_tells_soft_from_conformal_contact(self):
        """Trap 2 of the transition: with a sphere's stiffness the fuzzy film fades before contact
        carries; Winkler's leaves a smaller hole; load sharing none.
        """
        soft = mixed_joint(
            transition=laws.fuzzy(),
            contact=laws.hertz(stiffness=PAIR.stiffness),
            asperity=None,
            film=laws.harmonic(),
        )
        hard = mixed_joint(transition=laws.fuzzy(), asperity=None)
        actual = {
            n: cl.hole_check(j, 60.0)
            for n, j in (("soft", soft), ("hard", hard), ("sharing", mixed_joint()))
        }
        assert not actual["soft"].monotone
        assert actual["sharing"].monotone
        assert actual["soft"].lost > 1.5 * actual["hard"].lost

    def test_hole_check_compares_with_the_load_before_the_drop(self):
        """Contact from the wall on, far stiffer than the film: what the film lost is lost all the
        same.
        """
        thin = cl.Lubricant(0.002)
        joint = mixed_joint(transition=laws.fuzzy(datum=0.0), asperity=None, lubricant=thin)
        for approach in (0.0, 1e-3):
            hole = cl.hole_check(joint, 60.0, approach)
            assert not hole.monotone
            assert (hole.left, hole.where) == (0.0, pytest.approx(0.4))
            assert hole.lost == hole.highest < max(hole.load)
        assert cl.hole_check(joint, 60.0).lost < 0.02 * max(hole.load)

    @pytest.mark.parametrize(
        ("options", "ratio", "warned"),
        [
            ({"transition": "load_sharing", "asperity": "none"}, 0.8, True),
            ({"transition": "load_sharing", "asperity": "none"}, 1.1, False),
            ({"transition": "load_sharing"}, 0.8, False),
            ({"transition": "fuzzy"}, 0.8, False),
        ],
    )
    def test_touching_asperities_need_a_law(self, options, ratio, warned):
        """Shared loads without an asperity law, below a film thickness ratio of 1."""
        scene = cl.load_case("slider_crank", model="mixed", **options)
        joint = scene.clearance_joints[0]
        actual = regimes.regime(joint, 1e3, ratio * joint.roughness).warnings(joint)
        texts = [w for w in actual if "falls to 0.8; below 1 asperities" in w]
        assert len(texts) == len(actual) == int(warned)

    @pytest.mark.parametrize(
        ("law", "stiffness", "cause"),
        [
            (laws.fuzzy(datum=0.0), None, "the film fades before contact begins, at the wall"),
            (
                laws.fuzzy(dry=0.1, datum=0.3),
                None,
                "before contact begins, at film thickness ratio 0.3",
            ),
            (laws.fuzzy(), 1e10, "the film fades, and the contact law is too soft to replace it"),
            (
                laws.fuzzy(squeeze=0.0),
                1e10,
                "the held film loses its squeeze rate, and the contact law is too soft",
            ),
        ],
    )
    def test_hole_warning_names_its_cause(self, law, stiffness, cause):
        """The warning states why the film fades, and where."""
        soft = {"contact": laws.hertz(stiffness=stiffness)} if stiffness else {}
        joint = mixed_joint(transition=law, asperity=None, lubricant=cl.Lubricant(0.005), **soft)
        warning = force_hole.hole_warning(joint, 30.0, 3000.0, reached=-1.0)
        assert "joint J: force hole" in warning
        assert cause in warning

    def test_holes_that_a_run_does_not_meet_are_not_warned_of(self):
        """A load that contact carries, a run that stays above, a film that carries the load at
        rest.
        """
        joint = mixed_joint(transition=laws.fuzzy(), asperity=None, lubricant=cl.Lubricant(0.005))
        warning = partial(force_hole.hole_warning, joint, 30.0)
        assert warning(3000.0, reached=0.0) is not None
        assert warning(300.0, reached=0.0) is None
        assert warning(3000.0, reached=0.8) is None
        late = mixed_joint(transition=laws.fuzzy(datum=0.0), asperity=None)
        # its film carries 1 kN and more at rest
        assert force_hole.hole_warning(late, 30.0, 100.0) is None
        assert force_hole.hole_warning(late, 30.0, 1e4) is not None

    def test_speed_of_a_load(self):
        """At its speed the load is carried at the film's rim (1 %: the secant steps)."""
        joint = mixed_joint(transition=laws.fuzzy(), asperity=None, lubricant=cl.Lubricant(0.005))
        loads = force_hole.JointLoads(joint)
        crest, speed, *_ = loads("scans", 60.0, 0.0, 2000.0)
        _, load = loads("loads", crest * joint.roughness, speed, 60.0)
        assert load == pytest.approx(2000.0, rel=0.01)

    def test_a_run_through_a_hole_is_warned_of(self):
        """The feeder with contact from the wall on, at 2 mPa s: it strikes with more than 9 kN."""
        options = {"model": "mixed", "transition": "fuzzy(datum=0)", "viscosity": 0.002}
        result = cl.simulate(cl.load_case("six_bar_feeder", **options), turns=1)
        assert result.extreme("joints/B/force_max").value > 3000.0
        assert any(
            "force hole" in w and "contact begins, at the wall" in w for w in result.warnings
        )

    def test_hole_warning_comes_before_and_with_the_result(self, caplog):
        """The log has the warning before the run, the result after it."""
        options = {"model": "mixed", "contact": "hertz", "elastic": "false"}
        with caplog.at_level(logging.WARNING):
            result = cl.simulate(cl.load_case("six_bar_feeder", **options), turns=1)
        assert any("force hole" in w and "joint B" in w for w in result.warnings)
        assert "joint B: force hole" in caplog.text  # before the run

    def test_a_hole_nobody_comes_near_is_not_cried_about(self):
        """A film three times as thick as the roughness: no warning."""
        result = cl.simulate(cl.load_case("six_bar_feeder", model="mixed", viscosity=0.05), turns=1)
        assert result.joint("B").film_thickness_ratio.min() > 3.0
        assert not any("force hole" in w for w in result.warnings)

    @pytest.mark.parametrize("transition", ["none", "fuzzy", "load_sharing"])
    def test_restitution_survives_a_vanishing_oil(self, transition):
        """A drop through an oil of next to no viscosity bounces as in the dry joint: 3 % of the
        restitution.
        """
        law = CONTACTS["winkler"](Pair(0.01, 1e-4, 0.02, steel), 0.9)
        wet = {
            "film": laws.pinkus_sternlicht(),
            "lubricant": cl.Lubricant(1e-9),
            "roughness": 1e-7,
            "transition": TRANSITIONS[transition](dry=0.4, mixed=1.0, full=3.0),
        }
        dry, drowned = (
            cl.simulate(thrown(law, 0.5, length=0.02, **more), until=4e-4, rtol=1e-7)[
                "rod"
            ].vx.min()
            for more in ({}, wet)
        )
        assert dry == pytest.approx(-0.45, rel=1e-3)
        assert drowned == pytest.approx(dry, rel=0.03)

    @pytest.mark.parametrize(
        ("fields", "doubt"),
        [
            (
                {"contact": laws.lee_wang(stiffness=1e9, restitution=0.5)},
                "lee_wang delivers a restitution of 0.80 where 0.50",
            ),
            (
                {"friction": laws.lugre(static=0.1, kinetic=0.1, damping=1e4)},
                "bristles' damping rubs with up to 43 F_n",
            ),
            (
                {"roughness": 1.6e-5, "transition": laws.load_sharing(full=4.0)},
                "more than half of the clearance",
            ),
            ({"contact": laws.hertz(stiffness=1e10)}, "a point contact's law"),
        ],
    )
    def test_doubts(self, fields, doubt):
        """A joint states where its numbers leave what a law is meant for."""
        assert any(doubt in d for d in mixed_joint(**fields).doubts())

    def test_penetrations_beyond_a_law_are_warned_of(self):
        """Johnson's cylinder beyond its limit."""
        law = laws.johnson(modulus=1.1e11, length=0.02, radius_difference=1e-6)
        result = cl.simulate(thrown(law, 0.5, clearance=1e-6), until=1e-4)
        assert any(
            "joint J: penetrations reach" in w and "johnson is meant up to" in w
            for w in result.warnings
        )

    @pytest.mark.parametrize(("share", "warned"), [(0.04, False), (0.06, True), (0.7, True)])
    def test_penetrations_no_solid_bears(self, share, warned):
        """Stiffness for an impact as deep as a share of the radius, 1.25 m v^2 = K delta^2.5:
        warned of beyond 0.05.
        """
        law = laws.hertz(stiffness=1.25 * 2.0**2 / (share * 0.01) ** 2.5)
        result = cl.simulate(thrown(law, 2.0), until=0.04)
        message = (
            f"joint J: penetrations reach {share * 0.01:.2g} m, {share:.2g} of the journal radius"
        )
        assert [w.startswith(message) for w in result.warnings] == [True] * warned

    def test_impossible_penetrations_explain_a_broken_ledger(self):
        """A journal 34 radii outside its bearing is named; of shallow contacts the loop is
        suspected.
        """
        run = prepare(cl.load_case("slider_crank"), turns=1)
        channels = run.mechanism.layout.channels
        for gap, message in (
            (-0.34, "joint C: penetrations reach 0.34 m"),
            (-1e-5, "a loop passed a dead centre"),
        ):
            writer = Recorder(channels, Memory(channels, {}))
            writer.samples(
                np.zeros(1),
                np.array([[gap if c.path == "joints/C/gap" else 0.0 for c in channels]]),
            )
            writer.ledger.since = 0.1
            quantity = next(
                i for i, q in enumerate(run.watched.quantities) if q.name == "joints/C/gap_min"
            )
            run.state.started, run.state.peaks[quantity, VALUE] = 1, -gap
            failure = Diagnosis(run, writer).failure(codes.LEDGER_BROKEN)
            assert failure.startswith(
                f"from t = 0.1 s on: {codes.MESSAGES[codes.LEDGER_BROKEN]}: {message}"
            )

    def test_hole_check_needs_a_transition(self):
        """Without a transition model there is no hole to look for."""
        with pytest.raises(ValueError, match="joint J: a hole check needs a transition model"):
            cl.hole_check(mixed_joint(transition=None, contact=None, asperity=None), 1.0)

    def test_regime_of_the_feeder(self):
        """Feeder-A at 600 rpm: p about 12 MPa, alpha p about 0.25 (order of magnitude: a factor of
        3).
        """
        scene = cl.load_case("six_bar_feeder", speed=cl.rpm(600))
        result = cl.simulate(scene, turns=2)
        attributes = result.file["joints/B"].attrs
        assert 12e6 / 3 < attributes["film_pressure"] < 12e6 * 3
        assert 0.25 / 3 < attributes["piezoviscous_number"] < 0.6

    def test_thin_films_are_called_formal(self):
        """Flores' slider-crank at 0.04 Pa s: alpha p > 1.5 or so, flattening beyond the film."""
        result = cl.simulate(
            cl.load_case("slider_crank", model="lubricated", viscosity=0.04), turns=2
        )
        assert result.file["joints/C"].attrs["piezoviscous_number"] > 1.0
        assert any("viscosity is only formal" in w for w in result.warnings)
        assert any("rigid is only formal" in w for w in result.warnings)
