"""Poincare sections against formulas and finer sampling; portraits and bifurcation diagrams."""

import numpy as np
import pytest
from clearance.postprocess.sections import bifurcation, poincare, portrait, section, section_times

import clearance as cl
from clearance.metrics.statistics import mean
from tests.postprocess.records import Formula

TURN = 1.0


def slow(t):
    """A period of three turns, with its rates."""
    return np.sin(2.0 * np.pi * t / 3.0)


def record_of(per_turn=50, turns=9, **options):
    w = 2.0 * np.pi / 3.0
    time = np.linspace(0.0, turns * TURN, per_turn * turns + 1)
    channels = {
        "bodies/slider/x": slow,
        "bodies/slider/vx": lambda t: w * np.cos(w * t),
        "bodies/slider/ax": lambda t: -(w**2) * np.sin(w * t),
    }
    return Formula(time, channels, **options)


@pytest.mark.parametrize("angle", [0.0, 1.0, -2.0, 6.0])
def test_section_of_a_formula(angle):
    """A period of three turns gives three points, located between samples to the interpolation's
    h^4 (w h = 0.042).

    Cubic Hermite errs by (w h)^4 / 384 = 8e-9 of the amplitude, four points by at most 3 (w
    h)^4 / 128 = 7e-8; the acceleration's amplitude is 4.4.
    """
    record = record_of()
    actual = section(record, ["slider.x", "slider.vx", "slider.ax"], angle=angle, settle=3.0)
    t = section_times(record, angle, 3.0)
    assert len(actual) == (7 if angle == 0.0 else 6)
    np.testing.assert_allclose(np.mod(2.0 * np.pi * t - angle + 1.0, 2.0 * np.pi), 1.0, atol=1e-9)
    w = 2.0 * np.pi / 3.0
    np.testing.assert_allclose(actual[:, 0], slow(t), atol=1e-8)
    np.testing.assert_allclose(actual[:, 1], w * np.cos(w * t), atol=2e-8)
    np.testing.assert_allclose(actual[:, 2], -(w**2) * slow(t), atol=4e-7)
    np.testing.assert_allclose(actual[:3], actual[3:6], atol=1e-6)  # of period three
    assert np.abs(actual[0] - actual[1]).max() > 0.1  # and not of period one


def test_samples_at_the_angle_are_taken_as_they_are():
    """Nothing is interpolated where a sample stands."""
    record = record_of()
    assert (
        section(record, "slider.ax", settle=0.0)[:, 0] == record.values("bodies/slider/ax")[::50]
    ).all()


@pytest.mark.parametrize(
    ("speed", "start"), [(2.0 * np.pi, 0.4), (-2.0 * np.pi, 0.4), (-2.0 * np.pi, -3.0)]
)
def test_sections_know_start_and_sense_of_the_drive(speed, start):
    """Each passage is at the angle, to rounding, one a turn."""
    record = record_of(speed=speed, start=start)
    times = section_times(record, 1.0, settle=0.0)
    np.testing.assert_allclose(
        np.mod(start + speed * times - 1.0 + np.pi, 2.0 * np.pi), np.pi, atol=1e-9
    )
    assert len(times) == 9


def test_the_start_of_a_drive_that_does_not_say_it():
    """It is that of the crank's stored angle, or zero."""
    record = record_of(start=None)
    assert section_times(record, 0.0, 0.0)[0] == 0.0
    record.data["bodies/crank/theta"] = 0.5 + 2.0 * np.pi * record.time
    assert section_times(record, 1.0, 0.0)[0] == pytest.approx(0.5 / (2.0 * np.pi), rel=1e-12)


def test_sections_of_a_run_agree_with_finer_sampling():
    """Lubricated feeder, 100 against 3200 samples a turn, rtol 1e-8.

    Measured: 2e-9 of the position's range, 2e-8 of the velocity's, 2e-7 of the acceleration's, 1e-6
    of c; bounds five times that, for the last digits of a run depend on the machine.
    """
    scene = cl.load_case("six_bar_feeder", joints="B,C")
    coarse, fine = (
        cl.simulate(scene, turns=3.0, samples_per_turn=n, rtol=1e-8) for n in (100, 3200)
    )
    names = ["slider.x", "slider.vx", "slider.ax", "B.epsilon_x"]
    a, b = (section(r, names, angle=1.2345, settle=1.0) for r in (coarse, fine))
    ranges = [np.ptp(fine.values(f"bodies/slider/{n}")) for n in ("x", "vx", "ax")]
    assert a.shape == (2, 4)
    assert (np.abs(a - b) / [*ranges, 1.0] < [1e-8, 1e-7, 1e-6, 5e-6]).all()


def test_a_lubricated_feeder_is_periodic():
    """After its transient it returns to the same point every turn: 1e-4 of c at rtol 1e-6."""
    run = cl.simulate(cl.load_case("six_bar_feeder"), turns=6.0, samples_per_turn=50)
    actual = section(run, ["B.epsilon_x", "B.epsilon_y"], settle=3.0)
    assert actual.shape == (4, 2)
    assert np.ptp(actual, axis=0).max() < 1e-4


def test_short_runs_have_no_section():
    """Sections of no passage have no rows."""
    assert section(record_of(turns=1), ["slider.x", "slider.vx"], settle=2.0).shape == (0, 2)
    assert section(record_of(turns=2), "slider.x", settle=2.0).shape == (1, 1)  # the end counts
    assert section(Formula([], {"bodies/slider/x": []}), "slider.x").shape == (0, 1)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"angle": np.inf}, "angle must be finite"),
        ({"angle": 90.0}, r"angle 90 rad is more than a turn; did you mean 90deg\?"),
        ({"angle": -6.3}, "angle -6.3 rad is more than a turn"),
        ({"settle": -1.0}, "settle must be a number of turns, not negative, got -1.0"),
        ({"settle": np.nan}, "settle must be a number of turns"),
        ({"channels": []}, "channels: give at least one"),
        ({"channels": ["slider.jerk"]}, "no channel 'slider.jerk'"),
    ],
)
def test_bad_sections(options, message):
    """Angles, settling times and channels that cannot be are refused."""
    with pytest.raises(ValueError, match=message):
        section(record_of(), **{"channels": ["slider.x"]} | options)


def test_no_section_without_a_drive(tmp_path):
    """Nothing that turns at constant speed: both pictures are refused."""
    pendulum = cl.simulate(cl.load_case("double_pendulum"), until=0.1)
    with pytest.raises(ValueError, match="no drive turns at constant speed"):
        section(pendulum, ["lower.theta"])
    with pytest.raises(ValueError, match="no drive turns at constant speed"):
        portrait(pendulum, tmp_path / "p.png", settle=1.0)


def test_poincare_shows_the_journal_and_the_slider(tmp_path, gallery):
    """Its points are those of the section, its title names the method."""
    run = cl.simulate(cl.load_case("six_bar_feeder", joints="B,C"), turns=3.0, samples_per_turn=100)
    path = poincare(run, tmp_path / "p.png", angle=1.0, settle=1.0)
    assert path.read_bytes().startswith(b"\x89PNG")
    journal, slider = gallery.last.axes
    expected = section(run, ["B.epsilon_x", "B.epsilon_y", "slider.vx", "slider.ax"], 1.0, 1.0)
    assert (np.column_stack(journal.lines[0].get_data()) == expected[:, :2]).all()
    assert (np.column_stack(slider.lines[0].get_data()) == expected[:, 2:]).all()
    title = "\n".join(gallery.texts())
    assert "crank angle 57.3°, 2 passages from turn 1 on" in title
    assert "cubic through 4 samples" in title
    assert gallery.smallest_text() >= 8.0
    poincare(run, tmp_path / "p.png", joint="C", settle=1.0)
    assert any("joint C eccentricity x" in text for text in gallery.texts())
    assert any("values at samples" in text for text in gallery.texts())
    with pytest.raises(ValueError, match="joint 'A' is no clearance joint of .*; those are: B, C"):
        poincare(run, tmp_path / "p.png", joint="A")


def test_nothing_left_after_settling(tmp_path, gallery):
    """It is refused; a run without samples is drawn as such."""
    run = cl.simulate(cl.load_case("four_bar"), turns=1.0)
    with pytest.raises(ValueError, match="has no passage of the section after turn 4"):
        poincare(run, tmp_path / "p.pdf", settle=4.0)
    with pytest.raises(ValueError, match="has no sample after turn 1.5"):
        portrait(run, tmp_path / "p.pdf", settle=1.5)
    empty, pairs = (
        Formula([], {f"bodies/slider/{n}": [] for n in ("x", "vx")}),
        [("slider.x", "slider.vx")],
    )
    for draw in (portrait, poincare):
        draw(empty, tmp_path / "p.png", pairs=pairs)
        assert "no samples" in gallery.texts()


def test_portraits(tmp_path, gallery):
    """Channels against each other after settling, with readable powers of ten."""
    run = cl.simulate(cl.load_case("slider_crank", model="dry"), turns=2.0, samples_per_turn=100)
    portrait(run, tmp_path / "p.png", settle=1.0)
    first, second = gallery.last.axes
    assert (first.get_xlabel(), first.get_ylabel()) == (
        "slider position x [m]",
        "slider velocity x [m/s]",
    )
    assert second.get_ylabel() == "slider acceleration x [10⁵ m/s²]"  # up to 2e5 m/s²
    assert (first.lines[0].get_xdata() == run["slider"].x[100:]).all()
    runs = [run, cl.simulate(cl.load_case("slider_crank", model="ideal"), turns=1.0)]
    portrait(runs, tmp_path / "p.png", pairs=("slider.x", "slider.vx"))
    assert len(gallery.last.axes) == 1
    assert gallery.legend == ["dry", "ideal"]
    with pytest.raises(ValueError, match="pairs must be of two channels"):
        portrait(run, tmp_path / "p.png", pairs=["slider.x"])


def test_bifurcation(tmp_path, gallery):
    """The logistic map: fixed point, crosses, and bars of intervals in chaos alone."""
    r = np.linspace(2.8, 4.0, 60)
    points = []
    for value in r:  # the logistic map, whose first doublings stand at 3 and 1 + sqrt(6)
        x = [0.5]
        for _ in range(400):
            x.append(value * x[-1] * (1.0 - x[-1]))
        points.append((value, np.array(x[-64:])))
    bifurcation(
        [*points, (4.1, [])],
        tmp_path / "b.png",
        parameter="r [-]",
        channels="x [-]",
        title="logistic map",
    )
    (axes,) = gallery.last.axes
    x, y = axes.lines[0].get_data()
    assert len(x) == 60 * 64
    np.testing.assert_allclose(y[x == r[0]], 1.0 - 1.0 / r[0], atol=1e-6)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("r [-]", "x [-]")
    assert axes.lines[1].get_xdata() == [4.1]
    note = (
        "crosses: no section there; bars: 95 % intervals of means over turns, of irregular motion"
    )
    assert f"logistic map\n{note}" in gallery.texts()
    (bars,) = axes.collections  # in chaos alone, from 3.5699... on
    where = [segment[0, 0] for segment in bars.get_segments()]
    assert 3.5699 < min(where) < 3.7
    one = mean(points[58][1])
    (low, high) = bars.get_segments()[where.index(r[58])][:, 1]
    assert (low, high) == pytest.approx((one.value - one.half_width, one.value + one.half_width))


def test_bifurcation_with_two_channels(tmp_path, gallery):
    """A panel each; shapes that do not fit are refused."""
    points = [(p, np.arange(6.0).reshape(3, 2) + p) for p in (1.0, 2.0)]
    bifurcation(points, tmp_path / "b.png", channels=["a", "b"])
    assert [len(axes.lines[0].get_xdata()) for axes in gallery.last.axes] == [6, 6]
    with pytest.raises(
        ValueError, match=r"at 1.0 section values of shape \(3, 2\); channels name 1"
    ):
        bifurcation(points, tmp_path / "b.png", channels=["a"])
    with pytest.raises(ValueError, match="points: give at least one"):
        bifurcation([], tmp_path / "b.png")
