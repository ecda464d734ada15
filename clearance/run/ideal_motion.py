"""Motion of the sliding bodies were all joints ideal: what a run with clearances deviates from."""

import dataclasses

import numpy as np

from clearance.mechanism.build import build
from clearance.results.extremes import guides
from clearance.run.options import Span
from clearance.run.run import Run
from clearance.scene.scene import Scene, idealised
from clearance.stepping import status as codes

MOST_KEPT = 64  # ideal motions held in memory
_motions: dict[tuple, dict | None] = {}


def ideal_motion(scene: Scene, span: Span, described: dict) -> dict | None:
    """Position [m] and acceleration [m/s2] along its guide of each body that slides on the ground,
    at the samples of a run. None where nothing slides, or where ideal joints leave a freedom, so
    that there is no one ideal motion.

    Where one drive at constant speed moves everything the motion is that at unit speed, stretched:
    it is worked out once for all speeds.
    """
    motion = _unit_motion(scene, span, described)
    rate = rate_of(described)
    return motion and {body: (x, a * rate**2) for body, (x, a) in motion.items()}


def rate_of(described: dict) -> float:
    """Speed of the one drive at constant speed that moves a scene [rad/s or m/s]; 1 where it is not
    so.
    """
    drives = [d for d in described["loads"] if d["type"] == "Drive"]
    return abs(drives[0]["speed"]) if len(drives) == 1 and drives[0]["speed"] else 1.0


def _unit_motion(scene: Scene, span: Span, described: dict) -> dict | None:
    """The ideal motion at unit speed where one drive moves everything, else as it is; see
    `ideal_motion`.
    """
    slides = guides(described)
    if not slides:
        return None
    drives = scene.drives
    steady = len(drives) == 1 and bool(drives[0].speed)
    rate = rate_of(described)
    # of the same turns at another speed only rounding differs: no run may depend on which was first
    angle = float(f"{span.until * rate:.14g}")
    key = (_kinematics(described, steady), angle, span.samples)
    if key not in _motions:
        if len(_motions) == MOST_KEPT:
            _motions.clear()
        _motions[key] = _motion(scene, rate, Span(angle, span.samples), slides)
    return _motions[key]


def _kinematics(scene: dict, steady: bool) -> tuple:
    """Parts of a scene's description on which the ideal motion depends."""
    bodies = tuple(
        (b["name"], str(b["points"]), str(b["com"]), b["angle"], str(b["position"]))
        for b in scene["bodies"]
    )
    joints = tuple(
        (j["name"], str(j["a"]), str(j["b"]), str(j.get("axis")), j.get("angle"))
        for j in scene["joints"]
    )
    drives = tuple(
        (
            str(d["target"]),
            d["speed"] > 0.0 if steady else d["speed"],
            str(d["motion"]),
            str(d["start"]),
        )
        for d in scene["loads"]
        if d["type"] == "Drive"
    )
    return bodies, joints, drives


def moves(path: tuple) -> bool:
    """True where the ideal motion depends on a number of a scene's description, the speed of a
    drive left out.
    """
    part, _, field, *_ = (*path, None, None)
    numbers = {
        "bodies": ("points", "com", "angle", "position"),
        "joints": ("a", "b", "axis", "angle"),
    }
    return (
        field in numbers.get(part, ()) or part == "loads" and field in ("target", "motion", "start")
    )


def moving(scene: Scene, rate: float) -> Scene:
    """Ideal joints and the drives of the scene, these so many times slower, with what they need."""
    ideal = idealised(scene)
    slower = [dataclasses.replace(d, speed=d.speed / rate) if d.speed else d for d in ideal.drives]
    parts = [*ideal.joints, *slower]
    for part in parts:
        for companion in part.companions().values():
            if all(companion is not p for p in parts):
                parts.append(companion)
    return Scene(*parts, name=scene.name)


def _motion(scene: Scene, rate: float, span: Span, slides: dict) -> dict | None:
    try:
        mechanism = build(moving(scene, rate), ledger=False)
    except ValueError:  # ideal joints do not fit together
        return None
    if mechanism.size:
        return None
    run = Run(mechanism, span)
    _, rows, code = run.trajectory()
    if code != codes.DONE or not np.isfinite(rows).all():  # ideal joints cannot go all the way
        return None
    column = {c.path: i for i, c in enumerate(mechanism.layout.channels)}
    motion = {}
    for body, (dx, dy) in slides.items():
        x, y, ax, ay = (rows[:, column[f"bodies/{body}/{n}"]] for n in ("x", "y", "ax", "ay"))
        motion[body] = (x * dx + y * dy, ax * dx + ay * dy)
    return motion
