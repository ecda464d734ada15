"""The feeder with a mixed joint B: journal path, regimes, and who carries the load.

Group: feeder

Answers: Jin et al. (2023), the joint in which dry contact and film share the load by fuzzy weights of the lubrication
state.

Reproduced: the transition model: memberships of the film thickness ratio in full film, mixed and dry weigh film and
contact; motion, drive torque, joint forces and the journal's path over six turns at 300 rpm, and the share of the
solids.

Assumed: the parameter set feeder-A; half-cosine memberships with thresholds 0.4, 1 and 3, oil of 5 cP so that the film
gets thin, and the harmonic film in place of the source's formula.

Not comparable: when and how long the joint is mixed, and all amplitudes; the source's lengths, masses and membership
functions are not in the part of it we had.
"""

import numpy as np
from clearance.paper_figures import workshop
from clearance.postprocess.plots import MEMBERSHIPS, STATES, overview

PARAMETERS = {"model": "mixed", "transition": "fuzzy", "film": "harmonic", "viscosity": 5e-3}


def draw(work: workshop.Workshop) -> None:
    with work.run("six_bar_feeder", PARAMETERS, turns=6.0) as run:
        work.drawing(overview, run)
        numbers(work, run)


def numbers(work: workshop.Workshop, run) -> None:
    """How long joint B is in each state, and what its solids carry, over the last two turns."""
    late = run.time >= run.time[-1] - 2.0 * run.turn
    joint = run.joint("B")
    states = np.argmax([getattr(joint, name)[late] for name in MEMBERSHIPS], axis=0)
    rows = [[f"{name}, share of the time [-]", float(np.mean(states == i))] for i, name in enumerate(STATES)]
    rows += [
        ["film thickness ratio, least [-]", float(joint.film_thickness_ratio[late].min())],
        ["load on the solids, largest share [-]", float(joint.asperity_share[late].max())],
        ["force, largest [N]", float(np.hypot(*joint.force[late].T).max())],
    ]
    work.table(("joint B, last two turns", "value"), rows, remarks="The state is that of the largest membership.")


if __name__ == "__main__":
    workshop.main(__file__)
