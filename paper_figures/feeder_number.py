"""Influence of the number of clearance joints of the six-bar feeder: B; B and C; B, C and E.

Group: feeder

Answers: Jin et al. (2023), the slider with one, two and three clearance joints, dry, lubricated and
transitional. The source states that impacts grow with the number of joints.

Reproduced: deviation of the slider's displacement from the ideal one, its acceleration, and the
crank's moment at 300 rpm with radial clearances of 0.2 mm. The joints are B, B and C, and B, C and
E, with film only, transitional on rigid and on elastic surfaces, and dry. Also largest values of a
turn and root mean squares, contacts and energy lost. Each picture has the growth of the largest
acceleration. With oil it grows, as the source states; dry joints in series soften each other,
against the source.

Assumed: that the source counts its clearances in this order (it gives joint forces of B, C and E).
Also parameter set feeder-A, restitution 0.9, friction coefficient 0.1, oil of 5 mPa s in every wet
joint. Dry motions are irregular: curves are samples, largest values are means over ten turns.

Not comparable: peaks and curves of the source, whose dimensions and clearances were not in the part
we had.
"""

import numpy as np
from clearance.paper_figures import workshop
from clearance.paper_figures.feeder_slider import (
    COMPARED,
    DRY,
    ELASTIC,
    FILM,
    IDEAL,
    SETTLE,
    TRANSITIONAL,
    by_turns,
    conclude,
    feeder,
    finished,
    of_turn,
    rms,
    settled,
    turns_seen,
)
from clearance.postprocess.channels import abscissa
from clearance.postprocess.contacts import contacts_of
from clearance.postprocess.figures import finish, line, sheet, stroke

JOINTS = ("B", "B,C", "B,C,E")
CLAIM = "more clearance joints, greater impacts"
LABELS = ("displacement [µm]", "acceleration [m/s²]", "crank moment [N m]")


def draw(work: workshop.Workshop) -> None:
    ideal = feeder(work, **COMPARED[IDEAL])
    wetted = (FILM, TRANSITIONAL, ELASTIC)
    runs = {(m, j): feeder(work, **COMPARED[m], joints=j) for m in (*wetted, DRY) for j in JOINTS}
    oiled = {m: {j: runs[m, j] for j in JOINTS} for m in wetted}
    work.keep(wet(oiled, ideal), "lubricated")
    work.keep(dry({j: runs[DRY, j] for j in JOINTS}, ideal), "dry")
    work.table(*numbers(runs, ideal), remarks=f"Of {turns_seen(runs)} turns after {SETTLE}.")


def named(joints: str) -> str:
    return f"clearance at {joints.replace(',', ', ')}"


def largest(runs: dict) -> tuple[float, float]:
    """Largest acceleration of a turn with one and with all joints."""
    first, *_, last = (of_turn(r["slider"].ax[settled(r)], turns_seen(runs)) for r in runs.values())
    return first, last


def wet(models: dict, ideal):
    """With oil, a column for each model: deviations from the ideal mechanism over the last turn."""
    figure = sheet(11.0, 7.2)
    panels = figure.subplots(3, len(models), sharex=True, sharey="row")
    for column, (model, runs) in zip(panels.T, models.items(), strict=True):
        column[0].set_title(model, fontsize="medium")
        first = model == next(iter(models))
        for i, (joints, run) in enumerate(runs.items()):
            angle, last, xlabel = abscissa(run, "angle", 1.0)
            for axes, values in zip(column, beyond(run, ideal), strict=True):
                line(
                    axes,
                    angle,
                    values[last],
                    **{"lw": 1.2, "label": named(joints)} | stroke(i, len(runs)),
                )
        for axes, label in zip(column, LABELS, strict=True):
            finish(axes, f"deviation of\n{label}" if first else "", "", legend=False)
        column[-1].set_xlabel(xlabel)
    grown = {model: largest(runs) for model, runs in models.items()}
    conclude(figure, "Largest slider acceleration of a turn from one to three joints", grown, CLAIM)
    return finished(figure, panels[:, 0], xlabel)


def dry(runs: dict, ideal):
    """Dry: the same, a column for each number of clearances."""
    figure = sheet(10.0, 7.0)
    panels = figure.subplots(3, len(runs), sharex=True, sharey="row")
    for i, (column, (joints, run)) in enumerate(zip(panels.T, runs.items(), strict=True)):
        angle, last, xlabel = abscissa(run, "angle", 1.0)
        for axes, values in zip(column, beyond(run, ideal), strict=True):
            line(axes, angle, values[last], **stroke(i, len(runs)) | {"lw": 0.5})
            finish(axes, "", "", legend=False)
        column[0].set_title(named(joints), fontsize="medium")
        column[-1].set_xlabel(xlabel)
        column[-1].set(xlim=(0.0, 360.0), xticks=range(0, 361, 90))
    for axes, label in zip(panels[:, 0], LABELS, strict=True):
        axes.set_ylabel(f"deviation of\n{label}")
    conclude(
        figure,
        "Largest slider acceleration of a turn from one to three joints",
        {DRY: largest(runs)},
        CLAIM,
    )
    figure.align_ylabels()
    return figure


def beyond(run, ideal) -> tuple[np.ndarray, ...]:
    """Displacement [um], acceleration [m/s2] and crank moment [N m] beyond those of the ideal
    mechanism.
    """
    now, then = run["slider"], ideal["slider"]
    torque = run.drive("crank").torque - ideal.drive("crank").torque
    return 1e6 * (now.x - then.x), now.ax - then.ax, torque


def numbers(runs: dict, ideal) -> tuple[list[str], list[list]]:
    """Heads and rows: deviations, extremes, contacts and losses."""
    heads = [
        "joints",
        "deviation of x, max of a turn [um]",
        "largest abs. acceleration of a turn [m/s2]",
        "rms acceleration beyond ideal [m/s2]",
        "largest abs. moment of a turn [N m]",
        "rms moment [N m]",
        "contacts a turn",
        "energy lost in a turn [J]",
    ]
    rows, turns = [], turns_seen(runs)
    for (model, joints), run in runs.items():
        now = settled(run)
        dx, da, _ = (values[now] for values in beyond(run, ideal))
        a, torque = np.abs(run["slider"].ax[now]), np.abs(run.drive("crank").torque[now])
        names = joints.split(",")
        count = (
            sum(len(contacts_of(run, j, settle=SETTLE).time) for j in names) / turns
            if model == DRY
            else "-"
        )
        lost = sum(np.ptp(run.joint(j).dissipated[now]) for j in names) / turns
        title = f"{model}, {joints.replace(',', ' ')}"
        accelerations = [by_turns(a, turns), rms(da)]
        moments = [by_turns(torque, turns), rms(torque)]
        rows.append([title, of_turn(dx, turns), *accelerations, *moments, count, float(lost)])
    return heads, rows
