"""Scenes made from a scene: the same mechanism with other bodies or joints."""

import dataclasses

from clearance.elements import ClearanceRevolute, Revolute
from clearance.elements.element import Element
from clearance.scene import Scene


def reduced(scene: Scene) -> dict[str, Scene]:
    """The scene, and what is left of it when parts are taken out, the smallest last: what each part costs."""
    found = {"as it is": scene}
    clearances = scene.clearance_joints
    if any(j.friction is not None for j in scene.joints):
        found["without friction"] = scene.rebuilt(element=_smooth)
    if any(j.film is not None and j.film_torques for j in clearances):
        found["without film torques"] = scene.rebuilt(element=_without_film_torques)
    if len(clearances) > 1:
        first = clearances[0].name
        found[f"clearance in {first} only"] = scene.rebuilt(element=lambda e: e if e.name == first else _ideal(e))
    if clearances:
        found["ideal joints"] = idealised(scene)
    return found


def idealised(scene: Scene) -> Scene:
    """The scene with an ideal hinge for every clearance joint, and no friction in any joint."""
    return scene.rebuilt(element=_ideal)


def _smooth(element: Element) -> Element:
    rubs = getattr(element, "friction", None) is not None
    return dataclasses.replace(element, friction=None) if rubs else element


def _without_film_torques(element: Element) -> Element:
    return dataclasses.replace(element, film_torques=False) if hasattr(element, "film_torques") else element


def _ideal(element: Element) -> Element:
    if isinstance(element, ClearanceRevolute):  # which carries nothing out of the plane
        return Revolute(element.a, element.b, name=element.name, self_aligning=True)
    return _smooth(element)
