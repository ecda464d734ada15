"""Influence of the number of clearance joints of the six-bar feeder: B; B and C; B, C and E.

Group: feeder

Answers: Jin et al. (2023), the slider with one, two and three clearance joints, dry and lubricated.

Reproduced: deviation of the slider's displacement from the ideal one, its acceleration, and the crank's moment at 300
rpm with radial clearances of 0.1 mm at B, at B and C, and at B, C and E; extremes and root mean squares, contacts and
energy lost. Here each further clearance adds to the deviation of the displacement, and softens the dry joints' largest
accelerations.

Assumed: that the source counts its clearances in this order (it gives joint forces of B, C and E); parameter set
feeder-A, restitution 0.9, friction coefficient 0.1, oil of 50 mPa s in every lubricated joint. Dry motions are
irregular: curves are samples, extremes are those of ten turns.

Not comparable: peaks and curves of the source, whose dimensions and clearances were not in the part we had.
"""

import numpy as np
from clearance.paper_figures import workshop
from clearance.paper_figures.feeder_slider import SETTLE, by_turns, feeder, finished, rms, settled, turns_seen
from clearance.postprocess.channels import abscissa
from clearance.postprocess.contacts import contacts_of
from clearance.postprocess.figures import finish, line, sheet, stroke

CLEARANCES = ("B", "B,C", "B,C,E")


def draw(work: workshop.Workshop) -> None:
    ideal = feeder(work, model="ideal")
    runs = {(m, j): feeder(work, model=m, joints=j) for m in ("lubricated", "dry") for j in CLEARANCES}
    work.keep(oiled({j: runs["lubricated", j] for j in CLEARANCES}, ideal), "lubricated")
    work.keep(dry({j: runs["dry", j] for j in CLEARANCES}, ideal), "dry")
    work.table(*numbers(runs, ideal), remarks=f"Of {turns_seen(runs)} turns after {SETTLE}.")


def oiled(runs: dict, ideal):
    """Lubricated: deviation of displacement, acceleration and moment from the ideal mechanism over the last turn."""
    figure = sheet(7.0, 6.4)
    panels = figure.subplots(3, 1, sharex=True)
    for i, (joints, run) in enumerate(runs.items()):
        angle, last, xlabel = abscissa(run, "angle", 1.0)
        for axes, values in zip(panels, beyond(run, ideal), strict=True):
            line(
                axes,
                angle,
                values[last],
                **{"lw": 1.2, "label": f"clearance at {joints.replace(',', ', ')}"} | stroke(i, len(runs)),
            )
    labels = ("displacement [µm]", "acceleration [m/s²]", "crank moment [N m]")
    for axes, label in zip(panels, labels, strict=True):
        finish(axes, f"deviation of\n{label}", "", legend=False)
    return finished(figure, panels, xlabel)


def dry(runs: dict, ideal):
    """Dry: the same, a column for each number of clearances."""
    figure = sheet(10.0, 6.6)
    panels = figure.subplots(3, len(runs), sharex=True, sharey="row")
    for i, (column, (joints, run)) in enumerate(zip(panels.T, runs.items(), strict=True)):
        angle, last, xlabel = abscissa(run, "angle", 1.0)
        for axes, values in zip(column, beyond(run, ideal), strict=True):
            line(axes, angle, values[last], **stroke(i, len(runs)) | {"lw": 0.5})
            finish(axes, "", "", legend=False)
        column[0].set_title(f"clearance at {joints.replace(',', ', ')}", fontsize="medium")
        column[-1].set_xlabel(xlabel)
        column[-1].set(xlim=(0.0, 360.0), xticks=range(0, 361, 90))
    labels = ("displacement [µm]", "acceleration [m/s²]", "crank moment [N m]")
    for axes, label in zip(panels[:, 0], labels, strict=True):
        axes.set_ylabel(f"deviation of\n{label}")
    figure.align_ylabels()
    return figure


def beyond(run, ideal) -> tuple[np.ndarray, ...]:
    """What displacement [um], acceleration [m/s2] and crank moment [N m] have beyond the ideal mechanism."""
    now, then = run["slider"], ideal["slider"]
    torque = run.drive("crank").torque - ideal.drive("crank").torque
    return 1e6 * (now.x - then.x), now.ax - then.ax, torque


def numbers(runs: dict, ideal) -> tuple[list[str], list[list]]:
    """Heads and rows: deviations, extremes, contacts and losses."""
    heads = [
        "joints", "deviation of x, max [um]", "largest abs. acceleration [m/s2]", "of a turn [m/s2]",
        "rms acceleration beyond ideal [m/s2]", "largest abs. moment [N m]", "rms moment [N m]", "contacts a turn",
        "energy lost in a turn [J]",
    ]  # fmt: skip
    rows, turns = [], turns_seen(runs)
    for (model, joints), run in runs.items():
        now = settled(run)
        dx, da, _ = (values[now] for values in beyond(run, ideal))
        a, torque = np.abs(run["slider"].ax[now]), np.abs(run.drive("crank").torque[now])
        names = joints.split(",")
        count = sum(len(contacts_of(run, j, settle=SETTLE).time) for j in names) / turns if model == "dry" else "-"
        lost = sum(np.ptp(run.joint(j).dissipated[now]) for j in names) / turns
        said = f"{model}, {joints.replace(',', ' ')}"
        accelerations = [float(a.max()), by_turns(a, turns), rms(da)]
        moments = [float(torque.max()), rms(torque)]
        rows.append([said, float(np.abs(dx).max()), *accelerations, *moments, count, float(lost)])
    return heads, rows


if __name__ == "__main__":
    workshop.main(__file__)
