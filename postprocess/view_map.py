"""The map of a sweep for a page that moves: points, metrics, as many runs as there is room."""

from collections.abc import Iterable

import numpy as np
from clearance.postprocess.maps import chosen_metrics
from clearance.postprocess.moving import Moving, of_all, telling
from clearance.postprocess.pages import number, scaled

from clearance.results.record import Record
from clearance.sweeping.index import Sweep

#: characters that the runs of a page have room for, and turns that it has of each run
ROOM, TURNS = 24_000_000, 2.0


def of_sweep(sweep: Sweep, channels: str | Iterable[str] | None = None) -> tuple[dict, list[str]]:
    """Facts of the page of a sweep, and blocks of numbers of the runs in it.

    channels: curves of the runs, default the telling ones. The page has the last two turns of each
    run that has a file, of as many runs as there is room for, spread evenly.
    Raises ValueError for a sweep of which no point is done.
    """
    metrics = [*dict.fromkeys([*chosen_metrics(sweep, None), *sweep.metrics])]
    runs, blocks, where = _runs(sweep, channels)
    parameters = _parameters(sweep)
    wide = [p["name"] for p in parameters if len(p["values"]) > 1]
    axes = list(dict.fromkeys(p["axis"] for p in parameters if len(p["values"]) > 1))
    firsts = [
        next(p for p in parameters if p["axis"] == axis and p["name"] in wide) for axis in axes
    ]
    firsts = [p["name"] for p in sorted(firsts, key=lambda p: not p["numbers"])]
    if sweep.definition.points.drawn:
        firsts = wide
    if not firsts:
        raise ValueError(f"{sweep.folder}: nothing varies in this sweep; view its run")
    facts = {
        "x": firsts[0],
        "y": firsts[1] if len(firsts) > 1 else "",
        "metric": metrics[0],
        "drawn": bool(sweep.definition.points.drawn),
        "parameters": parameters,
        "metrics": [_metric(sweep, name) for name in metrics],
        "status": sweep.status.tolist(),
        "reason": sweep.reason.tolist(),
        "blocks": [where.get(i) for i in range(len(sweep))],
        "note": _note(sweep, len(where)),
    }
    first = list(dict.fromkeys(path for run in runs for path in run.facts["columns"]))
    title = f"{sweep.definition.case}: sweep {sweep.folder.absolute().name}"
    page = {"title": title, "first": first, "open": [0] if runs else [], "map": facts}
    return page | of_all(runs), blocks


def _note(sweep: Sweep, count: int) -> str:
    """Number of runs in the page, and the place of the others, in words."""
    if not sweep.definition.files:
        return "This sweep keeps no files of its runs, only metrics."
    words = "Click a point to open its run, shift and click to lay it over the others."
    if count == len(sweep):
        return words
    share = f"{count} of {len(sweep)} runs are in this page"
    return f"{words} {share}; clearance view shows each file in {sweep.folder.name}/runs."


def _parameters(sweep: Sweep) -> list[dict]:
    """Swept parameters with their values in order, and the place of each point among them."""
    entries = []
    for axis, (names, _) in enumerate(sweep.definition.points.axes):
        for name in sweep.definition.points.varying(names):
            column = sweep.columns[name]
            numbers = column.dtype.kind in "iuf"
            units = sweep.definition.units.get(name, "?")
            if numbers:
                values, index = np.unique(column, return_inverse=True)
                unit, factor = scaled(units, *map(float, values))
                values = (values * factor).tolist()
                text = [number(v, 4) for v in values]
            else:
                values, unit = list(dict.fromkeys(map(str, column))), ""
                index, text = np.array([values.index(str(v)) for v in column]), values
            label = name.replace("_", " ") + (f" [{unit}]" if unit else "")
            entries.append(
                {
                    "name": name,
                    "label": label,
                    "axis": axis,
                    "numbers": numbers,
                    "values": values,
                    "text": text,
                    "place": index.tolist(),
                }
            )
    return entries


def _metric(sweep: Sweep, name: str) -> dict:
    """Values of a metric in a unit that suits them; None where there is none."""
    units, text = sweep.known.get(name, ("?", name))
    values = np.where(sweep.done, sweep.metrics[name], np.nan)
    unit, factor = scaled(units, *map(float, values))
    short = name.replace("_", " ") + (f" [{unit}]" if unit else "")
    shown = [float(f"{v * factor:.6g}") if np.isfinite(v) else None for v in values]
    return {"name": name, "label": f"{short}: {text}", "short": short, "values": shown}


def _runs(
    sweep: Sweep, channels: str | Iterable[str] | None
) -> tuple[list[Moving], list[str], dict[int, int]]:
    """Runs in the page, their blocks, and the block of each point that has one."""
    runs, blocks, where, room = [], [], {}, ROOM
    having = [
        i
        for i in range(len(sweep))
        if sweep.definition.files and sweep.done[i] and sweep.path(i).exists()
    ]
    for i in _spread(having):
        with sweep.run(i) as record:
            if record.time.size < 2:
                continue
            run = Moving(
                record, _label(sweep, i), only=_channels(record, channels), begin=_begin(record)
            )
        text = run.pack.text()
        if len(text) > room:
            break
        room -= len(text)
        where[i] = len(runs)
        runs.append(run)
        blocks.append(text)
    return runs, blocks, where


def _spread(places: list[int]) -> list[int]:
    """Places in an order of which every beginning is spread over all of them."""
    count = len(places)
    order, step = [], 1 << max(count - 1, 0).bit_length()
    while step:
        order += range(0, count, step)
        step //= 2
    return [places[i] for i in dict.fromkeys(order)]


def _label(sweep: Sweep, i: int) -> str:
    units = sweep.definition.units
    parts = []
    for name, value in sweep.definition.points[i].items():
        unit, factor = (
            scaled(units.get(name, "?"), value) if isinstance(value, int | float) else ("", 1.0)
        )
        shown = number(value * factor, 4) if isinstance(value, int | float) else str(value)
        parts.append(f"{name.replace('_', ' ')} {shown} {unit}".strip())
    return ", ".join(parts)


def _channels(record: Record, channels: str | Iterable[str] | None) -> list[str]:
    if channels is None:
        return telling(record)
    return [n.strip() for n in channels.split(",")] if isinstance(channels, str) else list(channels)


def _begin(record: Record) -> float:
    """Time from which on the page has a run [s]."""
    end = float(record.time[-1])
    if record.turn is None:
        return 0.0
    return float(record.time_at(max(float(record.turns_at(end)) - TURNS, 0.0)))
