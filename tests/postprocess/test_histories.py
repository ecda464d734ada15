"""Channels by name, overlays of results, axes along time and turns."""

import numpy as np
import pytest
from clearance.postprocess import channels, figures
from clearance.postprocess.histories import histories
from clearance.postprocess.labels import headline, labels_of
from matplotlib.figure import Figure

import clearance as cl
from tests.postprocess.records import Formula


@pytest.fixture(scope="module")
def dry():
    return cl.simulate(cl.load_case("slider_crank", model="dry"), turns=2.0, samples_per_turn=100)


@pytest.fixture(scope="module")
def feeder():
    return cl.simulate(
        cl.load_case("six_bar_feeder", joints="B,C"), turns=1.0, samples_per_turn=100
    )


def test_series_by_path_and_by_short_name(dry):
    """Both give the stored values, their units and a label."""
    for path in ("bodies/slider/ax", "slider.ax"):
        values, units, label = channels.series(dry, path)
        assert (values == dry["slider"].ax).all()
        assert (units, label) == ("m/s2", "slider acceleration x")
    assert channels.series(dry, "crank.torque")[1:] == ("N m", "crank torque")
    assert channels.series(dry, "energy.kinetic")[1:] == ("J", "kinetic energy")


def test_magnitudes_and_eccentricity_ratio(dry):
    """Sizes of vectors, and eccentricity over the clearance, to one rounding."""
    values, units, label = channels.series(dry, "C.force")
    assert (values == np.hypot(*dry.joint("C").force.T)).all()
    assert (units, label) == ("N", "joint C force")
    assert (
        channels.series(dry, "slider.v")[0] == np.hypot(dry["slider"].vx, dry["slider"].vy)
    ).all()
    ratio, units, label = channels.series(dry, "C.epsilon_y")
    # one rounding
    np.testing.assert_allclose(ratio, dry.joint("C").eccentricity[:, 1] / 0.5e-3, rtol=1e-15)
    assert (units, label) == ("1", "joint C eccentricity y / c")


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("slider.jerk", r"no channel 'slider.jerk'.*bodies/slider: .*vx"),
        ("nobody.x", r"no channel 'nobody.x'.*joints/C: .*contact_force"),
        ("bodies/slider/jerk", "bodies/slider: "),
        ("time", "no channel 'time'"),
        ("crank.epsilon", "no channel 'crank.epsilon'"),
    ],
)
def test_unknown_channels_name_the_known_ones(dry, name, message):
    """The message lists the channels that are there."""
    with pytest.raises(ValueError, match=message):
        channels.series(dry, name)


def test_channels_that_were_not_kept():
    """They are refused by name; stored ones are there."""
    scene = cl.load_case("slider_crank", model="dry")
    lean = cl.simulate(scene, turns=0.2, channels=["bodies/slider/ax", "joints/C/gap"])
    assert channels.series(lean, "slider.ax")[0].size == lean.time.size
    with pytest.raises(
        ValueError, match="no channel 'C.force', or it was not stored; it has joints/C: gap"
    ):
        channels.series(lean, "C.force")
    with pytest.raises(ValueError, match="name the channels"):
        channels.principal(lean)


def test_patterns(feeder):
    """A pattern gives paths in the order of the file, each once."""
    assert channels.expand(feeder, "*.epsilon") == ["joints/B/epsilon", "joints/C/epsilon"]
    assert channels.expand(feeder, ["?.force", "B.force"]) == [
        f"joints/{j}/force" for j in "ABCDEF"
    ]
    assert "joints/B/force" not in channels.expand(feeder, "B.*")
    assert set(channels.expand(feeder, "joints/B/*")) == {
        f"joints/B/{n}" for n in feeder.names("joints/B")
    }
    with pytest.raises(ValueError, match=r"matches '\*\.jerk'; it has .*energy: "):
        channels.expand(feeder, "*.jerk")


def test_the_same_short_name_in_two_groups():
    """It is refused with both paths."""
    record = Formula([0.0, 1.0], {"bodies/s/x": [0, 1], "springs/s/x": [2, 3]})
    with pytest.raises(ValueError, match="may be bodies/s/x or springs/s/x; give the full path"):
        channels.series(record, "s.x")


@pytest.mark.parametrize(("path", "degree"), [("bodies/slider/x", 3), ("joints/C/force_x", 3)])
def test_interpolation_is_exact_for_cubics(path, degree):
    """Both ways reproduce a cubic to rounding (1e-13 of its size), at the ends too and on uneven
    samples.
    """
    cubic = np.polynomial.Polynomial([0.3, -1.0, 2.0, -0.7])
    time = np.sort(np.concatenate([[0.0, 2.0], np.random.default_rng(1).uniform(0.0, 2.0, 20)]))
    record = Formula(time, {path: cubic, "bodies/slider/vx": cubic.deriv()})
    where = np.linspace(0.0, 2.0, 101)
    np.testing.assert_allclose(channels.at(record, path, where), cubic(where), atol=1e-12)
    assert (channels.at(record, path, time) == cubic(time)).all()


@pytest.mark.parametrize(
    ("path", "bound"), [("bodies/slider/x", 1.0 / 384.0), ("joints/C/force_x", 3.0 / 128.0)]
)
def test_interpolation_is_of_fourth_order(path, bound):
    """Errors of cubic Hermite (h^4/384) and in the middle of four points (3 h^4/128), of sin; 5 %
    for o(h^4).
    """
    for count in (40, 80):
        time = np.linspace(0.0, 2.0 * np.pi, count + 1)
        record = Formula(time, {path: np.sin, "bodies/slider/vx": np.cos})
        where = np.linspace(time[2], time[-3], 5001)
        error = np.abs(channels.at(record, path, where) - np.sin(where)).max()
        assert error == pytest.approx(bound * (2.0 * np.pi / count) ** 4, rel=0.05)


def test_interpolating_outside_the_run():
    """It is refused with the times of the run."""
    record = Formula([0.0, 1.0], {"bodies/slider/x": [0.0, 1.0]})
    with pytest.raises(ValueError, match="times from 0.5 s to 1.5 s: formula has 0 s to 1 s"):
        channels.at(record, "slider.x", [0.5, 1.5])


def test_abscissas(dry):
    """Time, turns and angle of the drive, over all or the last turns."""
    turn = dry.turn
    x, stored, label = channels.abscissa(dry, "angle", last=1.0)
    assert (x[0], x[-1], label) == (
        pytest.approx(0.0, abs=1e-9),
        pytest.approx(360.0),
        "crank angle [deg]",
    )
    assert dry.time[stored][0] == pytest.approx(turn)
    x, stored, label = channels.abscissa(dry, "turns")
    assert (x[0], x[-1], label) == (0.0, pytest.approx(2.0), "drive turns [-]")
    assert channels.abscissa(dry, "time", last=0.5)[0].size == 51
    with pytest.raises(ValueError, match="along must be one of time, turns, angle; got 'days'"):
        channels.abscissa(dry, "days")
    with pytest.raises(ValueError, match="last must be a positive number of turns, got 0"):
        channels.abscissa(dry, "time", last=0)


def test_drive_angle_counts_start_and_sense():
    """A drive that turns backwards has angles that fall."""
    record = Formula(
        [0.0, 1.0], {"bodies/slider/x": [0.0, 1.0]}, speed=-2.0 * np.pi, start=np.pi / 2.0
    )
    np.testing.assert_allclose(channels.abscissa(record, "angle")[0], [90.0, -270.0], atol=1e-12)


def test_without_a_drive():
    """Time remains; turns are refused."""
    pendulum = cl.simulate(cl.load_case("double_pendulum"), until=0.1)
    with pytest.raises(ValueError, match="no drive turns at constant speed"):
        channels.abscissa(pendulum, "turns")
    assert channels.abscissa(pendulum, "time")[0].size == pendulum.time.size


def test_one_panel_a_channel(dry, tmp_path, gallery):
    """Each panel has its channel over the last turn, labels and title."""
    path = histories(
        dry,
        tmp_path / "h.png",
        channels=["slider.ax", "C.force", "crank.torque"],
        along="angle",
        last=1,
    )
    assert path.read_bytes().startswith(b"\x89PNG")
    drawn = [axes.lines[0] for axes in gallery.last.axes]
    wanted = (dry["slider"].ax, np.hypot(*dry.joint("C").force.T), dry.drive("crank").torque)
    for line, values in zip(drawn, wanted, strict=True):
        assert (line.get_ydata() == values[100:]).all()
        assert line.get_xdata()[-1] == pytest.approx(360.0)
    texts = gallery.texts()
    assert {
        "joint C force [N]",
        "crank angle [deg]",
        "slider_crank: 5000 rpm, C dry c = 0.5 mm",
    } <= {*texts}
    assert gallery.smallest_text() >= 8.0


def test_overlays(tmp_path, gallery):
    """Runs have colours and labels of their own."""
    runs = [
        cl.simulate(cl.load_case("slider_crank", model="dry", clearance=c), turns=0.2)
        for c in (1e-4, 2e-4)
    ]
    histories(runs, tmp_path / "h.svg", channels=["slider.ax", "*.gap"])
    (legend,) = gallery.last.legends
    assert [t.get_text() for t in legend.get_texts()] == ["clearance 0.1 mm", "clearance 0.2 mm"]
    for axes in gallery.last.axes:
        a, b = axes.lines
        assert a.get_color() != b.get_color()
    histories(runs, tmp_path / "h.svg", channels="slider.ax", labels=["one", "other"])
    assert gallery.legend == ["one", "other"]
    with pytest.raises(ValueError, match="labels: 1 of them for 2 results"):
        histories(runs, tmp_path / "h.svg", channels="slider.ax", labels=["one"])


def test_a_channel_that_one_result_lacks(dry, feeder, tmp_path, gallery):
    """The panel names the result without it; one that all lack is refused."""
    histories(
        [dry, feeder],
        tmp_path / "h.png",
        channels=["slider.ax", "B.gap"],
        labels=["crank", "feeder"],
    )
    assert "not in crank" in gallery.texts()
    with pytest.raises(ValueError, match="no channel 'Z.gap'"):
        histories([dry, feeder], tmp_path / "h.png", channels="Z.gap")


def test_what_tells_results_apart(tmp_path):
    """Labels are the parameters that differ, else the names of files."""

    def run(**options):
        return cl.simulate(cl.load_case("slider_crank", **options), until=1e-5)

    base = run(model="dry")
    assert labels_of([base, run(model="lubricated", joints="C")]) == ["dry", "lubricated"]
    assert labels_of([base, run(model="dry", speed=cl.rpm(600))]) == [
        "speed 5000 rpm",
        "speed 600 rpm",
    ]
    assert labels_of([base, run(model="dry", restitution=0.8, clearance=1e-3)]) == [
        "clearance 0.5 mm, restitution 0.9",
        "clearance 1 mm, restitution 0.8",
    ]
    saved = [cl.open_result(base.save(tmp_path / n)) for n in ("a.h5", "b.h5")]
    assert labels_of(saved) == ["a.h5", "b.h5"]
    assert len(set(labels_of([base, base]))) == 2


def test_few_samples_and_none(tmp_path, gallery):
    """Two samples are dots; no samples are a sentence."""
    two = cl.simulate(cl.load_case("double_pendulum"), until=0.01, samples=2)
    histories(two, tmp_path / "h.png", channels="lower.theta")
    assert gallery.last.axes[0].lines[0].get_marker() == "."
    histories(Formula([], {"bodies/slider/x": []}), tmp_path / "h.png", channels="slider.x", last=1)
    assert "no samples" in gallery.texts()


def test_unfinished_runs_say_so(tmp_path, gallery):
    """Their status stands on the picture."""
    with pytest.raises(cl.SimulationError) as stop:
        cl.simulate(cl.load_case("slider_crank", model="dry"), turns=1.0, max_steps=30)
    partial = stop.value.result
    histories(partial, tmp_path / "h.png", channels="slider.ax")
    assert any("partial: " in text for text in gallery.texts())
    assert "other: partial: " in headline([partial, partial], ["one", "other"])


def test_too_many_panels(feeder, tmp_path):
    """A page has room for twelve, and needs one."""
    with pytest.raises(ValueError, match="a page has room for 12"):
        histories(feeder, tmp_path / "h.png", channels="*")
    with pytest.raises(ValueError, match="channels: give at least one"):
        histories(feeder, tmp_path / "h.png", channels=[])
    with pytest.raises(ValueError, match="records: give at least one"):
        histories([], tmp_path / "h.png", channels="slider.x")


def test_paths_in_the_plane_lose_nothing_visible():
    """Two hundred equal turns are drawn once; every point is within a cell of a drawn one; new
    turns stay.
    """
    angle = np.linspace(0.0, 2.0 * np.pi, 401)[:-1]
    x = np.concatenate([np.tile(np.cos(angle), 200), 1.5 * np.cos(angle)])
    y = np.concatenate([np.tile(np.sin(angle), 200), 1.5 * np.sin(angle)])
    axes = Figure().add_subplot()
    figures.trajectory(axes, x, y)
    drawn = np.column_stack(axes.lines[0].get_data())
    assert len(drawn) < 1000
    finite = drawn[np.isfinite(drawn[:, 0])]
    for radius in (1.0, 1.5):
        wanted = radius * np.exp(1j * angle)
        nearest = np.abs(wanted[:, None] - (finite[:, 0] + 1j * finite[:, 1])).min(axis=1)
        assert nearest.max() <= np.hypot(1.0, 1.0) * 3.0 / figures.CELLS
    strokes = np.isfinite(drawn[1:, 0]) & np.isfinite(drawn[:-1, 0])
    assert strokes.sum() == pytest.approx(2 * 400, abs=4)
