"""Scenes made from a scene: the same mechanism with other bodies or joints."""

import dataclasses
from collections.abc import Callable

from clearance.body import Body, Point, ground
from clearance.elements import ClearanceRevolute
from clearance.elements.joint import Joint
from clearance.scene import Scene


def rebuilt(
    scene: Scene, *, body: Callable[[Body], Body] = lambda b: b, joint: Callable[[Joint], Joint] = lambda j: j,
    gravity: tuple[float, float] | None = None,
) -> Scene:  # fmt: skip
    """The scene with every body and joint passed through a function; loads follow to the new ones."""
    bodies = {b: body(b) for b in scene.bodies} | {ground: ground}

    def followed(value):
        if isinstance(value, Point):
            return dataclasses.replace(value, body=bodies[value.body])
        if isinstance(value, Joint):
            return joints[value]
        return bodies[value] if isinstance(value, Body) else value

    joints = {}
    for j in scene.joints:
        joints[j] = joint(dataclasses.replace(j, a=followed(j.a), b=followed(j.b)))
    loads = [
        dataclasses.replace(
            load, **{f.name: followed(getattr(load, f.name)) for f in dataclasses.fields(load) if f.init}
        )
        for load in scene.loads
    ]
    return Scene(*joints.values(), *loads, gravity=scene.gravity if gravity is None else gravity, name=scene.name)


def reduced(scene: Scene) -> dict[str, Scene]:
    """The scene, and what is left of it when parts are taken out, the smallest last: what each part costs."""
    found = {"as it is": scene}
    clearances = scene.clearance_joints
    if any(j.friction is not None for j in scene.joints):
        found["without friction"] = rebuilt(scene, joint=lambda j: dataclasses.replace(j, friction=None))
    if any(j.film is not None and j.film_torques for j in clearances):
        found["without film torques"] = rebuilt(scene, joint=_without_film_torques)
    if len(clearances) > 1:
        first = clearances[0].name
        found[f"clearance in {first} only"] = rebuilt(scene, joint=lambda j: j if j.name == first else _ideal(j))
    if clearances:
        found["ideal joints"] = idealised(scene)
    return found


def idealised(scene: Scene) -> Scene:
    """The scene with an ideal joint for every one with clearance, and no friction in any joint."""
    return rebuilt(scene, joint=_ideal)


def _without_film_torques(joint: Joint) -> Joint:
    return dataclasses.replace(joint, film_torques=False) if isinstance(joint, ClearanceRevolute) else joint


def _ideal(joint: Joint) -> Joint:
    return joint.ideal() if joint.soft else dataclasses.replace(joint, friction=None)
