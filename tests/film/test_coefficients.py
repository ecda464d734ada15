"""Stiffness and damping of a film about a load, against closed forms and the law itself."""

import json
import math

import numpy as np
import pytest

import clearance as cl
from tests.seeds import few_of

SPEED = cl.rpm(3000)


def closed_form(eps: float) -> tuple[np.ndarray, np.ndarray]:
    """Of a short bearing: c K / W and c Omega C / W.

    Source: Friswell et al., Dynamics of Rotating Machines (2010); there the load
    is along the second axis, and the first one points against the sense of rotation.
    """
    e, p = eps * eps, math.pi**2
    root = math.sqrt(1.0 - e)
    h = 1.0 / (p * (1.0 - e) + 16.0 * e) ** 1.5
    uu = 4.0 * (p * (2.0 - e) + 16.0 * e)
    uv = math.pi * (p * (1.0 - e) ** 2 - 16.0 * e * e) / (eps * root)
    vu = -math.pi * (p * (1.0 - e) * (1.0 + 2.0 * e) + 32.0 * e * (1.0 + e)) / (eps * root)
    vv = 4.0 * (p * (1.0 + 2.0 * e) + 32.0 * e * (1.0 + e) / (1.0 - e))
    damping = p * (1.0 + 2.0 * e) - 16.0 * e
    c_uu = 2.0 * math.pi * root * damping / eps
    c_uv = -8.0 * damping
    c_vv = 2.0 * math.pi * (p * (1.0 - e) ** 2 + 48.0 * e) / (eps * root)
    stiffness = h * np.array([[vv, -vu], [-uv, uu]])
    return stiffness, h * np.array([[c_vv, -c_uv], [-c_uv, c_uu]])


def short(seed: int) -> tuple[cl.Bearing, float]:
    """A short bearing and a load that it carries at any eccentricity ratio, drawn at random."""
    rng = np.random.default_rng(seed)
    radius = 10.0 ** rng.uniform(-3, -1)
    bearing = cl.Bearing(radius, radius * 10.0 ** rng.uniform(-3, -2), 0.2 * radius, 0.05)
    rest = cl.short_film().plain(cl.FilmJoint(radius, bearing.clearance, bearing.length, 0.05, 0.0))
    eps = rng.uniform(0.05, 0.98)
    joint = cl.FilmJoint(radius, bearing.clearance, bearing.length, 0.05, 0.0)
    return bearing, math.hypot(*rest(eps, 0.0, SPEED, joint))


@pytest.mark.parametrize("seed", few_of(range(20), 8))
def test_users37_a_short_bearing_has_its_closed_form(seed):
    """Any size and load: within 1e-5 of the largest entry, what the differences state."""
    bearing, load = short(seed)
    film = cl.film_coefficients(bearing, load, SPEED, law=cl.short_film())
    assert film.error < 2e-5
    scales = bearing.clearance / load, bearing.clearance * SPEED / load
    wanted = closed_form(film.eccentricity_ratio)
    for actual, matrix, scale in zip((film.stiffness, film.damping), wanted, scales, strict=True):
        np.testing.assert_allclose(actual * scale, matrix, atol=1e-5 * np.abs(matrix).max())


def test_the_film_pushes_back_along_the_load():
    """At rest the force on the journal is minus the load, which presses along x (rounding)."""
    bearing, load = short(0)
    film = cl.film_coefficients(bearing, load, SPEED, law=cl.short_film())
    joint = cl.FilmJoint(bearing.radius, bearing.clearance, bearing.length, 0.05, 0.0)
    radial, tangential = cl.short_film().plain(joint)(film.eccentricity_ratio, 0.0, SPEED, joint)
    angle = film.attitude
    along = radial * math.cos(angle) - tangential * math.sin(angle)
    across = radial * math.sin(angle) + tangential * math.cos(angle)
    assert (along, across) == pytest.approx((-load, 0.0), abs=1e-9 * load)


@pytest.mark.slow
@pytest.mark.parametrize(("length", "load"), [(1e-3, 0.2), (5e-4, 0.02)])
def test_the_reynolds_equation_tends_to_the_short_bearing(length, load):
    """Entries differ by at most L / R / 5 of the largest: what ends of the arc leave out."""
    bearing, radius = cl.Bearing(0.01, 1e-4, length, 0.05), 0.01
    laws = None, cl.short_film()
    film, formula = (cl.film_coefficients(bearing, load, SPEED, law=law) for law in laws)
    assert film.error < 1e-3
    for name in ("stiffness", "damping"):
        wanted = getattr(formula, name)
        tolerance = 0.2 * length / radius * np.abs(wanted).max()
        np.testing.assert_allclose(getattr(film, name), wanted, atol=tolerance)


@pytest.mark.parametrize(
    ("load", "speed", "words"),
    [
        (-1.0, SPEED, "load must be positive"),
        (1.0, 0.0, "sum of the speeds must be positive"),
        (1e12, SPEED, "more than is carried"),
        (1e-9, SPEED, "too light"),
    ],
)
def test_impossible_loads_are_refused(load, speed, words):
    """Each by its name."""
    with pytest.raises(ValueError, match=words):
        cl.film_coefficients(short(0)[0], load, speed, law=cl.short_film())


@pytest.mark.slow
def test_the_command(typed, tmp_path):
    """A table and a document with both matrices."""
    arguments = "film coefficients --length 4mm --load 5N --speed 3000rpm"
    document = json.loads(typed(arguments, "--json").out)
    assert np.shape(document["stiffness"]) == np.shape(document["damping"]) == (2, 2)
    assert "| stiffness [N/m] |" in typed(arguments, "-o", tmp_path).out
    assert (tmp_path / "film_coefficients.md").exists()
