"""Pictures of fits: what is drawn, by its numbers."""

import dataclasses

import numpy as np
import pytest
from clearance.paper_figures.ball_joint_bench import bench
from clearance.postprocess import figures, fits

from clearance.identify.fit import Fit, fit, nrmse, open_fit
from clearance.identify.models import Curve
from clearance.identify.records import Measurement

NAMES = "p07_triangle_spin", "p07_triangle_tilt", "p08_triangle_spin", "p17_mixed_crossing"


@pytest.fixture(scope="module")
def measurement():
    entire = bench()
    return Measurement([entire.named(n) for n in NAMES], entire.facts)


@pytest.fixture(scope="module")
def actual(measurement, tmp_path_factory) -> Fit:
    return open_fit(
        fit(measurement, "lugre3d", starts=2).save(tmp_path_factory.mktemp("fit") / "fit.h5")
    )


@pytest.fixture
def drawn(monkeypatch):
    """The figures that are saved."""
    stored, save = [], figures.save
    monkeypatch.setattr(
        figures, "save", lambda figure, path: (stored.append(figure), save(figure, path))[1]
    )
    return stored


def shown(figure):
    return [axes for axes in figure.axes if axes.get_visible()]


def test_loops_have_a_panel_for_each_measured_axis(actual, measurement, tmp_path, drawn):
    """Titles name trial, axis and motion; curves are measured and modelled torque."""
    assert fits.loops(actual, measurement, tmp_path / "loops.png").stat().st_size > 10_000
    panels = shown(drawn[0])
    assert [p.get_title().split(":")[0] for p in panels] == [*NAMES, NAMES[-1]]
    assert [p.get_title().split(": ")[1].split("\n")[0] for p in panels] == [
        "spin, 10°, 50°/s",
        "tilt x, 10°, 50°/s",
        "spin, 10°, 100°/s",
        "tilt x",
        "spin",
    ]
    assert "synthetic" in drawn[0].get_suptitle()
    assert f"NRMSE {actual.score(measurement.trials):.3f}" in drawn[0].get_suptitle()
    mixed = measurement.trials[-1]
    modelled = actual.torque(mixed)
    for axes, axis in zip(panels[-2:], (0, 2), strict=True):
        error = nrmse(mixed.torque[:, axis], modelled[:, axis])
        assert f"NRMSE {error:.3f}" in axes.get_title()
        measured, model = axes.lines
        assert model.get_label() == "lugre3d"
        np.testing.assert_allclose(
            [np.nanmin(measured.get_xdata()), np.nanmax(measured.get_xdata())],
            np.degrees([mixed.angle[:, axis].min(), mixed.angle[:, axis].max()]),
            rtol=1e-3,
            atol=1e-3,
        )
        assert np.nanmax(model.get_ydata()) == pytest.approx(modelled[:, axis].max(), rel=1e-3)


def test_histories_end_at_the_sixth_turning_point(actual, measurement, tmp_path, drawn):
    """Longer trials are cut there."""
    fits.histories(actual, measurement, tmp_path / "time.png")
    ends = [p.lines[0].get_xdata()[-1] for p in shown(drawn[0])]
    # triangles turn at an odd number of quarters, 0.2 s and 0.1 s, where the filter is behind by 11
    # ms; sines turn twice a cycle, whose halves begin at rest
    assert ends == pytest.approx([2.2 + 0.01, 2.2 + 0.01, 1.1 + 0.01, 3.0, 2.0], abs=0.02)


def test_short_trials_are_shown_whole(actual, tmp_path, drawn):
    """Fewer turning points than six: all of the trial."""
    entire = bench().named("p02_triangle_spin")
    fits.histories(actual, Measurement([entire]), tmp_path / "time.png")
    assert shown(drawn[0])[0].lines[0].get_xdata()[-1] == pytest.approx(entire.time[-1], abs=0.01)


def test_residuals(actual, measurement, tmp_path, drawn):
    """Scores by trial, shares of residuals by role, and their spread over the rate."""
    assert fits.residuals(actual, measurement, tmp_path / "residuals.png").exists()
    bars, shares, speeds = drawn[0].axes
    names = [t.get_text() for t in bars.get_yticklabels()]
    assert names == list(NAMES)  # training, test and extrapolation are in this order
    widths = [p.get_width() for p in bars.patches]
    assert widths == pytest.approx([actual.score([measurement.named(n)]) for n in names], rel=1e-9)
    text = [t.get_text() for t in shares.get_legend().get_texts()]
    assert [t.split(",")[0] for t in text] == ["training", "test", "extrapolation"]
    for patch in shares.patches:
        values, edges, _ = patch.get_data()
        # the outermost 0.5 % of the widest are left out
        assert 0.99 <= np.sum(values * np.diff(edges)) <= 1.0 + 1e-9
    assert [t.get_text() for t in speeds.get_legend().get_texts()] == [
        "fitted: median, 10 to 90 %",
        "not fitted: median, 10 to 90 %",
    ]


def test_residuals_along_the_motion_tell_which_way_a_model_errs(
    actual, measurement, tmp_path, drawn
):
    """A level that is 0.5 N m too high brakes too much, whatever the direction."""
    trials = [
        dataclasses.replace(t, torque=actual.torque(t) - 0.5 * np.sign(t.rate))
        for t in measurement.of("training").trials
    ]
    fits.residuals(actual, Measurement(trials), tmp_path / "residuals.png")
    median = drawn[0].axes[2].lines[0]
    assert len(median.get_ydata()) > 3
    np.testing.assert_allclose(median.get_ydata(), 0.5, rtol=1e-9)


def test_progress(actual, tmp_path, drawn):
    """The history of the cost, and the starts in order."""
    fits.progress(actual, tmp_path / "progress.png")
    history, starts = drawn[0].axes
    np.testing.assert_array_equal(history.lines[0].get_ydata(), actual.history)
    np.testing.assert_allclose(
        starts.lines[0].get_ydata(), np.sort(actual.starts["cost"]) / actual.starts["cost"].min()
    )
    curve = dataclasses.replace(
        actual, model=Curve(), history=np.array([1.0]), starts={"cost": np.array([1.0])}
    )
    fits.progress(curve, tmp_path / "curve.png")
    assert "no iterations" in drawn[1].axes[0].texts[0].get_text()


def test_a_torque_that_is_zero(actual, measurement, tmp_path, drawn):
    """Its panel has a sentence about that."""
    still = dataclasses.replace(measurement.trials[0], measured=(True, False, True))
    fits.loops(actual, Measurement([still]), tmp_path / "loops.png")
    assert "measured torque is zero" in shown(drawn[0])[0].get_title()


def test_pictures_of_other_kinds(actual, measurement, tmp_path):
    """Another ending than that of a picture is refused."""
    with pytest.raises(ValueError, match="must end in"):
        fits.loops(actual, measurement, tmp_path / "loops.gif")
