"""Ideal motions of many points that differ in lengths: those of run/ideal_motion.py, side by side.

Their loops close by formulas: each place is worked out by itself.
"""

import numpy as np

from clearance.lanes.lane_outputs import LaneOutputs
from clearance.lanes.point_numbers import NotForLanes
from clearance.mechanism.build import build
from clearance.mechanism.numbers import numbers_of
from clearance.results.extremes import guides
from clearance.run.ideal_motion import ideal_motion, moving, rate_of
from clearance.run.run import Run
from clearance.scene.scene import Scene
from clearance.values.columns import Column, values_of

CHANNELS = ("x", "y", "ax", "ay")
SAME = 1e-9  # of the largest value of a motion


class IdealMotions:
    """Ideal motions of scenes like one.

    Raises NotForLanes where places follow from those before.
    """

    def __init__(self, scene: Scene, samples: int):
        self.samples = samples
        described = scene.description()
        self.rate, self.slides = rate_of(described), guides(described)
        self.mechanism = mechanism = build(moving(scene, self.rate), ledger=False)
        if mechanism.layout.work:
            raise NotForLanes("the ideal motion is followed from place to place")
        paths = [f"bodies/{body}/{name}" for body in self.slides for name in CHANNELS]
        self.outputs = LaneOutputs(mechanism, paths)

    def numbers(self, scene: Scene, count: int) -> np.ndarray:
        """Numbers of points from their scene of columns."""
        layout = self.mechanism.layout
        par = np.tile(self.mechanism.par[: len(layout.parameters)], (count, 1)).T
        for name, number in numbers_of(moving(scene, rate_of(scene.description()))):
            if name in layout.parameters and isinstance(number, Column):
                par[layout.parameters[name]] = values_of(number)
        return par

    def along(self, scene: Scene, until: np.ndarray, samples: np.ndarray) -> np.ndarray:
        """Places and accelerations along the guides: (points, numbers, samples); accelerations are
        those at the speed of the first scene.

        scene: of columns; until: lengths of the runs [s]; samples: their numbers. Numbers behind
        the last sample are those there.
        """
        angle = until * values_of(rate_of(scene.description()))
        times = np.minimum(np.arange(self.samples)[:, None] / (samples - 1), 1.0) * angle
        outputs = self.outputs.along(self.numbers(scene, len(until)), times)
        rows = []
        for (dx, dy), (x, y, ax, ay) in zip(
            self.slides.values(), np.split(outputs, len(self.slides)), strict=True
        ):
            rows += [x * dx + y * dy, (ax * dx + ay * dy) * self.rate**2]
        return np.ascontiguousarray(np.moveaxis(rows, -1, 0))

    def compare(self, run: Run, ideal: np.ndarray) -> None:
        """Raises NotForLanes where the ideal motion of a run is not that which lanes have of it.

        ideal: as of `along`.
        """
        described = run.mechanism.scene.description()
        single = ideal_motion(run.mechanism.scene, run.span, described)
        rows = [row for pair in (single or {}).values() for row in pair]
        ideal = ideal[:, : run.span.samples]
        scale = [1.0, (self.rate / rate_of(described)) ** 2] * len(self.slides)
        for row, values, share in zip(rows, ideal, scale, strict=False):
            if not np.allclose(row * share, values, rtol=0.0, atol=SAME * np.abs(values).max()):
                raise NotForLanes("ideal motions do not follow from the parameters")
        if len(rows) < len(ideal):
            raise NotForLanes("a point has no ideal motion")
