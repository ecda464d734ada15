"""Interaction of clearance joints B, C and E of the six-bar feeder: each by itself and all three
together.

Group: feeder

Answers: Jin et al. (2023), interaction between several clearance joints. The source states that
clearance joints act on one another.

Reproduced: forces, eccentricities, contacts and losses of joints B, C and E at 300 rpm with radial
clearances of 0.1 mm. Each joint is the only one with clearance, or all three have it: transitional
on rigid and on elastic surfaces, film only, dry. Also the correlation in time of the contact forces
of two dry joints. C and E rock rather than turn, so that their oil carries by being squeezed. Each
picture has the growth of joint forces by the neighbours' clearance. With thin oil the neighbours
raise the force of each. Dry they lower that of B and raise those of C and E, and an impact in one
loads the others within a fraction of a millisecond.

Assumed: parameter set feeder-A, restitution 0.9, friction coefficient 0.1, oil of 5 mPa s. Dry
motions are irregular: compared are means over ten turns, and correlations of the contact forces,
which were averaged over 0.2 ms.

Not comparable: the source's forces and orbits of the three joints; its dimensions and clearances
were not in the part we had.
"""

import numpy as np
from clearance.paper_figures import workshop
from clearance.paper_figures.feeder_slider import (
    COMPARED,
    DRY,
    ELASTIC,
    FILM,
    SETTLE,
    TRANSITIONAL,
    feeder,
    finished,
    of_turn,
    rms,
    say,
    settled,
    turns_seen,
)
from clearance.postprocess.channels import abscissa
from clearance.postprocess.contacts import contacts_of
from clearance.postprocess.figures import STROKES, finish, line, sheet, stroke

from clearance.metrics.by_turn import by_turn

JOINTS, ALL = ("B", "C", "E"), "B,C,E"
PICTURES = {TRANSITIONAL: "transitional", ELASTIC: "elastic", FILM: "lubricated"}
CLEARANCE = 1e-4
#: a change of a joint's force by its neighbours that counts as interaction
NOTICED = 0.02
#: largest lag of correlations [ms], and the time over which contact forces are averaged [ms]
LAG, AVERAGED = 3.0, 0.2
ALONE, TOGETHER = (
    {"lw": 1.2, "label": "alone"} | STROKES[0],
    {"lw": 1.2, "label": "all three"} | STROKES[1],
)


def draw(work: workshop.Workshop) -> None:
    runs = {
        m: {j: feeder(work, **COMPARED[m], joints=j, clearance=CLEARANCE) for j in (*JOINTS, ALL)}
        for m in (TRANSITIONAL, ELASTIC, FILM, DRY)
    }
    for model, suffix in PICTURES.items():
        work.keep(oiled(model, runs[model]), suffix)
    work.keep(dry(runs[DRY]), "dry")
    remark = f"Means over {turns_seen(runs[DRY])} turns after {SETTLE}; gaps are those of samples."
    heads = [
        "model",
        "joint",
        "clearance",
        "largest force of a turn [N]",
        "rms force [N]",
        "smallest gap of a turn [um]",
        "largest eccentricity of a turn / c",
        "contacts a turn",
        "time in contact [%]",
        "energy lost in a turn [J]",
    ]
    rows = [
        [model, j, "alone" if case == j else "all three", *numbers(runs_of[case], j)]
        for model, runs_of in runs.items()
        for j in JOINTS
        for case in (j, ALL)
    ]
    work.table(heads, rows, remarks=remark)


def interaction(model: str, runs: dict) -> str:
    """Change of each joint's largest force of a turn by its neighbours' clearance, and the source's
    statement.
    """
    changed = {j: numbers(runs[ALL], j)[0] / numbers(runs[j], j)[0] for j in JOINTS}
    factors = ", ".join(f"{j} ×\u00a0{f:.3g}" for j, f in changed.items())
    noticed = max(abs(f - 1.0) for f in changed.values()) > NOTICED
    grows = max(changed.values()) > 1.0 + NOTICED
    verdict = "met" + ("" if grows else ", but forces fall") if noticed else "not met"
    claim = f"Source: joints act on one another; {verdict}."
    return f"Largest force of a turn, {model}, all three over alone: {factors}. {claim}"


def oiled(model: str, runs: dict):
    """With oil: eccentricity ratio of each joint over the last turn on the left, its force on the
    right.
    """
    figure = sheet(9.0, 7.2)
    panels = figure.subplots(3, 2, sharex=True)
    for row, name in zip(panels, JOINTS, strict=True):
        for case, shown in ((name, ALONE), (ALL, TOGETHER)):
            run = runs[case]
            angle, last, xlabel = abscissa(run, "angle", 1.0)
            joint = run.joint(name)
            line(
                row[0], angle, np.hypot(*joint.eccentricity[last].T) / run.clearances[name], **shown
            )
            line(row[1], angle, np.hypot(*joint.force[last].T), **shown)
        finish(row[0], f"eccentricity ratio\njoint {name} [-]", "", legend=False)
        finish(row[1], f"force in joint {name} [N]", "", legend=False)
        row[0].set_ylim(0.0)
    panels[-1, 0].set_xlabel(xlabel)
    say(figure, interaction(model, runs))
    return finished(figure, panels.ravel(), xlabel)


def dry(runs: dict):
    """Dry: force of each joint over the last turn, alone and together, and correlations of contacts
    between joints.
    """
    figure = sheet(9.5, 8.4)
    grid = figure.add_gridspec(4, 2, height_ratios=(1.0, 1.0, 1.0, 1.2))
    for i, name in enumerate(JOINTS):
        pair = [figure.add_subplot(grid[i, k]) for k in (0, 1)]
        for axes, case, shown in zip(pair, (name, ALL), (ALONE, TOGETHER), strict=True):
            angle, last, xlabel = abscissa(runs[case], "angle", 1.0)
            line(
                axes,
                angle,
                1e-3 * np.hypot(*runs[case].joint(name).force[last].T),
                **shown | {"lw": 0.5},
            )
            finish(
                axes, f"force in joint\n{name} [kN]" if axes is pair[0] else "", "", legend=False
            )
            axes.set(xlim=(0.0, 360.0), xticks=range(0, 361, 45))
            if i == 0:
                where = (
                    "its joint alone has clearance" if case == name else "all three have clearance"
                )
                axes.set_title(where, fontsize="medium")
            if name == JOINTS[-1]:
                axes.set_xlabel(xlabel)
        top = max(axes.get_ylim()[1] for axes in pair)
        for axes in pair:
            axes.set_ylim(-0.03 * top, top)
    axes = figure.add_subplot(grid[3, :])
    for i, (first, second) in enumerate((("B", "C"), ("C", "E"), ("B", "E"))):
        lag, correlated = correlation(runs[ALL], first, second)
        line(axes, lag, correlated, **stroke(i, 3) | {"lw": 1.2, "label": f"{first} and {second}"})
    finish(axes, "correlation of\ncontact forces [-]", "lag of the second joint [ms]", legend=False)
    axes.legend(fontsize="small", loc="upper right")
    say(figure, interaction(DRY, runs))
    figure.align_ylabels()
    return figure


def correlation(run, first: str, second: str) -> tuple[np.ndarray, np.ndarray]:
    """Lags [ms] and the correlation of two joints' contact forces beyond their course over a
    turn.
    """
    step = 1e3 * float(np.diff(run.time[:2])[0])
    a, b = (contact_force(run, name, max(round(AVERAGED / step), 1)) for name in (first, second))
    most = round(LAG / step)
    shifts = np.arange(-most, most + 1)
    inner = slice(most, len(a) - most)
    products = np.array([(a[inner] * b[most + s : len(b) - most + s]).mean() for s in shifts])
    return shifts * step, products / (a.std() * b.std())


def contact_force(run, name: str, width: int) -> np.ndarray:
    """Contact force of the settled turns, averaged over `width` samples, less its mean over turns,
    mean 0.
    """
    force = np.convolve(run.joint(name).contact_force, np.full(width, 1.0 / width), "same")[
        settled(run)
    ][:-1]
    turns = round(run.time[-1] / run.turn) - SETTLE
    by_turn = force.reshape(turns, -1)
    return (by_turn - by_turn.mean(axis=0)).ravel()


def numbers(run, name: str) -> list:
    """Force, gap, contacts and losses of a joint."""
    now, joint, turns = settled(run), run.joint(name), round(run.time[-1] / run.turn) - SETTLE
    force, gap = np.hypot(*joint.force[now].T), joint.gap[now]
    peak = float(by_turn(run, SETTLE, forces=True)[f"joint_{name}_force_peak"].values.mean())
    deepest = run.clearances[name] - of_turn(run.clearances[name] - gap, turns)
    count, share = "-", "-"
    if "contact_force" in joint:
        touches = contacts_of(run, name, settle=SETTLE)
        count, share = len(touches.time) / turns, 100.0 * touches.share
    lost = float(np.ptp(joint.dissipated[now])) / turns
    return [
        peak,
        rms(force),
        1e6 * deepest,
        1.0 - deepest / run.clearances[name],
        count,
        share,
        lost,
    ]
