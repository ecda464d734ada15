"""Error against run time of jumps over a machine's life.

Group: measured

Answers: no figure of the sources; it is the evidence behind `clearance wear`.

Reproduced: the depth of a loaded bushing after 1000 turns by dynamics and jumps. The comparison is
the closed form of an elastic foundation under a load at rest. Implicit jumps replay the load path
of a turn and are stable at any length. Explicit ones (wear of a turn times turns) are those of the
literature. The dashed line is what running every turn would cost.

Assumed: 1000 N at rest in a bearing of 10 mm radius and 0.1 mm clearance, Archard's law; stages of
one turn.

Not comparable: run times belong to the machine; their ratios do not.
"""

import shutil
import time

import numpy as np
from clearance.paper_figures import workshop
from clearance.postprocess import figures

import clearance as cl

TURNS = 1000.0
RADIUS, CLEARANCE, LENGTH, MODULUS, FORCE, WEAR = 0.01, 1e-4, 0.02, 1e12, 1000.0, 1e-13
JUMPS = (100.0, 200.0, 300.0, 500.0)
KINDS = ("replay", "linear")
STABLE = 2.0 / (2.0 * np.pi * RADIUS * WEAR * MODULUS)  # turns of an explicit jump


def bushing(eccentricity: float) -> cl.Scene:
    """A journal that turns once a second under a load at rest."""
    body = cl.Body("rotor", 0.5, 1e-4)
    joint = cl.ClearanceRevolute(
        cl.ground,
        body,
        name="B",
        radius=RADIUS,
        clearance=CLEARANCE,
        length=LENGTH,
        eccentricity=(eccentricity, 0.0),
        contact=cl.winkler(layer_modulus=MODULUS, restitution=1.0),
        wear=cl.archard(coefficient=WEAR),
    )
    load = cl.Force(body.at(0, 0), x=FORCE, name="load")
    drive = cl.Drive(body, speed=2.0 * np.pi, name="d")
    return cl.Scene(joint, load, drive, gravity=(0, 0), name="bushing")


def exact(turns: float, steps: int = 20000) -> tuple[float, float]:
    """Eccentricity of the unworn joint and depth at its deepest place after `turns` turns [m].

    p = K (e_0 - c) exp(-l phi) + int K e' exp(-l (phi - s)) ds, l = k R K, and
    e' = k F / (L (a + sin a cos a)) with cos a = c / e; the depth is e - c - p / K.
    """
    low, high = 0.0, 0.5 * np.pi
    for _ in range(60):
        a = 0.5 * (low + high)
        force = MODULUS * RADIUS * LENGTH * CLEARANCE * (a / np.cos(a) - np.sin(a))
        low, high = (a, high) if force < FORCE else (low, a)
    start = e = CLEARANCE / np.cos(0.5 * (low + high))
    p, step = MODULUS * (e - CLEARANCE), 2.0 * np.pi * turns / steps
    decay = WEAR * RADIUS * MODULUS

    def growth(e):
        a = np.arccos(CLEARANCE / e)
        return WEAR * FORCE / (LENGTH * (a + np.sin(a) * np.cos(a)))

    for _ in range(steps):
        rate = growth(e + 0.5 * step * growth(e))
        p = p * np.exp(-decay * step) + MODULUS * rate * (1.0 - np.exp(-decay * step)) / decay
        e += rate * step
    return start, e - CLEARANCE - p / MODULUS


def draw(work: workshop.Workshop) -> None:
    turns = work.less(TURNS, 100.0)
    start, depth = exact(turns)
    jumps = [jump * turns / TURNS for jump in JUMPS]
    lives = (lived(work, kind, jump, turns, depth, start) for kind in KINDS for jump in jumps)
    rows = [row for row in lives if row]
    one = min(row[3] / row[4] for row in rows)  # CPU of a stage, which is a turn
    figure = figures.sheet(7.2, 5.0)
    axes = figure.subplots()
    for kind, mark in zip(KINDS, "os", strict=True):
        points = [r for r in rows if r[0] == kind]
        axes.loglog([r[3] for r in points], [r[2] for r in points], mark + "-", label=kind)
        for r in points:
            axes.annotate(f"{r[1]:g}", (r[3], r[2]), textcoords="offset points", xytext=(4, 4))
    axes.axvline(one * turns, color="k", ls="--", lw=1.0, label="every turn run")
    figures.finish(axes, "error of the depth [-]", "CPU time [s]")
    axes.set_title(f"{turns:g} turns of a bushing, numbers: turns of a jump", pad=24)
    work.keep(figure)
    heads = ("jumps", "turns of a jump", "error", "CPU [s]", "stages", "stated error")
    remarks = (
        f"Errors over the depth of {1e6 * depth:.5g} um by the closed form. Explicit jumps are "
        f"unstable beyond {STABLE:.3g} turns and refused there. A turn takes {one:.2g} s at least."
    )
    work.table(heads, rows, remarks=remarks)


def lived(work, kind: str, jump: float, turns: float, depth: float, start: float) -> list | None:
    """Row of a life in jumps of one length; None where that is refused."""
    if kind == "linear" and jump > STABLE or jump > 0.5 * turns:
        return None
    folder = work.shared / f"{work.name}-{kind}-{jump:g}"
    shutil.rmtree(folder, ignore_errors=True)
    began = time.process_time()
    plan = {"settle": 0, "average": 1, "share": 1.0, "tolerance": 1.0}
    life = cl.wear(
        bushing(start), turns=turns, directory=folder, jump=kind, jump_turns=jump, **plan
    )
    spent = time.process_time() - began
    error = abs(float(life.depth("B")[-1][0]) / depth - 1.0)
    return [kind, jump, error, spent, len(life.stages), float(life.error[-1]) / depth]
