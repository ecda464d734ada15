"""Extremes are those of the motion that was integrated, not of the rows that were asked for."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import clearance as cl
from clearance.extremes import Extremes, whole
from clearance.sweeping.metrics import metrics


@given(
    until=st.floats(1e-3, 1e3), turns=st.one_of(st.none(), st.floats(0.1, 350.0)), seed=st.integers(0, 99),
    ends=st.lists(st.floats(0.0, 1.0), min_size=2, max_size=2),
)  # fmt: skip
def test_whole_stretches_hold_the_extremes_of_their_rows(until, turns, seed, ends):
    """Of random rows handed over in two pieces; a stretch is in where no row outside the times is in it."""
    rng = np.random.default_rng(seed)
    times, rows = np.sort(rng.uniform(0.0, until, 200)), rng.normal(size=(200, 3))
    kept = Extremes(3, until, turns and until / turns)
    kept.add(times[:70], rows[:70])
    kept.add(times[70:], rows[70:])
    assert len(kept.lowest) <= 101
    begin, end = sorted(until * e for e in ends)
    inside = whole(kept.length, len(kept.lowest), begin, end)
    found = rows[(times >= inside.start * kept.length) & (times < inside.stop * kept.length)]
    assert inside.start * kept.length >= begin * (1.0 - 1e-8)
    assert inside.stop * kept.length <= max(end, inside.start * kept.length) * (1.0 + 1e-8)
    if len(found):
        assert (kept.lowest[inside].min(axis=0) == found.min(axis=0)).all()
        assert (kept.highest[inside].max(axis=0) == found.max(axis=0)).all()
    every = whole(kept.length, len(kept.lowest), 0.0, math.inf)
    assert (kept.highest[every].max(axis=0) == rows.max(axis=0)).all()


SCENES = {
    "dry": ({"model": "dry"}, 0.5),
    "mixed": ({"model": "mixed", "viscosity": 0.005}, 1.0),
    "lubricated": ({"model": "lubricated", "clearance": 2e-4}, 1.0),
}


@pytest.mark.parametrize("model", SCENES)
def test_peaks_hardly_depend_on_the_samples(model):
    """Twenty samples a turn see at least 0.9 of what 40000 see: a contact, whose force is smooth, takes ten steps."""
    parameters, turns = SCENES[model]
    scene = cl.load_case("slider_crank", **parameters)
    coarse, fine = (cl.simulate(scene, turns=turns, samples_per_turn=n) for n in (20, 40000))
    for path in ("drives/crank/torque", "bodies/slider/ax"):
        low, high = fine.range(path)
        found = coarse.extremes(path)
        assert found[0] <= low + 0.1 * (high - low), path
        assert found[1] >= high - 0.1 * (high - low), path
        assert low - 0.02 * (high - low) <= found[0] <= found[1] <= high + 0.02 * (high - low), path
    for joint in ("A", "C"):
        assert 0.9 < coarse.largest_force(joint) / fine.largest_force(joint) < 1.02, joint
    gaps = [r.facts("joints/C")["smallest_gap"] for r in (coarse, fine)]
    assert gaps[0] == pytest.approx(gaps[1], abs=0.02 * scene.clearance_joints[0].clearance)


def test_samples_alone_would_miss_them():
    """Otherwise the test before could not fail."""
    coarse = cl.simulate(cl.load_case("slider_crank", model="dry"), turns=0.5, samples_per_turn=20)
    assert coarse.range("bodies/slider/ax")[1] < 0.8 * coarse.extremes("bodies/slider/ax")[1]


def test_the_first_turn_is_left_out_of_metrics():
    """A journal let go from the middle of its oil: its first turn has the largest forces."""
    run = cl.simulate(cl.load_case("slider_crank", model="lubricated"), turns=4, samples_per_turn=40)
    length, _, highest = run.stretches("drives/crank/torque")
    assert length == pytest.approx(run.turn, rel=1e-12)
    found = {n: m.value for n, m in metrics(run).items()}
    samples = run.drive("crank").torque[run.time >= run.turn * (1.0 - 1e-9)].max()
    assert found["drive_crank_torque_max"] == max(samples, highest[1:].max())
    everything = {n: m.value for n, m in metrics(run, 0.0).items()}
    assert everything["drive_crank_torque_max"] == run.extremes("drives/crank/torque")[1]


def test_the_ledger_is_judged_where_the_states_are_known():
    """Between the long steps of thick oil the dense output is of low order; at their ends the ledger closes with rtol.

    Ten times smaller for a hundred times: order 5 with the errors of all states controlled gives more.
    """
    scene = cl.load_case("slider_crank", model="lubricated", viscosity=5.0, clearance=1e-5, speed=cl.rpm(10))
    loose, tight = (
        cl.simulate(scene, turns=1, rtol=r, method="radau5").solver["energy_residual_share"] for r in (1e-4, 1e-6)
    )
    assert tight < 0.1 * loose
    assert tight < 1e-5
