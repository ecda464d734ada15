"""Lives at the points of a sweep: each has a directory, `lives/KEY`, and a row of metrics.

A point that was stopped goes on from its last stage. Its metrics are those of the run of its last
stage, and columns of the life: depths, volumes, the error of the depth, turns to a depth.
"""

import math
import time
from collections.abc import Mapping
from dataclasses import asdict, fields
from inspect import signature
from pathlib import Path

import numpy as np

from clearance.files.locks import folder_at
from clearance.metrics.metrics import Metric, Metrics, described
from clearance.scene.scene import Scene
from clearance.sweeping.journal import DONE, Outcome
from clearance.values import checks
from clearance.wearing.life import Driver, Plan, in_hand, wear
from clearance.wearing.life_record import Life

NAMES = tuple(f.name for f in fields(Plan))
DEFAULTS = {n: p.default for n, p in signature(wear).parameters.items() if n in NAMES}


def planned(life: Mapping[str, object], options: Mapping[str, object]) -> dict[str, object]:
    """Options of a sweep of lives; life: arguments of `wear`, and `depth` [m] to count turns to.

    options: those of the sweep, of which lives take rtol and samples_per_turn. Raises ValueError
    for what is none.
    """
    if extra := sorted(set(options) - {"rtol", "samples_per_turn"}):
        raise ValueError(f"{extra[0]} is no option of lives; their turns stand in life")
    asked = {**options, **life}
    depth = asked.pop("depth", None)
    if extra := sorted(set(asked) - set(NAMES)):
        raise ValueError(f"a life has no option {extra[0]}; it has {', '.join((*NAMES, 'depth'))}")
    if "turns" not in asked:
        raise ValueError("a life needs turns, its length")
    asked["turns"] = checks.positive("turns", asked["turns"])
    plan = asdict(Plan(**(DEFAULTS | asked)))
    life_plan = plan | {"depth": None if depth is None else checks.positive("depth", depth)}
    run = {n: plan[n] for n in ("rtol", "samples_per_turn")}
    return {"turns": float(plan["settle"] + plan["average"]), **run, "life": life_plan}


def folder_of(folder: Path, key: str) -> Path:
    """Directory of the life of a point."""
    return folder_at(Path(folder) / "lives") / key


def point(
    life: Mapping[str, object], scene: Scene, folder: Path, index: int, key: str, inputs: dict
) -> Outcome:
    """Outcome of the life of a point.

    A worker of a cluster goes on when its driver was killed; a second one waits for its end.
    """
    began = time.perf_counter()
    plan = Plan(**{n: v for n, v in life.items() if n != "depth"})
    here = folder_of(folder, key)
    with in_hand(here, wait=True):
        ended = Driver(scene, plan, here, accept_changes=None).go()
    metrics = columns(ended, life["depth"])
    return Outcome(
        index,
        key,
        DONE,
        metrics={n: float(m.value) for n, m in metrics.items()},
        known=described(metrics),
        wall=time.perf_counter() - began,
        made=inputs,
    )


def columns(life: Life, depth: float | None = None) -> Metrics:
    """Metrics of the last stage's run, and of the life; depth: [m], default one clearance."""
    described = life.stages[0].get("known", {})
    last = life.stages[-1]["metrics"]
    metrics = {n: Metric(v, *described[n]) for n, v in last.items() if n in described}
    metrics["life_error"] = Metric(
        float(life.error[-1]), "m", "depth that the jumps may have missed"
    )
    metrics["life_stages"] = Metric(float(len(life.stages)), "1", "stages of the life")
    for joint, size in life.asked["joints"].items():
        for surface in size["wears"]:
            worn, name = life.depth(joint, surface), f"joint_{joint}_{surface}"
            deep = worn.max(axis=1)
            aim = size["clearance"] if depth is None else depth
            metrics[f"{name}_depth"] = Metric(
                float(deep[-1]), "m", f"largest depth of the {surface}"
            )
            angle = math.radians(float(worn[-1].argmax()))
            metrics[f"{name}_depth_angle"] = Metric(angle, "rad", "its angle on the worn body")
            volume = float(life.volume(joint, surface)[-1])
            metrics[f"{name}_volume"] = Metric(volume, "m3", f"volume worn off the {surface}")
            text = "turns until the largest depth is the requested one, default one clearance"
            turns = turns_to(life.turns, deep, aim)
            metrics[f"{name}_turns_to_depth"] = Metric(turns, "1", text)
    return metrics


def turns_to(turns: np.ndarray, deep: np.ndarray, aim: float) -> float:
    """Turns at which a growing depth reaches an aim; nan if it does not.

    A cubic between two stages. Its slope at a stage is that of the mean wear of a turn on both
    sides: at most twice that of the chord, so that the turns grow (Fritsch and Carlson, SIAM J.
    Numerical Analysis 17, 1980, 238).
    """
    beyond = np.flatnonzero(deep >= aim)
    if not len(beyond) or beyond[0] == 0:
        return math.nan
    k = int(beyond[0])
    wear, grown = np.diff(deep) / np.diff(turns), deep[k] - deep[k - 1]
    t = (aim - deep[k - 1]) / grown
    first, second = (grown / wear[max(i - 1, 0) : i + 1].mean() for i in (k - 1, k))
    chord = turns[k] - turns[k - 1]
    bend = t * (1.0 - t) * ((first - chord) * (1.0 - t) - (second - chord) * t)
    return float(turns[k - 1] + t * chord + bend)
