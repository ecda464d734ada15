"""Pictures of the evidence: error against run time, the stress matrix."""

from pathlib import Path

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

COLOURS = ("#0b3d91", "#c8102e", "#00843d", "#6a1b9a")
GREYS = ("#7f7f7f", "#b58900", "#2aa198", "#d33682", "#586e75", "#cb4b16", "#6c71c4", "#859900", "#93a1a1", "#000000")


def work_precision(study, path: str | Path) -> Path:
    """Error against run time, both logarithmic: own methods as thick lines, others thin and dashed."""
    figure = Figure(figsize=(8.0, 5.5), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    own = other = 0
    for c in study.curves:
        if not c.seconds:
            continue
        style = {"color": COLOURS[own % 4], "lw": 2.2, "marker": "o", "ms": 4}
        if not c.own:
            style = {"color": GREYS[other % 10], "lw": 1.0, "ls": "--", "marker": "sv^<>DPX*+"[other % 10], "ms": 4}
        own, other = own + c.own, other + (not c.own)
        axes.loglog(c.error, [1e3 * s for s in c.seconds], label=c.name, **style)
    axes.axvspan(axes.get_xlim()[0], max(study.doubt, axes.get_xlim()[0]), color="0.92", lw=0)
    axes.set_xlabel(f"error: largest deviation of {study.measure}")
    axes.set_ylabel("run time / ms")
    axes.invert_xaxis()
    axes.grid(True, which="major", color="0.9")
    axes.legend(fontsize=8, ncol=2)
    span = f"{study.turns:.3g} turns" if study.turns else f"{study.until:.3g} s"
    axes.set_title(f"{study.title}, {span}", fontsize=10)
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=130)
    return path
