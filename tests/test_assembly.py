"""Start of undriven mechanisms: free coordinates as the scene gives them, the other bodies moved to
close loops.
"""

import math
from itertools import permutations

import pytest

import clearance as cl
from clearance.mechanism import assembly
from clearance.mechanism import build as building
from clearance.mechanism.assembly import assemble
from clearance.mechanism.build import build
from tests import mechanisms as m

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
    return {body.name: place for body, place in assemble(scene).pose.items()}


@pytest.mark.parametrize("order", [*permutations(range(4))])
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
    bar = m.body("bar", {"O": (0, 0), "P": (0.1, 0)}, angle=math.pi - 0.2)
    rod = m.body("rod", {"P": (0, 0), "Q": (0.12, 0)}, angle=0.4)
    lever = m.body("lever", {"R": (0, 0), "Q": (0.1, 0)}, angle=1.9)
    scene = cl.Scene(
        cl.Revolute(cl.ground, bar["O"], name="A"),
        cl.Revolute(bar["P"], rod["P"], name="B"),
        cl.Revolute(rod["Q"], lever["Q"], name="C"),
        cl.Revolute(cl.ground.at(GROUND, 0), lever["R"], name="D"),
    )
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
