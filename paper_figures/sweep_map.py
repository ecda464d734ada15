"""Maps of the feeder over speed and clearance, with a lubricated and with a dry joint B.

Group: feeder

Answers: Jin et al. (2023), how speed and clearance act on motion and joint forces, which the source shows for a few
values of each; here as maps of 20 by 20 runs.

Reproduced: trends: over most of the map the dry joint multiplies forces and accelerations by ten and more, and
neighbouring points differ because its motion is irregular; oil keeps forces near those of ideal joints until the
clearance is so large that the film thins to the roughness. The table has rank correlations with speed and clearance.

Assumed: the parameter set feeder-A; runs of 4 turns (lubricated) and 10 turns (dry), of which the first is left out.

Not comparable: every amplitude; the source's lengths and masses are not in the part of it we had. The largest values of
single dry points depend on rounding.
"""

import numpy as np
from clearance.paper_figures import workshop
from clearance.postprocess.maps import maps
from scipy.stats import spearmanr

import clearance as cl

COMMON = ("slider_acceleration_max", "drive_crank_torque_rms", "joint_B_force_max")
#: model -> turns of a run, and what its maps show
MODELS = {
    "lubricated": (4.0, (*COMMON, "joint_B_film_thickness_ratio_min", "dissipated_per_turn",
                         "slider_position_deviation_max")),
    "dry": (10.0, (*COMMON, "joint_B_contact_fraction", "joint_B_impacts_per_turn", "dissipated_per_turn")),
}  # fmt: skip


def draw(work: workshop.Workshop) -> None:
    count = work.less(20, 5)
    speeds, clearances = np.linspace(cl.rpm(60.0), cl.rpm(600.0), count), np.geomspace(0.02e-3, 0.5e-3, count)
    rows = []
    for model, (turns, metrics) in MODELS.items():
        points = cl.grid(speed=speeds, clearance=clearances)
        swept = work.sweep("six_bar_feeder", points, fixed={"model": model}, turns=turns, channels=[])
        work.drawing(maps, swept, metrics=metrics, suffix=model)
        rows += [[model, *_trend(swept, name)] for name in metrics]
    heads = (
        "joint B", "metric", "units", "least", "median", "largest", "rank correlation with speed [-]",
        "with clearance [-]",
    )  # fmt: skip
    work.table(heads, rows, remarks="Over all points; a correlation of 1 means that it always grows, -1 always falls.")


def _trend(swept, metric: str) -> list:
    """What a metric is, its range over the map, and how it goes with speed and clearance."""
    values = swept.metrics[metric]
    units, text = swept.known[metric]
    spread = (float(v) for v in (values.min(), np.median(values), values.max()))
    trends = (float(spearmanr(swept.columns[n], values).statistic) for n in ("speed", "clearance"))
    return [text, units, *spread, *trends]


if __name__ == "__main__":
    workshop.main(__file__)
