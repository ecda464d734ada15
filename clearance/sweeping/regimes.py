"""Regimes of a sweep's joints: the thresholds that all of its points share."""

from collections.abc import Iterator
from contextlib import suppress

import numpy as np

from clearance.scene.catalogue import find_case
from clearance.scene.scene import Scene
from clearance.sweeping.definition import Definition
from clearance.values.spots import THRESHOLDS


def regimes(definition: Definition) -> dict[str, dict[str, float]]:
    """For each joint with a transition its roughness [m] and thresholds [-], by name.

    Numbers that differ between points are absent: scenes at the ends of each swept number are
    compared, and one of each text. Points that cannot be built do not count.
    """
    case, shared = find_case(definition.path), None
    for index in _ends(definition):
        with suppress(ValueError, TypeError):
            numbers = _numbers(case.scene(**definition.values(index)))
            shared = numbers if shared is None else shared & numbers
            if not shared:
                return {}
    joints: dict[str, dict[str, float]] = {}
    for joint, name, value in sorted(shared or ()):
        joints.setdefault(joint, {})[name] = value
    return joints


def _ends(definition: Definition) -> Iterator[int]:
    """Points with the first and last value of each swept number, and with each text."""
    yield 0
    for column in map(np.array, definition.points.columns.values()):
        places = np.unique(column, return_index=True)[1].tolist()
        yield from (places[0], places[-1]) if column.dtype.kind in "if" else places


def _numbers(scene: Scene) -> set[tuple[str, str, float]]:
    """Joint, name and value of the roughness and thresholds of all its transitions."""
    return {
        (joint.name, name, float(value))
        for joint in scene.joints
        if (law := getattr(joint, "transition", None)) is not None
        for name, value in (law.values | {"roughness": joint.roughness}).items()
        if name in (*THRESHOLDS, "roughness") and value is not None
    }
