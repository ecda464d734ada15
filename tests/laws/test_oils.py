"""Oils by grade and temperature."""

import math

import pytest

import clearance as cl
from clearance.laws import oils
from clearance.laws.film import thinning

#: paraffinic machine oils at 30, 60, 100 C: viscosity [mPa s] and pressure-viscosity coefficient
#: [1e-9 /Pa], Stachowiak and Batchelor, Engineering Tribology, table 2.3
PARAFFINIC = ((12.1, 18.4), (5.3, 13.4), (153.0, 23.7), (34.0, 20.5), (9.1, 15.8), (250.0, 25.0))


def kinematic(name: str, temperature: float) -> float:
    """[mm2/s]."""
    return 1e6 * cl.oil(name, temperature=temperature).viscosity / oils.density(temperature)


@pytest.mark.parametrize("name", oils.GRADES)
def test_grades(name):
    """Each has the viscosity that defines it, to rounding, and thins all the way."""
    at, wanted = oils.GRADES[name]
    assert kinematic(name, at) == pytest.approx(wanted, rel=1e-12)
    if name.startswith("SAE"):
        low, high = oils.SAE[int(name.split()[1])]
        assert low < kinematic(name, 100.0) < high
    falling = [cl.oil(name, temperature=t).viscosity for t in range(-10, 151, 10)]
    assert falling == sorted(falling, reverse=True)


@pytest.mark.parametrize(
    ("name", "wanted"), [("ISO VG 32", 5.4), ("ISO VG 46", 6.8), ("ISO VG 68", 8.8)]
)
def test_hot(name, wanted):
    """At 100 C as oils of a viscosity index of about 100: 3 %."""
    assert kinematic(name, 100.0) == pytest.approx(wanted, rel=0.03)


def test_between():
    """At 60 and 80 C within 4 % of ASTM D341's straight line through the viscosities at 40 and 100
    C.
    """
    for name in ("ISO VG 10", "ISO VG 46", "ISO VG 460"):
        ends = [(math.log10(t + 273.15), kinematic(name, t)) for t in (40.0, 100.0)]
        (cold, thick), (hot, thin) = ((x, math.log10(math.log10(v + 0.7))) for x, v in ends)
        for t in (60.0, 80.0):
            share = (math.log10(t + 273.15) - cold) / (hot - cold)
            line = 10.0**10.0 ** (thick + share * (thin - thick)) - 0.7
            assert kinematic(name, t) == pytest.approx(line, rel=0.04)


def test_pressure_viscosity():
    """Within 20 % of measured paraffinic oils; it falls with the temperature."""
    for viscosity, wanted in PARAFFINIC:
        assert oils.coefficient(1e-3 * viscosity) == pytest.approx(1e-9 * wanted, rel=0.2)
    cold, hot = (cl.oil("SAE 30", temperature=t).pressure_viscosity for t in (40.0, 120.0))
    assert 1e-8 < hot < cold < 3e-8
    assert oils.coefficient(1e-5) == 0.0


def test_names():
    """A grade in usual spellings; a text of the command line with its temperature, K too."""
    wanted = cl.oil("ISO VG 46", temperature=60.0)
    for name in ("iso-vg-46", "ISO_VG 46", "VG46", "vg 46"):
        assert cl.oil(name, temperature=60) == wanted
    for text in ("ISO-VG-46@60C", "VG46 @ 60", "ISO VG 46@333.15K", "vg46@60 degC"):
        assert oils.oil_named(text).viscosity == pytest.approx(wanted.viscosity, rel=1e-12)
    assert cl.oil("ISO VG 46", temperature="60 °C") == wanted
    assert oils.oil_named("SAE-30") == cl.oil("SAE 30", temperature=100.0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("ISO-VG-47@60C", "no grade 'ISO-VG-47'"),
        ("SAE 10W-40", "no grade"),
        ("ISO-VG-46@600C", r"must lie in \[-10, 150\]"),
        ("ISO-VG-46@hot", "as 60C; got 'hot'"),
        ("ISO-VG-46@", "as 60C; got ''"),
        ("@60C", "no grade ''"),
    ],
)
def test_refusals(text, message):
    """One line that names the field and its value."""
    with pytest.raises(ValueError, match=message):
        oils.oil_named(text)


def test_heat():
    """The balance of an oil thins as the oil does, to rounding."""
    heat = cl.oil_heat("ISO VG 68", temperature=50.0, capacity=1.0, conductance=0.5)
    cold, warm = (cl.oil("ISO VG 68", temperature=t).viscosity for t in (50.0, 80.0))
    assert thinning(30.0, heat.surroundings, heat.vogel, heat.vogel_zero) == pytest.approx(
        warm / cold, rel=1e-12
    )


def test_in_a_case():
    """An option of cases, in place of the viscosity."""
    scene = cl.load_case("six_bar_feeder", oil="ISO-VG-46@60C")
    joint = next(j for j in scene.joints if j.name == "B")
    assert joint.lubricant == cl.oil("ISO VG 46", temperature=60.0)
    with pytest.raises(ValueError, match="joint B: oil: no grade"):
        cl.load_case("six_bar_feeder", oil="honey")
