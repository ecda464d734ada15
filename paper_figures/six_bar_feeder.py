"""The six-bar rocking feeder with a lubricated joint B at 300 rpm: the front picture.

Group: feeder

Answers: no single figure of Jin et al. (2023); it is one page of what a run gives, as the first command of the README
draws it.

Reproduced: a film in joint B in place of the ideal joint, as in the source's lubricated model: six turns that begin
with the journal in the middle of its clearance; slider acceleration, drive torque, joint forces, the journal's path.

Assumed: all lengths, masses and inertias, the joint's size and the oil's viscosity (parameter set feeder-A); the film
is the tabulated solution of the Reynolds equation, not the source's Pinkus-Sternlicht formula.

Not comparable: every amplitude; the source's numbers belong to its own lengths and masses, which we had not got.
"""

from clearance.paper_figures import workshop
from clearance.postprocess.plots import overview

PARAMETERS = {"model": "lubricated", "joints": "B"}
TURNS = 6.0


def draw(work: workshop.Workshop) -> None:
    with work.run("six_bar_feeder", PARAMETERS, turns=TURNS) as run:
        work.drawing(overview, run)


if __name__ == "__main__":
    workshop.main(__file__)
