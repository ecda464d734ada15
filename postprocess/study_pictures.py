"""Pictures of the evidence: error against run time, the stress matrix, Lyapunov exponents."""

import math
from pathlib import Path

# isort: off
from clearance.postprocess.sheets import sheet  # before matplotlib is imported

# isort: on
import numpy as np
from matplotlib import colormaps
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap, LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from clearance.files.locks import replacing

MARKERS = {"ideal": "D", "dry": "s", "lubricated": "o", "mixed": "^"}
COLOURS = ("#0b3d91", "#c8102e", "#00843d", "#6a1b9a")
GREYS = (
    "#7f7f7f",
    "#b58900",
    "#2aa198",
    "#d33682",
    "#586e75",
    "#cb4b16",
    "#6c71c4",
    "#859900",
    "#93a1a1",
    "#000000",
)


def saved(figure: Figure, path: str | Path) -> Path:
    """Write a picture of the kind of its name, completely or not at all; its folder is made."""
    path = Path(path)
    with replacing(path) as temporary:
        figure.savefig(temporary, dpi=130, format=path.suffix[1:])
    return path


def work_precision(study, path: str | Path) -> Path:
    """Error against run time, both logarithmic: own methods as thick lines, others thin and dashed.

    Beside it stated against true errors of the own methods: below the diagonal a statement would be
    too small.
    """
    figure = sheet(12.0, 5.2)
    axes, beside = figure.subplots(1, 2, width_ratios=(3, 2))
    ours = other = 0
    for c in study.curves:
        if not c.seconds:
            continue
        style = {"color": COLOURS[ours % 4], "lw": 2.2, "marker": "o", "ms": 4}
        if not c.own:
            style = {
                "color": GREYS[other % 10],
                "lw": 1.0,
                "ls": "--",
                "marker": "sv^<>DPX*+"[other % 10],
                "ms": 4,
            }
        ours, other = ours + c.own, other + (not c.own)
        axes.loglog(c.error, [1e3 * s for s in c.seconds], label=c.name, **style)
        if c.own:
            beside.loglog(c.error, c.stated, color=style["color"], lw=0.0, marker="o", ms=4)
    axes.axvspan(axes.get_xlim()[0], max(study.doubt, axes.get_xlim()[0]), color="0.92", lw=0)
    axes.set_xlabel(f"error: largest deviation of {study.measure}")
    axes.set_ylabel("CPU time of a run / ms")
    axes.invert_xaxis()
    axes.grid(True, which="major", color="0.9")
    axes.legend(fontsize=8, frameon=False)
    span = f"{study.turns:.3g} turns" if study.turns else f"{study.until:.3g} s"
    axes.set_title(f"{study.title}, {span}", fontsize=10)
    ends = [*beside.get_xlim(), *beside.get_ylim()]
    beside.loglog([min(ends), max(ends)], [min(ends), max(ends)], color="0.4", lw=1.0)
    beside.axvspan(min(ends), max(study.doubt, min(ends)), color="0.92", lw=0)
    beside.set_xlabel("true error")
    beside.set_ylabel("stated error")
    beside.set_title("own methods: stated, from the run at ten times the tolerance", fontsize=10)
    beside.grid(True, which="major", color="0.9")
    return saved(figure, path)


def stress(verdicts, path: str | Path) -> Path:
    """The stress matrix: colour is the energy residual, grey a named stop, black a fault."""
    shown = [v for v in verdicts if "random" not in v.row] or list(verdicts)
    rows, columns = (list(dict.fromkeys(getattr(v, n) for v in shown)) for n in ("row", "column"))
    figure = sheet(2.2 + 1.35 * len(columns), 1.6 + 0.27 * len(rows))
    axes = figure.add_subplot()
    colours = colormaps["viridis_r"]
    for v in shown:
        x, y = columns.index(v.column), rows.index(v.row)
        level = (math.log10(max(v.energy, 1e-14)) + 14.0) / 14.0 if v.kind == "done" else 0.0
        colour = {"done": colours(0.9 * level), "named": "0.75", "fault": "black"}[v.kind]
        axes.add_patch(Rectangle((x - 0.5, y - 0.5), 1, 1, color=colour, lw=0))
        text = (
            f"{v.energy:.0e}"
            if v.kind == "done"
            else "stops, named"
            if v.kind == "named"
            else "FAULT"
        )
        dark = v.kind == "fault" or v.kind == "done" and level > 0.55
        axes.text(
            x, y, text, ha="center", va="center", fontsize=7, color="white" if dark else "black"
        )
    axes.set_xticks(range(len(columns)), [c.replace(" ", "\n") for c in columns], fontsize=8)
    axes.set_yticks(range(len(rows)), rows, fontsize=8)
    axes.set_xlim(-0.5, len(columns) - 0.5)
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.set_title("energy residual over the energy turned over", fontsize=9)
    shades = colours(0.9 * np.linspace(0.0, 1.0, 256))
    scale = ScalarMappable(LogNorm(1e-14, 1.0), ListedColormap(shades))
    figure.colorbar(scale, ax=axes, label="energy residual", pad=0.02)
    return saved(figure, path)


def physics(study, path: str | Path) -> Path:
    """Distance from the finest choice of physics, and run time, a row for each choice; one colour a
    model.
    """
    shown = [c for c in study.choices if math.isfinite(c.distance)]
    figure = sheet(10.0, 1.4 + 0.23 * len(shown))
    distance, time = figure.subplots(1, 2, sharey=True)
    for row, c in enumerate(shown):
        style = {"color": COLOURS[list(MARKERS).index(c.model)], "ms": 6}
        if c.distance > 0.0:
            distance.semilogx(c.distance, row, MARKERS[c.model], **style)
        else:  # a logarithmic axis has no place for it
            position = {"transform": distance.get_yaxis_transform(), "va": "center", "fontsize": 8}
            distance.text(0.01, row, "0: the others are compared with it", **position)
        time.semilogx(1e3 * c.seconds, row, MARKERS[c.model], **style)
    distance.set_yticks(range(len(shown)), [c.name for c in shown], fontsize=8)
    distance.set_ylim(len(shown) - 0.5, -0.5)
    distance.set_xlabel(f"distance from '{study.finest}':\n{study.measure}")
    time.set_xlabel("CPU time of a run / ms")
    for axes in (distance, time):
        axes.grid(True, which="major", color="0.9")
        axes.set_axisbelow(True)
    figure.suptitle(study.title, fontsize=10)
    return saved(figure, path)


def lyapunov(exponents, path: str | Path) -> Path:
    """Running estimate of each exponent over turns, with the band of its error."""
    figure = sheet(9.0, 4.6)
    axes = figure.add_subplot()
    for i, (name, x) in enumerate(exponents.items()):
        turns, running, band = range(1, x.turns + 1), x.running, x.band
        colour = COLOURS[i] if i < 4 else GREYS[i % 10]
        axes.fill_between(turns, running - band, running + band, color=colour, alpha=0.18, lw=0)
        axes.plot(turns, running, color=colour, lw=1.4, label=f"{name}: {x}")
    axes.axhline(0.0, color="0.4", lw=0.8)
    ends = [v for x in exponents.values() for v in (x.running[-1], x.running[x.turns // 4])]
    room = 0.5 * (max(*ends, 0.0) - min(*ends, 0.0)) or 1.0
    # the first turns may lie far outside
    axes.set_ylim(min(*ends, 0.0) - room, max(*ends, 0.0) + room)
    axes.set_xlabel("turns after the transient")
    axes.set_ylabel("largest Lyapunov exponent per turn")
    axes.grid(True, which="major", color="0.9")
    axes.legend(fontsize=8, frameon=False)
    return saved(figure, path)


KINDS = {"trajectory": "trajectories", "extreme": "extremes", "mean": "means"}


def stated_against_true(rows, path: str | Path) -> Path:
    """Stated over true errors, both over the number or the clearance, a point a number; below the
    diagonal a statement would be too small.

    rows: with kind, stated and true.
    """
    figure = sheet(9.0, 4.6)
    kinds = sorted({r.kind for r in rows}, reverse=True)
    low = 10.0 ** math.floor(math.log10(min(r.true for r in rows)))
    high = 10.0 ** math.ceil(math.log10(max(r.stated for r in rows)))
    first = None
    for i, kind in enumerate(kinds):
        mine = [r for r in rows if r.kind == kind]
        axes = first = figure.add_subplot(1, len(kinds), i + 1, sharex=first, sharey=first)
        true, stated = (np.array([getattr(r, n) for r in mine]) for n in ("true", "stated"))
        axes.fill_between([low, high], [low, high], low, color="0.92", lw=0)
        axes.loglog([low, high], [low, high], color="0.4", lw=1.0)
        axes.plot(true, stated, ".", color=COLOURS[i % 4], ms=3, alpha=0.4, mew=0, rasterized=True)
        axes.set_title(
            f"{KINDS.get(kind, kind)}: {np.mean(stated >= true):.1%} of {len(mine)} covered",
            fontsize=10,
        )
        axes.set_xlabel("true error over the number [-]")
        axes.grid(True, which="major", color="0.9")
        axes.text(
            0.97,
            0.04,
            "stated too small",
            transform=axes.transAxes,
            ha="right",
            fontsize=8,
            color="0.35",
        )
        if i:
            axes.tick_params(labelleft=False)
    first.set_xlim(low, high)
    first.set_ylim(low, high)
    figure.axes[0].set_ylabel("stated error over the number [-]")
    return saved(figure, path)
