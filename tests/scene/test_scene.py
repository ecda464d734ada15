"""Descriptions: what is wrong is refused at once, naming the field and the value."""

import json

import pytest

import clearance as cl
from clearance.mechanism.build import build
from tests import mechanisms as m


def bar(name="bar", length=0.1, **more):
    return m.bar(name, length, inertia=1e-3, **more)


@pytest.mark.parametrize(
    ("field", "more"),
    [
        ("body bar: mass must be positive, got -1", {"mass": -1}),
        ("body bar: mass must be positive, got 0", {"mass": 0}),
        ("body bar: inertia must be positive, got 0", {"inertia": 0.0}),
        ("body bar: mass must be finite, got nan", {"mass": float("nan")}),
        ("body bar: com must be a pair", {"com": 3.0}),
        ("body bar: point 'a' must be a pair", {"points": {"a": (1, 2, 3, 4)}}),
        (
            r"body bar: point 'a'\[2\] must be finite, got nan",
            {"points": {"a": (1, 2, float("nan"))}},
        ),
        ("body name must be a non-empty name", {"name": "my/bar"}),
    ],
)
def test_body(field, more):
    """Wrong numbers of a body are refused by field."""
    with pytest.raises((ValueError, TypeError), match=field):
        cl.Body(**{"name": "bar", "mass": 1.0, "inertia": 1.0, **more})


def test_unknown_point_lists_the_known_ones():
    """A wrong point is answered with the right ones."""
    with pytest.raises(KeyError, match="no point 'c'; it has"):
        bar()["c"]


@pytest.mark.parametrize(
    ("message", "more"),
    [
        ("joint J: clearance must be positive, got -0.0001", {"clearance": -1e-4}),
        (
            "joint J: clearance 0.001 m must be smaller than radius 0.0001 m; 0.001 mm",
            {"radius": 1e-4, "clearance": 1e-3},
        ),
        ("joint J: film needs the bearing length", {"length": None}),
        ("joint J: film needs lubricant", {"lubricant": None}),
        ("joint J: a clearance joint needs a contact law, a film, or both", {"film": None}),
        (
            "joint J: contact must be a contact law or None",
            {"contact": cl.coulomb(coefficient=0.1)},
        ),
        (
            "joint J: contact: give lankarani_nikravesh its parameters",
            {"contact": cl.lankarani_nikravesh},
        ),
        ("joint J: friction needs a contact law", {"friction": cl.coulomb(coefficient=0.1)}),
        (
            "joint J: friction needs an asperity law",
            {"film": cl.elastic_film(liner=1e-12), "friction": cl.coulomb(coefficient=0.1)},
        ),
        (
            "joint J: film elastic carries contact itself: leave contact and transition out",
            {"film": cl.elastic_film(liner=1e-12), "contact": cl.hertz(stiffness=1e8)},
        ),
        ("no material 'POMM'", {"material": "POMM"}),
        ("joint J: start eccentricity", {"eccentricity": (1e-4, 0.0)}),
        ("joint J: roughness must be positive", {"roughness": -1.0}),
    ],
)
def test_clearance_joint(message, more):
    """Wrong numbers of a joint are refused by field."""
    good = {
        "radius": 0.01,
        "clearance": 1e-4,
        "length": 0.02,
        "film": cl.pinkus_sternlicht(),
        "lubricant": cl.Lubricant(0.05),
    }
    with pytest.raises((ValueError, TypeError), match=message):
        cl.ClearanceRevolute(cl.ground, bar()["a"], name="J", **{**good, **more})


def test_joint_to_itself():
    """A joint needs two bodies."""
    b = bar()
    with pytest.raises(ValueError, match="joint J joins body 'bar' to itself"):
        cl.Revolute(b["a"], b["b"], name="J")


@pytest.mark.parametrize(
    ("message", "more"),
    [
        ("exactly one of speed, motion, torque, force; got none", {}),
        ("exactly one of", {"speed": 1.0, "torque": 2.0}),
        ("takes no force", {"force": 1.0}),
        ("speed must be finite", {"speed": float("inf")}),
        ("speed_start belongs to a torque or force drive", {"speed": 1.0, "speed_start": 2.0}),
    ],
)
def test_drive(message, more):
    """Wrong numbers of a drive are refused by field."""
    with pytest.raises((ValueError, TypeError), match=message):
        cl.Drive(bar(), **more)


def test_a_material_by_its_name():
    """In Python as in scene files, all of the table."""
    size = {"radius": 0.01, "clearance": 1e-4, "length": 0.02}
    for name in cl.Material.table():
        joint = cl.ClearanceRevolute(
            cl.ground, bar()["a"], **size, contact=cl.winkler(restitution=0.9), material=name
        )
        assert joint.material == cl.Material.named(name)


def test_scene_errors():
    """Doubled names, and parts that nothing holds, are refused."""
    b, other = bar(), bar()
    with pytest.raises(ValueError, match="duplicate body name 'bar'"):
        cl.Scene(
            cl.Revolute(cl.ground, b["a"], name="A"), cl.Revolute(b["b"], other["a"], name="B")
        )
    with pytest.raises(ValueError, match="duplicate joint name 'A'"):
        cl.Scene(
            cl.Revolute(cl.ground, b["a"], name="A"), cl.Revolute(b["b"], bar("c")["a"], name="A")
        )
    with pytest.raises(ValueError, match="Drive c: unknown body 'c'; bodies with joints: bar"):
        cl.Scene(cl.Revolute(cl.ground, b["a"]), cl.Drive(bar("c"), speed=1.0))
    with pytest.raises(
        ValueError, match="floating: no joint, drive or spring connects bar, c with"
    ):
        cl.Scene(cl.Revolute(b["a"], bar("c")["a"]))
    with pytest.raises(TypeError, match="scene parts must be joints"):
        cl.Scene(b)
    with pytest.raises(ValueError, match="no moving body"):
        cl.Scene()


def four_bar(lengths=(0.1, 0.3, 0.25, 0.3)):
    crank, coupler, rocker = (
        bar("crank", lengths[0]),
        bar("coupler", lengths[1], angle=0.8),
        bar("rocker", lengths[2]),
    )
    return *m.loop(crank, coupler, rocker, lengths[3]), cl.Drive(crank, speed=1.0)


def test_open_loop_says_by_how_much():
    """Crank 0.1 at angle 0, coupler 0.05, rocker 0.05, frame 0.3: the pins stay 0.1 m apart in
    all.
    """
    with pytest.raises(ValueError, match="loop cannot close: joint .* m open"):
        build(cl.Scene(*four_bar((0.1, 0.05, 0.05, 0.3))))


def test_locked_and_redundant():
    """Too many drives, and bars that repeat each other, are refused."""
    parts = four_bar()
    with pytest.raises(ValueError, match="locked: .*Drive"):
        build(cl.Scene(*parts, cl.Drive(parts[2].b.body, speed=1.0)))
    crank, coupler, rocker, second = (
        bar(n, x)
        for n, x in zip(["crank", "coupler", "rocker", "second"], (0.1, 0.3, 0.1, 0.1), strict=True)
    )
    parallel = [
        *m.loop(crank, coupler, rocker, 0.3),
        cl.Revolute(cl.ground.at(0.15, 0), second["a"], name="E"),
        cl.Revolute(coupler.at(0.15, 0), second["b"], name="F"),
    ]
    with pytest.raises(ValueError, match="redundant loop: joint"):
        build(cl.Scene(*parallel, cl.Drive(crank, speed=1.0, start=1.0)))
    one, two = bar("one"), bar("two", angle=1.0)
    truss = [
        cl.Revolute(cl.ground.at(0, 0), one["a"], name="A"),
        cl.Revolute(one["b"], two["b"], name="B"),
        cl.Revolute(cl.ground.at(0.1, 0), two["a"], name="C"),
    ]
    with pytest.raises(ValueError, match="locked"):
        build(cl.Scene(*truss, cl.Drive(one, speed=1.0)))


def test_json_holds_every_number():
    """The document has bodies, clearances and laws."""
    scene = m.watt(m.chooser(m.film, "C"))
    document = json.loads(scene.to_json())
    assert {b["name"] for b in document["bodies"]} == {"crank", "coupler", "rocker", "rod", "lever"}
    joint = next(j for j in document["joints"] if j["name"] == "C")
    assert joint["clearance"] == 1e-4
    assert joint["film"] == {"law": "clearance.laws.film:pinkus_sternlicht"}


@pytest.mark.parametrize("make", m.ALL.values(), ids=m.ALL)
def test_assembly_closes_loops(make):
    """Closure to 1e-12 of the size, from rough angles; checked again by the kernels in
    test_mechanics.py.
    """
    scene = make()
    start = build(scene).start
    for joint in scene.joints:
        if hasattr(joint, "axis"):
            continue
        ends = []
        for p in (joint.a, joint.b):
            x, y, angle = start.pose[p.body]
            from math import cos, sin

            lx, ly = p.x - p.body.com[0], p.y - p.body.com[1]
            ends.append(
                (x + cos(angle) * lx - sin(angle) * ly, y + sin(angle) * lx + cos(angle) * ly)
            )
        assert abs(ends[0][0] - ends[1][0]) + abs(ends[0][1] - ends[1][1]) < 2e-12 * start.size


def test_scenes_are_frozen_and_can_be_sent_to_other_processes():
    """A pickled scene is the same; no field can be set."""
    import pickle

    scene = m.watt(m.chooser(m.film, "C"))
    with pytest.raises(AttributeError, match="frozen"):
        scene.gravity = (0.0, 0.0)
    copy = pickle.loads(pickle.dumps(scene))
    assert copy.to_json() == scene.to_json()
    assert build(copy).structure is build(scene).structure
