"""Messages of a sweep: its metrics, its progress, and the points that count."""

import numpy as np
import pytest
from clearance.postprocess import maps

import clearance as cl
from clearance.commands.sweep import readable, summary
from clearance.sweeping import sweep

IDEAL = {"fixed": {"model": "ideal"}, "turns": 1.0, "samples_per_turn": 50, "workers": 1}
POINTS = cl.grid(speed=[10.0, 20.0])


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sweep")
    (folder / "mine.py").write_text(
        "def number(run):\n    return float(run['slider'].x.max())\n"
        "def with_units(run):\n    return run['slider'].x.max(), 'm', 'furthest'\n"
        "def broken(run):\n    return 1 / 0\n"
    )
    metrics = [f"{folder / 'mine.py'}:{name}" for name in ("number", "with_units", "broken")]
    return cl.sweep("slider_crank", POINTS, folder / "out", metrics=metrics, **IDEAL)


def test_a_metric_may_be_a_number(swept):
    """Its name stands for a text, and its unit is unknown."""
    assert swept.metrics["number"].tolist() == swept.metrics["with_units"].tolist()
    assert swept.known["number"] == ("?", "number")
    assert swept.known["with_units"] == ("m", "furthest")


def test_a_metric_that_fails_does_not_cost_the_run(swept):
    """The points are done, the metric is missing and the reason stays, also without the journal."""
    assert swept.done.all()
    assert "broken" not in swept.metrics
    assert swept.reason[0] == "metric broken: ZeroDivisionError: division by zero (mine.py, line 6)"
    lines = readable(summary(swept) | {"seconds": 1.0, "done_before": 0})
    assert any("speed=10: metric broken: ZeroDivisionError" in line for line in lines)
    (swept.folder / "journal.jsonl").rename(swept.folder / "kept")
    (swept.folder / "sweep.h5").rename(swept.folder / "index")
    again = cl.open_sweep(swept.folder)
    (swept.folder / "kept").rename(swept.folder / "journal.jsonl")
    (swept.folder / "index").rename(swept.folder / "sweep.h5")
    assert again.reason.tolist() == swept.reason.tolist()


def test_the_nearest_run(swept):
    """Values between points give the nearest only on demand."""
    with swept.run(method="nearest", speed=19.0) as run:
        assert run.path == swept.path(1)
    with pytest.raises(ValueError, match="was not swept"):
        swept.run(speed=19.0)
    with pytest.raises(ValueError, match='method must be "nearest" or None'):
        swept.run(method="next", speed=19.0)


def test_the_summary_names_the_extreme_by_size(swept):
    """Of minima the smallest; of what is larger below zero that end; else the largest."""
    lines = readable(summary(swept) | {"seconds": 1.0, "done_before": 0})
    least = next(line for line in lines if "slider_acceleration_min" in line)
    most = next(line for line in lines if "slider_acceleration_max" in line)
    assert least.endswith("smallest at speed=20")
    assert most.endswith("largest at speed=20")


def test_running_is_no_more_than_workers(tmp_path):
    """A worker holds a second point to go on with at once; that one is not running."""
    seen = []
    points = cl.grid(speed=np.linspace(10.0, 20.0, 8))
    cl.sweep(
        "slider_crank", points, tmp_path / "out", progress=lambda p: seen.append(p.running), **IDEAL
    )
    assert max(seen) <= 1


class Settled:
    """A sweep of four points by hand: two come back to themselves, one does not, of one it is
    unknown.
    """

    def __new__(cls, swept):
        actual = cl.open_sweep(swept.folder)
        points = cl.grid(speed=[10.0, 20.0]) * cl.grid(clearance=[1e-4, 2e-4])
        actual.definition = sweep.replace(actual.definition, points=points)
        actual.count, actual.status = 4, np.array(["done"] * 4)
        actual.metrics = {
            "peak": np.array([1.0, 2.0, 3.0, 4.0]),
            "period": np.array([1.0, 2.0, np.inf, np.nan]),
        }
        actual.costs = {"warnings": np.zeros(4)}
        actual.known = {"peak": ("N", "peak"), "period": ("turns", "period")}
        return actual


def test_only_settled_leaves_out_what_did_not_come_back(swept, tmp_path):
    """Such points have no value on maps and curves."""
    actual = Settled(swept)
    choice = maps.Choice.of(actual, None, only_settled=True)
    np.testing.assert_array_equal(choice.values("peak"), [1.0, 2.0, np.nan, np.nan])
    np.testing.assert_array_equal(maps.Choice.of(actual, None).values("peak"), [1.0, 2.0, 3.0, 4.0])
    assert maps.maps(actual, tmp_path / "map.png", only_settled=True).exists()
    assert maps.curves(actual, tmp_path / "curves.png", only_settled=True).exists()
    with pytest.raises(ValueError, match="no run of .* is certain to have settled"):
        maps.maps(swept, tmp_path / "never.png", only_settled=True)


@pytest.mark.parametrize("option", ["--kind random", "--kind 🙂", "--seed 3"])
def test_R10_options_of_samples_belong_to_samples(option, tmp_path, monkeypatch, typed):
    """Refused in one line, with nothing written."""
    monkeypatch.chdir(tmp_path)
    line = typed.line(f"sweep slider_crank -p speed=10,20 {option}")
    assert "belongs to --sample N" in line
    assert not list(tmp_path.iterdir())


def test_R10_only_settled_belongs_to_maps(swept, typed):
    """Other pictures refuse it in a document."""
    ended = typed("plot", swept.path(0), "overview --only-settled --json", status=2)
    assert "--only-settled does not belong to overview" in ended.document["message"]
