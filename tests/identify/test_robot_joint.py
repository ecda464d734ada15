"""Friction of a joint in a logger's file: any headings, an uneven clock, angles, offset, position.

The truth is a LuGre joint with a torque of its angle, computed sample by sample.
"""

import gzip
import json
import math

import numpy as np
import pytest

from clearance.cli import main
from clearance.identify.fit import fit
from clearance.identify.models import lugre1d
from clearance.identify.records import read

KINETIC, STIFFNESS, VISCOUS, OFFSET, COSINE, SINE = 0.4, 900.0, 0.5, -0.2, 0.15, 0.3
COLUMNS = {"time": "time", "rate_z": "speed", "torque_z": "torque", "angle_z": "q"}


def logged(path, seed=0, speed=0.08, noise=0.02, samples=6000):
    """A compressed CSV file of a logger, whose clock is uneven and whose rate is noisy."""
    random = np.random.default_rng(seed)
    time = np.cumsum(random.uniform(0.5e-3, 3.5e-3, samples))
    angle = 0.9 + speed * (1.0 - np.cos(2.0 * math.pi * 0.4 * time)) / (0.8 * math.pi)
    rate = speed * np.sin(2.0 * math.pi * 0.4 * time)
    torque, bristle = np.empty(samples), 0.0
    for i, moved in enumerate(np.diff(angle, prepend=angle[0])):
        end = math.copysign(KINETIC, moved)
        bristle = end + (bristle - end) * math.exp(-STIFFNESS * abs(moved) / KINETIC)
        turned = angle[i] - angle[0]
        of_angle = OFFSET + COSINE * math.cos(turned) + SINE * math.sin(turned)
        torque[i] = bristle + VISCOUS * rate[i] + of_angle
    torque += random.normal(0.0, noise, samples)
    rate = rate + random.normal(0.0, 0.02 * speed, samples)
    rows = np.column_stack([time, angle, rate, torque])
    head = "time [s],q [rad],speed [rad/s],torque [N m]"
    lines = [head, *(",".join(f"{v:.9g}" for v in row) for row in rows)]
    path.write_bytes(gzip.compress("\n".join(lines).encode()))
    return path


@pytest.mark.parametrize("seed", range(3))
def test_the_parameters_of_a_logged_joint(tmp_path, seed):
    """Torque, stiffness, offset and harmonics within 2 % of the largest torque, from a record with
    noise of 5 % of it; the error is that of the noise to 2 %.
    """
    measurement = read(logged(tmp_path / "joint.csv.gz", seed), columns=COLUMNS)
    (trial,) = measurement.trials
    assert not trial.even
    assert trial.angle[-1, 2] == pytest.approx(trial.turned[-1, 2] - trial.turned[0, 2], rel=1e-12)
    fitted = fit(measurement, lugre1d(offset=True, position=1), starts=4)
    values = fitted.values
    assert fitted.rms(trial) == pytest.approx(0.02, rel=0.02)
    sliding = fitted.model.functions(values, [0.02, 0.05])[2, 0]
    assert sliding == pytest.approx(KINETIC, rel=0.04)
    assert values["spin_stiffness"] == pytest.approx(STIFFNESS, rel=0.05)
    # offset and cosine are nearly one over a small angle: their sum is seen
    assert values["spin_offset"] + values["spin_cos_1"] == pytest.approx(OFFSET + COSINE, abs=0.01)
    assert values["spin_sin_1"] == pytest.approx(SINE, abs=0.1)


def test_exact_slopes_of_offset_position_and_an_uneven_clock(tmp_path):
    """Slopes are those of central differences, to 1e-6 of the largest."""
    (trial,) = read(logged(tmp_path / "joint.csv.gz", samples=400), columns=COLUMNS).trials
    model = lugre1d(offset=True, position=2)
    values = np.array([p.typical for p in model.parameters])
    values[-5:] = 0.1, 0.2, -0.3, 0.05, 0.02
    torque, slopes = model.sensitivity(values, trial)
    assert torque == pytest.approx(model.torque(values, trial), abs=1e-14)
    for k in range(values.size):
        step = 1e-6 * max(abs(values[k]), 0.1)
        ends = [
            model.torque(values + way * step * np.eye(values.size)[k], trial) for way in (1, -1)
        ]
        difference = (ends[0] - ends[1]) / (2.0 * step)
        assert np.abs(difference - slopes[:, :, k]).max() < 1e-6 * max(
            np.abs(slopes[:, :, k]).max(), 1e-3
        )


def test_an_even_clock_is_a_special_case_of_an_uneven_one(tmp_path):
    """The same torque to rounding, read as a file of ours and by its headings."""
    time = 0.002 * np.arange(300)
    rate = 0.1 * np.sin(20.0 * time)
    rows = "\n".join(
        f"{t!r},{w!r},{w!r}" for t, w in zip(time.tolist(), rate.tolist(), strict=True)
    )
    (tmp_path / "a.csv").write_text("time,rate_z,torque_z\n" + rows)
    even, uneven = (
        read(tmp_path / "a.csv", columns=c).trials[0]
        for c in (None, {n: n for n in ("time", "rate_z", "torque_z")})
    )
    model = lugre1d()
    values = [p.typical for p in model.parameters]
    assert model.torque(values, uneven) == pytest.approx(model.torque(values, even), abs=1e-12)


def test_the_command_predicts_another_speed(tmp_path, capsys):
    """Errors of each record are printed, of one that was not fitted too."""
    slow, fast = (
        logged(tmp_path / f"{n}.csv.gz", 1, s) for n, s in (("slow", 0.05), ("fast", 0.1))
    )
    columns = ",".join(f"{ours}={theirs}" for ours, theirs in COLUMNS.items())
    call = ["identify", "--data", str(slow), "--predict", str(fast), "--columns", columns]
    options = ["--model", "lugre1d", "-p", "offset=yes", "-p", "position=1", "--starts", "3"]
    assert main([*call, *options, "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    slow_error, fast_error = document["rms"].values()
    assert slow_error == pytest.approx(0.02, rel=0.03)
    assert fast_error < 0.1  # a fifth of its torque: the angle reaches twice as far
    assert main(["identify", "--data", str(slow), "--columns", "rate_z=spee"]) == 2
    assert "no column 'spee' (did you mean speed?); there are time [s]" in capsys.readouterr().err
    assert main(["identify", "--data", str(slow), "--columns", "rate=speed"]) == 2
    assert "no column 'rate'" in capsys.readouterr().err
    assert main([*call, *options, "--lag"]) == 2
    assert "a lag needs even steps" in capsys.readouterr().err
