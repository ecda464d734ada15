"""Prescribed motion: efforts and reactions by the compiled kernel, by multipliers, and by dense
linear algebra.

Group: measured

Answers: Guo et al. (2024), the claim that explicit equations beat multiplier solves; the source
gives no run time.

Reproduced: time of 10,000 samples of the three-loop chain by each route, warm, in turn in one run,
and the operations a sample.

Assumed: link data decoded from the source's figure (see the case), friction at the driven joint.

Not comparable: the source's own code and its run times, which are not published.
"""

import numpy as np
from clearance.paper_figures import workshop

import clearance as cl
from clearance.commands import routes


def draw(work: workshop.Workshop) -> None:
    times = np.linspace(0.0, 10.0, work.less(10_000, 500))
    study = routes.compare(cl.load_case("three_loop_chain"), times, progress=work.say)
    work.drawing(routes.picture, study)
    work.text([*routes.table(study), "", *routes.describe(study)])
    work.study(lambda folder: routes.save(study, folder), case="three_loop_chain", until=10.0)


if __name__ == "__main__":
    workshop.main(__file__)
