"""A branch of periodic motions over its parameter, beside a bifurcation diagram where there is
one.
"""

from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path

import numpy as np
from clearance.postprocess import figures
from clearance.postprocess.labels import axis_label, shown_in
from clearance.postprocess.sections import section

from clearance.sweeping.index import Sweep

#: marks of bifurcations
MARKS = {"fold": "o", "period doubling": "^", "torus": "s", "grazing": "D"}
STABLE = {"color": "#0072b2", "ls": "-", "lw": 1.6}
UNSTABLE = {"color": "#d55e00", "ls": "--", "lw": 1.2}
ROOM = 0.04  # around the branch, over its size
BEYOND = 0.35  # the same above and below, where dots of runs may lie


def branches(
    columns: dict,
    path: str | Path,
    *,
    title: str = "",
    over: Sweep | None = None,
    settle: float | None = None,
) -> Path:
    """A panel for each channel, where turns begin, and one for the size of the largest multiplier;
    saved under `path`.

    columns: of a branch, name -> units, text, values; the first is the parameter. over: a sweep
    over this parameter whose runs are drawn as dots, once a turn after `settle` turns (default: the
    first half of them).
    """
    (parameter, (units, _, values)), *rest = columns.items()
    unit, factor = shown_in(units, values)
    x, stable, kinds = values * factor, columns["stable"][2] > 0, columns["kind"][2]
    numbers = columns["branch"][2]
    curves = [numbers == number for number in np.unique(numbers)]
    channels = {name: column for name, column in rest if "." in name}
    paths = list(dict.fromkeys(name.partition("[")[0] for name in channels))
    figure = figures.sheet(7.0, 1.0 + 2.6 * len(paths) + 2.0)
    ratios = [2.6] * len(paths) + [2.0]
    panels = figure.subplots(len(ratios), sharex=True, squeeze=False, height_ratios=ratios)[:, 0]
    dots = _dots(over, parameter, [p.replace(".", "/") for p in paths], settle) if over else []
    for axes, name in zip(panels, paths, strict=False):
        _dotted(axes, dots, paths.index(name), factor)
        mine = [column for column in channels if column.partition("[")[0] == name]
        if dots:
            _room(axes, [channels[column][2] for column in mine])
        for column in mine:
            for curve in curves:
                _curve(axes, x[curve], channels[column][2][curve], stable[curve], kinds[curve])
            _marks(axes, x, channels[column][2], kinds)
        figures.finish(axes, axis_label(_text(name), channels[column][0], 2.4), "", legend=False)
    for curve in curves:
        largest = columns["largest_multiplier"][2]
        _curve(panels[-1], x[curve], largest[curve], stable[curve], kinds[curve])
    _marks(panels[-1], x, columns["largest_multiplier"][2], kinds)
    panels[-1].axhline(1.0, color="0.5", lw=0.8)
    panels[-1].set_ylim(0.0, None)
    label = figures.with_units(parameter.replace("_", " "), unit)
    figures.finish(panels[-1], "size of the largest\nmultiplier [-]", label, legend=False)
    _frame(panels[0], np.concatenate([x, [factor * value for value, _ in dots]]))
    figure.align_ylabels()
    figures.legend_above(panels[0])
    figure.suptitle(title, fontsize="medium")
    return figures.save(figure, path)


def _text(name: str) -> str:
    """bodies.slider.vx as "slider vx"."""
    return " ".join(name.split(".")[1:]).replace("_", " ")


def _curve(axes, x: np.ndarray, y: np.ndarray, stable: np.ndarray, kinds: np.ndarray) -> None:
    """A line that changes its stroke where the stability does, which it does in bifurcations."""
    changes = np.flatnonzero(np.diff(stable.astype(int))) + 1
    edges = sorted({0, *np.flatnonzero(kinds != ""), *changes, len(x) - 1})
    named = set(axes.get_legend_handles_labels()[1])
    for first, last in pairwise(edges):
        middle = (first + last) // 2 if last - first > 1 else last if kinds[first] else first
        style, label = (STABLE, "stable") if stable[middle] else (UNSTABLE, "unstable")
        style = style | {"label": None if label in named else label}
        axes.plot(x[first : last + 1], y[first : last + 1], **style)
        named.add(label)


def _marks(axes, x: np.ndarray, y: np.ndarray, kinds: Iterable[str]) -> None:
    named = set(axes.get_legend_handles_labels()[1])
    for kind, mark in MARKS.items():
        here = np.array([k == kind for k in kinds])
        if here.any():
            label = None if kind in named else kind
            axes.plot(
                x[here], y[here], mark, color="black", mfc="white", ms=5, zorder=3, label=label
            )


def _dots(
    sweep: Sweep, parameter: str, paths: list[str], settle: float | None
) -> list[tuple[float, np.ndarray]]:
    """Section values of the runs of a sweep.
    Raises ValueError where it is not over this parameter.
    """
    if parameter not in sweep.columns:
        raise ValueError(
            f"{sweep.folder} is no sweep over {parameter}; it is over {', '.join(sweep.columns)}"
        )
    dots = []
    for i, value in enumerate(sweep.columns[parameter]):
        if sweep.done[i] and sweep.path(i).exists():
            with sweep.run(i) as run:
                left_out = (
                    float(int(0.5 * run.turns_at(run.time[-1]))) if settle is None else settle
                )
                dots.append((float(value), section(run, paths, 0.0, left_out)))
    return dots


def _dotted(axes, dots: list[tuple[float, np.ndarray]], column: int, factor: float) -> None:
    if dots:
        x = np.concatenate([np.full(len(rows), value * factor) for value, rows in dots])
        y = np.concatenate([rows[:, column] for _, rows in dots])
        axes.plot(x, y, ".", color="0.55", ms=3, mew=0, label="runs once a turn")


def _room(axes, curves: list[np.ndarray]) -> None:
    """Limits around the branch: chaotic runs go much further."""
    low, high = min(map(np.nanmin, curves)), max(map(np.nanmax, curves))
    axes.set_ylim(low - BEYOND * (high - low), high + BEYOND * (high - low))


def _frame(axes, x: np.ndarray) -> None:
    """The range of the branch, with room."""
    room = ROOM * (x.max() - x.min())
    axes.set_xlim(x.min() - room, x.max() + room)
