"""Pictures and pages of a mechanism's fit: records over what was fitted, residuals, regions."""

import math
from itertools import combinations
from pathlib import Path

import numpy as np
from clearance.postprocess import figures
from clearance.postprocess.pages import Page, element, facts, number, points, quantity, table

from clearance.identify.scene_parameters import SceneFit

FEW = 1500  # values up to which each is a dot
PAIRS = 3  # regions of pairs of parameters, at most
CHI = math.sqrt(5.991464547107979)  # 95 % of two parameters together
MEASURED = {"color": "#e0a800"}


def picture(fit: SceneFit, output: str | Path | None = None):
    """Records over what was fitted, their residuals, and 95 % regions of pairs of parameters."""
    pairs = _pairs(fit)
    count = len(fit.curves)
    figure = figures.sheet(9.0, 2.6 * count + (2.8 if pairs else 0.4))
    grid = figure.add_gridspec(count + bool(pairs), 1)
    for row, (curve, computed) in enumerate(fit.curves):
        curves, right = grid[row].subgridspec(1, 2, width_ratios=(1.7, 1.0)).subplots()
        record = curve.measured
        x, label = record.x, "time [s]"
        if record.along == "angle":
            x, label = 360.0 * record.x, "angle of the drive [deg]"
        few = len(x) <= FEW
        dots = {"marker": "." if few else "", "ms": 3, "ls": "" if few else "-"}
        figures.line(curves, x, record.values, label=record.path.name, **dots, **MEASURED)
        figures.line(curves, x, computed, label="fitted", lw=1.0, **figures.stroke(0, 1))
        figures.line(right, x, computed - record.values, color="0.3", lw=0.6)
        unit = "" if record.units == "?" else f" [{record.units}]"
        figures.finish(curves, f"{curve.channel}{unit}", label)
        figures.finish(right, f"fitted less measured{unit}", label, legend=False)
    if pairs:
        panels = grid[count].subgridspec(1, len(pairs)).subplots(squeeze=False)[0]
        for axes, (i, j) in zip(panels, pairs, strict=True):
            _region(axes, fit, i, j)
    return figures.save(figure, output)


def _pairs(fit: SceneFit) -> list[tuple[int, int]]:
    """Pairs of parameters with intervals, the most correlated first."""
    seen = [k for k, i in enumerate(fit.verdict.intervals) if math.isfinite(i.low)]
    pairs = combinations(seen, 2)
    return sorted(pairs, key=lambda p: -abs(fit.verdict.correlation[p]))[:PAIRS]


def _region(axes, fit: SceneFit, i: int, j: int) -> None:
    """The 95 % region of two parameters, from their covariance in the searched coordinates."""
    free, x = [fit.problem.free[k] for k in (i, j)], fit.best.x[[i, j]]
    powers, directions = np.linalg.eigh(fit.verdict.covariance[np.ix_([i, j], [i, j])])
    angle = np.linspace(0.0, 2.0 * math.pi, 181)
    circle = np.stack([np.cos(angle), np.sin(angle)])
    around = x[:, None] + CHI * directions @ (np.sqrt(np.maximum(powers, 0.0))[:, None] * circle)
    curves = [[f.value(v) for v in row] for f, row in zip(free, around, strict=True)]
    figures.trajectory(axes, *map(np.array, curves), color="0.2", lw=1.0)
    axes.plot(*([f.value(float(v))] for f, v in zip(free, x, strict=True)), "+", color="0.2")
    labels = [f"{f.name} [{f.units}]" for f in free]
    figures.finish(axes, labels[1], labels[0], legend=False)
    axes.set_title(f"correlation {fit.verdict.correlation[i, j]:.2f}", fontsize="small")


def report(fit: SceneFit, output: str | Path) -> Path:
    """Write the page of a fit."""
    path = Path(output)
    if path.suffix.lower() not in (".html", ".htm"):
        raise ValueError(f"report {path}: its name must end in .html")
    return page_of(fit).save(path)


def page_of(fit: SceneFit, page: Page | None = None) -> Page:
    """The page of a fit, not yet written; page: to which it is added."""
    judged, page = fit.verdict, page or Page("")
    page.title = f"{fit.problem.scene.name}: fit to {len(fit.curves)} records"
    page.head = element("h1", page.title)
    rows = [
        (i.name, quantity(i.value, _unit(i.units)), _ends(i), i.kind, number(i.deviation))
        for i in judged.intervals
    ]
    heads = ("parameter", "value", "95 % interval", "interval by", "standard error")
    page.section("Parameters", table(heads, rows), points([*judged.products, *judged.doubts]))
    page.section("Record and fit", page.picture(fit.plot, "Records, fit, residuals and regions"))
    names = [i.name for i in judged.intervals]
    rows = [
        (name, *(f"{r:.3f}" for r in row[: len(names)]))
        for name, row in zip(names, judged.correlation, strict=False)
    ]
    page.section("Correlations", table(("", *names), rows))
    about = [(f"{n}: probability", f"{p:.3g}") for n, p in judged.tests.items()]
    about += [
        ("values", str(judged.samples)),
        ("independent values", f"{judged.facts:.0f}"),
        ("deviation of a residual over its error", f"{judged.noise:.4g}"),
    ]
    about += [(c.label, f"{c.channel}, {len(r)} values") for c, r in fit.curves]
    page.section("Checks", facts(about))
    ends = [
        (f"{e.cost:.6g}", *(f"{v:.5g}" for v in fit.problem.values(e.x).values())) for e in fit.ends
    ]
    page.section("Starts", table(("half the sum of squares", *names), ends))
    return page


def _unit(units: str) -> str:
    return "1" if units in ("?", "-") else units


def _ends(interval) -> str:
    if not math.isfinite(interval.low):
        return "none"
    return f"{number(interval.low)} to {number(interval.high)}"
