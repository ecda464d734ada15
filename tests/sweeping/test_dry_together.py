"""Dry points in lanes: contacts and metrics of the ordinary way before chaos, its statistics after;
whatever runs beside.
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

import clearance as cl
from clearance.lanes.point_numbers import NotForLanes
from clearance.metrics.of_points import of_point
from clearance.results.recorder import Memory
from clearance.run.ideal_motion import ideal_motion
from clearance.run.recording import attributes_of, record_run
from clearance.scene.catalogue import find_case
from clearance.simulation import prepare
from clearance.sweeping.in_lanes import Together
from tests.seeds import few_of

POINTS = 24
OIL = cl.Lubricant(viscosity=0.02)
#: of each case: speeds [rad/s] and turns in which bearings touch, but are not chaotic yet
SPEEDS = {"slider_crank": (100.0, 400.0), "four_bar": (10.0, 60.0), "six_bar_feeder": (10.0, 60.0)}


def points_of(name, seed, count=POINTS):
    """Speeds and clearances at random."""
    rng = np.random.default_rng(seed)
    clearance = np.exp(rng.uniform(*np.log([5e-5, 5e-4]), count))
    return {"speed": rng.uniform(*SPEEDS[name], count), "clearance": clearance}


def scenes(name, oil="", **fixed):
    """A function of the swept values, to a dry scene of a case; oil: the joint that has a film in
    place of its contact.
    """
    case = find_case(name)

    def scene(values):
        dry = case.scene(**{"model": "dry"} | fixed | values)
        if not oil:
            return dry
        film = {"contact": None, "friction": None, "film": cl.table_film(), "lubricant": OIL}
        joints = [replace(j, **film) if j.name == oil else j for j in dry.joints]
        return cl.Scene(*joints, *dry.drives, gravity=dry.gravity, name=name)

    return scene


def ordinary(scene, values, options):
    """Metrics of one point the ordinary way, and its record."""
    run = prepare(scene(values), **options)
    sink = Memory(run.mechanism.layout.channels, attributes_of(run))
    assert record_run(run, sink) is None
    ideal = ideal_motion(run.mechanism.scene, run.span, sink.record.scene)
    return {n: m.value for n, m in of_point(sink.record, None, ideal).items()}, sink.record


class Ran:
    """Points in lanes."""

    def __init__(self, scene, columns, **options):
        self.together = Together(scene, columns, {"turns": 1.0, "rtol": 1e-8} | options, None)
        self.points = self.together.points(columns)
        self.answers = self.together.answers(self.points)
        self.metrics = self.together.summing.metrics(self.answers, self.points)
        #: blocks that rest on stiff corners may be left to the ordinary way
        self.sound = self.together.summing.sound(self.answers, self.points)
        assert self.sound.mean() > 0.9


SCENES = [
    ("slider_crank", {}),
    ("slider_crank", {"contact": "flores", "friction": "coulomb"}),
    ("slider_crank", {"contact": "johnson", "friction": "stribeck"}),
    ("slider_crank", {"contact": "herbert_mcwhannell"}),
    ("slider_crank", {"joints": "guide", "friction": "coulomb"}),
    ("slider_crank", {"joints": "C,guide", "restitution": 0.2}),
    ("four_bar", {"contact": "gonthier"}),
    ("four_bar", {"joints": "B,C", "restitution": 0.2}),
    ("four_bar", {"joints": "B,C", "oil": "B"}),
    ("six_bar_feeder", {"joints": "B,C,E", "oil": "C", "contact": "flores"}),
    ("six_bar_feeder", {"model": "mixed", "transition": "flores"}),
    ("slider_crank", {"model": "mixed", "joints": "C,guide", "transition": "fuzzy"}),
    ("slider_crank", {"model": "mixed", "joints": "guide", "transition": "load_sharing"}),
    ("slider_crank", {"model": "lubricated", "joints": "guide", "transition": "none"}),
    ("slider_crank", {"model": "ideal"}),
    ("six_bar_feeder", {"model": "ideal"}),
]


@pytest.mark.parametrize(("name", "fixed"), SCENES)
@pytest.mark.parametrize("seed", few_of(range(1, 11), 1))
def test_metrics(name, fixed, seed):
    """Before chaos: where a tighter tolerance of the ordinary way changes no metric by 1e-5, lanes
    have all within 1e-4 (measured 4e-5): means of squares are summed to 1e-6, and paths part as
    errors grow. Shares of time of places that balance on a corner are rounding: 1e-8.
    """
    scene, columns, options = scenes(name, **fixed), points_of(name, seed), {"turns": 1.0}
    options["method"] = "radau5" if {"oil", "transition"} & set(fixed) else "dop853"
    ran, calm = Ran(scene, columns, **options), 0
    warnings = ran.together.warnings(columns, ran.answers, ran.points)
    for i in range(6):
        values = {n: v[i].item() for n, v in columns.items()}
        plain, record = ordinary(scene, values, options | {"rtol": 1e-8})
        tight, _ = ordinary(scene, values, options | {"rtol": 1e-10})
        assert list(ran.metrics) == list(plain)
        assert len(record.warnings) == warnings[i]
        calmly = list(plain.values()) == pytest.approx(list(tight.values()), rel=1e-5, abs=1e-9)
        if calmly and ran.sound[i]:
            mine = [ran.metrics[n][i] for n in tight]
            assert mine == pytest.approx(list(tight.values()), rel=1e-4, abs=1e-8)
            calm += 1
    assert calm > 0


@pytest.mark.parametrize("seed", few_of(range(10), 2))
def test_contacts(seed):
    """Begins, impact speeds and durations of the first contacts are those of the ordinary way:
    within 1e-4 of the shortest, at rtol 1e-10.
    """
    scene, columns = scenes("slider_crank"), points_of("slider_crank", seed)
    ran = Ran(scene, columns, rtol=1e-10)
    for i in range(3):
        values = {n: v[i].item() for n, v in columns.items()}
        _, record = ordinary(scene, values, {"turns": 1.0, "rtol": 1e-10})
        rows = ran.answers.impacts[ran.answers.impacts[:, 0] == i][:5]
        events = {name: column[: len(rows)] for name, column in record.events.items()}
        shortest = rows[:, 4].min()
        np.testing.assert_allclose(rows[:, 2], events["time"], rtol=0.0, atol=1e-4 * shortest)
        np.testing.assert_allclose(rows[:, 4], events["duration"], rtol=0.0, atol=1e-4 * shortest)
        np.testing.assert_allclose(rows[:, 3], events["impact_speed"], rtol=1e-4)


@pytest.mark.parametrize("rtol", [1e-3, 1e-8])
@pytest.mark.parametrize("seed", few_of(range(10), 1))
def test_tolerances(rtol, seed):
    """Lanes have radau5 where single runs of films choose methods without lanes: numbers above a
    millionth are within 30 rtol, some times the errors of three scenes.
    """
    scene, columns = scenes("six_bar_feeder", model="lubricated"), points_of("six_bar_feeder", seed)
    ran = Ran(scene, columns, rtol=rtol)
    assert ran.together.run.method.current == "radau5"
    for i in np.flatnonzero(ran.sound)[:2]:
        values = {n: v[i].item() for n, v in columns.items()}
        exact, _ = ordinary(scene, values, {"turns": 1.0, "rtol": 1e-11})
        for name in (n for n, value in exact.items() if abs(value) > 1e-6):
            assert ran.metrics[name][i] == pytest.approx(exact[name], rel=30.0 * rtol)


def test_company():
    """A run is the same, bit for bit, in other company, in two threads, alone."""
    scene, columns = scenes("four_bar", friction="coulomb"), points_of("four_bar", 3)
    ran = Ran(scene, columns)
    mixed = np.random.default_rng(5).permutation(POINTS)
    moved = {n: v[mixed] for n, v in columns.items()}
    both = [ran.together.points(numbers) for numbers in (moved, columns)]
    with ThreadPoolExecutor(2) as threads:
        others, _ = threads.map(ran.together.answers, both)
    for name in ("extremes", "totals", "ledgers", "tracks", "steps"):
        np.testing.assert_array_equal(getattr(others, name), getattr(ran.answers, name)[mixed])
    for k in (0, 7):
        mine = ran.answers.impacts[ran.answers.impacts[:, 0] == mixed[k], 1:]
        np.testing.assert_array_equal(others.impacts[others.impacts[:, 0] == k, 1:], mine)


def test_statistics():
    """Chaotic runs: means over points and turns are those of the ordinary way, within three of
    their standard errors and 2 %.
    """
    scene, columns = scenes("slider_crank"), points_of("slider_crank", 4, 40)
    ran, options = Ran(scene, columns, turns=6.0, rtol=1e-6), {"turns": 6.0, "rtol": 1e-6}
    rows = [
        ordinary(scene, {n: v[i].item() for n, v in columns.items()}, options)[0] for i in range(40)
    ]
    for metric in ("joint_C_force_rms", "joint_C_contact_fraction", "dissipated_per_turn"):
        plain = np.array([row[metric] for row in rows])
        apart = ran.metrics[metric] / plain - 1.0
        assert abs(apart.mean()) <= 3.0 * apart.std() / 40**0.5 + 0.02, metric


def test_buffers_of_contacts_that_are_full(monkeypatch):
    """Contacts are taken in piece by piece: the same rows."""
    scene, columns = scenes("slider_crank"), points_of("slider_crank", 6)
    at_once = Ran(scene, columns).answers
    monkeypatch.setattr("clearance.lanes.group.IMPACTS", 40)
    np.testing.assert_array_equal(Ran(scene, columns).answers.impacts, at_once.impacts)


def test_warnings_that_depend_on_swept_numbers():
    """A law warns of small restitutions: each point has the warnings of its scene."""
    scene, columns = scenes("slider_crank"), points_of("slider_crank", 8)
    columns["restitution"] = np.random.default_rng(8).uniform(0.3, 0.95, POINTS)
    ran = Ran(scene, columns)
    warned = ran.together.warnings(columns, ran.answers, ran.points)
    assert len(set(warned)) > 1
    for i in range(0, POINTS, 6):
        values = {n: v[i].item() for n, v in columns.items()}
        _, record = ordinary(scene, values, {"turns": 1.0, "rtol": 1e-8})
        assert warned[i] == len(record.warnings)


def test_stiff_friction_is_left_to_the_ordinary_way():
    """Its method would change on the way."""
    with pytest.raises(NotForLanes, match="changes its method"):
        Ran(scenes("slider_crank", friction="lugre"), points_of("slider_crank", 1))


def test_sweeps_say_how_points_ran(tmp_path, caplog):
    """A dry sweep runs in lanes, with the metrics of its points the ordinary way."""
    points = cl.grid(speed=list(np.linspace(100.0, 300.0, 6)), clearance=[1e-4, 2e-4, 3e-4, 4e-4])
    with caplog.at_level("INFO", "clearance.sweep"):
        cl.sweep("slider_crank", points, tmp_path, fixed={"model": "dry"}, turns=1, channels=[])
    assert "24 points in lanes" in caplog.text


def test_sharp_friction_of_joints_is_left_to_the_ordinary_way():
    """Implicit steps of lanes do not look for where it turns round; explicit ones resolve it."""
    case = find_case("three_loop_chain")
    columns = {"transition_rate": np.geomspace(1e-2, 1e-1, POINTS)}
    options = {"until": 0.2, "rtol": 1e-6}

    def scene(values):
        return case.scene(drive="torque", where="all", **values)

    with pytest.raises(NotForLanes, match="turns round inside steps"):
        Together(scene, columns, options, None)
    together = Together(scene, columns, options | {"method": "dop853"}, None)
    points = together.points(columns)
    assert together.summing.sound(together.answers(points), points).all()
