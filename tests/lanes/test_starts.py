"""Starts of a chaotic motion side by side in lanes: numbers of each turn."""

import numpy as np
import pytest

import clearance as cl
from clearance.mechanism.build import build
from clearance.metrics.statistics import mean
from clearance.motions.ensemble import Ensemble
from clearance.run.options import Solver

SCENES = {
    "contact": ("slider_crank", {}),
    "friction": ("slider_crank", {"friction": "coulomb", "restitution": 0.7}),
    "slide": ("slider_crank", {"joints": "C,guide"}),
    "feeder": ("six_bar_feeder", {"joints": "B", "model": "dry"}),
}


def ensemble(name, starts=4, rtol=1e-6, seed=1):
    """Starts of a dry scene, none of which has begun."""
    case, options = SCENES[name]
    scene = cl.load_case(case, **{"model": "dry"} | options)
    return Ensemble(build(scene), 400, Solver(rtol), starts, seed)


def one_by_one(runner):
    """The same starts the ordinary way."""
    runner.together = None
    return runner


@pytest.mark.parametrize("name", ["contact", "friction", "slide"])
def test_first_turns(name):
    """Before chaos a start has the numbers of the ordinary way: 1e-4 at rtol 1e-11, which grows by
    1e4 in a turn; penetrations and counts of a slide's corners, which rest, are left out.
    """
    together, apart = ensemble(name, 2, 1e-11), one_by_one(ensemble(name, 2, 1e-11))
    assert together.together is not None
    for runner in (together, apart):
        runner.extend(1)
    assert list(together.values) == list(apart.values)
    assert together.about.keys() == apart.about.keys()
    for label, values in apart.values.items():
        if "guide" not in label:
            np.testing.assert_allclose(together.values[label], values, rtol=1e-4, err_msg=label)
        assert together.about[label].text == apart.about[label].text


@pytest.mark.slow
@pytest.mark.parametrize("name", ["contact", "friction", "feeder"])
def test_means(name):
    """Means over 1200 turns, without the first five: within 5.5 joint standard errors, which one
    of a hundred numbers exceeds in one run of some thousands, on any processor.
    """
    together, apart = ensemble(name), one_by_one(ensemble(name, seed=2))
    for runner in (together, apart):
        runner.extend(300)
    for label in apart.values:
        first, second = (mean(runner.values[label][:, 5:]) for runner in (together, apart))
        difference = abs(first.value - second.value)
        assert difference <= 5.5 * np.hypot(first.error, second.error), label


def test_company_and_pauses():
    """Turns are the same, bit for bit, whatever runs beside and wherever runs paused."""
    at_once, paused, fewer = (ensemble("contact", count) for count in (4, 4, 3))
    at_once.extend(30)
    fewer.extend(30)
    for turns in (1, 2, 7, 30):
        paused.extend(turns)
    for label, values in at_once.values.items():
        np.testing.assert_array_equal(paused.values[label], values, err_msg=label)
        np.testing.assert_array_equal(fewer.values[label], values[:3], err_msg=label)


def test_more_starts_than_lanes(monkeypatch):
    """Starts that do not fit into one register: the same numbers as of two registers."""
    monkeypatch.setattr("clearance.lanes.starts.natural_width", lambda: 2)
    pairs, first = ensemble("contact", 5), ensemble("contact", 2)
    for runner in (pairs, first):
        runner.extend(16)
    assert pairs.together is not None
    for label, values in first.values.items():
        assert pairs.values[label].shape == (5, 16)
        np.testing.assert_array_equal(pairs.values[label][:2], values, err_msg=label)


def test_starts_that_cannot_go_on_run_one_by_one(monkeypatch):
    """All begin again the ordinary way, with its numbers, once energy does not add up."""
    monkeypatch.setattr("clearance.lanes.starts.doubtful", lambda rtol: 0.0)
    runner, apart = ensemble("contact"), one_by_one(ensemble("contact"))
    assert runner.together is not None
    for each in (runner, apart):
        each.extend(16)
    assert runner.together is None
    for label, values in apart.values.items():
        np.testing.assert_array_equal(runner.values[label], values, err_msg=label)


@pytest.mark.parametrize("transition", ["fuzzy", "load_sharing"])
def test_mixed(transition):
    """Random mixed joints have the numbers of the ordinary way: 100 rtol of the largest; journals
    that go behind the wall 1000 rtol, for contact is stiffer. All share their machine code.
    """
    rng, codes = np.random.default_rng(3), set()
    for seed, viscosity in enumerate((3e-4, 2e-3, 1e-2, 4e-2)):
        options = {"clearance": rng.uniform(6e-5, 4e-4), "viscosity": viscosity}
        options |= {"speed": rng.uniform(20.0, 60.0), "transition": transition}
        mechanism = build(cl.load_case("six_bar_feeder", model="mixed", **options))
        together, apart = (Ensemble(mechanism, 40, Solver(1e-6), 2, seed) for _ in range(2))
        codes.add(together.together.going_on.group.engine.code.stem)
        for runner in (together, one_by_one(apart)):
            runner.extend(4)
        bound = 1e-3 if apart.values["joint_B_penetration_peak"].any() else 1e-4
        for label, values in apart.values.items():
            most = bound * np.abs(values).max()
            np.testing.assert_allclose(together.values[label], values, 0.0, most, label)
    assert len(codes) == 1


def test_turns_are_complete():
    """Runs one by one have all turns that they go on to, at speeds with any last bits."""
    for speed in np.random.default_rng(1).uniform(10.0, 60.0, 30):
        scene = cl.load_case("slider_crank", model="lubricated", speed=speed)
        runner = one_by_one(Ensemble(build(scene), 40, Solver(1e-4), 1, 0))
        for turns in (16, 39):
            runner.extend(turns)
            assert len(runner.values["drive_crank_torque_rms"][0]) == turns


def test_scenes_that_do_not_suit():
    """Stiff friction begins the ordinary way, or goes on there."""
    options = {"model": "dry", "friction": "lugre"}
    runner = Ensemble(build(cl.load_case("slider_crank", **options)), 20, Solver(1e-6), 2, 0)
    runner.extend(16)
    assert runner.together is None
    assert all(values.shape == (2, 16) for values in runner.values.values())
