"""Sweeps of lengths in lanes: starts and ideal motions of each point."""

import numpy as np
import pytest

import clearance as cl
from clearance.lanes.point_numbers import NotForLanes
from clearance.sweeping import in_lanes
from clearance.sweeping.in_lanes import Together
from tests.seeds import few_of
from tests.sweeping.test_dry_together import ordinary
from tests.sweeping.test_together import SCENE, tolerance

OPTIONS = {"turns": 2.0}
POINTS = 24
JOINT = {
    "lubricated": {"film": cl.pinkus_sternlicht(), "lubricant": cl.Lubricant(viscosity=0.04)},
    "dry": {"contact": cl.lankarani_nikravesh(stiffness=1e9, restitution=0.4)},
}


def crank(name, length, angle=0.0):
    """A bar of steel, its centre of mass in the middle."""
    ends = {"near": (-0.5 * length, 0.0), "far": (0.5 * length, 0.0)}
    mass = 1.6 * length
    return cl.Body(name, mass, mass * length**2 / 12.0, points=ends, angle=angle)


def slider_crank(values, *, model="lubricated", axis=(1.0, 0.0)):
    """A slider-crank; throw, rod and pivot are swept."""
    throw, rod = crank("crank", values["throw"]), crank("rod", values["rod"])
    slider = cl.Body("slider", 0.14, 1e-5, points={"pin": (0.0, 0.0)})
    joint = {"radius": 0.01, "length": 0.02, "clearance": values.get("clearance", 1e-4)}
    return cl.Scene(
        cl.Revolute(cl.ground.at(0.0, values.get("pivot", 0.0)), throw["near"], name="A"),
        cl.Revolute(throw["far"], rod["near"], name="B"),
        cl.ClearanceRevolute(rod["far"], slider["pin"], name="C", **joint, **JOINT[model]),
        cl.Prismatic(cl.ground, slider["pin"], axis=axis, name="guide"),
        cl.Drive(throw, speed=values.get("speed", 60.0)),
    )


def drag_link(values):
    """Both cranks turn; the driven one is the faster at the start."""
    throw, coupler = crank("crank", values["throw"]), crank("coupler", 0.1, 1.0)
    follower = crank("follower", values["follower"], 1.5)
    joint = {"radius": 0.01, "length": 0.02, "clearance": 1e-4}
    return cl.Scene(
        cl.Revolute(cl.ground, throw["near"], name="A"),
        cl.Revolute(throw["far"], coupler["near"], name="B"),
        cl.ClearanceRevolute(
            coupler["far"], follower["far"], name="C", **joint, **JOINT["lubricated"]
        ),
        cl.Revolute(cl.ground.at(0.03, 0.0), follower["near"], name="D"),
        cl.Drive(throw, speed=values.get("speed", 60.0), start=2.5),
    )


def hung(values):
    """A body on two springs, its start from two lengths."""
    start = (values["rod"] + values["spring"], 0.0)
    body = cl.Body("body", 1.0, 1e-3, points={"a": (0.05, 0.0), "b": (-0.05, 0.0)}, position=start)
    springs = {"stiffness": 400.0, "damping": 1.0, "free_length": 0.1}
    return cl.Scene(
        cl.SpringDamper(cl.ground.at(0.0, 0.0), body["a"], name="one", **springs),
        cl.SpringDamper(cl.ground.at(0.0, 0.5), body["b"], name="two", **springs),
    )


def drawn(seed, **middles):
    """Numbers within 1 % of those in the middle."""
    rng = np.random.default_rng(seed)
    return {n: middle * rng.uniform(0.99, 1.01, POINTS) for n, middle in middles.items()}


LENGTHS = {"throw": 0.05, "rod": 0.12}
OTHERS = [{}, {"clearance": 1e-4}, {"speed": 60.0}, {"pivot": 0.01}]


@pytest.mark.parametrize("model", ["lubricated", "dry"])
@pytest.mark.parametrize("others", OTHERS)
@pytest.mark.parametrize("seed", few_of(range(1, 6), 1))
def test_metrics(model, others, seed):
    """Those of the ordinary way at random points: within 2e-4 at rtol 1e-6, deviations from ideal
    joints 5e-3. Dry ones run half a turn at rtol 1e-9, before chaos.
    """
    columns = drawn(seed, **LENGTHS, **others)
    options = OPTIONS if model == "lubricated" else {"turns": 1.0, "rtol": 1e-9}

    def scene(values):
        return slider_crank(values, model=model)

    together = Together(scene, columns, options, None)
    points = together.points(columns)
    answers = together.answers(points)
    assert together.summing.sound(answers, points).all()
    metrics = together.summing.metrics(answers, points)
    assert any("deviation" in name for name in metrics)
    for k in range(0, POINTS, 8):
        at = {n: column[k].item() for n, column in columns.items()}
        for name, value in ordinary(scene, at, options)[0].items():
            allowed = tolerance(name) * abs(value) + 1e-9
            assert metrics[name][k] == pytest.approx(value, abs=allowed), name


def test_seconds_of_complete_turns():
    """A length in seconds is one in turns where all points have the same, complete ones: the same
    to 1e-6. A part of a turn behind them changes nothing but the samples.
    """
    columns = drawn(4, **LENGTHS)
    turn = 2.0 * np.pi / 60.0
    metrics = []
    same = {"until": 2.0 * turn, "samples": 801}
    for options in ({"turns": 2.0}, same, {"until": 2.3 * turn}):
        together = Together(slider_crank, columns, options, None)
        points = together.points(columns)
        metrics.append(together.summing.metrics(together.answers(points), points))
    for name, values in metrics[0].items():
        np.testing.assert_allclose(metrics[1][name], values, rtol=1e-6, atol=1e-9, err_msg=name)
        longer, share = metrics[2][name], tolerance(name)
        np.testing.assert_allclose(longer, values, rtol=share, atol=1e-9, err_msg=name)


def test_company():
    """A point is the same, bit for bit, in other company and in two threads."""
    columns = drawn(7, **LENGTHS, clearance=1e-4)
    together = Together(slider_crank, columns, OPTIONS, None)
    points = together.points(columns)
    alone = together.answers(points)
    metrics = together.summing.metrics(alone, points)
    for order in (np.arange(POINTS)[::-1], np.array([5]), np.arange(3, 14)):
        mine = {n: column[order] for n, column in columns.items()}
        others = together.points(mine)
        np.testing.assert_array_equal(others.ideal, points.ideal[order])
        again = together.summing.metrics(together.answers(others), others)
        for name, values in metrics.items():
            np.testing.assert_array_equal(again[name], values[order], err_msg=name)


def test_requested_errors(tmp_path):
    """Each point climbs its own ladder of tolerances: all of them have stated errors below 1e-5."""
    (tmp_path / "own.toml").write_text(SCENE)
    points = cl.zipped(**drawn(8, throw=0.05, clearance=1e-4))
    options = {"turns": 2.0, "workers": 1, "channels": [], "error": 1e-5}
    swept = cl.sweep(tmp_path / "own.toml", points, tmp_path / "out", **options)
    assert f"{POINTS} points in lanes" in (tmp_path / "out" / "sweep.log").read_text()
    peak, error = (swept.metrics[f"joint_C_force_max{end}"] for end in ("", "_error"))
    assert (error <= 1e-5 * peak).all()


def test_speeds_of_the_start():
    """A typical speed is that of the driven crank, which follows from all lengths: the same within
    1e-12, whatever runs beside, and metrics are those of the ordinary way.
    """
    columns = drawn(3, throw=0.1, follower=0.09)
    together = Together(drag_link, columns, OPTIONS, None)
    assert together.spread.rates is not None
    points = together.points(columns)
    answers = together.answers(points)
    assert together.summing.sound(answers, points).all()
    metrics = together.summing.metrics(answers, points)
    for k in range(0, POINTS, 8):
        at = {n: column[k].item() for n, column in columns.items()}
        run = together.spread.prepared(at)
        assert run.mechanism.frequency > 61.0
        assert points.frequency[k] == pytest.approx(run.mechanism.frequency, rel=1e-12)
        lone = together.points({n: column[k : k + 1] for n, column in columns.items()})
        assert lone.frequency[0] == points.frequency[k]
        for name, value in ordinary(drag_link, at, OPTIONS)[0].items():
            assert metrics[name][k] == pytest.approx(value, rel=2e-4, abs=1e-9), name


def test_starts_that_are_prepared(monkeypatch):
    """A place of a body is a coordinate, which lengths decide. Long runs have it prepared point by
    point, bit for bit; short ones take the ordinary way.
    """
    columns = drawn(3, rod=0.3, spring=0.2)
    options = {"until": 0.5, "samples": 41}
    with pytest.raises(NotForLanes, match="several parameters"):
        Together(hung, columns, options, None)
    monkeypatch.setattr(in_lanes, "LONG", 0)
    together = Together(hung, columns, options, None)
    assert together.spread.solved.size
    points = together.points(columns)
    answers = together.answers(points)
    assert together.summing.sound(answers, points).all()
    for k in range(0, POINTS, 8):
        run = together.spread.prepared({n: column[k].item() for n, column in columns.items()})
        np.testing.assert_array_equal(points.y[:, k], run.state.y)


def test_a_point_that_cannot_be_prepared(monkeypatch):
    """It is left to the ordinary way, which gives the reason."""
    monkeypatch.setattr(in_lanes, "LONG", 0)
    columns = drawn(3, rod=0.3, spring=0.2)
    together, odd = Together(hung, columns, {"until": 0.5, "samples": 41}, None), columns["rod"][5]
    usual = together.spread.prepared

    def prepared(values):
        if values["rod"] == odd:
            raise ValueError("a loop cannot close")
        return usual(values)

    monkeypatch.setattr(together.spread, "prepared", prepared)
    points = together.points(columns)
    sound = together.summing.sound(together.answers(points), points)
    assert np.flatnonzero(~sound).tolist() == [5]


def test_a_guide_that_turns():
    """The direction of a guide is a constant of metrics."""

    def scene(values):
        return slider_crank(values, axis=(1.0, 0.1 * values["slope"]))

    columns = drawn(2, **LENGTHS, slope=1.0)
    with pytest.raises(NotForLanes):
        Together(scene, columns, OPTIONS, None)
