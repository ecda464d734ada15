"""Bifurcation diagrams of the dry slider-crank over the speed and over the clearance.

Group: joints

Answers: no figure of the four sources. The literature on dry clearance joints draws these diagrams
for the slider-crank of the Flores group (Flores, Ravn, Parenteau, Skrinjar and their co-authors).

Reproduced: the joint's eccentricity and the slider's velocity once a turn, after 100 turns, over
the speed and over the
clearance: periodic in some ranges, irregular in others, with windows of period 2, as that
literature reports. Bars are 95 % intervals of the mean over the 41 turns. The guide has the same
diagrams of 151 points and 260 turns: periodic motions are the same, irregular ones have more.

Assumed: Lankarani-Nikravesh contact of steel with restitution 0.9. Smooth Coulomb friction, 0.03
over the speed and 0.07 over the clearance. The clearance is 1 mm over the speed, the speed is 1000
rpm over the clearance.

Not comparable: the speeds and clearances at which the motion turns irregular; masses, friction and
contact of those papers differ from each other and from these. Single points of the irregular ranges
depend on rounding.
"""

import numpy as np
from clearance.paper_figures import workshop
from clearance.postprocess.maps import bifurcation_of

import clearance as cl

FIXED = {"model": "dry", "friction": "coulomb", "restitution": 0.9}
CHANNELS = ("C.epsilon", "slider.vx")
KEPT = ["joints/C/eccentricity_*", "bodies/slider"]
POINTS, TURNS, SETTLE = 101, 140.0, 100.0
RTOL = 1e-5  # periodic values to less than a dot; single points of irregular motion mean nothing


def draw(work: workshop.Workshop) -> None:
    count = work.less(POINTS, 11)
    speeds = np.linspace(cl.rpm(1500.0), cl.rpm(6500.0), count)
    _diagram(
        work, cl.grid(speed=speeds), {"friction_coefficient": 0.03, "clearance": 1e-3}, "speed"
    )
    clearances = np.linspace(0.05e-3, 0.8e-3, count)
    _diagram(
        work,
        cl.grid(clearance=clearances),
        {"friction_coefficient": 0.07, "speed": cl.rpm(1000.0)},
        "clearance",
    )


def _diagram(work: workshop.Workshop, points, fixed: dict, parameter: str) -> None:
    """A sweep with the run files that its diagram is made of, and the diagram."""
    turns, settle = work.less((TURNS, SETTLE), (30.0, 15.0))
    swept = work.sweep(
        "slider_crank",
        points,
        fixed=FIXED | fixed,
        turns=turns,
        settle=settle,
        samples_per_turn=40,
        channels=KEPT,
        rtol=RTOL,
    )
    work.drawing(
        bifurcation_of,
        swept,
        parameter=parameter,
        settle=settle,
        channels=CHANNELS,
        suffix=parameter,
    )
