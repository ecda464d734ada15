"""Inverse dynamics through the compiled kernel: what it refuses, where it stops, what it keeps."""

import numpy as np
import pytest

import clearance as cl
from tests import mechanisms as m


def test_it_gives_what_a_simulation_gives():
    """The same kernel at the same times: equal to the last bit but for the angles' full turns."""
    scene = cl.load_case("four_bar", model="ideal")
    simulated = cl.simulate(scene, turns=2.0, samples=301)
    result = cl.inverse_dynamics(scene, turns=2.0, samples=301)
    for path in (
        "joints/C/force_x",
        "drives/crank/torque",
        "bodies/rocker/alpha",
        "bodies/coupler/theta",
    ):
        np.testing.assert_allclose(
            result.values(path), simulated.values(path), rtol=1e-12, atol=1e-12
        )
    assert "energy/input" not in result


@pytest.mark.parametrize("samples", [3, 5, 9, 50, 2000])
def test_coarse_samples_are_no_jumps(samples):
    """A run is complete with any number of samples, even one for each turn and a half."""
    run = cl.inverse_dynamics(
        cl.load_case("six_bar_feeder", model="ideal"), turns=3.0, samples=samples
    )
    assert run.complete
    assert run.time.size == samples


def test_iterated_loops_are_followed_between_coarse_samples():
    """A group that Newton solves: coarse samples lie on the fine ones."""
    fine = cl.inverse_dynamics(m.stephenson(), turns=0.5, samples=2001)
    coarse = cl.inverse_dynamics(m.stephenson(), turns=0.5, samples=5)
    for path in ("bodies/plate/x", "drives/crank/torque"):
        np.testing.assert_allclose(
            coarse.values(path), fine.values(path)[::500], rtol=1e-9, atol=1e-12
        )


def test_a_loop_that_changes_its_branch_ends_the_run():
    """A parallelogram driven through its flat position: its two branches meet there."""
    bars = {
        n: cl.Body(n, 1.0, 1e-3, points={"near": (0, 0), "far": (x, 0)}, com=(0.5 * x, 0), angle=a)
        for n, x, a in (("crank", 0.05, 1.0), ("coupler", 0.1, 0.0), ("rocker", 0.05, 1.0))
    }
    scene = cl.Scene(
        cl.Revolute(cl.ground, bars["crank"]["near"], name="A"),
        cl.Revolute(bars["crank"]["far"], bars["coupler"]["near"], name="B"),
        cl.Revolute(bars["coupler"]["far"], bars["rocker"]["far"], name="C"),
        cl.Revolute(cl.ground.at(0.1, 0), bars["rocker"]["near"], name="D"),
        cl.Drive(bars["crank"], speed=10.0, start=1.0),
    )
    with pytest.raises(cl.SimulationError, match="t = .* loop") as stopped:
        cl.inverse_dynamics(scene, turns=1.0, samples=1001)
    stored = stopped.value.result
    assert stored.time[-1] == pytest.approx((np.pi - 1.0) / 10.0, abs=0.002)  # flat at half a turn
    assert stored.status.startswith("partial: ")
    assert np.isfinite(stored.values("drives/" + stored.names("drives")[0] + "/torque")).all()


def test_a_motion_out_of_reach_says_where_and_when(tmp_path):
    """The crank of the three-loop chain may turn by +90.5 degrees; the file holds what came
    before.
    """
    with pytest.raises(
        cl.SimulationError, match=r"at t = 15\.80.* s: the loop of link_[ab] at .* singular"
    ) as stopped:
        cl.inverse_dynamics(
            cl.load_case("three_loop_chain"), until=20.0, samples=2001, path=tmp_path / "run.h5"
        )
    stored = cl.open_result(tmp_path / "run.h5")
    assert stored.time[-1] == pytest.approx(15.80, abs=0.011)
    assert stored.status.startswith("partial: at t = 15.80")
    assert stopped.value.result.time.size == stored.time.size


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: cl.load_case("slider_crank", model="dry"),
            "joint C has clearance: its motion is not prescribed",
        ),
        (
            lambda: cl.load_case("double_pendulum"),
            "no drive prescribes .*: inverse dynamics needs a motion",
        ),
        (
            lambda: cl.load_case("three_loop_chain", drive="torque"),
            "Drive crank gives an effort, not a motion",
        ),
    ],
)
def test_what_is_not_prescribed_is_refused(make, message):
    """Clearance, a missing drive and a drive by torque are refused by name."""
    with pytest.raises(ValueError, match=message):
        cl.inverse_dynamics(make(), until=1.0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({}, "exactly one of until=SECONDS, turns=N, time="),
        ({"until": 1.0, "time": [0.0]}, "exactly one of"),
        ({"time": [0.0, 0.0]}, "growing finite times"),
        ({"time": [0.0, np.nan]}, "growing finite times"),
        ({"until": -1.0}, "until must be positive, got -1"),
        ({"until": 1.0, "samples": 1}, "samples must be at least 2"),
    ],
)
def test_bad_arguments(arguments, message):
    """Times, their end and their number are refused by name where they cannot be."""
    with pytest.raises(ValueError, match=message):
        cl.inverse_dynamics(cl.load_case("four_bar"), **arguments)
