"""Extremes are those of the motion that was integrated, not of the rows that were requested."""

import math
from pathlib import Path

import h5py
import numpy as np
import pytest

import clearance as cl
from clearance.metrics.metrics import metrics
from clearance.results.extremes import Extremes, better, stretch_length, stretches
from clearance.scene.catalogue import case_names, find_case
from tests import mechanisms as m
from tests.seeds import few_of


def test_stretches_hold_their_extremes():
    """Complete stretches between two times, to rounding of their ends; outer ones are left out,
    empty ones are None.
    """
    values = np.array([[3.0, -1.0], [7.0, -5.0], [5.0, -2.0]])
    stored = Extremes(2.0, ("a_max", "b_min"), ("N", "m"), values, np.full((3, 2), np.nan))
    assert (
        stored.of("a_max", 2.0 * (1.0 + 1e-12)).value
        == better("a_max", [None, stored.of("a_max")]).value
    )
    assert (stored.of("a_max").value, better("a_max", [])) == (7.0, None)
    assert stored.of("a_max", 2.1).value == 5.0
    assert stored.of("b_min", 0.0, 3.9).value == -1.0
    assert stored.of("b_min", 0.1, 3.9) is None
    cut = Extremes(
        2.0, stored.names, stored.units, values, np.array([[1.0, 1.0], [3.5, 3.5], [4.5, 4.5]])
    )
    assert cut.of("a_max", 3.0, 4.0).value == 7.0  # it lies in the part that is left of its stretch
    assert cut.of("a_max", 3.6, 4.0) is None


@pytest.mark.parametrize(
    ("begin", "end", "parts"),
    [
        (0.0, math.inf, []),
        (2.0, 4.0 * (1.0 + 1e-12), []),
        (1.0, 5.0, [(1.0, 2.0), (4.0, 5.0)]),
        (3.0, math.inf, [(3.0, 4.0)]),
        (2.5, 3.5, [(2.5, 3.5)]),
        (9.0, math.inf, [(9.0, math.inf)]),
    ],
)
def test_samples_count_in_cut_stretches_alone(begin, end, parts):
    """Complete stretches of 2 s are left out, exactly; one that was not reached never is."""
    values = np.array([[3.0], [7.0], [5.0]])
    stored = Extremes(2.0, ("a_max",), ("N",), values, np.array([[1.0], [3.0], [4.5]]))
    assert stored.cut(begin, end) == parts
    values[-1] = -np.inf
    assert stored.cut(0.0, math.inf) == [(0.0, math.inf)]


@pytest.mark.parametrize(
    ("until", "turn", "count"),
    [(1.0, None, 100), (6.0, 1.0, 6), (6.5, 1.0, 7), (2.5e5, 1.0, 83_334)],
)
def test_stretches_are_turns_or_hundredths(until, turn, count):
    """A hundred, or a turn each, several in runs of more than 100,000."""
    length = stretch_length(until, turn)
    assert stretches(until, length) == count
    assert turn is None or length % turn == 0.0


#: the two lubricated cases and a mixed one
FILMS = {
    "feeder": ("six_bar_feeder", {}),
    "slider-crank": ("slider_crank", {"model": "lubricated", "viscosity": 0.04}),
    "mixed feeder": ("six_bar_feeder", {"model": "mixed", "transition": "load_sharing"}),
}


@pytest.mark.parametrize("name", few_of([*FILMS], 1))
def test_R6_peaks_converge_with_the_tolerance(name):
    """At rtol 1e-6 within 1e-5 of rtol 1e-11, 1e-6 in the median; step ends alone are off by 1e-4
    to 1e-3 at both.
    """
    case, values = FILMS[name]
    scene = cl.load_case(case, **values)
    actual, exact = (
        cl.simulate(scene, turns=2, rtol=r, samples_per_turn=20, error=None).located
        for r in (1e-6, 1e-11)
    )
    errors = []
    for quantity in exact.names:
        value = exact.of(quantity, scene.turn).value
        if abs(value) > 1e-9:
            errors.append(abs(actual.of(quantity, scene.turn).value / value - 1.0))
    assert len(errors) >= 10
    assert max(errors) < 1e-5
    assert np.median(errors) < 1e-6


@pytest.mark.parametrize("name", few_of([*FILMS], 1))
def test_R6_no_sample_lies_beyond_a_located_extreme(name):
    """20000 samples a turn lie on the same dense output: none beyond by more than 1e-8 of the
    value.
    """
    case, values = FILMS[name]
    run = cl.simulate(cl.load_case(case, **values), turns=1, samples_per_turn=20000, error=None)
    for quantity in run.located.names:
        path, _, which = quantity.rpartition("_")
        seen, located = run._of_samples(path, which, 0.0, math.inf), run.located.of(quantity)
        assert abs(better(quantity, [seen, located]).value - located.value) <= 1e-8 * abs(
            located.value
        ), quantity


#: a slider-crank whose film of 1 nm is so stiff that forces between its steps are noise
THIN_FILM = """
[body]
crank = { mass = 0.3, inertia = 6.25e-5, points = { A = [-0.025, 0], B = [0.025, 0] } }
rod = { mass = 0.21, inertia = 2.5e-4, points = { B = [-0.06, 0], C = [0.06, 0] } }
slider = { mass = 0.14, inertia = 1e-5, points = { C = [0, 0] } }
[joint.A]
kind = "Revolute"
a = "ground"
b = "crank.A"
[joint.B]
kind = "Revolute"
a = "crank.B"
b = "rod.B"
[joint.C]
kind = "ClearanceRevolute"
a = "rod.C"
b = "slider.C"
radius = "10 mm"
clearance = "1 nm"
length = "20 mm"
film = "table_film"
lubricant = "oil"
[joint.guide]
kind = "Prismatic"
a = "ground"
b = "slider.C"
axis = [1, 0]
[lubricant]
oil = { viscosity = "40 cP" }
[drive]
crank = { target = "crank", speed = "1000 rpm", start = "0 deg" }
"""


def make_noisy(file: Path, begin: float) -> None:
    """Samples after the first turn, each tenth, 3 % further from zero: noise between steps."""
    with h5py.File(file, "r+") as opened:
        late = np.flatnonzero(opened["time"][()] > begin)[::10]
        for name in ("joints/C/force_x", "joints/C/force_y", "bodies/slider/ax"):
            opened[name][late] *= 1.03
            del opened[name].attrs["crc32"]


def test_noise_between_the_steps_of_a_stiff_film_is_no_peak(tmp_path):
    """Peaks within their stated errors of those at rtol 1e-11; samples lie more than 1 % beyond.

    The file gets noise, which the run has not. Metrics have the values and errors of the extremes,
    exactly. The stated error of a cut turn, which has samples only, covers it too.
    """
    file = tmp_path / "thin.toml"
    file.write_text(THIN_FILM)
    scene = cl.load_case(file)
    cl.simulate(scene, turns=2, path=tmp_path / "run.h5").close()
    quiet = cl.simulate(scene, turns=2)
    make_noisy(tmp_path / "run.h5", scene.turn)
    run = cl.open_result(tmp_path / "run.h5")
    exact = cl.simulate(scene, turns=2, rtol=1e-11, error=None)
    begin = scene.turn
    metric_of = {
        "joints/C/force_max": "joint_C_force_max",
        "bodies/slider/ax_max": "slider_acceleration_max",
    }
    for name, metric in metric_of.items():
        path, _, which = name.rpartition("_")
        extreme, error = run.extreme(name, begin), run.errors[name]
        assert run._of_samples(path, which, begin, math.inf).value > 1.01 * extreme.value
        assert extreme.value == error.value == run.errors[metric].value
        assert error.stated == run.errors[metric].stated < 1e-2 * error.value
        assert abs(error.value - exact.located.of(name, begin).value) <= error.stated
        cut = begin, 1.75 * begin
        assert run.error(name, *cut).value > 1.01 * error.value
        error = quiet.error(name, *cut)
        assert abs(error.value - exact.extreme(name, *cut).value) <= error.stated


def thin_film(seed):
    """A slider-crank whose film has 0.5 to 100 nm; speed and viscosity are drawn, too."""
    rng = np.random.default_rng(seed)
    values = {
        "1 nm": f"{10.0 ** rng.uniform(-0.3, 2.0)} nm",
        "1000 rpm": f"{10.0 ** rng.uniform(2.4, 3.5)} rpm",
        "40 cP": f"{10.0 ** rng.uniform(0.7, 2.3)} cP",
    }
    text = THIN_FILM
    for old, new in values.items():
        text = text.replace(f'"{old}"', f'"{new}"')
    return text


@pytest.mark.filterwarnings("ignore::clearance.RunWarning")
def test_forces_between_the_steps_of_thin_films(tmp_path):
    """Of 12 random films: peaks within 1e-4 of those at rtol 1e-10, the median within 1e-7.
    Samples within 1e-2 of the peak, the median within 1e-3.

    Measured over 80 films: 5e-5, 3e-10, 1e-3 and 2e-5. Without settled rates: 3e-2, 1e-6, 0.1
    and 5e-3. Forces hardly depend on such a film.
    """
    peaks, samples = [], []
    for seed in range(12):
        file = tmp_path / f"{seed}.toml"
        file.write_text(thin_film(seed))
        scene = cl.load_case(file)
        run, exact = (
            cl.simulate(scene, turns=2, samples_per_turn=200, rtol=rtol, error=None)
            for rtol in (1e-6, 1e-10)
        )
        for name in ("joints/C/force_max", "bodies/slider/ax_max"):
            true = exact.located.of(name, scene.turn).value
            peaks.append(abs(run.located.of(name, scene.turn).value / true - 1.0))
        off = run.joint("C").force_x - exact.joint("C").force_x
        late = run.time > scene.turn
        samples.append(np.abs(off[late]).max() / exact.extreme("joints/C/force_max").value)
    assert max(peaks) < 1e-4
    assert np.median(peaks) < 1e-7
    assert max(samples) < 1e-2
    assert np.median(samples) < 1e-3


def test_times_of_extremes():
    """At the time of an extreme, a run sampled there has its value: 1e-9 of it (the same steps,
    other samples).
    """
    scene = cl.load_case("six_bar_feeder")
    run = cl.simulate(scene, turns=2, error=None)
    for quantity in (
        "joints/B/force_max",
        "joints/B/gap_min",
        "drives/crank/torque_min",
        "bodies/slider/ax_max",
    ):
        extreme, path = run.extreme(quantity, scene.turn), quantity[:-4]
        assert scene.turn <= extreme.time <= 2.0 * scene.turn
        again = cl.simulate(scene, until=extreme.time, samples=2, error=None)
        assert again.sizes(path)[-1] == pytest.approx(extreme.value, rel=1e-5)


def test_extremes_of_channels_that_are_not_followed_are_those_of_samples():
    """Other channels have the extremes of their samples; wrong names and windows are refused."""
    run = cl.simulate(cl.load_case("six_bar_feeder"), turns=1, samples_per_turn=50)
    assert run.extremes("bodies/rod2/vx") == run.range("bodies/rod2/vx")
    with pytest.raises(KeyError, match="_min or _max"):
        run.extreme("joints/B/force")
    with pytest.raises(KeyError, match="joints/B/nothing"):
        run.extreme("joints/B/nothing_max")
    with pytest.raises(KeyError, match="_min or _max"):
        run.extreme("events/time_max")
    with pytest.raises(ValueError, match="the run has nothing between 10 and 11 s"):
        run.extreme("joints/B/force_max", 10.0, 11.0)
    with pytest.raises(ValueError, match="begin must not lie after end"):
        run.extreme("joints/B/force_max", 1.0, 0.0)
    gap, roughness = run.extreme("/joints/B/gap_min"), 0.8e-6
    ratio = run.extreme("joints/B/film_thickness_ratio_min")
    assert (ratio.value, ratio.time) == (pytest.approx(gap.value / roughness, rel=1e-12), gap.time)


@pytest.mark.parametrize("name", few_of(case_names(), 3))
def test_M3_angles_do_not_depend_on_the_samples(name):
    """One sample a turn gives the angles of 200 a turn, where steps are the same; full turns would
    be 6.3 rad.
    """
    scene = find_case(name).scene()
    length = {"error": None} | ({"turns": 2} if scene.turn else {"until": 1.0})
    few, many = ({"samples_per_turn": n} if scene.turn else {"samples": n + 1} for n in (1, 200))
    coarse, fine = cl.simulate(scene, **length, **few), cl.simulate(scene, **length, **many)
    every = (fine.time.size - 1) // (coarse.time.size - 1)
    for body in coarse.names("bodies"):
        np.testing.assert_allclose(coarse[body].theta, fine[body].theta[::every], atol=1e-2)


def test_M3_a_long_crank_does_not_turn_its_rod():
    """crank / rod = 0.6 at one sample a turn: the rod's angle is 0 after each."""
    crank, rod = (m.bar(n, x, 0.0, 0.1, 1e-4) for n, x in (("crank", 0.06), ("rod", 0.1)))
    joints = m.crank_and_slider(crank, rod, cl.Body("slider", 0.1, 1e-4))
    scene = cl.Scene(*joints, cl.Drive(crank, speed=10.0, start=0.0), name="long_crank")

    assert np.abs(cl.simulate(scene, turns=6, samples_per_turn=1)["rod"].theta).max() < 1e-12


SCENES = {
    "dry": ({"model": "dry"}, 0.5),
    "mixed": ({"model": "mixed", "transition": "load_sharing"}, 1.0),
    "lubricated": ({"model": "lubricated", "clearance": 2e-4}, 1.0),
}


@pytest.mark.parametrize("model", few_of([*SCENES], 2))
def test_peaks_hardly_depend_on_the_samples(model):
    """Twenty samples a turn give what 10000 give, within 1e-5: ten tolerances, for full buffers
    change some steps.
    """
    parameters, turns = SCENES[model]
    scene = cl.load_case("slider_crank", **parameters)
    coarse, fine = (
        cl.simulate(scene, turns=turns, samples_per_turn=n, error=None) for n in (20, 10000)
    )
    assert coarse.located.names == fine.located.names
    for quantity in coarse.located.names:
        low, high = sorted((coarse.extreme(quantity).value, fine.extreme(quantity).value))
        assert high - low <= 1e-5 * max(abs(low), abs(high)), quantity


def test_samples_alone_would_miss_them():
    """Otherwise the test before could not fail."""
    coarse = cl.simulate(cl.load_case("slider_crank", model="dry"), turns=0.5, samples_per_turn=20)
    assert coarse.range("bodies/slider/ax")[1] < 0.8 * coarse.extremes("bodies/slider/ax")[1]


def test_the_first_turn_is_left_out_of_metrics():
    """A journal let go from the middle of its oil: its first turn has the largest forces."""
    run = cl.simulate(
        cl.load_case("slider_crank", model="lubricated"), turns=4, samples_per_turn=40, error=None
    )
    assert run.located.length == pytest.approx(run.turn, rel=1e-12)
    settled, everything = ({n: m.value for n, m in metrics(run, s).items()} for s in (None, 0.0))
    column = run.located.columns["drives/crank/torque_max"]
    assert settled["drive_crank_torque_max"] == run.located.values[1:, column].max()
    assert everything["drive_crank_torque_max"] == run.located.values[:, column].max()
    assert settled["joint_C_force_max"] < 0.9 * everything["joint_C_force_max"]


def test_the_ledger_is_judged_where_the_states_are_known():
    """Between the long steps of thick oil the dense output is of low order; at their ends the
    ledger closes with rtol.

    Ten times smaller for a hundred times: order 5 with the errors of all states controlled gives
    more.
    """
    scene = cl.load_case(
        "slider_crank", model="lubricated", viscosity=5.0, clearance=1e-5, speed=cl.rpm(10)
    )
    loose, tight = (
        cl.simulate(scene, turns=1, rtol=r, method="radau5", error=None).solver[
            "energy_residual_share"
        ]
        for r in (1e-4, 1e-6)
    )
    assert tight < 0.1 * loose
    assert tight < 1e-5


def _sliding(law):
    """A block of 1 kg on a spring, let go 0.1 m from rest; its guide carries the weight alone."""
    block = cl.Body("block", 1.0, 1e-3)
    guide = cl.Prismatic(cl.ground, block, name="guide", axis=(1, 0), overlap=0.05, friction=law)
    spring = cl.SpringDamper(cl.ground.at(0.3, 0.0), block, stiffness=1e3, free_length=0.2)
    return cl.Scene(guide, spring, gravity=(0.0, -10.0))


@pytest.mark.parametrize("sharp", few_of([1e-4, 1e-2, 1e-6], 1))
@pytest.mark.parametrize("rtol", [1e-4, 1e-7])
def test_friction_is_largest_while_it_turns_round(sharp, rtol):
    """Stribeck's hump, ten layers wide, and a hump at the breakaway rate: the largest of the law
    over all rates, within 1e-4, what parabolas miss of them; also where they are over in a
    millionth of a period.
    """
    stribeck = cl.joint_stribeck(
        static=0.2, kinetic=0.1, stribeck_rate=10.0 * sharp, transition_rate=sharp
    )
    smooth = cl.breakaway_smooth(breakaway=3.0, coulomb=1.0, breakaway_rate=10.0 * sharp)
    rates = sharp * np.geomspace(1e-2, 1e3, 20001)
    for law in (stribeck, smooth):
        largest = max(-law(float(rate), 10.0) for rate in rates)
        run = cl.simulate(_sliding(law), until=0.5, rtol=rtol, error=None)
        for end, sign in (("max", 1.0), ("min", -1.0)):
            extreme = run.extreme(f"joints/guide/friction_{end}").value
            assert sign * extreme == pytest.approx(largest, rel=1e-4)


def test_users14_an_extreme_shows_its_unit():
    """Value, unit and time; those of samples, of vectors and of ratios of a gap too."""
    run = cl.simulate(cl.load_case("six_bar_feeder", model="mixed"), turns=1)
    units = {
        "joints/B/force_max": "N",
        "bodies/slider/ax_max": "m/s2",
        "joints/B/film_thickness_ratio_min": "1",
        "joints/B/side_flow_max": "m3/s",
    }
    assert {name: run.extreme(name).units for name in units} == units
    extreme = run.extreme("joints/B/force_max")
    assert repr(extreme) == f"<extreme {extreme.value:.6g} N at {extreme.time:.6g} s>"
    ratio = run.extreme("joints/B/film_thickness_ratio_min")
    assert repr(ratio) == f"<extreme {ratio.value:.6g} at {ratio.time:.6g} s>"
