"""A dry joint on worn outlines: Lyapunov exponent, forces, spread of the turns.

Group: joints

Answers: no figure of the sources; Mukras et al. and Flores (2009) state that wear changes the
motion.

Reproduced: a slider-crank with a dry joint between rod and slider, on worn outlines. They have the
shape of its first turns, scaled to depths of up to 0.3 clearances. For each: the largest Lyapunov
exponent with twice its error, the largest joint force, and the spread of the slider's acceleration
once a turn. The picture states the verdict on each exponent. Exponents differ where their intervals
do not overlap; the remark of the table states it.

Assumed: 0.1 mm of clearance at 300 rpm, a coefficient of restitution of 0.5, Winkler's contact. The
shape of the wear of a chaotic motion is that of four turns.

Not comparable: all numbers.
"""

from dataclasses import replace

import numpy as np
from clearance.paper_figures import workshop
from clearance.postprocess import figures

import clearance as cl
from clearance.laws.outline import worn
from clearance.motions.lyapunov import SURE, lyapunov

CASE = {
    "model": "dry",
    "contact": "winkler",
    "speed": cl.rpm(300),
    "clearance": 1e-4,
    "restitution": 0.5,
}
DEPTHS = (0.0, 0.1, 0.3)  # over the clearance
TURNS, SETTLE, SECTION = 40, 3, 24  # of the exponent, left out, of the section
JOINT = "C"


def draw(work: workshop.Workshop) -> None:
    turns = work.less(TURNS, 8)
    shape = scar(work.less(4.0, 2.0))
    rows, sections = [], []
    for depth in DEPTHS[:: work.less(1, 4)]:
        scene = on(depth * CASE["clearance"] * shape)
        exponent = lyapunov(scene, turns=turns, settle=SETTLE, rtol=1e-9)
        with cl.simulate(scene, turns=work.less(SECTION, turns), samples_per_turn=180) as run:
            late = slice(SETTLE * 180, None)
            force = np.hypot(run.joint(JOINT).force_x, run.joint(JOINT).force_y)[late]
            sections.append(run["slider"].ax[SETTLE * 180 :: 180])
        number = exponent.per_turn, exponent.error, float(force.max()), float(np.std(sections[-1]))
        rows.append([depth, *number, exponent.verdict])
    work.keep(picture(rows, sections))
    heads = ("depth over clearance", "exponent [1/turn]", "its error", "largest force [N]")
    spread = [float(np.std(section)) for section in sections]
    remarks = (
        f"Spread of the section over that of the unworn joint: {spread[-1] / spread[0]:.2g}. "
        f"{compared(rows[0], rows[-1])}"
    )
    work.table((*heads, "spread of the acceleration [m/s2]", "verdict"), rows, remarks=remarks)


def scar(turns: float) -> np.ndarray:
    """Shape of the wear of the first turns, its largest value 1."""
    scene = cl.load_case("slider_crank", **CASE, wear=1e-15)
    with cl.simulate(scene, turns=turns) as run:
        depth = run.facts(f"joints/{JOINT}/wear")["worn_bearing"]
    smooth = sum(np.roll(depth, k) for k in range(-4, 5))
    return smooth / smooth.max()


def on(depths: np.ndarray) -> cl.Scene:
    """The mechanism on a worn outline [m]."""
    scene = cl.load_case("slider_crank", **CASE)

    def element(one):
        return replace(one, outline=worn(bearing=depths)) if one.name == JOINT else one

    return scene.rebuilt(element=element)


def compared(first: list, last: list) -> str:
    """Verdict on two outlines: exponents that differ by more than twice their errors, or not."""
    change, error = last[1] - first[1], SURE * float(np.hypot(first[2], last[2]))
    words = f"from depth {first[0]:g} to {last[0]:g} changes by {change:.2g} +- {error:.2g} a turn"
    verdict = "wear changes it" if abs(change) > error else "this does not decide"
    return f"The exponent {words}: {verdict}."


def picture(rows: list, sections: list):
    """Exponent, force and section over the depth."""
    figure = figures.sheet(11.0, 4.0)
    chaos, force, section = figure.subplots(1, 3)
    values = np.array([row[:-1] for row in rows], dtype=float)
    chaos.errorbar(values[:, 0], values[:, 1], SURE * values[:, 2], fmt="o", ms=4, capsize=3)
    for depth, exponent, *_, verdict in rows:
        chaos.annotate(verdict, (depth, exponent), (5, 4), textcoords="offset points", fontsize=8)
    chaos.margins(x=0.3)
    chaos.set_title("bars: twice the error", fontsize="medium")
    chaos.axhline(0.0, color="k", lw=0.6)
    figures.finish(chaos, "largest Lyapunov exponent [1/turn]", "depth over clearance [-]")
    force.plot(values[:, 0], values[:, 3], "o-", ms=4, color="C3")
    figures.finish(force, "largest joint force [N]", "depth over clearance [-]")
    for depth, cut in zip(values[:, 0], sections, strict=True):
        section.plot(np.full(len(cut), depth), cut, ".", ms=4, color="C0")
    figures.finish(section, "slider acceleration once a turn [m/s²]", "depth over clearance [-]")
    return figure
