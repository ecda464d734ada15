"""Pictures of designs: the map around an optimum with its limits, and the front of two goals."""

from functools import partial
from pathlib import Path

import numpy as np
from clearance.postprocess import figures
from clearance.postprocess.labels import shown_in
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
    label = figures.with_units(goal.name, design.known[goal.name].units)
    tables = {
        n: metric_of(swept, n, design).reshape(swept.shape).T
        for n in (goal.name, *(i.name for i in optimum.limits))
    }
    places, here, names = [], [], []
    for p in free:
        values = np.array(swept.definition.points.along[p.name])
        units, factor = shown_in(p.units, values)
        places.append(factor * values)
        here.append([factor * optimum.values[p.name]])
        names.append(figures.with_units(p.name, units))
    values, marks = tables[goal.name], {}
    if len(free) == 1:
        figures.line(axes, places[0], values, **figures.stroke(0, 1))
        rooms = [[limit.room(v) for v in tables[limit.name]] for limit in optimum.limits]
        inside = np.all(np.array(rooms).reshape(-1, values.size) >= 0.0, axis=0)
        here.append([optimum.metrics[goal.name]])
        # limits hold at the optimum, which lies between points of the map
        x = np.append(places[0], here[0])
        thick = np.append(np.where(inside, values, np.nan), here[1])
        order = np.argsort(x)
        figures.line(axes, x[order], thick[order], lw=3.0, color="0.2")
        axes.set_title("thick: limits hold", fontsize="small")
        names.append(label)
    else:
        borders = tuple(edges(v, p.positive) for v, p in zip(places, free, strict=True))
        mesh = figures.cells(axes, borders, values, figures.scale(values, figures.wide(values)))
        figures.colour_bar(figure, mesh, axes, label)
    for which, span, p in zip("xy", places, free, strict=False):
        if p.positive:
            getattr(axes, f"set_{which}scale")("log")
            figures.plain_decades(getattr(axes, f"{which}axis"), span[0], span[-1])
    for k, limit in enumerate(optimum.limits if len(free) == 2 else ()):
        table, level = tables[limit.name], limit.value + limit.sign * limit.margin
        inside = table[np.isfinite(table)]
        if inside.size and inside.min() < level < inside.max():
            style = {"color": "black", "lw": 1.4, "ls": ("-", "--", ":", "-.")[k % 4]}
            figures.border(axes, tuple(places), table, level, style)
            marks[limit.text] = style
    axes.plot(*here, **BEST)
    figures.finish(axes, names[1], names[0], legend=False)
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
    page, d = page_of(optimum), optimum.document()
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


def page_of(optimum: Optimum) -> Page:
    """The tables of the page of an optimum."""
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
    return page


def _unit(units: str) -> str:
    return "1" if units in ("?", "-") else units
