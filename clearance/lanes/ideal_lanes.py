"""Ideal motions of many points that differ in lengths: those of run/ideal_motion.py, side by side.

Their loops close by formulas: each place is worked out by itself.
"""

import numpy as np

from clearance.lanes import lane_kernels
from clearance.lanes.code import Code, callable_at, natural_width, new_module
from clearance.lanes.engine import SOURCES
from clearance.lanes.group import with_derived
from clearance.lanes.point_numbers import NotForLanes
from clearance.mechanism.build import build
from clearance.mechanism.numbers import numbers_of
from clearance.results.extremes import guides
from clearance.run.ideal_motion import ideal_motion, moving, rate_of
from clearance.run.run import Run
from clearance.scene.scene import Scene
from clearance.tracing.emission import kernel_text
from clearance.values.columns import Column, values_of

CHANNELS = ("x", "y", "ax", "ay")
SAME = 1e-9  # of the largest value of a motion
PADDED = 8  # numbers behind the tables, which kernels may read along


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
        column = {c.path: i for i, c in enumerate(mechanism.layout.channels)}
        self.count = len(CHANNELS) * len(self.slides)
        paths = (f"bodies/{body}/{name}" for body in self.slides for name in CHANNELS)
        places = {i: column[path] for i, path in enumerate(paths)}
        program = lane_kernels.narrowed(mechanism.structure.programs["observe"], places)

        def module():
            module = new_module()
            lane_kernels.write(module, "motion", program, self.width)
            return module

        self.width = natural_width()
        self.code = Code(module, f"{self.width} {kernel_text(program, {})} {SOURCES}")
        self.call = callable_at(self.code.address("motion"), len(lane_kernels.ARRAYS))

    def numbers(self, scene: Scene, count: int) -> np.ndarray:
        """Numbers of points from their scene of columns."""
        layout = self.mechanism.layout
        par = np.tile(self.mechanism.par[: len(layout.parameters)], (count, 1)).T
        for name, number in numbers_of(moving(scene, rate_of(scene.description()))):
            if name in layout.parameters and isinstance(number, Column):
                par[layout.parameters[name]] = values_of(number)
        return par

    def along(self, scene: Scene, until: np.ndarray) -> np.ndarray:
        """Places and accelerations along the guides: (points, numbers, samples); accelerations are
        those at the speed of the first scene.

        scene: of columns; until: lengths of the runs [s].
        """
        width, count = self.width, len(until)
        mechanism, padded = self.mechanism, np.arange(-(-count // self.width) * self.width) % count
        par = with_derived(mechanism, self.numbers(scene, count))[:, padded]
        angle = np.broadcast_to(until * values_of(rate_of(scene.description())), count)[padded]
        data, empty = np.append(mechanism.par, np.zeros(PADDED)), np.zeros((1, width))
        out = np.zeros((len(padded), self.samples, self.count))
        for first in range(0, len(padded), width):
            lanes = slice(first, first + width)
            out[lanes] = self._block(par[:, lanes], angle[lanes], data, empty)
        pairs = zip(self.slides.values(), np.split(out[:count], len(self.slides), -1), strict=True)
        rows = []
        for (dx, dy), (x, y, ax, ay) in ((d, np.moveaxis(v, -1, 0)) for d, v in pairs):
            rows += [x * dx + y * dy, (ax * dx + ay * dy) * self.rate**2]
        return np.ascontiguousarray(np.stack(rows, axis=1))

    def compare(self, run: Run, given: np.ndarray) -> None:
        """Raises NotForLanes where the ideal motion of a run is not that which lanes have of it.

        given: as of `along`.
        """
        described = run.mechanism.scene.description()
        single = ideal_motion(run.mechanism.scene, run.span, described)
        rows = [row for pair in (single or {}).values() for row in pair]
        scale = [1.0, (self.rate / rate_of(described)) ** 2] * len(self.slides)
        for row, values, share in zip(rows, given, scale, strict=False):
            if not np.allclose(row * share, values, rtol=0.0, atol=SAME * np.abs(values).max()):
                raise NotForLanes("ideal motions do not follow from the parameters")
        if len(rows) < len(given):
            raise NotForLanes("a point has no ideal motion")

    def _block(self, par: np.ndarray, angle: np.ndarray, data: np.ndarray, empty: np.ndarray):
        """Outputs of as many points as there are lanes: (points, samples, outputs)."""
        shares = np.arange(self.samples) / (self.samples - 1)
        time = np.ascontiguousarray(shares[:, None] * angle)
        out = np.zeros((self.samples, self.count, self.width))
        par = np.ascontiguousarray(par)
        fixed = [a.ctypes.data for a in (empty, par, empty)]
        begin, into, table = time.ctypes.data, out.ctypes.data, data.ctypes.data
        for k in range(self.samples):
            self.call(begin + k * time.strides[0], *fixed, into + k * out.strides[0], table)
        return np.moveaxis(out, -1, 0)
