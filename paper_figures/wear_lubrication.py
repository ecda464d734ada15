"""Wear of a dry, a mixed and a lubricated bearing at equal load.

Group: joints

Answers: no figure of the sources; studies of worn joints with oil (Zhu, Li and Shen 2019) state
that oil cuts wear by orders of magnitude.

Reproduced: depth that a metre of sliding wears off, over the speed of the journal. The contact of a
dry bearing carries all of the load. Asperities of a mixed one carry the rest beside the film, and a
film alone wears nothing. What wear makes of the mixed bearing: film thickness ratio and share of
the asperities over the life at one speed.

Assumed: a short bearing of steel (radius 10 mm, length 8 mm, clearance 50 um, roughness 0.8 um)
under 400 N at rest in oil of 50 mPa s. Archard's law has one coefficient, 1e-15 m2/N.

Not comparable: all numbers; no source has such a bearing.
"""

import numpy as np
from clearance.paper_figures import workshop
from clearance.postprocess import figures

import clearance as cl

CLEARANCE, ROUGHNESS, LOAD, WEAR = 5e-5, 0.8e-6, 400.0, 1e-15
SPEEDS = np.geomspace(0.5, 60.0, 13)
SLOW, TURNS = 2.0, 4000.0
MODELS = ("dry", "mixed", "lubricated")


def bearing(model: str, speed: float) -> cl.Scene:
    """A journal under a load at rest."""
    body = cl.Body("rotor", 0.5, 1e-4)
    solids = {
        "contact": cl.winkler(layer_modulus=1e13, restitution=0.5),
        "wear": cl.archard(coefficient=WEAR),
    }
    film = {"film": cl.laws.short_film(), "lubricant": cl.Lubricant(0.05), "roughness": ROUGHNESS}
    both = {"transition": cl.laws.load_sharing(), "asperity": cl.greenwood_tripp()}
    slots = {"dry": solids, "lubricated": film, "mixed": solids | film | both}[model]
    start = CLEARANCE + 1.5e-6 if model == "dry" else 0.95 * CLEARANCE
    joint = cl.ClearanceRevolute(
        cl.ground,
        body,
        name="B",
        radius=0.01,
        clearance=CLEARANCE,
        length=0.008,
        eccentricity=(start, 0.0),
        **slots,
    )
    load, drive = cl.Force(body.at(0, 0), x=LOAD), cl.Drive(body, speed=speed)
    return cl.Scene(joint, load, drive, gravity=(0, 0), name=model)


def draw(work: workshop.Workshop) -> None:
    speeds = SPEEDS[:: work.less(1, 6)]
    rows = [measured(model, float(speed)) for model in MODELS for speed in speeds]
    life = work.life(bearing("mixed", SLOW), turns=work.less(TURNS, 300.0), settle=1, average=1)
    work.keep(picture(rows, life))
    heads = (
        "model",
        "speed [rad/s]",
        "film thickness ratio",
        "share of the solids",
        "wear [um/km]",
    )
    work.table(heads, rows, remarks="Wear: volume over the bearing's area and the way slid.")


def measured(model: str, speed: float) -> list:
    """Settled numbers of a bearing, from the second of two turns."""
    with cl.simulate(bearing(model, speed), turns=2, rtol=1e-6) as run:
        joint = run.joint("B")
        ratio = joint.film_thickness_ratio[-1] if model != "dry" else 0.0
        share = joint.asperity_share[-1] if model == "mixed" else float(model == "dry")
        depth = 0.0
        if model != "lubricated":
            half = len(run.time) // 2
            worn = joint.wear_volume_bearing[-1] - joint.wear_volume_bearing[half]
            way = 0.01 * speed * (run.time[-1] - run.time[half])
            depth = worn / (2.0 * np.pi * 0.01 * 0.008) / way
    return [model, speed, float(ratio), float(share), 1e9 * float(depth)]


def picture(rows: list, life: cl.Life):
    """Wear and share over speed; film thickness ratio and depth over the life."""
    figure = figures.sheet(11.0, 4.4)
    wear, film, ageing = figure.subplots(1, 3)
    for model, colour in zip(MODELS[:2], ("C3", "C0"), strict=True):
        points = np.array([r[1:] for r in rows if r[0] == model])
        shown = points[:, 3] > 1e-9
        wear.loglog(points[shown, 0], points[shown, 3], "o-", ms=3, color=colour, label=model)
    figures.finish(wear, "wear over way [µm/km]", "speed of the journal [rad/s]")
    wear.set_ylim(1e-5, None)
    for model, colour in zip(MODELS[1:], ("C0", "C2"), strict=True):
        points = np.array([r[1:] for r in rows if r[0] == model])
        film.semilogx(points[:, 0], points[:, 1], "o-", ms=3, color=colour, label=model)
    figures.finish(film, "film thickness ratio [-]", "speed of the journal [rad/s]")
    depth = 1e6 * life.depth("B").max(axis=1)
    ageing.plot(life.turns, depth, "o-", ms=3, color="C3", label="depth")
    figures.finish(ageing, "largest depth [µm]", f"turns at {SLOW:g} rad/s")
    other = ageing.twinx()
    ratio = life.metric("joint_B_film_thickness_ratio_min")
    other.plot(life.turns, ratio, "s-", ms=3, color="C0", label="least film thickness ratio")
    other.set_ylabel("film thickness ratio [-]")
    figures.legend_above(ageing, other)
    return figure
