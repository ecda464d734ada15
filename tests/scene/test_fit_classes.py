"""Fits of ISO 286 as clearances: the tables by the formulas they were made of, and their uses."""

import json
import math
import pickle

import numpy as np
import pytest

import clearance as cl
from clearance.cli import main
from clearance.values.fit_class import ABOVE, BELOW, FINE, STEPS, TOLERANCES, fit_class

#: steps of 3 mm and less count as 1 to 3
LOWER = (1, *STEPS[:-1])
#: fundamental deviations [um] of the mean diameter of a step [mm] (ISO 286-1, annex B of 1988)
FORMULAS = {
    "d": lambda d: 16.0 * d**0.44,
    "e": lambda d: 11.0 * d**0.41,
    "f": lambda d: 5.5 * d**0.41,
    "g": lambda d: 2.5 * d**0.34,
    "n": lambda d: 5.0 * d**0.34,
}


def middle(low, high):
    """Geometric mean of a step [mm]."""
    return math.sqrt(low * high)


@pytest.mark.parametrize("grade", list(TOLERANCES))
def test_standard_tolerances_follow_their_formula(grade):
    """7, 10, 16, 25, 40, 64, 100 times i = 0.45 D^(1/3) + 0.001 D, rounded: to 5 % and half a
    micrometre; up to 3 mm the standard is coarser, by 16 %.
    """
    times = {5: 7.0, 6: 10.0, 7: 16.0, 8: 25.0, 9: 40.0, 10: 64.0, 11: 100.0}[grade]
    d = np.array([middle(*ends) for ends in zip(LOWER, STEPS, strict=True)])
    shares = TOLERANCES[grade] / (times * (0.45 * np.cbrt(d) + 0.001 * d))
    assert shares[0] == pytest.approx(1.08, abs=0.08)
    assert shares[1:] == pytest.approx(1.0, abs=0.1 if grade < 7 else 0.05)


@pytest.mark.parametrize("letter", list(FORMULAS))
def test_deviations_follow_their_formula(letter):
    """To 4 % from 3 mm on, to 2 um below: the standard rounds."""
    table = np.array((BELOW | ABOVE)[letter])
    d = np.array([middle(*ends) for ends in zip(LOWER, STEPS, strict=True)])
    expected = FORMULAS[letter](d)
    assert table[1:] == pytest.approx(expected[1:], rel=0.04)
    assert table[0] == pytest.approx(expected[0], abs=2.1)


def test_deviations_of_finer_steps():
    """c: 52 D^0.2 up to 40 mm, to 15 %, then 95 + 0.8 D to 3 %; s: IT8 + 1 to 4 up to 50 mm, then
    IT7 + 0.4 D; r: geometric mean of p and s; both to 1 um.
    """
    lower = (1, *FINE[:-1])
    d = np.array([middle(*ends) for ends in zip(lower, FINE, strict=True)])
    thin = d < 40.0
    assert np.array(BELOW["c"])[thin] == pytest.approx(52.0 * d[thin] ** 0.2, rel=0.15)
    assert np.array(BELOW["c"])[~thin] == pytest.approx(95.0 + 0.8 * d[~thin], rel=0.03)
    coarse = [np.searchsorted(STEPS, end) for end in FINE]
    seven, eight = (np.array(TOLERANCES[g])[coarse] for g in (7, 8))
    s, p = np.array(ABOVE["s"]), np.array(ABOVE["p"])[coarse]
    beyond = (s - eight)[d < 50.0]
    assert beyond.min() >= 0
    assert beyond.max() <= 4
    assert s[d > 50.0] == pytest.approx((seven + 0.4 * d)[d > 50.0], abs=1.0)
    assert ABOVE["r"] == pytest.approx(np.sqrt(p * s), abs=1.2)


def test_deviations_near_the_zero_line():
    """m: IT7 - IT6; p: IT7 to IT7 + 5; both from 3 mm on; k: 0.6 D^(1/3) to 1 um."""
    grades = np.array(TOLERANCES[7]) - TOLERANCES[6]
    assert ABOVE["m"][1:] == tuple(grades[1:].tolist())
    beyond = np.array(ABOVE["p"]) - TOLERANCES[7]
    assert beyond[1:].min() >= 0
    assert beyond.max() <= 5
    k = [0.6 * middle(*ends) ** (1 / 3) for ends in zip(LOWER, STEPS, strict=True)]
    assert ABOVE["k"] == pytest.approx(k, abs=1.0)


@pytest.mark.parametrize(
    ("name", "diameter", "smallest", "largest"),
    [
        ("H7/f7", 20e-3, 20, 62),
        ("H7/g6", 25e-3, 7, 41),
        ("H7/h6", 30e-3, 0, 34),
        ("H8/f7", 50e-3, 25, 89),
        ("H9/d9", 80e-3, 100, 248),
        ("H11/c11", 40e-3, 120, 440),
        ("H11/c11", 40.001e-3, 130, 450),
        ("H8/e8", 500e-3, 135, 329),
    ],
)
def test_published_fits(name, diameter, smallest, largest):
    """Clearances of the diameters in micrometres as handbooks have them; radial ones are half."""
    fit = fit_class(name, diameter)
    assert [1e6 * v for v in fit.diametral] == pytest.approx([smallest, largest])
    assert [2e6 * v for v in (fit.smallest, fit.largest)] == pytest.approx([smallest, largest])
    assert fit.smallest < fit.mean < fit.largest
    assert cl.fit_class(f"{name}@{1e3 * diameter:.9g}mm") == fit


@pytest.mark.parametrize(
    ("name", "diameter", "message"),
    [
        ("H7/k6", 20e-3, "no clearance for sure: k6 interferes by up to 15 um"),
        ("H8/k8", 20e-3, "k8 interferes by up to 33 um"),
        ("H7/js6", 20e-3, "js6 interferes by up to 6.5 um"),
        ("H7/s6", 70e-3, "s6 interferes by up to 78 um"),
        ("H7/f7", None, "needs a diameter: H7/f7@20mm"),
        ("H7/f7", 0.6, "up to 500 mm"),
        ("H12/f7", 20e-3, "grade 12 is not one of 5 to 11"),
        ("H7/z6", 20e-3, "no shaft 'z'"),
        ("F7/h6", 20e-3, "no fit of the hole basis"),
    ],
)
def test_what_is_no_clearance_fit(name, diameter, message):
    """Each message names class and value."""
    with pytest.raises(ValueError, match=message):
        fit_class(name, diameter)


@pytest.mark.parametrize(("case", "nominal"), [("slider_crank", 20e-3), ("six_bar_feeder", 20e-3)])
def test_cases_take_a_fit_at_the_diameter_of_their_joint(case, nominal):
    """The mean clearance; in one case bearings keep their radius, in the other journals do."""
    scene = cl.load_case(case, model="dry", clearance="H7/f7")
    (joint,) = scene.clearance_joints
    assert joint.clearance == fit_class("H7/f7", nominal).mean == pytest.approx(20.5e-6)
    value = pickle.loads(pickle.dumps(scene.parameters["clearance"]))
    assert value.fit == fit_class("H7/f7", nominal)  # workers get scenes
    with pytest.raises(ValueError, match=r"not a number"):
        cl.load_case(case, model="dry", speed="H7/f7")
    with pytest.raises(ValueError, match=r"k6 interferes"):
        cl.load_case(case, model="dry", clearance="H7/k6")


def test_a_run_prints_the_limits(tmp_path, monkeypatch, capsys):
    """Its given parameters have class, diameter and limits; numbers of a scene take a fit too."""
    monkeypatch.chdir(tmp_path)
    call = ["run", "slider_crank", "-p", "clearance=H7/f7", "-p", "film=short", "--turns", "0.05"]
    assert main([*call, "-p", "model=lubricated"]) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert "H7/f7 at 20 mm: radial clearance 10 to 31 um, mean 20.5 um" in text
    assert main([*call, "-p", "model=lubricated", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["parameters"]["clearance"] == pytest.approx(20.5e-6)


@pytest.mark.slow
def test_sweeps_and_scatters_take_a_fit(tmp_path):
    """A sweep has limits and mean; a scatter draws from between the limits, with the deviation of
    independent hole and shaft within 10 %, what 32 points give.
    """
    case = ["six_bar_feeder", "-p", "film=short", "-p", "clearance=H7/f7", "--turns", "1"]
    aside = ["--quiet", "--workers", "1", "-o"]
    assert main(["sweep", *case, "--channels", "none", *aside, str(tmp_path / "sweep")]) == 0
    swept = cl.open_sweep(tmp_path / "sweep")
    assert swept.columns["clearance"] == pytest.approx([10e-6, 20.5e-6, 31e-6])
    assert main(["scatter", *case, "--points", "48", *aside, str(tmp_path / "scatter")]) == 0
    drawn = cl.open_scatter(tmp_path / "scatter").sweep.columns["clearance"]
    assert 10e-6 < drawn.min() < drawn.max() < 31e-6
    assert drawn.std() == pytest.approx(21e-6 / math.sqrt(2.0) / 6.0, rel=0.1)
