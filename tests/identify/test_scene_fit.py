"""Parameters of mechanisms from their records: slopes, intervals that hold, words, files."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import clearance as cl
from clearance.cli import main
from clearance.identify.fit_plan import plan
from clearance.identify.free import Free, Varying
from clearance.identify.measured import Measured, read
from clearance.identify.scene_fit import Curve, Problem, Solved
from clearance.identify.scene_parameters import fit
from clearance.identify.turn_statistics import reason_without
from clearance.identify.verdict import Judge, dependence, runs_test, verdict
from clearance.run import progress_bar
from tests.mechanisms import bar, loop

STIFFNESS, DAMPING = 1.0, 0.2
FREE = {"springs/S/stiffness": (0.3, 3.0), "springs/S/damping": (0.05, 1.0)}
FIRST = "springs/S/stiffness"
TIMES = np.linspace(0.1, 20.0, 200)


def oscillator(stiffness=STIFFNESS, damping=DAMPING):
    """A mass of 1 kg on a spring with a damper, 1 m from its rest, at rest."""
    block = cl.Body("block", 1.0, 1e-3, position=(6.0, 0.0))
    spring = cl.SpringDamper(
        cl.ground, block, stiffness=stiffness, damping=damping, free_length=5.0, name="S"
    )
    slide = cl.Prismatic(cl.ground, block, name="G")
    return cl.Scene(slide, spring, gravity=(0.0, 0.0), name="oscillator")


def exact(time, stiffness=STIFFNESS, damping=DAMPING):
    """Position of the oscillator [m], by its closed form."""
    decay = 0.5 * damping
    omega = math.sqrt(stiffness - decay**2)
    turn = omega * time
    return 5.0 + np.exp(-decay * time) * (np.cos(turn) + decay / omega * np.sin(turn))


def slopes(time):
    """Derivatives of the position by the logarithms of stiffness and damping, of closed forms."""
    columns = []
    for d_k, d_d in ((1e-5, 0.0), (0.0, 1e-5)):
        ends = (
            exact(time, STIFFNESS * math.exp(s * d_k), DAMPING * math.exp(s * d_d)) for s in (1, -1)
        )
        high, low = ends
        columns.append((high - low) / 2e-5)
    return np.stack(columns, axis=1)


def record(time, values, along="time", units="m"):
    """A record in memory."""
    return Measured(Path("bench.csv"), "x", units, along, time, values)


def noisy(seed, sigma=0.02):
    """A record of the oscillator with normal errors."""
    errors = np.random.default_rng(seed).normal(0.0, sigma, TIMES.size)
    return record(TIMES, exact(TIMES) + errors)


def problem_at(data, sigma):
    """The fit of an oscillator that is not that of the record."""
    free = [Free(n, *b, "?") for n, b in FREE.items()]
    scene = oscillator(1.1, 0.25)
    return Problem(scene, free, [Curve(data, "bodies/block/x", sigma)])


def test_slopes_and_covariance_are_those_of_the_closed_form():
    """To 1e-5 of their size: runs are integrated to 1e-7, and differences of 1e-5 err by 1e-10."""
    problem = problem_at(noisy(0), 0.02)
    truth = np.log([STIFFNESS, DAMPING])
    expected = slopes(TIMES) / 0.02
    actual = problem.jacobian(truth)
    assert np.abs(actual - expected).max() < 1e-5 * np.abs(expected).max()
    judged = verdict(problem, problem.solved(truth), [problem.solved(truth)])
    exact_covariance = np.linalg.inv(expected.T @ expected)
    # at the estimate, which is some 2 % from the truth
    assert judged.covariance == pytest.approx(
        exact_covariance, rel=0.15, abs=0.05 * exact_covariance[0, 0]
    )


@pytest.mark.slow
def test_intervals_hold_the_truth():
    """Of 200 draws of the noise 92 to 98 % of the 95 % intervals, for known and unknown noise: the
    deviation of a share of 200 is 1.5 %.
    """
    inside = np.zeros((2, 2))
    for seed in range(200):
        for row, sigma in enumerate((0.02, None)):
            problem = problem_at(noisy(seed), sigma)
            best = problem.solved(problem.middle)
            problem.weighed(best.x)
            best = problem.solved(best.x)
            for column, (i, value) in enumerate(
                zip(verdict(problem, best, [best]).intervals, (STIFFNESS, DAMPING), strict=True)
            ):
                inside[row, column] += i.low <= value <= i.high
    assert inside.min() >= 0.92 * 200, inside
    assert inside.max() <= 0.98 * 200 + 2, inside


CASE = {"model": "lubricated", "film": "pinkus_sternlicht", "film_torques": True}
BOUNDS = {"clearance": "0.1mm:1mm", "viscosity": (0.05, 1.0), "bodies/slider/mass": "50g:500g"}
CHANNEL = "bodies/slider/ax=slider_acceleration_measured_m_s2"
#: noise [m/s2]; linearised estimates of clearance [m], viscosity [Pa s], mass [kg]; relative
#: standard errors; correlations, of a record with this truth
RECORDS = {
    "a": (
        297.811,
        (0.48616e-3, 0.36108, 0.14401),
        (0.0289, 0.0688, 0.0361),
        (0.769, -0.668, -0.191),
    ),
    "b": (
        293.581,
        (0.27348e-3, 0.15469, 0.14260),
        (0.0797, 0.1969, 0.0877),
        (0.854, -0.503, -0.048),
    ),
}


@pytest.fixture(scope="module", params=["a", pytest.param("b", marks=pytest.mark.slow)])
def of_record(request, tmp_path_factory):
    """A record of a lubricated slider-crank with known truth, and its fit."""
    path = Path(__file__).parent / "data" / f"fit_record_{request.param}.csv"
    scene = cl.load_case("slider_crank", **CASE)
    noise, *expected = RECORDS[request.param]
    folder = tmp_path_factory.mktemp("fit")
    return fit(scene, path, BOUNDS, CHANNEL, noise=noise, folder=folder), expected, folder


def test_estimates_are_those_of_an_independent_code(of_record):
    """Within 0.3 standard errors of its linearised estimates, whose second order is some 0.2.

    Errors within 8 %, correlations within 0.04: theirs are at the truth, ours at the estimate.
    """
    actual, (values, errors, correlations), _ = of_record
    for interval, value, error in zip(actual.verdict.intervals, values, errors, strict=True):
        assert interval.value == pytest.approx(value, abs=0.3 * error * value)
        assert interval.deviation / interval.value == pytest.approx(error, rel=0.08)
        assert interval.kind == "linear"
    c = actual.verdict.correlation
    assert (c[0, 1], c[0, 2], c[1, 2]) == pytest.approx(correlations, abs=0.04)
    assert actual.verdict.doubts == []
    assert actual.verdict.minima == []


def test_all_starts_end_in_one_minimum(of_record):
    """Within a twentieth of a standard error: starts are followed until the cost stands still."""
    actual, (values, errors, _), _ = of_record
    ends = np.array([e.x for e in actual.ends])
    assert len(ends) == 5
    assert (np.abs(ends - actual.best.x).max(axis=0) < 0.05 * np.array(errors)).all()


def test_a_fit_is_in_its_folder(of_record, capsys, monkeypatch):
    """Its numbers, and the run of the fitted scene, which runs again; ends of starts are read from
    the folder, so that the same call computes none anew.
    """
    actual, _, folder = of_record
    document = json.loads((folder / "fit.json").read_text())
    assert document["parameters"]["viscosity"]["value"] == actual.values["viscosity"]
    with cl.open_result(folder / "run.h5") as run:
        assert run.scene["joints"][2]["clearance"] == actual.values["clearance"]
    scene, _ = cl.again(folder / "run.h5")
    assert scene.to_json() == actual.scene.to_json()
    monkeypatch.setattr(Problem, "followed", None)
    curve = actual.problem.curves[0]
    same = fit(
        cl.load_case("slider_crank", **CASE),
        curve.measured,
        BOUNDS,
        "bodies/slider/ax",
        noise=curve.sigma,
        folder=folder,
    )
    assert [e.x.tolist() for e in same.ends] == [e.x.tolist() for e in actual.ends]


def test_pictures_and_page(of_record, tmp_path):
    """A picture with panels for record, residuals and three regions; a page with all estimates."""
    actual, _, _ = of_record
    assert len(actual.plot().axes) == 5
    page = actual.report(tmp_path / "fit.html").read_text()
    assert "bodies/slider/mass" in page and "<svg" in page or "data:image/png" in page
    with pytest.raises(ValueError, match=r"must end in \.html"):
        actual.report(tmp_path / "fit.txt")
    assert "95 % interval" in actual._repr_html_()


def test_a_product_is_stated_where_two_parameters_enter_as_one():
    """Force and gap of a short film depend on viscosity and length by mu L^3 alone."""
    scene = cl.load_case("slider_crank", model="lubricated", film="short")
    run = cl.simulate(scene, turns=3, samples_per_turn=180, error=None)
    times = run.turns_at(run.time)
    data = record(times[360:540] - 2.0, run["slider"].ax[360:540], "angle", "m/s2")
    bounds = {"viscosity": (0.05, 2.0), "joints/C/length": "10mm:100mm"}
    noise = 0.01 * float(np.ptp(data.values))
    actual = fit(scene, data, bounds, "bodies/slider/ax", noise=noise, starts=1)
    (line,) = actual.verdict.products
    assert "cannot be told apart: they enter as viscosity * joints/C/length^3" in line
    assert all(i.kind == "inseparable" and math.isnan(i.low) for i in actual.verdict.intervals)


def test_two_minima_are_both_named():
    """Samples once a second see a frequency w as they see 2 pi - w: two stiffnesses."""
    times = np.arange(1.0, 13.0)
    values = exact(times, 4.0, 1e-9)
    free = {"springs/S/stiffness": (3.0, 25.0)}
    scene = oscillator(4.3, 1e-9)
    noise = 0.3
    errors = np.random.default_rng(4).normal(0.0, noise, times.size)
    actual = fit(
        scene, record(times, values + errors), free, "bodies/block/x", noise=noise, starts=8
    )
    ((other, growth),) = actual.verdict.minima
    pair = sorted([actual.values["springs/S/stiffness"], other["springs/S/stiffness"]])
    # within six deviations of the two; their costs are those of one another's aliases
    assert pair == pytest.approx([4.0, (2.0 * math.pi - 2.0) ** 2], rel=0.1)
    assert growth < 4.0
    assert actual.verdict.chances[1] == pytest.approx(1.0 / (1.0 + math.exp(0.5 * growth)))
    chance = f"another minimum has a probability of {actual.verdict.chances[1]:.0%}"
    assert any(chance in d for d in actual.verdict.doubts)


def test_nuisances_of_a_sensor():
    """Gain, offset and a shifted clock beside stiffness and damping, from an exact record: to 1e-4,
    for runs are integrated to 1e-7.
    """
    late, gain, offset = 0.37, 1.2, -0.4
    times = TIMES[:150] - TIMES[0]
    data = record(times, gain * exact(times + late) + offset)
    bounds = [Free(n, *b, "?") for n, b in FREE.items()]
    curve = Curve(data, "bodies/block/x", 1e-3, ("shift", "offset", "gain"))
    problem = Problem(oscillator(1.1, 0.25), bounds, [curve])
    begin = np.append(problem.middle[:2], [0.2, 0.0, 1.1])
    actual = problem.solved(begin, finish=1e-12)
    assert np.exp(actual.x[:2]) == pytest.approx([STIFFNESS, DAMPING], rel=1e-4)
    expected = [late, offset / problem.scales[0], gain]
    assert actual.x[2:] == pytest.approx(expected, abs=1e-3)


def test_the_mounting_of_an_accelerometer(tmp_path):
    """Both directions of a sensor at an angle of 12 degrees and a gain of one: angle and mass as
    they were, within four deviations, beside a torque that has no direction.
    """
    case, angle = {"model": "ideal"}, math.radians(12.0)
    scene = cl.load_case("slider_crank", **case).replaced({"bodies/slider/mass": 0.2})
    run = cl.simulate(scene, turns=1, samples_per_turn=90, error=None)
    rod, random = run["rod"], np.random.default_rng(0)
    seen = {
        "ax": math.cos(angle) * rod.ax + math.sin(angle) * rod.ay,
        "ay": math.cos(angle) * rod.ay - math.sin(angle) * rod.ax,
        "torque": run.drive("crank").torque,
    }
    columns = [v[:-1] + random.normal(0.0, 0.01 * np.ptp(v), 90) for v in seen.values()]
    rows = [
        ",".join(map(repr, map(float, row))) for row in zip(range(0, 360, 4), *columns, strict=True)
    ]
    path = tmp_path / "bench.csv"
    path.write_text("\n".join(["angle_deg,ax_m_s2,ay_m_s2,torque [N m]", *rows]))
    channels = "bodies/rod/ax=ax_m_s2,bodies/rod/ay=ay_m_s2,drives/crank/torque=torque"
    bounds = {"bodies/slider/mass": (0.05, 0.5)}
    call = cl.load_case("slider_crank", **case), path, bounds
    rest = {"noise": "1%", "settle": 0.0, "starts": 1, "nuisances": "mounting"}
    sensors = {"noise": "1%,1%,2%", "lowpass": [(2, 1e7), (2, 1e7), None]}
    actual = fit(*call, channels, **rest | sensors)
    assert actual.problem.names == ["bodies/slider/mass", "mounting of record 1"]
    deviations = np.sqrt(np.diag(actual.verdict.covariance))
    truth = np.array([math.log(0.2), angle])
    assert (np.abs(actual.best.x - truth) < 4.0 * deviations).all()
    value, deviation, units = actual.nuisances["mounting of record 1"]
    assert (value, deviation, units) == (actual.best.x[1], deviations[1], "rad")
    assert deviation < 0.01
    with pytest.raises(ValueError, match="no direction"):
        fit(*call, "drives/crank/torque=torque", **rest)


@pytest.mark.slow
def test_records_of_two_speeds_in_time_and_in_angle():
    """A record in angle at one speed, one in time with an unknown shift at another: both together
    give the truth of exact records to 1e-3 of it.
    """
    truth = {"clearance": 3e-4, "viscosity": 0.2}
    data = []
    for speed, along in ((400.0, "angle"), (523.6, "time")):
        scene = cl.load_case("slider_crank", **CASE, speed=speed, **truth)
        run = cl.simulate(scene, turns=4, samples_per_turn=720, rtol=1e-9, error=None)
        places = run.turns_at(run.time)
        rows = slice(1440, 2160) if along == "angle" else slice(1600, 2320)
        x = places[rows] - 2.0 if along == "angle" else run.time[rows] - run.time[rows][0]
        data.append((record(x, run["slider"].ax[rows], along, "m/s2"), {"speed": speed}))
    scene = cl.load_case("slider_crank", **CASE)
    bounds = {"clearance": "0.1mm:1mm", "viscosity": (0.05, 1.0)}
    actual = fit(scene, data, bounds, "bodies/slider/ax", noise="1%", starts=1)
    assert list(actual.values.values()) == pytest.approx(list(truth.values()), rel=1e-3)
    assert actual.problem.names[2] == "shift of record 2"
    assert actual.best.x[2] == pytest.approx((1600 - 1440) / 720 * 2.0 * math.pi / 523.6, abs=1e-6)


def test_a_filter_of_the_sensor():
    """A record through a filter of second order at 400 Hz: with it the truth to 1e-3, without it
    not within 1 %.
    """
    from scipy.signal import butter, sosfilt

    scene = cl.load_case("slider_crank", **CASE)
    run = cl.simulate(scene, turns=3, samples_per_turn=7200, rtol=1e-9, error=None)
    rate = 1.0 / float(run.time[1])
    values = sosfilt(butter(2, 400.0, fs=rate, output="sos"), run["slider"].ax)[14400:21600:20]
    data = record(np.arange(360) / 360.0, values, "angle", "m/s2")
    bounds = {"clearance": "0.1mm:1mm"}
    errors = {}
    for lowpass in ((2, 400.0), None):
        actual = fit(scene, data, bounds, "bodies/slider/ax", noise="1%", lowpass=lowpass, starts=1)
        errors[lowpass] = abs(actual.values["clearance"] / 5e-4 - 1.0)
    assert errors[2, 400.0] < 2e-3
    assert errors[None] > 0.01


@pytest.mark.slow
def test_dry_contact_before_the_horizon():
    """Clearance and restitution from half a turn with impacts lie in their intervals. Of three
    turns the stretch before trajectories part is fitted, which is stated. A record that begins
    after two turns is refused with the reason.
    """
    truth = {"clearance": 3e-4, "restitution": 0.8}
    bounds = {"clearance": "0.1mm:1mm", "restitution": (0.5, 0.95)}
    machine = cl.load_case("slider_crank", model="dry", **truth)
    run = cl.simulate(machine, turns=3, samples_per_turn=720, rtol=1e-11, error=None)
    values = run["slider"].ax
    noise = 0.01 * float(np.ptp(values))
    noisy_values = values + np.random.default_rng(0).normal(0.0, noise, values.size)
    scene, turns = cl.load_case("slider_crank", model="dry"), run.turns_at(run.time)
    data = record(turns[:361], noisy_values[:361], "angle", "m/s2")
    actual = fit(scene, data, bounds, "bodies/slider/ax", noise=noise, settle=0.0, starts=2)
    for interval, value in zip(actual.verdict.intervals, truth.values(), strict=True):
        assert abs(interval.value - value) < 4.0 * interval.deviation
    data = record(turns, noisy_values, "angle", "m/s2")
    longer = fit(scene, data, bounds, "bodies/slider/ax", noise=noise, settle=0.0, starts=2)
    assert "trajectories part: it is fitted up to 2." in longer.verdict.doubts[0]
    for interval, value in zip(longer.verdict.intervals, truth.values(), strict=True):
        assert abs(interval.value - value) < 4.0 * interval.deviation
    late = record(turns[1440:] - 2.0, noisy_values[1440:], "angle", "m/s2")
    for starts, noise_of in ((1, noise), (3, noise), (1, None)):
        with pytest.raises(ValueError, match=r"part at .* turns of the record|does not follow"):
            fit(scene, late, bounds, "bodies/slider/ax", noise=noise_of, starts=starts)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 2, 4])
def test_dry_contact_behind_the_horizon(seed):
    """Clearance and restitution, drawn at random, from statistics of settled turns: within their
    intervals. That of the clearance is narrower than half of it, that of the restitution, which
    hangs on the chaotic runs, than the value. The verdict states the statistics.
    """
    random = np.random.default_rng(seed)
    truth = {
        "clearance": float(np.exp(random.uniform(*np.log([2e-4, 6e-4])))),
        "restitution": float(random.uniform(0.65, 0.9)),
    }
    machine = cl.load_case("slider_crank", model="dry", **truth)
    run = cl.simulate(machine, turns=64, samples_per_turn=180, rtol=1e-7, error=None)
    values = run["slider"].ax[4 * 180 : 64 * 180]
    noise = 0.01 * float(np.ptp(values))
    values = values + random.normal(0.0, noise, values.size)
    data = record(np.arange(values.size) / 180.0, values, "angle", "m/s2")
    scene = cl.load_case("slider_crank", model="dry")
    call = scene, data, {"clearance": "0.1mm:1mm", "restitution": (0.5, 0.97)}, "bodies/slider/ax"
    actual = fit(*call, noise=noise, settle=4.0)
    for interval in actual.verdict.intervals:
        assert interval.low <= truth[interval.name] <= interval.high
        share = 0.5 if interval.name == "clearance" else 1.0
        assert interval.high - interval.low < share * interval.value
    assert "fitted by 6 statistics of 60 turns" in actual.verdict.doubts[0]


@pytest.mark.parametrize("seed", range(3))
def test_each_run_of_a_fit_reports_its_progress(seed, monkeypatch):
    """Lines of a log come while a start takes long: before each run, also of those behind the last
    start; the share never falls.
    """
    shares, runs, prepared = [], [], Varying.prepared

    def counted(self, *arguments, **options):
        run = prepared(self, *arguments, **options)
        runs.append(len(shares))
        return run

    monkeypatch.setattr(Varying, "prepared", counted)
    about = {"noise": 0.02, "starts": 2, "progress": shares.append}
    fit(oscillator(1.1, 0.25), noisy(seed), FREE, "bodies/block/x", **about)
    reported = np.array(runs[np.flatnonzero(runs)[0] :])
    assert (np.diff(reported) > 0).all()
    assert len(reported) > 20
    last = shares.index(2.0 / 3.0)  # both starts have ended, the verdict is left
    assert last + 1 < reported[-1]
    assert shares == sorted(shares)
    assert shares[-1] < 1.0


def test_a_bar_that_is_closed_stays_so(monkeypatch):
    """A result runs later, and shows nothing."""
    lines = []
    monkeypatch.setattr(progress_bar, "INTERVAL", 0.0)
    with progress_bar.ProgressBar("fit", lines.append) as bar:
        bar(0.5)
    bar(1.0)
    assert len(lines) == 1


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 3])
def test_dry_contact_that_no_start_follows(seed):
    """A record whose first values lie before the horizon, and whose minima are many, is fitted by
    statistics, with the truth inside; a start reports its progress.
    """
    random = np.random.default_rng(seed)
    truth = float(np.exp(random.uniform(*np.log([1e-4, 4e-4]))))
    machine = cl.load_case("slider_crank", model="dry", clearance=truth)
    run = cl.simulate(machine, turns=40, samples_per_turn=180, rtol=1e-7, error=None)
    values = run["slider"].ax[180:]
    noise = 0.01 * float(np.ptp(values))
    values = values + random.normal(0.0, noise, values.size)
    data = record(np.arange(values.size) / 180.0, values, "angle", "m/s2")
    scene, shares = cl.load_case("slider_crank", model="dry"), []
    about = {"noise": noise, "settle": 1.0, "starts": 1, "progress": shares.append}
    actual = fit(scene, data, {"clearance": "0.05mm:0.5mm"}, "bodies/slider/ax", **about)
    (interval,) = actual.verdict.intervals
    assert interval.low <= truth <= interval.high
    assert interval.kind == "statistics"
    assert "no trajectory follows the records" in actual.verdict.doubts[0]
    first = shares[: shares.index(0.5) + 1]  # the end of the only start
    assert len(first) > 2
    assert first == sorted(first)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({}, "at least 20 turns, and the record has 3"),
        ({"x": 21}, "noise of the sensor"),
        ({"x": 31, "noise": 1.0, "missing": 5}, "at least 20 turns, and the record has 2 without"),
        ({"x": 21, "noise": 1.0, "nuisances": "gain"}, "offset, gain and mounting"),
    ],
)
def test_what_statistics_cannot_fit(change, message):
    """Records that are too short, with a gap, of unknown noise, or with a gain."""
    turns = change.pop("x", 3)
    scene = cl.load_case("slider_crank", model="dry")
    free = [Free("clearance", 1e-4, 1e-3)]
    places = np.delete(np.arange(90.0 * turns), slice(200, 200 + change.pop("missing", 0)))
    data = record(places / 90.0, np.sin(places), "angle", "m/s2")
    curve = Curve(
        data, "bodies/slider/ax", change.get("noise"), (change.get("nuisances") or "").split()
    )
    assert message in reason_without(Problem(scene, free, [curve]))


def wiper(friction=0.15, stiffness=2.0):
    """A driven four-bar whose rocker turns against a spring and rubs in its hinge."""
    law = cl.joint_coulomb(coefficient=friction, viscous=0.002, transition_rate=0.02)
    crank, rod = bar("crank", 0.03, mass=0.2, inertia=5e-4), bar("rod", 0.25, mass=0.1)
    arm = bar("arm", 0.06, angle=1.4, mass=0.4, inertia=0.02, com=(0.2, 0.0))
    *joints, last = loop(crank, rod, arm, 0.24)
    rubbing = replace(last, friction=law, pin_radius=0.01)
    spring = cl.TorsionSpring(cl.ground, arm, stiffness=stiffness, free_angle=1.5, name="S")
    return cl.Scene(*joints, rubbing, spring, cl.Drive(crank, speed=6.0), name="wiper")


NAMES = "joints/D/friction/coefficient", "springs/S/stiffness"


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
def test_the_error_of_the_runs_is_in_the_intervals(seed):
    """A record with a shifted clock and noise of 0.01 % or none, of a torque that friction bends
    within 2 ms: friction and stiffness at random, made by finer runs, lie in their intervals.

    Cubics through 720 samples of a turn missed them by ten deviations.
    """
    random = np.random.default_rng(seed)
    truth = dict(zip(NAMES, random.uniform((0.05, 1.0), (0.4, 4.0)), strict=True))
    run = cl.simulate(
        wiper(*truth.values()), turns=4, samples_per_turn=7200, rtol=1e-10, error=None
    )
    rows = slice(2 * 7200 + 1234, 3 * 7200 + 1234, 80)
    values, sigma = run.drive("crank").torque[rows], (0.0, 1e-4, 1e-3)[seed % 3]
    values = values + random.normal(0.0, sigma * np.ptp(values), values.size)
    data = record(run.time[rows] - run.time[rows][0], values, units="N m")
    bounds = {n: (v / 4.0, v * 3.0) for n, v in truth.items()}
    noise = f"{100.0 * sigma}%" if sigma else None
    actual = fit(wiper(), data, bounds, "drives/crank/torque", noise=noise, starts=2)
    for interval in actual.verdict.intervals:
        assert interval.low <= truth[interval.name] <= interval.high
        assert interval.deviation < 0.01 * interval.value


def test_a_record_without_noise_tests_nothing():
    """Residuals of a closed form are the error of the runs, which is stated and in the intervals;
    these hold the truth, and are narrower than a millionth.
    """
    data = record(TIMES, exact(TIMES))
    actual = fit(oscillator(1.1, 0.25), data, FREE, "bodies/block/x", starts=2)
    assert actual.verdict.tests == {}
    assert any("no larger than the error of the runs" in d for d in actual.verdict.doubts)
    for interval, value in zip(actual.verdict.intervals, (STIFFNESS, DAMPING), strict=True):
        assert interval.low <= value <= interval.high
        assert interval.deviation < 1e-6 * value


def test_a_parameter_at_its_bound_has_the_interval_inside():
    """Of a stiffness whose upper bound is below the truth, and of the damping beside it."""
    bounds = {"springs/S/stiffness": (0.3, 0.98), "springs/S/damping": (0.05, 1.0)}
    actual = fit(oscillator(0.8, 0.25), noisy(0), bounds, "bodies/block/x", noise=0.02, starts=1)
    stiffness, damping = actual.verdict.intervals
    assert (stiffness.kind, stiffness.value, stiffness.high) == ("at its bound", 0.98, 0.98)
    assert 0.9 < stiffness.low < 0.98
    assert damping.low < damping.value < damping.high
    assert any("ends at a bound" in d for d in actual.verdict.doubts)


def test_residuals_larger_than_stated_widen_the_intervals():
    """Noise stated ten times too small: intervals are those of the noise that is there, to 10 %,
    and a sentence states it.
    """
    stated, right = (
        fit(oscillator(1.1, 0.25), noisy(0), FREE, "bodies/block/x", noise=noise, starts=1).verdict
        for noise in (0.002, None)
    )
    for a, b in zip(stated.intervals, right.intervals, strict=True):
        assert a.deviation == pytest.approx(b.deviation, rel=0.1)
    assert any("as large as these" in d for d in stated.doubts)


def test_the_clock_of_a_record_without_turns_is_looked_for():
    """Shifted by 9 % of the record at whose start the cost has another minimum: to 1e-3 s."""
    times, late = TIMES[:100] - TIMES[0], 0.9
    data = record(times, exact(times + late, 20.0))
    bounds = {"springs/S/stiffness": (2.0, 60.0)}
    actual = fit(oscillator(16.0), data, bounds, "bodies/block/x", nuisances="shift", starts=3)
    assert actual.values["springs/S/stiffness"] == pytest.approx(20.0, rel=1e-4)
    assert actual.best.x[1] == pytest.approx(late, abs=1e-3)


@pytest.mark.parametrize("late", [0.05, 0.3])
def test_a_sensor_that_comes_late_sees_the_rest_before(late):
    """A record from the start of a motion through a delay, with another minimum a period further:
    to 1e-6, for runs are integrated to 1e-7.
    """
    data = record(TIMES, exact(np.maximum(TIMES - late, 0.0), 20.0))
    bounds = {FIRST: (2.0, 60.0)}
    actual = fit(oscillator(16.0), data, bounds, "bodies/block/x", nuisances="shift", starts=1)
    assert actual.values[FIRST] == pytest.approx(20.0, rel=1e-6)
    assert actual.nuisances["shift of record 1"][0] == pytest.approx(-late, abs=1e-6)


def test_a_plan_is_the_information_of_the_closed_form():
    """Half widths by the closed form's slopes, to 1 %: noise is a share of the run's range."""
    rows = plan(
        oscillator(), list(FREE), "bodies/block/x", noise=0.02, turns=[20.0], samples_per_turn=10
    )
    expected = slopes(np.arange(1, 201) / 10.0) / 0.02
    deviations = np.sqrt(np.diag(np.linalg.inv(expected.T @ expected)))
    assert list(rows[0].half.values()) == pytest.approx(list(1.96 * deviations), rel=0.01)
    longer, shorter = plan(oscillator(), list(FREE), "bodies/block/x", noise=0.02, turns=[10, 20])
    assert longer.title.endswith("20 s")
    assert shorter.title.endswith("10 s")


def test_residuals_that_are_no_noise():
    """Autocorrelated ones are worth fewer values, and have too few changes of sign; white ones are
    worth all.
    """
    white = np.random.default_rng(1).normal(size=1000)
    assert dependence([white]) == 1.0
    assert runs_test(white) > 0.01
    smooth = np.convolve(white, np.ones(20), "same")
    assert dependence([smooth]) > 10.0
    assert runs_test(smooth) < 1e-10


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"channels": "bodies/block/xx"}, "no channel 'bodies/block/xx'"),
        ({"channels": ""}, "at least one channel"),
        ({"parameters": {}}, "at least one parameter"),
        ({"parameters": {"springs/S/stiffness": (2.0, 1.0)}}, "must rise"),
        ({"parameters": {"springs/S/stiff": (1.0, 2.0)}}, "stiff"),
        ({"parameters": {"springs/S/stiffness": "1:2:3"}}, "two bounds"),
        ({"nuisances": "shifts"}, "no nuisance 'shifts'"),
        ({"noise": -1.0}, "noise"),
        ({"noise": "1%,2%"}, "noise needs one value, or 1, one a channel"),
        ({"lowpass": [None, (2, 9.0)]}, "lowpass needs one value"),
        ({"starts": 0}, "starts must be a whole number"),
        ({"data": record(TIMES, TIMES, units="N")}, "is in N, bodies/block/x in m"),
        ({"data": record(TIMES, TIMES, "angle")}, "no drive of the scene turns evenly"),
    ],
)
def test_what_cannot_be_fitted_is_refused_before_anything_runs(change, message):
    """Each message names the field and its value."""
    call = {"data": noisy(0), "parameters": FREE, "channels": "bodies/block/x"} | change
    with pytest.raises((ValueError, KeyError), match=message):
        fit(oscillator(), **call)


def test_headings_with_units_at_their_end():
    """Names of spreadsheets and loggers: unit behind an underscore."""
    data = read(
        Path(__file__).parent / "data" / "fit_record_a.csv", "slider_acceleration_exact_m_s2"
    )
    assert (data.along, data.units, data.x[90]) == ("angle", "m/s2", 0.25)
    assert data.values[0] == -19485.4641


def test_the_command(tmp_path, monkeypatch, capsys):
    """The same as in Python is printed; a plan needs no record; errors name the option."""
    monkeypatch.chdir(tmp_path)
    scene = cl.load_case("slider_crank", **CASE)
    run = cl.simulate(scene, turns=3, samples_per_turn=90, rtol=1e-8, error=None)
    values = run["slider"].ax[180:270]
    rows = [f"{4 * k},{v!r}" for k, v in enumerate(values.tolist())]
    Path("bench.csv").write_text("\n".join(["crank_angle_deg,a_m_s2", *rows]))
    case = ["slider_crank", *(f"-p{n}={str(v).lower()}" for n, v in CASE.items())]
    call = ["fit", *case, "-p", "clearance=0.1mm:1mm", "--channels", "bodies/slider/ax=a_m_s2"]
    assert (
        main(
            [*call, "--data", "bench.csv", "--noise", "1%", "-o", "fit", "--starts", "1", "--json"]
        )
        == 0
    )
    document = json.loads(capsys.readouterr().out)
    # an exact record: to the tolerance of its runs
    assert document["parameters"]["clearance"]["value"] == pytest.approx(5e-4, rel=1e-5)
    assert all(Path(name).is_file() for name in document["files"])
    assert main(["run", "fit", "--again"]) == 0
    assert main(["fit", *case, "-p", "clearance", "--channels", "bodies/slider/ax", "--plan"]) == 0
    assert "bodies/slider/ax, 1 turn\n" in capsys.readouterr().out
    for options, message in (
        ([], "--data names a record"),
        (["--data", "none.csv"], "none.csv"),
        (["--data", "bench.csv", "--lowpass", "2"], "expected ORDER:CORNER"),
        (["--data", "bench.csv", "--lowpass", "none,none"], "lowpass needs one value"),
        (["--data", "bench.csv,spee=1"], "FILE,NAME=VALUE"),
        (["--data", "bench.csv", "-p", "viscosity"], "viscosity=LOW:HIGH"),
        (["--data", "bench.csv", "-p", "viscosit=1"], "did you mean viscosity"),
    ):
        assert main([*call, *options]) == 2
        assert message in capsys.readouterr().err


def test_masses_of_an_ideal_mechanism_are_those_of_linear_least_squares():
    """The torque of a prescribed motion is linear in the masses: fit and linear least squares agree
    to 1e-9 (1e-11 is usual), where errors are 5 % of the torque.
    """
    scene, masses = cl.load_case("slider_crank", model="ideal"), (0.14, 0.21)

    def torque(slider, rod):
        changed = scene.replaced({"bodies/slider/mass": slider, "bodies/rod/mass": rod})
        run = cl.simulate(changed, turns=1, samples_per_turn=720, error=None)
        return run.turns_at(run.time)[:-1], run.drive("crank").torque[:-1]

    turns, middle = torque(*masses)
    columns = [(torque(0.15, 0.21)[1] - middle) / 0.01, (torque(0.14, 0.22)[1] - middle) / 0.01]
    errors = np.random.default_rng(5).normal(0.0, 0.05 * np.ptp(middle), middle.size)
    change, *_ = np.linalg.lstsq(np.stack(columns, axis=1), errors, rcond=None)
    data = record(turns, middle + errors, "angle", "N m")
    bounds = {"bodies/slider/mass": (0.05, 0.5), "bodies/rod/mass": (0.05, 0.6)}
    actual = fit(scene, data, bounds, "drives/crank/torque", settle=0.0, starts=1)
    assert list(actual.values.values()) == pytest.approx(list(masses + change), rel=1e-9)


@pytest.mark.slow
def test_intervals_of_a_lubricated_joint_hold_the_truth():
    """Of 60 draws at least 80 % of the 95 % intervals: 200 draws of three parameters gave 92, 95
    and 94.5 %, and three deviations of a share of 60 are 11 %.
    """
    scene = cl.load_case("slider_crank", **CASE)
    path = Path(__file__).parent / "data" / "fit_record_a.csv"
    clean = read(path, "slider_acceleration_exact_m_s2")
    free = [Free("clearance", 1e-4, 1e-3), Free("viscosity", 0.05, 1.0)]
    inside = np.zeros(2)
    for seed in range(60):
        errors = np.random.default_rng(seed).normal(0.0, 297.811, clean.values.size)
        data = record(clean.x, clean.values + errors, "angle", "m/s2")
        problem = Problem(scene, free, [Curve(data, "bodies/slider/ax", 297.811)])
        best = problem.solved(problem.middle)
        pairs = zip(verdict(problem, best, [best]).intervals, (5e-4, 0.4), strict=True)
        inside += [i.low <= value <= i.high for i, value in pairs]
    assert inside.min() >= 0.8 * 60, inside


def test_an_interrupt_has_one_line(monkeypatch, capsys):
    """Exit status 1, and how to go on."""

    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("clearance.identify.scene_parameters.fit", interrupted)
    call = ["fit", "slider_crank", "-p", "clearance=0.3mm:0.6mm"]
    call += ["--data", "bench.csv", "--channels", "bodies/slider/ax"]
    assert main(call) == 1
    assert "with -o the same command goes on" in capsys.readouterr().err


class Bent:
    """A problem of two parameters whose cost is a parabola, but for a share that bends it."""

    freedom = 1000
    bounds = np.full(2, -np.inf), np.full(2, np.inf)

    def __init__(self, share: float):
        self.share = share

    def priced(self, x: np.ndarray) -> Solved:
        """Cost of a parabola, and of one that turns down beyond half of the interval."""
        square = float(x @ x)
        return Solved(x, 0.5 * square * (1.0 - self.share * min(square, 1.0)), True)


def test_a_linear_interval_needs_a_parabola():
    """The cost at the ends of a linear interval decides whether slopes alone may state it."""
    best, one = Solved(np.zeros(2), 0.0, True), np.eye(2)
    for share, straight in ((0.0, True), (0.5, True), (0.9, False), (-9.0, False)):
        judge = Judge(Bent(share), best, one, 1.0)
        assert judge.straight(0) is straight


def test_a_function_is_a_case():
    """A function's parameters are fitted as the numbers of its scene are: the same runs."""
    noisy = exact(TIMES) + np.random.default_rng(3).normal(0.0, 0.01, TIMES.size)
    data, rest = record(TIMES, noisy), {"noise": 0.01, "starts": 1}
    case = fit(oscillator, data, {"stiffness": (0.3, 3.0)}, "bodies/block/x", **rest)
    scene = fit(oscillator(), data, {FIRST: FREE[FIRST]}, "bodies/block/x", **rest)
    (one,), (other,) = case.intervals.values(), scene.intervals.values()
    assert (one.value, one.low, one.high) == pytest.approx(
        (other.value, other.low, other.high), rel=1e-9
    )


def product(first=1.0, second=1.0, third=1.0, damping=0.2):
    """An oscillator whose stiffness is a product of three numbers."""
    return oscillator(first * second**2 / third, damping)


@pytest.mark.parametrize("seed", range(4))
def test_three_parameters_may_enter_as_one(seed):
    """Their product is stated, with its interval that holds the truth; the damping beside them is
    determined as ever.
    """
    random = np.random.default_rng(seed)
    truth = np.exp(random.uniform(-0.3, 0.3, 3))
    stiffness = float(truth[0] * truth[1] ** 2 / truth[2])
    values = exact(TIMES, stiffness) + random.normal(0.0, 0.01, TIMES.size)
    bounds = dict.fromkeys(("first", "second", "third"), (0.3, 3.0)) | {"damping": (0.05, 1.0)}
    actual = fit(
        product, record(TIMES, values), bounds, "bodies/block/x", noise=0.01, starts=1
    ).verdict
    (line,) = actual.products
    names, _, enter = line.partition(" cannot be told apart: they enter as ")
    assert all(n in names for n in ("first", "second", "third"))
    terms, value, factor = enter.replace(" within a factor of ", ", ").rsplit(", ", 2)
    power = {t.partition("^")[0]: float(t.partition("^")[2] or 1) for t in terms.split(" * ")}
    assert power["second"] / power["first"] == 2.0
    assert power["third"] / power["first"] == -1.0
    # 3 deviations: the interval has two
    assert abs(math.log(float(value) ** (1.0 / power["first"]) / stiffness)) < 1.5 * math.log(
        float(factor)
    )
    *others, damping = actual.intervals
    assert [i.kind for i in others] == ["inseparable"] * 3
    assert abs(damping.value - DAMPING) < 4.0 * damping.deviation


@pytest.mark.parametrize("seed", range(3))
def test_clocks_and_speeds_of_records(seed):
    """A record at a tenth to a half of the scene's speed, of any phase, by a clock that began long
    before: the same numbers as by one that begins with it, the truth within four deviations.
    """
    random = np.random.default_rng(seed)
    machine, speed = cl.load_case("slider_crank", model="ideal"), 523.6 * random.uniform(0.1, 0.5)
    mass, late = random.uniform(0.1, 0.3), int(random.integers(0, 360))
    there = cl.load_case("slider_crank", model="ideal", speed=speed)
    run = cl.simulate(
        there.replaced({"bodies/slider/mass": mass}), turns=3, samples_per_turn=360, error=None
    )
    rows = slice(360 + late, 720 + late, 4)
    torque, times = run.drive("crank").torque[rows], run.time[rows] - run.time[rows][0]
    torque = torque + random.normal(0.0, 0.02 * np.ptp(torque), torque.size)
    results = []
    for began in (0.0, 2.0**30):
        data = record(times + began, torque, units="N m"), {"speed": speed}
        bounds, sigma = {"bodies/slider/mass": (0.05, 0.5)}, 0.02 * float(np.ptp(torque))
        actual = fit(machine, data, bounds, "drives/crank/torque", noise=sigma, starts=1)
        results.append([*actual.values.values(), actual.nuisances["shift of record 1"][0]])
    # a clock of 2^30 s has steps of 1e-7 s
    assert results[1] == pytest.approx(results[0], rel=1e-3, abs=1e-6)
    (interval,) = actual.verdict.intervals
    assert abs(interval.value - mass) < 4.0 * interval.deviation
    turn = 2.0 * math.pi / speed
    apart = (results[0][1] - run.time[late]) / turn
    assert abs(apart - round(apart)) < 0.01
    assert actual.problem.in_turns(0)[-1] == pytest.approx(89 / 90, rel=1e-4)


def test_a_sensor_whose_sign_is_flipped():
    """Its gain ends at a bound, which a sentence states."""
    call = oscillator(), record(TIMES, -exact(TIMES)), FREE, "bodies/block/x"
    actual = fit(*call, noise=0.02, nuisances="gain", starts=1)
    assert any("gain of record 1 ends at a bound" in d for d in actual.verdict.doubts)


def test_noise_that_is_autocorrelated_is_not_the_model_s():
    """Noise has a correlation time of nine values. The signs of residuals refuse the model in at
    most two of 16 records: one of a hundred is expected.
    """
    refused = 0
    for seed in range(16):
        random = np.random.default_rng(seed)
        white = random.normal(0.0, 0.02, TIMES.size)
        noise = np.empty_like(white)
        noise[0] = white[0]
        for k in range(1, white.size):
            noise[k] = 0.8 * noise[k - 1] + 0.6 * white[k]
        problem = problem_at(record(TIMES, exact(TIMES) + noise), 0.02)
        best = problem.solved(np.log([STIFFNESS, DAMPING]))
        refused += verdict(problem, best, [best]).tests["runs of residuals"] < 0.01
    assert refused <= 2


def test_what_the_records_do_not_see_is_stated():
    """The inertia of a block that does not turn."""
    bounds = {FIRST: FREE[FIRST], "bodies/block/inertia": (1e-4, 1e-2)}
    actual = fit(oscillator(1.1), noisy(0), bounds, "bodies/block/x", noise=0.02, starts=1)
    sentence = "the records do not determine bodies/block/inertia between its bounds"
    assert sentence in actual.verdict.doubts
    assert len(actual.verdict.doubts) == 1


def faint(first=1.0, second=1.0, strength=0.0, stiffness=1.0):
    """An oscillator with a spring beside its own, whose stiffness is a product times a strength."""
    return oscillator(stiffness + strength * first**2 * second)


@pytest.mark.parametrize("seed", range(6))
def test_a_product_that_the_records_do_not_see_is_no_product(seed):
    """It moves the stiffness by 1e-12 to 1e-7 of it: both parameters are not determined between
    their bounds. Beside a strength of 0.1 to 1 the product is stated with its interval.
    """
    random = np.random.default_rng(seed)
    strength = 10.0 ** random.uniform(*((-12.0, -7.0) if seed % 2 else (-1.0, 0.0)))
    data = record(TIMES, exact(TIMES, 1.0 + strength) + random.normal(0.0, 0.01, TIMES.size))
    scene = cl.load_case(faint, strength=strength)
    bounds = dict.fromkeys(("first", "second"), (0.2, 5.0))
    judged = fit(scene, data, bounds, "bodies/block/x", noise=0.01, starts=1).verdict
    if seed % 2:
        assert judged.products == []
        assert judged.doubts == [
            f"the records do not determine {name} between its bounds" for name in bounds
        ]
    else:
        (line,) = judged.products
        assert "they enter as second * first^2, 1" in line or "second * first^2, 0.9" in line
        assert judged.doubts == []


@pytest.mark.parametrize("seed", range(6))
def test_a_sensor_that_clips(seed):
    """Its range ends at 50 to 90 % of the deflection on one side: a sentence states it. Without
    these rows the truth is within four deviations. A range that is long enough has none, nor steps
    of 6 to 10 bits.
    """
    random, data = np.random.default_rng(seed), noisy(seed)
    high, span = data.values.max(), np.ptp(data.values)
    top = 5.0 + random.uniform(0.5, 0.9) * (high - 5.0)
    values = np.minimum(data.values, top)
    steps = span / 2 ** random.integers(6, 11)
    rows = {
        "clipped": record(TIMES, values),
        "others": record(TIMES[values < top], values[values < top]),
        "in steps": record(TIMES, np.round(data.values / steps) * steps),
    }
    share = np.mean(values == top)
    sentence = f"bench.csv, x: {share:.0%} of the values are its largest or least"
    for name, measured in rows.items():
        problem = problem_at(measured, 0.02)
        best = problem.solved(np.log([STIFFNESS, DAMPING]))
        judged = verdict(problem, best, [best])
        clips = [d for d in judged.doubts if "clip" in d]
        assert bool(clips) == (name == "clipped" and share > 0.02)
        assert all(d.startswith(sentence) for d in clips)
        for i, value in zip(judged.intervals, (STIFFNESS, DAMPING), strict=True):
            assert name == "clipped" or abs(i.value - value) < 4.0 * i.deviation


def apart(first=1.0, second=1.0):
    """An oscillator whose damping hangs a little on one of two factors of its stiffness."""
    return oscillator(first * second, DAMPING * first**0.02)


def bent(first=1.0, second=1.0, beside=0.0):
    """An oscillator whose stiffness is no product of powers."""
    return oscillator(first * second + beside * first)


@pytest.mark.parametrize("seed", range(6))
def test_parameters_that_are_apart_between_wide_bounds_have_intervals(seed):
    """They are correlated by more than 0.9999, and their intervals hold the truth: in logarithms
    within 1.5 of their half widths, three deviations.
    """
    random = np.random.default_rng(seed)
    truth = np.exp(random.uniform(-1.0, 1.0, 2))
    values = exact(TIMES, truth.prod(), DAMPING * truth[0] ** 0.02)
    data = record(TIMES, values + random.normal(0.0, 0.01, TIMES.size))
    bounds = dict.fromkeys(("first", "second"), (1e-5, 1e5))
    judged = fit(apart, data, bounds, "bodies/block/x", noise=0.01, starts=1).verdict
    assert abs(judged.correlation[0, 1]) > 0.9999
    assert judged.products == []
    for i, value in zip(judged.intervals, truth, strict=True):
        assert i.kind == "profile"
        assert (i.low / i.value) ** 1.5 < value / i.value < (i.high / i.value) ** 1.5
        assert i.high < 1e4 * i.low


@pytest.mark.parametrize("seed", range(4))
def test_a_product_that_holds_near_the_estimate_is_stated_with_its_error(seed):
    """A stiffness of a b + c a between bounds of a factor of nine is no product of powers: at the
    truth, that stated is within its factor.
    """
    random = np.random.default_rng(seed)
    beside, truth = random.uniform(0.2, 1.0), np.exp(random.uniform(-1.0, 1.0, 2))
    stiffness = truth[0] * (truth[1] + beside)
    data = record(TIMES, exact(TIMES, stiffness) + random.normal(0.0, 0.01, TIMES.size))
    bounds = dict.fromkeys(("first", "second"), (1.0 / 3.0, 3.0))
    scene = cl.load_case(bent, beside=beside)
    (line,) = fit(scene, data, bounds, "bodies/block/x", noise=0.01, starts=1).verdict.products
    terms, _, number = line.partition("enter as ")[2].rpartition(", ")
    value, factor = map(float, number.split(" within a factor of "))
    powers = {t.partition("^")[0]: float(t.partition("^")[2] or 1) for t in terms.split(" * ")}
    product = truth[0] ** powers["first"] * truth[1] ** powers["second"]
    assert 1.0 / factor < product / value < factor


@pytest.mark.parametrize("seed", range(12))
def test_fewer_values_than_unknowns_are_refused(seed):
    """Values of one to three records beside parameters, nuisances and, where it is not stated, the
    noise: one too few are refused with both numbers, as many are fitted.
    """
    random = np.random.default_rng(seed)
    count, noise = int(random.integers(1, 4)), (0.02, None)[seed % 2]
    names = [n for n in ("shift", "offset", "gain") if random.integers(2)]
    bounds = {n: FREE[n] for n in [*FREE][: random.integers(1, 3)]}
    unknown = len(bounds) + count * len(names)
    least = unknown + (noise is None)

    def call(values):
        parts = np.array_split(TIMES[:values], count)
        data = [record(times, exact(times)) for times in parts]
        curves = [Curve(d, "bodies/block/x", noise, tuple(names)) for d in data]
        return Problem(oscillator(), [Free(n, *b) for n, b in bounds.items()], curves)

    text = f"{least - 1} values do not determine {unknown} numbers"
    text += " and their noise" * (noise is None)
    if least > count:
        with pytest.raises(ValueError, match=f"fit: {text}$"):
            call(least - 1)
    assert call(max(least, 2 * count)).size >= least


@pytest.mark.parametrize("seed", range(2))
def test_points_that_starts_are_taken_from_run_once(monkeypatch, seed):
    """Each of 32 points, with the shift of its sensor or without; starts rise in cost."""
    nuisances, runs, steps = ("shift",) * (seed % 2), [], Problem._steps
    monkeypatch.setattr(Problem, "_steps", lambda *a: runs.append(1) or steps(*a))
    free = [Free(n, *b) for n, b in FREE.items()]
    problem = Problem(oscillator(), free, [Curve(noisy(seed), "bodies/block/x", None, nuisances)])
    starts = [*problem.lowest(3, seed)]
    assert len(runs) == 32
    costs = [problem.priced(x).cost for x in starts]
    assert costs == sorted(costs)


@pytest.mark.parametrize("seed", range(6))
def test_a_dead_sensor_is_named(tmp_path, seed):
    """One of several channels of one of several files has the same number in all rows: file, column
    and channel are named before anything runs.
    """
    random = np.random.default_rng(seed)
    columns = {"bodies/block/x": "x", "bodies/block/vx": "v", "bodies/block/ax": "a"}
    files, dead = [], (int(random.integers(3)), str(random.choice([*columns])))
    for i in range(3):
        rows = {n: random.normal(size=9) for n in columns}
        if i == dead[0]:
            rows[dead[1]][:] = random.choice([0.0, 4.5])
        lines = (",".join(map(repr, map(float, row))) for row in zip(*rows.values(), strict=True))
        files.append(tmp_path / f"{i}.csv")
        table = [f"{0.1 * k:.1f},{line}" for k, line in enumerate(lines)]
        files[-1].write_text("\n".join(["time [s],x [m],v [m/s],a [m/s2]", *table]))
    channels = [f"{n}={c}" for n, c in columns.items()]
    about = f"{dead[0]}.csv, {columns[dead[1]]} of {dead[1]}: .* in all rows; nothing measured"
    with pytest.raises(ValueError, match=about):
        fit(oscillator(), files, FREE, channels)


def test_runs_have_no_more_samples_than_they_need():
    """A record of 50 kHz at 300 rpm, and one with a burst, have as many as one of 720 a turn."""
    scene = cl.load_case("six_bar_feeder")
    free = [Free("clearance", 1e-4, 1e-3)]
    turn = scene.turn
    for x in (np.arange(0.0, turn, 2e-5), np.append(1e-9 * np.arange(100), turn)):
        data = record(x, np.sin(x), units="?")
        problem = Problem(scene, free, [Curve(data, "bodies/slider/ax")])
        run = problem.run_of(problem.middle, problem.groups[0])
        assert 3 * 720 <= run.span.samples <= 3 * 1440


@pytest.mark.parametrize(
    ("heading", "turns"),
    [("turns", 0.25), ("angle [deg]", 0.25 / 360.0), ("crank angle [rev]", 0.25), ("angle", None)],
)
def test_an_angle_has_its_unit(tmp_path, heading, turns):
    """Turns are turns; an angle without a unit is refused."""
    path = tmp_path / "bench.csv"
    path.write_text("\n".join([f"{heading},a_m_s2", *(f"{0.25 * k},{k}" for k in range(4))]))
    if turns is None:
        with pytest.raises(ValueError, match="column 'angle': unknown unit 'angle'"):
            read(path)
    else:
        assert read(path).x[1] == pytest.approx(turns)
