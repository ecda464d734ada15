"""Pictures of designs: the map around an optimum with its limits, and the front of two goals."""

from functools import partial
from pathlib import Path

import numpy as np
from clearance.postprocess import figures
from clearance.postprocess.maps import edges
from clearance.postprocess.pages import Page, element, number, points, quantity, table

from clearance.identify.designs import Optimum, metric_of
from clearance.sweeping.index import Sweep

BEST = {"marker": "*", "ms": 14, "mec": "black", "mfc": "white", "ls": "", "zorder": 5}


def picture(optimum: Optimum, output: str | Path | None = None, swept: Sweep | None = None):
    """The goal over the first two parameters with lines at the limits, or over the only one; the
    front of two goals beside it. swept: see `Optimum.mapped`.
    """
    panels = [p for p, there in ((_map, swept), (_front, optimum.front)) if there]
    figure = figures.sheet(6.0 * max(len(panels), 1), 4.4)
    rows = figure.subplots(1, max(len(panels), 1), squeeze=False)[0]
    marks: dict[str, dict] = {}
    for axes, draw in zip(rows, panels, strict=False):
        marks |= draw(figure, axes, optimum, swept) or {}
    if not panels:
        figures.note(rows[0], "no map")
    figures.legend_of_marks(figure, marks)
    return figures.save(figure, output)


def _map(figure, axes, optimum: Optimum, swept: Sweep) -> dict[str, dict]:
    """Cells of the goal and lines of the limits, or curves of both."""
    design, goal = optimum.design, optimum.goals[0]
    free = design.free[: len(swept.shape)]
    places = [np.array(swept.definition.points.along[p.name]) for p in free]
    label = figures.with_units(goal.name, design.known[goal.name].units)
    values = metric_of(swept, goal.name, design).reshape(swept.shape)
    names = [figures.with_units(p.name, p.units) for p in free]
    here = [optimum.values[p.name] for p in free]
    scales = ["log" if p.positive else "linear" for p in free]
    axes.set_xscale(scales[0])
    if len(free) == 1:
        figures.line(axes, places[0], values, **figures.stroke(0, 1))
        axes.plot(here, [optimum.metrics[goal.name]], **BEST)
        inside = np.ones(len(values), bool)
        for limit in optimum.limits:
            reached = metric_of(swept, limit.name, design)
            inside &= np.array([limit.room(v) >= 0.0 for v in reached])
        figures.line(axes, places[0], np.where(inside, values, np.nan), lw=3.0, color="0.2")
        figures.finish(axes, label, names[0], legend=False)
        axes.set_title("thick: limits hold", fontsize="small")
        return {}
    borders = [edges(v, p.positive) for v, p in zip(places, free, strict=True)]
    norm = figures.scale(values, figures.wide(values))
    mesh = figures.cells(axes, tuple(borders), values.T, norm)
    axes.set_yscale(scales[1])
    marks = {}
    for k, limit in enumerate(optimum.limits):
        table = metric_of(swept, limit.name, design).reshape(swept.shape).T
        level = limit.value + limit.sign * limit.margin
        inside = table[np.isfinite(table)]
        if inside.size and inside.min() < level < inside.max():
            style = {"color": "black", "lw": 1.4, "ls": ("-", "--", ":", "-.")[k % 4]}
            figures.border(axes, tuple(places), table, level, style)
            marks[limit.text] = style
    axes.plot(here[:1], here[1:], **BEST)
    figures.finish(axes, names[1], names[0], legend=False)
    figures.colour_bar(figure, mesh, axes, label)
    return marks


def _front(figure, axes, optimum: Optimum, swept: Sweep | None) -> None:
    """Values of both goals of the designs of a front."""
    design = optimum.design
    points = [design.point(e.x).values for e in optimum.front]
    x, y = (np.array([p[g.name] for p in points]) for g in optimum.goals)
    axes.plot(x, y, marker="o", **figures.stroke(0, 1))
    labels = [figures.with_units(g.name, design.known[g.name].units) for g in optimum.goals]
    figures.finish(axes, labels[1], labels[0], legend=False)


def report(optimum: Optimum, output: str | Path, swept: Sweep | None = None) -> Path:
    """Write the page of an optimum."""
    path = Path(output)
    if path.suffix.lower() not in (".html", ".htm"):
        raise ValueError(f"report {path}: its name must end in .html")
    d, about = optimum.document(), optimum.design.known
    page = Page(f"{optimum.design.scene.name}: {', '.join(d['goals'])}")
    page.head = element("h1", page.title)
    rows = [
        (n, quantity(p["value"], _unit(p["units"])), " to ".join(map(number, p["bounds"])))
        for n, p in d["parameters"].items()
    ]
    page.section("Parameters", table(("parameter", "value", "bounds [SI]"), rows))
    rows = [
        (n, quantity(m["value"], _unit(m["units"])), about[n].text) for n, m in d["metrics"].items()
    ]
    page.section("Metrics", table(("metric", "value", "meaning"), rows))
    rows = [
        (i["limit"], number(i["value"]), number(i["margin"]), "yes" if i["active"] else "no")
        for i in d["limits"]
    ]
    heads = ("limit", "value", "margin", "active")
    page.section("Limits", table(heads, rows), points([*d["words"], *d["doubts"]]))
    drawn = partial(optimum.plot, swept=swept)
    page.section(
        "Map and front", page.picture(drawn, "The goal around the optimum, with its limits")
    )
    names = [*d["parameters"], *d["metrics"]]
    for title, ends in (("Optima", d["optima"]), ("Front", d["front"])):
        rows = [
            tuple(map(number, (*e["parameters"].values(), *e["metrics"].values()))) for e in ends
        ]
        if rows:
            page.section(title, table(names, rows))
    return page.save(path)


def _unit(units: str) -> str:
    return "1" if units in ("?", "-") else units
