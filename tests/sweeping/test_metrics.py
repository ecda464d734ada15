"""Summary metrics against other ways to them: arrays of the run, energy balances, closed forms,
made-up records.
"""

import dataclasses
import importlib
import json
import math
import subprocess
import sys
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

import clearance as cl
from clearance.metrics import metrics as defined
from clearance.metrics.metrics import Window, integrating, metrics, of_user
from clearance.metrics.of_points import of_point
from clearance.results.extremes import Extremes, guides
from clearance.results.recorder import Memory
from clearance.run import ideal_motion as ideals
from clearance.run.ideal_motion import ideal_motion
from clearance.run.options import Span
from clearance.run.recording import attributes_of, record_run
from clearance.simulation import prepare
from tests.mechanisms import body, scotch_yoke
from tests.mechanisms import dry as dry_joint
from tests.postprocess.records import Formula, joint

CRANK, ROD = 0.05, 0.12  # of the case slider_crank [m]
FEEDER = {"speed": 30.0, "model": "lubricated", "film": "harmonic"}


def recorded(scene, **options):
    """A run in memory and what ideal joints would have it do."""
    run = prepare(scene, **options)
    sink = Memory(run.mechanism.layout.channels, attributes_of(run))
    record_run(run, sink)
    return sink.record, ideal_motion(run.mechanism.scene, run.span, sink.record.scene)


def values(record, settle=None, ideal=None):
    """Metrics of a record by name."""
    return {name: metric.value for name, metric in metrics(record, settle, ideal).items()}


def ideal_of(scene, turns=1.0, samples=101):
    """Motion of the sliders of a scene with ideal joints, over some turns."""
    span = Span(turns * (scene.turn or 1.0), samples)
    return ideal_motion(scene, span, json.loads(scene.to_json()))


@pytest.fixture(scope="module")
def feeder():
    return recorded(cl.load_case("six_bar_feeder", **FEEDER), turns=6.0, samples_per_turn=200)


@pytest.fixture(scope="module")
def dry():
    """Two dry joints with friction, and an end within a turn."""
    scene = cl.load_case("six_bar_feeder", speed=30.0, model="dry", joints="B,C", clearance=2e-4)
    return recorded(scene, turns=3.3, samples_per_turn=200)


@pytest.fixture(scope="module")
def mixed():
    return recorded(
        cl.load_case("four_bar", model="mixed", film="pinkus_sternlicht", viscosity=0.002),
        turns=3.0,
    )


# --- the window
def clocked(turns, per_turn=40, speed=7.3, **more):
    """A record that lasts so many turns, its times as a run makes them."""
    length, count = turns * (2.0 * math.pi / abs(speed)), max(round(per_turn * turns), 1)
    time = np.append(np.arange(count) * (length / count), length)
    return Formula(time, {}, speed=speed, **more)


thousandths = st.integers(0, 12000)
#: turns after settling, many of them full or a thousandth beside
lefts = thousandths | st.builds(
    lambda entire, beside: 1000 * entire + beside, st.integers(0, 12), st.integers(-1, 1)
)


@given(thousandths, lefts, st.integers(1, 60), st.sampled_from([7.3, -31.4159, 1e-3, 523.6]))
@example(1000, 2000, 40, 7.3)
@example(100, 1000, 40, 7.3)
@example(300, 3000, 10, 523.6)
@example(11999, 1, 1, 7.3)
def test_a_window_has_whole_turns_after_settling_and_no_more(settle, rest, per_turn, speed):
    """Full turns by exact arithmetic; all numbers are multiples of 0.001, so 1e-9 of a run never is
    a complete turn.
    """
    turns, settle = (f"{number / 1000:.3f}" for number in (settle + rest, settle))
    rest = Fraction(rest, 1000)
    assume(float(turns) > 0.0)
    record = clocked(float(turns), per_turn, speed)
    window, length = Window.of(record, float(settle)), float(record.time[-1])
    if rest <= 0:
        assert window is None
        return
    if window is None:  # too few samples
        assert math.floor(rest) <= 2
        assert (record.time >= float(settle) * record.turn * (1.0 - 1e-9)).sum() <= per_turn + 1
        return
    assert window.begin == float(settle) * record.turn
    assert window.begin < window.end <= length
    if rest >= 1:
        assert window.turns == math.floor(rest)
        span = window.turns * record.turn
        assert window.end - window.begin == pytest.approx(span, rel=1e-9 * float(turns))
    else:
        assert window.end == length
        assert window.turns == pytest.approx(float(rest), rel=1e-9)
    inside = record.time[window.samples]
    assert inside[0] >= window.begin * (1.0 - 1e-9)
    assert inside[-1] <= window.end * (1.0 + 1e-9)
    before, after = record.time[: window.samples.start], record.time[window.samples.stop :]
    assert (before < window.begin).all()
    assert (after > window.end).all()
    assert window.weights.shape == inside.shape
    assert window.weights.min() >= 0.0
    assert window.weights.sum() == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize(
    ("turns", "begin", "entire"),
    [(0.7, 0.0, 0.7), (1.0, 0.0, 1), (1.9, 0.0, 1), (2.0, 1.0, 1), (6.5, 1.0, 5)],
)
def test_the_first_turn_is_left_out_where_there_is_a_second(turns, begin, entire):
    """Without a request the start is left out, where enough remains."""
    window = Window.of(clocked(turns), None)
    assert window.begin == begin * clocked(turns).turn
    assert window.turns == pytest.approx(entire, rel=1e-12)


@pytest.mark.parametrize(
    ("turns", "settle", "entire"),
    [(0.9, None, None), (1.9, None, None), (2.0, None, 1), (2.6, 0.5, 2), (2.6, 2.0, None)],
)
def test_a_run_that_ended_early_has_whole_turns_or_none(turns, settle, entire):
    """Such a run is not seen with its start, nor by a part of a turn, as if that were what the
    point is like.
    """
    window = Window.of(clocked(turns, status="partial: something broke"), settle)
    assert window is None if entire is None else window.turns == entire


def test_without_a_turn_the_window_is_in_seconds():
    """Settling is in seconds; nothing left is no metric."""
    record = Formula(np.linspace(0.0, 3.5, 71), {}, speed=None)
    assert Window.of(record, None).begin == 0.0
    window = Window.of(record, 1.25)
    assert (window.begin, window.end, window.turns) == (1.25, 3.5, None)
    assert window.per() == (2.25, "per_second", "in a second")
    early = Formula(np.linspace(0.0, 3.5, 71), {}, speed=None, status="partial: something broke")
    assert Window.of(early, 1.25) is not None
    assert metrics(record, 3.5) == {}
    assert metrics(record, 100.0) == {}


@pytest.mark.parametrize("time", [[], [0.0], [0.0, 6.0]])
def test_too_few_samples_give_no_metrics(time):
    """Two samples after settling are the least."""
    assert metrics(Formula(time, {"bodies/slider/ax": np.zeros(len(time))}), 1.0) == {}


@pytest.mark.parametrize("settle", [-1.0, math.nan, math.inf])
def test_a_settle_that_is_none_is_refused(settle):
    """It must be a finite number, not negative."""
    with pytest.raises(ValueError, match="settle must"):
        metrics(clocked(3.0), settle)


@given(st.floats(0.5, 9.5), st.floats(0.0, 4.0), st.integers(5, 80))
def test_means_are_over_time(turns, settle, per_turn):
    """Each sample stands for the time half-way to its neighbours: right to half a step of the slope
    at the ends.
    """
    assume(turns - settle > 0.5)
    record = clocked(turns, per_turn)
    window = Window.of(record, settle)
    mean, step = window.mean(record.time[window.samples]), record.time[1]
    half = 0.5 * (window.begin + window.end)
    assert abs(mean - half) <= step**2 / (window.end - window.begin) + 1e-12
    assert window.mean(np.ones(record.time.size)[window.samples]) == pytest.approx(1.0, abs=1e-12)


# --- made-up motions
def shaker(turns=4.0, per_turn=50, speed=2.0 * math.pi, joints=(), events=None, **channels):
    """A record of one turn a second with a drive and joint C (force 3 N, 4 N, gap 1e-4 m) unless
    stated otherwise.
    """
    count = round(turns * per_turn)
    flat = {"force_x": 3.0, "force_y": 4.0, "gap": 1e-4, "eccentricity_x": 9e-4}
    flat |= {"eccentricity_y": 0.0}
    functions = {n: (lambda t, v=v: np.full(t.shape, v)) for n, v in flat.items()} | channels
    paths = {f"joints/C/{n}": v for n, v in functions.items()}
    columns = {"peak_penetration": np.zeros(0)} | (events or {})
    time, joints = np.linspace(0.0, turns, count + 1), joints or (joint("C"),)
    return Formula(time, paths, speed=speed, joints=joints, events=columns)


def twice(record):
    """A record whose joint B has the channels of joint C."""
    joints = {p: v for p, v in record.data.items() if p.startswith("joints/")}
    record.data |= {p.replace("/C/", "/B/"): v for p, v in joints.items()}
    return record


BOTH = joint("B"), joint("C")
COSINE = {"force_x": lambda t: 5.0 * np.cos(2.0 * np.pi * t), "force_y": np.zeros_like}


def contacts(begin, duration, joints=None, speed=0.5, force=10.0, depth=1e-6):
    """Columns of the events of contacts that begin at these times [s]."""
    begin = np.asarray(begin, float)
    numbers = {"duration": duration, "impact_speed": speed, "peak_force": force}
    numbers |= {"peak_penetration": depth}
    columns = {name: np.broadcast_to(v, begin.shape).astype(float) for name, v in numbers.items()}
    names = np.array(joints or ["C"] * begin.size, dtype=str)
    return columns | {"time": begin, "joint": names, "kind": np.full(begin.size, "contact")}


def test_root_mean_square_of_a_sine_is_exact_over_whole_turns():
    """The trapezium rule integrates a sine over full turns exactly; counting both ends fully would
    be off by 1 %.
    """
    actual = values(shaker(**COSINE))
    assert actual["joint_C_force_rms"] == pytest.approx(5.0 / math.sqrt(2.0), rel=1e-14)
    assert actual["joint_C_force_max"] == pytest.approx(5.0, rel=1e-14)


@pytest.mark.parametrize("turns", [2.37, 5.91])
def test_root_mean_square_where_samples_are_not_those_of_the_turn(turns):
    """Off by the two ends only: half a step each of a window of full turns."""
    rms = values(shaker(turns, 53, **COSINE), 0.29)["joint_C_force_rms"]
    assert rms == pytest.approx(5.0 / math.sqrt(2.0), rel=0.5 / 53)


def located(record, **quantities):
    """Give a record extremes of joints, a value for each of its turns: C_force_max=[...]."""
    names = tuple("joints/{}/{}".format(*name.split("_", 1)) for name in quantities)
    columns = np.array(list(quantities.values()), dtype=float).T
    times = np.broadcast_to(np.arange(len(columns))[:, None] + 0.5, columns.shape)
    record.located = Extremes(1.0, names, ("?",) * len(names), columns, times)
    return record


def test_peaks_between_samples_are_the_located_ones_of_the_window():
    """Values of turns in the window only; without them those of the samples."""
    forces, gaps = [900.0, 70.0, 20.0, 800.0], [-9e-6, -2e-6, -1e-6, 0.0]
    record = located(shaker(3.5), C_force_max=forces, C_gap_min=gaps)
    actual = values(record)  # window: turns 1 and 2
    assert metrics(record)["joint_C_force_max"].time == 1.5
    assert actual["joint_C_force_max"] == 70.0
    assert actual["joint_C_gap_min"] == -2e-6
    assert actual["joint_C_eccentricity_ratio_max"] == pytest.approx(1.002, rel=1e-12)
    quiet = values(shaker(3.5, events=contacts([0.4], 1e-3)))
    assert (quiet["joint_C_force_max"], quiet["joint_C_gap_min"]) == (5.0, 1e-4)
    assert (quiet["joint_C_impacts_per_turn"], quiet["joint_C_impact_speed_max"]) == (0.0, 0.0)


def test_film_thickness_ratio_is_that_of_the_smallest_gap():
    """Located gap over roughness."""
    rough = joint("C") | {"roughness": 2e-6}
    actual = values(located(shaker(3.0, joints=(rough,)), C_gap_min=[0.0, -3e-6, 0.0]))
    assert actual["joint_C_film_thickness_ratio_min"] == pytest.approx(-1.5, rel=1e-12)


@pytest.mark.parametrize(
    ("begin", "duration", "share", "impacts"),
    [
        ([0.0], [4.0], 1.0, 0.0),  # permanent, since before the window
        ([1.0], [3.0], 1.0, 1.0 / 3.0),  # permanent, open at the end, begun with the window
        # one into the window, one inside, one open
        ([0.5, 2.0, 3.75], [1.0, 0.25, 0.25], 1.0 / 3.0, 2.0 / 3.0),
        ([0.2, 4.0], [0.8, 0.0], 0.0, 0.0),  # over when the window begins, begun when it ends
        ([], [], 0.0, 0.0),
    ],
)
def test_contact_fraction_and_impacts_of_contacts_at_the_windows_ends(
    begin, duration, share, impacts
):
    """Parts inside the window count; an impact where it begins."""
    actual = values(shaker(4.0, events=contacts(begin, duration)))
    assert actual["joint_C_contact_fraction"] == pytest.approx(share, abs=1e-15)
    assert actual["joint_C_impacts_per_turn"] == pytest.approx(impacts, abs=1e-15)


@given(
    st.lists(st.tuples(st.floats(0.0, 0.9), st.floats(0.1, 1.0)), max_size=8),
    st.integers(1, 3),
    st.data(),
)
def test_windows_side_by_side_share_out_contacts(parts, cut, data):
    """Counts in two adjacent windows add up to each event once: a contact, and its time on either
    side.
    """
    begin = np.array([(i + b) * 0.5 for i, (b, _) in enumerate(parts)])
    duration = np.array([0.5 * (1.0 - b) * d for b, d in parts])
    names = data.draw(st.lists(st.sampled_from("BC"), min_size=len(parts), max_size=len(parts)))
    record = shaker(4.0, events=contacts(begin, duration, names))
    first = dataclasses.replace(Window.of(record, 0.0), end=float(cut), turns=float(cut))
    second = Window.of(record, float(cut))
    of = [
        {n: v for n, v, *_ in defined.joints(defined.OfRecord(record, w, {}))}
        for w in (first, second)
    ]
    for name, total in (
        ("impacts_per_turn", names.count("C")),
        ("contact_fraction", duration[np.array(names) == "C"].sum()),
    ):
        before, after = (part[f"joint_C_{name}"] for part in of)
        assert before * cut + after * (4 - cut) == pytest.approx(total, abs=1e-12)


def test_contact_of_one_joint_is_none_of_another():
    """Speeds, forces and shares by joint."""
    touches = contacts([1.2, 1.6], 0.1, ["B", "C"], [1.0, 2.0], [50.0, 60.0])
    record = twice(shaker(3.0, joints=BOTH, events=touches))
    actual = values(located(record, B_force_max=[0.0, 50.0, 0.0], C_force_max=[0.0, 60.0, 0.0]))
    for name, speed, force in (("B", 1.0, 50.0), ("C", 2.0, 60.0)):
        assert actual[f"joint_{name}_impact_speed_max"] == speed
        assert actual[f"joint_{name}_force_max"] == force
        assert actual[f"joint_{name}_contact_fraction"] == pytest.approx(0.05, rel=1e-12)


def wet(law):
    """A joint with film and contact as scenes describe it."""
    return joint("C") | {
        "film": {"law": "clearance.laws.film:harmonic"},
        "transition": {"law": f"clearance.laws.transition:{law}"},
    }


def test_contact_that_sets_in_gradually_is_read_off_the_samples():
    """The share of samples with force, and no impacts."""
    gradual = (wet("load_sharing"),)
    for turns, per_turn, force, share in (
        (3.0, 50, lambda t: np.where(np.mod(t, 1.0) < 0.195, 8.0, 0.0), 0.2),  # 10 of 50 samples
        (3.3, 37, lambda t: np.full(t.shape, 8.0), 1.0),
    ):
        actual = values(shaker(turns, per_turn, joints=gradual, contact_force=force))
        assert actual["joint_C_contact_fraction"] == pytest.approx(share, rel=1e-12)
        assert "joint_C_impacts_per_turn" not in actual


@pytest.mark.parametrize("begin", [[], [1.3, 2.3]])
def test_a_film_whose_contact_begins_with_a_touch_has_impacts(begin):
    """Its events count, also where no sample sees them."""
    # no sample falls into the contacts
    options = {"events": contacts(begin, 0.01), "contact_force": np.zeros_like}
    actual = values(shaker(3.0, joints=(wet("flores_hybrid"),), **options))
    assert actual["joint_C_impacts_per_turn"] == len(begin) / 2.0
    assert actual["joint_C_contact_fraction"] == pytest.approx(0.01 * len(begin) / 2.0, rel=1e-12)


BLEND = """
import clearance as cl


@cl.transition
def blend(gap, joint, tolerance):
    beyond = min(max(-gap / (tolerance * joint.clearance), 0.0), 1.0)
    film_gap = max(gap, 1e-3 * joint.clearance)
    return 1.0 - beyond, film_gap, 1.0, beyond, -gap, 1.0, 0.0, 0.0


blend.first_touch = {}
"""
METRICS = """
import json, sys, clearance as cl
from clearance.metrics.metrics import metrics
with cl.open_result(sys.argv[1]) as result:
    print(json.dumps({n: m.value for n, m in metrics(result).items()}))
"""


@pytest.mark.parametrize("touching", [True, False])
def test_a_file_states_whose_contact_begins_with_a_touch(touching, tmp_path, monkeypatch):
    """A process that never imports the user's transition reads the metrics of one that ran it."""
    module = f"blend_{touching}"
    (tmp_path / f"{module}.py").write_text(BLEND.format(touching))
    monkeypatch.syspath_prepend(tmp_path)
    blend = importlib.import_module(module).blend(tolerance=0.05)
    scene = cl.load_case("slider_crank", model="mixed", film="harmonic", viscosity=0.4)
    scene = scene.rebuilt(
        element=lambda e: (
            dataclasses.replace(e, transition=blend, asperity=None)
            if getattr(e, "transition", None)
            else e
        )
    )
    with cl.simulate(scene, turns=1.5, path=tmp_path / "run.h5") as result:
        here = {name: metric.value for name, metric in metrics(result).items()}
    command = [sys.executable, "-W", "ignore", "-c", METRICS, str(tmp_path / "run.h5")]
    elsewhere = subprocess.run(command, capture_output=True, text=True, cwd="/", check=True)
    assert json.loads(elsewhere.stdout) == here
    assert (here.get("joint_C_impacts_per_turn") == 0.0) == touching


def test_without_a_turn_rates_are_per_second():
    """Names, units and values are those of a second."""
    touches = contacts([0.5, 1.5, 2.5], 0.1)
    record = shaker(4.0, speed=None, events=touches, dissipated=lambda t: 3.0 * t)
    record.data["energy/dissipated"] = 5.0 * record.time
    actual = metrics(record, 1.0)
    for name, value, units in (
        ("joint_C_impacts_per_second", 2.0 / 3.0, "1/s"),
        ("joint_C_dissipated_power", 3.0, "W"),
        ("dissipated_power", 5.0, "W"),
    ):
        assert actual[name].value == pytest.approx(value, rel=1e-14)
        assert actual[name].units == units
    assert not [n for n in actual if "turn" in n or "period" in n]


# --- periods
def orbit(x, y=np.zeros_like, turns=10.0, per_turn=50, **more):
    """A journal whose eccentricity over the clearance (1e-3 m) is a function of time in turns."""
    path = {"eccentricity_x": lambda t: 1e-3 * x(t), "eccentricity_y": lambda t: 1e-3 * y(t)}
    return shaker(turns, per_turn, **path, **more)


def wave(*parts):
    """Sum of (amplitude, periods a turn)."""
    return lambda t: sum(a * np.cos(2.0 * np.pi * k * t + k) for a, k in parts)


@pytest.mark.parametrize(
    ("x", "period"),
    [
        (wave((0.8, 1), (0.2, 3)), 1.0),
        (wave((0.8, 1), (0.1, 0.5)), 2.0),
        (wave((0.8, 1), (0.1, 1 / 3)), 3.0),
        # a subharmonic of less than 1 %: 0.8 % from turn to turn
        (wave((0.8, 1), (0.004, 0.5)), 1.0),
        (wave((0.8, 1), (0.006, 0.5)), 2.0),
        (wave((0.8, 1), (0.1, (math.sqrt(5.0) - 1.0) / 2.0)), math.inf),
        (wave((0.004, 0.618)), 1.0),  # a journal that hardly moves
    ],
)
@pytest.mark.parametrize(("turns", "per_turn"), [(10.0, 50), (9.73, 61)])
def test_period_of_a_known_motion(x, period, turns, per_turn):
    """Also where a turn has a fraction of a sample: the cubic is right to 0.03 (6 pi / 61)^4 < 1e-3
    here.
    """
    assert values(orbit(x, turns=turns, per_turn=per_turn))["period"] == period


def test_period_error_is_the_distance_that_is_left():
    """Both components: after a turn the subharmonic of 0.1 in x and 0.05 in y is on its other
    side.
    """
    actual = values(orbit(wave((0.8, 1), (0.1, 0.5)), wave((0.8, 1), (0.05, 0.5)), turns=4.0))
    assert actual["period"] == math.inf  # three turns are seen: only a period of one is looked for
    assert actual["period_error"] == pytest.approx(2.0 * math.hypot(0.1, 0.05), rel=1e-3)
    assert values(orbit(wave((0.8, 1), (0.1, 0.5))))["period_error"] < 1e-12


def test_a_motion_that_settles_is_told_from_one_that_does_not():
    """A subharmonic fades by 1 / e a turn, and two turns lie between the first and the last change.

    They are seen a sample apart: 1 / 50 of a turn, 2 % of the ratio.
    """

    def fading(t):
        return 0.8 * np.cos(2.0 * np.pi * t) + 0.5 * np.exp(-t) * np.cos(np.pi * t)

    actual = values(orbit(fading, turns=5.0))
    assert actual["period"] == math.inf
    assert actual["settling_ratio"] == pytest.approx(math.exp(-2.0), rel=0.03)
    lasting = values(orbit(wave((0.8, 1), (0.1, (math.sqrt(5.0) - 1.0) / 2.0))))
    assert lasting["settling_ratio"] > 0.5
    assert values(orbit(np.zeros_like))["settling_ratio"] == 0.0


def test_a_journal_that_comes_by_the_same_place_on_other_ways_has_no_period():
    """Pressed against the bearing once a turn, chaotic in between: one section a turn would take it
    for periodic.
    """
    way = lambda t: np.sin(np.pi * t) ** 2 * np.cos(7.3 * np.floor(t) ** 2)  # noqa: E731
    assert values(orbit(way))["period"] == math.inf
    assert values(orbit(way))["period_error"] > 0.1


@pytest.mark.parametrize(("turns", "reference"), [(3.9, False), (4.0, True)])
def test_a_period_needs_three_turns(turns, reference):
    """After the one that settles."""
    assert ("period" in values(orbit(wave((0.8, 1)), turns=turns))) == reference


@pytest.mark.parametrize(
    ("turns", "per_turn", "reference"), [(6.0, 1, True), (6.0, 7, True), (6.1, 11.3, False)]
)
def test_few_samples_tell_a_period_only_where_they_are_those_of_the_turn(
    turns, per_turn, reference
):
    """Otherwise they cannot be interpolated."""
    actual = values(orbit(wave((0.8, 1)), turns=turns, per_turn=per_turn))
    assert actual.get("period") == (1.0 if reference else None)


def test_all_journals_must_be_back():
    """The period is that of the slowest joint."""
    record = twice(orbit(wave((0.8, 1)), joints=BOTH))
    assert values(record)["period"] == 1.0
    record.data["joints/B/eccentricity_y"] = 1e-3 * wave((0.1, 0.5))(record.time)
    assert values(record)["period"] == 2.0


# --- runs
def test_every_metric_is_described(feeder, dry, mixed):
    """Each stands in the list at the top of metrics.py, with SI units and a text that names what it
    is about.
    """
    text = defined.__doc__
    for record, ideal in (feeder, dry, mixed):
        names = [*record.names("joints"), *record.names("drives"), *record.names("bodies")]
        for name, metric in metrics(record, None, ideal).items():
            assert isinstance(metric.value, float)
            assert not math.isnan(metric.value)
            assert metric.units in ("1", "m", "m/s", "m/s2", "N", "N m", "J", "turns")
            about = next((n for n in names if f"{n}_" in name), "")
            assert (
                name.partition(f"{about}_")[2].rpartition("_")[2] in text if about else name in text
            )
            assert about in metric.text


def test_forces_gaps_and_torques_are_located(feeder):
    """Located extremes exceed the samples; means agree with integrals over them."""
    record, ideal = feeder
    actual = values(record, None, ideal)
    # 5 turns of 200 samples and the one that begins them
    late = record.time >= record.turn * (1.0 - 1e-9)
    assert late.sum() == 1001

    def rms(v):
        return math.sqrt(np.trapezoid(v[late] ** 2, record.time[late]) / np.ptp(record.time[late]))

    def ends(path, v):
        """Smallest and largest of all turns but the first, beyond all samples there to 1e-8 of
        their range.
        """
        located = record.located
        assert located.values.shape[0] == 6
        names = [f"{path}_{end}" for end in ("min", "max")]
        low, high = (located.of(n, record.turn) if n in located else None for n in names)
        slack = 1e-8 * np.ptp(v[late])
        assert low is None or low.value <= v[late].min() + slack
        assert high is None or high.value >= v[late].max() - slack
        return low and low.value, high and high.value

    force = np.hypot(*record.joint("B").force.T)
    highest = record.extreme("joints/B/force_max", record.turn).value
    assert highest >= force[late].max() * (1.0 - 1e-14)
    assert actual["joint_B_force_max"] == pytest.approx(highest, rel=1e-14)
    # over steps here, over samples there: the dense output and the trapezoidal rule err by less
    assert actual["joint_B_force_rms"] == pytest.approx(rms(force), rel=1e-6)
    torque = rms(record.drive("crank").torque)
    assert actual["drive_crank_torque_rms"] == pytest.approx(torque, rel=1e-5)
    for name, path, channel in (
        ("drive_crank_torque", "drives/crank/torque", record.drive("crank").torque),
        ("slider_acceleration", "bodies/slider/ax", record["slider"].ax),
    ):
        assert (actual[f"{name}_min"], actual[f"{name}_max"]) == ends(path, channel)
    assert actual["joint_B_gap_min"] == ends("joints/B/gap", record.joint("B").gap)[0]
    roughness = record.joint("B").gap[-1] / record.joint("B").film_thickness_ratio[-1]
    assert actual["joint_B_film_thickness_ratio_min"] == pytest.approx(
        actual["joint_B_gap_min"] / roughness, rel=1e-12
    )
    eccentric = 1.0 - actual["joint_B_gap_min"] / 1e-4
    assert actual["joint_B_eccentricity_ratio_max"] == pytest.approx(eccentric, rel=1e-12)


def balanced(record, actual, tolerance):
    """First law over the window: what the drive puts in is taken out or stored, by the run's
    tolerance.
    """
    window = Window.of(record, None)
    at = [
        np.interp((window.begin, window.end), record.time, record.values(f"energy/{n}"))
        for n in ("input", "kinetic", "potential")
    ]
    put, kinetic, potential = (end - begin for begin, end in at)
    assert actual["dissipated_per_turn"] * window.turns == pytest.approx(
        put - kinetic - potential, abs=tolerance * put
    )
    joints = [
        v for n, v in actual.items() if n.startswith("joint_") and n.endswith("dissipated_per_turn")
    ]
    assert sum(joints) == pytest.approx(actual["dissipated_per_turn"], rel=1e-12)
    return put / window.turns, (kinetic + potential) / window.turns


def test_over_a_periodic_turn_the_drive_puts_in_what_the_film_takes_out(feeder):
    """The motion is periodic to 1e-4, so hardly anything is stored; rtol 1e-6 leaves a ledger that
    closes to 1e-4.
    """
    record, _ = feeder
    actual = values(record, 3.0)
    assert actual["period"] == 1.0
    assert actual["period_error"] < 1e-4
    put, stored = balanced(record, values(record), 1e-4)
    assert actual["dissipated_per_turn"] == pytest.approx(put, rel=1e-3)
    assert abs(stored) < 1e-3 * put
    late = record.time >= 3.0 * record.turn * (1.0 - 1e-9)
    # two other ways to the same number: the power of the joint, and that of the drive, by the
    # trapezium rule
    for power in (record.joint("B").power_loss, record.drive("crank").torque * 30.0):
        mean = np.trapezoid(power[late], record.time[late]) / 3.0
        assert actual["joint_B_dissipated_per_turn"] == pytest.approx(mean, rel=1e-3)


def test_turning_the_other_way(feeder):
    """Metrics of a drive at negative speed have the same names and signs: turns and rates are
    positive.
    """
    scene = cl.load_case("six_bar_feeder", **FEEDER | {"speed": -30.0})
    record, ideal = recorded(scene, turns=3.0, samples_per_turn=200)
    actual = values(record, None, ideal)
    of_period = {"period", "period_error", "settling_ratio"}
    assert set(actual) == set(values(feeder[0], None, feeder[1])) - of_period
    assert actual["dissipated_per_turn"] > 0.0
    balanced(record, actual, 1e-4)
    assert 0.0 < actual["slider_position_deviation_max"] < 1e-3


def test_impacts_are_those_counted_in_the_events(dry):
    """Counts, speeds, forces and shares by another way over the events."""
    record, _ = dry
    actual, events = values(record), record.events
    begin, end = record.turn, 3.0 * record.turn
    columns = ("time", "duration", "impact_speed", "peak_force", "peak_penetration")
    for name in "BC":
        rows = sorted(
            zip(*(events[n][events["joint"] == name].tolist() for n in columns), strict=True)
        )
        assert all(one[0] + one[1] <= other[0] for one, other in pairwise(rows))
        begun = [r for r in rows if begin <= r[0] < end]
        assert len(begun) > 3
        assert actual[f"joint_{name}_impacts_per_turn"] == len(begun) / 2.0
        assert actual[f"joint_{name}_impact_speed_max"] == max(r[2] for r in begun)
        assert actual[f"joint_{name}_force_max"] >= max(r[3] for r in begun)
        assert actual[f"joint_{name}_gap_min"] <= -max(r[4] for r in begun)
        touching = sum(max(min(r[0] + r[1], end) - max(r[0], begin), 0.0) for r in rows)
        share = actual[f"joint_{name}_contact_fraction"]
        assert share == pytest.approx(touching / (end - begin), rel=1e-12)
        # of 400 samples one is wrong for about each second start or end of a contact
        late = (record.time >= begin) & (record.time < end)
        assert share == pytest.approx((record.joint(name).gap[late] < 0.0).mean(), abs=0.03)
    balanced(record, actual, 1e-3)


def test_mixed_joint_in_contact(mixed):
    """The share of time with contact force, and the first law."""
    record, _ = mixed
    actual = values(record)
    force, time = record.joint("C").contact_force, record.time
    late = time >= record.turn * (1.0 - 1e-9)
    share = np.trapezoid(force[late] > 0.0, time[late]) / np.ptp(time[late])
    assert 0.0 <= actual["joint_C_contact_fraction"] <= 1.0
    assert actual["joint_C_contact_fraction"] == pytest.approx(share, abs=1e-12)
    assert "joint_C_impacts_per_turn" not in actual
    balanced(record, actual, 1e-3)


def test_a_journal_at_rest_in_its_bearing_is_in_contact_all_the_time():
    """Set down where the contact carries the weight: in contact from the start to the end, which
    cuts it off.
    """
    stiffness, clearance = 1e9, 1e-3
    load = body("load", {"pin": (0.0, 0.0)}, mass=2.0)
    depth = (2.0 * 9.81 / stiffness) ** (2.0 / 3.0)  # F = K d^1.5
    start = {"clearance": clearance, "eccentricity": (0.0, -clearance - depth)}
    law = {"stiffness": stiffness, "restitution": 0.5}
    resting = dry_joint(cl.ground, load["pin"], "J", **start, **law)
    record, ideal = recorded(cl.Scene(resting), until=0.1)
    assert ideal is None
    for settle in (None, 0.03):
        actual = values(record, settle)
        assert actual["joint_J_contact_fraction"] == pytest.approx(1.0, abs=1e-12)
        # an error of rtol times the clearance, 1e-9 m of a depth of 7e-6 m
        assert actual["joint_J_force_rms"] == pytest.approx(2.0 * 9.81, rel=2e-4)
        assert actual["joint_J_eccentricity_ratio_max"] == pytest.approx(
            1.0 + depth / clearance, rel=1e-5
        )
    assert values(record)["joint_J_impacts_per_second"] <= 1.0 / 0.1
    assert values(record, 0.03)["joint_J_impacts_per_second"] == 0.0


def test_dampers_of_a_double_pendulum_take_out_what_it_loses():
    """Mean power is the loss of energy over the time."""
    record, ideal = recorded(cl.load_case("double_pendulum", damping=0.02), until=2.0)
    assert ideal is None
    actual = values(record, 0.5)
    total = record.values("energy/kinetic") + record.values("energy/potential")
    before = np.interp(0.5, record.time, total)
    # rtol 1e-6
    assert actual["dissipated_power"] == pytest.approx((before - total[-1]) / 1.5, rel=1e-5)
    assert not [n for n in actual if "turn" in n or "period" in n or "deviation" in n]


# --- the mechanism with ideal joints
def closed_form(angle, speed):
    """Slider of a slider-crank at the crank angle: position [m] and acceleration [m/s2] along the
    guide.
    """
    s, c = np.sin(angle), np.cos(angle)
    root = np.sqrt(ROD**2 - (CRANK * s) ** 2)
    position = CRANK * c + root
    bend = CRANK**2 * (c * c - s * s) / root + CRANK**4 * (s * c) ** 2 / root**3
    return position, -(speed**2) * (CRANK * c + bend)


@pytest.mark.parametrize("speed", [523.6, -31.0, 1.0])
def test_ideal_slider_crank_against_its_closed_form(speed, validated):
    """Place and acceleration of the slider, 1e-12 of the largest."""
    scene = cl.load_case("slider_crank", speed=speed, clearance=1e-3)
    computed = ideal_of(scene, 2.7, 401)["slider"]
    expected = closed_form(speed * np.linspace(0.0, 2.7 * scene.turn, 401), speed)
    of = {"source": "closed form of the slider-crank", "kind": "exact"}
    for name, actual, wanted in zip(("place", "acceleration"), computed, expected, strict=True):
        size = np.abs(wanted).max()
        validated(f"{name} of the ideal slider", actual, wanted, 1e-12, relative=size, **of)


def lubricated(clearance):
    """A slider-crank whose Sommerfeld number does not depend on the clearance: viscosity as c^2."""
    film = {"model": "lubricated", "film": "pinkus_sternlicht"}
    viscosity = 0.4 * (clearance / 4e-4) ** 2
    return cl.load_case(
        "slider_crank", speed=50.0, clearance=clearance, viscosity=viscosity, **film
    )


@pytest.fixture(scope="module")
def cranks():
    """Lubricated slider-cranks of smaller and smaller clearance, with the same Sommerfeld number:
    viscosity as c^2.
    """
    sizes = (4e-4, 2e-4, 1e-4)
    return sizes, [recorded(lubricated(c), turns=2.0, samples_per_turn=200) for c in sizes]


def test_deviation_is_of_first_order_in_the_clearance(cranks):
    """The orbit over the clearance is the same to first order: halving c halves the deviation, ever
    more closely.
    """
    sizes, runs = cranks
    actual = [values(record, None, ideal) for record, ideal in runs]
    for name in ("slider_position_deviation_max", "slider_acceleration_deviation_rms"):
        far = [f[name] for f in actual]
        orders = np.log(np.divide(far[:-1], far[1:])) / math.log(2.0)
        np.testing.assert_allclose(orders, 1.0, atol=0.1)
        assert abs(orders[1] - 1.0) < 0.6 * abs(orders[0] - 1.0)
    for c, f in zip(sizes, actual, strict=True):
        assert 0.1 * c < f["slider_position_deviation_max"] < 1.5 * c


def test_deviation_is_that_from_the_closed_form(cranks):
    """Largest deviation and root mean square by another way, 1e-9."""
    for record, ideal in cranks[1]:
        actual = values(record, None, ideal)
        late = record.time >= record.turn * (1.0 - 1e-9)
        position, acceleration = closed_form(50.0 * record.time[late], 50.0)
        far = np.abs(record["slider"].x[late] - position).max()
        assert actual["slider_position_deviation_max"] == pytest.approx(far, rel=1e-9)
        beyond = np.trapezoid((record["slider"].ax[late] - acceleration) ** 2, record.time[late])
        rms = math.sqrt(beyond / np.ptp(record.time[late]))
        assert actual["slider_acceleration_deviation_rms"] == pytest.approx(rms, rel=1e-9)


def test_a_part_of_a_run_is_compared_with_the_same_part():
    """A run given up half way has fewer samples than the ideal motion."""
    scene, options = lubricated(4e-4), {"turns": 4.0, "samples_per_turn": 100}
    entire, ideal = recorded(scene, **options)
    steps = int(0.8 * entire.solver["steps"])
    part, same = recorded(scene, max_steps=steps, **options)
    assert not part.complete
    assert 2.0 * part.turn < part.time[-1] < 4.0 * part.turn
    count = math.floor(part.time[-1] / part.turn * (1.0 + 1e-9)) - 1
    begin, end = part.turn * (1.0 - 1e-9), (1 + count) * part.turn * (1.0 + 1e-9)
    late = (part.time >= begin) & (part.time <= end)
    far = np.abs(part["slider"].x[late] - closed_form(50.0 * part.time[late], 50.0)[0]).max()
    assert values(part, None, same)["slider_position_deviation_max"] == pytest.approx(far, rel=1e-9)


def turned(angle, by_ground=True, axis=(1.0, 0.0), speed=20.0, throw=CRANK, length=ROD):
    """A slider-crank of ideal joints at an angle; the axis of its guide may point backwards or
    stand in the slider.
    """
    crank = body("crank", {"O": (0, 0), "P": (throw, 0)}, angle=angle)
    rod = body("rod", {"P": (0, 0), "Q": (length, 0)}, angle=angle)
    slider = body("slider", {"Q": (0, 0)}, angle=angle)
    c, s = math.cos(angle), math.sin(angle)
    x, y = np.round((c * axis[0] - s * axis[1], s * axis[0] + c * axis[1]), 15)
    if by_ground:
        guide = cl.Prismatic(cl.ground, slider["Q"], axis=(x, y), angle=angle, name="guide")
    else:
        guide = cl.Prismatic(slider["Q"], cl.ground, axis=axis, angle=-angle, name="guide")
    return cl.Scene(
        cl.Revolute(cl.ground, crank["O"], name="O"),
        cl.Revolute(crank["P"], rod["P"], name="P"),
        cl.Revolute(rod["Q"], slider["Q"], name="Q"),
        guide,
        cl.Drive(crank, speed=speed, start=angle),
        name="turned",
    )


@pytest.mark.parametrize(
    ("angle", "by_ground", "axis"),
    [
        (0.0, True, (1.0, 0.0)),
        (0.0, True, (-1.0, 0.0)),
        (0.5 * math.pi, True, (1.0, 0.0)),
        (0.7, True, (1.0, 0.0)),
        (-2.1, False, (-1.0, 0.0)),
    ],
)
def test_guides_at_any_angle(angle, by_ground, axis):
    """Positions and accelerations count along the axis, whichever body it stands in and wherever it
    points.
    """
    scene = turned(angle, by_ground, axis)
    direction = np.array([math.cos(angle), math.sin(angle)]) * axis[0]
    np.testing.assert_allclose(guides(json.loads(scene.to_json()))["slider"], direction, atol=1e-15)
    record, ideal = recorded(scene, turns=2.0, samples_per_turn=100)
    actual = values(record, None, ideal)
    # 1e-9 from its extremes
    acceleration = axis[0] * closed_form(np.linspace(0.0, 2.0 * math.pi, 100_001), 20.0)[1]
    assert actual["slider_acceleration_max"] == pytest.approx(acceleration.max(), rel=2e-9)
    assert actual["slider_acceleration_min"] == pytest.approx(acceleration.min(), rel=2e-9)
    np.testing.assert_allclose(
        ideal["slider"][0], axis[0] * closed_form(20.0 * record.time, 20.0)[0], atol=1e-13
    )
    assert actual["slider_position_deviation_max"] < 1e-13
    assert actual["slider_acceleration_deviation_rms"] < 1e-9
    assert "period" not in actual


def test_only_what_slides_on_the_ground_has_a_guide():
    """A scotch yoke: its block slides in the yoke, which moves."""
    record, ideal = recorded(scotch_yoke(), turns=1.0, samples_per_turn=50)
    assert set(guides(record.scene)) == set(ideal) == {"yoke"}
    actual = values(record, None, ideal)
    assert not [n for n in actual if n.startswith("block")]
    assert actual["yoke_position_deviation_max"] < 1e-12


def pushed(speed=0.2):
    """A block that a slide of constant speed pushes up a slope, with another on top that a motion
    shakes.
    """
    block = body("block", {"P": (0, 0)}, mass=2.0)
    rider = body("rider", {"P": (0, 0)}, mass=1.0)
    slope = cl.Prismatic(cl.ground, block["P"], axis=(3.0, 4.0), name="slope")
    top = cl.Prismatic(block["P"], rider["P"], axis=(0.0, 1.0), name="top")
    return cl.Scene(
        slope,
        top,
        cl.Drive(slope, speed=speed, name="push"),
        cl.Drive(top, speed=0.1, name="lift"),
        name="pushed",
    )


def test_prismatic_drives_have_forces_and_no_turns():
    """Weight on a slope and on a lift, to rounding."""
    record, ideal = recorded(pushed(), until=0.5)
    actual = values(record, None, ideal)
    # 3 kg up a slope of 3 : 4 at constant speed: m g 4 / 5
    for name in ("min", "max", "rms"):
        assert actual[f"drive_push_force_{name}"] == pytest.approx(3.0 * 9.81 * 0.8, rel=1e-12)
    assert actual["drive_lift_force_max"] == pytest.approx(9.81, rel=1e-12)
    assert actual["block_position_deviation_max"] < 1e-14
    assert not [n for n in actual if "turn" in n or "period" in n or n.startswith("rider")]


def test_ideal_motion_does_not_depend_on_which_run_came_first(monkeypatch):
    """Bit for bit, at speeds whose angles over the same turns differ by rounding only."""
    speeds = [31.4159, 523.6, -523.6, 1.0 / 3.0, 20.0, 7.7]
    scenes = {
        s: cl.load_case("slider_crank", speed=s, clearance=1e-5 + 1e-6 * abs(s)) for s in speeds
    }

    def alone(speed):
        monkeypatch.setattr(ideals, "_motions", {})
        return computed(speed)

    def computed(speed):
        return ideal_of(scenes[speed], 6.0, 2401)["slider"]

    expected = {s: alone(s) for s in speeds}
    for order in (speeds, speeds[::-1], sorted(speeds)):
        monkeypatch.setattr(ideals, "_motions", {})
        for s in (*order, *order):
            np.testing.assert_array_equal(computed(s), expected[s])
        assert len(ideals._motions) == 2  # one motion each way


def test_ideal_motion_does_not_depend_on_masses_loads_and_clearances(monkeypatch):
    """Nothing but the kinematics counts; scenes that differ there do not share a motion."""

    def position(scene, **more):
        return ideal_of(scene, **more)["slider"][0]

    monkeypatch.setattr(ideals, "_motions", {})
    plain = turned(0.7)
    first = position(plain)
    spring = cl.SpringDamper(cl.ground.at(3.0, 9.0), plain.joints[2].b, stiffness=5.0)
    loaded = cl.Scene(*plain.joints, *plain.loads, spring, gravity=(1.0, 2.0))
    np.testing.assert_array_equal(position(loaded), first)
    assert len(ideals._motions) == 1
    assert not np.array_equal(position(turned(0.8)), first)
    assert not np.array_equal(position(turned(0.7, axis=(-1.0, 0.0))), first)
    assert position(plain, samples=51).shape == (51,)
    assert not np.array_equal(position(plain, turns=2.0), first)
    assert len(ideals._motions) == 5


def test_no_more_ideal_motions_are_kept_than_allowed(monkeypatch):
    """Older ones are made again, bit for bit."""
    monkeypatch.setattr(ideals, "_motions", {})
    monkeypatch.setattr(ideals, "MOST_KEPT", 3)
    scene, counts = turned(0.7), range(11, 19)
    firsts = [ideal_of(scene, 1.0, n)["slider"][0] for n in counts]
    assert len(ideals._motions) <= 3
    for n, first in zip(counts, firsts, strict=True):
        np.testing.assert_array_equal(ideal_of(scene, 1.0, n)["slider"][0], first)


def torque_driven():
    """Driven by a torque, a freedom is left."""
    plain = turned(0.7)
    return cl.Scene(*plain.joints, cl.Drive(plain.loads[0].target, torque=1.0))


@pytest.mark.parametrize(
    "scene",
    [
        cl.load_case("double_pendulum"),
        cl.load_case("four_bar"),
        torque_driven(),
        turned(0.0, speed=5.0, throw=0.12, length=0.05),  # cannot go round
    ],
    ids=["pendulum", "four bar", "torque", "short"],
)
def test_no_ideal_motion_where_nothing_slides_or_there_is_not_one(scene):
    """A rod shorter than the crank cannot go round; a torque leaves a freedom."""
    assert ideal_of(scene, 1.0, 51) is None


# --- a user's own
def clock(run):
    return 3


def test_own_metrics_are_numbers_by_name():
    """A number, or value with units and text; infinite ones too."""
    numbers = {"mean": np.float32(2.0), "rate": (3, "1/s", "a rate"), "none": math.inf}
    actual = of_user(lambda run: numbers, clocked(1.0))
    shown = {n: (m.value, m.units, m.text) for n, m in actual.items()}
    assert shown["mean"] == (2.0, "?", "mean")
    assert shown["rate"] == (3.0, "1/s", "a rate")
    assert shown["none"][0] == math.inf
    assert of_user(clock, clocked(1.0))["clock"].value == 3.0


@pytest.mark.parametrize(
    ("answer", "reason"),
    [
        ("3.0", "expected a number or a dictionary of numbers, got '3.0'"),
        ({"bad": "text"}, "bad is no number: 'text'"),
        ({"bad": None}, "bad is no number: None"),
        ({"bad": [1.0, 2.0]}, r"bad is no number: \[1.0, 2.0\]"),
        ({"bad": (1j, "m", "complex")}, "bad is no number: 1j"),
        ({"a/b": 1.0}, "its name must be"),
        ({3: 1.0}, "its name must be"),
    ],
)
def test_own_metrics_that_are_none(answer, reason):
    """Texts, arrays, complex numbers and bad names are refused."""

    def mine(run):
        return answer

    with pytest.raises(ValueError, match=f"metric mine: {reason}"):
        of_user(mine, clocked(1.0))


@pytest.mark.parametrize(("count", "error"), [(3, 0.1), (20, 1e-3), (400, 2e-6)])
def test_integrals_of_uneven_places(count, error):
    """Of a wave from 0.1 to 0.9: errors of the second order."""
    places = np.linspace(0.05, 0.95, count) ** 1.1
    begin, end = places[0] + 0.1 * (places[1] - places[0]), places[-1]
    weights = integrating(places, begin, end)
    exact = (np.cos(6.0 * begin) - np.cos(6.0 * end)) / 6.0
    assert weights.sum() == pytest.approx(end - begin, rel=1e-13)
    assert weights @ np.sin(6.0 * places) == pytest.approx(exact, abs=error)


def test_integrals_of_straight_lines():
    """Exact to rounding, also from and to places between samples; so where two samples meet."""
    even = np.linspace(0.0, 1.0, 30)
    for places in (even, np.sort([*even, even[7] + 1e-7])):
        weights = integrating(places, -0.01, 0.99)
        for power in range(2):
            exact = (0.99 ** (power + 1) - (-0.01) ** (power + 1)) / (power + 1)
            assert weights @ places**power == pytest.approx(exact, abs=1e-12)


def test_ideal_motion_beside_a_thermal_node():
    """A node that joints share does not change how ideal joints would move the slider."""
    plain = cl.load_case("slider_crank", model="lubricated")
    node = cl.ThermalNode("housing", capacity=10.0, conductance=0.5)
    oil = cl.HeatBalance(capacity=1.0, conductance=0.8, to=node)
    joints = [dataclasses.replace(j, heat=oil) if j.name == "C" else j for j in plain.joints]
    heated = cl.Scene(*joints, *plain.loads, node, name="heated")
    (_, expected), (_, actual) = (recorded(s, turns=1) for s in (plain, heated))
    np.testing.assert_array_equal(actual["slider"], expected["slider"])


@pytest.mark.parametrize("seed", range(3))
def test_a_dry_joint_leaves_the_films_of_others_their_metrics(seed):
    """The thinnest film of an oiled joint is a metric of a point beside a dry joint, as it is of
    the run. Penetrations of the dry one are means over turns.
    """
    rng = np.random.default_rng(seed)
    clearance, speed = rng.uniform(3e-5, 1e-4), rng.uniform(6.0, 20.0)
    crank = cl.Body("crank", 0.3, 1e-4, points={"A": (-0.025, 0), "B": (0.025, 0)})
    rod = cl.Body("rod", 0.21, 2.5e-4, points={"B": (-0.06, 0), "C": (0.06, 0)})
    slider = cl.Body("slider", 0.5, 1e-5, points={"C": (0, 0)})
    size = {"radius": 0.01, "length": 0.02}
    oil = {"lubricant": cl.Lubricant(0.05), "film": cl.short_film(), "roughness": 8e-7}
    hard = cl.lankarani_nikravesh(restitution=0.8)
    scene = cl.Scene(
        cl.Revolute(cl.ground.at(0, 0), crank["A"], name="A"),
        cl.ClearanceRevolute(crank["B"], rod["B"], name="B", clearance=clearance, **size, **oil),
        cl.ClearanceRevolute(rod["C"], slider["C"], name="C", clearance=1e-4, contact=hard, **size),
        cl.Prismatic(cl.ground.at(0, 0), slider["C"], axis=(1, 0), name="guide"),
        cl.Drive(crank, speed=speed),
    )
    run = cl.simulate(scene, turns=2, error=None)
    point, complete = of_point(run), metrics(run)
    for name in ("gap_min", "eccentricity_ratio_max", "film_thickness_ratio_min"):
        assert point[f"joint_B_{name}"] == complete[f"joint_B_{name}"]
    assert "joint_C_penetration_peak_mean" in point
    assert "joint_C_gap_min" not in point
