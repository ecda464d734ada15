"""Stated errors: above the true ones, from the same start, in the file, and left out where they
would mean nothing.
"""

import re

import h5py
import numpy as np
import pytest

import clearance as cl
from clearance.accuracy import companion
from clearance.accuracy.request import Request, ToleranceSearch, names, printed
from clearance.commands.accuracy import prefixed, with_error
from clearance.metrics.metrics import metrics
from clearance.results.errors import Error, Errors
from clearance.results.result import open_result
from clearance.run.options import Output
from clearance.run.run import Run
from clearance.simulation import NotReached, prepare, write
from tests.seeds import few_of

SAMPLES = {"samples_per_turn": 100}


@pytest.fixture(scope="module")
def feeder():
    return cl.load_case("six_bar_feeder")


@pytest.fixture(scope="module")
def stated(feeder, tmp_path_factory):
    return cl.simulate(
        feeder, turns=2, path=tmp_path_factory.mktemp("stated") / "run.h5", **SAMPLES
    )


@pytest.fixture(scope="module")
def exact(feeder):
    return cl.simulate(feeder, turns=2, rtol=1e-12, error=None, **SAMPLES)


def test_numbers_with_their_errors():
    """The last digit is that of the error, which is rounded up; one below nine digits stands in
    units of its own.
    """
    assert with_error(128.32521, 8.03e-4, "N") == "128.3252 +- 0.0009 N"
    assert with_error(128.32521, 8.03e-4, "N", " (144.661)") == "128.3252 +- 0.0009 (144.661) N"
    assert with_error(128.32521, 3.0, "N") == "128 +- 3 N"
    assert with_error(128.3252111, 3e-9, "N") == "128.325211 N +- 3 nN"
    assert with_error(128.3252105, None, "N") == with_error(128.3252105, 0.0, "N") == "128.325 N"
    assert [prefixed(e, "m") for e in (9.7e-10, 2.01e-9, 1.0, 0.0)] == [
        "1 nm",
        "3 nm",
        "1 m",
        "0e+00 m",
    ]
    assert prefixed(1.5e-3, "1") == "2e-03 1"


def test_tiny_errors_and_units_with_a_prefix():
    """No unit has two prefixes; an error below 1e-12 of its number is rounding."""
    assert [prefixed(e, "um") for e in (3e-9, 2e-6, 0.4)] == ["3e-15 m", "2 pm", "400 nm"]
    assert [prefixed(e, "m") for e in (1e-11, 2e-22)] == ["10 pm", "2e-22 m"]
    assert prefixed(2e-9, "rpm") == "2e-09 rpm"
    assert with_error(9.87, 4e-15, "N m") == "9.87 N m +- below 1e-12 of it"
    assert with_error(9.87, 4e-11, "N m") == "9.87 N m +- 40 pN m"


def test_stated_errors_cover_the_true_ones(feeder, stated, exact):
    """All extremes and means of the feeder at five tolerances, against rtol 1e-12.

    Nine in ten are covered, none is wrong by four times what is stated: which ones are not
    covered is chance, and depends on the processor. Most are stated less than 1000 times too
    large; the trajectory's less than 100 times, for it is twice that of a run that is some ten
    times worse.
    """
    errors, shares = stated.errors, []
    for rtol in (1e-4, 1e-5, 1e-6, 1e-7, 1e-8):
        run = cl.simulate(feeder, turns=2, rtol=rtol, error="state", **SAMPLES)
        for name, error in run.errors.items():
            if name.startswith(("joints/", "drives/")):
                true = abs(error.value - exact.extreme(name, errors.begin).value)
                shares.append(true / error.stated)
    assert len(shares) >= 50
    assert np.mean(np.array(shares) <= 1.0) >= 0.9
    assert max(shares) < 4.0
    assert np.median(shares) > 1e-3
    c = stated.clearances["B"]
    true = np.abs(stated.joint("B").eccentricity - exact.joint("B").eccentricity).max() / c
    assert true < errors.trajectory < 100.0 * true
    for path, share in errors.channels.items():
        one, two = stated.values(path), exact.values(path)
        assert np.abs(one - two).max() <= max(share, 1e-12) * max(
            np.ptp(one), 1e-9 * np.abs(one).max()
        )


def test_extremes_of_any_stretch_have_their_errors(stated, exact):
    """Of the start-up and of the settled motion, covered both; a name that is none of a located
    extreme raises.
    """
    turn = stated.turn
    for begin, end in ((0.0, turn), (turn, 2 * turn), (0.0, np.inf)):
        error = stated.error("joints/B/force_max", begin, end)
        assert (
            abs(error.value - exact.extreme("joints/B/force_max", begin, end).value) <= error.stated
        )
    with pytest.raises(KeyError, match="no located extreme"):
        stated.error("joints/B/power_loss_max")
    with pytest.raises(KeyError, match="the run has no such number"):
        stated.errors["joint_Z_force_max"]


def test_the_films_part(stated, feeder):
    """Against films of larger viscosity, to which their force is proportional: within 10 % of the
    change, whose difference is taken at rtol 1e-9.
    """
    share = stated.facts("joints/B")["film_table_error_closing"]
    thick = cl.load_case("six_bar_feeder", viscosity=0.05 * (1.0 + 0.01))
    one, two = (cl.simulate(s, turns=2, rtol=1e-9, error=None, **SAMPLES) for s in (feeder, thick))
    for name in ("joints/B/gap_min", "joints/B/film_pressure_max"):
        change = (
            abs(two.extreme(name, stated.turn).value - one.extreme(name, stated.turn).value)
            * share
            / 0.01
        )
        assert stated.errors[name].film == pytest.approx(change, rel=0.1)


def mixed(seed):
    """A feeder with a narrow peak of pressure, 9.64 MPa, and random scenes of the cases. Every
    other one has thin oil: its contacts set in, and pressure peaks microseconds after.
    """
    if seed == 0:
        numbers = {"joints": "B,E", "speed": 61.93, "viscosity": 5.97e-3, "clearance": 63e-6}
        return cl.load_case("six_bar_feeder", model="mixed", **numbers)
    rng = np.random.default_rng(seed)
    return cl.load_case(
        ("slider_crank", "four_bar", "six_bar_feeder")[rng.integers(3)],
        model="mixed",
        transition=("fuzzy", "load_sharing")[rng.integers(2)],
        viscosity=10.0 ** rng.uniform(*((-3.3, -2.3) if seed % 2 else (-2.5, -1.0))),
        clearance=10.0 ** rng.uniform(-5.0, -4.0),
        speed=cl.rpm(10.0 ** rng.uniform(2.0, 3.0)),
    )


@pytest.mark.filterwarnings("ignore::clearance.RunWarning")
@pytest.mark.parametrize("count", few_of([1, 36], 1))
def test_ranges10_narrow_peaks_of_film_pressure(count):
    """Of that many scenes, the difference to the largest value and sample of a run at rtol 1e-11.

    Stated errors are at most 1e-3 of the peak. They cover nine in ten, the others by a factor of
    four: two runs may err alike by chance. Of 74 such peaks of 72 scenes 3 are not covered. Films
    stay as they are. A step across a contact's onset had peaks that were wrong by up to 1e-3, and
    stated errors of up to 1e-2.
    """
    shares = []
    for seed in range(count):
        scene = mixed(seed)
        run = cl.simulate(scene, turns=2)
        exact = cl.simulate(scene, turns=2, rtol=1e-11, error=None, samples_per_turn=10_000)
        for joint in scene.clearance_joints:
            path, begin = f"joints/{joint.name}/film_pressure", run.errors.begin
            error = run.errors[f"{path}_max"]
            seen = exact.values(path)[exact.time >= begin].max()
            true = max(exact.extreme(f"{path}_max", begin).value, float(seen))
            assert error.stated <= 1e-3 * true, seed
            shares.append(abs(error.value - true) / error.stated)
    assert np.mean(np.array(shares) <= 1.0) >= 0.9
    assert max(shares) < 4.0


def unhurried(rng):
    """A slow crank with a damped pendulum and a spring: its steps are the longest."""
    speed, length = rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-1.0, 0.5), rng.uniform(0.1, 1.0)
    crank = cl.Body("crank", 1.0, 0.1, points={"pin": (length, 0)}, angle=rng.uniform(-3.0, 3.0))
    bob = cl.Body("bob", 1.0, 0.1, com=(0.3 * length, 0), angle=rng.uniform(-3.0, 3.0))
    return cl.Scene(
        cl.Revolute(cl.ground, crank, name="main"),
        cl.Revolute(crank["pin"], bob, name="pin"),
        cl.Drive(crank, speed=speed),
        cl.TorsionSpring(crank, bob, damping=rng.uniform(1.0, 2.0) * abs(speed), name="a"),
        cl.TorsionSpring(cl.ground, crank, stiffness=10.0 ** rng.uniform(-2.0, 2.0), name="b"),
        gravity=(0.0, rng.uniform(-0.3, 0.0) * speed**2),
    )


@pytest.mark.parametrize("count", [10, pytest.param(30, marks=pytest.mark.slow)])
def test_steps_that_no_tolerance_shortens(count):
    """Runs at 1e-6 and 1e-5 make nearly the same steps; the companion makes others, so that 97 % of
    the numbers are within their stated errors of runs at 1e-11 with short steps.
    """
    within = []
    for seed in range(count):
        scene = unhurried(np.random.default_rng(seed))
        errors = cl.simulate(scene, turns=1).errors
        exact = cl.simulate(scene, turns=1, rtol=1e-11, max_step=scene.turn / 300).errors
        off = {n: abs(e.value - exact[n].value) - 1e-11 * abs(e.value) for n, e in errors.items()}
        within += [value <= errors[name].stated for name, value in off.items()]
    assert np.mean(within) > 0.97


def test_errors_in_the_file(stated):
    """Plain h5py reads them, with units; a second opening gives the same."""
    with h5py.File(stated.path) as file:
        names = [n.decode() for n in file["errors/name"]]
        i = names.index("joint_B_force_max")
        assert file["errors/units_of"][i].decode() == "N"
        assert file["errors/stated"][i] == stated.errors["joint_B_force_max"].stated
        assert file["extremes/stated"].shape == file["extremes/value"].shape
        assert file["errors"].attrs["companion_rtol"] == pytest.approx(1e-5)
    with open_result(stated.path) as again:
        assert dict(again.errors) == dict(stated.errors)
        assert (
            float(again.to_xarray()["errors/stated"].sel(name="trajectory"))
            == stated.errors.trajectory
        )


def test_what_gets_no_errors(tmp_path, feeder):
    """Impacts, checkpoints, no request: the file states why, and the mapping is empty."""
    dry = cl.simulate(cl.load_case("slider_crank", model="dry"), turns=0.1, **SAMPLES)
    assert len(dry.errors) == 0
    assert dry.errors.reason.startswith("neighbouring trajectories may part at impacts; --error")
    none = cl.simulate(feeder, turns=0.1, error=None, **SAMPLES)
    assert none.errors.reason == "none was requested"
    stored = cl.simulate(feeder, turns=0.1, path=tmp_path / "run.h5", checkpoint=60.0, **SAMPLES)
    assert stored.errors.reason.startswith("a run with checkpoints is a long one: ")
    assert np.isnan(stored.errors.trajectory)
    with pytest.raises(KeyError, match="checkpoints"):
        stored.errors["trajectory"]
    with pytest.raises(ValueError, match="'exact' is no number"):
        cl.simulate(feeder, turns=0.1, error="exact")


def test_a_run_with_checkpoints(feeder, tmp_path):
    """Interrupted and gone on: the errors of the run that went through, to the last bit."""

    def errors_of(name, progress=None):
        options = {"turns": 0.5, "checkpoint": 1e-9, "error": "state", "samples_per_turn": 10_000}
        return cl.simulate(feeder, path=tmp_path / name, progress=progress, **options).errors

    def interrupt(share):
        if 0.4 <= share < 1.0:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        errors_of("run.h5", interrupt)
    again, through = errors_of("run.h5"), errors_of("through.h5")
    assert again.rows == through.rows
    assert again["joint_B_force_max"].stated > 0.0


def test_a_run_whose_numbers_change():
    """The second run has the same changes at the same times: stated errors are small, and above
    those against rtol 1e-11. The film's part is that of the table after the change too.
    """
    scene = cl.load_case("slider_crank", model="lubricated")

    def record(rtol, error):
        run = prepare(scene, turns=0.5, rtol=rtol, **SAMPLES)
        run.every(0.2 * scene.turn, lambda r: r.change({"joints/C/clearance": wider(r)}))
        return write(run, Output(), error=error, settle=0.0)

    def wider(run):
        return 1.05 * run.mechanism.scene.clearance_joints[0].clearance

    errors, exact = record(1e-6, "auto").errors, metrics(record(1e-11, None), 0.0)
    for name in ("joint_C_force_max", "joint_C_gap_min", "drive_crank_torque_max"):
        assert 0.0 < errors[name].relative < 1e-3, name
        assert abs(errors[name].value - exact[name].value) <= errors[name].stated, name
        assert 0.0 < errors[name].film < 1e-3 * abs(errors[name].value), name


@pytest.mark.slow
def test_films_that_are_solved_as_the_run_goes():
    """Not by default, for a second run costs as much again; stated where they are requested."""
    scene = cl.load_case("slider_crank", model="lubricated", film="fem")
    short = {"turns": 0.01, "samples_per_turn": 400}
    reason = companion.reason_without(prepare(scene, **short), "auto")
    assert reason.endswith('--error state (error="state") makes it')
    errors = cl.simulate(scene, error="state", **short).errors
    table = cl.simulate(cl.load_case("slider_crank", model="lubricated"), **short).errors
    name = "joint_C_force_max"
    assert errors[name].value == pytest.approx(table[name].value, rel=0.01)  # of the meshes
    ratio = errors[name].stated / table[name].stated
    assert 0.03 < ratio < 30.0  # two methods: of the same order


def test_a_companion_begins_where_its_run_began(feeder):
    """Also where that is not the scene's start: nearly the same first sample."""
    run = prepare(feeder, turns=0.1, start="quasi-static", **SAMPLES)
    start = companion.Start.of(run)
    first = companion.companion(run, start, 1e-5).joint("B").eccentricity[0]
    plain = companion.companion(
        prepare(feeder, turns=0.1, **SAMPLES), companion.Start.of(run), 1e-5
    )
    scene = cl.simulate(feeder, turns=0.1, error=None, **SAMPLES).joint("B").eccentricity[0]
    assert np.array_equal(first, plain.joint("B").eccentricity[0])
    assert np.abs(first - scene).max() > 1e-3 * 1e-4


def test_a_companion_that_fails(feeder, monkeypatch):
    """The next tighter one takes its place; where that fails too, the run stays and states why it
    states nothing.
    """
    asked, plain = [], companion.companion

    def failing(run, start, rtol, times=0.0, longer=1.0, least=0.0):
        asked.append(rtol)
        if rtol > least:
            raise companion.CompanionFailed(f"the companion at rtol {rtol:g} failed")
        return plain(run, start, rtol, times, longer)

    monkeypatch.setattr(companion, "companion", lambda *a, **b: failing(*a, **b, least=1e-6))
    result = cl.simulate(feeder, turns=0.1, **SAMPLES)
    assert asked == pytest.approx([1e-5, 1e-7, 1e-7])
    assert result.errors.rtol == pytest.approx((1e-6, 1e-7))
    monkeypatch.setattr(companion, "companion", failing)
    result = cl.simulate(feeder, turns=0.1, **SAMPLES)
    assert result.complete
    assert result.errors.reason == "the companion at rtol 1e-07 failed"


def test_an_interrupt_keeps_the_run(feeder, tmp_path, monkeypatch):
    """The run is complete; only its errors are missing."""

    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(companion, "companion", interrupted)
    with pytest.raises(KeyboardInterrupt) as request:
        cl.simulate(feeder, turns=0.1, path=tmp_path / "run.h5", **SAMPLES)
    assert "without stated errors" in request.value.__notes__[0]
    with open_result(tmp_path / "run.h5") as stored:
        assert stored.complete
        assert not stored.errors


def test_motions_that_do_not_forget_their_start():
    """A double pendulum loses digits as it goes: the stated error of its trajectory states so, and
    is above the true.
    """
    scene = cl.load_case("double_pendulum")
    actual, exact = (
        cl.simulate(scene, until=4.0, rtol=r, error=e) for r, e in ((1e-4, "state"), (1e-12, None))
    )
    true = max(np.abs(actual[b].theta - exact[b].theta).max() for b in actual.names("bodies"))
    assert true < actual.errors.trajectory


def test_shares_and_sums():
    """Relative to the value, of nothing infinite; the total has both parts."""
    error = Error(-4.0, 0.2, "N", film=0.1)
    assert (error.relative, error.total) == (0.05, pytest.approx(0.3))
    assert (Error(0.0, 0.1).relative, Error(0.0, 0.0).relative) == (np.inf, 0.0)
    assert "none was requested" in repr(Errors(reason="none was requested"))


def test_json(tmp_path, typed):
    """The command's document has them beside its numbers; --no-error leaves them out."""
    out = ["--turns 0.1 -o", tmp_path / "r.h5", "--json --samples-per-turn 100"]
    document = typed("run six_bar_feeder", *out).document
    numbers = document["errors"]["numbers"]
    assert (
        document["joints"]["B"]["peak_force_error"] == numbers["joints/B/force_max"]["stated"] > 0.0
    )
    document = typed("run six_bar_feeder --no-error", *out).document
    assert document["errors"] == {"reason": "none was requested"}
    assert "peak_force_error" not in document["joints"]["B"]


# --- errors that are requested
def test_requests_are_read():
    """Numbers, percent, names; what is none is named."""
    assert Request.of("5%").asked == {"all": pytest.approx(0.05)}
    named = Request.of("joint_B_force_max=1e-4, trajectory=1e-5")
    assert named.asked == {"joint_B_force_max": 1e-4, "trajectory": 1e-5}
    assert Request.of(1e-3).asked == {"all": 1e-3}
    assert Request.of({"joint_B_force_max": "1%"}).asked == {"joint_B_force_max": 0.01}
    for wrong, text in (
        ("much", "no number"),
        (-1.0, "error"),
        (2.0, "less than 1"),
        ({}, "give a number"),
        ("1e-3,1e-4", "requests twice all numbers"),
        ("a=1e-3,b=", "error of b: '' is no number"),
    ):
        with pytest.raises(ValueError, match=text):
            Request.of(wrong)


def test_a_request_is_reached(feeder, exact):
    """All that is printed, 1e-3: stated and true errors are below it, and the tolerance was not
    tighter than 1e-6.
    """
    result = cl.simulate(feeder, turns=2, error=1e-3, **SAMPLES)
    assert result.solver["rtol"] > 1e-6
    assert (result.errors.asked, result.errors.cannot) == ({"all": 1e-3}, "")
    force = result.errors["joint_B_force_max"]
    # 1e-7 of the force; from the first, loose companion it was 3e-4
    assert force.film < force.stated
    truth = metrics(exact)
    for name in printed(result.errors):
        true = abs(result.errors[name].value - truth[name].value)
        assert true <= result.errors[name].stated <= 1e-3 * abs(result.errors[name].value)


def test_a_request_beyond_the_film_table(feeder, tmp_path):
    """1e-6 of the smallest gap: the table's own error is larger, which is reported before digits
    are bought.
    """
    with pytest.raises(
        NotReached, match=r"the film table alone makes 1\.[0-9]e-04 of joint_B_gap_min"
    ) as stop:
        cl.simulate(
            feeder, turns=2, error={"joint_B_gap_min": 1e-6}, path=tmp_path / "run.h5", **SAMPLES
        )
    stored = stop.value.result
    assert stored.complete
    assert stored.solver["rtol"] >= 1e-7
    assert "film table" in stored.errors.cannot
    reached = cl.simulate(feeder, turns=2, error={"integration": 1e-6}, **SAMPLES)
    assert all(error.film == 0.0 for error in reached.errors.values())  # tables are left aside
    assert max(reached.errors[n].relative for n in printed(reached.errors)) <= 1e-6


def test_requests_that_cannot_be_reached(feeder, tmp_path):
    """Chaos, a name there is not, checkpoints, a run that fails, a tolerance beyond rounding: each
    states so.
    """
    dry = cl.load_case(
        "slider_crank", model="dry", clearance=1e-3, speed=cl.rpm(5000), friction_coefficient=0.03
    )
    with pytest.raises(NotReached, match="trajectories part"):
        cl.simulate(dry, turns=20, error=1e-2, samples_per_turn=20)
    with pytest.raises(ValueError, match="checkpoint"):
        cl.simulate(feeder, turns=0.1, error=1e-3, checkpoint=60.0, path=tmp_path / "run.h5")
    with pytest.raises(cl.SimulationError, match="failed at t ="):
        cl.simulate(feeder, turns=0.1, error=1e-3, max_steps=5, **SAMPLES)
    with pytest.raises(NotReached, match="rounding|does not fall"):
        cl.simulate(feeder, turns=0.1, error="integration=1e-13", **SAMPLES)


@pytest.mark.parametrize(
    ("case", "parameters", "length"),
    [
        ("six_bar_feeder", {"model": "mixed"}, {"turns": 3}),
        ("slider_crank", {}, {"turns": 3}),
        ("double_pendulum", {}, {"until": 0.2}),
    ],
)
def test_names_before_anything_runs(case, parameters, length, monkeypatch):
    """Those of a run that has not begun are those that it has, and a wrong one ends it there."""
    scene = cl.load_case(case, **parameters)
    run = cl.simulate(scene, error=None, **length)
    expected = {*metrics(run), *run.located.names, "trajectory"}
    assert names(prepare(scene, **length), metrics) == expected
    monkeypatch.setattr(Run, "go", None)
    with pytest.raises(ValueError, match=r"has no 'trajectry' \(did you mean trajectory\?\)"):
        cl.simulate(scene, error={"trajectry": 0.1}, **length)


def test_an_interrupted_request_keeps_its_best_run(feeder, tmp_path, monkeypatch):
    """The second run of the ladder is interrupted: the first one's file is there, with its
    errors.
    """
    plain, begun = ToleranceSearch._attempt, []

    def attempt(self, rtol):
        begun.append(rtol)
        if len(begun) > 1:
            raise KeyboardInterrupt
        return plain(self, rtol)

    monkeypatch.setattr(ToleranceSearch, "_attempt", attempt)
    monkeypatch.setattr(
        ToleranceSearch, "_verdict", lambda *_: setattr(_[0], "past", [(1.0, 10.0)])
    )
    with pytest.raises(KeyboardInterrupt) as request:
        cl.simulate(feeder, turns=0.1, error=1e-3, path=tmp_path / "run.h5", **SAMPLES)
    assert "best run so far is stored" in request.value.__notes__[0]
    with open_result(tmp_path / "run.h5") as stored:
        assert stored.errors.asked == {"all": 1e-3}


def quick_return(speed: float, clearance: float, viscosity: float, force: float) -> cl.Scene:
    """A crank, a lever with a slot, and a ram that cuts, on a pin with a liner."""
    crank = cl.Body.bar("crank", {"shaft": 0, "pin": 0.06}, section=0.025)
    lever = cl.Body.bar("lever", {"pivot": 0, "tip": 0.28}, section=(0.02, 0.04), angle=1.5)
    rod = cl.Body.bar("rod", {"tip": 0, "wrist": 0.16}, section=0.02)
    ram = cl.Body("ram", mass=6.0, inertia=0.05, points={"wrist": (0, 0)})
    pin = {"radius": 0.012, "length": 0.024, "lubricant": cl.Lubricant(viscosity)}
    pin |= {"clearance": clearance, "film": cl.elastic_film(liner=3e-14, pressure_viscosity=0.0)}
    return cl.Scene(
        cl.Revolute(cl.ground, crank["shaft"]),
        cl.Revolute(cl.ground.at(0, -0.14), lever["pivot"]),
        cl.PinSlot(lever["pivot"], crank["pin"]),
        cl.Revolute(lever["tip"], rod["tip"]),
        cl.ClearanceRevolute(rod["wrist"], ram["wrist"], name="wrist", **pin),
        cl.Prismatic(cl.ground.at(0.16, 0.13), ram["wrist"]),
        cl.Drive(crank, speed=speed),
        cl.Force(ram["wrist"], x=force),
    )


@pytest.mark.slow
def test_a_film_is_blamed_for_its_own_part_alone():
    """Random machines whose first, loose runs may part: where the film's table is the reason, its
    part of a run at 1e-6 is above half of the request. It was less in five of 96, down to a
    twentieth. Three may be peaks that come and go: one in a hundred does, on any processor.
    """
    asked, blamed = 0.1, []
    for rng in map(np.random.default_rng, (0, 1, 4, 5)):
        for draw in rng.uniform([6.0, 9e-5, -2.0, 100.0], [30.0, 1.2e-4, -1.0, 700.0], (24, 4)):
            scene = quick_return(draw[0], draw[1], 10.0 ** draw[2], draw[3])
            try:
                cl.simulate(scene, turns=2, error=asked, **SAMPLES)
            except NotReached as stop:
                if "film table alone" in str(stop):
                    errors = cl.simulate(scene, turns=2, **SAMPLES).errors
                    parts = [abs(errors[n].film / errors[n].value) for n in printed(errors)]
                    blamed.append(max(parts))
    assert sum(part < 0.5 * asked for part in blamed) <= 3, blamed


def test_the_command_asks(tmp_path, typed):
    """Exit status 0 where it is reached, 1 with the file where not, 2 for what does not go
    together.
    """
    out = ["--turns 1 -o", tmp_path / "r.h5", "--samples-per-turn 100"]
    assert (
        "0.01 asked, over the value, at most " in typed("run six_bar_feeder --error 1%", *out).out
    )
    document = typed(
        "run six_bar_feeder --error joint_B_gap_min=1e-6 --json", *out, status=1
    ).document
    assert "the film table alone" in document["message"]
    assert document["errors"]["asked"] == {"joint_B_gap_min": 1e-6}
    assert "leave out --rtol" in typed.line("run six_bar_feeder --error 1% --rtol 1e-3", *out)


# --- sweeps
def test_sweeps_have_columns_of_errors(tmp_path):
    """Beside each metric, with its units; as `simulate` states them, film table and integration
    together. A sweep has more metrics, and the geometric mean over them is another: within 10 %.
    """
    points = cl.grid(speed=[20.0, 30.0])
    options = {"turns": 1, "workers": 1, "channels": [], **SAMPLES}
    sweep = cl.sweep("six_bar_feeder", points, tmp_path / "stated", error="state", **options)
    plain = cl.simulate(cl.load_case("six_bar_feeder", speed=30.0), turns=1, **SAMPLES).errors
    for name in ("joint_B_force_max", "joint_B_gap_min", "dissipated_per_turn"):
        assert sweep.metrics[f"{name}_error"][1] == pytest.approx(plain[name].total, rel=0.1)
        assert sweep.known[f"{name}_error"][0] == sweep.known[name][0]
    asked = cl.sweep(
        "six_bar_feeder", points, tmp_path / "asked", error={"joint_B_gap_min": 1e-6}, **options
    )
    assert (asked.status == "failed").all()
    assert all("film table alone" in reason for reason in asked.reason)
    assert np.isfinite(asked.metrics["joint_B_gap_min_error"]).all()


def test_sweeps_reach_a_request(tmp_path):
    """Each point at its tolerance, deviations from ideal joints among its numbers."""
    points = cl.grid(speed=[cl.rpm(3000), cl.rpm(4000)])
    options = {"fixed": {"model": "lubricated"}, "turns": 1, "workers": 1, "channels": []}
    sweep = cl.sweep("slider_crank", points, tmp_path / "s", error="1%", **options)
    assert sweep.done.all(), sweep.reason
    numbers = sweep.metrics
    for name in ("joint_C_force_max", "joint_C_gap_min", "drive_crank_torque_max"):
        assert (numbers[f"{name}_error"] <= 0.01 * np.abs(numbers[name])).all(), name
    assert (numbers["slider_position_deviation_max"] > 0.0).all()


def test_sweeps_without_errors_say_why(tmp_path):
    """Impacts: points are done, their reason states why nothing is stated."""
    points = cl.grid(speed=[20.0, 30.0])
    dry = cl.sweep(
        "slider_crank",
        points,
        tmp_path / "dry",
        error="state",
        turns=0.1,
        workers=1,
        channels=[],
        **SAMPLES,
    )
    assert dry.done.all()
    assert all("neighbouring trajectories may part at impacts" in reason for reason in dry.reason)
    assert not any(n.endswith("_error") for n in dry.metrics if n != "period_error")
    for error, text in (
        ("much", "no number"),
        ("joint_C_force_max=1e-3", "has no 'joint_C_force_max'"),
        ({"joint_C_force_peek_mean": 0.1}, "did you mean joint_C_force_peak_mean"),
    ):
        with pytest.raises(ValueError, match=text):
            cl.sweep("slider_crank", points, tmp_path / "wrong", error=error, turns=1)
        assert not (tmp_path / "wrong").exists()


@pytest.mark.parametrize("model", few_of(["dry", "mixed"], 1))
def test_users17_a_dry_run_names_both_ways_to_errors(model, tmp_path, typed):
    """At a random point, in print and in JSON: --error and --steady; a film states its errors."""
    rng = np.random.default_rng(17)
    speed, gap = rng.uniform(20.0, 40.0), rng.uniform(0.1, 0.5)
    words = ["slider_crank", "-p", f"model={model}", "-p", f"speed={speed:.3f}"]
    words = ["run", *words, "-p", f"clearance={gap:.3f}mm", "--turns", "0.1"]
    lines = re.split(r"\n(?=  \w)", typed(*words, "-o", tmp_path / "a.h5").out)
    line = next(" ".join(n.split()) for n in lines if n.startswith("  error  "))
    reason = typed(*words, "--json -o", tmp_path / "b.h5").document["errors"].get("reason", "")
    for text in (line, reason):
        assert [way in text for way in ("--error 1e-3", "--steady 1e-6")] == [model == "dry"] * 2
