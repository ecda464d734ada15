"""Maps of the feeder over speed and clearance, with four models of joint B.

Group: feeder

Answers: Jin et al. (2023), the effect of speed and clearance on motion and joint forces. The source
shows it for a few values of each; here it is in maps of 20 by 20 runs.

Reproduced: trends. Over most of the map the dry joint multiplies forces and accelerations by ten
and more, and neighbouring points differ because its motion is irregular. Oil of 5 mPa s holds
forces near those of ideal joints until speed and clearance are so large that the film thins to the
roughness. The table has rank correlations with speed and clearance, and where the source's
statement is met that impacts grow with both.

Assumed: the parameter set feeder-A; runs of 4 turns (ideal, film only, transitional) and 41 turns
(dry), of which the first is left out. Largest values are those of a turn, means over the turns.

Not comparable: every amplitude; the source's lengths and masses are not in the part of it we had.
Dry points
scatter: half the 95 % interval of a mean over 40 turns is a sixth of it in the median, a third at
one point of ten. That is why they have rtol 1e-5.
"""

import numpy as np
from clearance.paper_figures import workshop
from clearance.paper_figures.feeder_slider import DRY, FILM, GROWN, IDEAL, MODELS, OIL, TRANSITIONAL
from clearance.postprocess.maps import maps
from scipy.stats import spearmanr

import clearance as cl

COMMON = ("slider_acceleration_peak_mean", "drive_crank_torque_rms", "joint_B_force_peak_mean")
OILED = ("joint_B_film_thickness_ratio_min", "dissipated_per_turn", "slider_position_deviation_max")
STRUCK = ("joint_B_contact_fraction", "joint_B_impacts_per_turn", "dissipated_per_turn")
DRY_TURNS = 41.0
#: of dry runs, whose means over turns have a far larger interval than this tolerance's error
DRY_RTOL = 1e-5
#: model -> turns of a run, what its maps show, suffix of its picture
MAPS = {
    IDEAL: (4.0, COMMON, "ideal"),
    FILM: (4.0, COMMON + OILED, "lubricated"),
    TRANSITIONAL: (4.0, COMMON + OILED, "transitional"),
    DRY: (DRY_TURNS, COMMON + STRUCK, "dry"),
}
#: impacts, and the rank correlation from which on they grow
IMPACTS = "slider_acceleration_peak_mean"
GROWS = 0.1


def draw(work: workshop.Workshop) -> None:
    count = work.less(20, 5)
    speeds, clearances = (
        np.linspace(cl.rpm(60.0), cl.rpm(600.0), count),
        np.geomspace(0.02e-3, 0.5e-3, count),
    )
    rows = []
    for model, (turns, metrics, suffix) in MAPS.items():
        points = cl.grid(speed=speeds, clearance=clearances)
        fixed = {"viscosity": OIL} | MODELS[model]
        tolerance = {"rtol": DRY_RTOL} if model == DRY else {}
        swept = work.sweep(
            "six_bar_feeder", points, fixed=fixed, turns=turns, channels=[], **tolerance
        )
        work.drawing(maps, swept, metrics=metrics, remark=remark(model, swept), suffix=suffix)
        rows += [[model, *_trend(swept, name)] for name in metrics]
    heads = (
        "joint B",
        "metric",
        "units",
        "least",
        "median",
        "largest",
        "rank correlation with speed [-]",
        "with clearance [-]",
        "impacts grow with speed and clearance",
    )
    work.table(
        heads,
        rows,
        remarks="Over all points; a correlation of 1 means that it always grows, -1 always falls.",
    )


def remark(model: str, swept) -> str:
    """By how much the largest acceleration of a turn grows along each edge of the map, and the
    source's statement.
    """
    count = round(len(swept.columns["speed"]) ** 0.5)
    values = swept.metrics[IMPACTS].reshape(count, count)
    edges = {"speed": (values[0], values[-1]), "clearance": (values[:, 0], values[:, -1])}
    grown = {
        name: float(np.median(last) / np.median(first)) for name, (first, last) in edges.items()
    }
    factors = ", ".join(f"with {name} ×\u00a0{factor:.3g}" for name, factor in grown.items())
    text = f"Largest acceleration of a turn, {model}, from edge to edge (medians): {factors}."
    if model == IDEAL:
        return text
    answer = " and ".join(
        f"{'met' if g > GROWN else 'not met'} for {name}" for name, g in grown.items()
    )
    return f"{text} Source: impacts grow with both; {answer}."


def _trend(swept, metric: str) -> list:
    """Name of a metric, its range over the map, and its trend with speed and clearance."""
    values = swept.metrics[metric]
    units, text = swept.known[metric]
    spread = (float(v) for v in (values.min(), np.median(values), values.max()))
    trends = [float(spearmanr(swept.columns[n], values).statistic) for n in ("speed", "clearance")]
    met = (
        " and ".join("met" if t > GROWS else "not met" for t in trends) if metric == IMPACTS else ""
    )
    return [text, units, *spread, *trends, met]
