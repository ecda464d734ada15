"""Numbers of a run turn by turn, against its extremes, events and ledger."""

import numpy as np
import pytest

import clearance as cl
from clearance.metrics.by_turn import by_turn, means
from clearance.results.extremes import Extremes


@pytest.fixture(scope="module")
def run():
    return cl.simulate(cl.load_case("slider_crank"), turns=10, rtol=1e-5)


def test_counts_and_speeds_are_those_of_the_events(run):
    """Contacts belong to the turn in which they begin."""
    actual, turn = by_turn(run, 1), run.turn
    for i in range(9):
        inside = (run.events["time"] >= (i + 1) * turn) & (run.events["time"] < (i + 2) * turn)
        assert actual["joint_C_impacts_per_turn"].values[i] == inside.sum()
        fastest = run.events["impact_speed"][inside].max(initial=0.0)
        assert actual["joint_C_impact_speed_peak"].values[i] == fastest
    assert actual["joint_C_impacts_per_turn"].values.sum() > 5


def test_peaks_are_those_of_the_turns(run):
    """Located extremes as they are, and those of the record where a stretch is no turn."""
    actual = by_turn(run)
    entire = run.located.values[:, run.located.columns["joints/C/force_max"]]
    assert actual["joint_C_force_peak"].values == pytest.approx(entire, rel=1e-15)
    low, high = run.extremes("drives/crank/torque", 2.0 * run.turn, 3.0 * run.turn)
    assert actual["drive_crank_torque_peak"].values[2] == pytest.approx(max(-low, high), rel=1e-12)
    assert (actual["joint_C_penetration_peak"].values > 0.0).all()
    deepest = -run.extreme("joints/C/gap_min", 3.0 * run.turn, 4.0 * run.turn).value
    assert actual["joint_C_penetration_peak"].values[3] == pytest.approx(deepest, rel=1e-12)


def test_stretches_of_several_turns(run):
    """Samples stand in for located extremes; they miss 1 % of a force at most."""
    exact, located = by_turn(run), run.located
    values = located.values.reshape(5, 2, -1)
    try:
        run.located = Extremes(
            2.0 * located.length, located.names, located.units, values.max(axis=1), values[:, 0]
        )
        actual = by_turn(run)
    finally:
        run.located = located
    force = "joint_C_force_peak"
    assert actual[force].values[1:] == pytest.approx(exact[force].values[1:], rel=0.5)
    assert actual["drive_crank_torque_rms"].values == pytest.approx(
        exact["drive_crank_torque_rms"].values
    )


def test_means_and_energy(run):
    """The sum over turns is what the ledger has between their ends."""
    actual, edges = by_turn(run, 2, 5), np.array([2.0, 5.0]) * run.turn
    lost = np.interp(edges, run.time, run.energy.dissipated)
    assert actual["dissipated_per_turn"].values.sum() == pytest.approx(lost[1] - lost[0], rel=1e-12)
    assert len(actual["dissipated_per_turn"].values) == 3
    assert means(run)["dissipated_per_turn"].count == 9
    assert means(run, 3) == {}  # seven turns show no error
    assert by_turn(run, 10) == {}


def test_without_turns():
    """A scene without turns has no such series."""
    run = cl.simulate(cl.load_case("double_pendulum"), until=0.01)
    assert by_turn(run) == {}
