"""Mechanism sketch and ideal kinematics of the six-bar rocking feeder.

Group: feeder

Answers: Jin et al. (2023), the figure of the mechanism and the motion of its ideal model.

Reproduced: topology (crank, rod 2, rocker, rod 4, slider; joints A to F). The motion of the slider
and of the rocker over a turn, and the drive torque without clearance, at 300 rpm.

Assumed: all lengths, masses and inertias but the distances of the pivots A and D (parameter set
feeder-A). They are not in the part of the source we had.

Not comparable: amplitudes; the source's numbers belong to its own lengths.
"""

import numpy as np
from clearance.paper_figures import workshop
from clearance.postprocess.drawing import sketch
from clearance.postprocess.figures import finish, line, sheet


def draw(work: workshop.Workshop) -> None:
    with work.run("six_bar_feeder", {"model": "ideal"}, turns=1.0) as run:
        work.drawing(sketch, run)
        work.keep(kinematics(run), "kinematics")


def kinematics(run):
    """Slider, rocker and drive torque over the crank's angle."""
    figure = sheet(7.5, 8.0)
    panels = figure.subplots(5, 1, sharex=True)
    angle = np.degrees(run["crank"].theta - run["crank"].theta[0])
    shown = (
        (run["slider"].x, "slider x [m]"),
        (run["slider"].vx, "its velocity [m/s]"),
        (run["slider"].ax, "its acceleration [m/s²]"),
        (np.degrees(run["rocker"].theta), "rocker angle [deg]"),
        (run.drive("crank").torque, "drive torque [N m]"),
    )
    for axes, (values, label) in zip(panels, shown, strict=True):
        line(axes, angle, values, color="k", lw=1.2)
        finish(axes, label, "", legend=False)
    panels[-1].set_xlabel("crank angle from the start [deg]")
    panels[-1].set_xticks(range(0, 361, 45))
    return figure
