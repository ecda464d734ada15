"""Relative coordinates of all joints of a scene over absolute coordinates of its bodies, with their
slopes.

The joints' one statement is traced and written as plain Python, once for all scenes of a structure.
"""

import math
from collections.abc import Callable, Sequence

import numpy as np

from clearance.elements.body import ABSOLUTE, Body
from clearance.elements.joint import RELATIVE, TURN
from clearance.mechanism.kinematics import Kinematics, Pose
from clearance.mechanism.loops import offsets, wrong_turn
from clearance.mechanism.numbers import Numbers
from clearance.scene.scene import Scene
from clearance.tracing.emission import function_text
from clearance.tracing.function import Function
from clearance.tracing.trace import live

MOST = 100  # traced statements that a process keeps
_traced: dict[tuple, tuple] = {}


class Geometry:
    """Values and slopes of coordinates at positions q, (x, y, angle) of each body.

    places: (joint, name) of the relative coordinates, known ones less the numbers that joints keep
        them at, then (body, "x"), (body, "y"), (body, "angle"). angles: places of the last in q.
        read: the scene's numbers that they depend on.
    """

    def __init__(self, scene: Scene, values: list[float], traced: tuple):
        relative = [(j, axis) for j in scene.joints for axis in RELATIVE]
        absolute = [(b, axis) for b in scene.bodies for axis in ABSOLUTE]
        self.count, self.size = len(relative), len(absolute)
        self.places = [*relative, *absolute]
        self.place = {coordinate: i for i, coordinate in enumerate(self.places)}
        self.function, self.rows, self.columns, read = traced
        self.values, self.read = values, tuple(values[i] for i in read)
        self.angles = [i for i, (_, axis) in enumerate(absolute) if axis == "angle"]

    def pose(self, body: Body) -> slice:
        """Places of a body's x, y and angle in q."""
        first = self.place[body, ABSOLUTE[0]] - self.count
        return slice(first, first + len(ABSOLUTE))

    @classmethod
    def of(cls, scene: Scene, numbers: Numbers) -> "Geometry":
        """The geometry of a scene; scenes of one structure share its tracing."""
        if numbers.signature not in _traced:
            if len(_traced) >= MOST:
                del _traced[next(iter(_traced))]
            _traced[numbers.signature] = _trace(scene, numbers)
        return cls(scene, numbers.values, _traced[numbers.signature])

    def __call__(self, q: Sequence[float]) -> tuple[list[float], np.ndarray]:
        """Values of all coordinates, and their slopes (coordinates, q)."""
        q = [float(v) for v in q]
        out = self.function((), *q, *self.values)
        slopes = np.zeros((self.count + self.size, self.size))
        slopes[self.rows, self.columns] = out[self.count :]
        slopes[self.count :] = np.eye(self.size)
        return [*out[: self.count], *q], slopes

    def value(self, q: Sequence[float], coordinate: tuple) -> float:
        """Value of one coordinate."""
        return self(q)[0][self.place[coordinate]]


def _trace(scene: Scene, numbers: Numbers) -> tuple[Callable, np.ndarray, np.ndarray, list[int]]:
    """Function of q and the scene's numbers: values, then slopes at the places rows, columns;
    numbers that it reads.
    """
    function = Function("geometry")
    q = {body: [function.argument() for _ in ABSOLUTE] for body in scene.bodies}
    free = {name: function.argument() for name in numbers.index}
    parameters = numbers.constants | free
    trace = function.trace
    k = Kinematics(trace, parameters.__getitem__, {}, {})
    k.poses |= {
        body: Pose(x, y, trace.cos(angle), trace.sin(angle), angle)
        for body, (x, y, angle) in q.items()
    }
    values = [v for joint in scene.joints for v in _relative(k, joint)]
    if not values:
        return lambda par, *numbers: (), *np.zeros((2, 0), dtype=int), []
    leaves = [leaf for pose in q.values() for leaf in pose]
    slopes = trace.tangent(values, {leaf: {i: 1.0} for i, leaf in enumerate(leaves)})
    places = [(i, j) for i, slope in enumerate(slopes) for j in slope]
    function.outputs = [*values, *(slopes[i][j] for i, j in places)]
    scope: dict = {"math": math}
    exec(function_text(function), scope)  # noqa: S102
    rows, columns = np.array(places, dtype=int).reshape(-1, 2).T
    alive = set(live(function.outputs))
    return (
        scope[function.name],
        rows,
        columns,
        [i for i, leaf in enumerate(free.values()) if leaf in alive],
    )


def _relative(k: Kinematics, joint) -> list:
    """Along, across and turn of a joint; a turn that it keeps is in (-pi, pi]."""
    along, across = offsets(k, joint)
    if TURN in joint.free:
        return [along, across, k.poses[joint.b.body].angle - k.poses[joint.a.body].angle]
    return [along, across, k.trace.atan2(*wrong_turn(k, joint))]
