"""Friction of hinges and slides from their own reactions, and loads out of the plane, in the
generated mechanics.

Kernels run as plain Python where single states are looked at; runs use compiled ones.
"""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import clearance as cl
from clearance.laws.joint_friction import pin_load, slide_load
from clearance.mechanism.build import build
from tests import mechanisms as m
from tests.oracles.multipliers import inverse
from tests.plain import jacobian_error, observed
from tests.seeds import few_of

LENGTHS = {"crank": 0.05, "coupler": 0.15, "rocker": 0.12}
RATE = {"crank": 3.0}


def bars():
    return {
        n: m.bar(n, x, a, 10.0 * x, x**3, com=(0.4 * x, 0.01))
        for (n, x), a in zip(LENGTHS.items(), (0.0, 0.8, 1.6), strict=True)
    }


def four_bar(law=None, pin_radius=0.005, drive=None, gravity=(0.0, -9.81), **more):
    """Crank-rocker with the same friction in all four pins; drive: of the crank (default 3
    rad/s).
    """
    b = bars()
    options = {"friction": law, "pin_radius": pin_radius} if law is not None else {}
    ends = {
        "A": (cl.ground.at(0, 0), b["crank"]["a"]),
        "B": (b["crank"]["b"], b["coupler"]["a"]),
        "C": (b["coupler"]["b"], b["rocker"]["b"]),
        "D": (cl.ground.at(0.16, 0), b["rocker"]["a"]),
    }
    joints = [cl.Revolute(*e, name=n, **options, **more.get(n, {})) for n, e in ends.items()]
    return cl.Scene(
        *joints, drive(b) if drive else cl.Drive(b["crank"], speed=3.0, start=0.3), gravity=gravity
    )


def row(scene, time=0.0):
    """Channels of the observe kernel, in plain Python."""
    return observed(build(scene, ledger=False), time)


def consistent(scene, actual, tolerance=1e-11):
    """The friction of each joint is what its law makes of its rate and of the reaction it
    leaves.
    """
    for joint in (j for j in scene.joints if j.friction is not None):
        here = {
            n.rpartition("/")[2]: v
            for n, v in actual.items()
            if n.startswith(f"joints/{joint.name}/")
        }
        spin = {b.name: actual[f"bodies/{b.name}/omega"] for b in scene.bodies} | {"ground": 0.0}
        if isinstance(joint, cl.Revolute):
            rate = spin[joint.b.body.name] - spin[joint.a.body.name]
            across = [here.get(n, 0.0) for n in ("axial_force", "bending_x", "bending_y")]
            load = pin_load(here["force_x"], here["force_y"], *across, *joint.geometry.values())
        else:
            rate = actual[f"bodies/{joint.b.body.name}/vx"]  # slides along x on ground here
            load = slide_load(
                here["force_y"], 0.0, 0.0, here["moment"], 0.0, *joint.geometry.values()
            )
        assert here["friction_load"] == pytest.approx(load, rel=tolerance)
        assert here["friction"] == pytest.approx(joint.friction(rate, load), rel=tolerance)
        assert here["power_loss"] == pytest.approx(-here["friction"] * rate, rel=1e-13)


def energy_rate(scene, actual):
    """Rate of kinetic energy and of potential energy of gravity [W]."""
    total = 0.0
    for b in scene.bodies:
        x, y, theta = (actual[f"bodies/{b.name}/{n}"] for n in ("vx", "vy", "omega"))
        ax, ay, alpha = (actual[f"bodies/{b.name}/{n}"] for n in ("ax", "ay", "alpha"))
        total += (
            b.mass * (x * (ax - scene.gravity[0]) + y * (ay - scene.gravity[1]))
            + b.inertia * theta * alpha
        )
    return total


LAWS = {
    "coulomb": cl.joint_coulomb(coefficient=0.1, viscous=0.01, load_viscous=0.002),
    "smooth": cl.joint_coulomb(coefficient=0.1, transition_rate=0.5),
    "stribeck": cl.joint_stribeck(
        static=0.3, kinetic=0.1, stribeck_rate=2.0, exponent=1.0, viscous=0.02
    ),
}


# --- the coupled friction of all joints of a loop
@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
@pytest.mark.parametrize("time", few_of([0.7, 0.0, 1.9], 1))
def test_friction_in_every_pin_satisfies_its_own_equations(law, time):
    """Tolerance 1e-11: the fixed point stops at 1e-13 of the efforts, the loads are sums of terms
    ten times larger.
    """
    scene = four_bar(law)
    actual = row(scene, time)
    consistent(scene, actual)
    assert 1.0 <= actual["friction/iterations"] <= 12.0
    assert 0.0 < actual["friction/contraction"] < 0.2


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_driving_power_is_energy_and_losses(law):
    """Tolerance 1e-12 of the power: rounding of some hundred operations."""
    scene = four_bar(law)
    for time in np.linspace(0.0, 2.0, 7):
        actual = row(scene, time)
        lost = sum(actual[f"joints/{n}/power_loss"] for n in "ABCD")
        power = actual["drives/crank/power"]
        assert power == pytest.approx(
            energy_rate(scene, actual) + lost, abs=1e-12 * max(abs(power), lost)
        )


def test_without_coefficients_nothing_changes_by_a_bit():
    """Zero friction changes nothing; small friction changes linearly."""
    bare, zero = row(four_bar(), 0.4), row(four_bar(cl.joint_coulomb(coefficient=0.0)), 0.4)
    assert {n: zero[n] for n in bare} == bare
    assert zero["drives/crank/torque_ideal"] == bare["drives/crank/torque"]
    small = row(four_bar(cl.joint_coulomb(coefficient=1e-9)), 0.4)
    # linear in mu
    assert small["drives/crank/torque"] == pytest.approx(bare["drives/crank/torque"], rel=1e-7)


def test_newton_takes_over_where_the_fixed_point_contracts_slowly():
    """Pins as large as the crank, close to locking: the same equations hold."""
    scene = four_bar(cl.joint_coulomb(coefficient=1.0), pin_radius=0.05)
    for time in (0.25, 0.5, 0.75):
        actual = row(scene, time)
        consistent(scene, actual, 1e-10)
        assert actual["friction/contraction"] > 0.5
        assert (
            4.0 < actual["friction/iterations"] < 300.0
        )  # a share of the friction after the other


def test_of_several_solutions_it_is_the_one_that_grows_out_of_no_friction(validated):
    """At 1.0 s two balances exist far beyond usual friction; small steps of the coefficient lead to
    the same one.
    """
    torque = [
        row(four_bar(cl.joint_coulomb(coefficient=c), pin_radius=0.05), 1.0)["drives/crank/torque"]
        for c in np.linspace(0.0, 5.0, 26)
    ]
    assert np.isfinite(torque).all()
    assert np.abs(np.diff(torque)).max() < 2.0  # another one has 8.72 N m at a coefficient of 5
    assert torque[-1] == pytest.approx(22.18, abs=0.01)
    law = cl.joint_coulomb(coefficient=5.0)
    other = inverse(four_bar(law, pin_radius=0.05), [0.99, 1.0])
    options = {"source": "multiplier route", "kind": "independent"}
    validated(
        "torque with strong friction in all pins",
        torque[-1],
        other["drives/crank/torque"][-1],
        1e-9,
        **options,
    )


def test_friction_that_locks_the_mechanism_is_said():
    """Beyond the last solution the run ends with its reason."""
    law = cl.joint_coulomb(coefficient=2.0)
    # by continuation in mu R_p from zero, the solution ends near 0.055 m here
    scene = four_bar(law, pin_radius=0.025)
    with pytest.raises(
        cl.SimulationError, match="at t = .*joint friction have no solution.*locks"
    ) as stopped:
        cl.inverse_dynamics(scene, turns=1.0, samples=50)
    assert 0 < stopped.value.result.time.size < 50
    assert stopped.value.result.status.startswith("partial")


def test_driven_joints_rub_without_any_iteration():
    """Friction of a driven pin changes its torque and no force."""
    law = LAWS["coulomb"]
    options = {"A": {"friction": law, "pin_radius": 0.01}}
    scene = four_bar(**options)
    text = build(scene, ledger=False).structure.texts["observe"]
    assert "pin_load" in text
    assert "rub_" not in text
    actual, bare = row(scene, 0.4), row(four_bar(), 0.4)
    consistent(scene, actual, 1e-14)
    assert "friction/iterations" not in actual
    for name in "ABCD":
        for axis in "xy":
            assert actual[f"joints/{name}/force_{axis}"] == bare[f"joints/{name}/force_{axis}"]
    assert actual["drives/crank/torque"] == pytest.approx(
        bare["drives/crank/torque"] - actual["joints/A/friction"], rel=1e-14
    )


def test_laws_without_load_need_no_reaction():
    """Breakaway friction needs neither a load nor an iteration."""
    law = cl.breakaway_linear(breakaway=0.025, coulomb=0.02, viscous=0.001)
    scene = four_bar(**{n: {"friction": law} for n in "ABCD"})
    text = build(scene, ledger=False).structure.texts["observe"]
    assert "rub_" not in text
    assert "pin_load" not in text
    actual = row(scene, 0.4)
    assert "joints/B/friction_load" not in actual
    spin = actual["bodies/coupler/omega"] - actual["bodies/crank/omega"]
    assert actual["joints/B/friction"] == pytest.approx(law(spin, 0.0), rel=1e-14)


def test_a_scene_without_friction_has_nothing_of_it():
    """Kernels without friction have no word of it."""
    texts = build(four_bar()).structure.texts
    assert not any(
        word in text for text in texts.values() for word in ("pin_load", "rub_", "slide_load")
    )
    assert not any(
        "friction" in c.path or "ideal" in c.path for c in build(four_bar()).layout.channels
    )


def crank_and_rod():
    """Of two slider-cranks."""
    crank = m.bar("crank", 0.05, mass=0.5, inertia=1e-3, com=(0.02, 0))
    return crank, m.bar("rod", 0.2, mass=0.8, inertia=2e-3, com=(0.1, 0))


# --- slides
def test_a_slide_rubs_with_its_normal_force_and_moment():
    """A slider whose pin lies beside the guide: the force across and the tilting moment both
    rub.
    """
    law = cl.joint_coulomb(coefficient=0.15)
    crank, rod = crank_and_rod()

    block = cl.Body("block", 1.5, 1e-3, points={"pin": (0.0, 0.03), "shoe": (0, 0)})
    scene = cl.Scene(
        cl.Revolute(cl.ground.at(0, 0), crank["a"], name="A"),
        cl.Revolute(crank["b"], rod["a"], name="B"),
        cl.Revolute(rod["b"], block["pin"], name="C"),
        cl.Prismatic(
            cl.ground.at(0, -0.03), block["shoe"], name="guide", friction=law, overlap=0.06
        ),
        cl.Drive(crank, speed=20.0, start=0.4),
        cl.Force(block["shoe"], x=-50.0),
    )
    for time in (0.0, 0.1, 0.2):
        actual = row(scene, time)
        rate = actual["bodies/block/vx"]
        normal, moment = actual["joints/guide/force_y"], actual["joints/guide/moment"]
        load = abs(normal) + abs(moment) / 0.03
        assert actual["joints/guide/friction_load"] == pytest.approx(load, rel=1e-12)
        assert actual["joints/guide/friction"] == pytest.approx(
            -0.15 * load * math.copysign(1.0, rate), rel=1e-12
        )
        # all that passes through the guide along it is friction
        assert actual["joints/guide/force_x"] == pytest.approx(
            actual["joints/guide/friction"], rel=1e-12
        )
        pushed = energy_rate(scene, actual) + 50.0 * rate + actual["joints/guide/power_loss"]
        assert actual["drives/crank/power"] == pytest.approx(pushed, rel=1e-11)


# --- forward dynamics
def sled(coefficient=0.2, transition_rate=1e-4, force=None):
    block = cl.Body("block", 2.0, 0.01, points={"shoe": (0, 0)}, velocity=(1.0, 0.0))
    law = cl.joint_coulomb(coefficient=coefficient, transition_rate=transition_rate)
    guide = cl.Prismatic(cl.ground, block["shoe"], name="guide", friction=law, overlap=0.1)
    return cl.Scene(guide, *([cl.Force(block["shoe"], x=force)] if force else []))


def test_a_sliding_block_stops_where_and_when_coulomb_says(validated):
    """Stopping time v / (mu g), way v^2 / (2 mu g).

    The smoothed sign lags by about v_t: 1e-3 of the way.
    """
    run = cl.simulate(sled(), until=1.0, rtol=1e-8)
    way, stop = 1.0 / (2.0 * 0.2 * 9.81), 1.0 / (0.2 * 9.81)
    x, v = run["block"].x, run["block"].vx
    validated(
        "way of a block that slides to rest",
        x[-1],
        way,
        1e-3,
        unit="m",
        source="v^2 / (2 mu g)",
        kind="exact",
    )
    assert v[run.time < 0.99 * stop].min() > 0.0
    assert np.abs(v[run.time > 1.01 * stop]).max() < 1e-4
    assert np.abs(run.energy.residual).max() < 1e-6
    lost = run.joint("guide").dissipated[-1]
    validated(
        "energy a block loses", lost, 1.0, 1e-5, unit="J", source="its kinetic energy", kind="exact"
    )


def test_a_block_pushed_less_than_it_can_resist_only_creeps(validated):
    """Below mu N the smoothed sign creeps at v_t atanh(F / mu N)."""
    scene = sled(force=2.0)
    run = cl.simulate(scene, until=2.0, rtol=1e-8)
    creep = 1e-4 * math.atanh(2.0 / (0.2 * 2.0 * 9.81))
    options = {"source": "v_t atanh(F / mu N)", "kind": "exact"}
    validated(
        "creep below the sliding force", run["block"].vx[-1], creep, 1e-5, unit="m/s", **options
    )


def pushed(b):
    return cl.Drive(b["crank"], torque=0.8, start=0.3)


STRIBECK = cl.joint_stribeck(
    static=0.3, kinetic=0.1, stribeck_rate=0.5, viscous=0.003, transition_rate=0.2
)


def hanging(law=STRIBECK):
    """Two bars that fall, both hinges rubbing."""
    upper = m.bar("upper", 0.3, 0.2, 1.0, 0.02, com=(0.15, 0.01))
    lower = m.bar("lower", 0.2, -0.4, 0.7, 0.01, com=(0.1, 0.0), angular_velocity=2.0)

    options = {"friction": law, "pin_radius": 0.02}
    return cl.Scene(
        cl.Revolute(cl.ground, upper["a"], name="A", **options),
        cl.Revolute(upper["b"], lower["a"], name="B", **options),
    )


def mixed():
    """A crank and slider with a dry clearance joint; the other joints rub."""
    law = cl.joint_coulomb(coefficient=0.1, viscous=1e-3, transition_rate=0.3)
    crank, rod = crank_and_rod()

    block = cl.Body("block", 1.5, 1e-3, points={"pin": (0.0, 0.0)})
    return cl.Scene(
        cl.Revolute(cl.ground.at(0, 0), crank["a"], name="A", friction=law, pin_radius=0.01),
        cl.Revolute(crank["b"], rod["a"], name="B", friction=law, pin_radius=0.01),
        m.film(rod["b"], block["pin"], name="C"),
        cl.Prismatic(cl.ground, block["pin"], name="guide", friction=law, overlap=0.05),
        cl.Drive(crank, speed=20.0, start=0.4),
    )


FORWARD = {
    "four_bar": lambda: four_bar(
        cl.joint_coulomb(coefficient=0.1, viscous=0.002, transition_rate=0.3), drive=pushed
    ),
    "chain": hanging,
    "sled": sled,
    "clearance": mixed,
}


@pytest.mark.parametrize("name", few_of([*FORWARD], 2))
def test_the_jacobian_is_that_of_the_right_side(name):
    """Against central differences; tolerance 1e-6 of the largest entry of each column: what these
    are good for.
    """
    mechanism = build(FORWARD[name]())
    y, n, rng = mechanism.y0.copy(), mechanism.size, np.random.default_rng(3)
    y[:n] += 0.3 * mechanism.scale * rng.uniform(-1.0, 1.0, n)
    assert jacobian_error(mechanism, y) < 1e-6


@pytest.mark.parametrize("name", ["four_bar", "chain"])
def test_energy_balance_closes_in_forward_motion(name):
    """Residual over the energy turned over, at rtol 1e-8: 1e-6."""
    run = cl.simulate(FORWARD[name](), until=1.0, rtol=1e-8)
    energy = run.facts("energy")
    assert energy["largest_residual"] < 1e-6 * energy["turned_over"]
    assert run.energy.dissipated[-1] > 0.0
    joints = [run.joint(j).dissipated[-1] for j in run.names("joints")]
    assert run.energy.dissipated[-1] == pytest.approx(sum(joints), rel=1e-12)


def test_forward_motion_from_inverse_torque(validated):
    """The torque that inverse dynamics gives makes the prescribed motion."""
    law = cl.joint_coulomb(coefficient=0.1, viscous=0.002, transition_rate=2.0)
    given_run = cl.inverse_dynamics(four_bar(law), until=1.0, samples=2001)
    torque = given_run.values("drives/crank/torque")
    # a Chebyshev series of the torque, smooth with this transition rate
    series = np.polynomial.chebyshev.Chebyshev.fit(given_run.time, torque, 60, domain=[0.0, 1.0])
    assert np.abs(series(given_run.time) - torque).max() < 1e-6 * np.abs(torque).max()
    result = cl.simulate(
        four_bar(law, drive=lambda b: _series_drive(b, series.coef)), until=1.0, rtol=1e-10
    )
    options = {"source": "the prescribed motion", "kind": "exact", "relative": False}
    validated(
        "motion by the torque found",
        result["crank"].theta,
        0.3 + 3.0 * result.time,
        1e-4,
        unit="rad",
        **options,
    )


def _series_drive(b, coefficients):
    numbers = tuple(float(c) for c in coefficients)

    @cl.effort
    def of_series(time, position, rate):
        x = 2.0 * time - 1.0
        before, now, total = 1.0, x, numbers[0] + numbers[1] * x
        for k in range(2, 61):
            before, now = now, 2.0 * x * now - before
            total += numbers[k] * now
        return total

    return cl.Drive(b["crank"], torque=of_series(), start=0.3, speed_start=3.0)


def test_the_sign_function_is_refused_where_forces_decide_on_the_motion():
    """Forward dynamics need a transition rate; prescribed motions do not."""
    with pytest.raises(
        ValueError, match=r"joint A: friction joint_coulomb has a sign function.*transition_rate"
    ):
        build(four_bar(cl.joint_coulomb(coefficient=0.1), drive=pushed))
    build(four_bar(cl.joint_coulomb(coefficient=0.1)))  # prescribed: fine


# --- out of the plane
def plate(**joint):
    """A plate on two hinged bars, seen from above; centres of mass and pins at different
    heights.
    """
    arm = cl.Body(
        "arm",
        2.0,
        0.05,
        points={"near": (0, 0, 0.02), "far": (0.4, 0.0, 0.05)},
        com=(0.1, 0.05, 0.01),
    )
    tool = cl.Body(
        "tool",
        1.0,
        0.01,
        points={"near": (0, 0, 0.0), "tip": (0.2, 0, -0.1)},
        com=(0.15, 0, -0.03),
        products=(2e-3, -1e-3),
        angle=0.7,
    )
    return cl.Scene(
        cl.Revolute(cl.ground, arm["near"], name="shoulder", **joint),
        cl.Revolute(arm["far"], tool["near"], name="elbow", **joint),
        cl.Drive(arm, speed=2.0, start=0.3, name="arm"),
        cl.Drive(tool, speed=-1.0, start=1.0, name="tool"),
        cl.Force(tool["tip"], x=5.0, y=-2.0, z=-30.0),
        gravity=(0.0, 0.0, -9.8),
    )


def spatial(scene, actual):
    """Newton and Euler in space about the centres of mass: what joints must carry, independently
    written.
    """
    balance = {}
    for b in scene.bodies:
        c, s = (
            math.cos(actual[f"bodies/{b.name}/theta"]),
            math.sin(actual[f"bodies/{b.name}/theta"]),
        )
        turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        w, alpha = (np.array([0, 0, actual[f"bodies/{b.name}/{n}"]]) for n in ("omega", "alpha"))
        pxz, pyz = b.products
        inertia = (
            turn @ np.array([[1.0, 0, -pxz], [0, 1.0, -pyz], [-pxz, -pyz, b.inertia]]) @ turn.T
        )
        a = np.array([actual[f"bodies/{b.name}/ax"], actual[f"bodies/{b.name}/ay"], 0.0])
        force = b.mass * (a - np.array([*scene.gravity, 0.0][:3]))
        balance[b.name] = [force, inertia @ alpha + np.cross(w, inertia @ w), turn]
    return balance


def test_loads_out_of_the_plane_of_a_chain(validated):
    """All six components of both joints against Newton and Euler in space; tolerance 1e-12 of
    rounding.
    """
    scene = plate()
    actual = row(scene, 0.3)
    balance = spatial(scene, actual)
    tool, arm = scene.bodies[1], scene.bodies[0]
    height = {"arm": 0.01, "tool": -0.03}

    def offset(body, point):
        x, y, z = point
        local = np.array([x - body.com[0], y - body.com[1], z - height[body.name]])
        return balance[body.name][2] @ local

    push, at = np.array([5.0, -2.0, -30.0]), offset(tool, (0.2, 0, -0.1))
    elbow, shoulder = offset(tool, (0, 0, 0.0)), offset(arm, (0, 0, 0.02))
    force = balance["tool"][0] - push
    moment = balance["tool"][1] - np.cross(at, push) - np.cross(elbow, force)
    far = offset(arm, (0.4, 0, 0.05))
    force2 = balance["arm"][0] + force
    moment2 = balance["arm"][1] + np.cross(far, force) + moment - np.cross(shoulder, force2)
    for name, f, n in (("elbow", force, moment), ("shoulder", force2, moment2)):
        here = {
            k: actual[f"joints/{name}/{k}"]
            for k in ("force_x", "force_y", "axial_force", "bending_x", "bending_y")
        }
        expected = [*f, *n[:2]]
        options = {
            "source": "Newton and Euler in space",
            "kind": "independent",
            "relative": np.abs(expected).max(),
        }
        validated(
            "forces and moments of a chain in space",
            list(here.values()),
            expected,
            1e-12,
            **options,
        )


def test_friction_takes_axial_force_and_bending():
    """Loads out of the plane rub too, as in Newton's equations."""
    law = cl.joint_coulomb(coefficient=0.2)
    scene = plate(friction=law, pin_radius=0.02, friction_arm=0.03, bending_arm=0.06)
    consistent(scene, row(scene, 0.3))


@pytest.mark.parametrize(
    ("missing", "field"),
    [({"bending_arm": 0.05}, "friction_arm"), ({"friction_arm": 0.03}, "bending_arm")],
)
def test_arms_are_asked_for_where_they_rub(missing, field):
    """A joint with axial force or bending needs the arms of them."""
    law = cl.joint_coulomb(coefficient=0.2)
    with pytest.raises(ValueError, match=f"joint (elbow|shoulder): carries .* needs {field}"):
        build(plate(friction=law, pin_radius=0.02, **missing))


def test_loops_need_to_say_who_carries_loads_out_of_the_plane(validated):
    """A self-aligning joint decides it; the forces are the weights."""
    gravity = (0.0, -9.81, -2.0)
    with pytest.raises(ValueError, match=r"closed loop \(joints .*self_aligning=True"):
        build(four_bar(gravity=gravity))
    scene = four_bar(gravity=gravity, C={"self_aligning": True})
    actual = row(scene, 0.2)
    weights = {b.name: 2.0 * b.mass for b in scene.bodies}
    assert actual["joints/C/axial_force"] == 0.0
    carried = [actual[f"joints/{n}/axial_force"] for n in "BAD"]
    wanted = [weights["coupler"], weights["coupler"] + weights["crank"], weights["rocker"]]
    options = {"unit": "N", "source": "weights of the bars", "kind": "exact"}
    validated("axial forces of a horizontal four-bar", carried, wanted, 1e-14, **options)
    with pytest.raises(ValueError, match="body rocker: .* no joint carries them"):
        build(four_bar(gravity=gravity, C={"self_aligning": True}, D={"self_aligning": True}))


def test_a_planar_scene_has_no_loads_out_of_the_plane():
    """Without such loads there are no outputs of them."""
    assert not any(
        "axial" in c.path or "bending" in c.path for c in build(four_bar()).layout.channels
    )


# --- properties
@settings(max_examples=15, deadline=None)
@given(
    coefficient=st.floats(0.0, 0.4),
    radius=st.floats(1e-3, 0.015),
    viscous=st.floats(0.0, 0.1),
    time=st.floats(0.0, 2.0),
)
def test_any_friction_in_every_pin(coefficient, radius, viscous, time):
    """Any coefficients: Newton's equations to 1e-10, and no power gained."""
    law = cl.joint_coulomb(coefficient=coefficient, viscous=viscous)
    scene = four_bar(law, pin_radius=radius)
    actual = row(scene, time)
    consistent(scene, actual, 1e-10)
    assert all(actual[f"joints/{n}/power_loss"] >= 0.0 for n in "ABCD")


# --- stiff and extreme
@pytest.mark.parametrize("transition_rate", [1e-1, 1e-3, 1e-5])
def test_a_linkage_that_comes_to_rest_stays_there(transition_rate):
    """However sharp the sign: the energy goes into friction, to 1e-5 of what was turned over, in
    few steps.
    """
    law = cl.joint_coulomb(coefficient=0.2, transition_rate=transition_rate)
    free = four_bar(
        law, pin_radius=0.01, drive=lambda b: cl.Drive(b["crank"], torque=0.0, start=0.3)
    )
    run = cl.simulate(free, until=5.0)
    energy = run.facts("energy")
    assert energy["largest_residual"] < 1e-5 * energy["turned_over"]
    assert abs(run["crank"].omega[-1]) < 10.0 * transition_rate
    assert run.solver["steps"] < 5000
    assert run.solver["method"] == "radau5"
    assert run.warnings == []


def test_a_sign_sharper_than_the_tolerance_is_said():
    """A transition rate below the tolerance is warned of."""
    run = cl.simulate(sled(transition_rate=1e-7), until=0.1)
    assert any(
        "joint guide: transition_rate 1e-07 m/s is finer than rtol 1e-06 sees" in w
        for w in run.warnings
    )
