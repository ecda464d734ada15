"""Statistics of chaotic motion: runs that go on, intervals that agree, requested errors."""

import json
import re
from dataclasses import replace
from itertools import combinations

import h5py
import numpy as np
import pytest

import clearance as cl
from clearance.cli import main
from clearance.mechanism.build import build
from clearance.metrics import by_turn as turns
from clearance.motions import chaos
from clearance.motions.ensemble import Ensemble
from clearance.run import method
from clearance.run.options import Solver
from tests.seeds import few_of

SCENE = cl.load_case("slider_crank")
FORCE = "joint_C_force_peak"


@pytest.fixture(scope="module")
def actual():
    return cl.statistics(SCENE, {FORCE: 0.3, "drive_*_rms": 0.1}, max_turns=1000)


def test_a_run_goes_on_where_it_stopped():
    """Its first two turns are those of `simulate`: within the horizon, at 1e-9 of the tolerance
    times growth.
    """
    ensemble = Ensemble(build(SCENE), 50, Solver(1e-10), 2, 0)
    for count in (1, 2):
        ensemble.extend(count)
    entire = turns.by_turn(cl.simulate(SCENE, turns=2, rtol=1e-10))
    assert set(entire) == set(ensemble.values)
    for name, one in entire.items():
        assert ensemble.values[name][0] == pytest.approx(one.values, rel=1e-5), name
    assert ensemble.values[FORCE][1, 1] != ensemble.values[FORCE][0, 1]  # starts differ


def test_reached(actual):
    """Both that were requested; nothing else need be."""
    assert actual.reached
    assert set(actual.asked) == {FORCE, "drive_crank_torque_rms"}
    assert actual[FORCE].mean.share <= 0.3
    assert re.match(r"\+- (30|10) % requested, \+- ", actual.verdict)
    starts, turns = actual.shape
    assert starts == 4
    assert actual[FORCE].mean.count == starts * (turns - actual.left_out)
    assert actual.check.largest < 6.0  # standard errors: another processor runs other motions
    assert actual.check.rtol == pytest.approx(1e-8)


def test_other_starts_give_the_same(actual):
    """Intervals of 95 %: means differ by less than twice both half widths together, which is 5.5
    standard errors.
    """
    other = cl.statistics(SCENE, {FORCE: 0.3}, max_turns=1000, seed=7, check=False)
    for name in (FORCE, "dissipated_per_turn", "joint_C_impacts_per_turn"):
        one, two = actual[name].mean, other[name].mean
        assert abs(one.value - two.value) < 2.0 * (one.half_width + two.half_width), name


def test_quantiles(actual):
    """One turn in ten is above; one in a hundred needs 500 turns. The upper end of the interval
    may lie above all turns, where it is nan. Two looks mean at least 50 turns, as the first needs.
    """
    stored = actual.values[FORCE][:, actual.left_out :]
    q = actual[FORCE].quantiles[0]
    assert np.mean(stored > q.value) == pytest.approx(0.1, abs=1.0 / stored.size)
    assert q.low < q.value
    assert not q.high <= q.value
    assert actual["drive_crank_torque_rms"].quantiles == ()


def test_not_reached():
    """States what it would take: four times the turns for half the width."""
    result = cl.statistics(SCENE, 0.01, max_turns=160, check=False)
    assert not result.reached
    assert result.turns == 160
    name, share = result.widest
    mean = result[name].mean
    assert result.needed == pytest.approx(mean.count * (share / 0.01) ** 2, rel=0.1)
    assert f"only +- {100 * share:.2g} % for {name} over 160 turns: needs about" in result.verdict


def test_crawling_statistics_end_by_name(monkeypatch):
    """As of `simulate`: the remaining turns would need too many steps; here 500 are too many."""
    monkeypatch.setenv("CLEARANCE_LANES", "0")
    monkeypatch.setattr(method, "PACE", 500)
    monkeypatch.setattr(method, "ENDLESS", 500.0)
    with pytest.raises(cl.SimulationError, match="so short that the rest of the run needs more"):
        cl.statistics(SCENE, 0.1, max_turns=160, check=False)


def test_files(actual, tmp_path):
    """Series turn by turn, means and intervals; the same group in the file of a run, twice."""
    with h5py.File(actual.save(tmp_path / "s.h5")) as file:
        assert file.attrs["format"] == "clearance-statistics"
        np.testing.assert_array_equal(file[f"by_turn/{FORCE}"], actual.values[FORCE])
        assert file[f"by_turn/{FORCE}"].attrs["units"] == "N"
        assert file["by_turn"].attrs["left_out"] == actual.left_out
        at = list(file["motion_1/quantity"].asstr()).index(FORCE)
        assert file["motion_1/half_width"][at] == actual[FORCE].mean.half_width
        assert file["motion_1/q90"][at] == actual[FORCE].quantiles[0].value
    cl.simulate(SCENE, turns=1, path=tmp_path / "run.h5").close()
    for _ in range(2):
        actual.append(tmp_path / "run.h5")
    with cl.open_result(tmp_path / "run.h5") as run, h5py.File(tmp_path / "run.h5") as file:
        assert run.complete
        assert file["statistics/by_turn"].attrs["reached"]


def test_shown(actual):
    """The table and the document have the same numbers."""
    text = "\n".join(actual.lines())
    assert f"the first {actual.left_out} of each left out" in text
    assert "1 turn in 10 above" in text
    assert "means over" in text
    assert "agree" in text
    plain = actual.plain()
    assert plain["motions"][0]["quantities"][FORCE]["mean"] == actual[FORCE].mean.value
    assert plain["check"]["agrees"] is actual.check.agrees


def test_several_motions_are_not_averaged(actual):
    """Starts of other size are another motion; each has its statistics."""
    ensemble = Ensemble(build(SCENE), 50, Solver(1e-4), 4, 0)
    ensemble.extend(1)
    rng = np.random.default_rng(3)
    factor = np.array([[1.0], [1.0], [2.0], [1.0]])
    ensemble.values = {n: factor * rng.normal(5.0, 1.0, (4, 60)) for n in ensemble.values}
    motions = chaos._motions(ensemble, 0, {FORCE: 0.05})
    assert [m.starts for m in motions] == [(0, 1, 3), (2,)]
    assert motions[1].quantities[FORCE].mean.value == pytest.approx(10.0, abs=1.0)
    several = replace(actual, motions=motions, asked={FORCE: 0.05})
    assert "motion 2 of 2: start 3" in "\n".join(several.lines())
    with pytest.raises(ValueError, match="2 motions were seen"):
        several[FORCE]


@pytest.mark.slow
def test_ranges10_regular_motions_that_differ_are_told_apart():
    """A slider-crank that stays in contact keeps one motion for each impact speed it remembers.

    Starts that repeat within 1e-3, and differ by more than 1e-2, are never one motion; neither are
    such that repeat after two turns.
    """
    scene = cl.load_case(
        "slider_crank",
        model="dry",
        friction="coulomb",
        restitution=0.9,
        friction_coefficient=0.02,
        clearance=7e-4,
        speed=cl.rpm(5600),
    )
    pairs = 0
    for seed in range(1, 9):
        seen = cl.statistics(scene, {"joint_C_force_peak": 0.2}, seed=seed)
        forces = seen.values["joint_C_force_peak"][:, seen.left_out :]
        late = forces[:, -(forces.shape[1] // 4) * 2 :].reshape(len(forces), -1, 2)
        means = late.mean(axis=(1, 2))
        regular = (np.ptp(late, axis=1) < 1e-3 * means[:, None]).all(axis=1)
        of = {start: i for i, motion in enumerate(seen.motions) for start in motion.starts}
        for one, other in combinations(np.flatnonzero(regular), 2):
            if abs(means[one] - means[other]) > 1e-2 * means.min():
                pairs += 1
                assert of[one] != of[other], f"seed {seed}: starts {one} and {other}"
    assert pairs > 3


@pytest.mark.slow
def test_two_motions_of_one_mechanism():
    """The dry slider-crank at 3900 rpm, below its fold: starts lead to an orbit of one turn, or one
    in nine to one of two. Rounding decides which of them `steady` solves for; its mean force is
    theirs (1e-3). The mean forces of both differ by 2 %.
    """
    starts = 40
    dry = {"restitution": 0.9, "friction": "coulomb", "friction_coefficient": 0.03}
    scene = cl.load_case("slider_crank", clearance=1e-3, speed=cl.rpm(3900), **dry)
    actual = cl.statistics(scene, {FORCE: "1%"}, starts=starts, seed=1, check=False)
    forces = [motion.quantities[FORCE].mean.value for motion in actual.motions]
    assert len(forces) == 2
    assert sorted(start for motion in actual.motions for start in motion.starts) == [*range(starts)]
    orbit = cl.steady(scene, error=None)
    assert orbit.period in (1, 2)
    force = min(forces) if orbit.period == 2 else max(forces)
    assert force == pytest.approx(turns.by_turn(orbit.orbit)[FORCE].values.mean(), rel=1e-3)
    assert max(forces) > 1.02 * min(forces)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"error": 0.0}, "error must be positive"),
        ({"error": {"no_*": 0.1}}, "there is no 'no_"),
        ({"error": "joint_C_forc_max=5%"}, r"did you mean joint_C_force_peak\?"),
        ({"error": "5 per cent"}, "error: '5 per cent' is no number"),
        ({"max_turns": 159}, r"max_turns of 4 starts must be a whole number from 160 to"),
        ({"starts": 0}, "starts must be a whole number"),
    ],
)
def test_bad_arguments(options, message):
    """Wrong options of statistics are refused."""
    with pytest.raises(ValueError, match=message):
        cl.statistics(SCENE, **options)


def test_scenes_without_turns_or_freedom():
    """Scenes without turns, or without freedom, are refused."""
    with pytest.raises(ValueError, match="no drive of constant"):
        cl.statistics(cl.load_case("double_pendulum"))
    with pytest.raises(ValueError, match="nothing is free"):
        cl.statistics(cl.load_case("slider_crank", model="ideal"))


def command(tmp_path, capsys, *words):
    """Exit status and output of `clearance run` of the dry slider-crank."""
    status = main(["run", "slider_crank", "--turns", "1", "-o", str(tmp_path / "r.h5"), *words])
    return status, capsys.readouterr()


def test_command(tmp_path, capsys):
    """Chaos is recognised; the run's file has the statistics, and a picture stands beside it."""
    words = ["--error", "joint_C_force_max=60%", "--max-turns", "800", "--plot"]
    status, message = command(tmp_path, capsys, *words)
    assert status == 0, message.err
    assert "comparable until turn" in message.out
    assert "+- 60 % requested, +- " in message.out
    assert "reached for joint_C_force_peak" in message.out
    assert (tmp_path / "r_turns.png").stat().st_size > 20_000
    with h5py.File(tmp_path / "r.h5") as file:
        assert file["statistics/by_turn"].attrs["reached"]


def test_command_that_does_not_reach_it(tmp_path, capsys):
    """Exit status 1, what was reached, what it would take; the file stays."""
    status, message = command(tmp_path, capsys, "--error", "1%", "--max-turns", "160", "--json")
    document = json.loads(message.out)
    assert status == 1
    assert "only +- " in message.err
    assert "needs about" in message.err
    actual = document["turn_statistics"]
    assert not actual["reached"]
    assert actual["turns"] == 160
    assert (tmp_path / "r.h5").exists()


def test_command_of_other_motions(tmp_path, capsys):
    """Options of chaotic motion are refused elsewhere."""
    status, message = command(tmp_path, capsys, "-p", "model=ideal", "--max-turns", "800")
    assert status == 2
    assert "--max-turns and --starts are for chaotic motion" in message.err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--max-turns", "60"), "max_turns of 4 starts must be a whole number from 160 to "),
        (("--error", "joint_C_gap=5%"), "error: there is no 'joint_C_gap'"),
    ],
)
def test_command_that_is_refused_before_the_run(words, message, tmp_path, capsys):
    """Exit status 2, and no file."""
    status, text = command(tmp_path, capsys, *words)
    assert status == 2
    assert message in text.err
    assert not (tmp_path / "r.h5").exists()


def test_what_is_asked_for():
    """A largest value is the peak of a turn; the error of all is that of the others. Names that
    are there before a run are those of its series.
    """
    names = chaos.quantities(build(SCENE))
    assert names == list(turns.by_turn(cl.simulate(SCENE, turns=2)))
    asked = chaos.asked_of("joint_C_force_max=1e-2,5%", names)
    assert asked == dict.fromkeys(names, 0.05) | {FORCE: 0.01}


@pytest.mark.parametrize("seed", few_of(range(8), 3))
def test_a_drive_that_stays_behind_its_nominal_speed_is_named(seed):
    """At rest, or stopped after some turns: too few full turns, in words."""
    rng = np.random.default_rng(seed)
    nominal = float(rng.choice([-1.0, 1.0])) * 10.0 ** rng.uniform(-1, 2)
    crank = cl.Body("crank", 1.0, 10.0 ** rng.uniform(-4, 0), com=(0.1, 0))
    share = rng.choice([0.0, rng.uniform(0.0, 0.34)])
    drive = cl.Drive(crank, torque=0.0, start=0.0, speed_start=share * nominal, nominal=nominal)
    scene = cl.Scene(cl.Revolute(cl.ground, crank, name="A"), drive, gravity=(0, 0))
    with pytest.raises(cl.SimulationError, match=r"nominal speed: (\d|1[0-5]) full turns in 45"):
        cl.statistics(scene, {"drive_crank_torque_peak": 0.2}, max_turns=80, starts=1, check=False)
