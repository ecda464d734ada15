"""The report of a sweep: what was swept, what came of it, where its metrics are extreme, and what
it cost.
"""

import os
from functools import partial
from pathlib import Path
from urllib.parse import quote

import numpy as np
from clearance.postprocess import figures
from clearance.postprocess.labels import NO_BREAK
from clearance.postprocess.maps import by_ratio, chosen_metrics, curves, maps
from clearance.postprocess.pages import (
    ALIKE,
    Cell,
    Markup,
    Page,
    box,
    breakable,
    cell,
    date,
    element,
    facts,
    join,
    missing,
    number,
    quantity,
    scaled,
    table,
    valued,
)

from clearance.results.reading import open_checked
from clearance.sweeping.definition import FORMAT, FORMAT_VERSION
from clearance.sweeping.index import Sweep

#: most points in the table of all points, how many of more are shown, and most points that are not
#: done
MOST, FIRST, MOST_BAD = 500, 200, 100
#: most values along an axis for curves beside the maps
FEW = 6
BINS = 40


def sweep_page(sweep: Sweep, path: Path) -> Page:
    """The report of a sweep, not yet written; `path` is where it will be, for its links to run
    files.
    """
    page = Page(f"{sweep.definition.case}: report of the sweep {sweep.folder.absolute().name}")
    page.head = head(sweep)
    page.section("What was swept", *_swept(sweep))
    if not sweep.done.all():
        page.section("Points that are not done", *_bad(sweep))
    page.section("Extremes", *extremes(sweep))
    page.section("Over the parameters", *pictures(page, sweep), apart=True)
    page.section("Cost", *_cost(page, sweep))
    page.section("Points", *_points(sweep, path), apart=True)
    page.section("Provenance", *_provenance(sweep))
    return page


def head(sweep: Sweep) -> Markup:
    """Case and counts; what failed where it cannot be missed."""
    counts = {s: int((sweep.status == s).sum()) for s in ("done", "failed", "lost", "missing")}
    words = ", ".join(f"{n} {s}" for s, n in counts.items() if n or s == "done")
    title = element("h1", f"{sweep.definition.case}: sweep over {_axes(sweep)}")
    state = box(
        "good" if sweep.done.all() else "bad", element("b", f"{len(sweep)} points"), f": {words}"
    )
    doubtful = int((sweep.costs["warnings"] > 0).sum())
    if doubtful:
        total = int(sweep.costs["warnings"].sum())
        state = join(
            [
                state,
                box(
                    "doubt",
                    f"{doubtful} runs gave warnings, {total} in all: see the column of the points.",
                ),
            ]
        )
    return join([title, state])


def _axes(sweep: Sweep) -> str:
    """Swept quantities in a line."""
    axes = []
    for names, count in sweep.definition.points.axes:
        varying = sweep.definition.points.varying(names)
        drawn = f"{count} samples of {', '.join(varying)}"
        axes.append(drawn if varying != names else f"{' with '.join(varying)} ({count})")
    return " × ".join(axes) or "one point"


def _swept(sweep: Sweep) -> list[Markup]:
    """Axes with their values, what all points share, and how they were run."""
    d, rows = sweep.definition, []
    for names, _ in d.points.axes:
        varying = d.points.varying(names)
        drawn = varying != names
        for name in varying:
            values = list(dict.fromkeys(d.points.columns[name]))
            together = ", ".join(n for n in varying if n != name)
            how = (
                "drawn"
                if drawn
                else _spacing(values) + (f", together with {together}" if together else "")
            )
            units = d.units.get(name, "?")
            plain = f"{_values(values, '1')} {ALIKE.get(units, units)}".strip()
            rows.append([name, len(values), _values(values, units), plain, how])
    head = ["parameter", "number", "values", "in SI units", "how"]
    axes = table(head, rows) if rows else element("p", "One point.")
    options = [(n.replace("_", " "), v) for n, v in d.options.items() if v is not None]
    settle = "the first, where there is a second" if d.settle is None else d.settle
    options.append(("turns left out of the metrics", settle))
    options.append(
        (
            "channels in run files",
            "all" if d.keep is None else ", ".join(d.keep) or "none: summaries only",
        )
    )
    if d.own:
        options.append(("metrics of one's own", ", ".join(reference for reference, _ in d.own)))
    same = (
        facts(d.fixed.items()) if d.fixed else element("p", "Nothing but the defaults of the case.")
    )
    return [
        axes,
        element("h3", "The same at all points (SI units)"),
        same,
        element("h3", "Runs"),
        facts(options),
    ]


def _spacing(values: list) -> str:
    if any(isinstance(v, str | bool) for v in values) or len(values) < 3:
        return "listed"
    ordered = np.sort(np.array(values, float))
    steps = np.diff(np.log(ordered)) if by_ratio(ordered) else np.diff(ordered)
    if np.ptp(steps) > 1e-6 * steps.mean():
        return "listed"
    return "by even ratios" if by_ratio(ordered) else "by even steps"


def _values(values: list, units: str) -> str:
    """Values of a parameter in words: all of a few and all texts, else the smallest and the
    largest.
    """
    if any(isinstance(v, str | bool) for v in values):
        return ", ".join(map(str, values))
    if len(values) <= 3:
        return ", ".join(quantity(v, units) for v in values)
    return f"{quantity(min(values), units)} to {quantity(max(values), units)}"


def _at(sweep: Sweep, i: int) -> str:
    """The parameters of a point in words."""
    units = sweep.definition.units
    parts = (
        f"{n} {_values([v], units.get(n, '?'))}" for n, v in sweep.definition.points[int(i)].items()
    )
    return ", ".join(part.replace(" ", NO_BREAK) for part in parts) or "the only point"


def _bad(sweep: Sweep) -> list[Markup]:
    bad = np.flatnonzero(~sweep.done)
    rows = [
        [int(i), _at(sweep, i), sweep.status[i], sweep.reason[i] or "not run yet"]
        for i in bad[:MOST_BAD]
    ]
    more = (
        element("p", f"And {len(bad) - MOST_BAD} more, see sweep.h5.")
        if len(bad) > MOST_BAD
        else ""
    )
    return [table(["point", "at", "status", "reason"], rows, sortable=True), more]


def extremes(sweep: Sweep) -> list[Markup]:
    """Smallest and largest finite value of every metric, and where they are."""
    rows = []
    for name, values in sweep.metrics.items():
        units, text = sweep.known.get(name, ("?", name))
        finite = np.where(np.isfinite(values) & sweep.done, values, np.nan)
        label = join([text, " ", element("code", breakable(name))])
        if np.isnan(finite).all():
            rows.append([label, "", None, "", None, ""])
            continue
        low, high = int(np.nanargmin(finite)), int(np.nanargmax(finite))
        shown, factor = scaled(units, finite[low], finite[high])
        least, most = (valued(finite[i], number(finite[i] * factor)) for i in (low, high))
        places = (
            ["everywhere"] * 2
            if finite[low] == finite[high]
            else [_at(sweep, low), _at(sweep, high)]
        )
        rows.append([label, shown, least, places[0], most, places[1]])
    if not rows:
        return [missing("No point has a metric yet.")]
    endless = [n for n, v in sweep.metrics.items() if np.isinf(v[sweep.done]).any()]
    words = (
        element("p", f"Infinite values are left out here, those of {', '.join(endless)}.")
        if endless
        else ""
    )
    return [words, table(["what", "units", "smallest", "at", "largest", "at"], rows, sortable=True)]


def pictures(page: Page, sweep: Sweep) -> list[Markup]:
    """Maps over two parameters of a grid, curves over one or few values and over samples."""
    if not sweep.done.any():
        return [missing("No point is done: there is nothing to draw.")]
    wide = [n for n in sweep.shape if n > 1]
    if not wide:
        return [missing("Nothing varies: there is nothing to draw.")]
    drawn = sweep.definition.points.drawn
    parts = []
    if len(wide) > 1 and not drawn:
        parts.append(page.picture(partial(maps, sweep), "Metrics over two parameters"))
    if len(wide) == 1 or drawn or min(wide) <= FEW:
        parts.append(page.picture(partial(curves, sweep), "Metrics over a parameter"))
    return parts


def _cost(page: Page, sweep: Sweep) -> list[Markup]:
    """Wall time in all, in the compiled loop, and how it is distributed."""
    ran = sweep.costs["wall"] > 0.0
    if not ran.any():
        return [missing("No point has been run.")]
    wall, loop = (sweep.costs[n][ran] for n in ("wall", "loop"))
    steps = sweep.costs["steps"][sweep.done]
    longest = int(np.flatnonzero(ran)[np.argmax(wall)])
    rows = [
        ("runs", int(ran.sum())),
        ("wall time of all runs, one after the other", quantity(wall.sum(), "s")),
        ("of it in the compiled loop", quantity(loop.sum(), "s")),
        ("a run, median", quantity(float(np.median(wall)), "s")),
        ("longest run", f"{quantity(wall.max(), 's')}, at {_at(sweep, longest)}"),
    ]
    if steps.size:
        words = (
            f"{number(steps.min())} to {number(steps.max())}, median "
            f"{number(float(np.median(steps)))}"
        )
        rows.append(("steps of a run that is done", words))
    drawn = page.picture(
        partial(costs, sweep), "Wall time of the runs, and of it in the compiled loop"
    )
    return [facts(rows), drawn]


def costs(sweep: Sweep, path: str | Path) -> Path:
    """Histograms of the wall time of the runs and of their time in the compiled loop [s], saved
    under `path`.
    """
    figure = figures.sheet(7.0, 2.6)
    axes = figure.add_subplot()
    times = {n: v[v > 0.0] for n, v in ((n, sweep.costs[n]) for n in ("wall", "loop"))}
    every = np.concatenate(list(times.values()))
    low, high = 0.99 * every.min(), 1.01 * every.max()
    edges = np.geomspace(low, high, int(np.clip(2.0 * np.sqrt(len(every)), 5, BINS)) + 1)
    styles = {
        "wall": {"color": "0.75"},
        "loop": {"color": "#d55e00", "histtype": "step", "lw": 1.2},
    }
    labels = {"wall": "in all", "loop": "in the compiled loop"}
    for name, values in times.items():
        axes.hist(values, edges, label=labels[name], **styles[name])
    axes.set_xscale("log")
    figures.plain_decades(axes.xaxis, low, high)
    axes.locator_params(axis="y", integer=True)
    figures.finish(axes, "runs [-]", "wall time [s]")
    return figures.save(figure, path)


def _points(sweep: Sweep, path: Path) -> list[Markup]:
    """A row a point: parameters, status, telling metrics, cost, and a link to its run file."""
    shown = len(sweep) if len(sweep) <= MOST else FIRST
    units, described = sweep.definition.units, {n: k[0] for n, k in sweep.known.items()}
    measured = any(np.isfinite(v[sweep.done]).any() for v in sweep.metrics.values())
    names = chosen_metrics(sweep, None) if measured else []
    values = {n: np.where(sweep.done, sweep.metrics[n], np.nan) for n in names}
    columns = [("point", [cell(i) for i in range(shown)])]
    columns += [_column(v, n, units.get(n, "?"), shown) for n, v in sweep.columns.items()]
    columns += [("status", [cell(_status(sweep, i, path)) for i in range(shown)])]
    columns += [_column(v, n, described.get(n, "?"), shown) for n, v in values.items()]
    columns += [_column(sweep.costs["wall"], "wall time", "s", shown)]
    columns += [("warnings", [cell(int(w)) for w in sweep.costs["warnings"][:shown]])]
    listed = table(
        [head for head, _ in columns],
        zip(*(cells for _, cells in columns), strict=True),
        sortable=True,
    )
    index = f"{sweep.folder.absolute().name}/sweep.h5"
    words = f"All metrics of all points are in {index}."
    if shown < len(sweep):
        words = (
            f"The first {shown} of {len(sweep)} points; all of them, with all metrics, are in "
            f"{index}."
        )
    links = (
        " A status that is a link leads to the file of its run." if sweep.definition.files else ""
    )
    return [element("p", words + links), listed]


def _column(values: np.ndarray, name: str, units: str, shown: int) -> tuple[Markup, list[Cell]]:
    """Head and first cells of a column, in units that suit its largest value."""
    if values.dtype.kind not in "iuf":
        return breakable(name), [cell(str(v)) for v in values[:shown]]
    unit, factor = scaled(units, *map(float, values))
    head = breakable(f"{name} [{unit.replace(' ', NO_BREAK)}]" if unit else name)
    return head, [
        valued(float(v), number(v if factor == 1.0 else v * factor)) for v in values[:shown]
    ]


def _status(sweep: Sweep, i: int, path: Path) -> object:
    """The status of a point, a link where its run has a file."""
    status = str(sweep.status[i])
    if not sweep.definition.files or not (file := sweep.path(i)).exists():
        return status
    target = os.path.relpath(file.absolute(), path.absolute().parent)
    return element("a", status, href=quote(Path(target).as_posix()))


def _provenance(sweep: Sweep) -> list[Markup]:
    """Sources of the numbers, and notes for their reader."""
    d, index, folder = sweep.definition, sweep.folder / "sweep.h5", sweep.folder.absolute().name
    rows = [
        ("directory", folder),
        ("case", d.path),
        ("digest of its source", element("code", d.source)),
    ]
    if about := _about(index):
        rows += [
            ("format", f"{about['format']} {about['format_version']}"),
            ("index written", date(about["created"])),
        ]
        rows += [
            (n.replace("_", " of ", 1), v) for n, v in about.items() if n.startswith("version_")
        ]
    first = next(iter(sweep.metrics), "")
    lines = (
        "import clearance as cl",
        f"sweep = cl.open_sweep({folder!r})",
        f"sweep.metrics[{first!r}], sweep.dataset",
    )
    how = "\n".join(lines)
    return [facts(rows), element("h3", "In Python"), element("pre", how)]


def _about(index: Path) -> dict:
    """Attributes of an index; none of one that is not there or cannot be read, which a sweep does
    without.
    """
    try:
        with open_checked(index, "sweep index", FORMAT, FORMAT_VERSION) as file:
            about = file.attributes()
            return about if {"format_version", "created"} <= set(about) else {}
    except (OSError, ValueError):
        return {}
