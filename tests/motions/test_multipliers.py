"""The multiplier route: against the traced mechanics, closed forms, sums over point masses, balance
of power.
"""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
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
from clearance.mechanism.build import build
from clearance.scene.catalogue import load_case
from tests import mechanisms as m
from tests.elements.test_rubbing import energy_rate
from tests.oracles import multipliers
from tests.oracles.multipliers import SingularPosition, inverse
from tests.oracles.pairs import prescribed
from tests.plain import observed
from tests.seeds import few_of

GRAVITY = 9.8
GUO = {"source": "chains of Guo, Ju and Wang 2024, solved elsewhere", "kind": "independent"}


@cl.signal
def swing(time, amplitude, frequency, offset):
    return offset + amplitude * math.sin(frequency * time) + 0.3 * time * time


@cl.signal
def reaching(time, far, near):
    """Reaches its largest value at t = 1."""
    return far - near * (1.0 - time) ** 2


def poses_of(scene, actual):
    """Poses of the centres of mass (samples, bodies, 3)."""
    rows = [[actual[f"bodies/{b.name}/{n}"] for n in ("x", "y", "theta")] for b in scene.bodies]
    return np.moveaxis(np.array(rows), 2, 0)


def assert_same(actual, expected, tolerance, validated=None):
    """Channel by channel, relative to the largest value of channels of the same name; not the
    course of iterations.
    """
    largest: dict[str, float] = {}
    for path, values in expected.items():
        kind = path.split("/")[-1]
        largest[kind] = max(largest.get(kind, 0.0), float(np.abs(values).max()))
    for path in (p for p in actual if not p.startswith("friction/")):
        kind = path.split("/")[-1]
        wrong = actual[path] - expected[path]
        wrong = np.remainder(wrong + np.pi, 2.0 * np.pi) - np.pi if kind == "theta" else wrong
        assert np.abs(wrong).max() <= tolerance * (largest[kind] or 1.0), path
        if validated is not None:
            options = {
                "source": "traced mechanics",
                "kind": "independent",
                "relative": largest[kind],
            }
            validated(
                "multiplier route: all channels",
                expected[path] + wrong,
                expected[path],
                tolerance,
                **options,
            )


def placed(actual, body, local):
    """Place and acceleration (samples, 3) of a point (x, y, z) of a body, from its channels."""
    if body is cl.ground:
        return np.array([local]), np.zeros((1, 3))
    names = ("x", "y", "theta", "omega", "ax", "ay", "alpha")
    x, y, theta, w, ax, ay, alpha = (actual[f"bodies/{body.name}/{n}"] for n in names)
    arm = np.exp(1j * theta) * complex(local[0] - body.com[0], local[1] - body.com[1])
    position, pull = x + 1j * y + arm, ax + 1j * ay + (1j * alpha - w**2) * arm
    return np.stack([position.real, position.imag, 0.0 * x + local[2]], 1), np.stack(
        [pull.real, pull.imag, 0.0 * x], 1
    )


def reaction(actual, joint):
    """Force and moment (samples, 3) on body b about its joint point, from the joint's channels and
    its drive's.
    """
    names = ("force_x", "force_y", "axial_force"), ("bending_x", "bending_y")
    nothing = np.zeros_like(actual[f"joints/{joint.name}/force_x"])
    force, bending = (
        [actual.get(f"joints/{joint.name}/{n}", nothing) for n in group] for group in names
    )
    if isinstance(joint, cl.Prismatic):
        turn = actual[f"joints/{joint.name}/moment"]
    else:
        turn = actual.get(f"joints/{joint.name}/friction", nothing) + actual.get(
            f"drives/{joint.name}/torque", nothing
        )
    return np.stack(force, 1), np.stack([*bending, turn], 1)


def unbalanced(scene, actual):
    """Force and moment (samples, 3) that joints, weight and inertia leave on each body, and the
    largest force.
    """
    balance, largest = {}, 0.0
    for b in scene.bodies:
        (centre, a), com = placed(actual, b, (*b.com, 0.0)[:3]), (*b.com, 0.0)[:3]
        w, alpha, theta = (actual[f"bodies/{b.name}/{n}"] for n in ("omega", "alpha", "theta"))
        spin = (alpha + 1j * w**2) * complex(*b.products) * np.exp(1j * theta)
        push = b.mass * ((*scene.gravity, 0.0)[:3] - a)
        turn = np.stack(
            [spin.real, spin.imag, -b.inertia * alpha + actual.get(f"drives/{b.name}/torque", 0.0)],
            1,
        )
        balance[b] = [centre, com[2], push, turn]
        largest = max(largest, np.abs(push).max())
    for joint in scene.joints:
        force, moment = reaction(actual, joint)
        largest = max(largest, np.abs(force).max())
        points = [placed(actual, p.body, (p.x, p.y, p.z))[0] for p in (joint.a, joint.b)]
        if isinstance(joint, cl.Prismatic):  # the sliding point, at the height it has on body a
            points[0] = np.concatenate(
                [points[1][:, :2], 0.0 * points[1][:, :1] + joint.a.z], axis=1
            )
        for sign, end, point in ((-1.0, joint.a, points[0]), (1.0, joint.b, points[1])):
            if end.body is not cl.ground:
                centre = balance[end.body][0]
                balance[end.body][2] = balance[end.body][2] + sign * force
                balance[end.body][3] = balance[end.body][3] + sign * (
                    moment + np.cross(point - centre, force)
                )
    return {b: v[2:] for b, v in balance.items()}, largest


# --- friction mechanisms
def bar(name, length, angle=0.0, density=4.0):
    ends = {"near": (-0.5 * length, 0.0), "far": (0.5 * length, 0.0)}
    return cl.Body(
        name, density * length, density * length**3 / 12.0 + 1e-6, points=ends, angle=angle
    )


def four_bar(
    lengths=(0.05, 0.15, 0.12, 0.16),
    density=4.0,
    gravity=(0.0, -9.81),
    aligning="",
    speed=30.0,
    **rubbing,
):
    """Crank-rocker whose hinges A to D all rub alike."""
    bars = [
        bar(n, x, a, density)
        for n, x, a in zip(("crank", "rod", "rocker"), lengths, (0.1, 0.8, 1.6), strict=False)
    ]
    crank, rod, rocker = bars
    ends = {
        "A": (cl.ground.at(0, 0), crank["near"]),
        "B": (crank["far"], rod["near"]),
        "C": (rod["far"], rocker["far"]),
        "D": (cl.ground.at(lengths[3], 0), rocker["near"]),
    }
    hinges = [
        cl.Revolute(a, b, name=n, self_aligning=n in aligning, **rubbing)
        for n, (a, b) in ends.items()
    ]
    return cl.Scene(
        *hinges, cl.Drive(crank, speed=speed, start=0.1), gravity=gravity, name="four_bar"
    )


def slider_crank(law=None, **drive):
    """Crank, rod and a block on a tilted guide, friction everywhere."""
    crank, rod = bar("crank", 0.05, 0.3), bar("rod", 0.14, -0.1)
    block = cl.Body(
        "block", 0.3, 1e-4, points={"pin": (0.0, 0.0), "foot": (0.01, -0.02)}, com=(0.004, 0.003)
    )
    pin = {"friction": law, "pin_radius": 0.006}
    guide = cl.Prismatic(
        cl.ground.at(0.0, -0.02), block["foot"], name="guide", friction=law, overlap=0.04
    )
    return cl.Scene(
        cl.Revolute(cl.ground, crank["near"], name="A", **pin),
        cl.Revolute(crank["far"], rod["near"], name="B", **pin),
        cl.Revolute(rod["far"], block["pin"], name="C", **pin),
        guide,
        cl.Drive(guide if "motion" in drive else crank, **(drive or {"speed": -25.0})),
        name="slider_crank",
    )


def loaded():
    """A four-bar with every kind of load, and an arm on its rod that swings by a law."""
    scene = four_bar(speed=10.0)
    crank, rod, rocker = scene.bodies
    tool = m.body("tool", {"T": (0, 0), "tip": (0.05, 0.02)}, angle=0.4, com=(0.02, 0.01))
    wrist = cl.Revolute(rod.at(0.03, 0.04), tool["T"], name="wrist")
    return cl.Scene(
        *scene.joints,
        wrist,
        *scene.loads,
        cl.Drive(wrist, motion=swing(amplitude=0.7, frequency=12.0, offset=0.2), name="servo"),
        cl.SpringDamper(
            cl.ground.at(0.1, 0.2), rod.at(0.01, 0.02), 300.0, 4.0, 0.05, name="spring"
        ),
        cl.SpringDamper(tool["tip"], rocker["far"], 200.0, 0.0, 0.02, name="link"),
        cl.TorsionSpring(crank, rod, 0.8, 0.02, 0.3, name="twist"),
        cl.TorsionSpring(cl.ground, rocker, 0.5, 0.01, -0.2, name="hold"),
        cl.Force(
            tool["tip"], x=3.0, y=swing(amplitude=5.0, frequency=30.0, offset=-2.0), name="push"
        ),
        cl.Torque(rocker, swing(amplitude=0.2, frequency=20.0, offset=0.1), name="turn"),
        name="loaded",
    )


# --- against the traced mechanics
SCENES = {
    "slider_crank": (lambda: load_case("slider_crank", model="ideal"), 0.012),
    "four_bar": (lambda: load_case("four_bar"), 0.2),
    "six_bar_feeder": (lambda: load_case("six_bar_feeder", model="ideal"), 0.2),
    "moving_guide": (m.moving_guide, 0.016),  # it ends at 0.0183 s
    "loaded": (loaded, 0.3),
    # loops without a closed form: as far as the kernel reaches at once from the assembled position
    "stephenson": (m.stephenson, 0.02),
    "scotch_yoke": (m.scotch_yoke, 0.03),
} | {f.__name__: (f, 0.3) for f in (m.watt, m.inverted_slider, m.actuator, m.arm, m.reversed_arm)}


@pytest.mark.parametrize("name", few_of([*SCENES][::-1], 5))
def test_the_traced_mechanics_agree(name, validated):
    """All channels at five times: 1e-10; the kernel's loops close to 1e-13, the rest is
    rounding.
    """
    make, until = SCENES[name]
    scene, time = make(), until * np.array([0.0, 0.21, 0.4, 0.77, 1.0])
    actual, mechanism = inverse(scene, time), build(scene, ledger=False)
    rows = [observed(mechanism, t) for t in time]
    expected = {path: np.array([row[path] for row in rows]) for path in rows[0]}
    assert_same(actual, expected, 1e-10, validated)
    assert not {p for p in expected if p.split("/")[0] in ("bodies", "joints", "drives")} - set(
        actual
    )


# --- the two mechanisms of Guo, Ju and Wang (2024), decoded: numbers from a recursion and a 21 x 21
# solve of their own
def test_five_axis_tree(validated):
    """Printed digits: torques to 1e-6 N m, axial forces, Stribeck friction to 1e-6; friction is
    explicit.
    """
    scene = load_case(
        "five_axis_chain", friction="stribeck", bending_arm=0.05, friction_arm=0.02, pin_radius=0.02
    )
    actual = inverse(scene, np.array([0.05, 0.1, 0.2, 1.0, 2.0]))
    torques = np.array([actual[f"drives/{j}/torque_ideal"] for j in "12345"]).T
    expected = (
        [1.969606, 1.486063, -0.039957, 0.894093, 0.282312],
        [3.316237, 2.647132, -0.603835, 0.143756, 0.528323],
    )
    options = GUO | {"unit": "N m", "relative": False}
    validated(
        "ideal torques of the five-axis tree, multipliers", torques[3:], expected, 6e-7, **options
    )
    axial = [actual[f"joints/{j}/axial_force"][1] for j in "12345"]
    weights, source = [107.8, 49.0, 19.6, 49.0, 19.6], "weights of the links"
    validated(
        "axial forces, multipliers", axial, weights, 1e-14, unit="N", source=source, kind="exact"
    )
    friction = [
        [0.489680, 0.710454, 0.231424, 0.710482, 0.231493],
        [0.366329, 0.531549, 0.173195, 0.531336, 0.173244],
    ]
    rubbed = -np.array([actual[f"joints/{j}/friction"] for j in "12345"]).T
    validated("friction of the five-axis tree, multipliers", rubbed[:2], friction, 6e-7, **options)
    assert (actual["friction/iterations"] == 1.0).all()
    assert (actual["friction/contraction"] < 1e-13).all()


def test_three_loop_chain(validated):
    """Printed digits of the crank torque (1e-6 N m), ideal and with friction in all pins;
    contraction 0.019.
    """
    scene = load_case("three_loop_chain", where="all", pin_radius=0.005, friction="coulomb")
    actual = inverse(scene, np.array([0.0, 4.0, 8.0, 10.0]))
    torque, ideal = actual["drives/crank/torque"], actual["drives/crank/torque_ideal"]
    name, options = "of the three-loop chain, multipliers", GUO | {"unit": "N m", "relative": False}
    validated(f"ideal torque {name}", ideal[:3], [0.8800089, 1.8073065, 1.8089609], 6e-8, **options)
    validated(f"torque with friction {name}", torque[[0, 3]], [0.999011, 1.164278], 6e-7, **options)
    validated(
        f"friction torque {name}", (torque - ideal)[[0, 3]], [0.119002, 0.285188], 6e-7, **options
    )
    contraction = actual["friction/contraction"][0]
    validated(
        "contraction of the friction iteration, multipliers",
        contraction,
        0.019,
        5e-4,
        **GUO,
        relative=False,
    )
    assert actual["friction/iterations"][0] == 8.0


# --- out of the plane
def test_weight_along_the_axes(validated):
    """Two links whose axes are vertical, pushed and pulled at a height: loads of each pin, closed
    form to 1e-13.
    """
    one = cl.Body("one", 2.0, 0.1, points={"end": (0.5, 0.0)}, com=(0.2, 0.05))
    two = cl.Body("two", 3.0, 0.2, com=(0.3, -0.1))
    shoulder, elbow = (
        cl.Revolute(cl.ground, one, name="shoulder"),
        cl.Revolute(one["end"], two, name="elbow"),
    )
    drives = (
        cl.Drive(shoulder, speed=1.0, start=0.4, name="1"),
        cl.Drive(elbow, speed=2.0, start=-0.5, name="2"),
    )
    time = np.linspace(0.0, 2.0, 7)
    push = cl.Force(two.at(0.6, 0.1, 0.05), x=7.0, y=-2.0, z=4.0, name="push")
    spring = cl.SpringDamper(
        cl.ground.at(1.0, 0.5), two.at(0.6, 0.1, 0.05), 30.0, 0.0, 0.2, name="spring"
    )
    parts = shoulder, elbow, *drives, push, spring
    actual = inverse(cl.Scene(*parts, gravity=(0.0, 0.0, -GRAVITY)), time)
    np.testing.assert_allclose(
        actual["joints/shoulder/axial_force"], 5.0 * GRAVITY - 4.0, rtol=1e-14
    )
    np.testing.assert_allclose(actual["joints/elbow/axial_force"], 3.0 * GRAVITY - 4.0, rtol=1e-14)
    arm_1, arm_2 = np.exp(1j * (0.4 + time)), np.exp(1j * (-0.1 + 3.0 * time))
    elbow, tip = 0.5 * arm_1, 0.5 * arm_1 + (0.6 + 0.1j) * arm_2
    way = 1.0 + 0.5j - tip
    force = 7.0 - 2.0j + 30.0 * (np.abs(way) - 0.2) * way / np.abs(way)
    for joint, at in (("elbow", elbow), ("shoulder", 0.0)):
        weight = 3.0 * GRAVITY * (elbow + (0.3 - 0.1j) * arm_2 - at)
        weight = weight if joint == "elbow" else weight + 2.0 * GRAVITY * (0.2 + 0.05j) * arm_1
        expected = -1j * (weight + 0.05 * force - 4.0 * (tip - at))
        bending = actual[f"joints/{joint}/bending_x"] + 1j * actual[f"joints/{joint}/bending_y"]
        options = {"unit": "N m", "source": "closed form", "kind": "exact", "relative": False}
        validated("bending moments of two links", bending, expected, 1e-13 * 30, **options)


def clump(name, rng, count=4, **points):
    """A body of point masses (mass, x, y, z) in its own frame, and those."""
    masses, places = rng.uniform(0.1, 1.0, count), rng.uniform(-0.1, 0.1, (count, 3))
    com = masses @ places / masses.sum()
    x, y, z = (places - com).T
    inertia, products = masses @ (x * x + y * y), (masses @ (x * z), masses @ (y * z))
    return (
        cl.Body(name, masses.sum(), inertia, points=points, com=tuple(com), products=products),
        masses,
        places,
    )


def test_reactions_are_those_of_point_masses(validated):
    """Hinge, slide and hinge at heights, bodies of point masses: each joint carries sum r x m
    (a - g), to 1e-12.
    """
    rng, gravity = np.random.default_rng(3), np.array([1.0, -3.0, -8.0])
    one, *of_one = clump("one", rng, slide=(0.1, 0.02, 0.07))
    two, *of_two = clump("two", rng, slide=(0.01, 0.0, 0.07), pin=(0.06, 0.03, -0.04))
    three, *of_three = clump("three", rng, pin=(0.0, 0.01, -0.04))
    law = joint_coulomb(coefficient=0.1)
    arms = {"friction": law, "friction_arm": 0.03}
    joints = [
        cl.Revolute(
            cl.ground, one.at(0, 0, 0.02), name="base", pin_radius=0.01, bending_arm=0.04, **arms
        ),
        cl.Prismatic(
            one["slide"],
            two["slide"],
            axis=(1.0, 0.5),
            angle=0.2,
            name="slide",
            overlap=0.05,
            **arms,
        ),
        cl.Revolute(
            two["pin"], three["pin"], name="wrist", pin_radius=0.02, bending_arm=0.03, **arms
        ),
    ]
    drives = [
        cl.Drive(j, motion=swing(amplitude=a, frequency=5.0, offset=0.1))
        for j, a in zip(joints, (0.5, 0.05, 0.9), strict=True)
    ]
    actual = inverse(cl.Scene(*joints, *drives, gravity=tuple(gravity)), np.linspace(0.0, 1.0, 9))
    groups = (one, *of_one), (two, *of_two), (three, *of_three)
    carried = [
        (b, mass, r) for b, masses, places in groups for mass, r in zip(masses, places, strict=True)
    ]
    for number, joint in enumerate(joints):
        point, _ = placed(actual, joint.b.body, (joint.b.x, joint.b.y, joint.b.z))
        force, moment = np.zeros((9, 3)), np.zeros((9, 3))
        for body, mass, local in carried[4 * number :]:
            position, acceleration = placed(actual, body, local)
            push = mass * (acceleration - gravity)
            force, moment = force + push, moment + np.cross(position - point, push)
        carries = reaction(actual, joint)
        for kind, found_here, wanted in (
            ("forces", carries[0], force),
            ("moments", carries[1], moment),
        ):
            options = {
                "source": "sums over point masses",
                "kind": "independent",
                "relative": np.abs(wanted).max(),
            }
            validated(f"joint {kind} in space", found_here, wanted, 1e-12, **options)
    check_loads(actual, joints)


def test_heights_and_passive_friction():
    """A slider-crank on three levels, friction in all joints: each body balances in space, to 1e-12
    of the forces.

    Friction changes forces in the plane, these the bending moments, and these the friction: 1e-12
    there too.
    """
    law, arms = joint_coulomb(coefficient=0.1), {"friction_arm": 0.01}
    crank = cl.Body(
        "crank",
        0.3,
        1e-4,
        {"A": (0, 0, -0.01), "B": (0.05, 0, 0.02)},
        (0.02, 0.001, 0.004),
        (1e-5, -2e-5),
    )
    rod = cl.Body(
        "rod", 0.2, 3e-4, {"B": (0, 0, 0.02), "C": (0.15, 0, 0.03)}, (0.07, 0.0, 0.025), (3e-5, 0.0)
    )
    block = cl.Body(
        "block", 0.4, 1e-4, {"C": (0, 0, 0.03), "foot": (0, -0.01, -0.02)}, (0.001, 0.0, 0.0)
    )
    pin = {"friction": law, "pin_radius": 0.008, "bending_arm": 0.03, **arms}
    joints = [
        cl.Revolute(cl.ground.at(0, 0, 0.01), crank["A"], name="A", **pin),
        cl.Revolute(crank["B"], rod["B"], name="B", **pin),
        cl.Revolute(
            block["C"], rod["C"], name="C", friction=law, pin_radius=0.008, self_aligning=True
        ),
        cl.Prismatic(
            cl.ground.at(0, -0.01, -0.02),
            block["foot"],
            name="guide",
            friction=law,
            overlap=0.06,
            **arms,
        ),
    ]
    scene = cl.Scene(*joints, cl.Drive(crank, speed=40.0, start=0.3), gravity=(0.0, -5.0, -8.0))
    actual = inverse(scene, np.linspace(0.0, 0.3, 100))
    rest, largest = unbalanced(scene, actual)
    for force, moment in rest.values():
        assert np.abs(force).max() < 1e-12 * largest
        assert np.abs(moment).max() < 1e-12 * largest * 0.15
    assert actual["friction/iterations"].min() > 3.0
    check_loads(actual, joints)
    for joint in joints:
        here = f"joints/{joint.name}"
        expected = -0.1 * actual[f"{here}/friction_load"]
        np.testing.assert_allclose(np.abs(actual[f"{here}/friction"]), -expected, rtol=1e-12)


def check_loads(actual, joints):
    """Friction loads are what pin_load and slide_load make of the reactions, to rounding."""
    names = ("force_x", "force_y", "axial_force", "bending_x", "bending_y")
    for joint in joints:
        channels = [actual[f"joints/{joint.name}/{n}"] for n in names]
        if isinstance(joint, cl.Prismatic):
            axis = complex(*joint.axis) * np.exp(
                1j * actual.get(f"bodies/{joint.a.body.name}/theta", 0.0)
            )
            force, moment = ((x + 1j * y) / axis for x, y in (channels[:2], channels[3:]))
            arguments = (
                force.imag,
                channels[2],
                moment.real,
                moment.imag,
                actual[f"joints/{joint.name}/moment"],
            )
            expected = [slide_load(*v, **joint.geometry) for v in np.array(arguments).T]
        else:
            expected = [pin_load(*v, **joint.geometry) for v in np.array(channels).T]
        np.testing.assert_allclose(
            actual[f"joints/{joint.name}/friction_load"], expected, rtol=1e-12
        )
        assert (actual[f"joints/{joint.name}/power_loss"] >= 0.0).all()


def test_balancing_needs_two_planes(validated):
    """Two equal masses at (r, h) and (-r, -h): no force, and the bending moment m 2 r h (w^2,
    alpha), to 1e-13.
    """
    r, h, mass = 0.2, 0.05, 1.5
    rotor = cl.Body("rotor", 2 * mass, 2 * mass * r * r, products=(2 * mass * r * h, 0.0))
    hinge = cl.Revolute(cl.ground, rotor, name="hinge")
    actual = inverse(
        cl.Scene(
            hinge,
            cl.Drive(rotor, motion=swing(amplitude=1.0, frequency=3.0, offset=0.0)),
            gravity=(0, 0),
        ),
        np.linspace(0, 2, 9),
    )
    angle, w, alpha = (actual[f"bodies/rotor/{n}"] for n in ("theta", "omega", "alpha"))
    product = 2 * mass * r * h
    expected_x = product * (w**2 * np.sin(angle) - alpha * np.cos(angle))
    expected_y = -product * (w**2 * np.cos(angle) + alpha * np.sin(angle))
    bending = [actual["joints/hinge/bending_x"], actual["joints/hinge/bending_y"]]
    options = {"source": "closed form", "kind": "exact", "relative": np.abs(expected_x).max()}
    validated(
        "bending moment of an unbalanced rotor", bending, [expected_x, expected_y], 1e-13, **options
    )
    assert np.abs(actual["joints/hinge/axial_force"]).max() == 0.0


def test_a_loop_needs_a_self_aligning_joint():
    """Weights of a horizontal four-bar: C left out, A and D carry them all, C nothing; A to D
    together are no tree.
    """
    time = np.linspace(0.0, 0.2, 5)
    actual = inverse(four_bar(gravity=(0.0, 0.0, -GRAVITY), aligning="C"), time)
    masses = {"crank": 0.2, "rod": 0.6, "rocker": 0.48}
    np.testing.assert_allclose(
        actual["joints/A/axial_force"], GRAVITY * (masses["crank"] + masses["rod"]), rtol=1e-13
    )
    np.testing.assert_allclose(
        actual["joints/D/axial_force"], GRAVITY * masses["rocker"], rtol=1e-13
    )
    assert not actual["joints/C/axial_force"].any()
    assert not actual["joints/C/bending_x"].any()
    for aligning in ("", "AB", "AD"):  # too many carry, too few, rightly many that hang on nothing
        scene = four_bar(gravity=(0.0, 0.0, -GRAVITY), aligning=aligning)
        with pytest.raises(
            ValueError,
            match=r"joints .* must hang 3 bodies on ground as a tree.*self_aligning=True",
        ):
            inverse(scene, time)
    assert "joints/A/axial_force" not in inverse(four_bar(), time)


# --- joint friction
LAWS = {
    "coulomb": joint_coulomb(coefficient=0.2, viscous=1e-3, load_viscous=1e-3),
    "stribeck": joint_stribeck(static=0.4, kinetic=0.1, stribeck_rate=5.0),
    "breakaway": breakaway_linear(breakaway=0.1, coulomb=0.05, viscous=1e-3, threshold=1e-2),
    "smooth": breakaway_smooth(breakaway=0.1, coulomb=0.05, viscous=1e-3),
}


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("make", ["four_bar", "slider_crank"])
def test_power_goes_where_it_should(make, law):
    """The power of the drive moves masses and rubs, sample by sample: 1e-11 of the largest power
    (1e-9 is required).
    """
    law = LAWS[law]
    scene = slider_crank(law) if make == "slider_crank" else four_bar(friction=law, pin_radius=0.01)
    actual = inverse(scene, np.linspace(0.0, 0.25, 301))
    power = sum(
        v for path, v in actual.items() if path.startswith("drives") and path.endswith("power")
    )
    losses = [v for path, v in actual.items() if path.endswith("power_loss")]
    assert len(losses) == 4
    assert min(v.min() for v in losses) >= 0.0
    np.testing.assert_allclose(
        power, energy_rate(scene, actual) + sum(losses), rtol=0.0, atol=1e-11 * np.abs(power).max()
    )
    assert ("joints/B/friction_load" in actual) == law.law.needs_load
    drive = scene.loads[0].name
    assert (
        np.abs(actual[f"drives/{drive}/torque"] - actual[f"drives/{drive}/torque_ideal"]).max()
        > 1e-3
    )


def test_no_coefficient_no_friction():
    """mu = 0 and no friction at all: 1e-14, the rounding of one solve with more right sides."""
    time = np.linspace(0.0, 0.25, 50)
    actual = inverse(four_bar(friction=joint_coulomb(coefficient=0.0), pin_radius=0.01), time)
    ideal = inverse(four_bar(), time)
    assert_same(ideal, actual, 1e-14)
    assert set(actual) - set(ideal) == {
        f"joints/{j}/{n}" for j in "ABCD" for n in ("friction", "friction_load", "power_loss")
    } | {"drives/crank/torque_ideal", "friction/iterations", "friction/contraction"}
    assert (actual["friction/iterations"] == 1.0).all()


@pytest.mark.slow
def test_slow_fixed_point_is_left_to_newton(monkeypatch):
    """Pins of 40 mm, mu = 1: the fixed point contracts by 0.5 to 0.9 and agrees to 1e-12 (its
    stop / (1 - 0.9)).
    """
    scene, time = (
        four_bar(friction=joint_coulomb(coefficient=1.0), pin_radius=0.04),
        np.linspace(0.0, 0.2, 200),
    )
    newton = inverse(scene, time)
    assert (newton["friction/contraction"] > multipliers.SLOW).sum() > 100
    monkeypatch.setattr(multipliers, "SLOW", math.inf)
    monkeypatch.setattr(multipliers, "LIMIT", 1000)
    plain = inverse(scene, time)
    assert_same(newton, plain, 1e-12)


def test_newton_finds_what_a_law_bends(monkeypatch):
    """A law that is not linear in its load, by fixed point and by Newton from the third evaluation
    on: 1e-12.
    """
    law = joint_saturating(coefficient=0.8, knee=0.05)
    scene, time = four_bar(friction=law, pin_radius=0.02), np.linspace(0.0, 0.2, 40)
    plain = inverse(scene, time)
    monkeypatch.setattr(multipliers, "SLOW", -1.0)
    newton = inverse(scene, time)
    assert_same(newton, plain, 1e-12)
    # a share after the other
    assert (newton["friction/iterations"] > plain["friction/iterations"]).any()


@cl.joint_friction
def joint_saturating(rate, load, coefficient, knee):
    return -coefficient * knee * math.tanh(load / knee) * math.tanh(rate)


def test_jammed():
    """Pins as large as the crank is long: friction outgrows what makes it; the samples before that
    stay.
    """
    scene, time = (
        four_bar(friction=joint_coulomb(coefficient=1.0), pin_radius=0.05),
        np.linspace(0.0, 0.2, 50),
    )
    with pytest.raises(
        SingularPosition, match="joint friction finds no balance .* joint [A-D]"
    ) as caught:
        inverse(scene, time)
    count = caught.value.done["friction/iterations"].size
    assert count > 10
    assert caught.value.time == time[count]
    assert_same(caught.value.done, inverse(scene, time[:count]), 1e-11)


# --- positions
def test_poses_are_guesses():
    """Guesses 2 % of the size off, some angles by full turns: the same positions, and the same
    forces to 1e-11.
    """
    scene, time = slider_crank(LAWS["coulomb"]), np.linspace(0.0, 1.0, 200)
    followed = inverse(scene, time)
    poses = poses_of(scene, followed)
    rough = poses + 2e-3 * np.random.default_rng(1).uniform(-1.0, 1.0, poses.shape)
    polished = inverse(scene, time, rough)
    assert_same(polished, followed, 1e-11)
    np.testing.assert_allclose(
        polished["bodies/crank/theta"], 0.3 - 25.0 * time, rtol=0.0, atol=1e-12
    )
    rough[..., 2] = np.remainder(rough[..., 2] + np.pi, 2.0 * np.pi) - np.pi
    assert_same(inverse(scene, time, rough), followed, 1e-11)
    assert_same(inverse(scene, time[::40]), {k: v[::40] for k, v in followed.items()}, 1e-11)
    assert_same(inverse(scene, time[150:]), {k: v[150:] for k, v in followed.items()}, 1e-11)


def test_many_samples_are_solved_in_blocks(monkeypatch):
    """The same numbers whatever the block: 1e-13, as sums may be taken in another order."""
    scene, time = slider_crank(LAWS["coulomb"]), np.linspace(0.0, 0.3, 50)
    entire = inverse(scene, time)
    monkeypatch.setattr(multipliers, "BLOCK", 7)
    assert_same(inverse(scene, time), entire, 1e-13)


def test_a_motion_that_ends():
    """The moving guide runs into its dead centre at 0.0183 s: the samples before it stay."""
    scene, time = m.moving_guide(), np.linspace(0.0, 0.03, 61)
    with pytest.raises(
        SingularPosition, match=r"t = 0.0185 s: the motion ends here; .* stays .* open"
    ) as caught:
        inverse(scene, time)
    assert caught.value.time == 0.0185
    done = caught.value.done
    assert_same(done, inverse(scene, time[:37]), 1e-11)
    assert {v.size for v in done.values()} == {37}
    with pytest.raises(SingularPosition, match="t = 0.0185 s"):
        inverse(scene, time, np.concatenate([poses_of(scene, done), poses_of(scene, done)[-24:]]))


def test_dead_centre():
    """A slider pulls its crank straight: singular there, whether followed or given; before it all
    is computed.
    """
    scene = slider_crank(motion=reaching(far=0.19 + 0.01, near=0.03))
    with pytest.raises(
        SingularPosition, match="t = 1 s: singular position; the reaction of .* has no"
    ) as caught:
        inverse(scene, np.array([0.0, 0.5, 0.9, 1.0, 1.1]))
    done = caught.value.done
    assert done["bodies/crank/omega"].size == 3
    straight = np.array([[[0.025, 0.0, 0.0], [0.12, 0.0, 0.0], [0.194, 0.003, 0.0]]])
    with pytest.raises(
        SingularPosition,
        match="t = 1 s: singular position; the reaction of .* has no unique answer",
    ):
        inverse(scene, np.array([1.0]), straight)


# --- any four-bar
@settings(max_examples=25)
@given(
    crank=st.floats(0.02, 0.05),
    rod=st.floats(0.1, 0.2),
    rocker=st.floats(0.1, 0.2),
    frame=st.floats(0.1, 0.2),
    density=st.floats(0.1, 100.0),
    speed=st.floats(-50.0, 50.0),
    mu=st.floats(0.0, 0.3),
)
def test_any_crank_rocker(crank, rod, rocker, frame, density, speed, mu):
    """Every body's balance of forces and moments and the loop hold over a turn: 1e-11 of the
    largest term.

    The transmission angle stays away from 0, where all of them lose digits in proportion.
    """
    far, near = frame + crank, frame - crank
    cosines = [(rod**2 + rocker**2 - d**2) / (2.0 * rod * rocker) for d in (near, far)]
    assume(max(map(abs, cosines)) < 0.98)
    scene = four_bar(
        (crank, rod, rocker, frame),
        density,
        speed=speed,
        friction=joint_coulomb(coefficient=mu),
        pin_radius=0.004,
    )
    actual = inverse(scene, np.linspace(0.0, 2.0 * np.pi / max(abs(speed), 1.0), 20))
    for joint in scene.joints:
        ends = [placed(actual, p.body, (p.x, p.y, p.z))[0] for p in (joint.a, joint.b)]
        assert np.abs(ends[1] - ends[0]).max() < 1e-14
    rest, largest = unbalanced(scene, actual)
    for force, moment in rest.values():
        assert np.abs(force).max() < 1e-11 * largest
        assert np.abs(moment).max() < 1e-11 * largest * 0.2


# --- prescribed motion, and what is refused
def test_prescribed_motion_is_exact(validated):
    """Value and derivatives of a law: closed form, to rounding."""
    crank = m.body("crank", {"A": (0, 0)})
    time = np.linspace(0.0, 2.0, 11)
    actual = prescribed(
        cl.Drive(crank, motion=swing(amplitude=2.0, frequency=3.0, offset=1.0)), time
    )
    s, c = np.sin(3.0 * time), np.cos(3.0 * time)
    expected = 1.0 + 2.0 * s + 0.3 * time**2, 6.0 * c + 0.6 * time, -18.0 * s + 0.6
    options = {"source": "closed form", "kind": "exact", "relative": False}
    validated("derivatives of a prescribed motion", actual, expected, 1e-14, **options)
    for drive, start in (
        (cl.Drive(crank, speed=2.0, start=0.5), 0.5),
        (cl.Drive(crank, speed=2.0), -1.0),
    ):
        value, rate, acceleration = prescribed(drive, time, start=-1.0)
        np.testing.assert_array_equal(value, start + 2.0 * time)
        assert (rate == 2.0).all()
        assert not acceleration.any()
    with pytest.raises(ValueError, match="Drive crank: gives a torque or force"):
        prescribed(cl.Drive(crank, torque=1.0), time)


def test_refused():
    """Clearance, efforts, other numbers of motions, wrong times and poses are refused by name."""
    scene = four_bar()
    crank, rod, rocker = scene.bodies
    time = np.linspace(0.0, 1.0, 5)
    with pytest.raises(ValueError, match="joint B: inverse dynamics takes no joint with clearance"):
        inverse(load_case("four_bar", model="lubricated", joints="B,C"), time)
    with pytest.raises(
        ValueError, match="Drive crank: gives a torque or force; inverse dynamics takes a speed"
    ):
        inverse(m.pushed_four_bar(), time)
    with pytest.raises(
        ValueError,
        match=r"1 motion\(s\) missing: the joints leave 1 free .* prescribed are 0 "
        r"\(none\)",
    ):
        inverse(cl.Scene(*scene.joints), time)
    with pytest.raises(
        ValueError, match=r"1 motion\(s\) too many: .* prescribed are 2 \(crank, second\)"
    ):
        inverse(
            cl.Scene(*scene.joints, *scene.loads, cl.Drive(rocker, speed=1.0, name="second")), time
        )
    for wrong in ([], [[0.0]], [0.0, 0.0], [0.0, math.nan], [1.0, 0.5]):
        with pytest.raises(ValueError, match="time must be increasing finite numbers"):
            inverse(scene, wrong)
    with pytest.raises(ValueError, match=r"time must not be negative without poses.*-1"):
        inverse(scene, [-1.0, 0.0])
    with pytest.raises(
        ValueError, match=r"poses must be finite, of shape \(5, 3, 3\) .* got shape \(5, 3\)"
    ):
        inverse(scene, time, np.zeros((5, 3)))


def test_friction_out_of_the_plane_needs_arms():
    """A pin that carries an axial force has a face it rubs on; a self-aligning one carries none."""
    law = joint_coulomb(coefficient=0.1)
    for given_arms, missing in (({}, "friction_arm"), ({"friction_arm": 0.01}, "bending_arm")):
        scene = four_bar(
            gravity=(0.0, -9.81, 1.0), aligning="C", friction=law, pin_radius=0.01, **given_arms
        )
        with pytest.raises(
            ValueError,
            match=rf"joint A: carries loads out of the plane.*joint_coulomb needs "
            rf"{missing}",
        ):
            inverse(scene, np.array([0.0, 0.1]))
