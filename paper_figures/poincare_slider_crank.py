"""Poincare sections of the dry slider-crank at 3000 and 5000 rpm.

Group: joints

Answers: no figure of the four sources. The literature on dry clearance joints draws these sections
for the slider-crank of the Flores group (Flores, Ravn, Parenteau, Skrinjar and their co-authors).

Reproduced: the journal's centre, and the slider's velocity and acceleration, once a turn for 1000
turns: one point at 3000 rpm, where the motion comes back every turn, and a scattered set at 5000
rpm, where it does not.

Assumed: Lankarani-Nikravesh contact of steel with restitution 0.9, smooth Coulomb friction of 0.03,
clearance 1 mm; 200 turns are left out at the start.

Not comparable: shapes of the sections of those papers, whose masses, friction and contact differ.
Single points of the irregular motion depend on rounding, its cloud does not.
"""

from contextlib import ExitStack

from clearance.paper_figures import workshop
from clearance.paper_figures.bifurcation import FIXED, KEPT
from clearance.postprocess.sections import poincare

import clearance as cl

SPEEDS = (5000.0, 3000.0)  # rpm; the last one is drawn on top
TURNS, SETTLE = 1200.0, 200.0


def draw(work: workshop.Workshop) -> None:
    turns, settle = work.less((TURNS, SETTLE), (100.0, 40.0))
    parameters = FIXED | {"friction_coefficient": 0.03, "clearance": 1e-3}
    with ExitStack() as opened:
        runs = [
            opened.enter_context(
                work.run(
                    "slider_crank",
                    parameters | {"speed": cl.rpm(n)},
                    turns=turns,
                    samples_per_turn=40,
                    channels=KEPT,
                )
            )
            for n in SPEEDS
        ]
        work.drawing(poincare, runs, settle=settle)
