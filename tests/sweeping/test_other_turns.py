"""Points in lanes whose runs make different numbers of turns, or end inside one: metrics of the
complete turns of each, as the ordinary way has them.
"""

import numpy as np
import pytest

import clearance as cl
from clearance.metrics.metrics import RECURRING
from clearance.sweeping.in_lanes import Together
from tests.seeds import few_of
from tests.sweeping.test_dry_together import SPEEDS, ordinary, scenes

POINTS = 24
#: numbers that compare turns with each other: rounding, where the motion is periodic
COMPARING = ("settling_ratio", "period", "period_error")
KINDS = [
    ("six_bar_feeder", {"model": "lubricated"}),
    ("six_bar_feeder", {"model": "mixed", "joints": "B,E"}),
    ("six_bar_feeder", {"drive": "motor", "model": "mixed"}),
    ("four_bar", {"model": "lubricated", "joints": "A,C"}),
    ("slider_crank", {"model": "mixed", "joints": "C,guide"}),
    ("slider_crank", {}),
    ("four_bar", {"friction": "coulomb"}),
    ("six_bar_feeder", {"model": "ideal"}),
]


def drawn(name, seed, turns):
    """Speeds and clearances at random, and a length [s] of so many turns at most, one at least."""
    rng, (slow, fast) = np.random.default_rng(seed), SPEEDS[name]
    speed = rng.uniform(max(slow, 1.01 * fast / turns), fast, POINTS)
    clearance = np.exp(rng.uniform(*np.log([5e-5, 3e-4]), POINTS))
    return {"speed": speed, "clearance": clearance}, turns * 2.0 * np.pi / fast


class Ran:
    """Points of a case, run for a time at random."""

    def __init__(self, name, fixed, seed, turns, **options):
        self.columns, until = drawn(name, seed, turns)
        if "drive" in fixed:  # whose starts are solved for: few speeds
            self.columns["speed"] = np.repeat(self.columns["speed"][:4], POINTS // 4)
        self.scene, self.options = scenes(name, **fixed), {"until": until, "rtol": 1e-8} | options
        self.together = Together(self.scene, self.columns, self.options, None)
        self.points = self.together.points(self.columns)
        self.answers = self.together.answers(self.points)
        self.sound = self.together.summing.sound(self.answers, self.points)
        self.metrics = self.together.summing.metrics(self.answers, self.points)


@pytest.mark.parametrize(("name", "fixed"), KINDS)
@pytest.mark.parametrize("seed", few_of(range(1, 9), 1))
def test_metrics(name, fixed, seed):
    """Lanes have the metrics of the ordinary way within 5e-4 (measured 6e-5), where a tighter
    tolerance there changes none by 1e-5. They have the same warnings and no other metrics.
    """
    dry = "model" not in fixed  # before chaos
    turns = float(np.random.default_rng(seed).uniform(*((1.1, 1.9) if dry else (2.1, 4.9))))
    ran, calm = Ran(name, fixed, seed, turns), 0
    warnings = ran.together.warnings(ran.columns, ran.answers, ran.points)
    assert ran.sound.mean() > 0.8
    for i in range(6):
        values = {n: v[i].item() for n, v in ran.columns.items()}
        plain, record = ordinary(ran.scene, values, ran.options)
        tight, _ = ordinary(ran.scene, values, ran.options | {"rtol": 1e-10})
        if not ran.sound[i]:
            continue
        assert warnings[i] == len(record.warnings)
        names = [n for n in plain if n not in COMPARING]
        assert {n for n, v in ran.metrics.items() if np.isfinite(v[i])} >= {
            n for n in plain if np.isfinite(plain[n])
        }
        assert not [n for n, v in ran.metrics.items() if np.isfinite(v[i]) and n not in plain]
        if [plain[n] for n in names] == pytest.approx(
            [tight[n] for n in names], rel=1e-5, abs=1e-9
        ):
            mine = [ran.metrics[n][i] for n in names]
            assert mine == pytest.approx([tight[n] for n in names], rel=5e-4, abs=1e-8)
            calm += 1
    assert calm > 0


@pytest.mark.parametrize("seed", few_of(range(1, 6), 1))
def test_company(seed):
    """Points are the same, bit for bit, beside others that make other turns."""
    ran = Ran("six_bar_feeder", {"model": "mixed"}, seed, 4.3, rtol=1e-6)
    some = {n: v[5:8] for n, v in ran.columns.items()}
    points = ran.together.points(some)
    answers = ran.together.answers(points)
    assert len({int(n) for n in ran.points.count}) > 1
    for name, values in ran.together.summing.metrics(answers, points).items():
        np.testing.assert_array_equal(values, ran.metrics[name][5:8], err_msg=name)


def test_parts_of_turns_are_left_to_the_ordinary_way():
    """Points that make no complete turn are not sound; those of less than three have no period."""
    ran = Ran("six_bar_feeder", {"model": "lubricated"}, 3, 1.9, rtol=1e-6)
    ran.columns["speed"] *= np.linspace(0.4, 1.0, POINTS)
    points = ran.together.points(ran.columns)
    answers = ran.together.answers(points)
    turns = points.until / points.turn
    np.testing.assert_array_equal(ran.together.summing.sound(answers, points), turns >= 1.0)
    ran = Ran("six_bar_feeder", {"model": "lubricated"}, 3, 4.5, rtol=1e-6)
    few = ran.points.count < RECURRING
    assert 0 < few.sum() < POINTS
    np.testing.assert_array_equal(np.isnan(ran.metrics["period_error"]), few)


@pytest.mark.parametrize(
    "options", [{"turns": 2.6}, {"until": 0.45}, {"until": 0.45, "samples": 99}]
)
@pytest.mark.parametrize("error", [None, "state", 1e-3])
def test_sweeps_run_in_lanes(options, error, tmp_path):
    """All points of a sweep over speed, without errors, with stated and with requested ones."""
    points = cl.grid(speed=np.linspace(25.0, 60.0, 12), clearance=[1e-4, 2e-4])
    fixed, more = {"model": "lubricated"}, options | ({"error": error} if error else {})
    done = cl.sweep("six_bar_feeder", points, tmp_path / "a", fixed=fixed, channels=[], **more)
    assert done.ways.in_lanes == 24
    assert np.isfinite(done.metrics["joint_B_force_max"]).all()
