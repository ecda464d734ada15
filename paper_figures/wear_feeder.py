"""The life of a dry joint of the feeder.

Group: joints

Answers: no figure of the sources; Jin et al. (2023) state that clearance makes joint forces and
errors of the slider grow. Wear makes the clearance.

Reproduced: depth of the worn bearing B over ten million turns at 300 rpm, about 23 days. Beside it
the largest distance of the slider from its ideal motion, and the outline at the end. The band is
the stated error of the jumps. It is wide, for dry motion is chaotic and a stage averages few turns.

Assumed: parameter set feeder-A; steel with a coefficient of wear of 1e-15 m2/N.

Not comparable: all numbers.
"""

import numpy as np
from clearance.paper_figures import workshop
from clearance.postprocess import figures

import clearance as cl

TURNS = 1e7
PLAN = {"tolerance": 0.2, "share": 0.2}
CASE = {"model": "dry", "joints": "B", "wear": 1e-15}
JOINT = "B"


def draw(work: workshop.Workshop) -> None:
    life = work.life("six_bar_feeder", CASE, turns=work.less(TURNS, 1e5), **PLAN)
    work.keep(picture(life))
    deep, error = 1e6 * life.depth(JOINT)[-1].max(), 1e6 * life.error[-1]
    row = [life.turns[-1], deep, error, 1e9 * life.volume(JOINT)[-1], len(life.stages)]
    heads = ("turns", "depth [um]", "stated error [um]", "volume [mm3]", "stages")
    work.table(heads, [[float(v) for v in row]])


def picture(life: cl.Life):
    """Depth and distance from the ideal motion over turns; the outline at the end."""
    figure = figures.sheet(12.0, 4.0)
    depth, motion, outline = figure.subplots(1, 3)
    deep, error = 1e6 * life.depth(JOINT).max(axis=1), 1e6 * life.error
    depth.plot(life.turns, deep, "o-", ms=3)
    low = np.maximum(deep - error, 0.0)
    depth.fill_between(life.turns, low, deep + error, color="C0", alpha=0.2, lw=0.0)
    figures.finish(depth, "largest depth [µm]", "turns")
    away = 1e6 * life.metric("slider_position_deviation_max")
    motion.plot(life.turns, away, "o-", ms=3)
    figures.finish(motion, "slider from its ideal motion [µm]", "turns")
    outline.plot(1e6 * life.depth(JOINT)[-1])
    figures.finish(outline, "depth at the end [µm]", "angle of the bearing [deg]")
    figure.suptitle("six_bar_feeder, dry joint B")
    return figure
