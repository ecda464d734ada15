"""Turn peaks of a chaotic motion from the statistics in a run's file: turn by turn, and how often
they are exceeded.
"""

from pathlib import Path

import numpy as np
from clearance.postprocess import figures
from clearance.postprocess.labels import axis_label, shown_in

from clearance.results.result import open_result

PEAK = "_peak"
MOST = 3  # quantities in a picture
DOTS = 4000  # turns drawn, at most


def turn_peaks(path: str | Path, picture: str | Path) -> Path:
    """Draw up to three peaks that `clearance run --error` of a chaotic motion has put into a file.

    On the left stands each turn, with the mean, its 95 % interval and the levels exceeded in one
    turn of 10 and of 100. On the right stands the share of the turns that exceed a value. Several
    motions have a colour each. Raises ValueError for a file without statistics.
    """
    with open_result(path) as run:
        if "statistics" not in run.file:
            raise ValueError(
                f"{path} holds no statistics; clearance run --error 5% of a chaotic motion makes "
                f"some"
            )
        group = run.file["statistics"]
        about = dict(group["by_turn"].attrs)
        chosen = chosen_peaks(list(group["by_turn"]))
        peaks = {n: (group["by_turn"][n][:], group["by_turn"][n].attrs["units"]) for n in chosen}
        motions = [_motion(group[n]) for n in sorted(group) if n.startswith("motion_")]
    figure = figures.sheet(9.0, 1.2 + 2.3 * len(peaks))
    panels = figure.subplots(
        len(peaks), 2, sharex="col", sharey="row", squeeze=False, width_ratios=(2.2, 1.0)
    )
    for row, (name, (values, units)) in zip(panels, peaks.items(), strict=True):
        unit, factor = shown_in(units, values.ravel())
        for i, (starts, numbers) in enumerate(motions):
            _turns(row[0], factor * values[starts], int(about["left_out"]), f"C{i}")
            _exceeded(row[1], factor * values[starts, int(about["left_out"]) :], f"C{i}")
            for axes in row:
                _numbers(axes, {n: factor * v for n, v in numbers[name].items()}, f"C{i}")
        label = f"peak of {name.removesuffix(PEAK).replace('_', ' ')}"
        figures.finish(row[0], axis_label(label, unit), "", legend=False)
        row[0].set_xlim(0.0, values.shape[1])
        figures.finish(row[1], "", "", legend=False)
    panels[-1, 0].set_xlabel("turn of each start [-]")
    panels[-1, 1].set_xlabel("share of the turns above [-]")
    figure.get_layout_engine().set(wspace=0.06)
    figure.suptitle(_title(str(about["verdict"])), fontsize="medium")
    figures.legend_below(figure, panels[0, 0])
    return figures.save(figure, picture)


def chosen_peaks(names: list[str]) -> list[str]:
    """Forces of joints that touch, then efforts of drives and accelerations, then other forces."""
    peaks = [n for n in names if n.endswith(PEAK)]
    loose = [n.replace("_penetration", "_force") for n in peaks if n.endswith("_penetration_peak")]
    efforts = [n for n in peaks if n.startswith("drive_")]
    moved = [n for n in peaks if n.endswith("_acceleration_peak")]
    return list(dict.fromkeys([*loose, *efforts, *moved, *peaks]))[:MOST]


def _motion(group) -> tuple[np.ndarray, dict[str, dict[str, float]]]:
    """Its starts, and its numbers by quantity."""
    columns = {n: group[n][:] for n in ("mean", "half_width", "q90", "q99")}
    names = [str(n) for n in group["quantity"].asstr()]
    rows = {q: {n: float(c[i]) for n, c in columns.items()} for i, q in enumerate(names)}
    return np.array(group.attrs["starts"], dtype=int), rows


def _turns(axes, values: np.ndarray, left_out: int, colour: str) -> None:
    every, turn = max(values.size // DOTS, 1), np.arange(values.shape[1]) + 0.5
    style = {"ls": "", "marker": "o", "ms": 2.5, "mew": 0.0}
    later, first = slice(left_out, None, every), slice(left_out)
    axes.plot(turn[later], values[:, later].T, color=colour, alpha=0.6, **style)
    dots = axes.plot(turn[first], values[:, first].T, color="black", **style)
    dots[0].set_label("transient, left out")


def _exceeded(axes, values: np.ndarray, colour: str) -> None:
    ranked = np.sort(values, axis=None)[::-1]
    axes.plot(np.arange(1, ranked.size + 1) / ranked.size, ranked, color=colour, lw=1.2)
    axes.set_xscale("log")
    axes.set_xlim(1.0, max(1.0 / ranked.size, 1e-4))


def _numbers(axes, numbers: dict[str, float], colour: str) -> None:
    mean, half = numbers["mean"], numbers["half_width"]
    axes.axhspan(mean - half, mean + half, color=colour, alpha=0.25, lw=0)
    axes.axhline(mean, color=colour, lw=1.2, label="mean, 95 % interval shaded")
    for name, dashes, text in (
        ("q90", "--", "1 turn in 10 above"),
        ("q99", ":", "1 turn in 100 above"),
    ):
        if np.isfinite(numbers[name]):
            axes.axhline(numbers[name], color=colour, lw=1.0, ls=dashes, label=text)


def _title(verdict: str) -> str:
    """The verdict, with the plus and minus of print."""
    return verdict.replace("+-", "±")
