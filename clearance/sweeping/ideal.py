"""Motion of the sliding bodies were all joints ideal: what a run with clearances deviates from."""

import dataclasses

from clearance.evidence.variants import idealised
from clearance.loads import Drive
from clearance.mechanism.build import build
from clearance.scene import Scene
from clearance.simulation import Run, Span, choose_method
from clearance.sweeping.metrics import guides

MOST_KEPT = 64  # ideal motions kept in memory
_made: dict[tuple, dict | None] = {}


def ideal_motion(scene: Scene, span: Span, described: dict) -> dict | None:
    """Position [m] and acceleration [m/s2] along its guide of each body that slides on the ground, at the samples of
    a run; None where nothing slides or ideal joints leave a freedom, so that there is no one ideal motion.

    Where one drive at constant speed moves everything the motion is that at unit speed, stretched: it is worked out
    once for all speeds.
    """
    slides = guides(described)
    if not slides:
        return None
    drives = [load for load in scene.loads if isinstance(load, Drive)]
    steady = len(drives) == 1 and bool(drives[0].speed)
    rate = abs(drives[0].speed) if steady else 1.0
    # of the same turns at another speed only rounding differs: no run may depend on which was first
    angle = float(f"{span.until * rate:.12g}")
    key = (_kinematics(described, steady), angle, span.samples)
    if key not in _made:
        if len(_made) == MOST_KEPT:
            _made.clear()
        _made[key] = _motion(_at_unit_speed(scene) if steady else scene, Span(angle, span.samples), slides)
    found = _made[key]
    return found and {body: (x, a * rate**2) for body, (x, a) in found.items()}


def _kinematics(scene: dict, steady: bool) -> tuple:
    """What of a scene's description the ideal motion depends on."""
    bodies = tuple(
        (b["name"], str(b["points"]), str(b["com"]), b["angle"], str(b["position"])) for b in scene["bodies"]
    )
    joints = tuple((j["name"], str(j["a"]), str(j["b"]), str(j.get("axis")), j.get("angle")) for j in scene["joints"])
    drives = tuple(
        (str(d["target"]), d["speed"] > 0.0 if steady else d["speed"], str(d["motion"]), str(d["start"]))
        for d in scene["loads"]
        if d["type"] == "Drive"
    )
    return bodies, joints, drives


def _at_unit_speed(scene: Scene) -> Scene:
    loads = [dataclasses.replace(d, speed=d.speed / abs(d.speed)) if isinstance(d, Drive) else d for d in scene.loads]
    return Scene(*scene.joints, *loads, gravity=scene.gravity, name=scene.name)


def _motion(scene: Scene, span: Span, slides: dict) -> dict | None:
    try:
        mechanism = build(idealised(scene), ledger=False)
    except ValueError:  # ideal joints do not fit together
        return None
    if mechanism.size:
        return None
    run = Run(mechanism, span, 1e-6, choose_method(mechanism))
    _, rows, _ = run.trajectory()
    place = {c.path: i for i, c in enumerate(mechanism.structure.channels)}
    found = {}
    for body, (dx, dy) in slides.items():
        x, y, ax, ay = (rows[:, place[f"bodies/{body}/{n}"]] for n in ("x", "y", "ax", "ay"))
        found[body] = (x * dx + y * dy, ax * dx + ay * dy)
    return found
