"""The balance of heat of a joint's oil: Vogel's law, first law of thermodynamics, limits,
derivative, clear errors.
"""

import math
from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import clearance as cl
from clearance import laws
from clearance.elements.thermal_node import WARMING
from clearance.film.online import conserving_film, fem_film
from clearance.film.tabulated import table_film
from clearance.laws.film import thinning
from clearance.laws.law import FilmJoint
from clearance.laws.materials import HeatBalance
from clearance.mechanism.build import build
from tests import mechanisms as m
from tests.differences import jacobian_and_differences
from tests.mechanisms import journal

C, MU, SPEED, MASS = 1e-4, 0.05, 100.0, 3.0
COLD = 313.15
FIRST_LAW = {"source": "first law of thermodynamics", "kind": "exact"}


class TestVogel:
    @pytest.mark.parametrize(("celsius", "viscosity"), [(40.0, 27.6e-3), (100.0, 4.6e-3)])
    def test_mineral_oil(self, celsius, viscosity):
        """The two values of the docstring, the second within 2 %."""
        oil = HeatBalance(1.0, 1.0)
        actual = 27.6e-3 * thinning(celsius - 40.0, oil.surroundings, oil.vogel, oil.vogel_zero)
        assert actual == pytest.approx(viscosity, rel=0.02)

    @given(
        surroundings=st.floats(250.0, 400.0),
        one=st.floats(-30.0, 150.0),
        other=st.floats(-30.0, 150.0),
    )
    def test_falls_and_composes(self, surroundings, one, other):
        """Warmer is thinner; warming by one and then by another is warming by both: rounding."""
        both = thinning(one + other, surroundings, 786.0, 178.15)
        if surroundings + min(one, one + other) - 178.15 > 1.0:
            step = thinning(one, surroundings, 786.0, 178.15) * thinning(
                other, surroundings + one, 786.0, 178.15
            )
            assert both == pytest.approx(step, rel=1e-9)
        assert thinning(one + 1.0, surroundings, 786.0, 178.15) <= thinning(
            one, surroundings, 786.0, 178.15
        )

    def test_far_too_cold_is_finite(self):
        """Trial states may be; the floor is there for them."""
        assert math.isfinite(thinning(-300.0, COLD, 786.0, 178.15))


def scene(heat=None, film=None, speed=SPEED, **more):
    """The heavy journal, driven, with a balance of heat: 0.6 W."""
    options = {"film": film or table_film(), "heat": heat} | more
    return journal(mass=MASS, speed=speed, viscosity=MU, **options)


MIXED = {
    "transition": laws.load_sharing(),
    "roughness": 1e-6,
    "friction": cl.coulomb(coefficient=0.1),
    "contact": laws.winkler(layer_modulus=1e13, length=0.02, radius=0.01, radius_difference=C),
    "asperity": laws.greenwood_tripp(modulus=laws.contact_modulus(cl.steel, cl.steel)),
}
FILMS = {
    "table": table_film(),
    "pinkus_sternlicht": cl.pinkus_sternlicht(),
}


class TestState:
    @pytest.mark.parametrize("film", FILMS.values(), ids=FILMS)
    def test_one_state_more(self, film):
        """Temperature last, from rest at the surroundings, its size 10 K; without a balance nothing
        of it is left.
        """
        plain, warm = build(scene(film=film)), build(scene(HeatBalance(0.05, 0.1), film))
        assert warm.size == plain.size + 1
        assert warm.scale[-1] == WARMING
        assert warm.y0[warm.size - 1] == 0.0
        for text in plain.structure.texts.values():
            assert "thinning" not in text
            assert "heat" not in text
        assert "thinning" in warm.structure.texts["rhs"]
        assert not any("oil_temperature" in c.path for c in plain.layout.channels)

    def test_texts_without_heat_are_those_of_any_scene_without(self):
        """Building a warm scene in between changes no text of the cold one's kernels."""
        before = dict(build(scene()).structure.texts)
        build(scene(HeatBalance(0.05, 0.1)))
        assert build(scene()).structure.texts == before

    def test_numbers_are_no_structure(self):
        """Other numbers of a balance of heat share the kernels."""
        oils = HeatBalance(0.05, 0.1), HeatBalance(5.0, 0.0, surroundings=300.0)
        one, other = (build(scene(oil)) for oil in oils)
        assert one.structure is other.structure

    @pytest.mark.parametrize(
        "more", [{}, {"film_torques": False}, MIXED], ids=["film", "no drag", "mixed"]
    )
    @pytest.mark.parametrize("film", FILMS.values(), ids=FILMS)
    def test_derivative(self, film, more):
        """Of the compiled right-hand side by every state, temperature included: 1e-5 of each row
        (2e-8), central differences.
        """
        mechanism = build(scene(HeatBalance(0.05, 0.1), film, **more))
        draw = np.random.default_rng(1)
        for _ in range(3):
            y = mechanism.y0.copy()
            y[:2] = draw.uniform(-0.6, 0.6, 2) * C
            y[2:4], y[4] = draw.normal(size=2) * 2e-3, draw.uniform(-5.0, 40.0)
            actual, wanted = jacobian_and_differences(mechanism, y)
            assert (np.abs(actual - wanted).max(axis=1) < 1e-5 * np.abs(wanted).max(axis=1)).all()
            assert abs(wanted[4, 4]) > 0.0


class TestFirstLaw:
    @pytest.mark.parametrize("film", FILMS.values(), ids=FILMS)
    def test_balance(self, film, validated):
        """Integral of power less cooling is what the capacity holds: 5e-3 (2e-3, trapezoids over
        the first whirl).
        """
        oil = HeatBalance(0.05, 0.1)
        joint = cl.simulate(scene(oil, film), until=0.5, samples=501).joint("J")
        warming = joint.oil_temperature - COLD
        flow = joint.side_flow if film is FILMS["table"] else 0.0
        net = joint.power_loss - (oil.conductance + oil.volumetric * flow) * warming
        held = np.trapezoid(net, joint.time)
        validated(
            "heat the oil holds", held, oil.capacity * warming[-1], 5e-3, unit="J", **FIRST_LAW
        )
        assert warming.min() >= 0.0
        assert warming[-1] > 0.2

    def test_steady_state(self, validated):
        """After ten time constants (0.03 s with the oil that leaves): warming = power / (h + rho
        c_p Q), to 1e-6; and the film carries the weight with the viscosity of that temperature, to
        1e-3.
        """
        oil = HeatBalance(0.05, 0.1)
        result = cl.simulate(scene(oil), until=0.8, samples=81, rtol=1e-8)
        joint = result.joint("J")
        warming, flow = joint.oil_temperature[-1] - COLD, joint.side_flow[-1]
        wanted = joint.power_loss[-1] / (oil.conductance + oil.volumetric * flow)
        validated("warming of the steady oil", warming, wanted, 1e-6, unit="K", **FIRST_LAW)
        thin = MU * thinning(warming, COLD, oil.vogel, oil.vogel_zero)
        eps = math.hypot(joint.eccentricity_x[-1], joint.eccentricity_y[-1]) / C
        carried = table_film()(eps, 0.0, SPEED, FilmJoint(0.01, C, 0.02, thin))
        source = {"source": "weight of the journal", "kind": "exact"}
        load = math.hypot(*carried[:2])
        validated("force of the warm film", load, MASS * 9.81, 1e-3, unit="N", **source)
        assert thin < MU

    def test_warm_oil_carries_less(self):
        """Poor cooling: the oil warms by some kelvin, thins, and the journal sinks below where cold
        oil holds it.
        """
        oil = HeatBalance(0.01, 0.02, volumetric=0.0)
        cold, warm = (
            cl.simulate(scene(heat), until=0.6, samples=61).joint("J") for heat in (None, oil)
        )
        assert warm.oil_temperature[-1] > COLD + 5.0
        assert warm.eccentricity_ratio[-1] > 1.05 * cold.eccentricity_ratio[-1]
        assert warm.power_loss[-1] < cold.power_loss[-1]

    @pytest.mark.parametrize("more", [{}, MIXED], ids=["film", "mixed"])
    def test_adiabatic(self, more, validated):
        """Nothing leaves: C dT is the energy that the ledger states was dissipated, at all times;
        1e-6 (1e-10).
        """
        oil = HeatBalance(0.5, 0.0, volumetric=0.0)
        result = cl.simulate(scene(oil, **more), until=0.1, samples=101, rtol=1e-8)
        stored = oil.capacity * (result.joint("J").oil_temperature - COLD)
        dissipated = result.file["energy/dissipated"][:]
        size = {"unit": "J", "relative": dissipated[-1]}
        validated("heat of an adiabatic oil", stored, dissipated, 1e-6, **size, **FIRST_LAW)
        assert dissipated[-1] > 0.01
        assert result.solver["energy_residual_share"] < 1e-6

    @pytest.mark.parametrize(
        "oil",
        [HeatBalance(0.05, 1e9), HeatBalance(1e9, 0.0), HeatBalance(0.05, 0.0, volumetric=1e18)],
        ids=["conductance", "capacity", "fresh oil"],
    )
    def test_held_at_the_surroundings(self, oil):
        """Any of three infinities leaves the film of constant viscosity: 1e-6 of the clearance
        (2e-10).
        """
        plain, held = (
            cl.simulate(scene(h), until=0.05, samples=51, rtol=1e-8).joint("J") for h in (None, oil)
        )
        assert held.eccentricity_x == pytest.approx(plain.eccentricity_x, abs=1e-6 * C)
        assert held.eccentricity_y == pytest.approx(plain.eccentricity_y, abs=1e-6 * C)
        assert np.abs(held.oil_temperature - COLD).max() < 1e-4

    def test_two_joints_have_two_temperatures(self):
        """Each oil warms by its own joint's loss."""

        heat = HeatBalance(0.5, 0.0, volumetric=0.0)
        scene = m.watt(m.chooser(m.film, "BC", heat=heat))
        result = cl.simulate(scene, until=0.05, samples=51, rtol=1e-8)
        warming = [result.joint(n).oil_temperature[-1] - COLD for n in "BC"]
        dissipated = result.file["energy/dissipated"][:]
        assert 0.5 * sum(warming) == pytest.approx(dissipated[-1], rel=1e-6)
        assert warming[0] != warming[1]


def without_a_film():
    """A dry joint with a balance of heat."""
    return m.dry(cl.ground, cl.Body("journal", 1.0, 1e-3), "J", heat=HeatBalance(1.0, 1.0))


NEEDS = "joint J: heat needs a formula or a table without ambient pressure"


@pytest.mark.parametrize(
    ("refused", "line"),
    [
        *(
            (partial(HeatBalance, **{"capacity": 1.0, "conductance": 1.0} | numbers), line)
            for line, numbers in (
                ("heat balance: .*capacity", {"capacity": 0.0}),
                ("heat balance: .*capacity", {"capacity": -1.0}),
                ("heat balance: .*conductance", {"conductance": -1.0}),
                ("heat balance: .*volumetric", {"volumetric": -1.0}),
                ("heat balance: .*vogel", {"vogel": -5.0}),
                ("heat balance: .*surroundings", {"surroundings": math.nan}),
                ("heat balance: .*must be above vogel_zero", {"surroundings": 170.0}),
                ("heat balance: .*must be above vogel_zero", {"surroundings": 178.15}),
            )
        ),
        (without_a_film, "joint J: heat must be a HeatBalance.* of a joint with a film"),
        (partial(scene, heat=5.0), "joint J: heat must be a HeatBalance"),
        *(
            (partial(scene, HeatBalance(1.0, 1.0), film), NEEDS)
            for film in (table_film(ambient=1e5), fem_film(), conserving_film())
        ),
    ],
)
def test_refusals(refused, line):
    """Numbers, joints and films that no balance of heat fits are refused with one line."""
    with pytest.raises(ValueError, match=line):
        refused()
