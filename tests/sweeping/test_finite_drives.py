"""Points with finite drives in lanes: their turns end where the drive has turned round."""

import numpy as np
import pytest

import clearance as cl
from clearance.lanes.point_numbers import NotForLanes
from clearance.scene.catalogue import find_case
from clearance.sweeping.in_lanes import Together
from tests.seeds import few_of
from tests.sweeping.test_dry_together import ordinary, scenes

KINDS = [
    ("six_bar_feeder", {"drive": "motor", "model": "mixed"}),
    ("six_bar_feeder", {"drive": "pi", "model": "lubricated", "joints": "B,C"}),
    ("slider_crank", {"drive": "dc", "model": "mixed", "joints": "C,guide"}),
    ("slider_crank", {"drive": "kloss", "model": "ideal"}),
    ("four_bar", {"drive": "dc", "model": "lubricated", "joints": "A,C"}),
]


def columns_of(name, seed):
    """Four speeds about the usual one, each with clearances at random."""
    rng, usual = np.random.default_rng(seed), find_case(name).parameters["speed"].default
    clearance = np.exp(rng.uniform(*np.log([1e-4, 3e-4]), 24))
    return {"speed": np.repeat(usual * rng.uniform(0.8, 1.2, 4), 6), "clearance": clearance}


class Ran:
    """Points of a case with a finite drive."""

    def __init__(self, name, fixed, seed, **options):
        columns = columns_of(name, seed)
        self.scene, self.columns, self.options = scenes(name, **fixed), columns, options
        self.together = Together(self.scene, columns, options, None)
        self.points = self.together.points(columns)
        self.answers = self.together.answers(self.points)
        self.sound = self.together.summing.sound(self.answers, self.points)
        self.metrics = self.together.summing.metrics(self.answers, self.points)


@pytest.mark.parametrize(("name", "fixed"), KINDS)
@pytest.mark.parametrize("seed", few_of(range(1, 9), 1))
def test_metrics(name, fixed, seed):
    """Lanes have all metrics within 5e-4 (measured 1.7e-4) where a tighter tolerance of the
    ordinary way changes none by 1e-5. Those that are sound have as many warnings.
    """
    ran, calm = Ran(name, fixed, seed, turns=3.5, rtol=1e-8), 0
    warnings = ran.together.warnings(ran.columns, ran.answers, ran.points)
    for i in range(4):
        values = {n: v[i].item() for n, v in ran.columns.items()}
        plain, record = ordinary(ran.scene, values, ran.options)
        tight, _ = ordinary(ran.scene, values, ran.options | {"rtol": 1e-10})
        if not ran.sound[i]:
            continue
        assert list(ran.metrics) == list(plain)
        assert warnings[i] == len(record.warnings)
        if list(plain.values()) == pytest.approx(list(tight.values()), rel=1e-5, abs=1e-9):
            mine = [ran.metrics[n][i] for n in tight]
            assert mine == pytest.approx(list(tight.values()), rel=5e-4, abs=1e-8)
            calm += 1
    assert calm > 0


def test_impacts_at_the_end_of_a_turn():
    """Means of a turn end where it ends, whatever samples lie about: of a dry joint that bounces
    there both ways have those of samples a hundred times as dense, within 1e-4 (measured 3e-6).
    """
    ran = Ran("four_bar", {"drive": "pi", "restitution": 0.2}, 1, turns=1.5, rtol=1e-8)
    values = {n: v[0].item() for n, v in ran.columns.items()}
    usual, dense = (
        ordinary(ran.scene, values, ran.options | {"samples_per_turn": n})[0] for n in (400, 40000)
    )
    for name in ("joint_C_force_rms", "dissipated_per_turn", "drive_crank_torque_rms"):
        assert ran.metrics[name][0] == pytest.approx(dense[name], rel=1e-4)
        assert usual[name] == pytest.approx(dense[name], rel=1e-4)


def test_company():
    """Points are the same, bit for bit, in other company."""
    ran = Ran("six_bar_feeder", {"drive": "motor", "model": "mixed"}, 3, turns=3.5)
    some = {n: v[5:8] for n, v in ran.columns.items()}
    points = ran.together.points(some)
    answers = ran.together.answers(points)
    for name, values in ran.together.summing.metrics(answers, points).items():
        np.testing.assert_array_equal(values, ran.metrics[name][5:8], err_msg=name)


def test_points_that_made_other_turns_are_not_sound():
    """A motor that idles slower makes fewer turns than that of the first point."""
    scene = scenes("four_bar", model="lubricated")

    def weak(values):
        drive = f"motor(stall=20,no_load={values['idle']})"
        return scene({"drive": drive, "clearance": values["clearance"]})

    idle = np.repeat(np.geomspace(8.0, 31.0, 4), 6)
    columns = {"idle": idle, "clearance": np.tile([1e-4, 2e-4, 3e-4], 8)}
    together = Together(weak, columns, {"turns": 3.2}, None)
    points = together.points(columns)
    answers = together.answers(points)
    sound = together.summing.sound(answers, points)
    assert 0 < sound.sum() < 24
    metrics = together.summing.metrics(answers, points)
    for i in (int(np.flatnonzero(sound)[0]), int(np.flatnonzero(~sound)[0])):
        values = {n: v[i].item() for n, v in columns.items()}
        plain, _ = ordinary(weak, values, {"turns": 3.2})
        same = [metrics[n][i] for n in plain] == pytest.approx(list(plain.values()), rel=1e-3)
        assert same == sound[i]


def test_less_than_a_turn_takes_the_ordinary_way():
    """Metrics of a part of a turn are left to it, with the reason."""
    with pytest.raises(NotForLanes, match="complete turns of its drive"):
        Ran("six_bar_feeder", {"drive": "motor", "model": "mixed"}, 1, turns=0.5)


@pytest.mark.parametrize("seed", few_of(range(30), 3))
def test_extremes_at_the_ends_of_windows(seed):
    """A motor's torque falls as a flywheel runs up: the least of a window is at its end, between
    samples. Both ways have it, and each turn's, within 1e-6 of those of samples ten times as dense.
    The last sample before, a hundredth of a turn away, was up to 1 % off.
    """
    rng = np.random.default_rng(seed)
    stall, idle, inertia = rng.uniform(5.0, 50.0), rng.uniform(10.0, 60.0), rng.uniform(0.05, 2.0)

    def scene(values):
        wheel = cl.Body("wheel", 1.0, inertia * values["factor"])
        line = cl.motor_line(stall=stall, no_load=idle)
        drive = cl.Drive(wheel, torque=line, nominal=idle)
        return cl.Scene(cl.Revolute(cl.ground, wheel, name="A"), drive)

    columns = {"factor": np.linspace(0.999, 1.0, 24)}
    until = float(rng.uniform(2.0, 4.0) * 2.0 * np.pi / idle + 1.3 * inertia * idle / stall)
    options = {"until": until, "rtol": 1e-10, "samples_per_turn": 100}
    together = Together(scene, columns, options, None)
    points = together.points(columns)
    answers = together.answers(points)
    assert together.summing.sound(answers, points)[-1]
    metrics = together.summing.metrics(answers, points)
    usual, _ = ordinary(scene, {"factor": 1.0}, options)
    dense, _ = ordinary(scene, {"factor": 1.0}, options | {"samples_per_turn": 1000})
    for name, value in dense.items():
        if name.endswith(("_min", "_max", "_peak_mean")):
            assert usual[name] == pytest.approx(value, rel=1e-6, abs=1e-9), name
            assert metrics[name][-1] == pytest.approx(value, rel=1e-6, abs=1e-9), name
