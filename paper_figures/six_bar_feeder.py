"""The six-bar rocking feeder with a transitional joint B at 300 rpm: the front picture.

Group: feeder

Answers: Jin et al. (2023), the joint in which film and contact share the load by fuzzy weights of
the lubrication state. It is one page of the content of a run, as the first command of the README
draws it.

Reproduced: the transition model: memberships of the film thickness ratio of elastic surfaces in
full film, mixed and dry weigh film and contact. Six turns begin with the journal in the middle of
its clearance. The page has slider acceleration, drive torque, joint forces, the journal's path and
its regimes, and the share of the load on the solids.

Assumed: all lengths, masses and inertias, and the joint's size (parameter set feeder-A).
Half-cosine memberships with thresholds 0.4, 1 and 3, oil of 5 mPa s so that the film gets thin. The
film is the tabulated solution of the Reynolds equation, not the source's Pinkus-Sternlicht formula.

Not comparable: times and durations of the mixed state, and all amplitudes. The source's lengths,
masses and membership functions are not in the part of it we had.
"""

import numpy as np
from clearance.paper_figures import workshop
from clearance.postprocess.plots import MEMBERSHIPS, STATES, overview

PARAMETERS = {"model": "mixed"}
TURNS = 6.0


def draw(work: workshop.Workshop) -> None:
    with work.run("six_bar_feeder", PARAMETERS, turns=TURNS) as run:
        work.drawing(overview, run)
        numbers(work, run)


def numbers(work: workshop.Workshop, run) -> None:
    """Share of time of joint B in each state, and of load on its solids, over the last two
    turns.
    """
    late = run.time >= run.time[-1] - 2.0 * run.turn
    joint = run.joint("B")
    states = np.argmax([getattr(joint, name)[late] for name in MEMBERSHIPS], axis=0)
    rows = [
        [f"{name}, share of the time [-]", float(np.mean(states == i))]
        for i, name in enumerate(STATES)
    ]
    rows += [
        ["film thickness ratio, least [-]", float(joint.film_thickness_ratio[late].min())],
        ["load on the solids, largest share [-]", float(joint.asperity_share[late].max())],
        ["force, largest [N]", float(np.hypot(*joint.force[late].T).max())],
    ]
    work.table(
        ("joint B, last two turns", "value"),
        rows,
        remarks="The state is that of the largest membership.",
    )
