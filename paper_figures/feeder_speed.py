"""Influence of the crank's speed on the six-bar feeder with five models of joint B.

Group: feeder

Answers: Jin et al. (2023), slider acceleration and joint force at several crank speeds, with dry,
lubricated and transitional clearance. The source states that impacts grow with speed.

Reproduced: curves over a turn at 150, 300 and 600 rpm, over the ideal mechanism's largest value
there. Over 60 to 900 rpm: the largest force of a turn in joint B, the acceleration of the slider
and its excess over the ideal slider. Also the smallest film thickness ratio, contacts and energy
lost; clearance 0.2 mm. Each picture has the growth of every model and where the source's statement
is met. The transitional joint stands there with rigid and with elastic surfaces. Ideal forces grow
with the square of the speed; the transitional joint's grow faster.

Assumed: parameter set feeder-A, restitution 0.9, friction coefficient 0.1, oil of 5 mPa s,
half-cosine memberships. Dry motion was irregular at all speeds that were looked at in longer runs
(60 to 900 rpm), so that neighbouring points of its sweep scatter. Largest values are located on the
dense output, turn by turn; shown are means over the turns, ten dry ones, with 95 % intervals.
Growth compares medians of the first and last fifth of the points.

Not comparable: the source's speeds and peaks, which were not in the part we had.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from clearance.paper_figures import workshop
from clearance.paper_figures.feeder_slider import (
    CLEARANCE,
    COMPARED,
    DRY,
    IDEAL,
    OIL,
    STYLES,
    conclude,
    feeder,
    of_turn,
    settled,
    turns_seen,
)
from clearance.postprocess.channels import abscissa
from clearance.postprocess.figures import finish, legend_below, line, marker, plain_decades, sheet

import clearance as cl

SPEEDS = (150, 300, 600)
CLAIM = "greater speed, greater impacts"
#: metrics of a sweep: name, label, whether its axis is logarithmic
METRICS = (
    ("joint_B_force_peak_mean", "largest force of a turn\nin joint B [N]", True),
    ("slider_acceleration_peak_mean", "largest acceleration of a\nturn, slider [m/s²]", True),
    ("slider_acceleration_deviation_rms", "rms acceleration beyond\nthe ideal slider [m/s²]", True),
    ("joint_B_film_thickness_ratio_min", "smallest film\nthickness ratio [-]", True),
    ("joint_B_impacts_per_turn", "contacts of dry joint\nin a turn [-]", False),
    ("dissipated_per_turn", "energy lost\nin a turn [J]", True),
)
#: ticks of the film thickness ratio, negative where solids penetrate
RATIOS = (-10, -1, 0, 0.5, 1, 3, 10)
#: turns and samples a turn of the dry runs of a sweep, of which SETTLE turns are left out
TURNS, PER_TURN, SETTLE = 12, 2000, 2


def draw(work: workshop.Workshop) -> None:
    speeds = np.linspace(60, 900, work.less(29, 4))
    runs = {f"{n} rpm": values(work, speed=cl.rpm(n)) for n in SPEEDS}
    work.keep(curves(runs, f"{SPEEDS[0]} to {SPEEDS[-1]} rpm", CLAIM))
    results = swept(work, {"clearance": CLEARANCE}, speed=[cl.rpm(n) for n in speeds])
    work.keep(influence(results, speeds, "crank speed [rpm]", CLAIM), "sweep")
    work.table(*rows(results, speeds, "rpm", SPEEDS), "sweep", "Nearest points of the sweep.")


def values(work: workshop.Workshop, **parameters) -> dict:
    """A run of each model at one point; the dry one needs more turns."""
    return {
        m: feeder(work, **model, **parameters, turns=TURNS if m == DRY else 4)
        for m, model in COMPARED.items()
    }


def swept(work: workshop.Workshop, fixed: Mapping, **along: Sequence[float]) -> dict:
    """Metrics by name, arrays over the points, for each model; the dry one needs more turns and
    samples.
    """
    metrics = {}
    for name, model in COMPARED.items():
        turns, samples = work.less(
            (TURNS, PER_TURN) if name == DRY else (SETTLE + 2, 2000), (SETTLE + 1, 1000)
        )
        options = {"turns": turns, "samples_per_turn": samples, "settle": SETTLE, "channels": []}
        options["fixed"] = {"viscosity": OIL} | dict(fixed) | model
        metrics[name] = work.sweep("six_bar_feeder", cl.grid(**along), **options).metrics
    return metrics


def curves(runs: dict, span: str, claim: str):
    """Acceleration and joint force over the last turn over the ideal ones, a row for each value;
    oil beside dry.
    """
    figure = sheet(10.0, 1.9 * len(runs) + 1.4)
    panels = figure.subplots(len(runs), 4, sharex=True, sharey="col")
    for row, (label, models) in zip(panels, runs.items(), strict=True):
        scales = [np.abs(curve).max() for curve in shown(models[IDEAL])]
        for name, run in models.items():
            angle, last, xlabel = abscissa(run, "angle", 1.0)
            for which, (y, scale) in enumerate(zip(shown(run), scales, strict=True)):
                panel = row[2 * which + (name == DRY)]
                line(panel, angle, y[last] / scale, **{"lw": 1.2, "label": name} | STYLES[name])
        for axes in row:
            finish(axes, "", "", legend=False)
        row[0].set_ylabel(label, fontweight="bold")
    heads = (
        f"slider acceleration / ideal\nall but {DRY}",
        DRY,
        f"force in joint B / ideal\nall but {DRY}",
        DRY,
    )
    for above, below, head in zip(panels[0], panels[-1], heads, strict=True):
        above.set_title(head, fontsize="medium")
        below.set_xlabel(xlabel)
        below.set(xlim=(0.0, 360.0), xticks=range(0, 361, 90))
    ends = [list(runs.values())[i] for i in (0, -1)]
    grown = {m: tuple(_largest(r[m]) for r in ends) for m in COMPARED}
    conclude(figure, f"Largest slider acceleration of a turn, {span}", grown, claim)
    figure.align_ylabels()
    legend_below(figure, *panels[0, :2])
    return figure


def _largest(run) -> float:
    """Largest acceleration of the slider in a turn, mean over the settled ones."""
    return of_turn(run["slider"].ax[settled(run)], turns_seen({"": run}))


def shown(run) -> tuple[np.ndarray, np.ndarray]:
    """Acceleration of the slider and force in joint B."""
    return run["slider"].ax, np.hypot(*run.joint("B").force.T)


def influence(results: dict, at: np.ndarray, label: str, claim: str, log: bool = False):
    """Metrics over the swept value, a curve for each model that has them."""
    figure = sheet(9.0, 9.0)
    panels = figure.subplots(3, 2, sharex=True)
    for axes, (metric, text, tall) in zip(panels.flat, METRICS, strict=True):
        for i, (name, metrics) in enumerate(results.items()):
            y = told(metrics, name, metric)
            if y is None:
                continue
            axes.plot(
                at, y, **STYLES[name] | {"lw": 0.9, "label": name, "marker": marker(i), "ms": 3.0}
            )
            if f"{metric}_half_width" in metrics:
                bars = {"ecolor": STYLES[name]["color"], "elinewidth": 0.7, "fmt": "none"}
                axes.errorbar(at, y, metrics[f"{metric}_half_width"], **bars)
        finish(axes, text, "", legend=False)
        axes.set_yscale("log" if tall else "linear")
        if metric == "joint_B_film_thickness_ratio_min":
            for threshold in (1.0, 3.0):
                axes.axhline(threshold, color="0.5", lw=0.7, ls=":")
            axes.set_yscale("symlog", linthresh=0.5)
            axes.set_yticks(RATIOS, [f"{r:g}" for r in RATIOS])
    for axes in panels[-1]:
        axes.set_xlabel(label)
    if log:
        panels[0, 0].set_xscale("log")
        plain_decades(panels[0, 0].xaxis, at[0], at[-1])
    grown = {
        name: ends(metrics["slider_acceleration_peak_mean"]) for name, metrics in results.items()
    }
    quantity, _, units = label.partition(" [")
    span = f"{quantity} {at[0]:g} to {at[-1]:g} {units.rstrip(']')}"
    conclude(figure, f"Largest slider acceleration of a turn, {span}", grown, claim)
    figure.align_ylabels()
    legend_below(figure, panels[0, 0])
    return figure


def ends(values: np.ndarray) -> tuple[float, float]:
    """Medians of the first and of the last fifth of the points."""
    fifth = max(len(values) // 5, 1)
    return float(np.median(values[:fifth])), float(np.median(values[-fifth:]))


def told(metrics: dict, model: str, metric: str) -> np.ndarray | None:
    """Values of a metric where it has a meaning for a model."""
    film, contacts = (
        metric.endswith("film_thickness_ratio_min"),
        metric.endswith("impacts_per_turn"),
    )
    beyond = metric.endswith(("deviation_rms", "dissipated_per_turn"))
    if (film and model == DRY) or (contacts and model != DRY) or (beyond and model == IDEAL):
        return None
    value = metrics.get(metric)
    return value if value is not None and np.isfinite(value).any() else None


def rows(
    results: dict, at: np.ndarray, units: str, chosen: Sequence[float]
) -> tuple[list[str], list[list]]:
    """Heads and rows of the metrics at the swept points nearest to those chosen."""
    heads = [
        "joint B",
        units,
        *(text.replace("\n", " ").replace("²", "2") for _, text, _ in METRICS),
    ]
    table = []
    for name, metrics in results.items():
        for i in dict.fromkeys(int(np.abs(np.log(at / c)).argmin()) for c in chosen):
            columns = [told(metrics, name, m) for m, *_ in METRICS]
            table.append(
                [name, f"{at[i]:.3g}", *("-" if c is None else float(c[i]) for c in columns)]
            )
    return heads, table
