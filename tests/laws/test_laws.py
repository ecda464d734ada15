"""Every law: limits, signs, smoothness, energy, and the finite answer for every state."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import clearance as cl
from clearance import laws
from clearance.laws.contact import delivered_restitution as delivered_by
from clearance.laws.law import FilmJoint
from tests.augmented import film as textbook_film

FILM = laws.pinkus_sternlicht()
JOINT = FilmJoint(radius=0.01, clearance=1e-4, length=0.02, viscosity=0.05)
UNIT = FilmJoint(radius=1.0, clearance=1.0, length=1.0, viscosity=1.0)
rates = st.floats(-1e4, 1e4)


class TestHertz:
    @pytest.mark.parametrize(
        ("clearance", "expected"), [(5e-4, 6.610e10), (2e-4, 1.062e11), (1e-4, 1.509e11)]
    )
    def test_published_stiffness(self, clearance, expected, validated):
        """Steel, bearing radius 10 mm (models of the Flores group); 4 printed digits."""
        actual = laws.hertz_stiffness(0.01 - clearance, clearance)
        validated(
            "Hertzian stiffness of steel joints",
            actual,
            expected,
            5e-4,
            unit="N/m^1.5",
            source="Flores group",
        )

    def test_conformal_sign(self):
        """The external (plus) sign would be 6 times softer for c = 0.5 mm."""
        internal = laws.hertz_stiffness(0.0095, 0.0005)
        external = 4 / (3 * 2 * (1 - 0.09) / 207e9) * math.sqrt(0.0095 * 0.01 / 0.0195)
        assert internal / external == pytest.approx(math.sqrt(0.0195 / 0.0005), rel=1e-12)

    def test_journal_must_fit(self):
        """A joint without clearance is refused."""
        with pytest.raises(ValueError, match="clearance must be positive"):
            laws.hertz_stiffness(0.01, 0.0)


def delivered_restitution(law, mass=1.0, speed=1.0, stiffness=1e6):
    """Restitution of a free mass hitting the law, by fixed-step RK4 (1e-6 in the answer for 4000
    steps a contact).
    """
    force = law.plain(JOINT)

    def slope(x, v):
        return v, -force(x, v, speed) / mass

    x, v = 0.0, speed
    h = 2e-3 * (mass / stiffness) ** 0.4
    while True:
        k1 = slope(x, v)
        k2 = slope(x + h / 2 * k1[0], v + h / 2 * k1[1])
        k3 = slope(x + h / 2 * k2[0], v + h / 2 * k2[1])
        k4 = slope(x + h * k3[0], v + h * k3[1])
        x_new = x + h / 6 * (k1[0] + 2 * k2[0] + 2 * k3[0] + k4[0])
        v += h / 6 * (k1[1] + 2 * k2[1] + 2 * k3[1] + k4[1])
        if x_new <= 0.0 and v < 0.0:
            return -v / speed
        x = x_new


@pytest.mark.parametrize(
    "law",
    [
        laws.lankarani_nikravesh(stiffness=1e6, restitution=1.0),
        laws.hunt_crossley_memoryless(stiffness=1e6, dissipation=0.0),
    ],
)
def test_without_losses_it_is_hertz(law):
    """A full restitution, or no dissipation, leaves the elastic force: rounding."""
    assert law(0.01, -3.0, 1.0) == pytest.approx(1e6 * 0.01**1.5, rel=1e-15)


def test_grazing_impacts_stay_finite():
    """Below 1 mm/s an impact counts as one of 1 mm/s."""
    law = laws.lankarani_nikravesh(stiffness=1e10, restitution=0.5)
    assert law(1e-6, 0.1, 0.0) == law(1e-6, 0.1, 1e-3)


class TestHuntCrossley:
    @pytest.mark.parametrize("speed", [0.01, 0.1])
    def test_restitution_falls_with_the_speed(self, speed, validated):
        """e = 1 - alpha v to first order (Hunt and Crossley 1975); the closed form for chi = 1.5
        alpha v to 1e-4.
        """
        alpha = 0.3
        law = laws.hunt_crossley_memoryless(stiffness=1e6, dissipation=alpha)
        actual = delivered_restitution(law, speed=speed)
        allowed, source = (alpha * speed) ** 2 + 2e-5, "Hunt and Crossley 1975, 1 - alpha v"
        label = f"restitution at {speed:g} m/s"
        validated(label, actual, 1.0 - alpha * speed, allowed, source=source, relative=False)
        assert actual == pytest.approx(delivered_by(1.5 * alpha * speed), abs=1e-4)

    @given(st.floats(-1e-3, 1e-3), st.floats(-100, 100), st.floats(0, 100), st.floats(0, 1))
    def test_does_not_see_the_impact_speed(self, depth, rate, impact, dissipation):
        """The memoryless form has the same force whatever the speed of the first touch."""
        law = laws.hunt_crossley_memoryless(stiffness=1e10, dissipation=dissipation)
        assert law(depth, rate, impact) == law(depth, rate, 0.0)


class TestPinkusSternlicht:
    @given(st.floats(0.01, 0.99), rates.filter(lambda r: abs(r) > 1e-3), st.floats(-1e3, 1e3))
    def test_equals_the_textbook_branches(self, ratio, rate, entrainment):
        """The singularity-free form is the k-form multiplied out: 1e-9 (rounding of the k-form)."""
        e, c = ratio * JOINT.clearance, JOINT.clearance
        fr, ft = FILM(ratio, rate, entrainment, JOINT)
        fx, fy, _, _ = textbook_film(
            e, 0.0, rate * c, 0.0, entrainment, 0.0, c, JOINT.radius, JOINT.length, 0.05, 0.0
        )
        size = math.hypot(fr, ft)
        assert fr == pytest.approx(fx, abs=1e-9 * size)
        assert ft == pytest.approx(fy, abs=1e-9 * size)

    def test_receding_branch_is_continuous_in_the_rate(self):
        """With the wrong (minus) prefix the wedge part would jump to its opposite at rate 0."""
        before, after = FILM(0.5, -1e-9, 1.0, UNIT), FILM(0.5, 1e-9, 1.0, UNIT)
        assert before == pytest.approx(after, rel=1e-7)
        assert before[0] == pytest.approx(-12 * 0.25 / (2.25 * 0.75), rel=1e-6)

    def test_centred_journal_is_a_damper(self, validated):
        """-6 pi P0 eps' in every direction; the tangential speed enters through w = -2 gamma'."""
        actual = FILM(1e-7, 2.0, 0.0, UNIT)[0]
        validated(
            "force of a concentric journal, long film",
            actual,
            -12 * math.pi,
            1e-6,
            source="-6 pi P0 eps'",
            kind="exact",
        )
        swirl = 3.0 / 1e-7
        assert FILM(1e-7, 0.0, -2.0 * swirl, UNIT)[1] == pytest.approx(-6 * math.pi * 3.0, rel=1e-5)

    def test_near_the_exact_half_sommerfeld_film(self, validated):
        """Exact long pi-film, (eps, eps', w) -> (F_r, F_t): the form is within its known 9 % in
        approach.
        """
        for state, exact in (
            ((0.5, 1.0, 1.0), (-46.69790, 6.41712)),
            ((0.5, 1e-12, 1.0), (-1.777778, 4.836798)),
        ):
            actual = FILM(*state, UNIT)
            options = {"source": "exact long film, cut off at zero", "kind": "exact"}
            validated(
                "force of Pinkus and Sternlicht", complex(*actual), complex(*exact), 0.09, **options
            )

    @given(st.floats(0.0, 1.5), st.floats(-100, 100), st.floats(-1e3, 1e3), st.floats(-1e3, 1e3))
    def test_torques_balance_the_force_pair(self, ratio, tangential, journal, bearing):
        """Both torques and the moment of the force pair add to nothing: 1e-12."""
        tj, tb = laws.film_torques(ratio, tangential, journal, bearing, *JOINT[:4])
        scale = abs(tj) + abs(tb) + 1e-30
        assert tj + tb + ratio * JOINT.clearance * tangential == pytest.approx(
            0.0, abs=1e-12 * scale
        )

    def test_petroff(self, validated):
        """A concentric journal is dragged by 2 pi mu R^3 L w / c."""
        actual = laws.film_torques(0.0, 0.0, 100.0, 0.0, *JOINT[:4])
        petroff = 2 * math.pi * 0.05 * 0.01**3 * 0.02 / 1e-4 * 100.0
        validated(
            "drag torques",
            actual,
            (-petroff, petroff),
            1e-12,
            unit="N m",
            source="Petroff",
            kind="exact",
        )


class TestBinding:
    def test_wrong_parameters_are_named(self):
        """Missing and unknown parameters are in one message."""
        with pytest.raises(TypeError, match="missing restitution; unknown cor"):
            laws.lankarani_nikravesh(stiffness=1.0, cor=0.9)

    def test_values_are_checked_by_name(self):
        """A number out of range is refused with its name."""
        with pytest.raises(ValueError, match=r"restitution must lie in \[0, 1\], got 1.5"):
            laws.lankarani_nikravesh(stiffness=1.0, restitution=1.5)
        with pytest.raises(ValueError, match="stiffness must be positive"):
            laws.lankarani_nikravesh(stiffness=-1.0, restitution=0.5)

    def test_arrays(self):
        """A law of arrays has the values of its elements."""
        law = laws.coulomb(coefficient=0.1)
        speeds = np.linspace(-1, 1, 5)
        np.testing.assert_array_equal(law(speeds, 10.0), [law(v, 10.0) for v in speeds])
        radial, tangential = FILM(np.array([0.1, 0.5]), 1.0, 1.0, UNIT)
        assert (radial[1], tangential[1]) == FILM(0.5, 1.0, 1.0, UNIT)

    def test_a_law_must_have_its_familys_arguments(self):
        """Other first arguments are refused when the law is defined."""
        with pytest.raises(TypeError, match="must start with arguments"):

            @cl.contact
            def wrong(depth, speed):
                return 0.0
