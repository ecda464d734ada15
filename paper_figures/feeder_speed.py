"""Influence of the crank's speed on the six-bar feeder with joint B dry, lubricated and mixed.

Group: feeder

Answers: Jin et al. (2023), slider acceleration and joint force at several crank speeds, dry and with lubricated
clearance.

Reproduced: curves over a turn at 150, 300, 600 and 900 rpm, and over 60 to 900 rpm the largest force in joint B, the
largest acceleration of the slider, what it accelerates beyond the ideal slider, the smallest film thickness ratio,
contacts and energy lost; clearance 0.1 mm. The mixed joint has an oil of 5 mPa s and shares its load between film and
asperities.

Assumed: parameter set feeder-A, restitution 0.9, friction coefficient 0.1, oil of 50 mPa s (lubricated). Dry motion
was irregular at all speeds that were looked at in longer runs (60 to 900 rpm), so that neighbouring points of its
sweep scatter: extremes are those of six turns. Forces of contacts are the peaks of their events; largest accelerations
are located on the dense output.

Not comparable: the source's speeds and peaks, which were not in the part we had.
"""

from collections.abc import Sequence

import numpy as np
from clearance.paper_figures import workshop
from clearance.paper_figures.feeder_slider import STYLES, feeder
from clearance.postprocess.channels import abscissa
from clearance.postprocess.figures import finish, legend_below, line, marker, plain_decades, sheet

import clearance as cl

SPEEDS = (150, 300, 600, 900)
#: models of a sweep: name -> parameters, and how it is drawn
MODELS = {
    "ideal": ({"model": "ideal"}, STYLES["ideal"]),
    "dry": ({"model": "dry"}, STYLES["dry"]),
    "lubricated": ({"model": "lubricated"}, STYLES["lubricated"]),
    "mixed, 5 mPa s": ({"model": "mixed", "viscosity": 0.005}, STYLES["mixed, 2 mPa s"]),
}
#: metrics of a sweep: name, label, whether its axis is logarithmic
METRICS = (
    ("joint_B_force_max", "largest force\nin joint B [N]", True),
    ("slider_acceleration_extreme", "largest acceleration\nof the slider [m/s²]", True),
    ("slider_acceleration_deviation_rms", "rms acceleration beyond\nthe ideal slider [m/s²]", True),
    ("joint_B_film_thickness_ratio_min", "smallest film\nthickness ratio [-]", True),
    ("joint_B_impacts_per_turn", "contacts of dry joint\nin a turn [-]", False),
    ("dissipated_per_turn", "energy lost\nin a turn [J]", True),
)
#: turns and samples a turn of the dry runs of a sweep, of which SETTLE turns are left out
TURNS, PER_TURN, SETTLE = 8, 12000, 2


def draw(work: workshop.Workshop) -> None:
    speeds = np.linspace(60, 900, work.less(29, 4))
    runs = {f"{n} rpm": values(work, speed=cl.rpm(n)) for n in work.less(SPEEDS, SPEEDS[1:3])}
    work.keep(curves(runs))
    found = swept(work, speed=[cl.rpm(n) for n in speeds])
    work.keep(influence(found, speeds, "crank speed [rpm]"), "sweep")
    work.table(*rows(found, speeds, "rpm", SPEEDS), "sweep", "Nearest points of the sweep.")


def values(work: workshop.Workshop, **parameters) -> dict:
    """A run of each of three models at one point; the mixed ones are left to the sweep."""
    return {m: feeder(work, **MODELS[m][0], **parameters, turns=4) for m in ("ideal", "dry", "lubricated")}


def swept(work: workshop.Workshop, **along: Sequence[float]) -> dict:
    """Metrics by name, arrays over the points, for each model; the dry one needs more turns and samples."""
    found = {}
    for names in (["dry"], [n for n in MODELS if n != "dry"]):
        parameters = [{"viscosity": 0.05} | MODELS[n][0] for n in names]
        models = cl.zipped(**{k: [p[k] for p in parameters] for k in ("model", "viscosity")})
        turns, samples = work.less((TURNS, PER_TURN) if "dry" in names else (SETTLE + 2, 2000), (SETTLE + 1, 1000))
        options = {"turns": turns, "samples_per_turn": samples, "settle": SETTLE, "channels": []}
        sweep = work.sweep("six_bar_feeder", models * cl.grid(**along), **options)
        for name, p in zip(names, parameters, strict=True):
            own = {metric: v[sweep.columns["model"] == p["model"]] for metric, v in sweep.metrics.items()}
            both = [np.abs(own[f"slider_acceleration_{side}"]) for side in ("min", "max")]
            found[name] = own | {"slider_acceleration_extreme": np.maximum(*both)}
    return {name: found[name] for name in MODELS}


def curves(runs: dict):
    """Acceleration and joint force over the last turn, a row for each value; with oil beside dry."""
    figure = sheet(10.0, 1.9 * len(runs) + 0.8)
    panels = figure.subplots(len(runs), 4, sharex=True)
    for row, (said, models) in zip(panels, runs.items(), strict=True):
        for name, run in models.items():
            angle, last, xlabel = abscissa(run, "angle", 1.0)
            shown = {"lw": 1.2, "label": name} | MODELS[name][1]
            curve = (run["slider"].ax, np.hypot(*run.joint("B").force.T))
            for which, y in enumerate(curve):
                place = row[2 * which + (name == "dry")]
                line(place, angle, y[last], **shown)
        for axes in row:
            finish(axes, "", "", legend=False)
        row[0].set_ylabel(said, fontweight="bold")
    heads = ("slider acceleration [m/s²]\nideal, lubricated", "dry", "force in joint B [N]\nideal, lubricated", "dry")
    for above, below, head in zip(panels[0], panels[-1], heads, strict=True):
        above.set_title(head, fontsize="medium")
        below.set_xlabel(xlabel)
        below.set(xlim=(0.0, 360.0), xticks=range(0, 361, 90))
    figure.align_ylabels()
    legend_below(figure, *panels[0, :2])
    return figure


def influence(found: dict, at: np.ndarray, label: str, log: bool = False):
    """Metrics over the swept value, a curve for each model that has them."""
    figure = sheet(9.0, 8.4)
    panels = figure.subplots(3, 2, sharex=True)
    for axes, (metric, text, tall) in zip(panels.flat, METRICS, strict=True):
        for i, (name, metrics) in enumerate(found.items()):
            y = told(metrics, name, metric)
            if y is None:
                continue
            shown = MODELS[name][1] | {"lw": 0.9, "label": name, "marker": marker(i), "ms": 3.0}
            axes.plot(at, y, **shown)
        finish(axes, text, "", legend=False)
        axes.set_yscale("log" if tall else "linear")
        if metric == "joint_B_film_thickness_ratio_min":
            axes.axhline(1.0, color="0.5", lw=0.7, ls=":")
            axes.axhline(3.0, color="0.5", lw=0.7, ls=":")
            plain_decades(axes.yaxis, *axes.get_ylim())
    for axes in panels[-1]:
        axes.set_xlabel(label)
    if log:
        panels[0, 0].set_xscale("log")
        plain_decades(panels[0, 0].xaxis, at[0], at[-1])
    figure.align_ylabels()
    legend_below(figure, panels[0, 0])
    return figure


def told(metrics: dict, model: str, metric: str) -> np.ndarray | None:
    """Values of a metric where it says something of a model."""
    film, contacts = metric.endswith("film_thickness_ratio_min"), metric.endswith("impacts_per_turn")
    beyond = metric.endswith(("deviation_rms", "dissipated_per_turn"))
    if (film and model == "dry") or (contacts and model != "dry") or (beyond and model == "ideal"):
        return None
    found = metrics.get(metric)
    return found if found is not None and np.isfinite(found).any() else None


def rows(found: dict, at: np.ndarray, units: str, chosen: Sequence[float]) -> tuple[list[str], list[list]]:
    """Heads and rows of the metrics at the swept points nearest to those chosen."""
    heads = ["joint B", units, *(text.replace("\n", " ").replace("²", "2") for _, text, _ in METRICS)]
    table = []
    for name, metrics in found.items():
        for i in dict.fromkeys(int(np.abs(np.log(at / c)).argmin()) for c in chosen):
            columns = [told(metrics, name, m) for m, *_ in METRICS]
            table.append([name, f"{at[i]:.3g}", *("-" if c is None else float(c[i]) for c in columns)])
    return heads, table


if __name__ == "__main__":
    workshop.main(__file__)
