"""The picture of turn peaks: what it shows, and files that have nothing to show."""

import numpy as np
import pytest
from clearance.postprocess.turn_peaks import chosen_peaks, turn_peaks

import clearance as cl

SCENE = cl.load_case("slider_crank")


def test_a_picture_from_a_file(tmp_path, monkeypatch):
    """Mean and quantiles are lines at their values [kN]."""
    cl.simulate(SCENE, turns=1, path=tmp_path / "run.h5").close()
    with pytest.raises(ValueError, match="holds no statistics"):
        turn_peaks(tmp_path / "run.h5", tmp_path / "t.png")
    actual = cl.statistics(SCENE, {"joint_C_force_peak": 0.99}, max_turns=200, check=False)
    actual.append(tmp_path / "run.h5")
    seen = []
    monkeypatch.setattr("matplotlib.axes.Axes.axhline", lambda self, y, **style: seen.append(y))
    assert turn_peaks(tmp_path / "run.h5", tmp_path / "t.png").stat().st_size > 20_000
    force = actual["joint_C_force_peak"]
    wanted = [force.mean.value, *(q.value for q in force.quantiles)]
    assert np.array(seen[: len(wanted)]) == pytest.approx(1e-3 * np.array(wanted), rel=1e-12)


def test_forces_of_joints_that_touch_come_first():
    """Of joints with penetration, then torque and acceleration."""
    names = [
        "slider_acceleration_peak",
        "drive_crank_torque_peak",
        "drive_crank_torque_rms",
        "joint_A_force_peak",
        "joint_C_force_peak",
        "joint_C_penetration_peak",
        "joint_C_impacts_per_turn",
    ]
    first = ["joint_C_force_peak", "drive_crank_torque_peak", "slider_acceleration_peak"]
    assert chosen_peaks(names) == first
