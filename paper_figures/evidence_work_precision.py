"""Error against run time of all methods: lubricated slider-crank and six-bar feeder.

Group: measured

Answers: no figure of a source; the sources give neither errors nor run times of their integrations.

Reproduced: run time to reach an error, of the package's methods and of scipy's on the same compiled
right-hand side.

Assumed: two crank turns. The error is the largest deviation of the eccentricity ratio from a
reference by another method at its tightest. Times are warm medians of one core.

Not comparable: times of another machine, only ratios. Other people's compiled integrators
are compared by `clearance work-precision CASE --peers`, which needs the extra peers and more time,
and a multibody code by `python tests/benchmarks/multibody.py CASE`.
"""

from clearance.paper_figures import work_precision, workshop
from clearance.postprocess import study_pictures

import clearance as cl

SCENES = {
    "slider_crank": {"model": "lubricated", "film": "pinkus_sternlicht"},
    "six_bar_feeder": {"film": "pinkus_sternlicht"},
}


def draw(work: workshop.Workshop) -> None:
    for case, parameters in SCENES.items():
        title = " ".join([case, *(f"{k}={v}" for k, v in parameters.items())])
        study = work_precision.work_precision(
            title,
            cl.load_case(case, **parameters),
            turns=work.less(2.0, 0.1),
            progress=lambda text, case=case: work.say(f"{case}: {text}"),
        )
        work.drawing(study_pictures.work_precision, study, suffix=case)
        work.text([*work_precision.table(study), "", *work_precision.describe(study)], suffix=case)
        work.study(
            lambda folder, study=study, case=case: work_precision.save(study, folder / case),
            case=case,
            parameters=parameters,
        )
