"""Friction laws of joints without clearance, and the geometry that makes a load of a reaction."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import clearance as cl
from clearance.laws.joint_friction import (
    breakaway_linear,
    breakaway_smooth,
    joint_coulomb,
    joint_stribeck,
    pin_load,
    slide_load,
)

LEGACY = breakaway_linear(breakaway=25.0, coulomb=20.0, viscous=1e-3, decay=10.0, threshold=1e-4)
SMOOTH = breakaway_smooth(breakaway=25.0, coulomb=20.0, breakaway_rate=0.1)

rates = st.floats(-1e3, 1e3)
loads = st.floats(0.0, 1e5)
numbers = st.floats(0.0, 1e3)
small = st.floats(1e-6, 10.0)
levels = st.tuples(numbers, numbers).map(sorted)  # the lower one first

coulombs = st.builds(
    lambda *n: joint_coulomb(
        coefficient=n[0], viscous=n[1], load_viscous=n[2], transition_rate=n[3]
    ),
    numbers,
    numbers,
    numbers,
    st.just(0.0) | small,
)
stribecks = st.builds(
    lambda mu, w, d, v, lv, tr: joint_stribeck(
        kinetic=mu[0],
        static=mu[1],
        stribeck_rate=w,
        exponent=d,
        viscous=v,
        load_viscous=lv,
        transition_rate=tr,
    ),
    levels,
    small,
    st.floats(1.0, 4.0),
    numbers,
    numbers,
    st.just(0.0) | small,
)
linears = st.builds(
    lambda f, v, c, w: breakaway_linear(
        coulomb=f[0], breakaway=f[1], viscous=v, decay=c, threshold=w
    ),
    levels,
    numbers,
    numbers,
    small,
)
smooths = st.builds(
    lambda f, v, w: breakaway_smooth(coulomb=f[0], breakaway=f[1], viscous=v, breakaway_rate=w),
    levels,
    numbers,
    small,
)
any_law = coulombs | stribecks | linears | smooths


class TestAllLaws:
    @given(any_law, rates, loads)
    def test_odd(self, law, rate, load):
        """Friction of the opposite rate has the opposite sign."""
        assert law(-rate, load) == -law(rate, load)

    @given(any_law, rates, loads)
    def test_never_pushes(self, law, rate, load):
        """Finite, and against the rate: the power put in is not positive."""
        friction = law(rate, load)
        assert math.isfinite(friction)
        assert friction * rate <= 0.0

    @given(any_law, loads)
    def test_nothing_at_rest(self, law, load):
        """No rate, no friction."""
        assert law(0.0, load) == 0.0

    @given(linears | smooths, rates, loads)
    def test_breakaway_laws_know_no_load(self, law, rate, load):
        """Levels stated in newtons do not depend on the load."""
        assert law(rate, load) == law(rate, 0.0)

    @given(st.one_of(coulombs, stribecks), rates)
    def test_others_have_only_their_viscous_part_without_load(self, law, rate):
        """Without load Coulomb's and Stribeck's parts vanish."""
        assert law(rate, 0.0) == -law.values["viscous"] * rate

    @pytest.mark.parametrize("law", [LEGACY, SMOOTH, joint_coulomb(coefficient=0.1)])
    def test_arrays(self, law):
        """A law of arrays has the values of its elements."""
        some = np.linspace(-1.0, 1.0, 5)
        np.testing.assert_array_equal(law(some, 10.0), [law(w, 10.0) for w in some])
        np.testing.assert_array_equal(law(some, some**2), [law(w, w**2) for w in some])


class TestCoulomb:
    def test_value(self):
        """mu Q + c w + c_Q Q w = 0.1 * 50 + 2 * 3 + 0.01 * 50 * 3."""
        law = joint_coulomb(coefficient=0.1, viscous=2.0, load_viscous=0.01)
        assert law(3.0, 50.0) == pytest.approx(-12.5, rel=1e-15)

    def test_transition(self):
        """tanh: its value at the transition rate, all of Coulomb's from twenty times that on (1 -
        e^-40).
        """
        law = joint_coulomb(coefficient=0.1, transition_rate=0.02)
        assert law(0.02, 50.0) == pytest.approx(-5.0 * math.tanh(1.0), rel=1e-15)
        assert law(1e-9, 50.0) == pytest.approx(-5.0 * 1e-9 / 0.02, rel=1e-12)
        assert law(-0.4, 50.0) == pytest.approx(5.0, rel=1e-15)

    @pytest.mark.parametrize("rate", [1e-13, 1e-9, 1.0])
    def test_sign_stands_at_rest_without_a_transition(self, rate):
        """Any rate above rounding has all of Coulomb's friction."""
        assert joint_coulomb(coefficient=0.1)(rate, 50.0) == -5.0
        assert joint_coulomb(coefficient=0.1)(1e-15, 50.0) == 0.0  # rounding has no sign


class TestStribeck:
    @pytest.mark.parametrize(("exponent", "twice"), [(1.0, math.exp(-2.0)), (2.0, math.exp(-4.0))])
    def test_fall(self, exponent, twice):
        """1/e of the difference is left at the Stribeck rate; e^-2 (Tustin) or e^-4 (Gauss) at
        twice that.
        """
        law = joint_stribeck(static=0.2, kinetic=0.05, stribeck_rate=0.1, exponent=exponent)
        assert law(0.1, 100.0) == pytest.approx(-100.0 * (0.05 + 0.15 / math.e), rel=1e-14)
        assert law(0.2, 100.0) == pytest.approx(-100.0 * (0.05 + 0.15 * twice), rel=1e-14)
        assert law(1e-12, 100.0) == pytest.approx(-20.0, rel=1e-10)
        assert law(50.0, 100.0) == pytest.approx(-5.0, rel=1e-14)

    @given(numbers, rates, loads, small, st.floats(1.0, 4.0), numbers)
    def test_equal_coefficients_are_coulombs(
        self, mu, rate, load, stribeck_rate, exponent, viscous
    ):
        """Without a difference of levels Stribeck's law is Coulomb's."""
        law = joint_stribeck(
            static=mu, kinetic=mu, stribeck_rate=stribeck_rate, exponent=exponent, viscous=viscous
        )
        assert law(rate, load) == joint_coulomb(coefficient=mu, viscous=viscous)(rate, load)

    @given(stribecks, rates, loads)
    def test_between_kinetic_and_static(self, law, rate, load):
        """1e-9: rounding of the two sums, whose terms differ by up to 1e6."""
        shared = {n: law.values[n] for n in ("viscous", "load_viscous", "transition_rate")}
        bounds = [
            joint_coulomb(coefficient=law.values[n], **shared)(rate, load)
            for n in ("kinetic", "static")
        ]
        margin = 1e-9 * abs(bounds[1])
        assert min(bounds) - margin <= law(rate, load) <= max(bounds) + margin


class TestBreakaway:
    def test_printed_value_at_the_threshold(self, validated):
        """20 + 5 exp(-10 * 1e-4), printed as 24.995; the decay coefficients 100 and 0.001 would
        give others.
        """
        law = breakaway_linear(breakaway=25.0, coulomb=20.0)
        actual, options = -law(1e-4, 0.0), {"unit": "N m", "relative": False}
        validated(
            "friction at the threshold",
            actual,
            24.995,
            5e-4,
            source="Chacko and Khan 2017",
            **options,
        )
        validated(
            "friction at the threshold",
            actual,
            24.9950025,
            5e-8,
            source="closed form",
            kind="exact",
            **options,
        )
        for decay, printed in ((100.0, 24.95), (0.001, 25.0)):
            assert (
                round(-breakaway_linear(breakaway=25.0, coulomb=20.0, decay=decay)(1e-4, 0.0), 3)
                == printed
            )

    @given(linears)
    def test_continuous_at_the_threshold(self, law):
        """Both sides of one ulp, to the change that the slopes allow; 1e-12 of the value for
        rounding.
        """
        at = law.values["threshold"]
        below, above = law(math.nextafter(at, 0.0), 0.0), law(math.nextafter(at, 2.0 * at), 0.0)
        assert below == pytest.approx(above, rel=1e-12)

    def test_straight_below_the_threshold(self):
        """A quarter of the threshold has a quarter of the friction."""
        assert LEGACY(0.25e-4, 0.0) == pytest.approx(0.25 * LEGACY(1e-4, 0.0), rel=1e-14)

    @pytest.mark.parametrize("rate", [5.0, -20.0, 300.0])
    def test_far_limit(self, rate):
        """f w + F_C: exp(-10 * 5) of the difference is left, below 1e-20 of it."""
        expected = -(20.0 * math.copysign(1.0, rate) + 1e-3 * rate)
        assert LEGACY(rate, 0.0) == pytest.approx(expected, rel=1e-12)
        assert breakaway_smooth(breakaway=25.0, coulomb=20.0, viscous=1e-3)(
            rate, 0.0
        ) == pytest.approx(expected)

    def test_smooth_form_peaks_at_the_breakaway_rate(self, validated):
        """Without viscosity the largest friction is the breakaway level, at the breakaway rate.

        What is missing is F_C (1 - tanh 10) = 8e-8 N; that term's slope there, 200 F_C e^-20 / w_b,
        moves the peak by 1e-7 of w_b. The scan is 1e-4 of w_b fine.
        """
        some = np.linspace(1e-5, 1.0, 100_000)
        actual = -SMOOTH(some, 0.0)
        options = {"source": "breakaway level and rate given", "kind": "exact", "relative": False}
        validated("peak of the smooth friction", actual.max(), 25.0, 1e-7, unit="N m", **options)
        validated("rate of that peak", some[np.argmax(actual)], 0.1, 2e-5, unit="rad/s", **options)

    def test_smooth_form_has_a_slope_at_rest(self, validated):
        """sqrt(2 e) (F_b - F_C) / w_S + F_C / w_C with w_S = sqrt(2) w_b and w_C = w_b / 10."""
        slope = math.sqrt(2.0 * math.e) * 5.0 / (math.sqrt(2.0) * 0.1) + 20.0 / 0.01
        actual = -SMOOTH(1e-9, 0.0) / 1e-9
        validated(
            "slope of the smooth friction at rest",
            actual,
            slope,
            1e-9,
            unit="N m s/rad",
            source="closed form",
            kind="exact",
        )


class TestLoads:
    def test_pin(self):
        """0.02 * |(3, 4)| + 0.03 * 10 + 0.4 * |(0.6, 0.8)|."""
        assert pin_load(3.0, 4.0, -10.0, 0.6, 0.8, 0.02, 0.03, 0.4) == pytest.approx(0.8, rel=1e-15)

    def test_slide(self):
        """|(3, 4)| + |(6, 8)| / (0.05 / 2) + |-2| / 0.02."""
        actual = slide_load(3.0, 4.0, -2.0, 6.0, 8.0, 1.0 / 0.02, 1.0 / 0.05)
        assert actual == pytest.approx(505.0, rel=1e-14)

    def test_joints_give_their_geometry(self):
        """Ratio R_p / R_b and the inverses of overlap and arm, as the load functions take them."""
        body = cl.Body("arm", 1.0, 1.0)
        pin = cl.Revolute(cl.ground, body, pin_radius=0.02, friction_arm=0.03, bending_arm=0.05)
        assert pin_load(3.0, 4.0, -10.0, 0.6, 0.8, **pin.geometry) == pytest.approx(0.8, rel=1e-15)
        slide = cl.Prismatic(cl.ground, body, overlap=0.05, friction_arm=0.02)
        assert slide_load(3.0, 4.0, -2.0, 6.0, 8.0, **slide.geometry) == pytest.approx(
            505.0, rel=1e-14
        )

    def test_nothing_makes_nothing(self):
        """Without reaction there is no load."""
        assert pin_load(*[0.0] * 5, 0.02, 0.03, 0.4) == 0.0
        assert slide_load(*[0.0] * 5, 50.0, 20.0) == 0.0

    @given(
        st.lists(st.floats(-1e4, 1e4), min_size=5, max_size=5),
        st.floats(1e-3, 1e3),
        st.floats(-3.0, 3.0),
    )
    def test_grow_with_the_reaction_and_have_no_direction_of_their_own(
        self, reaction, factor, turn
    ):
        """Homogeneous of degree one, and the same for a turned radial force; 1e-12 of the load for
        rounding.
        """
        load = pin_load(*reaction, 0.02, 0.03, 0.4)
        assert load >= 0.0
        assert pin_load(*(factor * r for r in reaction), 0.02, 0.03, 0.4) == pytest.approx(
            factor * load, rel=1e-12
        )
        x, y, *others = reaction
        c, s = math.cos(turn), math.sin(turn)
        turned = pin_load(c * x - s * y, s * x + c * y, *others, 0.02, 0.03, 0.4)
        assert turned == pytest.approx(load, rel=1e-12, abs=1e-200)


class TestRefusals:
    @pytest.mark.parametrize(
        ("law", "numbers", "message"),
        [
            (
                joint_coulomb,
                {"coefficient": -0.1},
                "joint_coulomb: coefficient must not be negative, got -0.1",
            ),
            (joint_coulomb, {"coefficient": 0.1, "viscous": -1.0}, "viscous must not be negative"),
            (
                joint_coulomb,
                {"coefficient": 0.1, "transition_rate": -1.0},
                "transition_rate must not be negative",
            ),
            (
                joint_stribeck,
                {"static": -1.0, "kinetic": 0.1, "stribeck_rate": 1.0},
                "static must not be negative",
            ),
            (
                joint_stribeck,
                {"static": 0.2, "kinetic": 0.1, "stribeck_rate": 0.0},
                "stribeck_rate must be positive",
            ),
            (
                joint_stribeck,
                {"static": 0.2, "kinetic": 0.1, "stribeck_rate": 1.0, "exponent": 0.5},
                "joint_stribeck: exponent must be at least 1, got 0.5",
            ),
            (
                breakaway_linear,
                {"breakaway": 2.0, "coulomb": 1.0, "threshold": 0.0},
                "threshold must be positive",
            ),
            (
                breakaway_smooth,
                {"breakaway": 2.0, "coulomb": 1.0, "breakaway_rate": 0.0},
                "breakaway_rate must be pos",
            ),
        ],
    )
    def test_numbers(self, law, numbers, message):
        """Numbers out of range are refused with law and name."""
        with pytest.raises(ValueError, match=message):
            law(**numbers)

    @pytest.mark.parametrize(
        ("kind", "more", "message"),
        [
            (
                cl.Revolute,
                {"friction": joint_coulomb(coefficient=0.1)},
                r"joint J: friction joint_coulomb is made by the reaction and needs pin_radius "
                r"\[m\]",
            ),
            (
                cl.Prismatic,
                {"friction": joint_coulomb(coefficient=0.1)},
                r"joint J: friction joint_coulomb is made by the reaction and needs overlap \[m\]",
            ),
            (
                cl.Revolute,
                {
                    "friction": joint_stribeck(static=0.1, kinetic=0.2, stribeck_rate=1.0),
                    "pin_radius": 0.01,
                },
                "joint J: friction joint_stribeck needs static >= kinetic, got 0.1 and 0.2",
            ),
            (
                cl.Revolute,
                {"friction": breakaway_linear(breakaway=1.0, coulomb=2.0)},
                "joint J: friction breakaway_linear needs breakaway >= coulomb, got 1 and 2",
            ),
            (
                cl.Prismatic,
                {"friction": breakaway_smooth(breakaway=1.0, coulomb=2.0)},
                "joint J: friction breakaway_smooth needs breakaway >= coulomb, got 1 and 2",
            ),
            (cl.Revolute, {"pin_radius": 0.0}, "joint J: pin_radius must be positive, got 0.0"),
            (cl.Revolute, {"bending_arm": -1.0}, "joint J: bending_arm must be positive, got -1.0"),
            (cl.Prismatic, {"overlap": float("nan")}, "joint J: overlap must be finite, got nan"),
            (
                cl.Revolute,
                {"friction": cl.coulomb(coefficient=0.1)},
                "joint J: friction must be a joint_friction law",
            ),
            (
                cl.Revolute,
                {"friction": joint_coulomb},
                "joint J: friction: give joint_coulomb its parameters",
            ),
        ],
    )
    def test_joints(self, kind, more, message):
        """A joint refuses a law that it has no geometry for."""
        with pytest.raises((ValueError, TypeError), match=message):
            kind(cl.ground, cl.Body("arm", 1.0, 1.0), name="J", **more)

    @pytest.mark.parametrize("kind", [cl.Revolute, cl.Prismatic])
    def test_laws_without_load_need_no_geometry(self, kind):
        """A breakaway law needs no radius and no overlap."""
        joint = kind(cl.ground, cl.Body("arm", 1.0, 1.0), friction=LEGACY)
        assert not joint.rubs_by_load
        assert joint.friction is LEGACY

    def test_smoothness_is_known(self):
        """Inputs of a motion that follows from forces."""
        for law, smooth in (
            (joint_coulomb(coefficient=0.1), False),
            (joint_coulomb(coefficient=0.1, transition_rate=0.1), True),
            (joint_stribeck(static=0.2, kinetic=0.1, stribeck_rate=1.0), False),
        ):
            assert law.law.smooth(law.values) is smooth
