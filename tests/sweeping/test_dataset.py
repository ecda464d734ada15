"""Labelled records: the same from the same seed, the noise as stated, a card, a baseline."""

import json
import shlex

import h5py
import numpy as np
import pytest

import clearance as cl
from clearance.cli import main
from clearance.identify.baseline import baseline
from clearance.scene.parameter import varied
from clearance.sweeping.dataset import usual

CASE = {"model": "lubricated", "film": "pinkus_sternlicht"}
CHANNELS = ("bodies/slider/ax", "joints/C/force")
SMALL = {"points": 6, "turns": 1, "settle": 2, "samples_per_turn": 180, "fixed": CASE}


@pytest.fixture(scope="module")
def records(tmp_path_factory):
    """Six records of a lubricated slider-crank."""
    folder = tmp_path_factory.mktemp("set")
    return cl.dataset("slider_crank", folder, CHANNELS, seed=3, workers=1, **SMALL)


def test_the_same_seed_gives_the_same_bytes(records, tmp_path):
    """By two workers and from the command too, on another day; another seed gives others."""
    again = cl.dataset("slider_crank", tmp_path / "a", CHANNELS, seed=3, workers=2, **SMALL)
    assert again.read_bytes() == records.read_bytes()
    options = [f"-p{n}={v}" for n, v in CASE.items()]
    call = ["dataset", "slider_crank", *options, "--channels", ",".join(CHANNELS), "--points", "6"]
    call += ["--turns", "1", "--samples-per-turn", "180", "--quiet", "-o", str(tmp_path / "b")]
    assert main([*call, "--seed", "3"]) == 0
    assert (tmp_path / "b" / "records.h5").read_bytes() == records.read_bytes()
    other = cl.dataset("slider_crank", tmp_path / "c", CHANNELS, seed=4, workers=1, **SMALL)
    assert other.read_bytes() != records.read_bytes()


def test_a_record_is_a_run_with_noise(records):
    """Noise of 1 % of the range about the run of the labels, to five deviations of 180 values."""
    with h5py.File(records) as file:
        labels = {n: v[()] for n, v in file["labels"].items()}
        actual = file["records/bodies_slider_ax"][2].astype(float)
        assert file["records/bodies_slider_ax"].attrs["units"] == "m/s2"
        assert file["labels/clearance"].attrs["units"] == "m"
    numbers = {n: float(labels[n][2]) for n in ("clearance", "viscosity", "speed")}
    scene = cl.load_case("slider_crank", **CASE, **numbers)
    run = cl.simulate(scene, turns=3, samples_per_turn=180, error=None)
    expected = run["slider"].ax[360:540]
    noise = labels["noise_bodies_slider_ax"][2]
    assert noise == pytest.approx(0.01 * np.ptp(expected), rel=1e-6)
    assert (actual - expected).std() == pytest.approx(noise, rel=0.25)


def test_ranges_noise_and_filter(tmp_path):
    """Labels fill the ranges; records without noise and filter are the channel, rounded."""
    options = SMALL | {"noise": 0.0, "ranges": {"clearance": (2e-4, 4e-4)}}
    path = cl.dataset("slider_crank", tmp_path / "a", CHANNELS[:1], workers=1, **options)
    soft = cl.dataset(
        "slider_crank", tmp_path / "b", CHANNELS[:1], workers=1, lowpass=(2, 200.0), **options
    )
    with h5py.File(path) as file, h5py.File(soft) as filtered:
        clearance, sharp = file["labels/clearance"][()], file["records/bodies_slider_ax"][()]
        blunt = filtered["records/bodies_slider_ax"][()]
    assert sorted(np.floor((clearance - 2e-4) / (2e-4 / 6))) == [*range(6)]  # a Latin hypercube
    scene = cl.load_case("slider_crank", **CASE, clearance=float(clearance[0]))
    run = cl.simulate(scene, turns=3, samples_per_turn=180, error=None)
    assert sharp[0] == pytest.approx(run["slider"].ax[360:540], rel=1e-6)
    assert np.abs(np.diff(blunt)).max() < 0.9 * np.abs(np.diff(sharp)).max()


def test_a_mounted_sensor(tmp_path):
    """A record is that of the sensor's direction, by the label of its angle; a force has none."""
    options = SMALL | {"points": 2, "noise": 0.0, "workers": 1}
    names = ("bodies/rod/ax", "bodies/rod/ay")
    straight = cl.dataset("slider_crank", tmp_path / "a", names, **options)
    turned = cl.dataset("slider_crank", tmp_path / "b", names, mounting="5deg", **options)
    with h5py.File(straight) as a, h5py.File(turned) as b:
        x, y = (a[f"records/bodies_rod_a{axis}"][()] for axis in "xy")
        for axis, along, across in (("x", x, y), ("y", y, -x)):
            angle = b[f"labels/mounting_bodies_rod_a{axis}"][()][:, None]
            actual = b[f"records/bodies_rod_a{axis}"][()]
            assert 0.0 < np.abs(angle).max() < 0.5
            expected = np.cos(angle) * along + np.sin(angle) * across
            assert actual == pytest.approx(expected, rel=1e-5, abs=1e-5 * float(np.abs(x).max()))
    with pytest.raises(ValueError, match="no direction"):
        cl.dataset("slider_crank", tmp_path / "c", "joints/C/force", mounting=0.1, **options)


def test_the_card_names_what_it_is(records):
    """Synthetic, its seed, ranges, sensor and version."""
    text = records.with_name("card.md").read_text()
    assert "null" not in text
    for part in (
        "**Synthetic**",
        "seed 3",
        "noise 1%",
        "Label clearance",
        f"clearance {cl.__version__}",
    ):
        assert part in text


@pytest.mark.parametrize(
    ("case", "fixed"),
    [
        ("six_bar_feeder", {"model": "mixed"}),  # whose viscosity is auto
        ("six_bar_feeder", {"model": "lubricated", "viscosity": 0.03}),
        ("four_bar_clearances", {}),
    ],
)
def test_usual_ranges_are_about_the_numbers_of_the_scene(case, fixed):
    """A factor of two on either side, also of a number that the case chooses by its model."""
    ranges = usual(case, fixed)
    scene = cl.load_case(case, **fixed)
    values = {n: varied(scene, n).value for n in ranges}
    middles = {n: (low * high) ** 0.5 for n, (low, high, _) in ranges.items()}
    assert middles == pytest.approx(values, rel=1e-12)
    assert all(high == pytest.approx(4.0 * low) for low, high, _ in ranges.values())


@pytest.mark.slow
def test_the_baseline_finds_the_labels(records, capsys):
    """Within 30 % of clearance and viscosity, most of six within their intervals."""
    scores = baseline(records, 6, starts=2)
    assert scores.keys() == {"clearance", "viscosity"}
    for row in scores.values():
        assert row["rms_of_logarithm"] < 0.3
        assert row["inside_95"] >= 4 / 6


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"channels": ()}, "at least one channel"),
        ({"channels": ("bodies/slider/xx",)}, "fits none"),
        ({"noise": "-1%"}, "noise"),
        ({"points": 0}, "count must be a whole number of at least 1"),
        ({"ranges": {"clearanc": (1e-4, 2e-4)}}, "did you mean clearance"),
    ],
)
def test_bad_input_is_named(tmp_path, change, message):
    """Before anything runs."""
    options = SMALL | {"channels": CHANNELS} | change
    with pytest.raises((ValueError, TypeError), match=message):
        cl.dataset("slider_crank", tmp_path / "a", workers=1, **options)
    assert not (tmp_path / "a" / "records.h5").exists()


def test_the_command_prints_its_files(tmp_path, capsys):
    """As JSON too; a parameter that is not there is named."""
    call = ["dataset", "slider_crank", "-p", "model=lubricated", "-p", "film=pinkus_sternlicht"]
    call += ["--channels", "bodies/slider/ax", "--points", "2", "-o", str(tmp_path / "a")]
    assert main([*call, "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert h5py.is_hdf5(document["records"])
    assert main([*call, "-p", "clearanc=1:2"]) == 2
    assert "did you mean clearance" in capsys.readouterr().err


def test_the_command_on_the_card_makes_the_same_bytes(tmp_path):
    """Whatever was given in Python; texts in units too."""
    options = {"fixed": {"model": "lubricated", "film": "short"}, "lowpass": (2, 300.0)}
    options |= {"ranges": {"clearance": (2e-4, 4e-4, "log"), "speed": ("90rpm", "200rpm")}}
    options |= {"points": 2, "seed": 5, "turns": 1, "settle": 1, "samples_per_turn": 90}
    options |= {"noise": "2%", "mounting": "3deg", "workers": 1}
    channels = ["bodies/rod/ax", "bodies/rod/ay"]
    path = cl.dataset("slider_crank", tmp_path / "a", channels, **options)
    (line,) = (x for x in path.with_name("card.md").read_text().splitlines() if "again" in x)
    words = shlex.split(line.partition("`")[2].rstrip("`."))
    assert main([*words[1:], "-o", str(tmp_path / "b"), "--quiet"]) == 0
    assert (tmp_path / "b/records.h5").read_bytes() == path.read_bytes()


def test_wear_is_a_label(tmp_path):
    """Depths of a worn arc are drawn, stand on the card, and give the records of their runs."""
    wanted = {"worn_depth": (1e-5, 1e-4), "clearance": (2e-4, 6e-4)}
    fixed = {"model": "lubricated", "film": "short", "worn_angle": 0.0}
    options = {"turns": 1, "settle": 1, "samples_per_turn": 90, "noise": 0.0, "workers": 1}
    path = cl.dataset(
        "slider_crank", tmp_path, CHANNELS[:1], points=3, ranges=wanted, fixed=fixed, **options
    )
    with h5py.File(path) as file:
        labels = {n: float(file[f"labels/{n}"][1]) for n in wanted}
        actual = file["records/bodies_slider_ax"][1]
    assert 1e-5 <= labels["worn_depth"] <= 1e-4
    assert "- Label worn_depth: " in (tmp_path / "card.md").read_text()
    scene = cl.load_case("slider_crank", **fixed, **labels)
    run = cl.simulate(scene, turns=2, samples_per_turn=90, error=None)
    expected = run["slider"].ax[90:180]
    np.testing.assert_allclose(actual, expected, atol=1e-6 * np.ptp(expected))
    plain = cl.load_case("slider_crank", **fixed, clearance=labels["clearance"])
    unworn = cl.simulate(plain, turns=2, samples_per_turn=90, error=None)["slider"].ax[90:180]
    assert np.abs(actual - unworn).max() > 1e-5 * np.ptp(expected)
