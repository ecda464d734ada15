"""Shared thermal nodes: linear networks, films that follow a node, balances of energy, clear
errors.

`thermal_nodes.csv`: rows of independent small codes. "petroff" is a centred journal of 10 mm in a
bearing of 20 mm with a clearance of 0.1 mm, 0.05 Pa s at 313.15 K and 500 rad/s; "two" an oil of 2
J/K that takes 10 W, 0.8 W/K from a housing of 200 J/K and that 0.5 W/K from the surroundings.
"""

import csv
import dataclasses
import math
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import clearance as cl
from clearance.film.tabulated import table_film
from clearance.laws.materials import HeatBalance
from clearance.mechanism.build import build
from tests.film.test_heat import COLD, FIRST_LAW, MIXED, C, scene
from tests.mechanisms import film, journal
from tests.pages import block

TABLE = (Path(__file__).parent / "thermal_nodes.csv").read_text()
ROWS = {row["quantity"]: float(row["value"]) for row in csv.DictReader(TABLE.splitlines())}
INDEPENDENT = {"source": "independent code", "kind": "independent"}
# power at the surroundings' temperature [W]
PETROFF = 0.05 * 0.01**3 * 0.02 * 500.0**2 * 2.0 * math.pi / 1e-4
STILL = {"vogel": 1e-6}  # viscosity does not follow the temperature


def centred(heat, *nodes, viscosity=0.05):
    """A journal that turns in the middle of its bearing, within 1e-5 of the clearance: free it
    would whirl.
    """
    at = {"eccentricity": (0.0, 0.0), "viscosity": viscosity, "heat": heat}
    plain = journal(*nodes, mass=1.0, speed=500.0, gravity=(0.0, 0.0), **at)
    (body,) = plain.bodies
    hold = cl.SpringDamper(cl.ground.at(1e-5 * C, 0), body.at(0, 0), stiffness=1e8)
    return cl.Scene(*plain.joints, hold, *plain.loads, gravity=(0.0, 0.0))


def bath(capacity, conductance, **more):
    """A film of the temperature of its bath."""
    node = cl.ThermalNode("bath", capacity, conductance, **more)
    return centred(HeatBalance(to=node, volumetric=0.0), node)


class TestFilmFollowsTheNode:
    """Films without a state of their own: the viscosity is that of the node's temperature."""

    @pytest.mark.parametrize("conductance", [0.1, 5.0])
    def test_steady(self, conductance, validated):
        """After 20 time constants: 1e-6 K (2e-8)."""
        of = f"conductance {conductance:g} W/K"
        name, until = f"steady warming, {of}", 10.0 * ROWS[f"time constant over the capacity, {of}"]
        run = {"until": until, "samples": 11, "max_step": until / 50.0, "rtol": 1e-9}
        result = cl.simulate(bath(0.5, conductance), **run)
        joint, node = result.joint("J"), result.node("bath")
        actual = node.temperature[-1] - COLD
        validated(name, actual, ROWS[name], 1e-6, unit="K", relative=False, **INDEPENDENT)
        assert joint.oil_temperature[-1] == node.temperature[-1]
        assert node.flow[-1] == pytest.approx(joint.power_loss[-1], rel=1e-6)

    @pytest.mark.parametrize("conductance", [0.1, 5.0])
    def test_time_constant(self, conductance, validated):
        """Started 1e-3 K beside the steady state it comes back by exp(-t / tau): tau to 1e-3 (the
        slope's change).
        """
        name = f"time constant over the capacity, conductance {conductance:g} W/K"
        steady = ROWS[f"steady warming, conductance {conductance:g} W/K"]
        start, until = COLD + steady + 1e-3, 0.5 * ROWS[name]
        result = cl.simulate(
            bath(0.5, conductance, start=start), until=until, samples=2, rtol=1e-12
        )
        rest = (result.node("bath").temperature[-1] - COLD - steady) / 1e-3
        validated(name, -until / math.log(rest) / 0.5, ROWS[name], 1e-3, unit="K/W", **INDEPENDENT)

    def test_warming(self, validated):
        """Warming of 0.2 s to 1e-6 K, as by an oil with the same capacity and conductance of its
        own.
        """
        name = "warming at 0.2 s, conductance 1 W/K, capacity 0.5 J/K"
        alone = centred(HeatBalance(0.5, 1.0, volumetric=0.0))
        for warm in (bath(0.5, 1.0), alone):
            result = cl.simulate(warm, until=0.2, samples=3, rtol=1e-10)
            actual = result.joint("J").oil_temperature[-1] - COLD
            validated(name, actual, ROWS[name], 1e-6, unit="K", relative=False, **INDEPENDENT)


class TestTwoNodes:
    """An oil that heats a housing, 10 W whatever the temperature."""

    def run(self, until, **more):
        housing = cl.ThermalNode("housing", 200.0, 0.5)
        heat = HeatBalance(2.0, 0.8, volumetric=0.0, to=housing, **STILL)
        warm = centred(heat, housing, viscosity=0.05 * 10.0 / PETROFF)
        result = cl.simulate(warm, until=until, samples=3, rtol=1e-9, **more)
        oil, housing = result.joint("J").oil_temperature, result.node("housing").temperature
        return np.array([oil[-1] - COLD, housing[-1] - COLD])

    @pytest.mark.parametrize(("until", "more"), [(1, {}), (600, {"max_step": 2.0})])
    def test_warming(self, until, more, validated):
        """To 1e-6 of each (1e-8)."""
        wanted = [ROWS[f"{part} at {until} s"] for part in ("oil", "housing")]
        actual, label = self.run(until, **more), f"oil and housing at {until} s"
        validated(label, actual, wanted, 1e-6, unit="K", **INDEPENDENT)

    def test_steady(self, validated):
        """P / h over both: 32.5 K and 20 K after 8000 s, 1e-5."""
        actual = self.run(8000.0, max_step=50.0)
        wanted = [ROWS["steady warming of the oil"], 20.0]
        validated("steady oil and housing", actual, wanted, 1e-5, unit="K", **INDEPENDENT)

    def test_a_row_of_nodes_is_the_same(self):
        """The oil as a node that leads to the housing: the same warming to 1e-7."""
        housing = cl.ThermalNode("housing", 200.0, 0.5)
        oil = cl.ThermalNode("oil", 2.0, 0.8, to=housing)
        heat = HeatBalance(volumetric=0.0, to=oil, **STILL)
        scene = centred(heat, oil, housing, viscosity=0.05 * 10.0 / PETROFF)
        result = cl.simulate(scene, until=1.0, samples=3, rtol=1e-9)
        actual = [result.node(n).temperature[-1] - COLD for n in ("oil", "housing")]
        assert actual == pytest.approx([ROWS["oil at 1 s"], ROWS["housing at 1 s"]], rel=1e-6)


class TestBalance:
    """Heat is conserved."""

    def test_two_joints_heat_one_housing(self, validated):
        """Adiabatic: oils and housing hold what the ledger states was dissipated, at all times;
        1e-6 of it.
        """
        housing = cl.ThermalNode("housing", 2.0, 0.0)
        parts = [housing]
        for name, spin in (("B", 100.0), ("C", 250.0)):
            shaft = cl.Body(name, 3.0, 1e-3)
            heat = HeatBalance(0.5, 0.8, volumetric=0.0, to=housing)
            eccentricity = 0.2 * C, -0.3 * C
            bearing = film(cl.ground, shaft, name, heat=heat, eccentricity=eccentricity)
            parts += [bearing, cl.Drive(shaft, speed=spin)]
        result = cl.simulate(cl.Scene(*parts), until=0.05, samples=51, rtol=1e-8)
        oils = sum(0.5 * (result.joint(n).oil_temperature - COLD) for n in "BC")
        held = oils + 2.0 * (result.node("housing").temperature - COLD)
        lost = result.energy.dissipated
        more = FIRST_LAW | {"relative": lost[-1]}
        validated("heat of two oils and a housing", held, lost, 1e-6, unit="J", **more)
        assert result.node("housing").temperature[-1] > COLD

    @pytest.mark.slow
    def test_share(self, validated):
        """Half of the solids' heat goes past the oil: oil and housing hold all of it, 1e-6; the oil
        less.
        """
        results = []
        for share in (1.0, 0.5):
            housing = cl.ThermalNode("housing", 2.0, 0.0)
            heat = HeatBalance(0.5, 0.8, volumetric=0.0, to=housing, share=share)
            mixed = scene(film=cl.short_film(), **MIXED | {"roughness": 1.6e-5})
            joint = dataclasses.replace(mixed.joints[0], heat=heat)
            result = cl.simulate(
                cl.Scene(joint, *mixed.loads, housing), until=0.05, samples=26, rtol=1e-8
            )
            stored = 0.5 * (result.joint("J").oil_temperature - COLD)
            held = stored + 2.0 * (result.node("housing").temperature - COLD)
            lost = result.energy.dissipated
            more = FIRST_LAW | {"relative": lost[-1]}
            label = f"heat of oil and housing, share {share:g}"
            validated(label, held, lost, 1e-6, unit="J", **more)
            results.append(stored[-1])
        assert results[1] < 0.98 * results[0], results

    def test_supply(self, validated):
        """Steady: P = h (T - T_0) + rho c_p Q (T - T_f); the oil comes 15 K warmer than the
        surroundings; 1e-6.
        """
        oil = HeatBalance(0.05, 0.1, supply=COLD + 15.0)
        joint = cl.simulate(scene(oil, table_film()), until=0.8, samples=5, rtol=1e-8).joint("J")
        flow = oil.volumetric * joint.side_flow[-1]
        wanted = (joint.power_loss[-1] + flow * 15.0) / (oil.conductance + flow)
        actual = joint.oil_temperature[-1] - COLD
        validated("warming by warm oil", actual, wanted, 1e-6, unit="K", **FIRST_LAW)
        assert actual > 14.0


class TestStructure:
    def test_scenes_without_nodes_have_nothing_of_them(self):
        """A node that no joint heats changes no force: only its own state and outputs are added."""
        plain, idle = build(scene(HeatBalance(0.05, 0.1))), scene(HeatBalance(0.05, 0.1))
        idle = build(cl.Scene(*idle.joints, *idle.loads, cl.ThermalNode("sump", 5.0, 1.0)))
        assert idle.size == plain.size + 1
        assert [c.path for c in idle.layout.channels if "nodes" in c.path] == [
            "nodes/sump/temperature",
            "nodes/sump/flow",
        ]
        assert not any("node" in text for text in plain.structure.texts.values())

    def test_which_node_is_structure(self):
        """Two joints of one kind that heat another node each are another structure; other numbers
        are not.
        """

        def built(first, capacity=5.0):
            nodes = [cl.ThermalNode(n, capacity, 1.0) for n in ("one", "two")]
            return build(centred(HeatBalance(2.0, 0.8, to=nodes[first]), *nodes)).structure

        assert built(0) is not built(1)
        assert built(0) is built(0, 7.0)

    def test_start(self):
        """A node starts at the temperature given, an oil without a state of its own with it."""
        node = cl.ThermalNode("bath", 5.0, 1.0, start=350.0)
        result = cl.simulate(centred(HeatBalance(to=node), node), until=1e-3, samples=2)
        assert result.joint("J").oil_temperature[0] == 350.0


def test_guide():
    """The guide's example, shorter: heat goes from both oils to the housing."""
    scope: dict = {}
    exec(block("cl.ThermalNode(").replace("turns=2", "turns=0.1"), scope)
    run = scope["run"]
    warming = [run.joint(n).oil_temperature[-1] - COLD for n in "AD"]
    assert 0.0 < run.node("housing").temperature[-1] - COLD < min(warming)


HOUSING = cl.ThermalNode("housing", 200.0, 0.5)
HEAT = HeatBalance(1.0, 1.0, to=HOUSING)


@pytest.mark.parametrize(
    ("refused", "line"),
    [
        *(
            (
                partial(cl.ThermalNode, "sump", **{"capacity": 1.0, "conductance": 1.0} | numbers),
                f"ThermalNode sump: {line}",
            )
            for line, numbers in (
                ("capacity must be positive, got 0.0", {"capacity": 0.0}),
                ("conductance must not be negative", {"conductance": -1.0}),
                ("surroundings must be positive", {"surroundings": -5.0}),
                ("start must be positive", {"start": 0.0}),
                ("surroundings beside to=housing", {"surroundings": 300.0, "to": HOUSING}),
                ("to must be a ThermalNode", {"to": "housing"}),
            )
        ),
        *(
            (partial(HeatBalance, **numbers), f"heat balance: {line}")
            for line, numbers in (
                ("capacity is missing", {}),
                ("conductance is missing", {"capacity": 1.0}),
                ("conductance is missing", {"capacity": 1.0, "to": HOUSING}),
                ("share must lie in", {"share": 1.5, "to": HOUSING}),
                ("supply must be positive", {"supply": -3.0, "to": HOUSING}),
            )
        ),
        (
            lambda: centred(HeatBalance(1.0, 1.0, to="housing")),
            "joint J: heat balance: to must be a ThermalNode",
        ),
        (
            partial(centred, HEAT),
            "joint J: its thermal node, ThermalNode housing, is not in the scene",
        ),
    ],
)
def test_refusals(refused, line):
    """Numbers of nodes and balances, and nodes that a scene lacks, in one line."""
    with pytest.raises((ValueError, TypeError), match=line):
        refused()


def test_a_node_that_changes_stays_that_of_its_films():
    """The balance of heat of a joint follows to the node with the other number."""
    scene = bath(0.5, 1.0).replaced({"nodes/bath/capacity": 0.7})
    (node,) = (load for load in scene.loads if isinstance(load, cl.ThermalNode))
    assert node.capacity == 0.7
    assert scene.joints[0].heat.to is node
