"""First pictures: made from a file alone, for every kind of scene, with no peak lost."""

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
        ("six_bar_feeder", {"model": "mixed", "transition": "fuzzy", "joints": "B,C"}, {"turns": 0.2}),
        ("four_bar", {"model": "ideal"}, {"turns": 0.2}),
        ("double_pendulum", {}, {"until": 0.5}),
    ],
)
def test_overview(case, options, span, tmp_path):
    path = cl.simulate(cl.load_case(case, **options), **span).save(tmp_path / "run.h5")
    picture = plots.overview(cl.open_result(path), tmp_path / "run.png")
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert picture.stat().st_size > 30000


def test_thinning_keeps_peaks():
    values = np.zeros(300_000)
    values[123_456], values[234_567] = 5.0, -7.0
    axes = Figure().add_subplot()
    figures.line(axes, np.arange(values.size), values)
    (line,) = axes.lines
    assert len(line.get_xdata()) <= 2 * figures.POINTS
    assert (line.get_ydata().max(), line.get_ydata().min()) == (5.0, -7.0)
    assert (np.diff(line.get_xdata()) >= 0).all()
