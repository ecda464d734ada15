"""Scenes made from a scene: the same mechanism with other bodies or joints."""

import dataclasses

from clearance.elements.element import Element
from clearance.elements.joint import Joint
from clearance.scene.scene import Scene


def reduced(scene: Scene) -> dict[str, Scene]:
    """The scene, and what is left of it when parts are taken out, the smallest last: what each part
    costs.
    """
    scenes = {"as it is": scene}
    clearances = scene.clearance_joints
    if any(j.friction is not None for j in scene.joints):
        scenes["without friction"] = scene.rebuilt(element=_smooth)
    if any(j.film is not None and j.film_torques for j in clearances):
        scenes["without film torques"] = scene.rebuilt(element=_without_film_torques)
    if len(clearances) > 1:
        first = clearances[0].name
        scenes[f"clearance in {first} only"] = scene.rebuilt(
            element=lambda e: e if e.name == first else _ideal(e)
        )
    if clearances:
        scenes["ideal joints"] = idealised(scene)
    return scenes


def idealised(scene: Scene) -> Scene:
    """The scene with an ideal joint for every one with clearance, and no friction in any joint."""
    return scene.rebuilt(element=_ideal)


def _smooth(element: Element) -> Element:
    rubs = getattr(element, "friction", None) is not None
    return dataclasses.replace(element, friction=None) if rubs else element


def _without_film_torques(element: Element) -> Element:
    return (
        dataclasses.replace(element, film_torques=False)
        if hasattr(element, "film_torques")
        else element
    )


def _ideal(element: Element) -> Element:
    return element.ideal() if isinstance(element, Joint) and element.soft else _smooth(element)
