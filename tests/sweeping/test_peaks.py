"""Metrics of points of sweeps: means over turns where joints are dry, extremes elsewhere."""

import numpy as np
import pytest

import clearance as cl
from clearance.metrics.by_turn import by_turn
from clearance.metrics.metrics import metrics
from clearance.metrics.of_points import is_dry, of_point
from clearance.metrics.statistics import mean
from clearance.run.ideal_motion import ideal_motion
from clearance.run.options import Span

FORCE = "joint_C_force_peak"


@pytest.fixture(scope="module")
def dry():
    return cl.simulate(cl.load_case("slider_crank"), turns=60, rtol=1e-5, samples_per_turn=100)


def test_dry_points_have_means_over_turns(dry):
    """Those of the turns after `settle`, their intervals and the quantile that 50 turns show."""
    actual, forces = of_point(dry, settle=10), by_turn(dry, 10)[FORCE].values
    assert actual[f"{FORCE}_mean"].value == pytest.approx(forces.mean(), rel=1e-14)
    assert actual[f"{FORCE}_mean_half_width"].value == mean(forces).half_width
    assert actual[f"{FORCE}_q90"].value == np.quantile(forces, 0.9)
    assert f"{FORCE}_q99" not in actual
    assert actual[f"{FORCE}_mean"].units == "N"
    assert "mean over turns of the largest force" in actual[f"{FORCE}_mean"].text
    assert f"{FORCE}_mean_half_width" not in of_point(dry, settle=53)  # of seven turns


def test_dry_points_have_nothing_that_grows_with_the_run(dry):
    """Largest values are left out; means have half widths."""
    actual, all_of_it = of_point(dry), metrics(dry)
    assert {n for n in all_of_it if all_of_it[n].time is not None or n.endswith("_max")}.isdisjoint(
        actual
    )
    assert "joint_C_contact_fraction" in actual
    assert actual["dissipated_per_turn"].value == all_of_it["dissipated_per_turn"].value
    assert (
        0.0 < actual["dissipated_per_turn_half_width"].value < actual["dissipated_per_turn"].value
    )


def test_the_root_mean_square_of_efforts(dry):
    """Its interval is from that of the mean square, (x + d)^2 = x^2 + 2 x d, within 20 %."""
    actual = of_point(dry)
    rms = by_turn(dry, 1)["drive_crank_torque_rms"].values
    assert actual["drive_crank_torque_rms"].value == pytest.approx(
        np.sqrt(np.mean(rms**2)), rel=1e-2
    )
    half = actual["drive_crank_torque_rms_half_width"].value
    assert half == pytest.approx(mean(rms).half_width, rel=0.2)


def test_a_settled_part_that_begins_inside_a_turn(dry):
    """Turns are counted from its begin."""
    actual = of_point(dry, settle=1.5)
    begin, end = 1.5 * dry.turn, (2.5 - 1e-6) * dry.turn
    first = by_turn(dry, 1.5)[FORCE].values
    assert len(first) == 58
    assert first[0] == pytest.approx(dry.extreme("joints/C/force_max", begin, end).value, rel=1e-12)
    assert actual[f"{FORCE}_mean"].value == pytest.approx(first.mean(), rel=1e-12)


def test_distances_from_ideal_joints(dry):
    """The largest of all turns is that of the run."""
    scene = cl.load_case("slider_crank")
    ideal = ideal_motion(scene, Span(60.0 * scene.turn, dry.time.size), dry.scene)
    actual = of_point(dry, ideal=ideal)
    most = metrics(dry, ideal=ideal)["slider_position_deviation_max"].value
    assert 0.3 * most < actual["slider_position_deviation_peak_mean"].value < most


def test_other_scenes_have_extremes_and_means(dry):
    """A periodic motion has the same peak in each turn: 1e-4 after the first two."""
    run = cl.simulate(cl.load_case("six_bar_feeder"), turns=4, rtol=1e-6)
    actual = of_point(run, settle=2)
    assert not is_dry(run.scene)
    assert is_dry(dry.scene)
    assert actual["joint_B_force_peak_mean"].value == pytest.approx(
        actual["joint_B_force_max"].value, rel=1e-4
    )
    assert "joint_B_force_peak_mean_half_width" not in actual
    assert "joint_B_gap_min" in actual
    assert set(metrics(run, settle=2)) < set(actual)


def test_a_run_of_half_a_turn():
    """It has no turn: its extremes stay."""
    run = cl.simulate(cl.load_case("slider_crank"), turns=0.5, rtol=1e-4)
    assert set(of_point(run)) == set(metrics(run))
