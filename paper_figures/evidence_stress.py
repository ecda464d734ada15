"""Stiff and extreme runs of the feeder: every cell done, with its energy residual, or stopped for a
named reason.

Group: measured

Answers: no figure of a source; it is the check of numerical stability on stiff and extreme cases.

Reproduced: clearances of 1 um to 1 mm, 30 to 12000 rpm, viscosities of 1e-4 to 10 Pa s. Further,
contact stiffness, mass ratios, restitution 0 and 1, for dry, lubricated and mixed joints of the
six-bar feeder. `clearance stress` has the same rows for a slider-crank and a four-bar too, and
random
scenes: three times as many runs and more kernels to compile.

Assumed: the ranges; they enclose those of all sources.

Not comparable: the sources report no failures and no residuals.
"""

from clearance.paper_figures import stress, workshop
from clearance.postprocess import study_pictures


def draw(work: workshop.Workshop) -> None:
    case = work.less("six_bar_feeder", "random")
    verdicts = stress.stress(
        case,
        quick=work.quick,
        progress=lambda done, total, name: work.say(f"{done} of {total}: {name}"),
    )
    work.drawing(study_pictures.stress, verdicts)
    work.text(stress.table(verdicts))
    work.study(lambda folder: stress.save(verdicts, folder), cells=len(verdicts))
    if faults := [v for v in verdicts if v.kind == "fault"]:
        raise RuntimeError(
            f"{len(faults)} cells of the matrix fail, the first: {faults[0].row}, "
            f"{faults[0].column}"
        )
