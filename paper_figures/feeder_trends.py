"""Trends of the six-bar feeder with transitional joints over speed, clearance and number of joints:
a table.

Group: feeder

Answers: Jin et al. (2023). They state that impacts grow with the crank's speed, with the clearance
and with the number of clearance joints, and that joints act on one another.

Reproduced: largest acceleration of the slider, largest force in joint B and largest moment of the
crank at 150, 300 and 600 rpm. Radial clearances are 0.05, 0.1 and 0.2 mm. The mechanism is ideal,
or has transitional joints at B, at B and C, and at B, C and E. Beside each number stands that with
elastic surfaces. The picture has the accelerations over the ideal ones, filled marks for elastic
surfaces. It states for each statement at which clearances it is met.

Assumed: parameter set feeder-A, oil of 5 mPa s, half-cosine memberships, runs of four turns of
which two are left out.

Not comparable: every amplitude; the source's lengths, masses and clearances were not in the part we
had.
"""

import numpy as np
from clearance.paper_figures import workshop
from clearance.paper_figures.feeder_slider import GROWN, IDEAL, say
from clearance.postprocess.figures import finish, legend_below, marker, sheet, stroke

import clearance as cl

SPEEDS = (150, 300, 600)
CLEARANCES = (0.05, 0.1, 0.2)
JOINTS = ("B", "B,C", "B,C,E")
#: surfaces of the middle state
SURFACES = {"rigid": {}, "elastic": {"elastic": "true"}}
TURNS, SETTLE = 4, 2
#: quantity, metrics of which the largest counts
QUANTITIES = {
    "largest abs. acceleration [m/s2]": ("slider_acceleration_min", "slider_acceleration_max"),
    "largest force B [N]": ("joint_B_force_max",),
    "largest abs. crank moment [N m]": ("drive_crank_torque_min", "drive_crank_torque_max"),
}
ACCELERATION, FORCE, _ = QUANTITIES
#: place of the speed at which clearances and numbers of joints are compared
MIDDLE = 1


def draw(work: workshop.Workshop) -> None:
    grid = cl.grid(
        speed=[cl.rpm(n) for n in SPEEDS],
        clearance=[1e-3 * c for c in CLEARANCES],
        joints=list(JOINTS),
    )
    options = {"turns": TURNS, "settle": SETTLE, "channels": []}
    mixed = {
        name: shaped(
            work.sweep("six_bar_feeder", grid, fixed={"model": "mixed"} | surfaces, **options), grid
        )
        for name, surfaces in SURFACES.items()
    }
    alone = cl.grid(speed=[cl.rpm(n) for n in SPEEDS])
    ideal = shaped(work.sweep("six_bar_feeder", alone, fixed={"model": "ideal"}, **options), alone)
    heads = ["joints", "rpm", "quantity", *(f"{c:g} mm" for c in CLEARANCES)]
    remark = "Behind the slash: elastic surfaces, where they differ in the digits shown."
    work.table(heads, rows(mixed, ideal), remarks=remark)
    work.keep(growth(mixed, ideal))


def shaped(sweep, points) -> dict[str, np.ndarray]:
    """Each quantity over the grid of its points."""
    shape = [count for _, count in points.axes]
    return {
        name: np.max([np.abs(sweep.metrics[m]) for m in metrics], axis=0).reshape(shape)
        for name, metrics in QUANTITIES.items()
    }


def rows(mixed: dict, ideal: dict) -> list[list]:
    """A row for each set of joints, speed and quantity; clearances side by side."""
    lines = [
        [IDEAL, n, name, *[f"{ideal[name][i]:.4g}"] * len(CLEARANCES)]
        for name in QUANTITIES
        for i, n in enumerate(SPEEDS)
    ]
    for name in QUANTITIES:
        for k, joints in enumerate(JOINTS):
            for i, n in enumerate(SPEEDS):
                pairs = zip(*(of[name][i, :, k] for of in mixed.values()), strict=True)
                lines.append([joints.replace(",", " "), n, name, *(both(a, b) for a, b in pairs)])
    return lines


def both(value: float, other: float) -> str:
    first, second = f"{value:.4g}", f"{other:.4g}"
    return first if first == second else f"{first} / {second}"


def verdicts(mixed: dict, ideal: dict) -> str:
    """A line for each statement of the source: what grows by how much, and at which clearances it
    is met.

    Arrays of `mixed` are (speeds, clearances, joints), those of `ideal` (speeds,).
    """
    over = mixed[ACCELERATION] / ideal[ACCELERATION][:, None, None]
    impacts, force = mixed[ACCELERATION][MIDDLE], mixed[FORCE][MIDDLE]
    by_speed = over[-1, :, 0] / over[0, :, 0]
    by_size = impacts[-1] / impacts[0]
    sizes, numbers = (
        [f"{c:g} mm" for c in CLEARANCES],
        [f"{1 + j.count(',')} joints" for j in JOINTS],
    )
    by_number, by_neighbours = (v[:, -1] / v[:, 0] for v in (impacts, force))
    over_speeds, speed = f"{SPEEDS[0]} to {SPEEDS[-1]} rpm", f"{SPEEDS[MIDDLE]} rpm"
    lines = (
        (f"Impacts grow with speed (B, {over_speeds}, over the ideal)", by_speed, sizes),
        (
            f"Impacts grow with clearance ({CLEARANCES[0]:g} to {sizes[-1]}, {speed})",
            by_size,
            numbers,
        ),
        (f"Impacts grow with the number of joints ({speed})", by_number, sizes),
        (f"Neighbours act on the force in B ({speed})", by_neighbours, sizes),
    )
    return "\n".join(f"{claim}: {verdict(*values)}; {listed(*values)}." for claim, *values in lines)


def listed(factors: np.ndarray, names: list[str]) -> str:
    """Factors by name; of numbers with one unit the unit once."""
    units = {name.partition(" ")[2] for name in names}
    numbers = ", ".join(name.partition(" ")[0] for name in names)
    grown = ", ".join(f"×\u00a0{factor:.3g}" for factor in factors)
    return f"{grown} with {numbers} {' '.join(units)}"


def verdict(factors: np.ndarray, names: list[str]) -> str:
    """Places where a statement of growth is met; names in the order in which it should show more
    and more.
    """
    met = factors > GROWN
    if met.all() or not met.any():
        return "met" if met.all() else "not met"
    first = int(met.argmax())
    if met[first:].all():
        return f"met from {names[first]} on"
    return f"met with {' and '.join(n for n, m in zip(names, met, strict=True) if m)} only"


def growth(mixed: dict, ideal: dict):
    """Largest acceleration over the ideal one by clearance, a panel for each speed."""
    figure = sheet(9.5, 5.8)
    panels = figure.subplots(1, len(SPEEDS), sharey=True)
    rigid, elastic = (
        of[ACCELERATION] / ideal[ACCELERATION][:, None, None] for of in mixed.values()
    )
    for i, (axes, speed) in enumerate(zip(panels, SPEEDS, strict=True)):
        for k, joints in enumerate(JOINTS):
            style = stroke(k, len(JOINTS)) | {"marker": marker(k), "ms": 5, "lw": 1.2}
            name = f"clearance at {joints.replace(',', ', ')}"
            axes.plot(CLEARANCES, rigid[i, :, k], **style, mfc="none", label=name)
            axes.plot(CLEARANCES, elastic[i, :, k], **style | {"ls": ""})
        finish(
            axes,
            "" if i else "largest slider acceleration\nover the ideal one [-]",
            "",
            legend=False,
        )
        axes.set_xlabel("radial clearance [mm]")
        axes.set_xticks(CLEARANCES)
        axes.set_title(f"{speed} rpm", fontsize="medium")
    panels[0].set_yscale("log")
    panels[0].set_yticks([1, 2, 5, 10, 20], ["1", "2", "5", "10", "20"])
    texts = (f"{name.capitalize()} surfaces.\n{verdicts(v, ideal)}" for name, v in mixed.items())
    say(figure, "\n".join(texts))
    legend_below(figure, panels[0])
    return figure
