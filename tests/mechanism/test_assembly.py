"""Start of undriven mechanisms: free coordinates as the scene gives them, the other bodies moved to
close loops.
"""

import json
import math
import random
from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest

import clearance as cl
from clearance.mechanism import assembly
from clearance.mechanism import build as building
from clearance.mechanism.assembly import assemble
from clearance.mechanism.build import build
from tests import mechanisms as m
from tests.random_scenes import draw
from tests.relations import Shifted
from tests.seeds import few_of

CRANK, ROD, GROUND = 0.05, 0.15, 0.13


def engine(order, *loads, angle=0.4):
    """Crank, rod and piston without a prescribing drive; the joints in this order."""
    crank = m.body("crank", {"O": (0, 0), "P": (CRANK, 0)}, angle=angle)
    rod = m.body("rod", {"P": (0, 0), "Q": (ROD, 0)}, com=(0.06, 0.01))
    piston = m.body("piston", {"Q": (0, 0)})
    joints = [
        cl.Revolute(cl.ground, crank["O"], name="A"),
        cl.Revolute(crank["P"], rod["P"], name="B"),
        cl.Revolute(rod["Q"], piston["Q"], name="C"),
        cl.Prismatic(cl.ground, piston["Q"], name="G"),
    ]
    return cl.Scene(*(joints[i] for i in order), *(load(crank, joints) for load in loads))


def pose(scene):
    """Poses of the start by the bodies' names."""
    return {body.name: position for body, position in assemble(scene).pose.items()}


@pytest.mark.parametrize("order", few_of([*permutations(range(4))][::-1], 6))
def test_crank_as_given(order):
    """The crank to the last digit, the piston by geometry (closing error, 1e-12 of the size),
    whatever the order.
    """
    start = pose(engine(order))
    assert start["crank"][2] == 0.4
    x = CRANK * math.cos(0.4) + math.sqrt(ROD**2 - (CRANK * math.sin(0.4)) ** 2)
    assert start["piston"][:2] == pytest.approx((x, 0.0), abs=1e-12)


@pytest.mark.parametrize("order", [*permutations(range(2))])
def test_cart_and_pole(order):
    """A cart given off its rail goes straight to it; its place along it and the pole's angle stay
    as they are (rounding).
    """
    cart = m.body("cart", {"P": (0, 0)}, position=(0.3, 0.02))
    pole = m.body("pole", {"P": (0, 0), "Q": (0.4, 0)}, angle=-1.2, com=(0.2, 0.0))
    joints = (
        cl.Prismatic(cl.ground, cart["P"], name="rail"),
        cl.Revolute(cart["P"], pole["P"], name="pin"),
    )
    start = pose(cl.Scene(*(joints[i] for i in order)))
    assert start["cart"] == pytest.approx((0.3, 0.0, 0.0), abs=1e-14)
    assert start["pole"] == pytest.approx(
        (0.3 + 0.2 * math.cos(-1.2), 0.2 * math.sin(-1.2), -1.2), abs=1e-14
    )


@pytest.mark.parametrize("offset", [(0.0, 0.0), (2e-5, 1e-5), (1e-3, 0.0)])
def test_pendulum_with_clearance(offset):
    """It keeps its angle to the last digit and is moved by the eccentricity (rounding)."""
    bar = m.body("bar", {"top": (0, 0.18)}, angle=1.0)
    joint = m.dry(cl.ground, bar["top"], "J", clearance=2e-3, eccentricity=offset)
    x, y, angle = pose(cl.Scene(joint))["bar"]
    assert angle == 1.0
    assert (x, y) == pytest.approx(
        (offset[0] + 0.18 * math.sin(1.0), offset[1] - 0.18 * math.cos(1.0)), abs=1e-15
    )


def test_given_by_a_drive():
    """The start of a drive that pushes comes before the body's own angle, be it of the body or of a
    hinge (1e-12).
    """
    for target in (lambda crank, joints: crank, lambda crank, joints: joints[0]):
        scene = engine(range(4), lambda c, j, t=target: cl.Drive(t(c, j), torque=0.0, start=0.7))
        assert pose(scene)["crank"][2] == pytest.approx(0.7, abs=1e-12)


def test_one_of_two_by_a_drive():
    """Two bars, a torque whose start is the angle between them: the first keeps its own angle
    (1e-12).
    """
    first = m.body("first", {"O": (0, 0), "P": (0.3, 0)}, angle=0.7)
    second = m.body("second", {"P": (0, 0)}, angle=-0.4, com=(0.1, 0.0))
    elbow = cl.Revolute(first["P"], second["P"], name="B")
    drive = cl.Drive(elbow, torque=0.0, start=0.5)
    start = pose(cl.Scene(cl.Revolute(cl.ground, first["O"], name="A"), elbow, drive))
    assert start["first"][2] == pytest.approx(0.7, abs=1e-12)
    assert start["second"][2] == pytest.approx(1.2, abs=1e-12)


def test_out_of_reach():
    """A bar at an angle where its loop cannot close is turned until it does, as before."""
    bar, rod = m.bar("bar", 0.1, math.pi - 0.2), m.bar("rod", 0.12, 0.4)
    scene = cl.Scene(*m.loop(bar, rod, m.bar("lever", 0.1, 1.9), GROUND))

    angle = pose(scene)["bar"][2]
    far = math.hypot(0.1 * math.cos(angle) - GROUND, 0.1 * math.sin(angle))
    assert far <= 0.22 + 1e-12
    assert abs(angle - (math.pi - 0.2)) > 0.1


@pytest.mark.parametrize("values", [{"angle": 0.5}, {"speed": 20.0}])
def test_shared_positions(values):
    """A scene of a structure seen before starts as it does in a fresh process, bit by bit; another
    angle moves it.
    """

    def built(angle=0.4, speed=10.0):
        scene = engine(range(4), lambda crank, _: cl.Drive(crank, speed=speed), angle=angle)
        return build(scene)

    first = built()
    shared = built(**values)
    for memory in (assembly._positions, building._planned):
        memory.clear()
    alone = built(**values)
    assert [*shared.start.pose.values()] == [*alone.start.pose.values()]
    assert [*shared.start.velocity.values()] == [*alone.start.velocity.values()]
    assert shared.par.tolist() == alone.par.tolist()
    assert [*shared.start.pose.values()] != [*first.start.pose.values()] or "angle" not in values


def branch(rng, rates, scale=1.0, off=0.0, halves=False):
    """A random tree of hinged bars; rates: of each, or None. off: shift of the centres of mass;
    halves: each bar is two that are welded, of which the outer one has the rate.
    """
    parts, ends = [], [cl.ground.at(0.0, 0.0)]
    for i, rate in enumerate(rates):
        length, angle, seat = (
            scale * rng.uniform(0.1, 1.0),
            rng.uniform(-3, 3),
            rng.integers(len(ends)),
        )
        tips = {"o": (0.0, 0.0), "p": (length, 0.1 * length)}
        more = {"com": (0.5 * length + scale * off, scale * off), "angle": angle}
        bar = cl.Body(f"bar{i}", 1.0, 0.01, points=tips, angular_velocity=rate, **more)
        if halves:
            inner = cl.Body(f"inner{i}", 1.0, 0.01, points=tips, **more)
            parts += [
                cl.Revolute(ends[seat], inner["o"], name=f"J{i}"),
                cl.Weld(inner["p"], bar["p"], name=f"W{i}"),
            ]
        else:
            parts.append(cl.Revolute(ends[seat], bar["o"], name=f"J{i}"))
        ends.append(bar["p"])
    return cl.Scene(*parts)


@pytest.mark.parametrize("seed", few_of(range(20), 5))
def test_ranges3_a_body_without_a_given_rate_rests_on_its_carrier(seed):
    """Random trees in which some rates are given, some are 0 and some are none: each body has its
    own or that of its carrier, wherever the centres of mass are, in any unit, in one or welded of
    halves. Rounding of some ten equations: 1e-12.
    """
    draw = np.random.default_rng(seed)
    drawn = [(None, None, 0.0, 1e-300, draw.uniform(-9, 9))[draw.integers(5)] for _ in range(5)]
    for more in ({}, {"off": 0.3}, {"scale": 1e3}, {"scale": 1e-3}, {"halves": True}):
        scene = branch(np.random.default_rng(seed), drawn, **more)
        rate = {b.name: w[2] for b, w in assemble(scene).velocity.items()}
        for joint in (j for j in scene.joints if j.name[0] == "J"):
            number = int(joint.name[1:])
            wanted = rate[joint.a.body.name] if drawn[number] is None else drawn[number]
            assert rate[f"bar{number}"] == pytest.approx(wanted, abs=1e-12 * 9.0)


@pytest.mark.parametrize("seed", few_of(range(5), 2))
def test_one_given_rate_starts_a_loop(seed):
    """The rate that a four-bar's rocker has by its crank starts the same motion, given alone with
    any body: to 1e-9 of it.
    """
    rng, rates = np.random.default_rng(seed), {}
    angle, speed = rng.uniform(0.3, 2.8), rng.uniform(-9.0, 9.0)
    for giver in ("crank", "rocker", "rod"):
        crank = m.bar("crank", 0.05, angle, com=(0.02, 0.0))
        bodies = crank, m.bar("rod", 0.15, 0.5), m.bar("rocker", 0.12, 1.5)
        rate = {"angular_velocity": rates.get(giver, speed)}
        bodies = (replace(b, **rate) if b.name == giver else b for b in bodies)
        scene = cl.Scene(*m.loop(*bodies, 0.16))

        started = {b.name: w[2] for b, w in assemble(scene).velocity.items()}
        rates = rates or started
        assert started == pytest.approx(rates, rel=1e-9)


@pytest.mark.parametrize("seed", few_of(range(24), 6))
def test_a_crank_that_is_pushed_starts_at_its_angle(seed):
    """Of a four-bar whose given angles do not close, in any order of its joints, with each of its
    bars in one or welded of halves: rounding of a turn.
    """
    rng, halves = np.random.default_rng(seed), np.random.default_rng(seed).integers(3)
    parts, ends, angles = [], {}, rng.uniform([0.6, 0.2, 1.2], [1.6, 0.6, 1.8])
    for i, (name, length) in enumerate([("crank", 0.05), ("rod", 0.15), ("rocker", 0.12)]):
        first = other = m.bar(name, length, angles[i])

        if i == halves:
            other = replace(first, name="half")
            parts.append(cl.Weld(first["b"], other["b"], name="W"))
        ends[name] = first["a"], other["b"], first
    pairs = [(cl.ground, ends["crank"][0]), (ends["crank"][1], ends["rod"][0])]
    pairs += [(ends["rod"][1], ends["rocker"][1]), (cl.ground.at(0.16, 0), ends["rocker"][0])]
    parts += [cl.Revolute(*pair, name=f"J{i}") for i, pair in enumerate(pairs)]
    drive = cl.Drive(ends["crank"][2], torque=cl.motor_line(stall=1.0, no_load=9.0))
    scene = cl.Scene(*(parts[i] for i in rng.permutation(len(parts))), drive)
    angle = {b.name: pose[2] for b, pose in assemble(scene).pose.items()}["crank"]
    assert angle == pytest.approx(angles[0], abs=1e-14)


@pytest.mark.parametrize("seed", few_of(range(20), 5))
def test_a_start_that_gives_way_has_no_unit_and_no_origin(seed):
    """A slider-crank whose given angles do not close, with rates that contradict each other: it
    starts alike in any unit of length and wherever the world's origin is. Rounding of places
    1e3 units from the origin, where Newton's steps grow it: 1e-9.
    """
    rng, starts = np.random.default_rng(seed), []
    angle, far, rate, speed = rng.uniform([2.0, 0.38, -9.0, -9.0], [3.1, 0.5, 9.0, 9.0])
    for unit, x, y in [(1.0, 0.0, 0.0), (10.0 ** rng.uniform(-4, 3), *rng.uniform(-1e3, 1e3, 2))]:
        crank = m.bar("crank", unit, angle, inertia=1.0, angular_velocity=rate)
        rod = m.bar("rod", 3.0 * unit, far, inertia=1.0)
        block = cl.Body("block", 1.0, 1.0, velocity=(speed * unit, 0.0))
        joints = m.crank_and_slider(crank, rod, block, at=(x * unit, y * unit))
        scene = cl.Scene(*joints, cl.Drive(rod, torque=0.0))

        start, bodies = assemble(scene), (crank, rod)
        starts.append([start.pose[b][2] for b in bodies] + [start.velocity[b][2] for b in bodies])
    assert starts[1] == pytest.approx(starts[0], abs=1e-9, rel=1e-9)


def test_ranges3_documents_tell_a_rate_of_0_from_none():
    """JSON keeps both; in a document of an older version a rate of 0 was none."""
    free = cl.Body("free", 1.0, 0.01)
    still = cl.Body("still", 1.0, 0.01, angular_velocity=0.0, velocity=(0.0, 0.0))
    scene = cl.Scene(cl.Revolute(cl.ground, free), cl.Revolute(cl.ground, still, name="B"))
    text = scene.to_json()
    rates = [(b.angular_velocity, b.velocity) for b in cl.Scene.from_json(text).bodies]
    assert rates == [(None, None), (0.0, (0.0, 0.0))]
    older = json.loads(text)
    del older["rates"]
    rates = [(b.angular_velocity, b.velocity) for b in cl.Scene.from_json(json.dumps(older)).bodies]
    assert rates == [(None, None), (None, None)]


def pushed(near, size, mass, ratio):
    """A slider-crank that its slide drives from near the stretched position."""
    parts = {}
    for name, length, angle in (
        ("crank", size, near),
        ("rod", ratio * size, -math.asin(math.sin(near) / ratio)),
    ):
        inertia = mass * length**2 / 12.0
        parts[name] = m.bar(name, length, angle, mass, inertia, com=(length / 2, 0))
    joints = m.crank_and_slider(*parts.values(), cl.Body("block", mass, mass * size**2))
    start = size * (math.cos(near) + math.sqrt(ratio**2 - math.sin(near) ** 2))
    return cl.Scene(*joints, cl.Drive(joints[-1], speed=-size, start=start))


@pytest.mark.parametrize("seed", few_of(range(24), 6))
def test_ranges5_a_slide_cannot_begin_at_a_stretched_crank(seed):
    """Refused by that name where rounding would decide on the rates, 1e-16 / near^2 of them; else
    complete, with less than 1e-4 of the energy missing. The band ends between 1e-6 and 3e-5 rad,
    which depends on the ratio of the links.
    """
    rng = np.random.default_rng(seed)
    near = 0.0 if seed == 0 else 10.0 ** rng.uniform(-12.0, -2.0)
    size, mass = 10.0 ** rng.uniform(-3.0, 1.0), 10.0 ** rng.uniform(-2.0, 2.0)
    scene = pushed(near, size, mass, rng.uniform(1.5, 6.0))
    options = {"until": 1.0, "samples": 101, "error": None}
    if near < 3e-5:
        try:
            run = cl.simulate(scene, **options)
        except ValueError as reason:
            text = str(reason)
        else:
            assert near > 1e-6
            assert run.solver["energy_residual_share"] < 1e-4
            return
        assert "singular position: Drive G cannot begin where joint O" in text
    else:
        run = cl.simulate(scene, **options)
        assert run.solver["energy_residual_share"] < 1e-4


@pytest.mark.parametrize("seed", few_of(range(40), 8))
def test_natural_sizes_do_not_depend_on_the_origin(seed):
    """Random scenes whose world begins up to a hundred sizes away: rounding of places, 1e-12 of
    them. Beside a mass on a slide 10 m away errors of rates were 600 times those at the origin.
    """
    scene = draw(seed).scene
    moved = Shifted(random.Random(seed), scene).of(scene)
    here, there = build(scene), build(moved)
    assert there.start.size == pytest.approx(here.start.size, rel=1e-12)
    assert there.scale == pytest.approx(here.scale, rel=1e-9)
    assert there.energy == pytest.approx(here.energy, rel=1e-9)
