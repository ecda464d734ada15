"""Integrals over time are those of the motion that was integrated, not of the rows that were
requested.
"""

import math

import numpy as np
import pytest

import clearance as cl
from clearance.metrics.metrics import metrics
from clearance.results.extremes import PARTS, Integrals
from clearance.run.recording import remember_run
from clearance.simulation import prepare

#: forces with peaks between 400 samples a turn
SHARP = {"speed": cl.rpm(600), "clearance": 0.453453e-3}
PATHS = {
    "drive_crank_torque_rms": "drives/crank/torque",
    "joint_B_force_rms": "joints/B/force",
    "joint_guide_force_rms": "joints/guide/force",
}


def of_samples(run, path, begin, end):
    """Root mean square by the trapezoidal rule over the samples between two times."""
    late = (run.time >= begin * (1.0 - 1e-12)) & (run.time <= end * (1.0 + 1e-12))
    squares = run.sizes(path)[late] ** 2
    return math.sqrt(np.trapezoid(squares, run.time[late]) / (end - begin))


@pytest.fixture(scope="module")
def fine():
    """The sharp run at rtol 1e-9, so finely sampled that the trapezoidal rule errs by 1e-7."""
    scene = cl.load_case("six_bar_feeder", **SHARP)
    run, _ = remember_run(prepare(scene, turns=2, samples_per_turn=8000, rtol=1e-9))
    return run


def test_sharp_forces_are_right_within_their_stated_errors(fine):
    """At 400 samples a turn, where sums over samples are wrong by more than a tenth."""
    run = cl.simulate(cl.load_case("six_bar_feeder", **SHARP), turns=2, samples_per_turn=400)
    settled, turn = metrics(run), run.turn
    for name, path in PATHS.items():
        exact = of_samples(fine, path, turn, 2.0 * turn)
        assert abs(settled[name].value - exact) <= run.errors[name].stated < 1e-4 * exact
        assert abs(of_samples(run, path, turn, 2.0 * turn) - exact) > 0.1 * exact


def test_windows_with_parts_of_turns(fine):
    """Steps where parts of the run lie in the window, samples beside them: within the 1e-5 by which
    8000 samples a turn err between the peaks.
    """
    turn = fine.turn
    for begin, end in ((0.0, 2.0), (0.513, 1.513), (0.3, 0.6)):
        for path in PATHS.values():
            exact = of_samples(fine, path, begin * turn, end * turn) ** 2
            actual = fine.mean_square(path, begin * turn, end * turn)
            assert actual == pytest.approx(exact, rel=1e-5)
    assert fine.mean_square("drives/crank/torque", 0.51 * turn, 0.54 * turn) is None
    assert fine.mean_square("bodies/slider/x", 0.0, turn) is None


def test_loose_tolerances():
    """A companion at 1e-2, with some steps that hide a peak of the force: within 3 %, twice the
    present difference, most of which is that of the trajectory.
    """
    scene, values = cl.load_case("six_bar_feeder", model="mixed"), []
    for rtol in (1e-2, 1e-6):
        run, _ = remember_run(prepare(scene, turns=2, rtol=rtol, samples_per_turn=40))
        squares = [run.mean_square(p, run.turn, 2.0 * run.turn) for p in PATHS.values()]
        values.append(np.sqrt(squares))
    np.testing.assert_allclose(*values, rtol=0.03)


def test_sums_over_steps_are_of_sixth_order():
    """Ideal joints, so that nothing but the sums errs, and too loose a tolerance for inner places:
    half the step, a 64th of the error (from 30 to 130 times allowed), from 48 steps a turn on.

    Over a part of a turn, for errors cancel over a period.
    """
    scene, values = cl.load_case("slider_crank", model="ideal"), []
    for steps in (48, 96, 768):
        longest = scene.turn / steps
        run, _ = remember_run(
            prepare(scene, turns=2, samples_per_turn=24, rtol=0.1, max_step=longest)
        )
        values.append(run.mean_square("drives/crank/torque", run.turn, 1.35 * run.turn))
    coarse, half = (abs(value - values[2]) for value in values[:2])
    assert 1e-12 * values[2] < half
    assert 30.0 < coarse / half < 130.0


def test_time_in_contact_of_a_mixed_joint():
    """Located, not counted: at 100 samples a turn within 1e-5 of 20,000, where counting errs by
    up to a hundredth for each contact.
    """
    scene, shares = cl.load_case("slider_crank", model="mixed", viscosity=0.01), []
    for every in (100, 20_000):
        run = cl.simulate(scene, turns=2, samples_per_turn=every, error=None)
        assert run.integrals.names[-1:] == ("joints/C/contact_force_positive",)
        shares.append(metrics(run)["joint_C_contact_fraction"].value)
    late = run.time >= run.turn
    counted = np.mean(run.joint("C").contact_force[late] > 0.0)
    assert 0.01 < shares[0] < 0.99
    assert shares[0] == pytest.approx(shares[1], abs=1e-5)
    # each of a few contacts begins and ends between two samples
    assert shares[1] == pytest.approx(counted, abs=1e-3)


def test_changes_of_numbers_begin_anew():
    """Forces jump where a mass changes, and the next panel begins behind the jump: within 1e-6 of
    40,000 samples, the first of which is left out.
    """
    scene = cl.load_case("slider_crank", model="lubricated")
    run = prepare(scene, turns=2, samples_per_turn=40_000)
    run.every(scene.turn, lambda run: run.change({"bodies/slider/mass": 0.3}))
    record, _ = remember_run(run)
    squares = record.sizes("joints/A/force")[40_000:] ** 2
    squares[0] = 2.0 * squares[1] - squares[2]
    exact = np.trapezoid(squares, record.time[40_000:]) / scene.turn
    actual = record.mean_square("joints/A/force", scene.turn, 2.0 * scene.turn)
    assert actual == pytest.approx(exact, rel=1e-6)


def test_files_have_them(tmp_path):
    """All parts of the run, whichever channels are stored."""
    scene = cl.load_case("slider_crank", model="lubricated")
    path = tmp_path / "run.h5"
    stored = cl.simulate(scene, turns=2, error=None, channels=["bodies/slider"], path=path)
    entire = cl.simulate(scene, turns=2, error=None)
    assert stored.integrals.values.shape == (2 * PARTS, 5)
    assert stored.integrals.names[-1] == "drives/crank/torque_square"
    np.testing.assert_array_equal(stored.integrals.values, entire.integrals.values)
    assert stored.integrals.ends[-1] == stored.time[-1]


def test_edges():
    """Sums between edges, to rounding; None for times that are none."""
    values = np.array([[1.0], [2.0], [4.0]])
    stored = Integrals(("a_square",), ("N^2 s",), np.array([1.0, 2.0, 2.5]), values)
    np.testing.assert_array_equal(stored.between("a_square", np.array([0.0, 1.0, 2.5])), [1.0, 6.0])
    assert stored.between("a_square", np.array([0.0, 1.1])) is None
    assert stored.inside(1.0 + 1e-12, 2.5) == (1, 3)
    assert stored.inside(1.1, 1.9) == (2, 2)
