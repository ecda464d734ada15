"""Tornado of a run: changes of its metrics where each parameter grows or shrinks by 1 %."""

from collections.abc import Mapping
from fnmatch import fnmatchcase
from pathlib import Path

from clearance.postprocess.figures import Sheet, save, sheet, with_units
from clearance.postprocess.labels import shown_in

from clearance.metrics.metrics import metrics as metrics_of
from clearance.results.result import Result
from clearance.values.checks import meant

MOST, SHOWN = 12, 4  # metrics of a picture, and of one that names none
WIDTH, HEAD, BAR = 7.5, 0.85, 0.34  # of the sheet, of a panel without bars, of a bar [inch]
GROWS, SHRINKS = "#1565c0", "#b0bec5"
UNCERTAIN = {"hatch": "////", "edgecolor": "white", "linewidth": 0.0}


def tornado(
    run: Result, path: str | Path | None = None, metrics: list[str] | None = None
) -> Path | Sheet:
    """A panel for each metric, a bar for each parameter, the longest on top, with stated errors.

    metrics: names or patterns, default forces, gaps and efforts, four in all. Raises ValueError for
        a run without sensitivities, and for metrics that it does not have.
    """
    sensitivities = run.sensitivities
    if not sensitivities:
        raise ValueError(
            f"the run has no sensitivities: {sensitivities.reason}; "
            "make it with --sensitivity NAMES"
        )
    chosen = _chosen(sensitivities.telling(run.clearances), metrics)
    height = HEAD + BAR * len(sensitivities.parameters)
    figure = sheet(WIDTH, height * len(chosen) + 0.4)
    panels = figure.subplots(len(chosen), squeeze=False)[:, 0]
    words = {name: metric.text for name, metric in metrics_of(run).items()}
    for axes, metric in zip(panels, chosen, strict=True):
        of_metric = {p: s for (m, p), s in sensitivities.items() if m == metric}
        _panel(axes, words.get(metric, metric), of_metric)
    handles = panels[0].get_legend_handles_labels()
    figure.legend(*handles, loc="outside upper center", ncols=3, fontsize="small", frameon=False)
    return save(figure, path)


def _chosen(names: list[str], metrics: list[str] | None) -> list[str]:
    """Metrics by name or pattern. Raises ValueError for one that matches none, and for too many."""
    if metrics is None:
        return names[:SHOWN]
    for pattern in metrics:
        if not any(fnmatchcase(n, pattern) for n in names):
            answer = f"{meant(pattern, names)}; there are {', '.join(names)}"
            raise ValueError(f"no sensitivities of {pattern!r}{answer}")
    chosen = [n for n in names if any(fnmatchcase(n, pattern) for pattern in metrics)]
    if len(chosen) > MOST:
        raise ValueError(f"metrics: {len(chosen)} are chosen, a page has room for {MOST}")
    return chosen


def _panel(axes, words: str, sensitivities: Mapping) -> None:
    """Bars of one metric, the longest on top, and their errors."""
    names = sorted(sensitivities, key=lambda n: abs(sensitivities[n].change))
    metric_units = next(iter(sensitivities.values())).metric_units
    units, factor = shown_in(metric_units, [one.change for one in sensitivities.values()])
    for rank, name in enumerate(names):
        one = sensitivities[name]
        style = {} if one.trusted else UNCERTAIN
        change, error = factor * one.change, factor * one.change_error
        axes.barh(rank, -change, 0.7, color=SHRINKS, label=_once("- 1 %", rank), **style)
        axes.barh(rank, change, 0.7, color=GROWS, label=_once("+ 1 %", rank), **style)
        axes.errorbar(change, rank, xerr=error, color="black", capsize=2.0, lw=0.8)
    marks = [n if sensitivities[n].trusted else f"{n}\n(uncertain)" for n in names]
    axes.set_yticks(range(len(names)), marks)
    axes.axvline(0.0, color="black", linewidth=0.8)
    axes.set_xlabel(
        with_units(f"change of the {words.partition(', negative')[0]}", units), fontsize="small"
    )
    axes.locator_params(axis="x", nbins=7)


def _once(label: str, rank: int) -> str:
    """A label of the legend, for the first bar alone."""
    return label if rank == 0 else "_"
