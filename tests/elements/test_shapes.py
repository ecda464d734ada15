"""Bars and plates: their mass properties against other formulas."""

import math

import numpy as np
import pytest

import clearance as cl

DENSITY = cl.steel.density


@pytest.mark.parametrize("section", ["12mm", (0.004, "20 mm")])
def test_users34_a_bar(section):
    """Mass and moment of inertia by summing slices, to 1e-6 of 2000 slices in each direction."""
    bar = cl.Body.bar("rod", {"B": -0.05, "C": 0.07, "D": 0.0}, section, length=0.16)
    x = 0.01 + (np.arange(2000) + 0.5) / 2000 * 0.16 - 0.08
    y = (np.arange(2000) + 0.5) / 2000 - 0.5
    if isinstance(section, tuple):
        area, square = 0.004 * 0.02, np.mean((0.02 * y) ** 2)
    else:
        width = np.sqrt(0.25 - y**2)
        area, square = math.pi / 4.0 * 0.012**2, np.sum(width * (0.012 * y) ** 2) / width.sum()
    mass = DENSITY * area * 0.16
    assert bar.mass == pytest.approx(mass, rel=1e-12)
    assert bar.inertia == pytest.approx(mass * (np.mean((x - 0.01) ** 2) + square), rel=1e-6)
    assert bar.com == pytest.approx((0.01, 0.0), abs=1e-15)
    assert bar["C"].x == 0.07


@pytest.mark.parametrize("seed", range(5))
def test_users34_a_plate(seed):
    """A triangle by closed forms, turned either way; a hole by superposition (rounding)."""
    rng = np.random.default_rng(seed)
    corners = rng.uniform(-0.2, 0.2, (3, 2))
    a, b = corners[1] - corners[0], corners[2] - corners[0]
    area = 0.5 * abs(a[0] * b[1] - a[1] * b[0])
    centre = corners.mean(axis=0)
    plate = cl.Body.plate("cam", [tuple(c) for c in corners], 0.01, points={"A": (0, 0)})
    mass = DENSITY * 0.01 * area
    inertia = mass * ((corners - centre) ** 2).sum() / 12.0
    assert plate.mass == pytest.approx(mass, rel=1e-12)
    assert plate.com == pytest.approx(tuple(centre), abs=1e-13)
    assert plate.inertia == pytest.approx(inertia, rel=1e-9)
    radius = 0.2 * math.sqrt(area)
    holed = cl.Body.plate("cam", [tuple(c) for c in corners], 0.01, holes=[(*centre, radius)])
    disc = DENSITY * 0.01 * math.pi * radius**2
    assert holed.mass == pytest.approx(mass - disc, rel=1e-12)
    assert holed.inertia == pytest.approx(inertia - 0.5 * disc * radius**2, rel=1e-8)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: cl.Body.bar("b", {"A": 0.0}, 0.01), "body b: length must be positive"),
        (lambda: cl.Body.bar("b", {"A": 0, "B": 1}, -0.01), "body b: section must be positive"),
        (lambda: cl.Body.bar("b", {"A": 0, "B": 1}, (1, 2, 3)), "a diameter, or width and height"),
        (lambda: cl.Body.plate("b", [(0, 0), (1, 0)], 0.01), "leave an area of 0 m2"),
        (
            lambda: cl.Body.plate("b", [(0, 0), (1, 0), (0, 1)], 0.01, holes=[(0, 0, 1)]),
            "leave an area of -",
        ),
    ],
)
def test_impossible_shapes_are_refused(make, words):
    """By the name of the body and of the size."""
    with pytest.raises(ValueError, match=words):
        make()


def test_users31_materials_of_bearings():
    """Steel is that of the package; each has a source and, where it is known, a range of wear that
    the law of Archard takes; a scene file names them.
    """
    assert cl.Material.named("steel") == cl.steel
    for row in cl.Material.table().values():
        assert 1e7 < row.hardness < 1e10
        assert row.source
        assert row.wear is None or [cl.archard(coefficient=k) for k in row.wear]
    with pytest.raises(ValueError, match=r"did you mean bronze\?"):
        cl.Material.named("bronce")


def test_users31_a_scene_file_names_a_material(tmp_path):
    """`material = "bronze"` needs no table."""
    path = tmp_path / "rig.toml"
    path.write_text(
        """[body]
bob = { mass = "0.5 kg", inertia = 1e-3, points = { P = [0, "0.2 m"] } }
[joint.P]
kind = "ClearanceRevolute"
a = "ground"
b = "bob.P"
radius = "10 mm"
clearance = "0.1 mm"
length = "20 mm"
material = "bronze"
contact = "liu"
"""
    )
    (joint,) = cl.load_case(path).joints
    assert joint.material == cl.Material.named("bronze")


def test_users32_roughness_of_two_surfaces():
    """Ra counts sqrt(pi / 2) times, and both surfaces together are a root of squares (rounding)."""
    wanted = math.sqrt(math.pi / 2.0) * math.hypot(0.4e-6, 0.8e-6)
    assert cl.composite_roughness("Ra 0.4 um", "Ra 0.8 um") == pytest.approx(wanted, rel=1e-15)
    assert cl.composite_roughness(3e-7, "Rq 0.4um") == pytest.approx(5e-7, rel=1e-15)
    scene = cl.load_case("six_bar_feeder", model="mixed", roughness="Ra0.4um+Ra0.8um")
    (joint,) = scene.clearance_joints
    assert joint.roughness == pytest.approx(wanted, rel=1e-15)


@pytest.mark.parametrize(("text", "units"), [("Ra0.4um+1", "m"), ("Ra0.4um", "Pa")])
def test_other_texts_of_roughness_are_refused(text, units):
    """A part without Ra or Rq, and a field that is no length."""
    with pytest.raises(ValueError, match=r"is written as Ra0\.4um\+Ra0\.8um"):
        cl.units.quantity(text, units)
