"""The energy ledger by parts: what each clearance joint and each damper has taken out, and which
parts there are.
"""

import numpy as np
import pytest

import clearance as cl
from clearance.mechanism.build import build
from clearance.run.diagnosis import doubtful
from clearance.studies.explain import explain
from tests import mechanisms as m
from tests.seeds import few_of

C = 1e-4
FEEDER = {
    "lubricated": {"film": "pinkus_sternlicht"},
    "dry": {"model": "dry"},
    "mixed": {"model": "mixed", "viscosity": 0.05, "transition": "load_sharing"},
}


def feeder(kind, joints="B,C"):
    return cl.load_case("six_bar_feeder", joints=joints, **FEEDER[kind])


def parts(result):
    """Dissipated energy along time by the path of its part."""
    groups = [f"{kind}/{name}" for kind in ("joints", "springs") for name in result.names(kind)]
    return {g: result.values(f"{g}/dissipated") for g in groups if f"{g}/dissipated" in result}


def kinetic(result, body):
    ours = next(b for b in result.scene["bodies"] if b["name"] == body)
    x, y, turning = result[body].vx, result[body].vy, result[body].omega
    return 0.5 * ours["mass"] * (x**2 + y**2) + 0.5 * ours["inertia"] * turning**2


def bouncy(restitution):
    # contacts last about 50 us
    return cl.lankarani_nikravesh(stiffness=1e12, restitution=restitution)


def hard(a, b, name, clearance, law=None, **more):
    law = law or bouncy(0.7)
    return cl.ClearanceRevolute(
        a, b, name=name, radius=0.01, clearance=clearance, contact=law, **more
    )


def free(name, joint=hard, x=0.0, velocity=(0.3, 0.1), spin=0.0, mass=0.5, **more):
    """A clearance joint that holds a body to ground; the body is free otherwise."""
    ball = cl.Body(name, mass, 1e-4, position=(x, 0.0), velocity=velocity, angular_velocity=spin)
    return joint(cl.ground.at(x, 0.0), ball, name, C, eccentricity_rate=velocity, **more)


def hinged(name, spin, inertia=2e-3, x=0.0):
    wheel = cl.Body(name, 1.0, inertia, position=(x, 0.0), angular_velocity=spin)
    return wheel, cl.Revolute(cl.ground.at(x, 0.0), wheel, name=name)


def steered(damping=(0.4, 0.02), crank_speed=3.0, elbow_speed=-5.0):
    """An arm whose motion is prescribed altogether: no degree of freedom, only the ledger is
    integrated.
    """
    upper = m.body("upper", {"S": (0, 0), "E": (0.3, 0)}, com=(0.15, 0))
    fore = m.body("fore", {"E": (0, 0), "H": (0.25, 0)}, com=(0.1, 0.01))
    elbow = cl.Revolute(upper["E"], fore["E"], name="E")
    return cl.Scene(
        cl.Revolute(cl.ground, upper["S"], name="S"),
        elbow,
        cl.Drive(upper, speed=crank_speed, name="shoulder"),
        cl.Drive(elbow, speed=elbow_speed, name="elbow"),
        cl.SpringDamper(
            cl.ground.at(0.4, 0.9), fore["H"], stiffness=50.0, damping=damping[0], name="strut"
        ),
        cl.TorsionSpring(upper, fore, stiffness=2.0, damping=damping[1], name="twist"),
    )


SCENES = {
    "lubricated": (lambda: feeder("lubricated"), {"until": 0.02}, {"joints/B", "joints/C"}),
    "dry": (lambda: feeder("dry"), {"until": 0.02}, {"joints/B", "joints/C"}),
    "mixed": (lambda: feeder("mixed"), {"until": 0.005}, {"joints/B", "joints/C"}),
    "steered": (steered, {"until": 1.0}, {"springs/strut", "springs/twist"}),
}


@pytest.mark.parametrize("name", SCENES)
def test_parts_add_up_to_the_total(name):
    """To the rounding of a sum, a few ulp of the largest part; and with the total the residual
    stays what it was.
    """
    make, span, expected = SCENES[name]
    result = cl.simulate(make(), rtol=1e-8, **span)
    actual = parts(result)
    assert set(actual) == expected
    largest = max(np.abs(p).max() for p in actual.values())
    np.testing.assert_allclose(
        sum(actual.values()), result.energy.dissipated, rtol=0.0, atol=1e-15 * largest
    )
    assert all(abs(p[-1]) > 1e-3 * largest for p in actual.values())
    assert result.solver["energy_residual_share"] < 1e-6


@pytest.mark.parametrize("method", few_of(["radau5", "rodas5p", "radau9"], 1))
def test_a_film_takes_out_the_integral_of_its_power_loss(method):
    """Once the journals have risen from the middle (an eighth of a turn) the trapezoidal rule is
    off by h^2: a quarter for half the distance of samples. What it tends to is what the ledger has,
    to ten times rtol of the joint's energy (measured: a tenth of rtol). Over the complete span the
    journals' rise leaves the rule off by 2e-8 of it.
    """
    result = cl.simulate(feeder("lubricated"), turns=0.5, rtol=1e-10, samples=8193, method=method)
    for name in "BC":
        joint = result.joint(name)
        power, taken = joint.power_loss[2048:], joint.dissipated[-1] - joint.dissipated[2048]
        rule = [np.trapezoid(power[::k], result.time[2048::k]) for k in (4, 2, 1)]
        assert (rule[0] - taken) / (rule[1] - taken) == pytest.approx(4.0, rel=0.05)
        assert (rule[1] - taken) / (rule[2] - taken) == pytest.approx(4.0, rel=0.05)
        assert rule[2] + (rule[2] - rule[1]) / 3.0 == pytest.approx(taken, rel=1e-9)
        assert np.trapezoid(joint.power_loss, result.time) == pytest.approx(
            joint.dissipated[-1], rel=1e-7
        )


@pytest.mark.parametrize("method", few_of(["radau5", "dop853", "rodas5p", "radau9"], 2))
@pytest.mark.parametrize("kind", ["mixed", "dry"])
def test_each_part_is_as_accurate_as_the_run(kind, method):
    """Thirty times rtol of the energy of both joints, at rtol 1e-7 (measured: up to nine times),
    over the first
    contacts: later the trajectories of a dry joint part.
    """
    span = {"until": 0.004, "samples": 201}
    reference = parts(cl.simulate(feeder(kind), rtol=1e-12, method="radau9", **span))
    actual = parts(cl.simulate(feeder(kind), rtol=1e-7, method=method, **span))
    energy = sum(abs(p).max() for p in reference.values())
    for path, expected in reference.items():
        np.testing.assert_allclose(
            actual[path], expected, rtol=0.0, atol=3e-6 * energy, err_msg=path
        )


@pytest.mark.parametrize(
    "friction", [None, cl.coulomb_tanh(coefficient=0.2, transition_speed=1e-2)]
)
def test_two_dry_joints_each_take_out_what_their_own_body_loses(friction):
    """Two bodies bounce in bearings of their own, without gravity. In flight each joint has taken
    out the kinetic energy of its own body that is gone, 1e-8 at rtol 1e-10. In flight it takes out
    nothing.
    """
    scene = cl.Scene(
        free("hard", velocity=(0.3, 0.1), spin=40.0, law=bouncy(0.9), friction=friction),
        free(
            "soft",
            velocity=(-0.2, 0.3),
            spin=-90.0,
            x=0.2,
            mass=0.2,
            law=bouncy(0.5),
            friction=friction,
        ),
        gravity=(0.0, 0.0),
    )
    result = cl.simulate(scene, until=5e-3, rtol=1e-10, samples=4001)
    time, events = result.time, result.events
    for name in ("hard", "soft"):
        joint, energy, ours = result.joint(name), kinetic(result, name), events["joint"] == name
        flying = joint.contact_force == 0.0
        lost = energy[0] - energy
        np.testing.assert_allclose(
            joint.dissipated[flying], lost[flying], rtol=0, atol=1e-8 * energy[0]
        )
        assert joint.dissipated[-1] > 0.02 * energy[0]
        starts, ends = events["time"][ours], (events["time"] + events["duration"])[ours]
        flights = [
            joint.dissipated[(time > a) & (time < b)]
            for a, b in zip(ends, starts[1:], strict=False)
        ]
        assert len(flights) > 2
        assert all(np.ptp(flight) == 0.0 for flight in flights if flight.size)


def test_an_impact_takes_out_what_its_speeds_say():
    """Straight at the wall: m (v1^2 - v2^2) / 2 with both speeds of the impact table, 1e-8 at rtol
    1e-10. One impact between two samples: the ledger has all of it, the sampled power loss nothing.
    """
    scene = cl.Scene(free("ball", velocity=(0.25, 0.0)), gravity=(0.0, 0.0))
    result = cl.simulate(scene, until=8e-4, rtol=1e-10, samples=3)
    (before,), (after,) = result.events["impact_speed"], result.events["separation_speed"]
    joint = result.joint("ball")
    assert before == pytest.approx(0.25, rel=1e-12)
    assert not joint.power_loss.any()
    assert joint.dissipated.tolist()[:1] == [0.0]
    assert joint.dissipated[-1] == pytest.approx(0.25 * (before**2 - after**2), rel=1e-8)
    assert after < 0.85 * before


def test_a_contact_without_loss_gives_all_of_it_back():
    """Hertz: stored while it touches, given back at the end; 1e-8 of the kinetic energy at rtol
    1e-10.
    """
    scene = cl.Scene(free("ball", law=cl.hertz(stiffness=1e12)), gravity=(0.0, 0.0))
    result = cl.simulate(scene, until=2e-3, rtol=1e-10, samples=2001)
    energy, taken = kinetic(result, "ball"), result.joint("ball").dissipated
    touching = result.joint("ball").contact_force > 0.0
    assert taken[touching].max() > 0.5 * energy[0]
    assert np.abs(taken[~touching]).max() < 1e-8 * energy[0]
    assert len(result.events["time"]) == 3


def test_film_and_contact_side_by_side():
    """Beside a body that bounces another stops in oil: at all times the film has what its body
    lost; 1e-8.
    """
    scene = cl.Scene(
        free("wet", joint=m.film, velocity=(0.02, 0.01), spin=30.0),
        free("ball", x=0.2, velocity=(0.2, 0.0)),
        gravity=(0.0, 0.0),
    )
    result = cl.simulate(scene, until=5e-3, rtol=1e-10, samples=501)
    energy = kinetic(result, "wet")
    np.testing.assert_allclose(
        result.joint("wet").dissipated, energy[0] - energy, rtol=0.0, atol=1e-8 * energy[0]
    )
    assert kinetic(result, "ball")[-1] < 0.9 * kinetic(result, "ball")[0]
    assert energy[-1] < 0.995 * energy[0]


def test_dampers_take_out_what_theory_says():
    """Two wheels run down against torsion dampers, a slide against a damper with a spring. The
    wheels' energies decay by exp(-2 d t / I). The slide's loss is what is missing of kinetic and
    spring energy; 1e-9 at rtol 1e-10.
    """
    (fast, hinge), (slow, other) = hinged("fast", 30.0), hinged("slow", 7.0, 5e-3, 0.3)
    block = cl.Body("block", 0.4, 1e-4, position=(0.0, 1.0), velocity=(2.0, 0.0))
    scene = cl.Scene(
        hinge,
        other,
        cl.Prismatic(cl.ground.at(0.0, 1.0), block, name="slide"),
        cl.TorsionSpring(cl.ground, fast, damping=3e-3, name="brake"),
        cl.TorsionSpring(slow, cl.ground, damping=1e-3, name="drag"),
        cl.SpringDamper(
            cl.ground.at(-0.5, 1.0),
            block,
            stiffness=30.0,
            damping=0.8,
            free_length=0.4,
            name="strut",
        ),
        cl.SpringDamper(
            cl.ground.at(0.9, 1.0), block, stiffness=10.0, free_length=0.4, name="spring"
        ),
        gravity=(0.0, 0.0),
    )
    result = cl.simulate(scene, until=1.0, rtol=1e-10)
    actual, t = parts(result), result.time
    assert set(actual) == {"springs/brake", "springs/drag", "springs/strut"}
    for path, spin, inertia, damping in (
        ("springs/brake", 30.0, 2e-3, 3e-3),
        ("springs/drag", 7.0, 5e-3, 1e-3),
    ):
        lost = -0.5 * inertia * spin**2 * np.expm1(-2.0 * damping * t / inertia)
        np.testing.assert_allclose(actual[path], lost, rtol=0.0, atol=1e-9 * lost[-1])
    lengths = {n: result.values(f"springs/{n}/length") for n in ("strut", "spring")}
    energy = (
        kinetic(result, "block")
        + 15.0 * (lengths["strut"] - 0.4) ** 2
        + 5.0 * (lengths["spring"] - 0.4) ** 2
    )
    np.testing.assert_allclose(
        actual["springs/strut"], energy[0] - energy, rtol=0.0, atol=1e-9 * energy[0]
    )
    assert actual["springs/strut"][-1] > 0.3 * energy[0]


def test_dampers_of_a_prescribed_motion_are_integrated_to_tolerance():
    """No degree of freedom: the ledger alone sets the steps.

    The torsion damper turns at constant speed: d w^2 t, and
    the strut is as near to a tight run as six steps and rtol 1e-6 of the energy scale, about 1 J,
    let it be.
    """
    result = cl.simulate(steered(), until=2.0, rtol=1e-6, max_step=1.0)
    actual = parts(result)
    np.testing.assert_allclose(
        actual["springs/twist"], 0.02 * 25.0 * result.time, rtol=1e-12, atol=1e-15
    )
    tight = parts(cl.simulate(steered(), until=2.0, rtol=1e-12))
    np.testing.assert_allclose(actual["springs/strut"], tight["springs/strut"], rtol=0.0, atol=1e-5)
    assert result.solver["steps"] < 10


STATES = {
    "ideal": (lambda: cl.load_case("six_bar_feeder", model="ideal"), 1),
    "pendulum": (lambda: cl.load_case("double_pendulum"), 1),
    "film": (lambda: feeder("lubricated", "B"), 2),
    "dry": (lambda: feeder("dry", "B"), 2),
    "six joints": (lambda: feeder("lubricated", "A,B,C,D,E,F"), 7),
    "two dampers": (steered, 3),
    "one damper": (lambda: steered(damping=(0.0, 0.02)), 2),
    "no damper": (lambda: steered(damping=(0.0, 0.0)), 1),
}


@pytest.mark.parametrize("name", STATES)
def test_the_ledger_has_no_more_states_than_it_needs(name):
    """Energy input, and one for each part that can take energy out; none of them with the ledger
    off.
    """
    make, count = STATES[name]
    mechanism = build(make())
    assert mechanism.y0.size == mechanism.size + count
    assert len(explain(make())["states"]) == mechanism.y0.size
    assert build(make(), ledger=False).y0.size == mechanism.size
    paths = [c.path for c in mechanism.layout.channels]
    assert sum(p.endswith("/dissipated") for p in paths) == count  # of the parts, and the total
    assert "energy/dissipated" in paths


def test_states_are_named_after_their_parts():
    """Each damper and joint has a state of its losses."""
    lost = [f"energy dissipated by springs/{name}" for name in ("strut", "twist")]
    assert explain(steered())["states"] == ["energy input", *lost]
    lost = [f"energy dissipated by joints/{name}" for name in "BC"]
    assert explain(feeder("dry"))["states"][-3:] == ["energy input", *lost]


def test_nothing_dissipates():
    """The total is there for every reader of the file, and nothing else; the ledger closes without
    it.
    """
    result = cl.simulate(cl.load_case("double_pendulum"), until=1.0, rtol=1e-9)
    assert parts(result) == {}
    assert not result.energy.dissipated.any()
    assert result.solver["energy_residual_share"] < 1e-6


@pytest.mark.parametrize("make", [lambda: feeder("dry"), steered])
def test_without_the_ledger_there_is_nothing_of_it(make):
    """Without the ledger only energies and powers are left."""
    result = cl.simulate(make(), until=1e-3, energy=False)
    assert parts(result) == {}
    assert set(result.names("energy")) == {"kinetic", "potential"}
    if "joints/B/gap" in result:
        assert "joints/B/power_loss" in result


def test_lost_energy_is_warned_of_by_the_tolerance():
    """1000 tolerances; up to 1e-6 it was 1e-3 of the energy, whatever the tolerance."""
    assert doubtful(1e-6) == pytest.approx(1e-3)
    assert doubtful(1e-8) == pytest.approx(1e-5)
    assert doubtful(1e-4) == pytest.approx(1e-2)
    assert doubtful(1e-14) == 1e-9  # rounding of a long run
