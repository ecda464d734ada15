"""Five-axis chain: driving torques, joint friction and reactions, case 1 of Guo, Ju and Wang.

Group: chains

Answers: Guo, Ju and Wang, Aerospace 11 (2024) 368, case 1. Driving torques of the five axes without
friction, with Coulomb-viscous and with Stribeck friction, and the joint reactions behind them.

Reproduced: the tree of five hinges about vertical axes, each accelerated by 0.2 rad/s² against its
carrier. Reactions with axial force and bending moments, the friction load made of them, and both
friction laws with the printed coefficients.

Assumed: the start from rest and a run of 5 s, and the links of 3 kg (reading P, links 2 and 4; the
table has reading Q as well). Pin radius and friction arm are 20 mm and the bending arm 50 mm, to
which all friction is proportional. The exponent of the Stribeck term is 2, and viscous friction
follows the rate alone.

Not comparable: every number; the part of the source we had prints no torque and no error, only that
it agrees with ADAMS. Instead the ideal torques agree with Pinocchio to rounding (see the tests).
"""

import numpy as np
from clearance.paper_figures import workshop
from clearance.postprocess.drawing import sketch
from clearance.postprocess.figures import finish, legend_below, line, sheet, stroke

JOINTS = ("1", "2", "3", "4", "5")
LAWS = {"coulomb": "Coulomb-viscous", "stribeck": "Stribeck"}
UNTIL = 5.0  # s
BEGINNING = 0.5  # s, in which Stribeck friction falls


def draw(work: workshop.Workshop) -> None:
    samples = work.less(2001, 401)
    runs = {
        law: work.inverse("five_axis_chain", {"friction": law}, until=UNTIL, samples=samples)
        for law in LAWS
    }
    other = work.inverse("five_axis_chain", {"reading": "Q"}, until=UNTIL, samples=samples)
    work.keep(torques(runs))
    work.keep(reactions(runs["coulomb"]), "reactions")
    work.drawing(sketch, runs["coulomb"], suffix="sketch")
    peaks(work, runs, other)


def torques(runs: dict):
    """Driving torque of every joint, and what friction adds to it at the beginning."""
    figure = sheet(9.0, 9.0)
    panels = figure.subplots(5, 2, sharex="col", width_ratios=(3, 2))
    first = runs["coulomb"]
    begin = first.time <= BEGINNING
    for (total, added), joint in zip(panels, JOINTS, strict=True):
        line(
            total,
            first.time,
            first.drive(joint).torque_ideal,
            label="no friction",
            **stroke(0, 3),
            lw=1.4,
        )
        for i, (law, run) in enumerate(runs.items(), 1):
            drive, style = run.drive(joint), stroke(i, 3) | {"label": LAWS[law], "lw": 1.2}
            line(total, run.time, drive.torque, **style)
            line(added, run.time[begin], (drive.torque - drive.torque_ideal)[begin], **style)
        finish(total, f"torque {joint} [N m]", "", legend=False)
        finish(added, "for friction [N m]", "", legend=False)
        added.set_ylim(bottom=0.0)
    for axes in panels[-1]:
        axes.set_xlabel("time [s]")
    panels[0, 0].set_title("driving torque of joints 1 to 5", fontsize="medium")
    panels[0, 1].set_title(f"its part for friction, first {BEGINNING:g} s", fontsize="medium")
    figure.align_ylabels()
    legend_below(figure, panels[0, 0])
    return figure


def radial(run, joint: str) -> np.ndarray:
    """Force across the pin (samples,) [N]."""
    return np.hypot(*run.joint(joint).force.T)


def bending(run, joint: str) -> np.ndarray:
    """Bending moment of the pin (samples,) [N m]."""
    return np.hypot(*run.joint(joint).bending.T)


def reactions(run):
    """Loads of the pins, the friction load that they come to, and the friction that it makes."""
    figure = sheet(7.0, 9.5)
    panels = figure.subplots(5, 1, sharex=True)
    shown = (
        (radial, "radial force [N]"),
        (lambda r, j: np.abs(r.joint(j).axial_force), "axial force [N]"),
        (bending, "bending moment [N m]"),
        (lambda r, j: r.joint(j).friction_load, "friction load [N m]"),
        (lambda r, j: np.abs(r.joint(j).friction), "friction torque,\nCoulomb-viscous [N m]"),
    )
    for axes, (values, label) in zip(panels, shown, strict=True):
        for i, joint in enumerate(JOINTS):
            line(axes, run.time, values(run, joint), label=f"joint {joint}", **stroke(i, 5), lw=1.3)
        finish(axes, label, "", legend=False)
        axes.set_ylim(bottom=0.0)
    panels[-1].set_xlabel("time [s]")
    figure.align_ylabels()
    legend_below(figure, panels[0])
    return figure


def peaks(work: workshop.Workshop, runs: dict, other) -> None:
    """Largest values over the run, joint by joint."""
    run = runs["coulomb"]
    heads = (
        "joint",
        "torque, no friction [N m]",
        "Coulomb-viscous [N m]",
        "Stribeck [N m]",
        "largest Stribeck part [N m]",
        "radial force [N]",
        "axial force [N]",
        "bending moment [N m]",
        "torque, no friction, reading Q [N m]",
    )
    rows = []
    for joint in JOINTS:
        driving, slow = run.drive(joint), runs["stribeck"].drive(joint)
        peaks = (
            driving.torque_ideal,
            driving.torque,
            slow.torque,
            slow.torque - slow.torque_ideal,
            radial(run, joint),
            run.joint(joint).axial_force,
            bending(run, joint),
            other.drive(joint).torque_ideal,
        )
        rows.append([joint, *(float(np.abs(values).max()) for values in peaks)])
    remarks = (
        f"Largest absolute values in {UNTIL:g} s, reading P but for the last column; "
        "friction is proportional to "
    )
    work.table(heads, rows, remarks=f"{remarks}the assumed lengths of the pins.")
