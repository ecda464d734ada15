"""Three-loop closed chain: driving torque and pin friction, case 2 of Guo, Ju and Wang.

Group: chains

Answers: Guo, Ju and Wang, Aerospace 11 (2024) 368, case 2. Driving torque of the closed chain
without friction, with Coulomb-viscous and with Stribeck friction at the driven joint. Friction in
all ten pins is our extension.

Reproduced: seven links, ten hinges and three loops, decoded from the nine printed vectors (met
within their rounding). Driving torque and all reactions at a crank speed of 0.1 rad/s, with the
printed masses and friction coefficients.

Assumed: the sense of turning, a run of 10 s and pin radius 10 mm in all pins. Also exponent 2 of
the Stribeck term, and viscous friction by the rate alone.

Not comparable: every number; the part of the source we had prints no torque and no error, only that
it agrees with ADAMS. At the constant crank speed, which is the printed Stribeck rate, the source's
Stribeck factor stays at 0.105. Its case shows how friction follows the load, not the Stribeck
curve.
"""

import numpy as np
from clearance.paper_figures import workshop
from clearance.postprocess.drawing import sketch
from clearance.postprocess.figures import finish, legend_below, line, sheet, stroke
from clearance.postprocess.plots import overview

UNTIL = 10.0  # s
#: name in pictures -> parameters of the case
VARIANTS = {
    "Coulomb-viscous, driven joint": {"friction": "coulomb"},
    "Stribeck, driven joint": {"friction": "stribeck"},
    "Coulomb-viscous, all ten pins": {"friction": "coulomb", "where": "all"},
    "Stribeck, all ten pins": {"friction": "stribeck", "where": "all"},
}
CRANK = "ground-g"
NONE = "no friction"


def draw(work: workshop.Workshop) -> None:
    with work.run("three_loop_chain", {"where": "all"}, until=UNTIL) as run:
        work.drawing(overview, run)
        work.drawing(sketch, run, suffix="sketch")
    runs = {
        n: work.inverse("three_loop_chain", p, until=UNTIL, samples=1001)
        for n, p in VARIANTS.items()
    }
    work.keep(driving(runs), "torque")
    everywhere = {n.partition(",")[0]: r for n, r in runs.items() if "all" in n}
    work.keep(pins(everywhere), "pins")
    numbers(work, runs)


def _added(run) -> np.ndarray:
    """Part of friction in the driving torque (samples,) [N m]."""
    return run.drive("crank").torque - run.drive("crank").torque_ideal


def driving(runs: dict):
    """Driving torque, its part for friction, and the force in the driven joint."""
    figure = sheet(7.6, 7.5)
    torque, added, force = figure.subplots(3, 1, sharex=True, height_ratios=(3, 3, 2))
    first = next(iter(runs.values()))
    line(torque, first.time, first.drive("crank").torque_ideal, label=NONE, **stroke(0, 5), lw=1.5)
    for i, (name, run) in enumerate(runs.items(), 1):
        style = stroke(i, 5) | {"lw": 1.4, "label": name}
        line(torque, run.time, run.drive("crank").torque, **style)
        line(added, run.time, _added(run), **style)
        if i in (1, 3, 4):  # at the driven joint alone friction changes no reaction
            line(force, run.time, np.hypot(*run.joint(CRANK).force.T), **style)
    finish(torque, "driving torque [N m]", "", legend=False)
    finish(added, "its part for friction [N m]", "", legend=False)
    added.set_ylim(bottom=0.0)
    finish(force, "force in the\ndriven joint [N]", legend=False)
    figure.align_ylabels()
    legend_below(figure, torque)
    return figure


def pins(runs: dict):
    """Friction torque of each of the ten pins, crank pin first."""
    figure = sheet(10.0, 5.6)
    panels = figure.subplots(2, 5, sharex=True, sharey=True)
    scene = next(iter(runs.values())).scene
    names = sorted(
        (j["name"] for j in scene["joints"]), key=lambda n: (n != CRANK, "ground" not in n)
    )
    for axes, pin in zip(panels.flat, names, strict=True):
        for i, (name, run) in enumerate(runs.items()):
            line(
                axes, run.time, run.joint(pin).friction, label=name, **stroke(3 * i + 1, 6), lw=1.3
            )
        axes.axhline(0.0, color="0.5", lw=0.6)
        axes.set_title(f"{pin}, driven" if pin == CRANK else pin, fontsize="medium")
        finish(axes, "", "", legend=False)
    for axes in panels[-1]:
        axes.set_xlabel("time [s]")
    for axes in panels[:, 0]:
        axes.set_ylabel("friction torque [N m]")
    legend_below(figure, panels[0, 0])
    return figure


def numbers(work: workshop.Workshop, runs: dict) -> None:
    """Driving torques and their parts for friction."""
    first = next(iter(runs.values()))
    heads = (
        "friction",
        "torque at 0 s [N m]",
        "at 10 s [N m]",
        "largest [N m]",
        "at [s]",
        "part for friction, mean [N m]",
        "largest [N m]",
    )
    rows = [[NONE, *_peaks(first.time, first.drive("crank").torque_ideal), 0.0, 0.0]]
    for name, run in runs.items():
        added = _added(run)
        rows.append(
            [
                name,
                *_peaks(run.time, run.drive("crank").torque),
                float(added.mean()),
                float(added.max()),
            ]
        )
    work.table(heads, rows, remarks="Crank speed 0.1 rad/s, pin radius 10 mm (assumed).")


def _peaks(time: np.ndarray, torque: np.ndarray) -> list[float]:
    most = int(torque.argmax())
    return [float(v) for v in (torque[0], torque[-1], torque[most], time[most])]
