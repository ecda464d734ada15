"""The finite element film of a run: against the sharp rupture of film/fem.py and the fast
solver.
"""

import math

import numpy as np
import pytest

from clearance.film.banded import Factors, factorise
from clearance.film.bands import FastFilm
from clearance.film.bearing import Groove
from clearance.film.fem import FemFilm
from clearance.film.moving import SATURATED, SHIFT, MovingFilm, error_of, mesh_for, softplus
from tests.differences import slopes
from tests.film.states import apart, bearing, force, outputs
from tests.seeds import few_of

STATES = [(0.3, 0.0, 31.0), (0.6, 5.0, 20.0), (0.9, -3.0, -10.0), (0.95, 1.0, 31.0)]
ROUGH = {"roughness": 2e-5}
FED = {"grooves": (Groove(0.5, 0.4, 0.6, 2e3),)}


def off(actual, wanted):
    """Relative error of a force."""
    return apart(actual[:2], wanted[:2])


@pytest.mark.parametrize(
    ("more", "tolerance"),
    [
        ({}, 3e-3),
        ({"cavitation": "none"}, 1e-4),
        ({"cavitation": "gumbel"}, 1e-3),
        ({"ambient": 2e3}, 3e-3),
        (ROUGH, 2e-3),
        (FED, 2e-2),
    ],
    ids=["reynolds", "none", "gumbel", "ambient", "rough", "groove"],
)
def test_force_is_that_of_the_sharp_rupture(more, tolerance):
    """48 by 6 cells against 96 by 12 with a rupture at nodes; a groove holds the mesh still."""
    of = bearing(**more)
    moving, sharp = MovingFilm(of, (48, 6)), FemFilm(of, (96, 12))
    for state in STATES:
        assert off(moving.outputs(*state), outputs(sharp.solve(*state))) < tolerance


@pytest.mark.parametrize("slenderness", [0.125, 0.25, 1.0])
def test_error_is_what_a_mesh_is_chosen_for(slenderness, validated):
    """The error that `error_of` expects of the default mesh, against the fast solver on (128, 16),
    which has 3e-4.
    """
    of = bearing(slenderness)
    moving, fast = MovingFilm(of), FastFilm(of, (128, 16))
    states = [
        (e, r, w) for e in (0.2, 0.8, 0.95) for r, w in ((0.0, 31.0), (6.0, 31.0), (31.0, 0.0))
    ]
    actual, wanted = (
        np.array([f.outputs(*s)[:2] for s in states]) @ (1, 1j) for f in (moving, fast)
    )
    expected = max(error_of(moving.mesh[0], e, slenderness) for e, *_ in states)
    assert expected < 3.1e-3
    source, sizes = {"source": "fast solver", "kind": "independent"}, np.abs(wanted)
    label = f"force of the film of a run, L/D {slenderness:g}"
    validated(label, actual / sizes, wanted / sizes, expected + 3e-4, **source)


@pytest.mark.parametrize(
    "more", few_of([ROUGH, FED, {}, {"ambient": 2e3}, {"cavitation": "gumbel"}], 2)
)
def test_derivatives_are_exact(more):
    """Against central differences, whose own error is about 1e-5 of the largest where the roughness
    cuts phi.
    """
    film = MovingFilm(bearing(**more), (24, 3))
    for state in STATES[1:3]:
        actual = film.linearised(*state)[:3, 1:]
        steps = 1e-5 * np.maximum(np.abs(state), 1.0)
        wanted = slopes(lambda *at: film.outputs(*at)[:3], state, steps)
        largest = np.abs(actual[:2]).max(axis=0)
        assert np.allclose(wanted[:2], actual[:2], atol=5e-5 * largest)
        assert wanted[2] == pytest.approx(actual[2], rel=1e-3, abs=1e-3 * np.abs(actual[2]).max())


def roughness_of(solve):
    """Total variation of the second difference of the force over its range, as the journal turns
    and sinks.
    """
    states = [(0.6 + 0.001 * i, 0.03 * (i - 50), 31.0) for i in range(100)]
    bend = np.diff([solve(*s)[1] for s in states], 2)
    return np.abs(np.diff(bend)).sum() / np.ptp(bend)


def test_force_is_smooth_where_the_sharp_one_is_not():
    """The cause of steps that were too long, every fourth of a run: nodes that turn wet one by
    one.
    """
    sharp = FemFilm(bearing(), (32, 4))
    assert roughness_of(MovingFilm(bearing(), (32, 4)).outputs) < 3.0
    assert roughness_of(lambda *s: force(sharp.solve(*s))) > 6.0


def test_homogeneous_and_a_mirror_image():
    """To the correction at which solutions end, 1e-8 of the pressure."""
    film = MovingFilm(bearing())
    forces = film.outputs(0.8, 2.0, 31.0)[:2]
    assert film.outputs(0.8, 20.0, 310.0)[:2] == pytest.approx(10.0 * forces, rel=1e-6)
    assert film.outputs(0.8, 2.0, -31.0)[:2] == pytest.approx(forces * (1.0, -1.0), rel=1e-6)


def test_solutions_do_not_depend_on_the_last_one():
    """From a neighbour or from nowhere: 1e-6 of the force."""
    film = MovingFilm(bearing())
    alone = [film.outputs(*s) for s in STATES if film.reset() is None]
    film.linearised(*STATES[0])
    for state, wanted in zip(STATES, alone, strict=True):
        assert off(film.outputs(*state), wanted) < 1e-6


def test_neighbouring_states_share_factors():
    """Fewer than one factorisation for three states a thousandth apart."""
    film = MovingFilm(bearing())
    film.linearised(0.8, 1.0, 31.0)
    before = film.systems
    for i in range(30):
        film.outputs(0.8 + 1e-4 * i, 1.0, 31.0)
    assert film.systems - before < 10


def test_bias_of_the_smooth_rupture():
    """SHIFT and SATURATED make g 1 in the cavity, and the wet side begin at the pressure of the
    sharp rupture.
    """
    assert softplus(SHIFT - SATURATED) == pytest.approx(1.0, rel=1e-12)
    p = np.linspace(SATURATED, 60.0, 400_001)
    g = np.array([softplus(SHIFT - x) for x in p])
    assert SATURATED + np.trapezoid(g, p) == pytest.approx(0.0, abs=1e-8)


def test_mesh():
    """Finer around where the bearing is short; a warning where a mesh is too coarse names a finer
    one.
    """
    assert mesh_for(1.0) == (36, 3)
    assert mesh_for(0.125)[0] > mesh_for(0.25)[0] > 36
    film = MovingFilm(bearing(), (16, 2))
    assert "16 cells around are too coarse for eccentricity ratio 0.95" in film.doubt(0.95)
    assert MovingFilm(bearing()).doubt(0.95) is None
    with pytest.raises(ValueError, match="mass_conserving"):
        MovingFilm(bearing(cavitation="mass_conserving"))


def test_pressure_carries_the_load():
    """The field's own integral, trapezia around and Simpson's rule along, gives the force: 5e-3."""
    film = MovingFilm(bearing(), (64, 8))
    actual = film.solve(0.8, 2.0, 31.0)
    around = np.append(actual.theta, actual.theta[0] + 2.0 * math.pi)
    rule = np.ones(len(actual.axial))
    rule[1:-1:2], rule[2:-1:2] = 4.0, 2.0
    line = actual.pressure @ rule * (actual.axial[1] - actual.axial[0]) / 3.0 * 2.0
    line = np.append(line, line[0])
    force = [np.trapezoid(line * f(around), around) * 0.01 for f in (np.cos, np.sin)]
    assert force == pytest.approx([actual.radial, actual.tangential], rel=5e-3)


@pytest.mark.parametrize("seed", few_of(range(4), 1))
def test_factors_of_an_indefinite_matrix_stay_inside_their_arrays(seed):
    """Pressures that run away on the way of Newton's method: nan fills the factors, and nothing
    beside them is written. A run was killed by that.
    """
    rng = np.random.default_rng(seed)
    count, reach, inner = int(rng.integers(6, 30)), int(rng.integers(2, 6)), 3
    memory = np.full(count * (reach + 1) + 2 * (reach + 1) ** 2, 7.0)
    entries = memory[: count * (reach + 1)]
    entries[:] = rng.normal(size=entries.size)
    entries[:: reach + 1] = 10.0
    entries[(reach + 1) * int(rng.integers(count))] = -1.0
    factors = Factors(
        entries.reshape(count, reach + 1), np.ones((count, inner)), 9.0 * np.eye(inner)
    )
    factorise(factors)
    assert np.isnan(factors.band).any()
    assert (memory[entries.size :] == 7.0).all()
