"""Loads of a hole check in compiled code are those of the joint's laws, put together."""

import numpy as np
import pytest

import clearance as cl
from clearance.run.force_hole import JointLoads, hole_check

FILMS = ["pinkus_sternlicht", "harmonic", "table", "long", "fast"]
FILMS += [pytest.param("fem", marks=pytest.mark.slow)]  # cold compilation of the solver


def load_of(joint, gap, approach, entrainment):
    """Film's and entire load, law by law."""
    facts, clearance = joint.film_joint, joint.clearance
    share, film_gap, slope, touching, depth, *_ = joint.transition(gap, facts)
    state = 1.0 - film_gap / clearance, slope * approach / clearance, entrainment
    film = -share * joint.film(*state, facts)[0] if share else 0.0
    impact = max(approach, 0.5 * clearance * abs(entrainment))
    load = film + touching * joint.contact(depth, approach, impact)
    if joint.asperity is not None:
        load += joint.asperity(gap / joint.roughness, facts)
    return film, load


def drawn(film, seed):
    """A joint of the slider-crank with any transition and contact."""
    draws = np.random.default_rng(seed)
    options = {
        "transition": str(draws.choice(["fuzzy", "load_sharing", "flores", "fuzzy(datum=0)"])),
        "contact": str(draws.choice(["hertz", "flores", "johnson", "winkler"])),
        "clearance": float(np.exp(draws.uniform(*np.log((1e-5, 4e-4))))),
        "viscosity": float(np.exp(draws.uniform(*np.log((2e-3, 0.1))))),
    }
    scene = cl.load_case("slider_crank", model="mixed", film=film, elastic="false", **options)
    return scene.clearance_joints[0], draws


@pytest.mark.parametrize("film", FILMS)
@pytest.mark.parametrize("seed", range(3))
def test_loads_are_those_of_the_laws(film, seed):
    """To 1e-9 of the load: rounding of other orders; solved films to 1e-6, their iterations."""
    joint, draws = drawn(film, seed)
    loads, share = JointLoads(joint), 1e-6 if film in ("fast", "fem") else 1e-9
    for ratio in draws.uniform(-2.0, 6.0, 4):
        state = ratio * joint.roughness, draws.uniform(0.0, 0.05), draws.uniform(10.0, 200.0)
        wanted = load_of(joint, *state)
        size = abs(wanted[0]) + abs(wanted[1])
        np.testing.assert_allclose(loads("loads", *state), wanted, rtol=0.0, atol=share * size)


@pytest.mark.parametrize("seed", range(10, 22))
def test_a_scan_is_that_of_its_loads(seed):
    """Rim, bottom and crest among the loads of the scan, by a plain search for the deepest fall."""
    joint, draws = drawn("pinkus_sternlicht", seed)
    entrainment, approach = draws.uniform(10.0, 200.0), draws.uniform(0.0, 0.05)
    hole = hole_check(joint, entrainment, approach)
    load = np.array(hole.load)
    falls = np.maximum.accumulate(load) - load
    assert hole.lost == pytest.approx(falls.max(), abs=1e-9 * np.abs(load).max())
    assert hole.left == pytest.approx(load[falls.argmax()], abs=1e-9 * np.abs(load).max())
    usual = 0.5 * joint.clearance * entrainment
    films = [load_of(joint, r * joint.roughness, usual, entrainment)[0] for r in hole.ratio]
    crest, *_ = JointLoads(joint)("scans", entrainment, 0.0, 1e3)
    best = load_of(joint, crest * joint.roughness, usual, entrainment)[0]
    assert best == pytest.approx(max(films), rel=1e-9)
