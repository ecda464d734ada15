"""A bushing over its life: full dynamics with jumps, a closed form, and Dufrane's arc.

Group: joints

Answers: no figure of the sources; Mukras et al. (SAE 2009-01-0403; J. Tribology 132 (2010) 031604)
print the depth of such a bushing over its turns.

Reproduced: the depth of wear_a beside the closed form of a rigid journal under the load path of the
first turn alone. A designer needs no code for that form. The worn outline beside the arc of a
circle that Dufrane measured and films of worn bearings assume: it is a result here. The normal
load over the force, by which a law V = k F s falls short.

Assumed: the set wear-A; Archard's law; stages of one settled turn, jumps of up to 0.3 clearances.

Not comparable: depths and volumes of the source, whose masses, lengths and clearance were not at
hand.
"""

import numpy as np
from clearance.paper_figures import workshop
from clearance.postprocess import figures

import clearance as cl

TURNS = 21400.0
PLAN = {"share": 0.3, "settle": 1, "average": 1}
JOINT = "B"


def draw(work: workshop.Workshop) -> None:
    life = work.life("wear_a", turns=work.less(TURNS, 500.0), **PLAN)
    work.keep(picture(life))
    work.table(*table(life))


def picture(life: cl.Life):
    """Depth over turns, the closed form above it, last outline less its arc, N over F."""
    figure = figures.sheet(11.0, 7.4)
    depth, form, error = (1e6 * v for v in (deepest(life), life.closed_form(JOINT), life.error))
    (top, apart), (ring, ratio) = figure.subplots(2, 2)
    top.plot(life.turns, depth, "o-", ms=3, color="C0")
    figures.finish(top, "largest depth [µm]", "turns", legend=False)
    apart.plot(life.turns[1:], form[1:] - depth[1:], "o-", ms=3, color="C3", label="closed form")
    apart.fill_between(life.turns, -error, error, color="C0", alpha=0.3, label="stated error")
    figures.finish(apart, "above the dynamics [µm]", "turns")
    angle, worn, arc = outline(life)
    ring.plot(angle, 1e6 * (worn - arc), color="C0")
    text = "outline less Dufrane's arc [µm]"
    figures.finish(ring, text, "angle from the deepest place [deg]", legend=False)
    ratio.plot(life.turns, load_over_force(life), "o-", ms=3, color="C2")
    figures.finish(ratio, "normal load over force, by wear [-]", "turns")
    figure.suptitle("wear_a, joint B: a PTFE bushing on a steel pin")
    return figure


def deepest(life: cl.Life) -> np.ndarray:
    """Largest depth of the bearing at each stage [m]."""
    return life.depth(JOINT).max(axis=1)


def outline(life: cl.Life) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Angle [deg], depth of the last stage and Dufrane's arc of the same depth [m].

    The arc lies where it fits best: at the angle of the scar's first harmonic.
    """
    worn, clearance = life.depth(JOINT)[-1], life.asked["joints"][JOINT]["clearance"]
    theta = np.deg2rad(np.arange(360))
    middle = np.angle(worn @ np.exp(1j * theta))
    beside = (np.degrees(theta - middle) + 180.0) % 360.0 - 180.0
    order = np.argsort(beside)
    arc = np.maximum((clearance + worn.max()) * np.cos(np.deg2rad(beside)) - clearance, 0.0)
    return beside[order], worn[order], arc[order]


def load_over_force(life: cl.Life) -> np.ndarray:
    """Worn volume of a turn over k F s of its load path, at each stage."""
    size = life.asked["joints"][JOINT]
    area = size["radius"] * size["length"] * np.deg2rad(1.0)
    worn = area * life.rate(JOINT).sum(axis=1)
    paths = [life.load_path(JOINT, i) for i in range(len(life.stages))]
    return worn / [np.hypot(p[:, 0], p[:, 1]) @ p[:, 3] for p in paths]


def table(life: cl.Life) -> tuple:
    """Heads, rows and remarks: the last stage."""
    depth, form = deepest(life)[-1], life.closed_form(JOINT)[-1]
    _, worn, arc = outline(life)
    heads = ("turns", "depth [um]", "stated error [um]", "closed form [um]", "difference [%]")
    more = ("largest distance from the arc [um]", "rms [um]", "normal load over force", "stages")
    row = [
        life.turns[-1],
        1e6 * depth,
        1e6 * life.error[-1],
        1e6 * form,
        100.0 * (form / depth - 1.0),
        1e6 * float(np.abs(worn - arc).max()),
        1e6 * float(np.sqrt(np.mean((worn - arc) ** 2))),
        float(load_over_force(life)[-1]),
        len(life.stages),
    ]
    return (*heads, *more), [[float(v) for v in row]]
