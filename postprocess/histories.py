"""Channels along time or along the turns of the drive, of one result or of several laid over each
other.
"""

from collections.abc import Iterable
from pathlib import Path

import numpy as np
from clearance.postprocess import figures
from clearance.postprocess.channels import abscissa, expand, series
from clearance.postprocess.labels import axis_label, headline, labels_of, several

from clearance.results.reading import Damaged
from clearance.results.record import Record

MOST_PANELS, COLUMN = 12, 6
#: samples up to which each is marked
FEW = 40


def histories(
    records: Record | Iterable[Record],
    path: str | Path,
    *,
    channels: str | Iterable[str],
    along: str = "time",
    last: float | None = None,
    labels: Iterable[str] | None = None,
) -> Path:
    """Histories of channels, one panel each, saved under `path`; every result is a curve in each
    panel.

    channels: names or patterns as in `clearance.postprocess.channels`; along: "time" [s], "turns"
        of the drive or its "angle" [deg]; last: only that many turns from the end; labels: names of
        the results (default: what differs).
    Raises ValueError for an unknown channel, more than 12 panels, or turns where no drive turns at
    constant speed.
    """
    records = several(records)
    labels, panels = labels_of(records, labels), _panels(records, channels)
    columns = 1 if len(panels) <= COLUMN else 2
    figure = figures.sheet(7.0, 1.1 + 1.7 * -(-len(panels) // columns))
    grid = figure.subplots(-(-len(panels) // columns), columns, sharex=True, squeeze=False)
    for axes, channel in zip(grid.T.flat, panels, strict=False):
        xlabel = _panel(axes, records, channel, labels, along, last)
        axes.margins(x=0.01)
    for axes in grid[:-1].flat:
        axes.set_xlabel("")
    if len(panels) < grid.size:
        grid[-1, -1].remove()
        grid[-2, -1].set_xlabel(xlabel)
        grid[-2, -1].tick_params(labelbottom=True)
    if along == "angle":
        figures.degrees(grid[0, 0], most=9 // columns)
    figure.suptitle(headline(records, labels), fontsize="medium")
    figure.align_ylabels()
    if len(records) > 1:
        figures.legend_below(figure, grid[0, 0])
    return figures.save(figure, path)


def _panels(records: list[Record], channels: str | Iterable[str]) -> list[str]:
    """Paths of the channels that at least one result has."""
    shown, missing = [], None
    names = [channels] if isinstance(channels, str) else list(channels)
    if not names:
        raise ValueError("channels: give at least one")
    for name in names:
        hits = []
        for record in records:
            try:
                hits += expand(record, name)
            except Damaged:
                raise
            except ValueError as error:
                missing = error
        if not hits:
            raise missing
        shown += hits
    shown = list(dict.fromkeys(shown))
    if len(shown) > MOST_PANELS:
        raise ValueError(f"channels {names} are {len(shown)}; a page has room for {MOST_PANELS}")
    return shown


def _panel(
    axes, records: list[Record], channel: str, labels: list[str], along: str, last: float | None
) -> str:
    """Draw a channel of every result that has it; the label of the x axis."""
    missing = []
    for i, (record, label) in enumerate(zip(records, labels, strict=True)):
        x, part, xlabel = abscissa(record, along, last)
        style = figures.stroke(i, len(records)) | {
            "label": label,
            "marker": "." if len(x) <= FEW else "",
        }
        try:
            values, units, named = series(record, channel)
        except Damaged:
            raise
        except ValueError:
            missing.append(label)
            x, values = np.zeros(0), np.zeros(0)
        else:
            values = values[part]
        figures.line(axes, x, values, **style)
    figures.finish(axes, axis_label(named, units), xlabel, legend=False)
    if missing:
        axes.set_title(f"not in {', '.join(missing)}", fontsize="small", loc="right", color="0.3")
    if not any(len(line.get_xdata()) for line in axes.lines):
        figures.note(axes, "no samples")
    return xlabel
