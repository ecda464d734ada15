"""Inverse dynamics by the compiled kernel: group by group, in the order in which the mechanism can
be solved.

The prescribed motion fixes all positions, velocities and accelerations. Each group of the plan (a
single body, a dyad, a larger group) then gives its reactions to the groups before it, down to the
drives. This is the route from subsystem to subsystem of Guo, Ju and Wang, Aerospace 11 (2024) 368,
Algorithm 1, with the group as subsystem.
"""

import time as clock
from collections.abc import Sequence

import numpy as np

from clearance.machine import store
from clearance.mechanism.build import Mechanism, build
from clearance.mechanism.closing import last_position, what_is_lost
from clearance.mechanism.topology import closed_plan
from clearance.scene.scene import Scene
from clearance.stepping.tour import tour
from clearance.stepping.types import KERNEL

#: longest way between two places followed, in rad at the typical frequency
STRETCH = 0.1


class Explicit:
    """A scene whose motion is prescribed, compiled; `rows(time)` gives all channels at any growing
    times.
    """

    def __init__(self, scene: Scene):
        self.scene, self.mechanism = scene, _built(scene)
        self.structure = self.mechanism.structure
        self.channels = self.structure.layout.channels
        roles = ("observe", "commit" if self.structure.layout.commits else "observe")
        self.kernels = [store.address(self.mechanism.kernel(role), KERNEL) for role in roles]
        self.loop_s = 0.0  # time spent in compiled code

    def rows(self, time: Sequence[float]) -> tuple[np.ndarray, str]:
        """Channels (columns) at each time [s] (rows) up to where the motion can be followed, and
        why no further.
        """
        times = np.ascontiguousarray(time, dtype=float)
        m, rows = self.mechanism, np.empty((times.size, len(self.channels)))
        work, began = np.append(m.work0, 0.0), clock.perf_counter()
        commits = self.structure.layout.commits
        done = tour(
            *self.kernels,
            commits,
            times,
            m.y0,
            m.par,
            work,
            STRETCH / m.frequency,
            self._places(),
            m.start.size,
            np.empty((2, rows.shape[1])),
            rows,
        )
        self.loop_s = clock.perf_counter() - began
        return rows[:done], self._why(times, rows, work, done) if done < times.size else ""

    def _places(self) -> np.ndarray:
        """Columns of positions, speeds and accelerations, in turn, of the bodies that close
        loops.
        """
        column = {c.path: i for i, c in enumerate(self.channels)}
        closing = [
            a.body.name for g in self.mechanism.plan.groups if g.closures for a in g.attachments
        ]
        names = [f"bodies/{b}/{n}" for b in closing for x in "xy" for n in (x, "v" + x, "a" + x)]
        return np.array([column[n] for n in names], np.int64)

    def _why(self, times: np.ndarray, rows: np.ndarray, work: np.ndarray, done: int) -> str:
        if np.isfinite(rows[done]).all():
            return (
                f"before t = {times[done]:.9g} s: a loop passes a singular position and jumps "
                "to its other branch"
            )
        if done == 0:
            outputs = dict(zip((c.path for c in self.channels), rows[0], strict=True))
            return (
                f"at t = {times[0]:.9g} s, the first sample: "
                f"{what_is_lost(self.mechanism, outputs)}"
            )
        position = last_position(self.mechanism, work, times[done - 1], times[done])
        if position is None:
            return f"before t = {times[done]:.9g} s: the mechanism can no longer be followed"
        return f"at t = {position[0]:.9g} s: {position[1]}"


def _built(scene: Scene) -> Mechanism:
    """The mechanism of a scene whose entire motion is prescribed.

    Raises ValueError naming what is free.
    """
    for joint in scene.soft_joints:
        reason = "has clearance" if joint.spots() else "is held by forces"
        raise ValueError(f"{joint.label()} {reason}: its motion is not prescribed; use cl.simulate")
    for drive in (d for d in scene.drives if not d.prescribes):
        raise ValueError(
            f"{drive.label()} gives an effort, not a motion; inverse dynamics needs speed= or "
            f"motion="
        )
    if free := closed_plan(scene).free:
        names = ", ".join(f"{c.label()}" for c in free)
        raise ValueError(
            f"no drive prescribes {names}: inverse dynamics needs a motion for every degree of "
            f"freedom"
        )
    mechanism = build(scene, ledger=False)
    if names := mechanism.layout.first_order:
        element = next(e for e in scene.elements if names[0].startswith(f"{e.key}/"))
        law = getattr(element, "friction", None)
        part = element.label() if law is None else f"{element.label()}: friction {law.law.name}"
        raise ValueError(f"{part} has a state that time integrates; use cl.simulate")
    return mechanism
