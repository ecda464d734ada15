"""First pictures: made from a file alone, for every kind of scene, with no peak lost."""

from types import SimpleNamespace

import numpy as np
import pytest
from clearance.postprocess import figures, plots
from matplotlib.figure import Figure

import clearance as cl


@pytest.mark.parametrize(
    ("case", "options", "span"),
    [
        ("six_bar_feeder", {"joints": "B,C,E"}, {"turns": 0.2}),
        ("slider_crank", {"model": "dry"}, {"turns": 0.2}),
        (
            "six_bar_feeder",
            {"model": "mixed", "transition": "fuzzy", "joints": "B,C"},
            {"turns": 0.2},
        ),
        ("four_bar", {"model": "ideal"}, {"turns": 0.2}),
        ("double_pendulum", {}, {"until": 0.5}),
    ],
)
def test_overview(case, options, span, tmp_path):
    """A picture of each kind of run, from its file."""
    path = cl.simulate(cl.load_case(case, **options), **span).save(tmp_path / "run.h5")
    picture = plots.overview(cl.open_result(path), tmp_path / "run.png")
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert picture.stat().st_size > 30000


def test_thinning_keeps_peaks():
    """Long series are thinned, their extremes stay."""
    values = np.zeros(300_000)
    values[123_456], values[234_567] = 5.0, -7.0
    axes = Figure().add_subplot()
    figures.line(axes, np.arange(values.size), values)
    (line,) = axes.lines
    assert len(line.get_xdata()) <= 2 * figures.POINTS
    assert (line.get_ydata().max(), line.get_ydata().min()) == (5.0, -7.0)
    assert (np.diff(line.get_xdata()) >= 0).all()


def test_users26_curves_of_many_turns_have_the_last_two():
    """Of twelve turns, at the axis and in words; the energy ledger has all."""
    figure = figures.sheet(4.0, 3.0)
    force, ledger = figure.subplots(2)
    for axes, label in ((force, "force [N]"), (ledger, plots.LEDGER[0])):
        axes.plot([0.0, 12.0], [0.0, 1.0])
        figures.finish(axes, label)
    run = SimpleNamespace(time=np.linspace(0.0, 12.0, 5), turn=1.0)
    before = ledger.get_xlim()
    plots._last_turns(figure, run)
    assert force.get_xlim() == (10.0, 12.0)
    assert force.get_xlabel() == "time [s], the last 2 of 12 turns"
    assert ledger.get_xlim() == before


def test_users26_curves_lead_to_the_dots_of_extremes():
    """A peak between two samples is a point of the curve, in order."""
    x, y = plots._through(
        np.array([0.0, 1.0]), np.zeros(2), np.array([0.4, np.nan]), np.array([30.0, np.nan])
    )
    assert x.tolist() == [0.0, 0.4, 1.0]
    assert y.tolist() == [0.0, 30.0, 0.0]


def time_panel(peak: float):
    """A sine of size 1 over 1 s with one sample of another size, as the overview leaves its
    axes.
    """
    figure = figures.sheet(4.0, 3.0)
    axes, time = figure.subplots(), np.linspace(0.0, 1.0, 1001)
    values = np.sin(20.0 * time)
    values[700] = peak
    figures.line(axes, time, values)
    axes.set_xlabel(plots.TIME)
    plots._settled_axes(figure, None)
    return axes


def test_lone_peaks_lie_beyond_the_axis_with_a_mark():
    """The axis is that of the others, the mark stands at the time, the text has the size."""
    axes = time_panel(1e5)
    low, high = axes.get_ylim()
    assert -4.0 < low < -1.0 < 1.0 < high < 4.0
    _, mark, _ = axes.lines
    assert mark.get_xdata() == pytest.approx([0.7])
    assert [t.get_text() for t in axes.texts] == ["triangles: beyond the axis, up to 1e+05"]


def test_peaks_of_a_usual_size_stay_on_the_axis():
    """No note where nothing is cut off."""
    axes = time_panel(20.0)
    assert axes.get_ylim()[1] > 20.0
    assert not axes.texts


def test_powers_of_ten_stand_in_labels(tmp_path):
    """Of shared axes in the label that is there; small and large numbers alike, with a prefix where
    the unit takes one; saving twice changes nothing.
    """
    figure = figures.sheet(4.0, 4.0)
    upper, lower = figure.subplots(2, 1, sharex=True)
    upper.plot([0.0, 3e-6], [0.0, 2.5e7])
    lower.plot([0.0, 3e-6], [7.0, 7.0 + 1e-9])
    upper.set_ylabel("force [N]")
    lower.set(xlabel="time [s]", ylabel="ratio [-]")
    for _ in range(2):
        figures.save(figure, tmp_path / "p.png")
        assert (upper.get_ylabel(), lower.get_xlabel()) == ("force [MN]", "time [µs]")
        assert [t.get_text() for t in upper.get_yticklabels()][1:4] == ["0", "5", "10"]
        assert (
            upper.yaxis.get_offset_text().get_text()
            == lower.xaxis.get_offset_text().get_text()
            == ""
        )
    assert lower.get_ylabel() == "ratio [-]"
    assert lower.yaxis.get_offset_text().get_text() == ""
    assert figures._with_power("share", -4) == "share [10⁻⁴]"
    assert figures._with_power("acceleration [m/s²]", 6) == "acceleration [10⁶ m/s²]"
    assert figures._with_power("torque [N\N{NO-BREAK SPACE}m]", -6) == "torque [µN m]"
    assert figures._with_power("share [-]\nof two", -4) == "share [10⁻⁴]\nof two"


def test_orbit_of_a_dry_joint_shows_flight_and_contact(tmp_path):
    """The drawn contact begins and ends on the clearance circle or beyond it, also between
    samples.
    """
    path = cl.simulate(cl.load_case("slider_crank", model="dry"), turns=0.5).save(
        tmp_path / "run.h5"
    )
    run = cl.open_result(path)
    axes = Figure().add_subplot()
    plots.orbit(run, "C", axes)
    assert [t.get_text() for t in axes.get_legend().get_texts()] == ["free flight", "contact"]
    touched = plots.touched(run, "C", run.time)
    # the force acts between an event's ends
    assert (touched | (run.joint("C").contact_force == 0.0)).all()
    journal, contact, clock = plots.with_contacts(run, "C")
    assert (np.diff(clock) >= 0.0).all()
    assert set(run.time) <= set(clock)
    ends = np.append(run.events["time"], run.events["time"] + run.events["duration"])
    assert set(ends[(ends > 0.0) & (ends < run.time[-1])]) <= set(clock)
    ratio = np.hypot(*journal.T) / run.clearances["C"]
    assert contact.any()
    # events are located to far less than 1e-6 of the clearance
    assert np.minimum(ratio[:-1], ratio[1:])[contact[1:]].min() > 1.0 - 1e-6
    assert ratio[~contact].max() < 1.0 + 1e-6


def test_a_path_in_contact_follows_the_wall():
    """From one sample to the next by 40 degrees, then off the wall: steps of 3 degrees at most,
    within the thousandth of the radius that such a step's chord leaves; samples stay."""
    angle, far = np.radians([170.0, 210.0, 215.0]), np.array([1.001, 1.003, 0.4])
    path = far[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    journal, contact, clock = plots._along_the_wall(
        path, np.array([True, True, False]), np.arange(3.0)
    )
    assert np.array_equal(journal[np.isin(clock, [0.0, 1.0, 2.0])], path)
    assert np.array_equal(contact, clock <= 1.0)
    on_wall = journal[contact]
    assert np.hypot(*on_wall.T).min() >= 1.001 * (1.0 - 1e-12)
    steps = np.hypot(*np.diff(on_wall, axis=0).T)
    assert steps.max() < np.radians(3.0) * 1.004


def test_orbit_of_a_lubricated_joint_marks_its_smallest_gap(tmp_path):
    """The mark stands there, and the legend has its size."""
    path = cl.simulate(cl.load_case("slider_crank", model="lubricated"), turns=0.2).save(
        tmp_path / "run.h5"
    )
    run = cl.open_result(path)
    axes = Figure().add_subplot()
    plots.orbit(run, "C", axes)
    gap = run.joint("C").gap.min() / run.clearances["C"]
    assert [t.get_text() for t in axes.get_legend().get_texts()] == [f"smallest gap {gap:.3g} c"]
    (mark,) = (line for line in axes.lines if line.get_marker() == "D")
    assert 1.0 - np.hypot(*mark.get_xydata()[0]) == pytest.approx(gap, rel=1e-9)


def test_regimes_show_the_thresholds_of_the_scene(tmp_path):
    """Curves of neighbouring states share a sample at each switch, so that no stroke is missing."""
    options = {
        "model": "mixed",
        "transition": "fuzzy",
        "thresholds": (0.05, 0.3, 1.2),
        "viscosity": 0.002,
        "elastic": "false",
    }
    path = cl.simulate(
        cl.load_case("six_bar_feeder", speed=cl.rpm(600), **options), turns=0.3
    ).save(tmp_path / "r.h5")
    run = cl.open_result(path)
    axes = Figure().add_subplot()
    plots.regimes(run, "B", axes)
    assert [t.get_text() for t in axes.texts] == ["dry 0.05", "mixed 0.3", "full 1.2"]
    assert axes.get_yscale() == (
        "log" if run.joint("B").film_thickness_ratio.min() > 0.0 else "symlog"
    )
    drawn = [np.isfinite(line.get_ydata()) for line in axes.lines[:-3]]
    strokes = sum((d[:-1] & d[1:]).astype(int) for d in drawn)
    assert len(drawn) > 1
    assert (strokes >= 1).all()


@pytest.mark.parametrize("points", [1000, 100_000])
def test_trajectories_may_have_gaps(points):
    """Values of nan are not drawn over, and both ends of each stretch survive, to a 4000th."""
    turn = np.linspace(0.0, 40.0 * np.pi, points)
    x, y = np.cos(turn), np.where(np.cos(turn) > 0.5, np.nan, np.sin(turn))
    axes = Figure().add_subplot()
    figures.trajectory(axes, x, y)
    shown = axes.lines[0].get_xydata()
    stored = np.isfinite(shown).all(axis=1)
    assert shown[stored, 0].max() <= 0.5
    assert shown[stored, 0].max() == pytest.approx(x[np.isfinite(y)].max(), abs=1e-3)
    strokes = np.abs(np.diff(shown, axis=0)).max(axis=1)
    assert np.nanmax(strokes) < 1.01 * max(40.0 * np.pi / points, 1e-3)


def test_legends_fit_the_page(monkeypatch):
    """Long names take more rows."""
    actual = []
    monkeypatch.setattr(Figure, "legend", lambda *_, **options: actual.append(options["ncols"]))
    for names in (["a", "b"], ["a", "b", "c", "d"], ["x" * 25, "y"], ["x" * 80, "y"]):
        figure = figures.sheet(7.0, 3.0)
        axes = figure.add_subplot()
        for name in names:
            axes.plot([0.0], [0.0], label=name)
        figures.legend_below(figure, axes)
    assert actual == [2, 3, 2, 1]
