"""Dimensions from limits: optima and prices of closed forms, fronts, shares of machines, words."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq, minimize, minimize_scalar

import clearance as cl
from clearance.cli import main
from clearance.identify.designs import optimize
from clearance.identify.optimum import Aim, parts_of_limit

RADIUS, LENGTH, LOAD, SPEED, VISCOSITY = 10e-3, 8e-3, 1000.0, 200.0, 0.05
CLEARANCE, RATIO = "joints/B/clearance", "joint_B_eccentricity_ratio_max"
BOUNDS = {CLEARANCE: "20um:400um"}
#: at rest from the start, so that one turn is enough
RUN = {"turns": 1.0, "settle": 0.0, "start": "quasi-static"}


def bearing():
    """A shaft at constant speed in a short bearing, under a constant load."""
    shaft = cl.Body("shaft", 1.0, 1e-4)
    joint = cl.ClearanceRevolute(
        cl.ground,
        shaft,
        name="B",
        radius=RADIUS,
        clearance=30e-6,
        length=LENGTH,
        film=cl.short_film(),
        lubricant=cl.Lubricant(VISCOSITY),
        film_torques=True,
    )
    drive = cl.Drive(shaft, speed=SPEED, start=0.0, name="motor")
    return cl.Scene(joint, cl.Force(shaft, 0.0, -LOAD), drive, gravity=(0.0, 0.0), name="bearing")


def eccentricity(clearance, length=LENGTH):
    """Over the clearance, where Ocvirk's film carries the load."""
    stiff = VISCOSITY * SPEED * length**3 * RADIUS / (4.0 * clearance**2)

    def rest(e):
        root = math.sqrt(16.0 * e * e + math.pi**2 * (1.0 - e * e))
        return stiff * e / (1.0 - e * e) ** 2 * root - LOAD

    return brentq(rest, 1e-6, 1.0 - 1e-9, xtol=1e-15)


def loss(clearance):
    """Power that the shaft takes [W]: shear, and the couple of load and eccentricity."""
    e = eccentricity(clearance)
    angle = math.atan2(math.pi * math.sqrt(1.0 - e * e), 4.0 * e)
    shear = 2.0 * math.pi * VISCOSITY * SPEED * RADIUS**3 * LENGTH
    shear /= clearance * math.sqrt(1.0 - e * e)
    return SPEED * (shear + 0.5 * clearance * e * LOAD * math.sin(angle))


def clearance_at(ratio):
    """Clearance whose eccentricity ratio is this [m]; it grows with the clearance."""
    return brentq(lambda c: eccentricity(c) - ratio, 1e-5, 1e-3, xtol=1e-16)


def test_the_least_loss_of_a_short_bearing():
    """The clearance of a one-dimensional search of Ocvirk's chain, to 1e-6 of it, from any start
    of four; nothing is at a bound, and no limit costs anything.
    """
    exact = minimize_scalar(
        lambda u: loss(math.exp(u)),
        bounds=(math.log(2e-5), math.log(4e-4)),
        method="bounded",
        options={"xatol": 1e-12},
    )
    best = optimize(bearing(), BOUNDS, minimize="drives/motor/loss_mean", **RUN)
    assert best.values[CLEARANCE] == pytest.approx(math.exp(exact.x), rel=1e-6)
    assert best.metrics["drive_motor_loss_mean"] == pytest.approx(exact.fun, rel=1e-9)
    assert best.others == []
    assert best.words == []
    assert best.doubts == ()


def test_what_a_limit_costs():
    """Below the clearance of least loss the journal is nearer to the middle: loss by eccentricity
    ratio, from differences of the closed form, to 1e-4 beside the margin. The limit holds with
    the stated error of its run.
    """
    best = optimize(
        bearing(), BOUNDS, minimize="loss_mean", limits=f"{RATIO} < 0.97", starts=2, **RUN
    )
    assert best.values[CLEARANCE] == pytest.approx(clearance_at(0.97), rel=1e-4)
    (limit,) = best.document()["limits"]
    assert 0.97 * (1.0 - 1e-5) < limit["value"] <= 0.97
    assert limit["margin"] >= limit["error"]
    price = (loss(clearance_at(0.9699)) - loss(clearance_at(0.9701))) / 2e-4
    assert limit["price"] == pytest.approx(price, rel=1e-4)
    words = f"{RATIO} < 0.97 is active: 0.01 less costs {0.01 * price:.3g} W"
    assert best.words == [words]
    # as `clearance run` has it, at its own tolerance
    assert best.simulated().joint("B").eccentricity_ratio.max() <= 0.97


def test_distinct_optima_have_a_ridge_between_them():
    """The largest loss of a bearing is at either end of the bounds: both are optima, the smaller
    clearance is the better. Minima that lie in one valley are one.
    """
    best = optimize(bearing(), BOUNDS, maximize="loss_mean", **RUN)
    assert best.values[CLEARANCE] == pytest.approx(2e-5, rel=1e-6)
    (other,) = best.others
    assert best.design.values(other.x)[CLEARANCE] == pytest.approx(4e-4, rel=1e-6)
    assert other.goal == pytest.approx(loss(4e-4), rel=1e-6)
    flat = optimize(
        cl.load_case("slider_crank", model="lubricated", film="short"),
        {"clearance": "0.1mm:1mm", "viscosity": (0.05, 1.0)},
        minimize="drive_crank_torque_rms",
        turns=2.0,
        starts=3,
    )
    assert flat.others == []


def test_bounds_and_signs():
    """The loss grows beyond its least value: the largest is at a bound, and so is that of minus."""
    ends = [
        optimize(bearing(), {CLEARANCE: (2e-4, 4e-4)}, starts=2, **goal, **RUN)
        for goal in ({"maximize": "loss_mean"}, {"minimize": "-loss_mean"})
    ]
    for best in ends:
        assert best.values[CLEARANCE] == pytest.approx(4e-4, rel=1e-6)
        (words,) = best.words
        assert words.startswith(f"{CLEARANCE} is at its upper bound: 1 % more gains")
        assert best.metrics["loss_mean"] == pytest.approx(loss(4e-4), rel=1e-6)


def test_a_front_of_two_goals(tmp_path):
    """From the least loss to the most central journal; each design has the clearance of its ratio
    by the closed form, to 1e-5.
    """
    goals = ["loss_mean", "joints/B/eccentricity_ratio_max"]
    best = optimize(bearing(), BOUNDS, minimize=goals, starts=2, designs=5, **RUN)
    rows = best.document()["front"]
    ratios = [row["metrics"][RATIO] for row in rows]
    assert np.diff(ratios) == pytest.approx([(ratios[-1] - ratios[0]) / 4.0] * 4, rel=1e-4)
    assert rows[-1]["parameters"][CLEARANCE] == pytest.approx(20e-6, rel=1e-6)
    for row, ratio in zip(rows[1:-1], ratios[1:-1], strict=True):
        assert row["parameters"][CLEARANCE] == pytest.approx(clearance_at(ratio), rel=1e-5)
    assert best.plot(tmp_path / "front.png").stat().st_size > 0


@pytest.mark.slow
def test_a_share_of_machines(tmp_path):
    """The margin is the quantile times the deviation of the ratio, by slopes of the closed form to
    1 %, also of a parameter that is not free. Of machines drawn by chance the share keeps the
    limit, within its interval.
    """
    best = optimize(
        bearing(),
        BOUNDS,
        minimize="loss_mean",
        limits=f"{RATIO} < 0.97",
        tolerance={CLEARANCE: "2um", "joints/B/length": "0.1mm"},
        share="95%",
        starts=1,
        folder=tmp_path,
        turns=6.0,
        settle=5.0,
    )
    c = best.values[CLEARANCE]
    by_clearance = eccentricity(c * 1.01) - eccentricity(c * 0.99)
    by_length = eccentricity(c, LENGTH * 1.01) - eccentricity(c, LENGTH * 0.99)
    deviation = math.hypot(by_clearance / 0.02 * 2e-6 / c, by_length / 0.02 * 1e-4 / LENGTH)
    (limit,) = best.document()["limits"]
    assert limit["margin"] == pytest.approx(1.6449 * deviation, rel=0.01)
    assert limit["kept"]["low"] <= 0.95 <= limit["kept"]["high"]
    swept = best.mapped(tmp_path / "map", along=5, workers=1)
    assert best.plot(tmp_path / "map.png", swept).stat().st_size > 0
    assert RATIO in best._repr_html_()


def test_an_interrupted_search_goes_on(tmp_path, monkeypatch):
    """Ends of starts are in the folder: the search that goes on looks for none again."""

    def interrupt(share):
        if share == 0.5:  # the only start has ended
            raise KeyboardInterrupt

    call = {"minimize": "loss_mean", "starts": 1, "folder": tmp_path, **RUN}
    with pytest.raises(KeyboardInterrupt):
        optimize(bearing(), BOUNDS, progress=interrupt, **call)
    solved, finished = Aim.solved, []

    def counted(self, x, *finish):
        finished.append(bool(finish))
        return solved(self, x, *finish)

    monkeypatch.setattr(Aim, "solved", counted)
    best = optimize(bearing(), BOUNDS, **call)
    assert finished == [True]  # the best one, to its end
    document = json.loads((tmp_path / "optimum.json").read_text())
    assert document["parameters"][CLEARANCE]["value"] == best.values[CLEARANCE]
    scene, _ = cl.again(tmp_path / "run.h5")
    assert scene.to_json() == best.scene.to_json()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"minimize": "loss_men"}, "no metric 'loss_men' .did you mean loss_mean"),
        ({"minimize": ()}, "one or two goals"),
        ({"limits": "joints/B/gap_mi > 1um"}, "did you mean joint_B_gap_min"),
        ({"limits": "joints/B/gap_min = 1um"}, "METRIC > VALUE"),
        ({"limits": "1um < joints/B/gap_min"}, "METRIC > VALUE"),
        ({"parameters": {CLEARANCE: 1e-4}}, "needs two bounds"),
        ({"limits": "joints/B/gap_min > 1N"}, "is in N, expected m"),
        (
            {"limits": "joints/B/gap_min > 1mm"},
            "joint_B_gap_min > 0.001 m: the nearest has .* um., at .* m ",
        ),
        ({"parameters": {CLEARANCE: (2.0, 1.0)}}, "must rise"),
        ({"parameters": {}}, "at least one parameter"),
        ({"share": "120%"}, "share must lie between 0 and 1"),
        ({"tolerance": {CLEARANCE: "2um"}}, "a tolerance widens limits, and there is none"),
        (
            {"tolerance": {CLEARANCE: "1N"}, "limits": "loss_mean < 1W"},
            "tolerance of joints/B/clearance",
        ),
        ({"starts": 0}, "starts must be a whole number"),
    ],
)
def test_what_cannot_be_sought_is_refused(change, message):
    """Each message names the field and its value."""
    call = {"parameters": BOUNDS, "minimize": "loss_mean", "starts": 1} | RUN | change
    with pytest.raises(ValueError, match=message):
        optimize(bearing(), call.pop("parameters"), **call)


def test_words_of_a_limit():
    """Name, sign and value, with blanks or without."""
    assert parts_of_limit("joints/B/gap_min>=2 um") == ("joints/B/gap_min", 1, "2 um")
    assert parts_of_limit(" drive_crank_torque_max < 2Nm ") == ("drive_crank_torque_max", -1, "2Nm")


@pytest.mark.slow
def test_a_corner_is_found_where_peaks_change_place():
    """Peaks of the torque at different angles are equal at the optimum of a spring beside a
    slider: the largest is within 1e-5 of that of a simplex that goes on from there.
    """
    scene = cl.load_case("slider_crank", model="ideal", speed=20.0)
    slider = next(b for b in scene.bodies if b.name == "slider")
    anchor = cl.ground.at(0.3, 0.0)
    spring = cl.SpringDamper(anchor, slider, stiffness=20.0, free_length=0.18, name="S")
    parts = [p for p in scene.parts if not isinstance(p, cl.Body)]
    scene = cl.Scene(*parts, spring, gravity=(0.0, 0.0), name="sprung")
    best = optimize(
        scene,
        {"springs/S/stiffness": (1.0, 500.0), "springs/S/free_length": (0.15, 0.22)},
        minimize="drive_crank_torque_max",
        starts=3,
    )
    assert "slopes do not show a least value" in best.doubts[0]

    def peak(x):
        return best.design.point(x).values["drive_crank_torque_max"]

    x = best.best.x
    simplex = [x, x + (0.02, 0.0), x + (0.0, 0.02)]
    further = minimize(peak, x, method="Nelder-Mead", options={"initial_simplex": simplex})
    assert best.best.goal == pytest.approx(further.fun, rel=1e-5)


@pytest.mark.slow
def test_contact_that_starts_with_a_touch_is_searched_without_slopes():
    """The least peak force over the clearance is not above that of 12 values by 2 %: peaks of dry
    joints are rough functions.
    """
    scene = cl.load_case("slider_crank", model="dry", restitution=0.5)
    goal = "joint_C_force_peak_mean"
    best = optimize(scene, {"clearance": "50um:500um"}, minimize=goal, turns=4.0, starts=2)
    assert "searched without slopes" in best.doubts[0]
    values = []
    for clearance in np.geomspace(5e-5, 5e-4, 12):
        point = best.design.point(np.array([math.log(clearance)]))
        values.append(point.values[goal])
    assert best.metrics[goal] < 1.02 * min(values)


@pytest.mark.slow
def test_a_feeder_of_three_parameters_and_maps_of_it(tmp_path):
    """Clearance, oil and speed of the feeder: no point of a map of the box that keeps the limits is
    better; the best of a map a thousandth around is within 2e-4, two of its cells. A map of 60^3
    points takes some 16 times as long as four starts, and its best is 3 % worse.
    """
    scene = cl.load_case("six_bar_feeder", model="lubricated")
    limits = {"joint_B_film_thickness_ratio_min": 10.0, "slider_acceleration_max": 45.0}
    bounds = {"clearance": (1e-5, 2e-4), "viscosity": (2e-3, 0.2), "speed": (20.0, 40.0)}
    best = optimize(
        scene,
        bounds,
        minimize="loss_mean",
        limits=[f"{n} > {v}" for n, v in limits.items()],
        turns=3.0,
        starts=2,
    )
    assert [w.partition(" is active")[1] for w in best.words] == [" is active"] * 2
    around = {n: (v * 0.9995, v * 1.0005) for n, v in best.values.items()}
    ratios = []
    for folder, box, count in (("all", bounds, 12), ("near", around, 11)):
        places = cl.grid(**{n: np.geomspace(*ends, count) for n, ends in box.items()})
        swept = cl.sweep(scene, places, tmp_path / folder, channels=[], turns=3.0, workers=1)
        inside = np.all([swept.metrics[n] >= v for n, v in limits.items()], axis=0)
        watts = swept.metrics["dissipated_per_turn"] * swept.columns["speed"] / (2.0 * math.pi)
        ratios.append(watts[inside].min() / best.metrics["loss_mean"] - 1.0)
    assert ratios[0] > -1e-4
    assert abs(ratios[1]) < 2e-4


def test_the_command(tmp_path, monkeypatch, capsys):
    """The same as in Python is printed and stored; errors name the option."""
    monkeypatch.chdir(tmp_path)
    case = ["optimize", "slider_crank", "-p", "model=lubricated", "-p", "film=short"]
    call = [*case, "-p", "clearance=0.3mm:0.6mm", "--starts", "1", "--turns", "2"]
    goal = ["--minimize", "joints/C/force_max", "--limit", "joints/C/loss_mean < 1kN"]
    assert main([*call, *goal[:2], "--json", "-o", "best"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert all(Path(name).is_file() for name in document["files"])
    assert main(["run", "best", "--again"]) == 0
    capsys.readouterr()
    assert main([*call, *goal[:2]]) == 0
    assert "least joint_C_force_max" in capsys.readouterr().out
    for options, message in (
        ([], "--minimize METRIC or --maximize METRIC"),
        ([*goal, "--limit", "joints/C/loss_mean < 1N"], "is in N, expected W"),
        ([*goal[:2], "-p", "viscosity"], "viscosity=LOW:HIGH"),
        ([*goal[:2], "--tolerance", "clearance"], "expected NAME=SIZE"),
    ):
        assert main([*call, *options]) == 2
        assert message in capsys.readouterr().err


def test_an_interrupt_has_one_line(monkeypatch, capsys):
    """Exit status 1, and how to go on."""

    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("clearance.identify.designs.optimize", interrupted)
    call = ["optimize", "slider_crank", "-p", "clearance=0.3mm:0.6mm"]
    call += ["--minimize", "loss_mean"]
    assert main(call) == 1
    assert "with -o the same command goes on" in capsys.readouterr().err
