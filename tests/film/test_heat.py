"""The balance of heat of a joint's oil: Vogel's law, first law of thermodynamics, limits,
derivative, clear errors.
"""

import math

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


def scene(heat=None, film=None, spin=SPEED, **more):
    """A heavy journal that turns at constant speed in a bearing of the ground: eccentricity about
    0.6, 0.6 W.
    """
    body = cl.Body("journal", MASS, 1e-3)
    joint = cl.ClearanceRevolute(
        cl.ground.at(0, 0),
        body.at(0, 0),
        name="J",
        radius=0.01,
        clearance=C,
        length=0.02,
        film=film or table_film(),
        lubricant=cl.Lubricant(MU),
        eccentricity=(0.2 * C, -0.3 * C),
        heat=heat,
        **more,
    )
    return cl.Scene(joint, cl.Drive(body, speed=spin))


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
        one, other = (
            build(scene(HeatBalance(0.05, 0.1))),
            build(scene(HeatBalance(5.0, 0.0, surroundings=300.0))),
        )
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
        n, scale, draw = mechanism.size, mechanism.scale, np.random.default_rng(1)

        def answer(role, y, size):
            out = np.zeros(size)
            mechanism.kernel(role)(0.0, y, mechanism.par, np.append(mechanism.work0, 0.0), out)
            return out

        for _ in range(3):
            y = mechanism.y0.copy()
            y[:2], y[2:4], y[4] = (
                draw.uniform(-0.6, 0.6, 2) * C,
                draw.normal(size=2) * 2e-3,
                draw.uniform(-5.0, 40.0),
            )
            actual = answer("jacobian", y, n * n).reshape(n, n) * scale
            wanted = np.zeros((n, n))
            for i in range(n):
                step = np.zeros(len(y))
                step[i] = 1e-5 * scale[i]
                ahead, behind = (answer("rhs", y + k * step, len(y))[:n] for k in (1.0, -1.0))
                wanted[:, i] = (ahead - behind) / 2e-5
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
        force, source = math.hypot(*carried[:2]), "weight of the journal"
        validated(
            "force of the warm film",
            force,
            MASS * 9.81,
            1e-3,
            unit="N",
            source=source,
            kind="exact",
        )
        assert thin < MU

    def test_warm_oil_carries_less(self):
        """Poor cooling: the oil warms by some kelvin, thins, and the journal sinks below where cold
        oil holds it.
        """
        cold = cl.simulate(scene(), until=0.6, samples=61).joint("J")
        warm = cl.simulate(
            scene(HeatBalance(0.01, 0.02, volumetric=0.0)), until=0.6, samples=61
        ).joint("J")
        assert warm.oil_temperature[-1] > COLD + 5.0
        assert (
            np.hypot(warm.eccentricity_x, warm.eccentricity_y)[-1]
            > 1.05 * np.hypot(cold.eccentricity_x, cold.eccentricity_y)[-1]
        )
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
        validated(
            "heat of an adiabatic oil",
            stored,
            dissipated,
            1e-6,
            unit="J",
            relative=dissipated[-1],
            **FIRST_LAW,
        )
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

        def hinge(name, a, b):
            if name not in ("B", "C"):
                return cl.Revolute(a, b, name=name)
            return cl.ClearanceRevolute(
                a,
                b,
                name=name,
                radius=0.01,
                clearance=C,
                length=0.02,
                film=cl.pinkus_sternlicht(),
                lubricant=cl.Lubricant(MU),
                heat=HeatBalance(0.5, 0.0, volumetric=0.0),
            )

        from tests import mechanisms as m

        result = cl.simulate(m.watt(hinge), until=0.05, samples=51, rtol=1e-8)
        warming = [result.joint(n).oil_temperature[-1] - COLD for n in "BC"]
        dissipated = result.file["energy/dissipated"][:]
        assert 0.5 * sum(warming) == pytest.approx(dissipated[-1], rel=1e-6)
        assert warming[0] != warming[1]


class TestErrors:
    @pytest.mark.parametrize(
        ("numbers", "line"),
        [
            ({"capacity": 0.0}, "capacity"),
            ({"capacity": -1.0}, "capacity"),
            ({"conductance": -1.0}, "conductance"),
            ({"volumetric": -1.0}, "volumetric"),
            ({"vogel": -5.0}, "vogel"),
            ({"surroundings": math.nan}, "surroundings"),
            ({"surroundings": 170.0}, "must be above vogel_zero"),
            ({"surroundings": 178.15}, "must be above vogel_zero"),
        ],
    )
    def test_numbers(self, numbers, line):
        with pytest.raises(ValueError, match=f"heat balance: .*{line}"):
            HeatBalance(**({"capacity": 1.0, "conductance": 1.0} | numbers))

    def test_needs_a_film(self):
        body = cl.Body("journal", 1.0, 1e-3)
        slots = {"name": "J", "radius": 0.01, "clearance": C, "contact": cl.hertz(stiffness=1e9)}
        with pytest.raises(
            ValueError, match="joint J: heat must be a HeatBalance.* of a joint with a film"
        ):
            cl.ClearanceRevolute(cl.ground, body, heat=HeatBalance(1.0, 1.0), **slots)

    def test_must_be_a_balance(self):
        with pytest.raises(ValueError, match="joint J: heat must be a HeatBalance"):
            scene(heat=5.0)

    @pytest.mark.parametrize(
        "film",
        [table_film(ambient=1e5), fem_film(), conserving_film()],
        ids=["ambient", "fem", "conserving"],
    )
    def test_needs_a_film_proportional_to_the_viscosity(self, film):
        with pytest.raises(
            ValueError, match="joint J: heat needs a formula or a table without ambient pressure"
        ):
            scene(HeatBalance(1.0, 1.0), film)
